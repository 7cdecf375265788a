/* hebra solve: the equilibrium of a scene, without marching in time. */
#include "base/clock.h"
#include "base/memory.h"
#include "cli/cli.h"
#include "output/file.h"
#include "output/report.h"

#include <getopt.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Load steps, or iterations, that can be asked for. */
enum { MOST = 1000000 };

/* The arguments. */
typedef struct options {
  const char *scene, *directory, *from;
  cli_overrides set;
  double time, tolerance; /* negative: not given */
  int load_steps, iterations;
  bool any, quiet, json;
} options;

/* Everything that a solution owns. */
typedef struct solution {
  options opt;
  char directory[PATH_MAX], trajectory[PATH_MAX + 32], report[PATH_MAX + 32];
  hb_scene_def def;
  hb_model *model;
  hb_sim *sim;
  hb_frame *frame;
  hb_equilibrium found;
  double seconds;
} solution;

/* One option with a value; an exit status, or -1 to go on. */
static int take(options *opt, int c, const char *value) {
  switch (c) {
  case 's': return cli_override(&cli_verb_solve, &opt->set, value);
  case 't':
    return cli_number(value, 0, &opt->time)
               ? -1
               : cli_usage(&cli_verb_solve, "--time \"%s\" is not a time from 0 on", value);
  case 'T':
    return cli_number(value, 1e-15, &opt->tolerance)
               ? -1
               : cli_usage(&cli_verb_solve, "--tolerance \"%s\" is not a number above 1e-15", value);
  case 'l':
    return cli_whole(value, MOST, &opt->load_steps)
               ? -1
               : cli_usage(&cli_verb_solve, "--load-steps \"%s\" is not a whole number from 1 to 1000000",
                           value);
  default:
    return cli_whole(value, MOST, &opt->iterations)
               ? -1
               : cli_usage(&cli_verb_solve, "--max-iterations \"%s\" is not a whole number from 1 to 1000000",
                           value);
  }
}

/* Parses argv; an exit status, or -1 to go on. */
static int parse(int argc, char **argv, options *opt) {
  static const struct option longs[] = {{"output", required_argument, NULL, 'o'},
                                        {"set", required_argument, NULL, 's'},
                                        {"time", required_argument, NULL, 't'},
                                        {"load-steps", required_argument, NULL, 'l'},
                                        {"max-iterations", required_argument, NULL, 'm'},
                                        {"tolerance", required_argument, NULL, 'T'},
                                        {"from", required_argument, NULL, 'f'},
                                        {"any", no_argument, NULL, 'a'},
                                        {"quiet", no_argument, NULL, 'q'},
                                        {"json", no_argument, NULL, 'j'},
                                        {NULL, 0, NULL, 0}};
  int result = -1;
  *opt = (options){.time = -1, .tolerance = -1, .load_steps = 1};
  opterr = 0;
  optind = 1;
  for (int c; result < 0 && (c = getopt_long(argc, argv, ":o:q", longs, NULL)) != -1;) {
    switch (c) {
    case 'o': opt->directory = optarg; break;
    case 'f': opt->from = optarg; break;
    case 'a': opt->any = true; break;
    case 'q': opt->quiet = true; break;
    case 'j': opt->json = true; break;
    case ':': return cli_usage(&cli_verb_solve, "%s needs a value", argv[optind - 1]);
    case '?': return cli_usage(&cli_verb_solve, "%s is not an option", argv[optind - 1]);
    default: result = take(opt, c, optarg);
    }
  }
  if (result >= 0) return result;
  if (optind == argc) return cli_usage(&cli_verb_solve, "the scene file is missing");
  opt->scene = argv[optind++];
  if (optind < argc)
    return cli_usage(&cli_verb_solve, "\"%s\": only one scene can be solved at a time", argv[optind]);
  return -1;
}

/* Directory of results, and the files in it. */
static hb_status choose_directory(solution *r, hb_error *err) {
  hb_status status =
      cli_directory(r->opt.directory, r->opt.scene, "-equilibrium", r->directory, sizeof r->directory, err);
  if (status) return status;
  snprintf(r->trajectory, sizeof r->trajectory, "%s/trajectory.h5", r->directory);
  snprintf(r->report, sizeof r->report, "%s/report.json", r->directory);
  return HB_OK;
}

/* Reads one frame of a trajectory of the same rods; the last, or the one after a colon: FILE:FRAME. */
static hb_status read_moment(solution *r, hb_error *err) {
  static const char *const names[] = {"position", "m1", "twist", "bishop_u", "theta"};
  double *const fields[] = {r->frame->position, r->frame->m1, r->frame->twist, r->frame->bishop_u,
                            r->frame->theta};
  char path[PATH_MAX];
  const char *colon = strrchr(r->opt.from, ':');
  char *end = NULL;
  long index = colon ? strtol(colon + 1, &end, 10) : -1;
  bool chosen = colon && end != colon + 1 && !*end;
  hb_reader *reader = NULL;
  snprintf(path, sizeof path, "%.*s", chosen ? (int)(colon - r->opt.from) : PATH_MAX - 1, r->opt.from);
  hb_status status = hb_reader_open(path, &reader, err);
  if (status) return status;
  const hb_trajectory_info *info = hb_reader_info(reader);
  if (!chosen || index < 0) index = info->frames + (chosen ? index : -1);
  if (info->nv != r->model->nv || info->rod_count != r->model->rod_count)
    status = hb_fail(err, HB_ERR_INPUT, "%s: holds %d rods with %d vertices in all, the scene has %d with %d",
                     path, info->rod_count, info->nv, r->model->rod_count, r->model->nv);
  else if (index < 0 || index >= info->frames)
    status = hb_fail(err, HB_ERR_INPUT, "--from %s: there is no such frame; the trajectory has %ld, 0 to %ld",
                     r->opt.from, info->frames, info->frames - 1);
  double *times = status ? NULL : hb_alloc((size_t)info->frames, sizeof *times);
  if (!status && !times) status = hb_fail_memory(err, "times of a trajectory");
  if (!status) status = hb_reader_series(reader, "time", times, err);
  for (size_t k = 0; !status && k < sizeof names / sizeof names[0]; k++)
    status = hb_reader_field(reader, names[k], index, fields[k], err);
  if (!status) r->frame->time = times[index];
  hb_free(times);
  hb_reader_close(reader);
  return status ? status : hb_sim_resume(r->sim, r->frame, err);
}

/* Scene, model, start. */
static hb_status prepare(solution *r, hb_error *err) {
  hb_status status = choose_directory(r, err);
  if (!status) status = hb_scene_read(r->opt.scene, r->opt.set.items, r->opt.set.count, &r->def, err);
  if (!status) status = hb_model_create(&r->def, &r->model, err);
  if (!status) status = hb_sim_create(r->model, &r->sim, err);
  if (!status) status = hb_frame_create(r->model, &r->frame, err);
  return !status && r->opt.from ? read_moment(r, err) : status;
}

/* The search. */
static hb_status solve(solution *r, hb_error *err) {
  hb_equilibrium_options how =
      hb_equilibrium_defaults(r->opt.time < 0 ? r->def.method.duration : r->opt.time);
  how.load_steps = r->opt.load_steps;
  how.any = r->opt.any;
  if (r->opt.iterations > 0) how.max_iterations = r->opt.iterations;
  if (r->opt.tolerance > 0) how.tolerance = r->opt.tolerance;
  double started = hb_clock_now();
  hb_status status = hb_sim_find_equilibrium(r->sim, &how, &r->found, err);
  r->seconds = hb_clock_now() - started;
  if (!status) hb_sim_measure_equilibrium(r->sim, &r->found, r->frame);
  return status;
}

/* Trajectory of one frame, report. */
static hb_status write_results(solution *r, hb_error *err) {
  hb_writer *writer = NULL;
  hb_status status = hb_file_directory(r->directory, err);
  if (!status) status = hb_writer_create(r->trajectory, r->model, 1, &writer, err);
  if (!status) status = hb_writer_add(writer, r->frame, err);
  hb_status closing = hb_writer_close(writer, status ? NULL : err);
  if (!status) status = closing;
  return status ? status : hb_report_equilibrium(r->report, r->model, r->frame, &r->found, r->seconds, err);
}

/* What a person wants to know. */
static void say(const solution *r) {
  const hb_equilibrium *e = &r->found;
  fprintf(stderr, "%s\n", r->def.title ? r->def.title : "untitled scene");
  for (int k = 0; k < r->model->note_count; k++) fprintf(stderr, "note: %s\n", r->model->notes[k]);
  if (e->unstable > 0)
    fprintf(stderr, "unstable equilibrium, %d unstable mode%s", e->unstable, e->unstable > 1 ? "s" : "");
  else
    fprintf(stderr, "stable equilibrium");
  if (e->neutral > 0) fprintf(stderr, ", %d mode%s without stiffness", e->neutral, e->neutral > 1 ? "s" : "");
  fprintf(stderr, " at t = %.9g: %d iterations, %.3g s, unbalanced force %.2g of %.3g\n", r->frame->time,
          e->iterations, r->seconds, e->residual, e->force_scale);
  if (e->escapes > 0)
    fprintf(stderr, "%d unstable equilibri%s left on the way (--any stops at the first)\n", e->escapes,
            e->escapes > 1 ? "a" : "um");
  fprintf(stderr, "shape in %s, figures in %s\n", r->trajectory, r->report);
}

/* The verb. */
static int run_verb(int argc, char **argv) {
  solution r;
  hb_error err = {HB_OK, ""};
  memset(&r, 0, sizeof r);
  hb_scene_def_init(&r.def);
  int result = parse(argc, argv, &r.opt);
  if (result >= 0) return result;
  hb_status status = prepare(&r, &err);
  if (!status) status = solve(&r, &err);
  if (!status) status = write_results(&r, &err);
  if (!status && !r.opt.quiet) say(&r);
  if (!status && r.opt.json) cli_print_file(r.report);
  result = status ? cli_fail("solve", &err) : CLI_DONE;
  hb_equilibrium_free(&r.found);
  hb_frame_free(r.frame);
  hb_sim_free(r.sim);
  hb_model_free(r.model);
  hb_scene_def_free(&r.def);
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
    "Loads and supports are those of the time T (default: the end of the scene). Leaves in DIR (default: "
    "out/NAME-equilibrium,\n"
    "NAME that of the scene)\n"
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
