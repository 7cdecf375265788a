/* hebra trace: branches of equilibria over a parameter. */
#include "base/clock.h"
#include "base/memory.h"
#include "cli/cli.h"
#include "output/branches.h"
#include "output/file.h"

#include <getopt.h>
#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

/* Room for frames in a new trajectory; it grows by half as often as needed. */
#define FRAMES 80

/* The arguments. */
typedef struct options {
  const char *scene, *directory;
  cli_overrides overrides;
  double time; /* negative: not given */
  bool any, quiet, json;
} options;

/* Everything that a trace owns. */
typedef struct study {
  options opt;
  char directory[PATH_MAX], path[PATH_MAX + 64];
  hb_scene_def def;
  hb_model *model;
  hb_frame *frame;
  hb_writer *writer; /* of the branch at hand */
  long room, frames; /* of it */
  double *first;     /* positions of the first point */
  hb_branch_row *rows;
  long row_count, row_room;
  hb_branch_end *ends;
  int end_count, end_room;
  hb_trace_costs costs;
  double seconds;
} study;

/* Parses argv; an exit status, or -1 to go on. */
static int parse(int argc, char **argv, options *opt) {
  static const struct option longs[] = {{"output", required_argument, NULL, 'o'},
                                        {"set", required_argument, NULL, 's'},
                                        {"time", required_argument, NULL, 't'},
                                        {"any", no_argument, NULL, 'a'},
                                        {"quiet", no_argument, NULL, 'q'},
                                        {"json", no_argument, NULL, 'j'},
                                        {NULL, 0, NULL, 0}};
  int result = -1;
  *opt = (options){.time = -1};
  opterr = 0;
  optind = 1;
  for (int c; result < 0 && (c = getopt_long(argc, argv, ":o:q", longs, NULL)) != -1;) {
    switch (c) {
    case 'o': opt->directory = optarg; break;
    case 's': result = cli_override(&cli_verb_trace, &opt->overrides, optarg); break;
    case 't':
      if (!cli_number(optarg, 0, &opt->time))
        return cli_usage(&cli_verb_trace, "--time \"%s\" is not a time from 0 on", optarg);
      break;
    case 'a': opt->any = true; break;
    case 'q': opt->quiet = true; break;
    case 'j': opt->json = true; break;
    case ':': return cli_usage(&cli_verb_trace, "%s needs a value", argv[optind - 1]);
    default: return cli_usage(&cli_verb_trace, "%s is not an option", argv[optind - 1]);
    }
  }
  if (result >= 0) return result;
  if (optind == argc) return cli_usage(&cli_verb_trace, "the scene file is missing");
  opt->scene = argv[optind++];
  if (optind < argc)
    return cli_usage(&cli_verb_trace, "\"%s\": only one scene can be traced at a time", argv[optind]);
  return -1;
}

/* Scene, model, room for a frame. */
static hb_status prepare(study *s, hb_error *err) {
  hb_status status =
      cli_directory(s->opt.directory, s->opt.scene, "-trace", s->directory, sizeof s->directory, err);
  if (!status)
    status = hb_scene_read(s->opt.scene, s->opt.overrides.items, s->opt.overrides.count, &s->def, err);
  if (!status && !s->def.trace.parameter)
    return hb_fail(
        err, HB_ERR_INPUT,
        "%s: the section trace is missing; it names the parameter, for example trace: {parameter: P, "
        "from: 0, to: 10}",
        s->opt.scene);
  if (!status) status = hb_model_create(&s->def, &s->model, err);
  if (!status) status = hb_frame_create(s->model, &s->frame, err);
  if (status) return status;
  s->first = hb_alloc(3 * (size_t)s->model->nv, sizeof *s->first);
  return s->first ? HB_OK : hb_fail_memory(err, "shape of the first point");
}

/* Room for one more entry of an array that grows by doubling. */
static bool grow(void **array, long count, long *room, size_t size) {
  if (count < *room) return true;
  long more = *room ? 2 * *room : 64;
  void *grown = hb_realloc(*array, (size_t)more, size);
  if (!grown) return false;
  *array = grown;
  *room = more;
  return true;
}

/* The trajectory of a branch: opened by its first point, made longer where it is full. */
static hb_status open_writer(study *s, const hb_trace_point *point, hb_error *err) {
  hb_status status = HB_OK;
  snprintf(s->path, sizeof s->path, "%s/branch-%d.h5", s->directory, point->branch);
  if (point->index == 0) {
    s->room = FRAMES;
    s->frames = 0;
    status = hb_file_directory(s->directory, err);
    return status ? status : hb_writer_create(s->path, s->model, s->room, &s->writer, err);
  }
  if (s->frames < s->room) return HB_OK;
  s->room += s->room / 2;
  hb_writer *full = s->writer;
  s->writer = NULL;
  status = hb_writer_close(full, err);
  return status ? status : hb_writer_continue(s->path, s->model, s->room, s->frames, &s->writer, err);
}

/* Every point: measured, written, kept as a row. The time of its frame is the parameter. */
static hb_status take_point(void *context, const hb_trace_point *point, hb_error *err) {
  study *s = context;
  if (!grow((void **)&s->rows, s->row_count, &s->row_room, sizeof *s->rows))
    return hb_fail_memory(err, "points of the branches");
  hb_sim_measure_equilibrium(point->sim, &point->found, s->frame);
  if (s->row_count == 0) memcpy(s->first, s->frame->position, 3 * (size_t)s->model->nv * sizeof *s->first);
  hb_branch_measure(point, s->model, s->frame, s->first, &s->rows[s->row_count++]);
  s->frame->time = point->parameter;
  s->frame->step = point->index;
  hb_status status = open_writer(s, point, err);
  if (!status) status = hb_writer_add(s->writer, s->frame, err);
  s->frames++;
  if (status || s->opt.quiet || point->kind == HB_TRACE_REGULAR) return status;
  fprintf(stderr, "branch %d, point %ld: %s at %s = %.9g, %s\n", point->branch, point->index,
          hb_trace_kind_name(point->kind), s->def.trace.parameter, point->parameter,
          point->found.unstable ? "unstable" : "stable");
  return HB_OK;
}

/* The end of a branch. */
static hb_status take_end(void *context, const hb_trace_end *end, hb_error *err) {
  study *s = context;
  long room = s->end_room;
  hb_writer *writer = s->writer;
  s->writer = NULL;
  hb_status status = hb_writer_close(writer, err);
  if (status) return status;
  if (!grow((void **)&s->ends, s->end_count, &room, sizeof *s->ends))
    return hb_fail_memory(err, "ends of the branches");
  s->end_room = (int)room;
  hb_branch_end *to = &s->ends[s->end_count++];
  *to = (hb_branch_end){
      .bifurcation = end->bifurcation, .side = end->side, .points = end->points, .failed = end->failed};
  snprintf(to->reason, sizeof to->reason, "%s", end->reason);
  if (!s->opt.quiet) fprintf(stderr, "branch %d: %ld points; %s\n", end->branch, end->points, end->reason);
  return HB_OK;
}

/* All branches. */
static hb_status trace(study *s, hb_error *err) {
  const hb_trace_def *d = &s->def.trace;
  hb_scene_range range = {&s->def, d->parameter, s->opt.time < 0 ? s->def.method.duration : s->opt.time};
  hb_trace_family family = hb_scene_family(&range);
  hb_trace_sink sink = {take_point, take_end, s};
  hb_trace_options how = {.from = d->from,
                          .to = d->to,
                          .step = d->step,
                          .max_points = d->points,
                          .max_branches = d->branches,
                          .any = s->opt.any};
  double started = hb_clock_now();
  hb_status status = hb_trace(&family, &how, &sink, &s->costs, err);
  s->seconds = hb_clock_now() - started;
  return status;
}

/* Table and report, of what there is. */
static hb_status write_results(study *s, hb_error *err) {
  hb_branches all = {.model = s->model,
                     .parameter = s->def.trace.parameter,
                     .from = s->def.trace.from,
                     .to = s->def.trace.to,
                     .time = s->opt.time < 0 ? s->def.method.duration : s->opt.time,
                     .wall_seconds = s->seconds,
                     .costs = &s->costs,
                     .rows = s->rows,
                     .row_count = s->row_count,
                     .ends = s->ends,
                     .end_count = s->end_count};
  snprintf(s->path, sizeof s->path, "%s/branches.csv", s->directory);
  hb_status status = hb_branches_table(s->path, &all, err);
  snprintf(s->path, sizeof s->path, "%s/branches.json", s->directory);
  return status ? status : hb_branches_report(s->path, &all, err);
}

/* A branch that could not be followed to its end is told as an error, after everything is written. */
static hb_status judge(const study *s, hb_error *err) {
  for (int k = 0; k < s->end_count; k++)
    if (s->ends[k].failed)
      return hb_fail(err, HB_ERR_NUMERIC, "branch %d ended early: %s (all points before are in %s)", k,
                     s->ends[k].reason, s->directory);
  return HB_OK;
}

/* The verb. */
static int run_verb(int argc, char **argv) {
  study s;
  hb_error err = {HB_OK, ""};
  memset(&s, 0, sizeof s);
  hb_scene_def_init(&s.def);
  int result = parse(argc, argv, &s.opt);
  if (result >= 0) return result;
  hb_status status = prepare(&s, &err);
  if (!status) status = trace(&s, &err);
  if (s.writer) (void)hb_writer_close(s.writer, NULL);
  if (!status) status = write_results(&s, &err);
  if (!status && !s.opt.quiet)
    fprintf(stderr, "%ld points in %.3g s; shapes in %s/branch-N.h5, table in branches.csv, report in %s\n",
            s.row_count, s.seconds, s.directory, s.path);
  if (!status && s.opt.json) cli_print_file(s.path);
  if (!status) status = judge(&s, &err);
  result = status ? cli_fail("trace", &err) : CLI_DONE;
  hb_free(s.rows);
  hb_free(s.ends);
  hb_free(s.first);
  hb_frame_free(s.frame);
  hb_model_free(s.model);
  hb_scene_def_free(&s.def);
  return result;
}

const cli_verb cli_verb_trace = {
    "trace", "follow equilibria over a parameter: folds, bifurcations, branches",
    "usage: hebra trace SCENE [-o DIR] [--set KEY=VALUE ...] [--time T] [--any] [--quiet] [--json]\n"
    "\n"
    "Finds the equilibrium of the scene at one value of a parameter and follows it while the parameter "
    "changes, also\n"
    "where it turns back (folds) and where it becomes unstable; finds the bifurcations on the way and "
    "follows the\n"
    "branches that cross there. The scene says what is followed:\n"
    "  trace: {parameter: P, from: 0, to: 40}        P: a name under parameters, or t\n"
    "Leaves in DIR (default: out/NAME-trace of the scene)\n"
    "  branches.csv     a line per point: parameter, stability, energies, forces, places\n"
    "  branches.json    how every branch ended, all folds and bifurcations\n"
    "  branch-N.h5      the shapes of branch N, for hebra render, plot, export; their time is the parameter\n"
    "\n"
    "  -o, --output DIR      where the results go\n"
    "  --set KEY=VALUE       change or add a key of the scene, for example trace.branches=3 (up to 64 "
    "times)\n"
    "  --time T              time at which loads and supports are taken (default: the end of the scene)\n"
    "  --any                 start from the nearest equilibrium, stable or not\n"
    "  -q, --quiet           say nothing\n"
    "  --json                print branches.json to standard output\n"
    "\n"
    "example:\n"
    "  hebra trace scenes/trace/euler.yaml -o out/euler\n"
    "  hebra plot out/euler/branches.csv -o euler.png\n",
    run_verb};
