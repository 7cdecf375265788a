/* hebra bench: what a step costs on this machine, and what the machine could do. */
#include "cli/bench.h"

#include <getopt.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define SIZES_MAX 16
#define CASES_MAX 128
#define COUNT(array) (int)(sizeof(array) / sizeof((array)[0]))

static const char *const integrators[] = {"symplectic-euler", "verlet"};

/* Measures the cases of a group and says them; stages of those that `detail` points out. */
static hb_status measure_all(const cli_bench_report *report, const cli_bench_case *cases, int count,
                             bool (*detail)(const cli_bench_case *), hb_error *err) {
  cli_bench_case shown[CASES_MAX];
  cli_bench_result results[CASES_MAX];
  int shown_count = 0;
  hb_status status = HB_OK;
  cli_bench_say_heads(report);
  for (int k = 0; !status && k < count; k++) {
    cli_bench_result result;
    status = cli_bench_measure(&cases[k], report->quick, &result, err);
    if (status) break;
    cli_bench_say_row(report, &cases[k], &result);
    if (!detail(&cases[k])) continue;
    shown[shown_count] = cases[k];
    results[shown_count++] = result;
  }
  if (!status) cli_bench_say_stages(report, shown, results, shown_count);
  return status;
}

/* Cases whose stages are shown: of middle size. */
static bool is_middle(const cli_bench_case *c) { return c->vertices == (c->rods > 1 ? 50 : 1000); }

/* One rod of growing size. */
static hb_status measure_one(const cli_bench_report *report, hb_error *err) {
  cli_bench_case cases[CASES_MAX];
  int count = 0;
  for (int kind = 0; kind < 2; kind++)
    for (int k = 0; k < COUNT(integrators); k++)
      for (int i = 0; i < report->size_count; i++)
        cases[count++] = (cli_bench_case){.group = "one",
                                          .integrator = integrators[k],
                                          .general = kind == 1,
                                          .rods = 1,
                                          .vertices = report->sizes[i],
                                          .threads = 1};
  return measure_all(report, cases, count, is_middle, err);
}

/* Many rods: as in hair, few that are longer, and all of different sizes. */
static hb_status measure_many(const cli_bench_report *report, hb_error *err) {
  static const int shapes[][2] = {{1000, 50}, {100, 100}, {1000, 0}};
  cli_bench_case cases[CASES_MAX];
  int count = 0;
  for (int kind = 0; kind < 2; kind++)
    for (int k = 0; k < COUNT(integrators); k++)
      for (int i = 0; i < COUNT(shapes); i++)
        cases[count++] = (cli_bench_case){.group = "many",
                                          .integrator = integrators[k],
                                          .general = kind == 1,
                                          .rods = shapes[i][0],
                                          .vertices = shapes[i][1],
                                          .threads = 1};
  return measure_all(report, cases, count, is_middle, err);
}

/* No stages. */
static bool is_none(const cli_bench_case *c) {
  (void)c;
  return false;
}

/* 1000 rods, and one long rod, on 1, 2, 4 ... all processors. */
static hb_status measure_threads(const cli_bench_report *report, hb_error *err) {
  static const int shapes[][2] = {{1000, 50}, {1, 100000}};
  cli_bench_case cases[CASES_MAX];
  int count = 0, most = report->machine.processors;
  for (int kind = 0; kind < 2; kind++)
    for (int i = 0; i < COUNT(shapes); i++)
      for (int threads = 1; count < CASES_MAX; threads = 2 * threads < most ? 2 * threads : most) {
        cases[count++] = (cli_bench_case){.group = "threads",
                                          .integrator = "verlet",
                                          .general = kind == 1,
                                          .rods = shapes[i][0],
                                          .vertices = shapes[i][1],
                                          .threads = threads};
        if (threads >= most) break;
      }
  return measure_all(report, cases, count, is_none, err);
}

/* Double against single precision. */
static hb_status measure_precision(const cli_bench_report *report, hb_error *err) {
  static const int shapes[][2] = {{1, 1000}, {1000, 50}};
  cli_bench_case cases[CASES_MAX];
  int count = 0;
  for (int kind = 0; kind < 2; kind++)
    for (int i = 0; i < COUNT(shapes); i++)
      for (int single = 0; single < 2; single++)
        cases[count++] = (cli_bench_case){.group = "precision",
                                          .integrator = "verlet",
                                          .general = kind == 1,
                                          .rods = shapes[i][0],
                                          .vertices = shapes[i][1],
                                          .single = single == 1,
                                          .threads = 1};
  return measure_all(report, cases, count, is_none, err);
}

/* The groups by name. steps: their rows share a table of JSON. */
static const struct group {
  const char *name, *title;
  bool steps;
  hb_status (*measure)(const cli_bench_report *report, hb_error *err);
} groups[] = {
    {"one", "one rod", true, measure_one},
    {"many", "many rods", true, measure_many},
    {"threads", "threads", true, measure_threads},
    {"precision", "double and single precision", true, measure_precision},
    {"start", "from a scene to results", false, cli_bench_start_up},
    {"output", "a frame after every 10th step", false, cli_bench_output},
};

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

/* What was asked for. */
typedef struct options {
  bool json, wanted[COUNT(groups)];
  int sizes[SIZES_MAX];
} options;

/* A group's name among the arguments; an exit status, or -1 to go on. */
static int choose_group(const char *name, options *opt) {
  char known[128] = "";
  for (int k = 0; k < COUNT(groups); k++) {
    if (strcmp(groups[k].name, name) == 0) {
      opt->wanted[k] = true;
      return -1;
    }
    size_t used = strlen(known);
    snprintf(known + used, sizeof known - used, "%s%s", k ? ", " : "", groups[k].name);
  }
  return cli_usage(&cli_verb_bench, "\"%s\" is not a group; allowed are %s", name, known);
}

/* Parses argv; an exit status, or -1 to go on. */
static int parse(int argc, char **argv, options *opt, cli_bench_report *report) {
  static const struct option longs[] = {{"sizes", required_argument, NULL, 'n'},
                                        {"scenes", required_argument, NULL, 's'},
                                        {"quick", no_argument, NULL, 'q'},
                                        {"json", no_argument, NULL, 'j'},
                                        {NULL, 0, NULL, 0}};
  static const int sizes[] = {25, 100, 1000, 10000, 100000, 1000000};
  *opt = (options){.json = false};
  *report = (cli_bench_report){.scenes = "scenes", .sizes = sizes, .size_count = COUNT(sizes)};
  opterr = 0;
  for (int c; (c = getopt_long(argc, argv, ":", longs, NULL)) != -1;) {
    switch (c) {
    case 'j': opt->json = true; break;
    case 'q': report->quick = true; break;
    case 's': report->scenes = optarg; break;
    case 'n':
      report->sizes = opt->sizes;
      report->size_count = parse_sizes(optarg, opt->sizes);
      if (report->size_count < 0)
        return cli_usage(&cli_verb_bench,
                         "--sizes \"%s\": up to %d numbers from 5 to 10000000 with commas are allowed",
                         optarg, SIZES_MAX);
      break;
    case ':': return cli_usage(&cli_verb_bench, "%s needs a value", argv[optind - 1]);
    default: return cli_usage(&cli_verb_bench, "%s is not an option", argv[optind - 1]);
    }
  }
  if (report->quick && report->sizes == sizes) report->size_count = 4;
  for (int k = 0; optind == argc && k < COUNT(groups); k++) opt->wanted[k] = true;
  for (; optind < argc; optind++) {
    int status = choose_group(argv[optind], opt);
    if (status >= 0) return status;
  }
  return -1;
}

/* The groups that were asked for. */
static hb_status measure_groups(cli_bench_report *report, const options *opt, hb_error *err) {
  hb_status status = cli_bench_measure_machine(&report->machine, err);
  if (status) return status;
  cli_bench_say_machine(report);
  if (report->json) hb_json_array(report->json, "steps");
  bool steps = true;
  for (int k = 0; !status && k < COUNT(groups); k++) {
    if (report->json && steps && !groups[k].steps) {
      hb_json_array_end(report->json);
      steps = false;
    }
    if (report->json && !groups[k].steps) hb_json_array(report->json, groups[k].name);
    if (opt->wanted[k]) {
      if (!report->json) printf("\n%s: %s\n", groups[k].name, groups[k].title);
      status = groups[k].measure(report, err);
    }
    if (report->json && !groups[k].steps) hb_json_array_end(report->json);
  }
  return status;
}

/* The verb. */
static int bench_verb(int argc, char **argv) {
  options opt;
  cli_bench_report report;
  hb_json json;
  hb_error err = {HB_OK, ""};
  int ended = parse(argc, argv, &opt, &report);
  if (ended >= 0) return ended;
  if (opt.json) {
    report.json = &json;
    hb_json_begin(&json, stdout);
  }
  if (measure_groups(&report, &opt, &err)) return cli_fail("bench", &err);
  if (opt.json) hb_json_end(&json);
  return CLI_DONE;
}

const cli_verb cli_verb_bench = {
    "bench", "measure what a step costs on this machine",
    "usage: hebra bench [GROUP ...] [--quick] [--json] [--sizes N,N,...] [--scenes DIR]\n"
    "\n"
    "Measures what this machine can do - multiply-adds of one core, bandwidth of its caches and memory - and "
    "then what\n"
    "steps cost on it: nanoseconds per vertex and step (the best of many trials), operations per second and "
    "their share\n"
    "of the peak, bytes per second and their share of the bandwidth, iterations, memory, and how the time "
    "divides over\n"
    "the stages. Operations and bytes were counted instruction by instruction (docs/guide/bench.md).\n"
    "\n"
    "Groups, all of them if none is named:\n"
    "  one         one rod of 25 to 1,000,000 vertices, isotropic and general, both integrators\n"
    "  many        1000 rods of 50 vertices, 100 of 100, 1000 of different sizes\n"
    "  threads     1000 rods and one of 100,000 vertices on 1, 2, 4, ... all processors\n"
    "  precision   the same rods in double and in single precision\n"
    "  start       a scene of 25 vertices up to its first step; the three scenes of the "
    "thesis with all output\n"
    "  output      what writing a frame after every 10th step costs\n"
    "\n"
    "  --quick           fewer trials, at most 10,000 vertices\n"
    "  --json            one JSON object instead of the tables\n"
    "  --sizes N,N,...   vertices of the rods in group one, default 25,100,1000,10000,100000,1000000\n"
    "  --scenes DIR      where the scenes of the thesis are, default scenes\n"
    "\n"
    "example: hebra bench one many --sizes 100,1000\n",
    bench_verb};
