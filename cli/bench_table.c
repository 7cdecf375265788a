/* The figures of `hebra bench` as tables or as JSON. */
#include "cli/bench.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

const char *const cli_bench_level_names[CLI_BENCH_LEVELS] = {"L1", "L2", "L3", "memory"};

/* What compiled this program. */
#if defined(__clang__)
#define COMPILER "clang " __clang_version__
#elif defined(__GNUC__)
#define COMPILER "gcc " __VERSION__
#else
#define COMPILER "unknown"
#endif

/* The machine for programs. */
static void write_machine(hb_json *json, const cli_bench_machine *m) {
  hb_json_object(json, "machine");
  hb_json_text(json, "processor", m->name);
  hb_json_integer(json, "processors", m->processors);
  hb_json_text(json, "instructions", m->isa);
  hb_json_number(json, "core_share", m->core_share);
  hb_json_number(json, "gflops_double", m->fused[0]);
  hb_json_number(json, "gflops_single", m->fused[1]);
  hb_json_number(json, "gflops_double_not_fused", m->apart[0]);
  hb_json_number(json, "gflops_single_not_fused", m->apart[1]);
  hb_json_object(json, "cache_bytes");
  for (int level = 0; level + 1 < CLI_BENCH_LEVELS; level++)
    hb_json_integer(json, cli_bench_level_names[level], (long long)m->size[level]);
  hb_json_object_end(json);
  hb_json_object(json, "gbytes_per_second");
  for (int level = 0; level < CLI_BENCH_LEVELS; level++)
    hb_json_number(json, cli_bench_level_names[level], m->bandwidth[level]);
  hb_json_object_end(json);
  hb_json_object_end(json);
}

/* What the machine can do. */
void cli_bench_say_machine(const cli_bench_report *report) {
  const cli_bench_machine *m = &report->machine;
  if (report->json) {
    hb_json_text(report->json, "version", hb_version());
    hb_json_text(report->json, "compiler", COMPILER);
    hb_json_bool(report->json, "quick", report->quick);
    hb_json_text(report->json, "counted_by", cli_bench_counted_by);
    write_machine(report->json, m);
    return;
  }
  printf("%s, %d processor%s, hebra %s compiled by %s\n", m->name, m->processors,
         m->processors == 1 ? "" : "s", hb_version(), COMPILER);
  printf("one core: %.1f GFlop/s with fused multiply-adds (%s), %.1f unfused; in single precision %.1f and "
         "%.1f\n",
         m->fused[0], m->isa, m->apart[0], m->fused[1], m->apart[1]);
  printf("bandwidth: L1 %.0f, L2 %.0f, L3 %.0f, memory %.0f GB/s (%zu KiB, %zu KiB, %zu MiB)\n",
         m->bandwidth[0], m->bandwidth[1], m->bandwidth[2], m->bandwidth[3], m->size[0] >> 10,
         m->size[1] >> 10, m->size[2] >> 20);
  if (m->core_share < 0.9)
    printf("note: other work took %.0f %% of the core meanwhile; times may come out too long\n",
           100 * (1 - m->core_share));
}

/* Heads of the columns of a group. */
void cli_bench_say_heads(const cli_bench_report *report) {
  if (report->json) return;
  printf("%-9s %-16s %4s %7s %9s %7s %6s %6s %11s %7s %5s %6s ", "rod", "integrator", "rods", "N",
         "ns/vertex", "GFlop/s", "peak", "GB/s", "bandwidth", "project", "twist", "mem/v");
  for (int k = 0; k < HB_STAGE_COUNT; k++) printf(" %4.4s", hb_stage_names[k]);
  printf("\n");
}

/* Words for a case. */
static const char *kind(const cli_bench_case *c) { return c->general ? "general" : "isotropic"; }

/* Stages of a case for programs. */
static void write_stages(hb_json *json, const cli_bench_case *c, const cli_bench_result *r,
                         const cli_bench_rate *rate, const cli_bench_machine *m) {
  hb_json_object(json, "stages");
  for (int k = 0; k < HB_STAGE_COUNT; k++) {
    double ns = r->stage[k] * r->ns, operations = rate->count ? rate->count->operations[k] : (double)NAN,
           bytes = rate->count ? rate->count->bytes[k] : (double)NAN;
    hb_json_object(json, hb_stage_names[k]);
    hb_json_number(json, "share", r->stage[k]);
    hb_json_number(json, "ns_per_vertex_step", ns);
    hb_json_number(json, "operations", operations);
    hb_json_number(json, "gflops", operations / ns);
    hb_json_number(json, "of_peak", operations / ns / m->fused[c->single]);
    hb_json_number(json, "bytes", bytes);
    hb_json_number(json, "of_bandwidth", bytes / ns / m->bandwidth[0]);
    hb_json_object_end(json);
  }
  hb_json_object_end(json);
}

/* One case for programs. */
static void write_row(hb_json *json, const cli_bench_case *c, const cli_bench_result *r,
                      const cli_bench_rate *rate, const cli_bench_machine *m) {
  hb_json_object(json, NULL);
  hb_json_text(json, "group", c->group);
  hb_json_text(json, "rod", kind(c));
  hb_json_text(json, "integrator", c->integrator);
  hb_json_integer(json, "rods", c->rods);
  hb_json_number(json, "vertices", c->vertices ? (double)c->vertices : (double)NAN);
  hb_json_integer(json, "vertices_in_all", r->vertices);
  hb_json_integer(json, "threads", c->threads);
  hb_json_text(json, "precision", c->single ? "single" : "double");
  hb_json_number(json, "ns_per_vertex_step", r->ns);
  hb_json_number(json, "projections_per_step", r->projections);
  hb_json_number(json, "twist_iterations_per_step", r->twist_iterations);
  hb_json_number(json, "memory_per_vertex", r->memory);
  hb_json_number(json, "gflops", rate->gflops);
  hb_json_number(json, "of_peak", rate->of_peak);
  hb_json_text(json, "level", cli_bench_level_names[rate->level]);
  hb_json_number(json, "bytes", rate->bytes);
  hb_json_number(json, "gbytes_per_second", rate->gbytes);
  hb_json_number(json, "of_bandwidth", rate->of_bandwidth);
  write_stages(json, c, r, rate, m);
  hb_json_object_end(json);
}

/* One case. */
void cli_bench_say_row(const cli_bench_report *report, const cli_bench_case *c, const cli_bench_result *r) {
  cli_bench_rate rate = cli_bench_compare(c, r, &report->machine);
  char vertices[24] = "20-80";
  if (report->json) {
    write_row(report->json, c, r, &rate, &report->machine);
    return;
  }
  if (c->vertices) snprintf(vertices, sizeof vertices, "%d", c->vertices);
  printf("%-9s %-16s %4d %7s %9.1f %7.2f %5.1f%% %6.1f %4.0f%% %-6s %6.2f %5.2f %6.0f ", kind(c),
         c->integrator, c->rods, vertices, r->ns, rate.gflops, 100 * rate.of_peak, rate.gbytes,
         100 * rate.of_bandwidth, cli_bench_level_names[rate.level], r->projections, r->twist_iterations,
         r->memory);
  for (int k = 0; k < HB_STAGE_COUNT; k++) printf(" %3.0f%%", 100 * r->stage[k]);
  if (strcmp(c->group, "threads") == 0) printf("  %d thread%s", c->threads, c->threads == 1 ? "" : "s");
  if (c->single) printf("  single");
  printf("\n");
  fflush(stdout);
}

/* Stages of some cases. */
void cli_bench_say_stages(const cli_bench_report *report, const cli_bench_case *cases,
                          const cli_bench_result *results, int count) {
  const cli_bench_machine *m = &report->machine;
  if (report->json || count == 0) return;
  printf("\n%-9s %-16s %4s %7s  %-8s %9s %10s %8s %6s %8s %7s %9s\n", "rod", "integrator", "rods", "N",
         "stage", "ns/vertex", "operations", "GFlop/s", "peak", "bytes", "GB/s", "bandwidth");
  for (int i = 0; i < count; i++) {
    const cli_bench_case *c = &cases[i];
    const cli_bench_result *r = &results[i];
    const cli_bench_count *counted = cli_bench_compare(c, r, m).count;
    for (int k = 0; counted && k < HB_STAGE_COUNT; k++) {
      double ns = r->ns * r->stage[k], bytes = counted->bytes[k];
      if (!(ns > 0)) continue;
      printf("%-9s %-16s %4d %7d  %-8s %9.1f %10.0f %8.2f %5.1f%% %8.0f %7.1f %6.0f%% L1\n", kind(c),
             c->integrator, c->rods, c->vertices, hb_stage_names[k], ns, counted->operations[k],
             counted->operations[k] / ns, 100 * counted->operations[k] / ns / m->fused[c->single], bytes,
             bytes / ns, 100 * bytes / ns / m->bandwidth[0]);
    }
  }
}
