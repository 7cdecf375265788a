/* What the files of `hebra bench` share: cases, what was measured of them, the machine. */
#ifndef HB_CLI_BENCH_H
#define HB_CLI_BENCH_H

#include "cli/cli.h"

/* Settings of a method that cases may vary; 1 where hb_method_def has the field. */
#define CLI_BENCH_THREADS 0   /* hb_method_def.threads */
#define CLI_BENCH_PRECISION 0 /* hb_method_def.precision */

/* ---- cases: bench_cases.c ---- */

/* Rods to step, and how. */
typedef struct cli_bench_case {
  const char *group, *integrator;
  bool general; /* anisotropic and curved at rest; else isotropic and straight */
  int rods;     /* >= 1 */
  int vertices; /* of each rod, >= 5; 0: 20 to 80, another number for every rod, 50 on the average */
  int threads;  /* 0: as the library chooses */
  bool single;  /* in single precision */
} cli_bench_case;

/* A case that runs. */
typedef struct cli_bench_run {
  hb_scene_def def;
  hb_model *model;
  hb_sim *sim;
} cli_bench_run;

/* Vertices of rod r of a case. */
int cli_bench_vertices(const cli_bench_case *c, int r);
/* Makes the simulation of a case; cli_bench_stop frees it, also after a failure. */
hb_status cli_bench_start(const cli_bench_case *c, cli_bench_run *run, hb_error *err);
void cli_bench_stop(cli_bench_run *run);

/* ---- operations and bytes per vertex and step: bench_counts.c, written by bench/count ---- */

/* One case, counted on a rod of 200 vertices or on 24 rods of 50. Stages in the order of hb_stage, and the
 * rest. */
typedef struct cli_bench_count {
  const char *name, *integrator;
  bool general, many;
  double projections, twist_iterations; /* per rod and step, when it was counted */
  double traffic;                       /* bytes that go through a cache of 1 MiB */
  double operations[HB_STAGE_COUNT + 1];
  double bytes[HB_STAGE_COUNT + 1]; /* that instructions load and store */
} cli_bench_count;
extern const cli_bench_count cli_bench_counts[];
extern const int cli_bench_count_rows;
extern const char *const cli_bench_counted_by; /* compiler, target, HEBRA_ISA */

/* ---- the machine: bench_peak.c ---- */

/* Levels of memory: three caches and what is behind them. */
enum { CLI_BENCH_LEVELS = 4 };

typedef struct cli_bench_machine {
  char name[128];
  int processors;
  const char *isa; /* instruction set of the fastest multiply-adds: "avx512", "avx2", "portable" */
  double fused[2]; /* GFlop/s of one core with multiply-adds, in double and in single precision */
  double apart[2]; /* with as many multiplications as additions, nothing fused */
  size_t size[3];  /* bytes of the caches */
  double bandwidth[CLI_BENCH_LEVELS]; /* GB/s that one core reads and writes */
} cli_bench_machine;
hb_status cli_bench_measure_machine(cli_bench_machine *machine, hb_error *err);

#endif
