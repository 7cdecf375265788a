/* The step, on one page. What it calls, in order, is in docs/develop/follow-one-step.md. */
#include "sim/sim.h"

#include <math.h>

/* Time, step count and length error after a step; not-a-number ends the run. */
static hb_status watch(hb_sim *sim, double h, hb_error *err) {
  hb_state *state = sim->state;
  state->scalar[HB_S_STEP] += 1;
  state->scalar[HB_S_TIME] = state->scalar[HB_S_STEP] * h;
  state->scalar[HB_S_LENGTH_ERROR] = sim->stepper.length_error;
  if (sim->stepper.length_error > state->scalar[HB_S_WORST_LENGTH])
    state->scalar[HB_S_WORST_LENGTH] = sim->stepper.length_error;
  for (int r = 0; r < sim->model->rod_count; r++) {
    int i = sim->model->rods[r].first;
    if (!isfinite(state->force[3 * i] + state->v[3 * i]))
      return hb_fail(err, HB_ERR_NUMERIC, "rod %s: the force or velocity is not finite any more", sim->model->rods[r].name);
  }
  return HB_OK;
}

/* One step of the model's time step. */
hb_status hb_sim_step(hb_sim *sim, hb_error *err) {
  double h = sim->model->def->method.time_step;
  long step = (long)sim->state->scalar[HB_S_STEP];
  hb_error inner = {HB_OK, ""};

  sim->stepper.timed = sim->time_every > 0 && step % sim->time_every == 0;
  sim->stepper.length_error = 0;
  sim->steps_timed += sim->stepper.timed;
  sim->steps_taken++;

  hb_status status = sim->integrator->step(&sim->stepper, h, &inner);
  if (!status) status = watch(sim, h, &inner);
  if (!status) return HB_OK;
  return hb_fail(err, status, "step %ld (t = %.9g): %s", step + 1, (double)(step + 1) * h, inner.text);
}
