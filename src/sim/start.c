/* The initial state: shape made to fit the lengths, frames, relaxed twist, first forces. */
#include "sim/sim.h"

#include "math/vec3.h"

#include <string.h>

/* Positions and velocities as the scene gives them, supports in their places at time 0. */
static void place(hb_sim *sim) {
  const hb_model *m = sim->model;
  memcpy(sim->state->x, m->initial, 3 * (size_t)m->nv * sizeof(double));
  for (int r = 0; r < m->rod_count; r++) {
    const hb_rod *rod = &m->rods[r];
    const double *v = m->def->rods[r].velocity;
    if (v) memcpy(sim->state->v + 3 * rod->first, v, 3 * (size_t)rod->nv * sizeof(double));
    hb_stepper_place(&sim->stepper, rod, 0, 1, true);
  }
}

/* Moves the free vertices onto the lengths; how far is remembered. */
static hb_status fit_lengths(hb_sim *sim, const hb_rod *rod, hb_error *err) {
  hb_projection p;
  hb_error inner = {HB_OK, ""};
  double *scratch = sim->stepper.v_predicted; /* takes the velocity that the correction would amount to */
  hb_status status = hb_project_positions(sim->model, rod, sim->state->x, scratch, 1, NULL, NULL,
                                          &sim->stepper.project_work, &p, &inner);
  if (status)
    return hb_fail(err, HB_ERR_INPUT, "the initial shape cannot be made to fit the rest lengths: %s",
                   inner.text);
  for (int i = rod->first; i < rod->first + rod->nv; i++) {
    hb_v3 moved = hb_v3_sub(hb_v3_load(sim->state->x + 3 * i), hb_v3_load(sim->model->initial + 3 * i));
    sim->initial_correction = fmax(sim->initial_correction, hb_v3_norm(moved));
  }
  return HB_OK;
}

/* Frames, twist, force of one rod. */
static hb_status start_rod(hb_sim *sim, const hb_rod *rod, hb_error *err) {
  hb_state *state = sim->state;
  hb_stepper *s = &sim->stepper;
  hb_status status = fit_lengths(sim, rod, err);
  if (status) return status;
  hb_project_velocities(sim->model, rod, state->x, state->v, &s->project_work);
  if (!hb_rod_geometry(rod, state->x, &s->rod_work))
    return hb_fail(err, HB_ERR_INPUT, "rod %s: the initial shape has an edge of length zero", rod->name);
  status = hb_frames_check(sim->model, rod, &s->rod_work, 0, err);
  if (status) return status;
  hb_frames_start(sim->model, rod, state, &s->rod_work);
  if (!rod->closed_form) {
    if (rod->frame_count == 0) hb_twist_scan(sim->model, rod, state, &s->rod_work);
    status = hb_twist_relax(sim->model, rod, state, &s->rod_work, err);
    for (int k = 4 * rod->first; !status && sim->model->any_viscosity && k < 4 * (rod->first + rod->nv); k++)
      state->omega_1[k] = state->omega_2[k] = s->rod_work.omega[k - 4 * rod->first];
  }
  if (!status) status = hb_stepper_evaluate(s, rod, 0, state->v, 0, err);
  return status;
}

/* Kinetic, bending and twisting energy at the start, for the balance. */
hb_status hb_sim_start(hb_sim *sim, hb_error *err) {
  place(sim);
  for (int r = 0; r < sim->model->rod_count; r++) {
    hb_status status = start_rod(sim, &sim->model->rods[r], err);
    if (status) return status;
  }
  sim->state->scalar[HB_S_FOLD_SLOT] = -1;
  sim->state->scalar[HB_S_FOLDS] = 0;
  sim->state->scalar[HB_S_PROJECTIONS] = sim->state->scalar[HB_S_TWIST_ITERATIONS] = 0;
  hb_frame *frame = NULL;
  hb_status status = hb_frame_create(sim->model, &frame, err);
  if (status) return status;
  hb_sim_measure(sim, frame);
  sim->state->scalar[HB_S_ENERGY_START] =
      frame->kinetic + frame->bending + frame->twisting + frame->stretching;
  hb_frame_free(frame);
  return HB_OK;
}
