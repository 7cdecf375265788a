/* What all verbs share: saying what went wrong. */
#include "cli/cli.h"

#include <stdarg.h>
#include <stdio.h>

/* Prints the sentence of an error. */
int cli_fail(const char *verb, const hb_error *err) {
  fprintf(stderr, "hebra %s: %s\n", verb, err->text);
  return err->status == HB_ERR_INPUT ? CLI_BAD_INPUT : CLI_FAILED;
}

/* Prints what is wrong with the arguments and where help is. */
int cli_usage(const cli_verb *verb, const char *format, ...) {
  fprintf(stderr, "hebra %s: ", verb->name);
  va_list args;
  va_start(args, format);
  vfprintf(stderr, format, args);
  va_end(args);
  fprintf(stderr, "\nhebra %s --help explains its arguments.\n", verb->name);
  return CLI_BAD_INPUT;
}
