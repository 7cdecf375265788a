/* One rod at one moment, in the order in which the theory builds it: geometry, frames, twist; then the force.
 */
#include "rod/rod.h"

#include "math/rotation.h"

/* Everything up to the twist in equilibrium. */
hb_status hb_rod_settle(const hb_model *model, const hb_rod *rod, hb_state *state, hb_rod_work *work,
                        double t, double h, hb_error *err) {
  if (!hb_rod_geometry(rod, state->x, work))
    return hb_fail(err, HB_ERR_NUMERIC, "rod %s: a vertex position is not finite, or an edge has length zero",
                   rod->name);
  hb_status status = hb_frames_check(model, rod, work, t, err);
  if (status) return status;
  hb_frames_hold(model, rod, state, work, t);
  if (!rod->closed_form) return hb_twist_newton(model, rod, state, work, h, err);
  if (!rod->twist_free) hb_twist_closed(model, rod, state, work, NULL);
  return HB_OK;
}

/* Half to each. */
void hb_rod_share_seam(const hb_rod *rod, double *f) {
  if (!rod->closed) return;
  double *a = f + 3 * (size_t)rod->first, *b = a + 3 * (size_t)(rod->nv - 1);
  for (int c = 0; c < 3; c++) a[c] = b[c] = 0.5 * (a[c] + b[c]);
}

/* Bending and twisting force on all vertices, torques on prescribed frames. */
void hb_rod_force(const hb_model *model, const hb_rod *rod, hb_state *state, hb_rod_work *work) {
  if (rod->closed_form)
    hb_elastic_closed(model, rod, state, work, state->force);
  else
    hb_elastic_general(model, rod, state, work, state->force);
  hb_stretch_force(model, rod, work, state->force);
  hb_rod_share_seam(rod, state->force);
  for (int k = rod->first_frame; k < rod->first_frame + rod->frame_count; k++)
    state->frame_torque[k] = hb_rod_frame_torque(model, rod, state, work, k);
}

/* dE/dtheta of a prescribed edge: what its support must hold. */
double hb_rod_frame_torque(const hb_model *model, const hb_rod *rod, const hb_state *state,
                           const hb_rod_work *work, int frame) {
  int edge = model->frames[frame].slot;
  if (!rod->closed_form) return work->gradient[edge - rod->first];
  double torque = 0;
  for (int s = rod->first_span; s < rod->first_span + rod->span_count; s++) {
    if (model->spans[s].last_edge == edge && model->spans[s].last_frame == frame) torque += state->moment[s];
    if (model->spans[s].first_edge == edge && model->spans[s].first_frame == frame)
      torque -= state->moment[s];
  }
  return torque;
}
