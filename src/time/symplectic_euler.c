/* Symplectic Euler with fast projection, as the thesis prints it (chapter 2): first order.
 *
 *   v* = v + h M^-1 f(x),  x* = x + h v*,  project x* onto the lengths,  v = (projected x - x)/h.
 * The velocity is corrected by what the projection moved, over h: the same, without cancellation. */
#include "time/integrators.h"

/* One rod. */
static hb_status step_rod(hb_stepper *s, const hb_rod *rod, double t, double h, hb_error *err) {
  hb_stepper_begin(s);
  hb_stepper_keep(s, rod);
  hb_stepper_kick_drift(s, rod, h, h);
  hb_stepper_place(s, rod, t, h, false);
  hb_stepper_end(s, HB_STAGE_MOVE);
  hb_status status = hb_stepper_project(s, rod, h, false, err);
  if (status) return status;
  hb_stepper_find_pull(s, rod, h, h);
  hb_stepper_end(s, HB_STAGE_PROJECT);
  hb_stepper_book_work(s, rod, h);
  status = hb_stepper_evaluate(s, rod, t, s->state->v, h, err);
  if (status) return status;
  hb_stepper_book_work(s, rod, h);
  hb_stepper_book_supports(s, rod, h, false);
  s->state->scalar[HB_S_DISSIPATED] += hb_elastic_commit(s->model, rod, s->state, &s->rod_work, h);
  return HB_OK;
}

/* All rods. */
static hb_status step(hb_stepper *s, double h, hb_error *err) {
  const hb_scheme scheme = {step_rod, hb_lane_step_euler};
  return hb_step_rods(s, h, &scheme, err);
}

const hb_integrator hb_integrator_symplectic_euler = {
    "symplectic-euler",
    "symplectic Euler with fast projection (Goldenthal et al. 2007), as in the thesis",
    1,
    false,
    false,
    step};
