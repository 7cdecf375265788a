/* hebra bench: what a step costs on this machine. */
#include "cli/cli.h"

#include <getopt.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#define SIZES_MAX 16
#define REPEATS 60

/* One way to run a rod. */
typedef struct bench_case {
  const char *name, *integrator;
  bool general;
} bench_case;

/* What was measured. */
typedef struct bench_result {
  double ns, stage[HB_STAGE_COUNT], projections, twist_iterations, bytes;
} bench_result;

static const bench_case cases[] = {{"isotropic", "symplectic-euler", false},
                                   {"isotropic", "verlet", false},
                                   {"general", "symplectic-euler", true},
                                   {"general", "verlet", true}};

/* Wall clock in seconds. */
static double wall(void) {
  struct timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* A helix of 20 edges of length 0.01 per turn, held at both ends and twisted by half a turn per helical turn.
 * The isotropic rod is straight at rest and unwinds, the general one is curved at rest and shaken: bending,
 * twist and lengths have the same work to do at every place, whatever the length. The step is a quarter of
 * the explicit limit. */
static void write_scene(const bench_case *c, int n, char *text, size_t size) {
  double turns = (n - 1) / 20.0;
  snprintf(text, size,
           "title: bench\n"
           "method: {integrator: %s, time_step: 2e-5, duration: 1e6, length_tolerance: 1e-10}\n"
           "rods:\n"
           "  - name: rod\n"
           "    rest: {helix: {radius: 0.03, pitch: 0.06, turns: %.17g, vertices: %d}}\n"
           "    straight_rest: %s\n"
           "    velocity: ['sin(50*s)', 'cos(70*s)', 'sin(90*s)']\n"
           "    bending: %s\n"
           "    twisting: 0.015\n"
           "    linear_density: 0.05\n"
           "    start: {position: fixed, material_angle: 'pi*%.17g'}\n"
           "    end: {position: fixed, material_angle: 0}\n",
           c->integrator, turns, n, c->general ? "false" : "true", c->general ? "[0.02, 0.03]" : "0.02",
           turns);
}

/* Steps per measurement: about 6 million vertex steps in all, at least one per repeat. */
static long step_count(int n) { return 6000000 / n > REPEATS ? 6000000 / n : REPEATS; }

/* Runs one case: the fastest of a few repeats. */
static hb_status measure(const bench_case *c, int n, bench_result *out, hb_error *err) {
  char text[2048];
  hb_scene_def def;
  hb_model *model = NULL;
  hb_sim *sim = NULL;
  write_scene(c, n, text, sizeof text);
  hb_status status = hb_scene_parse(text, strlen(text), "bench", NULL, NULL, 0, &def, err);
  if (status) return status;
  def.method.lanes = cli_lanes();
  status = hb_model_create(&def, &model, err);
  if (!status) status = hb_sim_create(model, &sim, err);
  long steps = step_count(n);
  for (long k = 0; !status && k < steps / 20 + 5; k++) status = hb_sim_step(sim, err);
  *out = (bench_result){.ns = 1e300};
  for (int repeat = 0; !status && repeat < REPEATS; repeat++) {
    double started = wall();
    for (long k = 0; !status && k < steps / REPEATS; k++) status = hb_sim_step(sim, err);
    double ns = 1e9 * (wall() - started) / ((double)n * (double)(steps / REPEATS));
    if (ns < out->ns) out->ns = ns;
  }
  if (!status) {
    const double *scalar = hb_sim_const_state(sim)->scalar;
    double done = scalar[HB_S_STEP];
    out->projections = scalar[HB_S_PROJECTIONS] / done;
    out->twist_iterations = scalar[HB_S_TWIST_ITERATIONS] / done;
    out->bytes = (double)hb_sim_memory(sim) / n;
    hb_sim_time_stages(sim, 1);
    for (long k = 0; !status && k < steps / 20 + 1; k++) status = hb_sim_step(sim, err);
    double sum = 0;
    hb_sim_stage_seconds(sim, out->stage);
    for (int k = 0; k < HB_STAGE_COUNT; k++) sum += out->stage[k];
    for (int k = 0; k < HB_STAGE_COUNT; k++) out->stage[k] /= sum > 0 ? sum : 1;
  }
  hb_sim_free(sim);
  hb_model_free(model);
  hb_scene_def_free(&def);
  return status;
}

/* One row. */
static void print_row(const bench_case *c, int n, const bench_result *r, bool json, bool first) {
  if (json) {
    printf("%s\n  {\"rod\": \"%s\", \"integrator\": \"%s\", \"vertices\": %d, \"ns_per_vertex_step\": %.3f, "
           "\"projections_per_step\": %.3f, \"twist_iterations_per_step\": %.3f, \"bytes_per_vertex\": %.1f, "
           "\"stages\": {",
           first ? "" : ",", c->name, c->integrator, n, r->ns, r->projections, r->twist_iterations, r->bytes);
    for (int k = 0; k < HB_STAGE_COUNT; k++)
      printf("%s\"%s\": %.4f", k ? ", " : "", hb_stage_names[k], r->stage[k]);
    printf("}}");
    return;
  }
  printf("%-10s %-17s %7d %9.1f %8.2f %8.2f %9.0f ", c->name, c->integrator, n, r->ns, r->projections,
         r->twist_iterations, r->bytes);
  for (int k = 0; k < HB_STAGE_COUNT; k++) printf(" %3.0f%%", 100 * r->stage[k]);
  printf("\n");
  fflush(stdout);
}

/* Comma-separated sizes; how many, or -1. */
static int parse_sizes(const char *text, int *sizes) {
  int count = 0;
  for (const char *p = text; count < SIZES_MAX;) {
    char *end;
    long n = strtol(p, &end, 10);
    if (end == p || n < 5 || n > 10000000 || (*end && *end != ',')) return -1;
    sizes[count++] = (int)n;
    if (!*end) return count;
    p = end + 1;
  }
  return -1;
}

/* The verb. */
static int bench_verb(int argc, char **argv) {
  static const struct option longs[] = {
      {"sizes", required_argument, NULL, 'n'}, {"json", no_argument, NULL, 'j'}, {NULL, 0, NULL, 0}};
  int sizes[SIZES_MAX] = {25, 100, 1000, 10000, 100000}, count = 5;
  bool json = false, first = true;
  opterr = 0;
  for (int c; (c = getopt_long(argc, argv, ":n:j", longs, NULL)) != -1;) {
    if (c == 'j')
      json = true;
    else if (c == 'n')
      count = parse_sizes(optarg, sizes);
    else
      return cli_usage(&cli_verb_bench, "%s is not an option, or lacks its value", argv[optind - 1]);
    if (count < 0)
      return cli_usage(&cli_verb_bench,
                       "--sizes \"%s\": up to %d numbers from 5 to 10000000 with commas are allowed", optarg,
                       SIZES_MAX);
  }
  if (optind < argc) return cli_usage(&cli_verb_bench, "\"%s\" is not expected", argv[optind]);
  if (json) {
    printf("[");
  } else {
    printf("cost of one step, one core, fastest of %d runs; lengths to 1e-10\n", REPEATS);
    printf("%-10s %-17s %7s %9s %8s %8s %9s ", "rod", "integrator", "N", "ns/vertex", "project", "twist",
           "bytes/v");
    for (int k = 0; k < HB_STAGE_COUNT; k++) printf(" %s", hb_stage_names[k]);
    printf("\n");
  }
  for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++)
    for (int i = 0; i < count; i++, first = false) {
      hb_error err = {HB_OK, ""};
      bench_result result;
      if (measure(&cases[k], sizes[i], &result, &err)) return cli_fail("bench", &err);
      print_row(&cases[k], sizes[i], &result, json, first);
    }
  if (json) printf("\n]\n");
  return CLI_DONE;
}

const cli_verb cli_verb_bench = {"bench", "measure what a step costs on this machine",
                                 "usage: hebra bench [--sizes N,N,...] [--json]\n"
                                 "\n"
                                 "Steps rods of 25 to 100,000 vertices, isotropic and general (anisotropic, "
                                 "curved at rest), with both integrators,\n"
                                 "and prints nanoseconds per vertex and step (the fastest of a few repeats), "
                                 "iterations of projection and twist per\n"
                                 "step, memory per vertex, and how the time divides over the stages.\n"
                                 "\n"
                                 "  --sizes N,N,...   vertices per rod, default 25,100,1000,10000,100000\n"
                                 "  --json            one JSON array instead of the table\n"
                                 "\n"
                                 "example: hebra bench --sizes 100,1000\n",
                                 bench_verb};
