/* Steps one case of `hebra bench` and nothing else, for tools that count what a step executes:
 *   count_steps isotropic|general INTEGRATOR RODS VERTICES WARM STEPS
 * makes the rods (VERTICES 0: 20 to 80 each), takes WARM steps that are not to be counted, then STEPS within
 * count_steps(), and prints vertices, iterations and memory as one line of JSON. `count_steps` alone says
 * what compiled it. */
#include "base/memory.h"
#include "cli/bench.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#if defined(__clang__)
#define COMPILER "clang"
#define MAJOR __clang_major__
#elif defined(__GNUC__)
#define COMPILER "gcc"
#define MAJOR __GNUC__
#else
#define COMPILER "other"
#define MAJOR 0
#endif
#if defined(__AVX512F__)
#define TARGET "x86-64-v4"
#elif defined(__AVX2__) && defined(__FMA__)
#define TARGET "x86-64-v3"
#elif defined(__x86_64__)
#define TARGET "x86-64"
#elif defined(__aarch64__)
#define TARGET "aarch64"
#else
#define TARGET "other"
#endif

__attribute__((noinline)) hb_status count_steps(hb_sim *sim, long steps, hb_error *err);

/* The steps that count: the tools look for this name. */
hb_status count_steps(hb_sim *sim, long steps, hb_error *err) {
  hb_status status = HB_OK;
  for (long k = 0; !status && k < steps; k++) status = hb_sim_step(sim, err);
  return status;
}

__attribute__((noinline)) void count_known(int n, const double *restrict a, double *restrict b);

/* One each of addition, subtraction, division, square root, and three multiplications. */
void count_known(int n, const double *restrict a, double *restrict b) {
  for (int i = 0; i < n; i++) b[i] = sqrt(a[i] * a[i] + 1) * 3 / (b[i] * 5 - 7);
}

/* The arithmetic that is known, on n numbers. */
static int known(int n) {
  double *a = hb_alloc((size_t)n, sizeof *a), *b = hb_alloc((size_t)n, sizeof *b), sum = 0;
  for (int i = 0; a && b && i < n; i++) a[i] = b[i] = i;
  if (a && b) count_known(n, a, b);
  for (int i = 0; a && b && i < n; i++) sum += b[i];
  printf("{\"vertices\": %d, \"sum\": %.17g}\n", n, sum);
  hb_free(a);
  hb_free(b);
  return sum == 0;
}

int main(int argc, char **argv) {
  if (argc == 1) {
    printf("{\"compiler\": \"%s-%d\", \"target\": \"%s\"}\n", COMPILER, MAJOR, TARGET);
    return 0;
  }
  if (argc == 3 && strcmp(argv[1], "known") == 0) return known(atoi(argv[2]));
  if (argc != 7) {
    fprintf(stderr, "usage: count_steps isotropic|general INTEGRATOR RODS VERTICES WARM STEPS\n");
    return 2;
  }
  cli_bench_case c = {.group = "count",
                      .integrator = argv[2],
                      .general = strcmp(argv[1], "general") == 0,
                      .rods = atoi(argv[3]),
                      .vertices = atoi(argv[4]),
                      .threads = 1};
  long warm = atol(argv[5]), steps = atol(argv[6]), vertices = 0;
  cli_bench_run run;
  hb_error err = {HB_OK, ""};
  hb_status status = cli_bench_start(&c, &run, &err);
  for (int r = 0; r < c.rods; r++) vertices += cli_bench_vertices(&c, r);
  for (long k = 0; !status && k < warm; k++) status = hb_sim_step(run.sim, &err);
  if (!status) {
    const double *scalar = hb_sim_const_state(run.sim)->scalar;
    double projections = scalar[HB_S_PROJECTIONS], twists = scalar[HB_S_TWIST_ITERATIONS];
    double rod_steps = (double)steps * c.rods;
    status = count_steps(run.sim, steps, &err);
    scalar = hb_sim_const_state(run.sim)->scalar;
    printf("{\"vertices\": %ld, \"projections\": %.17g, \"twist_iterations\": %.17g, \"memory\": %zu}\n",
           vertices, (scalar[HB_S_PROJECTIONS] - projections) / rod_steps,
           (scalar[HB_S_TWIST_ITERATIONS] - twists) / rod_steps, hb_sim_memory(run.sim));
  }
  if (status) fprintf(stderr, "count_steps: %s\n", err.text);
  cli_bench_stop(&run);
  return status ? 1 : 0;
}
