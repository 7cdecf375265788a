/* hebra modes: natural frequencies and modes about an equilibrium. */
#include "base/clock.h"
#include "base/memory.h"
#include "cli/modal_picture.h"
#include "output/file.h"
#include "output/modal.h"

#include <getopt.h>
#include <stdio.h>
#include <string.h>

/* Modes that can be asked for; frames of a film, the last one like the first. */
enum { MOST = 100000, FRAMES = 48 };
#define TURN 6.283185307179586

/* The arguments, and what was found. */
typedef struct study {
  cli_solution s;
  int count;
  double part; /* largest displacement in pictures and films, as a part of the rod's extent; 0: not given */
  double *amplitude; /* the same per mode, as a length */
  bool films, pictures, matrices;
  hb_modes modes;
  double seconds;
} study;

/* Parses argv; an exit status, or -1 to go on. */
static int parse(int argc, char **argv, study *y) {
  static const struct option longs[] = {CLI_SOLUTION_OPTIONS,
                                        {"count", required_argument, NULL, 'n'},
                                        {"amplitude", required_argument, NULL, 'A'},
                                        {"films", no_argument, NULL, 'F'},
                                        {"pictures", no_argument, NULL, 'P'},
                                        {"matrices", no_argument, NULL, 'M'},
                                        {NULL, 0, NULL, 0}};
  memset(y, 0, sizeof *y);
  cli_solution_begin(&y->s, &cli_verb_modes);
  y->count = 10;
  for (int c; (c = getopt_long(argc, argv, ":o:qn:", longs, NULL)) != -1;) {
    int result = -1;
    switch (c) {
    case 'F': y->films = true; break;
    case 'P': y->pictures = true; break;
    case 'M': y->matrices = true; break;
    case 'n':
      if (!cli_whole(optarg, MOST, &y->count))
        result = cli_usage(&cli_verb_modes, "--count \"%s\" is not a whole number from 1 to 100000", optarg);
      break;
    case 'A':
      if (!cli_number(optarg, 1e-9, &y->part) || y->part > 1)
        result =
            cli_usage(&cli_verb_modes, "--amplitude \"%s\" is not a number above 1e-9 and up to 1", optarg);
      break;
    default: result = cli_solution_option(&y->s, c, optarg, argv);
    }
    if (result >= 0) return result;
  }
  return cli_solution_scene(&y->s, argc, argv);
}

/* DIRECTORY/NAME; a directory's name fits with room to spare. */
static void name_file(const study *y, const char *name, char path[PATH_MAX + 32]) {
  snprintf(path, PATH_MAX + 32, "%s/%s", y->s.directory, name);
}

/* One period of one mode. */
static hb_status write_film(study *y, int k, hb_error *err) {
  const hb_mode *mode = &y->modes.mode[k];
  char path[PATH_MAX + 32], name[32];
  hb_writer *writer = NULL;
  snprintf(name, sizeof name, "mode-%d.h5", k + 1);
  name_file(y, name, path);
  hb_status status = hb_writer_create(path, y->s.model, FRAMES + 1, &writer, err);
  for (int n = 0; !status && n <= FRAMES; n++) {
    status =
        hb_sim_measure_mode(y->s.sim, &y->s.found, mode, y->amplitude[k], TURN * n / FRAMES, y->s.frame, err);
    y->s.frame->step = n;
    if (!status) status = hb_writer_add(writer, y->s.frame, err);
  }
  hb_status closing = hb_writer_close(writer, status ? NULL : err);
  return status ? status : closing;
}

/* What is asked for beside the tables. */
static hb_status write_more(study *y, hb_error *err) {
  char path[PATH_MAX + 32];
  hb_status status = HB_OK;
  if (y->matrices) {
    hb_matrices matrices;
    status = hb_sim_find_matrices(y->s.sim, &y->s.found, &matrices, err);
    if (!status) status = hb_modal_matrices(y->s.directory, y->s.model, &matrices, err);
    hb_matrices_free(&matrices);
  }
  name_file(y, "modes.png", path);
  if (!status && y->pictures) status = cli_modal_picture(&y->s, &y->modes, y->amplitude, path, err);
  for (int k = 0; !status && y->films && k < y->modes.count; k++) status = write_film(y, k, err);
  hb_sim_measure_equilibrium(y->s.sim, &y->s.found, y->s.frame); /* the frame as it was */
  return status;
}

/* Everything into the directory. The report comes last: it says that all is there. */
static hb_status write_results(study *y, hb_error *err) {
  cli_solution *s = &y->s;
  char path[PATH_MAX + 32];
  hb_status status = hb_file_directory(s->directory, err);
  name_file(y, "equilibrium.h5", path);
  if (!status) status = cli_solution_write(s, path, err);
  name_file(y, "modes.csv", path);
  if (!status) status = hb_modal_table(path, s->model, &y->modes, err);
  name_file(y, "shapes.csv", path);
  if (!status) status = hb_modal_shapes(path, s->model, s->frame->position, &y->modes, err);
  if (!status) status = write_more(y, err);
  name_file(y, "modes.json", path);
  if (!status) status = hb_modal_report(path, s->model, &s->found, &y->modes, y->seconds, err);
  return status;
}

/* How far the modes are shown displaced. */
static hb_status find_amplitudes(study *y, hb_error *err) {
  y->amplitude = hb_alloc((size_t)y->modes.count + 1, sizeof *y->amplitude);
  if (!y->amplitude) return hb_fail_memory(err, "amplitudes");
  if (!y->films && !y->pictures) return HB_OK;
  hb_status status =
      cli_modal_amplitudes(&y->s, &y->modes, y->part > 0 ? y->part : 0.1, y->part > 0, y->amplitude, err);
  hb_sim_measure_equilibrium(y->s.sim, &y->s.found, y->s.frame); /* the frame as it was */
  return status;
}

/* The table on standard output. */
static void print_table(const study *y) {
  printf("%5s  %-12s %-10s %16s %16s %16s\n", "mode", "rod", "kind", "omega", "frequency", "period");
  for (int k = 0; k < y->modes.count; k++) {
    const hb_mode *mode = &y->modes.mode[k];
    double omega = hb_mode_omega(mode);
    printf("%5d  %-12s %-10s", k + 1, y->s.model->rods[mode->rod].name, hb_modal_kind(mode));
    if (hb_mode_kind(mode) > 0)
      printf(" %16.9g %16.9g %16.9g\n", omega, omega / TURN, TURN / omega);
    else if (hb_mode_kind(mode) < 0)
      printf("  grows like exp(%.9g t)\n", omega);
    else
      printf(" %16d\n", 0);
  }
}

/* What a person wants to know beside it. */
static void say(const study *y) {
  const hb_modes *m = &y->modes;
  cli_solution_say(&y->s);
  fprintf(stderr, "the %d lowest of %ld modes, none missed: %d solves, %d factorisations, %.3g s\n", m->count,
          m->freedom, m->solves, m->factorisations, y->seconds);
  if (m->unstable > 0)
    fprintf(stderr, "%d mode%s leave%s the equilibrium\n", m->unstable, m->unstable > 1 ? "s" : "",
            m->unstable > 1 ? "" : "s");
  fprintf(stderr, "tables in %s: modes.json, modes.csv, shapes.csv%s%s%s\n", y->s.directory,
          y->matrices ? ", M.mtx, K.mtx, G.mtx" : "", y->pictures ? ", modes.png" : "",
          y->films ? ", mode-1.h5 ..." : "");
}

/* The verb. */
static int run_verb(int argc, char **argv) {
  study y;
  hb_error err = {HB_OK, ""};
  int result = parse(argc, argv, &y);
  if (result >= 0) return result;
  hb_status status = cli_solution_find(&y.s, "-modes", &err);
  double started = hb_clock_now();
  if (!status) status = hb_sim_find_modes(y.s.sim, &y.s.found, y.count, &y.modes, &err);
  y.seconds = hb_clock_now() - started;
  if (!status) status = find_amplitudes(&y, &err);
  if (!status) status = write_results(&y, &err);
  if (!status && !y.s.quiet) {
    say(&y);
    if (!y.s.json) print_table(&y);
  }
  if (!status && y.s.json) {
    char path[PATH_MAX + 32];
    name_file(&y, "modes.json", path);
    cli_print_file(path);
  }
  result = status ? cli_fail("modes", &err) : CLI_DONE;
  hb_free(y.amplitude);
  hb_modes_free(&y.modes);
  cli_solution_end(&y.s);
  return result;
}

const cli_verb cli_verb_modes = {
    "modes", "natural frequencies and modes about an equilibrium",
    "usage: hebra modes SCENE [-n N] [-o DIR] [--set KEY=VALUE ...] [--films] [--pictures] [--matrices]\n"
    "                   [--amplitude X] [--time T] [--load-steps N] [--from FILE[:FRAME]] [--any]\n"
    "                   [--tolerance X] [--max-iterations N] [--quiet] [--json]\n"
    "\n"
    "Looks for the equilibrium as hebra solve does, then for the slowest small vibrations about it, proves "
    "that "
    "none\n"
    "was missed, and prints them. Unstable equilibria (--any) have modes that grow. Leaves in DIR (default: "
    "out/NAME-modes,\n"
    "NAME that of the scene)\n"
    "  modes.json, modes.csv   the figures: omega, frequency, period, kind, resolution\n"
    "  shapes.csv              shapes: displacement of every vertex, turn of every frame, modal mass 1\n"
    "  equilibrium.h5          the equilibrium, as a trajectory of one frame\n"
    "\n"
    "  -n, --count N         how many modes (default 10); all, if there are fewer\n"
    "  --pictures            also modes.png: a panel for each mode (24 at most), the rod at rest and to both "
    "sides\n"
    "  --films               also mode-1.h5 ...: one period of each mode as a trajectory for hebra render\n"
    "  --matrices            also M.mtx, K.mtx, G.mtx (Matrix Market) and unknowns.csv, which names their "
    "rows\n"
    "  --amplitude X         largest displacement in pictures and films, as a part of the rod's extent "
    "(default 0.1, or as\n"
    "                        far as the lengths can be kept)\n"
    "  -o, --output DIR      where the results go\n"
    "  --set KEY=VALUE       change or add a key of the scene (may be given up to 64 times)\n"
    "  --time, --load-steps, --from, --any, --tolerance, --max-iterations\n"
    "                        of the equilibrium: as of hebra solve\n"
    "  -q, --quiet           say nothing\n"
    "  --json                print modes.json to standard output instead of the table\n"
    "\n"
    "example: hebra modes scenes/modes/telephone-cord.yaml -n 6 --pictures -o out/coil\n",
    run_verb};
