/* What the verbs share that draw pictures. */
#include "cli/picture.h"

#include <errno.h>
#include <getopt.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Compares the ends. */
bool cli_ends_with(const char *name, const char *end) {
  size_t n = strlen(name), m = strlen(end);
  return n > m && strcmp(name + n - m, end) == 0;
}

/* Two whole numbers with an x between them. */
bool cli_read_size(const char *text, const int least[2], int *width, int *height) {
  char *end = NULL;
  long w = strtol(text, &end, 10);
  if (end == text || *end != 'x') return false;
  const char *rest = end + 1;
  long h = strtol(rest, &end, 10);
  if (end == rest || *end || w < least[0] || h < least[1] || w > 8192 || h > 8192) return false;
  *width = (int)w;
  *height = (int)h;
  return true;
}

/* Where getopt stopped there must be one more argument. */
int cli_read_trajectory(const cli_verb *verb, int argc, char **argv, const char **path) {
  if (optind != argc - 1)
    return cli_usage(verb, "%s", optind < argc ? "one trajectory at a time" : "which trajectory?");
  *path = argv[optind];
  return -1;
}

/* Opens and closes it. */
hb_status cli_try_file(const char *file, const char *name, const char *what, hb_error *err) {
  FILE *f = fopen(file, "wb");
  if (!f) return hb_fail(err, HB_ERR_IO, "%s: the %s cannot be written: %s", name, what, strerror(errno));
  fclose(f);
  return HB_OK;
}
