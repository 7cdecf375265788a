/* Forces and moments that the rod and its supports bear (docs/theory, 9.2 and 9.5). */
#include "sim/measure.h"

#include "math/rotation.h"

#include <string.h>

/* Accelerations of prescribed vertices: difference of their exact velocities one time step before and after
 * (formulas are not asked about times before 0, where they need not mean anything). */
static void prescribed_accelerations(hb_measure *probe, const hb_rod *rod, hb_frame *out) {
  const hb_model *m = probe->model;
  double h = m->def->method.time_step, t = probe->state->scalar[HB_S_TIME], x[3];
  double t_before = t > h ? t - h : 0, inv = 1 / (t + h - t_before);
  double *after = probe->acceleration, *before = out->reaction; /* not measured yet */
  for (int n = rod->first_position; n < rod->first_position + rod->position_count; n++) {
    const hb_position_support *p = &m->positions[n];
    int base = p->tangent ? p->base : p->slot;
    hb_support_at(m, p, t + h, probe->state->x + 3 * base, after + 3 * base, x, after + 3 * p->slot);
    hb_support_at(m, p, t_before, probe->state->x + 3 * base, before + 3 * base, x, before + 3 * p->slot);
  }
  for (int n = rod->first_position; n < rod->first_position + rod->position_count; n++)
    for (int k = 3 * m->positions[n].slot; k < 3 * m->positions[n].slot + 3; k++)
      after[k] = inv * (after[k] - before[k]);
}

/* What a support gives to a prescribed vertex: what is missing in Newton's law. */
static void reaction_at(const hb_measure *probe, int k, const double constraint[3], double *reaction) {
  const hb_model *m = probe->model;
  for (int c = 0; c < 3; c++)
    reaction[c] = m->inv_mass[3 * k + c] != 0 ? 0
                                              : m->mass[k] * probe->acceleration[3 * k + c] -
                                                    probe->state->force[3 * k + c] - constraint[c];
}

/* Tension of an edge that is a spring; 0 where its length is kept. */
double hb_measure_spring(const hb_model *model, int k, const double *x) {
  if (!(model->stretching[k] > 0)) return 0;
  double length = hb_v3_norm(hb_v3_sub(hb_v3_load(x + 3 * k + 3), hb_v3_load(x + 3 * k)));
  return model->stretching[k] * (length * model->inv_rest_length[k] - 1);
}

/* Tension of every edge at this instant and what supports must give. */
static void measure_tension(hb_measure *probe, const hb_rod *rod, hb_frame *out) {
  const hb_model *m = probe->model;
  const hb_state *state = probe->state;
  double *lambda = probe->lambda + rod->first;
  bool reactions = probe->fields & HB_FIELD_BIT(reaction);
  prescribed_accelerations(probe, rod, out);
  hb_project_tension(m, rod, state->x, state->v, state->force, probe->acceleration, lambda,
                     probe->project_work);
  hb_v3 before = {0, 0, 0};
  for (int j = 0; j < rod->nv; j++) {
    int k = rod->first + j;
    hb_v3 pull = {0, 0, 0};
    if (j + 1 < rod->nv) {
      hb_v3 e = hb_v3_sub(hb_v3_load(state->x + 3 * k + 3), hb_v3_load(state->x + 3 * k));
      pull = hb_v3_scale(lambda[j] * 2 * m->inv_rest_length[k], e);
      out->tension[k] =
          lambda[j] * 2 * m->inv_rest_length[k] * hb_v3_norm(e) + hb_measure_spring(m, k, state->x);
    }
    double constraint[3];
    hb_v3_store(constraint, hb_v3_sub(pull, before));
    if (reactions) reaction_at(probe, k, constraint, out->reaction + 3 * k);
    before = pull;
  }
  if (reactions) hb_rod_share_seam(rod, out->reaction);
}

/* Moment of the bending of a vertex between unit tangents t and n: what its energy gains when all behind the
 * vertex turns, director and all, by a small rotation w is moment . w. q: gradients of the energy by the
 * binormal, from the frames of the two edges (docs/theory, 9.5). */
static hb_v3 bending_moment(hb_v3 t, hb_v3 n, hb_v3 kb, const hb_v3 q[2]) {
  hb_v3 sum = hb_v3_add(q[0], q[1]);
  double c = hb_v3_dot(t, n), inv = 1 / fmax(1 + c, HB_FOLD_LIMIT);
  hb_v3 moment = hb_v3_axpy(hb_v3_scale(2 * inv * c, sum), -2 * inv * hb_v3_dot(n, sum), t);
  moment = hb_v3_axpy(moment, -inv * hb_v3_dot(sum, kb), hb_v3_cross(n, t));
  return hb_v3_sub(moment, hb_v3_cross(kb, q[1]));
}

/* Gradients of the bending energy of interior vertex i (slot k) by its binormal, per edge's frame. */
static void bending_gradients(const hb_measure *probe, int i, int k, hb_v3 kb, hb_v3 q[2]) {
  const hb_model *m = probe->model;
  for (int side = 0; side < 2; side++) {
    int j = i - 1 + side;
    const double *B = m->B + 3 * (k - 1 + side), *rest = m->rest_omega + 4 * k + 2 * side;
    hb_v3 d1 = hb_v3_load(probe->m1 + 3 * j);
    hb_v3 d2 = hb_v3_cross(hb_v3_load(probe->rod_work->tangent + 3 * j), d1);
    double a = hb_v3_dot(kb, d2) - rest[0], b = -hb_v3_dot(kb, d1) - rest[1];
    hb_v3 g = hb_v3_scale((B[0] * a + B[1] * b) / m->voronoi[k], d2);
    q[side] = hb_v3_axpy(g, -(B[1] * a + B[2] * b) / m->voronoi[k], d1);
  }
}

/* Internal moments of the interior vertices. Where the rod is isotropic and straight at rest the moment of
 * bending is along the binormal. */
static void measure_moment(const hb_measure *probe, const hb_rod *rod, hb_frame *out) {
  const hb_model *m = probe->model;
  const double *tangent = probe->rod_work->tangent;
  for (int i = 1; i <= rod->last_joint; i++) {
    int k = rod->first + i;
    hb_v3 t = hb_v3_load(tangent + 3 * i - 3), n = hb_v3_load(tangent + 3 * i);
    double chi = 1 + hb_v3_dot(t, n), inv = 1 / (chi > HB_FOLD_LIMIT ? chi : HB_FOLD_LIMIT);
    hb_v3 kb = hb_v3_load(probe->kb + 3 * i), q[2], bending;
    if (rod->closed_form)
      bending = hb_v3_scale(0.5 * m->bend_gain[k] * inv, kb);
    else {
      bending_gradients(probe, i, k, kb, q);
      bending = bending_moment(t, n, kb, q);
    }
    hb_v3 axis = hb_v3_scale(inv, hb_v3_add(t, n));
    hb_v3 moment = hb_v3_axpy(bending, out->twisting_moment[k], axis);
    double along = hb_v3_dot(moment, axis) / hb_v3_dot(axis, axis);
    hb_v3_store(out->internal_moment + 3 * k, moment);
    out->bending_moment[k] = hb_v3_norm(hb_v3_axpy(moment, -along, axis));
  }
  if (!rod->closed) return;
  int first = rod->first, last = rod->first + rod->nv - 1;
  memcpy(out->internal_moment + 3 * first, out->internal_moment + 3 * last, 3 * sizeof(double));
  out->bending_moment[first] = out->bending_moment[last];
}

/* Along the edge the tension; across it what the moments at its ends ask for. Where a frame is prescribed
 * their difference along the edge is its torque. */
void hb_measure_internal_force(const hb_rod *rod, hb_frame *frame) {
  for (int k = rod->first; k + 1 < rod->first + rod->nv; k++) {
    hb_v3 e = hb_v3_sub(hb_v3_load(frame->position + 3 * k + 3), hb_v3_load(frame->position + 3 * k));
    double inv = 1 / hb_v3_norm(e);
    hb_v3 t = hb_v3_scale(inv, e);
    hb_v3 change =
        hb_v3_sub(hb_v3_load(frame->internal_moment + 3 * k), hb_v3_load(frame->internal_moment + 3 * k + 3));
    hb_v3 across = hb_v3_scale(inv, hb_v3_cross(change, t));
    hb_v3_store(frame->internal_force + 3 * k, hb_v3_axpy(across, frame->tension[k], t));
  }
}

/* Tension first: internal forces are made of it and of the moments. */
void hb_measure_forces(hb_measure *probe, const hb_rod *rod, hb_frame *out) {
  const uint64_t wanted = probe->fields;
  if (wanted & HB_FIELDS_OF_FORCES) measure_tension(probe, rod, out);
  if (wanted & HB_MEASURE_MOMENTS) measure_moment(probe, rod, out);
  if (wanted & HB_FIELD_BIT(internal_force)) hb_measure_internal_force(rod, out);
  for (int n = rod->first_frame; wanted & HB_FIELD_BIT(torque) && n < rod->first_frame + rod->frame_count;
       n++)
    out->torque[probe->model->frames[n].slot] = probe->state->frame_torque[n];
}
