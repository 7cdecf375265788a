/* Everything that can be measured on a state. Reads the state; writes workspace and the frame only. */
#include "sim/sim.h"

#include "base/memory.h"
#include "math/rotation.h"

#include <string.h>

/* Twist m_i of an interior vertex (slot k) in span s. */
static double twist_of(const hb_measure *probe, const hb_rod *rod, int s, int k) {
  const hb_model *m = probe->model;
  if (!rod->closed_form) return probe->state->twist[k];
  return m->rest_twist[k] + (m->twist_gain[k] > 0 ? probe->state->moment[s] / m->twist_gain[k] : 0);
}

/* Material angle of the first edge: the anchor's director against m1, windings from the state. */
static double first_angle(const hb_measure *probe, const hb_rod *rod, const double *m1) {
  const hb_state *state = probe->state;
  double expected = state->theta_0[rod->index];
  hb_v3 t = hb_v3_load(probe->rod_work->tangent);
  return hb_nearest_angle(hb_angle_about(hb_v3_load(state->anchor_m1 + 3 * rod->index), hb_v3_load(m1), t),
                          expected);
}

/* Directors, Bishop frame and material angle of every edge; twist and twisting moment of every vertex. */
static void measure_frames(hb_measure *probe, const hb_rod *rod, hb_frame *out) {
  const hb_model *m = probe->model;
  hb_rod_work *w = probe->rod_work;
  int o = rod->first, span = rod->first_span;
  hb_frames_now(m, rod, probe->state, w);
  if (rod->closed_form) hb_frames_closed(m, rod, probe->state, w);
  const double *m1 = rod->closed_form ? w->m1 : probe->state->m1 + 3 * o;
  double theta = first_angle(probe, rod, m1);
  hb_frames_bishop(rod, w, probe->state->anchor_m1 + 3 * rod->index, out->bishop_u + 3 * o);
  for (int j = 0; j <= rod->last_joint; j++) {
    int k = o + j;
    hb_v3 t = hb_v3_load(w->tangent + 3 * j), d = hb_v3_load(m1 + 3 * j),
          u = hb_v3_load(out->bishop_u + 3 * k);
    hb_v3_store(out->tangent + 3 * k, t);
    hb_v3_store(out->m1 + 3 * k, d);
    hb_v3_store(out->m2 + 3 * k, hb_v3_cross(t, d));
    hb_v3_store(out->bishop_v + 3 * k, hb_v3_cross(t, u));
    if (j > 0) {
      while (k > m->spans[span].last_edge) span++;
      double twist = twist_of(probe, rod, span, k);
      theta += twist;
      out->twist[k] = twist;
      out->twist_density[k] = 2 * twist / m->voronoi[k];
      out->twisting_moment[k] = m->twist_gain[k] * (twist - m->rest_twist[k]);
    }
    out->theta[k] = theta;
  }
}

/* The joint of a closed rod stands in the last slot; its vertex is also that of the first, and the two share
 * what is summed up. */
static void measure_seam(const hb_rod *rod, hb_frame *out) {
  int first = rod->first, last = rod->first + rod->nv - 1;
  if (!rod->closed) return;
  for (int c = 0; c < 3; c++) out->curvature_binormal[3 * first + c] = out->curvature_binormal[3 * last + c];
  for (int c = 0; c < 4; c++) out->omega[4 * first + c] = out->omega[4 * last + c];
  out->curvature[first] = out->curvature[last];
  out->twist_density[first] = out->twist_density[last];
  out->twisting_moment[first] = out->twisting_moment[last];
  out->energy_bending[first] = out->energy_bending[last] = 0.5 * out->energy_bending[last];
  out->energy_twisting[first] = out->energy_twisting[last] = 0.5 * out->energy_twisting[last];
}

/* Curvatures and elastic energies of the interior vertices. */
static void measure_elastic(const hb_measure *probe, const hb_rod *rod, hb_frame *out) {
  const hb_model *m = probe->model;
  for (int k = rod->first + 1; k <= rod->first + rod->last_joint; k++) {
    hb_v3 t = hb_v3_load(out->tangent + 3 * k - 3), n = hb_v3_load(out->tangent + 3 * k);
    hb_v3 kb = hb_v3_scale(2 / fmax(1 + hb_v3_dot(t, n), HB_FOLD_LIMIT), hb_v3_cross(t, n));
    double bending = 0;
    hb_v3_store(out->curvature_binormal + 3 * k, kb);
    out->curvature[k] = 2 * hb_v3_norm(kb) / m->voronoi[k];
    for (int side = 0; side < 2; side++) {
      int j = k - 1 + side;
      const double *B = m->B + 3 * j, *rest = m->rest_omega + 4 * k + 2 * side;
      double *omega = out->omega + 4 * k + 2 * side;
      omega[0] = hb_v3_dot(kb, hb_v3_load(out->m2 + 3 * j));
      omega[1] = -hb_v3_dot(kb, hb_v3_load(out->m1 + 3 * j));
      double a = omega[0] - rest[0], b = omega[1] - rest[1];
      bending += B[0] * a * a + 2 * B[1] * a * b + B[2] * b * b;
    }
    out->energy_bending[k] = 0.5 * bending / m->voronoi[k];
    out->energy_twisting[k] = 0.5 * out->twisting_moment[k] * (out->twist[k] - m->rest_twist[k]);
  }
  measure_seam(rod, out);
}

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

/* Tension of every edge at this instant and what supports must give. */
static void measure_forces(hb_measure *probe, const hb_rod *rod, hb_frame *out) {
  const hb_model *m = probe->model;
  const hb_state *state = probe->state;
  double *lambda = probe->lambda + rod->first;
  int o = rod->first;
  prescribed_accelerations(probe, rod, out);
  hb_project_tension(m, rod, state->x, state->v, state->force, probe->acceleration, lambda,
                     probe->project_work);
  hb_v3 before = {0, 0, 0};
  for (int j = 0; j < rod->nv; j++) {
    int k = o + j;
    hb_v3 pull = {0, 0, 0};
    if (j + 1 < rod->nv) {
      hb_v3 e = hb_v3_sub(hb_v3_load(state->x + 3 * k + 3), hb_v3_load(state->x + 3 * k));
      pull = hb_v3_scale(lambda[j] * 2 * m->inv_rest_length[k], e);
      out->tension[k] = lambda[j] * 2 * m->inv_rest_length[k] * hb_v3_norm(e);
    }
    double constraint[3];
    hb_v3_store(constraint, hb_v3_sub(pull, before));
    for (int c = 0; c < 3; c++)
      out->reaction[3 * k + c] = m->inv_mass[3 * k + c] != 0 ? 0
                                                             : m->mass[k] * probe->acceleration[3 * k + c] -
                                                                   state->force[3 * k + c] - constraint[c];
    before = pull;
  }
  for (int n = rod->first_frame; n < rod->first_frame + rod->frame_count; n++)
    out->torque[m->frames[n].slot] = state->frame_torque[n];
}

/* Kinetic energy, momenta, gravity, sums. */
static void measure_totals(hb_measure *probe, const hb_rod *rod, hb_frame *out) {
  const hb_model *m = probe->model;
  for (int k = rod->first; k < rod->first + rod->nv; k++) {
    hb_v3 x = hb_v3_load(out->position + 3 * k), v = hb_v3_load(out->velocity + 3 * k);
    hb_v3 p = hb_v3_scale(m->mass[k], v);
    out->energy_kinetic[k] = 0.5 * hb_v3_dot(p, v);
    out->kinetic += out->energy_kinetic[k];
    out->bending += out->energy_bending[k];
    out->twisting += out->energy_twisting[k];
    hb_v3_accumulate(out->momentum, p);
    hb_v3_accumulate(out->angular_momentum, hb_v3_cross(x, p));
  }
  for (int k = 0; hb_force_terms[k]; k++)
    if (hb_force_terms[k]->energy && hb_force_terms[k]->active(m, rod))
      out->gravity += hb_force_terms[k]->energy(m, rod, out->time, out->position);
}

/* All rods. */
void hb_measure_state(hb_measure *probe, const hb_state *state, hb_frame *frame) {
  const hb_model *m = probe->model;
  const double *scalar = state->scalar;
  probe->state = state;
  size_t bytes = 3 * (size_t)m->nv * sizeof(double);
  frame->time = scalar[HB_S_TIME];
  frame->step = (long)scalar[HB_S_STEP];
  frame->kinetic = frame->bending = frame->twisting = frame->gravity = frame->length_error = 0;
  memset(frame->momentum, 0, sizeof frame->momentum);
  memset(frame->angular_momentum, 0, sizeof frame->angular_momentum);
  memcpy(frame->position, state->x, bytes);
  memcpy(frame->velocity, state->v, bytes);
  for (int r = 0; r < m->rod_count; r++) {
    const hb_rod *rod = &m->rods[r];
    (void)hb_rod_geometry(rod, state->x, probe->rod_work);
    measure_frames(probe, rod, frame);
    measure_elastic(probe, rod, frame);
    measure_forces(probe, rod, frame);
    measure_totals(probe, rod, frame);
    frame->length_error = fmax(frame->length_error, hb_project_length_error(m, rod, state->x));
  }
  frame->work_loads = scalar[HB_S_WORK_LOADS];
  frame->work_supports = scalar[HB_S_WORK_SUPPORTS];
  frame->dissipated = scalar[HB_S_DISSIPATED];
  frame->worst_length_error = fmax(frame->length_error, scalar[HB_S_WORST_LENGTH]);
  frame->balance = frame->kinetic + frame->bending + frame->twisting - scalar[HB_S_ENERGY_START] -
                   frame->work_loads - frame->work_supports + frame->dissipated;
}

/* The simulation lends its workspaces. */
void hb_sim_measure(hb_sim *sim, hb_frame *frame) {
  hb_measure_state(&sim->measure, hb_sim_const_state(sim), frame);
}

/* What measuring needs beyond the workspaces of a rod. */
hb_status hb_measure_init(hb_measure *probe, const hb_model *model, hb_rod_work *rod_work,
                          hb_project_work *project_work, double *acceleration, double *lambda,
                          hb_error *err) {
  size_t nv = (size_t)model->nv;
  probe->model = model;
  probe->rod_work = rod_work;
  probe->project_work = project_work;
  probe->acceleration = acceleration;
  probe->lambda = lambda;
  if (acceleration) return HB_OK;
  probe->own = probe->acceleration = hb_alloc(4 * nv, sizeof *probe->own);
  if (!probe->own) return hb_fail_memory(err, "arrays for measuring");
  probe->lambda = probe->own + 3 * nv;
  return HB_OK;
}

/* Not the workspaces. */
void hb_measure_release(hb_measure *probe) { hb_free(probe->own); }

/* A measure that stands alone, with its workspaces beside it. */
typedef struct own_measure {
  hb_measure measure; /* first: the address of both is the same */
  hb_rod_work rod_work;
  hb_project_work project_work;
} own_measure;

/* Everything allocated here. */
hb_status hb_measure_create(const hb_model *model, hb_measure **out, hb_error *err) {
  *out = NULL;
  own_measure *own = hb_alloc(1, sizeof *own);
  if (!own) return hb_fail_memory(err, "arrays for measuring");
  hb_status status = hb_rod_work_create(model, &own->rod_work, err);
  if (!status) status = hb_project_work_create(model, &own->project_work, err);
  if (!status)
    status = hb_measure_init(&own->measure, model, &own->rod_work, &own->project_work, NULL, NULL, err);
  if (status)
    hb_measure_free(&own->measure);
  else
    *out = &own->measure;
  return status;
}

/* Only those that stand alone. */
void hb_measure_free(hb_measure *probe) {
  if (!probe) return;
  own_measure *own = (own_measure *)probe;
  hb_measure_release(probe);
  hb_project_work_free(&own->project_work);
  hb_rod_work_free(&own->rod_work);
  hb_free(own);
}
