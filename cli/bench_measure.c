/* Nanoseconds per vertex and step of a case, and how they stand against the machine. */
#include "base/clock.h"
#include "cli/bench.h"

#include <math.h>
#include <string.h>

/* One trial takes about this long, in seconds; short ones find moments in which nobody else has the core. */
#define TRIAL 1e-3
#define FEWEST_TRIALS 5

/* Seconds per step, and where they went. */
typedef struct timing {
  double step, stage[HB_STAGE_COUNT];
} timing;

/* What the stages took so far if the last `timed` steps were timed: the simulation scales it up to all steps.
 */
static void seconds_of_stages(const hb_sim *sim, long timed, double *seconds) {
  hb_sim_stage_seconds(sim, seconds);
  for (int k = 0; k < HB_STAGE_COUNT; k++)
    seconds[k] = timed ? seconds[k] * (double)timed / (double)hb_sim_steps(sim) : 0;
}

/* Times `block` steps. timed: steps in which the stages were timed before, and afterwards. */
static hb_status time_block(hb_sim *sim, long block, long *timed, timing *out, hb_error *err) {
  double before[HB_STAGE_COUNT];
  hb_status status = HB_OK;
  seconds_of_stages(sim, *timed, before);
  double started = hb_clock_now();
  for (long k = 0; !status && k < block; k++) status = hb_sim_step(sim, err);
  out->step = (hb_clock_now() - started) / (double)block;
  *timed += block;
  seconds_of_stages(sim, *timed, out->stage);
  for (int k = 0; k < HB_STAGE_COUNT; k++) out->stage[k] -= before[k];
  return status;
}

/* The best of many trials. */
static hb_status find_best(hb_sim *sim, long block, double seconds, timing *best, hb_error *err) {
  double until = hb_clock_now() + seconds;
  timing trial;
  long timed = 0;
  hb_status status = time_block(sim, block, &timed, best, err);
  for (int n = 1; !status && (n < FEWEST_TRIALS || hb_clock_now() < until); n++) {
    status = time_block(sim, block, &timed, &trial, err);
    if (trial.step < best->step) *best = trial;
  }
  return status;
}

/* Steps until the caches are warm and the first transient is over; how many make a trial. */
static hb_status warm_up(hb_sim *sim, double seconds, long *block, hb_error *err) {
  double started = hb_clock_now();
  long steps = 0;
  hb_status status = HB_OK;
  do {
    status = hb_sim_step(sim, err);
    steps++;
  } while (!status && hb_clock_now() < started + seconds);
  double per_step = (hb_clock_now() - started) / (double)steps;
  *block = per_step < TRIAL ? (long)(TRIAL / per_step) : 1;
  return status;
}

/* Shares of the stages, from steps that are all timed. */
static hb_status find_stages(hb_sim *sim, long block, double seconds, double *share, hb_error *err) {
  timing best;
  double sum = 0;
  hb_sim_time_stages(sim, 1);
  hb_status status = find_best(sim, block, seconds, &best, err);
  for (int k = 0; k < HB_STAGE_COUNT; k++) sum += best.stage[k];
  for (int k = 0; k < HB_STAGE_COUNT; k++) share[k] = best.stage[k] / (sum > 0 ? sum : 1);
  return status;
}

/* Measures one case. */
hb_status cli_bench_measure(const cli_bench_case *c, bool quick, cli_bench_result *out, hb_error *err) {
  cli_bench_run run;
  double budget = quick ? 0.08 : 0.6;
  timing best = {0};
  long block = 1;
  memset(out, 0, sizeof *out);
  for (int r = 0; r < c->rods; r++) out->vertices += cli_bench_vertices(c, r);
  hb_status status = cli_bench_start(c, &run, err);
  if (!status) status = warm_up(run.sim, 0.1 * budget, &block, err);
  if (!status) status = find_best(run.sim, block, budget, &best, err);
  if (!status) {
    const double *scalar = hb_sim_const_state(run.sim)->scalar;
    double rod_steps = scalar[HB_S_STEP] * c->rods;
    out->ns = 1e9 * best.step / (double)out->vertices;
    out->projections = scalar[HB_S_PROJECTIONS] / rod_steps;
    out->twist_iterations = scalar[HB_S_TWIST_ITERATIONS] / rod_steps;
    out->memory = (double)hb_sim_memory(run.sim) / (double)out->vertices;
    status = find_stages(run.sim, block, 0.4 * budget, out->stage, err);
  }
  cli_bench_stop(&run);
  return status;
}

/* What was counted of such rods: in double precision only. The single one needs other numbers of iterations.
 */
static const cli_bench_count *find_count(const cli_bench_case *c) {
  if (c->single) return NULL;
  for (int k = 0; k < cli_bench_count_rows; k++) {
    const cli_bench_count *row = &cli_bench_counts[k];
    if (row->general == c->general && row->many == (c->rods > 1) && !strcmp(row->integrator, c->integrator))
      return row;
  }
  return NULL;
}

/* Rates and shares. With several threads the peak is that of as many cores; bandwidth is that of one. */
cli_bench_rate cli_bench_compare(const cli_bench_case *c, const cli_bench_result *r,
                                 const cli_bench_machine *machine) {
  cli_bench_rate rate = {
      .count = find_count(c), .gflops = (double)NAN, .of_peak = (double)NAN, .level = CLI_BENCH_LEVELS - 1};
  double operations = 0, bytes = 0, held = r->memory * (double)r->vertices;
  rate.bytes = rate.gbytes = rate.of_bandwidth = (double)NAN;
  for (int level = CLI_BENCH_LEVELS - 2; level >= 0; level--)
    if (held <= (double)machine->size[level]) rate.level = level;
  /* What waits there is the way into the registers. The traffic was counted of rods that are far too large
   * for such a cache. */
  if (rate.level == 1 || held <= CLI_BENCH_COUNTED_CACHE) rate.level = 0;
  if (!rate.count) return rate;
  for (int k = 0; k <= HB_STAGE_COUNT; k++) {
    operations += rate.count->operations[k];
    bytes += rate.count->bytes[k];
  }
  rate.gflops = operations / r->ns;
  rate.of_peak = rate.gflops / (machine->fused[c->single] * (c->threads > 1 ? c->threads : 1));
  rate.bytes = (rate.level == 0 ? bytes : rate.count->traffic);
  rate.gbytes = rate.bytes / r->ns;
  rate.of_bandwidth = rate.gbytes / machine->bandwidth[rate.level];
  return rate;
}
