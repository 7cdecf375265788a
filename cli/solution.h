/* What the verbs share that begin with an equilibrium: their arguments, the search. */
#ifndef HB_CLI_SOLUTION_H
#define HB_CLI_SOLUTION_H

#include "cli/cli.h"

#include <limits.h>

/* Arguments, and everything that a solution owns. */
typedef struct cli_solution {
  const cli_verb *verb;
  const char *scene, *output, *from;
  cli_overrides set;
  double time, tolerance; /* negative: not given */
  int load_steps, iterations;
  bool any, quiet, json;
  char directory[PATH_MAX]; /* where the results go */
  hb_scene_def def;
  hb_model *model;
  hb_sim *sim;
  hb_frame *frame; /* measured at the equilibrium */
  hb_equilibrium found;
  double seconds; /* of the search */
} cli_solution;

/* The options for getopt_long, with their letters; short options ":o:q". */
#define CLI_SOLUTION_OPTIONS                                                                                 \
  {"output", required_argument, NULL, 'o'}, {"set", required_argument, NULL, 's'},                           \
      {"time", required_argument, NULL, 't'}, {"load-steps", required_argument, NULL, 'l'},                  \
      {"max-iterations", required_argument, NULL, 'm'}, {"tolerance", required_argument, NULL, 'T'},         \
      {"from", required_argument, NULL, 'f'}, {"any", no_argument, NULL, 'a'},                               \
      {"quiet", no_argument, NULL, 'q'}, {                                                                   \
    "json", no_argument, NULL, 'j'                                                                           \
  }

/* Defaults. */
void cli_solution_begin(cli_solution *s, const cli_verb *verb);
/* One option, or what getopt says is wrong; an exit status, or -1 to go on. */
int cli_solution_option(cli_solution *s, int c, const char *value, char **argv);
/* The scene, the only argument after the options; an exit status, or -1 to go on. */
int cli_solution_scene(cli_solution *s, int argc, char **argv);
/* Reads the scene and looks for its equilibrium. suffix: of the directory of results, see cli_directory. */
hb_status cli_solution_find(cli_solution *s, const char *suffix, hb_error *err);
/* Prints what was found, in short, to standard error. */
void cli_solution_say(const cli_solution *s);
/* Writes the equilibrium as a trajectory of one frame. */
hb_status cli_solution_write(const cli_solution *s, const char *path, hb_error *err);
void cli_solution_end(cli_solution *s);

#endif
