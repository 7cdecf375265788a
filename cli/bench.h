/* What the files of `hebra bench` share: cases, what was measured of them, the machine. */
#ifndef HB_CLI_BENCH_H
#define HB_CLI_BENCH_H

#include "cli/cli.h"
#include "output/json.h"

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
#define CLI_BENCH_COUNTED_CACHE 1048576.0 /* bytes, for the traffic */
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
  double core_share; /* of a core that this process had while it measured: well below 1 if other work runs */
} cli_bench_machine;
hb_status cli_bench_measure_machine(cli_bench_machine *machine, hb_error *err);

/* ---- measuring: bench_measure.c ---- */

/* What was measured of a case. */
typedef struct cli_bench_result {
  long vertices;                        /* of all rods */
  double ns;                            /* per vertex and step, the best of many trials */
  double stage[HB_STAGE_COUNT];         /* shares of the time, 1 in all */
  double projections, twist_iterations; /* per rod and step */
  double memory;                        /* bytes per vertex */
} cli_bench_result;
hb_status cli_bench_measure(const cli_bench_case *c, bool quick, cli_bench_result *out, hb_error *err);

/* How a case stands against the machine; NAN where nothing was counted of such rods. */
typedef struct cli_bench_rate {
  const cli_bench_count *count; /* NULL: nothing was counted */
  double gflops, of_peak;       /* operations, and their share of the peak in that precision */
  int level;    /* of memory: 0 if they fit into the second cache or 1 MiB, else the one that holds them */
  double bytes; /* per vertex and step: at level 0 what instructions move, else the traffic */
  double gbytes, of_bandwidth; /* GB/s, and their share of the level's bandwidth */
} cli_bench_rate;
cli_bench_rate cli_bench_compare(const cli_bench_case *c, const cli_bench_result *r,
                                 const cli_bench_machine *machine);

/* ---- saying it: bench_table.c ---- */

/* Where figures go: a table on standard output, or JSON. */
typedef struct cli_bench_report {
  bool quick;
  hb_json *json;      /* NULL: a table */
  const char *scenes; /* directory of the scene files */
  const int *sizes;   /* vertices of the rods of group `one` */
  int size_count;
  cli_bench_machine machine;
} cli_bench_report;
extern const char *const cli_bench_level_names[CLI_BENCH_LEVELS];
void cli_bench_say_machine(const cli_bench_report *report);
void cli_bench_say_heads(const cli_bench_report *report);
void cli_bench_say_row(const cli_bench_report *report, const cli_bench_case *c, const cli_bench_result *r);
/* The stages of some cases. Nothing with JSON, where every row has them. */
void cli_bench_say_stages(const cli_bench_report *report, const cli_bench_case *cases,
                          const cli_bench_result *results, int count);

/* ---- with files: bench_files.c ---- */
hb_status cli_bench_start_up(const cli_bench_report *report, hb_error *err);
hb_status cli_bench_output(const cli_bench_report *report, hb_error *err);

#endif
