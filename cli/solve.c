/* hebra solve: the equilibrium of a scene, without marching in time. */
#include "cli/solution.h"
#include "output/file.h"
#include "output/report.h"

#include <getopt.h>
#include <stdio.h>
#include <string.h>

/* Parses argv; an exit status, or -1 to go on. */
static int parse(int argc, char **argv, cli_solution *s) {
  static const struct option longs[] = {CLI_SOLUTION_OPTIONS, {NULL, 0, NULL, 0}};
  cli_solution_begin(s, &cli_verb_solve);
  for (int c; (c = getopt_long(argc, argv, ":o:q", longs, NULL)) != -1;) {
    int result = cli_solution_option(s, c, optarg, argv);
    if (result >= 0) return result;
  }
  return cli_solution_scene(s, argc, argv);
}

/* Trajectory of one frame, report. */
static hb_status write_results(const cli_solution *s, const char *trajectory, const char *report,
                               hb_error *err) {
  hb_status status = hb_file_directory(s->directory, err);
  if (!status) status = cli_solution_write(s, trajectory, err);
  return status ? status : hb_report_equilibrium(report, s->model, s->frame, &s->found, s->seconds, err);
}

/* The verb. */
static int run_verb(int argc, char **argv) {
  cli_solution s;
  hb_error err = {HB_OK, ""};
  char trajectory[PATH_MAX + 32], report[PATH_MAX + 32];
  int result = parse(argc, argv, &s);
  if (result >= 0) return result;
  hb_status status = cli_solution_find(&s, "-equilibrium", &err);
  snprintf(trajectory, sizeof trajectory, "%s/trajectory.h5", s.directory);
  snprintf(report, sizeof report, "%s/report.json", s.directory);
  if (!status) status = write_results(&s, trajectory, report, &err);
  if (!status && !s.quiet) {
    cli_solution_say(&s);
    fprintf(stderr, "shape in %s, figures in %s\n", trajectory, report);
  }
  if (!status && s.json) cli_print_file(report);
  result = status ? cli_fail("solve", &err) : CLI_DONE;
  cli_solution_end(&s);
  return result;
}

const cli_verb cli_verb_solve = {
    "solve", "find the equilibrium of a scene, without marching in time",
    "usage: hebra solve SCENE [-o DIR] [--set KEY=VALUE ...] [--time T] [--load-steps N] [--from "
    "FILE[:FRAME]]\n"
    "                   [--any] [--tolerance X] [--max-iterations N] [--quiet] [--json]\n"
    "\n"
    "Looks for the shape in which loads, supports and elasticity balance, from the initial shape of the "
    "scene on.\n"
    "Loads and supports are those of the time T (default: the end of the scene). Leaves in DIR\n"
    "(default: out/NAME-equilibrium, NAME that of the scene)\n"
    "  trajectory.h5    the shape, as a trajectory of one frame for hebra render, plot, export\n"
    "  report.json      stability, iterations, unbalanced force, tensions, reactions of the supports, "
    "energies\n"
    "\n"
    "  -o, --output DIR      where the results go\n"
    "  --set KEY=VALUE       change or add a key of the scene (may be given up to 64 times)\n"
    "  --time T              time at which loads and supports are taken\n"
    "  --load-steps N        go through N equilibria from time 0 to T, each starting from the one before "
    "(default 1)\n"
    "  --from FILE[:FRAME]   start from a frame of a trajectory of this scene (default the last; -1, -2 ... "
    "count from the\n"
    "                        end) instead of from the initial shape\n"
    "  --any                 accept an unstable equilibrium; without it the search goes on downhill until it "
    "is stable\n"
    "  --tolerance X         unbalanced force allowed, relative to tensions and loads (default 1e-10)\n"
    "  --max-iterations N    Newton iterations per load step before giving up (default 200)\n"
    "  -q, --quiet           say nothing\n"
    "  --json                print report.json to standard output\n"
    "\n"
    "example: hebra solve scenes/statics/cantilever.yaml -o out/cantilever --set parameters.P=3\n",
    run_verb};
