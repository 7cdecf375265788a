/* The step, on one page. What it calls, in order, is in docs/develop/follow-one-step.md. */
#include "sim/sim.h"

#include <math.h>

/* Every force and velocity is a number; one sum tells, and only if it is bad the vertex is looked for. */
static hb_status check_finite(const hb_sim *sim, hb_error *err) {
  const hb_state *state = sim->state;
  const hb_model *m = sim->model;
  double sum = 0;
  const hb_lane_plan *plan = sim->stepper.plan;
  for (int r = 0; r < m->rod_count; r++) {
    if (plan && plan->unit_of[r] >= 0) continue; /* lanes look after themselves */
    for (int k = 3 * m->rods[r].first; k < 3 * (m->rods[r].first + m->rods[r].nv); k++)
      sum += state->force[k] + state->v[k];
  }
  if (isfinite(sum) && sim->stepper.lanes_finite) return HB_OK;
  hb_stepper_store(sim->lane_owner);
  struct {
    const char *what;
    const double *values;
  } arrays[] = {
      {"load", state->load}, {"force", state->force}, {"velocity", state->v}}; /* causes before effects */
  for (size_t a = 0; a < sizeof arrays / sizeof arrays[0]; a++)
    for (int k = 0; k < 3 * m->nv; k++) {
      const hb_rod *rod = &m->rods[m->rod_of[k / 3]];
      int unit = sim->stepper.failed_unit; /* other rods may be some steps further on */
      if (!isfinite(arrays[a].values[k]) && (unit < 0 || plan->unit_of[rod->index] == unit))
        return hb_fail(err, HB_ERR_NUMERIC, "rod %s: the %s of vertex %d is not finite any more", rod->name,
                       arrays[a].what, k / 3 - rod->first);
    }
  if (!sim->stepper.lanes_finite)
    return hb_fail(err, HB_ERR_NUMERIC, "the forces and velocities of a rod are too big for numbers");
  return HB_OK;
}

/* Time, step count and length error after some steps; not-a-number ends the run. */
static hb_status watch(hb_sim *sim, double h, int steps, hb_error *err) {
  hb_state *state = sim->state;
  state->scalar[HB_S_STEP] += sim->stepper.lanes_finite ? steps : sim->stepper.failed_step + 1;
  state->scalar[HB_S_TIME] = state->scalar[HB_S_STEP] * h;
  state->scalar[HB_S_LENGTH_ERROR] = sim->stepper.length_error;
  if (sim->stepper.worst_error > state->scalar[HB_S_WORST_LENGTH])
    state->scalar[HB_S_WORST_LENGTH] = sim->stepper.worst_error;
  return check_finite(sim, err);
}

/* Some steps at once, at most HB_BLOCK_STEPS. Only a step that is taken alone is timed. */
static hb_status take_block(hb_sim *sim, int steps, hb_error *err) {
  double h = sim->model->def->method.time_step;
  long step = (long)sim->state->scalar[HB_S_STEP];
  hb_error inner = {HB_OK, ""};

  sim->stepper.block = steps;
  sim->stepper.timed = steps == 1 && sim->time_every > 0 && step % sim->time_every == 0;
  sim->steps_timed += sim->stepper.timed;
  sim->steps_taken += steps;

  hb_status status = sim->integrator->step(&sim->stepper, h, &inner);
  if (!status) status = watch(sim, h, steps, &inner);
  if (!status) return HB_OK;
  step += sim->stepper.failed_step + 1;
  return hb_fail(err, status, "step %ld (t = %.9g): %s", step, (double)step * h, inner.text);
}

/* One step. */
hb_status hb_sim_step(hb_sim *sim, hb_error *err) { return take_block(sim, 1, err); }

/* Several: in blocks that end where a step is to be timed. */
hb_status hb_sim_advance(hb_sim *sim, long count, hb_error *err) {
  bool blocks = hb_stepper_may_block(&sim->stepper);
  hb_status status = HB_OK;
  while (count > 0 && !status) {
    long step = (long)sim->state->scalar[HB_S_STEP], block = blocks ? count : 1;
    if (block > HB_BLOCK_STEPS) block = HB_BLOCK_STEPS;
    if (sim->time_every > 0) {
      long to_timed = sim->time_every - step % sim->time_every;
      if (step % sim->time_every == 0) to_timed = 1;
      if (block > to_timed) block = to_timed;
    }
    status = take_block(sim, (int)block, err);
    count -= block;
  }
  return status;
}
