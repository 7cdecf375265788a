/* Constrained velocity Verlet: half kick, drift, lengths along the old gradient (SHAKE), force, half kick,
 * velocities made tangent (RATTLE; Andersen 1983). Second order, time-symmetric, exact in both momenta.
 *
 * Forces that depend on velocity are taken at 2 v(n+1/2) - v(n), which is v(n+1) to second order. */
#include "time/integrators.h"

/* Extrapolates the velocities to the end of the step, where loads depend on velocity. */
static const double *predicted_velocities(hb_stepper *s, const hb_rod *rod) {
  size_t from = 3 * (size_t)rod->first, to = from + 3 * (size_t)rod->nv;
  for (size_t k = from; k < to; k++) s->v_predicted[k] = 2 * s->state->v[k] - s->v_old[k];
  return s->v_predicted;
}

/* Half kick and drift to the end of the step, supports in their places. */
static void move(hb_stepper *s, const hb_rod *rod, double t, double h) {
  hb_stepper_kick_drift(s, rod, 0.5 * h, h);
  hb_stepper_place(s, rod, t, h, false);
}

/* Lengths along the old gradient. Where a rod is taut and straight that gradient has no part across the rod,
 * and supports that come closer leave it no solution: then once more with the gradient that follows the
 * iterate. Such steps are counted; they are first order. */
static hb_status fit_lengths(hb_stepper *s, const hb_rod *rod, double t, double h, hb_error *err) {
  hb_status status = hb_stepper_project(s, rod, h, true, err);
  if (status != HB_ERR_NUMERIC) return status;
  hb_stepper_undo(s, rod);
  move(s, rod, t, h);
  s->state->scalar[HB_S_FALLBACKS]++;
  status = hb_stepper_project(s, rod, h, false, err);
  if (!status) hb_stepper_find_pull(s, rod, h, 0.5 * h);
  return status;
}

/* One rod. */
static hb_status step_rod(hb_stepper *s, const hb_rod *rod, double t, double h, hb_error *err) {
  hb_stepper_begin(s);
  hb_stepper_keep(s, rod);
  move(s, rod, t, h);
  hb_stepper_end(s, HB_STAGE_MOVE);
  hb_status status = fit_lengths(s, rod, t, h, err);
  if (status) return status;
  hb_stepper_end(s, HB_STAGE_PROJECT);
  hb_stepper_book_work(s, rod, h);
  const double *v = s->rates[rod->index] ? predicted_velocities(s, rod) : s->state->v;
  status = hb_stepper_evaluate(s, rod, t, v, h, err);
  if (status) return status;
  hb_stepper_book_work(s, rod, h);
  hb_stepper_begin(s);
  hb_stepper_kick(s, rod, 0.5 * h);
  hb_stepper_place(s, rod, t, h, true);
  hb_stepper_end(s, HB_STAGE_MOVE);
  hb_project_velocities(s->model, rod, s->state->x, s->state->v, &s->project_work);
  hb_stepper_end(s, HB_STAGE_PROJECT);
  hb_stepper_book_supports(s, rod, h, true);
  s->state->scalar[HB_S_DISSIPATED] += hb_elastic_commit(s->model, rod, s->state, &s->rod_work, h);
  return HB_OK;
}

/* All rods. */
static hb_status step(hb_stepper *s, double h, hb_error *err) {
  const hb_scheme scheme = {step_rod, hb_lane_step_verlet};
  return hb_step_rods(s, h, &scheme, err);
}

const hb_integrator hb_integrator_verlet = {
    "verlet", "constrained velocity Verlet (SHAKE and RATTLE), second order and time-symmetric",
    2,        true,
    false,    step};
