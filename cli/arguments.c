/* What several verbs read in the same way: keys to change, numbers, where results go. */
#include "cli/cli.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* --set. */
int cli_override(const cli_verb *verb, cli_overrides *overrides, const char *text) {
  const int most = sizeof overrides->items / sizeof overrides->items[0];
  if (overrides->count == most) return cli_usage(verb, "more than %d --set are too many", most);
  overrides->items[overrides->count++] = text;
  return -1;
}

/* A number in an argument. */
bool cli_number(const char *text, double least, double *out) {
  char *end;
  *out = strtod(text, &end);
  return !*end && end != text && *out >= least && *out < HUGE_VAL;
}

/* A whole number in an argument. */
bool cli_whole(const char *text, int most, int *out) {
  char *end;
  long value = strspn(text, "0123456789") > 0 ? strtol(text, &end, 10) : 0;
  *out = value >= 1 && value <= most ? (int)value : 0;
  return *out > 0 && !*end;
}

/* As asked for, or out/NAME and the suffix. */
hb_status cli_directory(const char *asked, const char *scene, const char *suffix, char *path, size_t size,
                        hb_error *err) {
  const char *slash = strrchr(scene, '/'), *name = slash ? slash + 1 : scene, *dot = strrchr(name, '.');
  int stem = dot && dot > name ? (int)(dot - name) : (int)strlen(name);
  int length =
      asked ? snprintf(path, size, "%s", asked) : snprintf(path, size, "out/%.*s%s", stem, name, suffix);
  if (length >= (int)size || length < 1)
    return hb_fail(err, HB_ERR_INPUT, "the name of the output directory is empty or too long");
  return HB_OK;
}

/* A report on standard output. */
void cli_print_file(const char *path) {
  char buffer[4096];
  FILE *file = fopen(path, "rb");
  if (!file) return;
  for (size_t n; (n = fread(buffer, 1, sizeof buffer, file)) > 0;) fwrite(buffer, 1, n, stdout);
  fclose(file);
}
