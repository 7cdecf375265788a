/* The command line: one verb per file. */
#ifndef HB_CLI_H
#define HB_CLI_H

#include "hebra/hebra.h"

/* Exit statuses of every verb. */
enum { CLI_DONE = 0, CLI_FAILED = 1, CLI_BAD_INPUT = 2 };

/* One verb: argv[0] is the verb's name. Returns an exit status. */
typedef struct cli_verb {
  const char *name;
  const char *summary; /* one line for `hebra --help` */
  const char *help;    /* whole text of `hebra VERB --help`, with an example */
  int (*run)(int argc, char **argv);
} cli_verb;

extern const cli_verb cli_verb_run, cli_verb_check, cli_verb_info, cli_verb_export, cli_verb_render,
    cli_verb_plot, cli_verb_bench, cli_verb_solve, cli_verb_validate;

/* Prints "hebra VERB: sentence" to stderr and gives the exit status for the error: 2 for input, 1 otherwise.
 */
int cli_fail(const char *verb, const hb_error *err);
/* The same for a mistake in the arguments: prints the sentence and how to get help; returns CLI_BAD_INPUT. */
int cli_usage(const cli_verb *verb, const char *format, ...) HB_PRINTF(2, 3);

/* How rods are stepped, from the environment: HEBRA_ISA=portable keeps to what every processor has,
 * HEBRA_ISA=scalar takes vertex by vertex; anything else, or nothing, is the fastest. */
hb_lane_choice cli_lanes(void);

#endif
