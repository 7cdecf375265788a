/* The command line: one verb per file. */
#ifndef HB_CLI_H
#define HB_CLI_H

#include "hebra/hebra.h"

#include <stddef.h>

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
    cli_verb_plot, cli_verb_bench, cli_verb_solve, cli_verb_trace, cli_verb_modes, cli_verb_validate;

/* Prints "hebra VERB: sentence" to stderr and gives the exit status for the error: 2 for input, 1 otherwise.
 */
int cli_fail(const char *verb, const hb_error *err);
/* The same for a mistake in the arguments: prints the sentence and how to get help; returns CLI_BAD_INPUT. */
int cli_usage(const cli_verb *verb, const char *format, ...) HB_PRINTF(2, 3);

/* ---- arguments.c: what several verbs read in the same way */

/* Keys of a scene that --set changes. */
typedef struct cli_overrides {
  const char *items[64];
  int count;
} cli_overrides;

/* One more; an exit status, or -1 to go on. */
int cli_override(const cli_verb *verb, cli_overrides *overrides, const char *text);
/* A finite number from `least` on; false if the text is none. */
bool cli_number(const char *text, double least, double *out);
/* A whole number from 1 to `most`; false if the text is none. */
bool cli_whole(const char *text, int most, int *out);
/* Directory of results: as asked for, or out/NAME after the scene file with what tells the verb, so that
 * results of one verb never take the place of another's. HB_ERR_INPUT: no name, or longer than size. */
hb_status cli_directory(const char *asked, const char *scene, const char *suffix, char *path, size_t size,
                        hb_error *err);
/* Prints a file to standard output. */
void cli_print_file(const char *path);

/* How rods are stepped, from the environment: HEBRA_ISA=portable keeps to what every processor has,
 * HEBRA_ISA=scalar takes vertex by vertex; anything else, or nothing, is the fastest. */
hb_lane_choice cli_lanes(void);

#endif
