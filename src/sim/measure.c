/* Everything that can be measured on a state. Reads the state; writes workspace and the frame only. Only what
 * was asked for is written; what all frames have, their scalars, is measured in the same way whatever that
 * is. */
#include "sim/measure.h"

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

/* (kappa b) between unit tangents. */
static hb_v3 binormal(hb_v3 t, hb_v3 n) {
  double chi = 1 + hb_v3_dot(t, n);
  return hb_v3_scale(2 / (chi > HB_FOLD_LIMIT ? chi : HB_FOLD_LIMIT), hb_v3_cross(t, n));
}

/* Tangents, binormals (kappa b), and the largest length error of the rod. */
static double measure_edges(hb_measure *probe, const hb_rod *rod) {
  const double *p = probe->state->x + 3 * (size_t)rod->first;
  const double *rest = probe->model->inv_rest_length + rod->first;
  hb_rod_work *w = probe->rod_work;
  hb_v3 before = {0, 0, 0};
  double worst = 0;
  for (int j = 0; j + 1 < rod->nv; j++, p += 3) {
    hb_v3 e = {p[3] - p[0], p[4] - p[1], p[5] - p[2]};
    double length = hb_v3_norm(e), inv = 1 / length, off = fabs(length * rest[j] - 1);
    hb_v3 t = hb_v3_scale(inv, e);
    worst = off > worst ? off : worst;
    w->inv_length[j] = inv;
    hb_v3_store(w->tangent + 3 * j, t);
    hb_v3_store(probe->kb + 3 * j, binormal(before, t));
    before = t;
  }
  if (rod->closed) { /* behind the last edge comes the first */
    w->inv_length[rod->nv - 1] = w->inv_length[0];
    memcpy(w->tangent + 3 * (rod->nv - 1), w->tangent, 3 * sizeof(double));
    hb_v3_store(probe->kb + 3 * (rod->nv - 1), binormal(before, hb_v3_load(w->tangent)));
  }
  return rod->extensible ? 0 : worst;
}

/* Strains and stretching energies; returns the sum of the energies. */
static double measure_stretching(const hb_measure *probe, const hb_rod *rod, hb_frame *out) {
  const uint64_t wanted = probe->fields;
  double sum = 0;
  if (!rod->extensible && !(wanted & (HB_FIELD_BIT(strain) | HB_FIELD_BIT(energy_stretching)))) return 0;
  for (int k = rod->first; k + 1 < rod->first + rod->nv; k++) {
    const hb_model *m = probe->model;
    double strain = hb_stretch_strain(m, k, probe->rod_work->inv_length[k - rod->first]);
    double energy = 0.5 * m->stretching[k] * strain * strain * m->rest_length[k];
    sum += energy;
    if (wanted & HB_FIELD_BIT(strain)) out->strain[k] = strain;
    if (wanted & HB_FIELD_BIT(energy_stretching)) out->energy_stretching[k] = energy;
  }
  return sum;
}

/* Material directors of all edges; those of closed-form rods are walked only where somebody looks. */
static void find_directors(hb_measure *probe, const hb_rod *rod) {
  const hb_model *m = probe->model;
  probe->m1 = probe->state->m1 + 3 * (size_t)rod->first;
  if (!rod->closed_form) return;
  probe->m1 = probe->rod_work->m1;
  if (!(probe->fields & HB_MEASURE_DIRECTORS)) return;
  hb_frames_now(m, rod, probe->state, probe->rod_work);
  hb_frames_closed(m, rod, probe->state, probe->rod_work);
}

/* Tangent, directors, Bishop frame and material angle of every edge. */
static void measure_frames(hb_measure *probe, const hb_rod *rod, hb_frame *out) {
  const double *tangent = probe->rod_work->tangent;
  const uint64_t wanted = probe->fields;
  const size_t seen = (size_t)(rod->last_joint + 1);
  int o = rod->first, span = rod->first_span;
  if (wanted & HB_FIELD_BIT(tangent))
    memcpy(out->tangent + 3 * (size_t)o, tangent, 3 * seen * sizeof(double));
  if (wanted & HB_FIELD_BIT(m1)) memcpy(out->m1 + 3 * (size_t)o, probe->m1, 3 * seen * sizeof(double));
  for (int j = 0; wanted & HB_FIELD_BIT(m2) && j <= rod->last_joint; j++)
    hb_v3_store(out->m2 + 3 * (o + j),
                hb_v3_cross(hb_v3_load(tangent + 3 * j), hb_v3_load(probe->m1 + 3 * j)));
  if (wanted & (HB_FIELD_BIT(bishop_u) | HB_FIELD_BIT(bishop_v))) {
    double *u = out->bishop_u + 3 * (size_t)o;
    hb_frames_bishop(rod, probe->rod_work, probe->state->anchor_m1 + 3 * rod->index, u);
    for (int j = 0; j <= rod->last_joint; j++)
      hb_v3_store(out->bishop_v + 3 * (o + j),
                  hb_v3_cross(hb_v3_load(tangent + 3 * j), hb_v3_load(u + 3 * j)));
  }
  if (!(wanted & HB_FIELD_BIT(theta))) return;
  double theta = out->theta[o] = first_angle(probe, rod, probe->m1);
  for (int k = o + 1; k <= o + rod->last_joint; k++) {
    while (k > probe->model->spans[span].last_edge) span++;
    out->theta[k] = theta += twist_of(probe, rod, span, k);
  }
}

/* Twist, twisting moment and twisting energy of the interior vertices; returns the sum of the energies. */
static double measure_twist(const hb_measure *probe, const hb_rod *rod, hb_frame *out) {
  const hb_model *m = probe->model;
  const bool any = probe->fields & HB_MEASURE_TWIST;
  double sum = 0;
  int span = rod->first_span;
  if (rod->twist_free && !any) return 0;
  for (int k = rod->first + 1; k <= rod->first + rod->last_joint; k++) {
    while (k > m->spans[span].last_edge) span++;
    double twist = twist_of(probe, rod, span, k), moment = m->twist_gain[k] * (twist - m->rest_twist[k]);
    double energy = 0.5 * moment * (twist - m->rest_twist[k]);
    sum += energy;
    if (!any) continue;
    out->twist[k] = twist;
    out->twist_density[k] = 2 * twist / m->voronoi[k];
    out->twisting_moment[k] = moment;
    out->energy_twisting[k] = energy;
  }
  return sum;
}

/* Material curvatures of interior vertex i. */
static void omega_at(const hb_measure *probe, int i, hb_v3 kb, double omega[4]) {
  for (int side = 0; side < 2; side++) {
    hb_v3 d1 = hb_v3_load(probe->m1 + 3 * (i - 1 + side));
    hb_v3 d2 = hb_v3_cross(hb_v3_load(probe->rod_work->tangent + 3 * (i - 1 + side)), d1);
    omega[2 * side] = hb_v3_dot(kb, d2);
    omega[2 * side + 1] = -hb_v3_dot(kb, d1);
  }
}

/* Bending energy of interior vertex i (slot k). Where the rod is isotropic and straight at rest it does not
 * depend on the directors: alpha |kb|^2/l. */
static double bending_at(const hb_measure *probe, const hb_rod *rod, int i, int k) {
  const hb_model *m = probe->model;
  hb_v3 kb = hb_v3_load(probe->kb + 3 * i);
  if (rod->closed_form) return 0.125 * m->bend_gain[k] * hb_v3_dot(kb, kb);
  double sum = 0, omega[4];
  omega_at(probe, i, kb, omega);
  for (int side = 0; side < 2; side++) {
    const double *B = m->B + 3 * (k - 1 + side), *rest = m->rest_omega + 4 * k + 2 * side;
    double a = omega[2 * side] - rest[0], b = omega[2 * side + 1] - rest[1];
    sum += B[0] * a * a + 2 * B[1] * a * b + B[2] * b * b;
  }
  return 0.5 * sum / m->voronoi[k];
}

/* Bending energies; returns their sum. */
static double measure_bending(const hb_measure *probe, const hb_rod *rod, hb_frame *out) {
  bool wanted = probe->fields & HB_FIELD_BIT(energy_bending);
  double sum = 0;
  for (int i = 1; i <= rod->last_joint; i++) {
    double energy = bending_at(probe, rod, i, rod->first + i);
    sum += energy;
    if (wanted) out->energy_bending[rod->first + i] = energy;
  }
  return sum;
}

/* Curvatures of the interior vertices. */
static void measure_curvature(const hb_measure *probe, const hb_rod *rod, hb_frame *out) {
  const uint64_t wanted = probe->fields;
  if (!(wanted & (HB_FIELD_BIT(curvature) | HB_FIELD_BIT(curvature_binormal) | HB_FIELD_BIT(omega)))) return;
  for (int i = 1; i <= rod->last_joint; i++) {
    int k = rod->first + i;
    hb_v3 kb = hb_v3_load(probe->kb + 3 * i);
    if (wanted & HB_FIELD_BIT(curvature)) out->curvature[k] = 2 * hb_v3_norm(kb) / probe->model->voronoi[k];
    if (wanted & HB_FIELD_BIT(curvature_binormal)) hb_v3_store(out->curvature_binormal + 3 * k, kb);
    if (wanted & HB_FIELD_BIT(omega)) omega_at(probe, i, kb, out->omega + 4 * k);
  }
}

/* The joint of a closed rod stands in the last slot; its vertex is also that of the first, and the two share
 * what is summed up. */
static void measure_seam(const hb_measure *probe, const hb_rod *rod, hb_frame *out) {
  const uint64_t wanted = probe->fields;
  int first = rod->first, last = rod->first + rod->nv - 1;
  if (!rod->closed) return;
  for (int c = 0; wanted & HB_FIELD_BIT(curvature_binormal) && c < 3; c++)
    out->curvature_binormal[3 * first + c] = out->curvature_binormal[3 * last + c];
  for (int c = 0; wanted & HB_FIELD_BIT(omega) && c < 4; c++)
    out->omega[4 * first + c] = out->omega[4 * last + c];
  if (wanted & HB_FIELD_BIT(curvature)) out->curvature[first] = out->curvature[last];
  if (wanted & HB_MEASURE_TWIST) {
    out->twist_density[first] = out->twist_density[last];
    out->twisting_moment[first] = out->twisting_moment[last];
    out->energy_twisting[first] = out->energy_twisting[last] = 0.5 * out->energy_twisting[last];
  }
  if (wanted & HB_FIELD_BIT(energy_bending))
    out->energy_bending[first] = out->energy_bending[last] = 0.5 * out->energy_bending[last];
}

/* Angle from the binormal of the edge's first vertex to that of its second, about the edge, per length. */
static void measure_torsion(const hb_measure *probe, const hb_rod *rod, hb_frame *out) {
  if (!(probe->fields & HB_FIELD_BIT(torsion)) || rod->nv < 4) return;
  /* the first joint of a closed rod is its last one */
  int first = rod->closed ? 0 : 1;
  hb_v3 before = hb_v3_load(probe->kb + 3 * (rod->closed ? rod->last_joint : 1));
  for (int j = first; j < rod->last_joint; j++) {
    hb_v3 after = hb_v3_load(probe->kb + 3 * j + 3), t = hb_v3_load(probe->rod_work->tangent + 3 * j);
    double least = fmin(hb_v3_dot(before, before), hb_v3_dot(after, after));
    double angle = least > HB_MEASURE_STRAIGHT
                       ? atan2(hb_v3_dot(t, hb_v3_cross(before, after)), hb_v3_dot(before, after))
                       : 0;
    out->torsion[rod->first + j] = angle * probe->model->inv_rest_length[rod->first + j];
    before = after;
  }
}

/* Kinetic energy and momenta. */
static void measure_motion(const hb_measure *probe, const hb_rod *rod, hb_frame *out) {
  const hb_model *m = probe->model;
  const hb_state *state = probe->state;
  bool wanted = probe->fields & HB_FIELD_BIT(energy_kinetic);
  double kinetic = 0;
  hb_v3 momentum = {0, 0, 0}, angular = {0, 0, 0};
  for (int k = rod->first; k < rod->first + rod->nv; k++) {
    hb_v3 v = hb_v3_load(state->v + 3 * k), p = hb_v3_scale(m->mass[k], v);
    double energy = 0.5 * hb_v3_dot(p, v);
    kinetic += energy;
    momentum = hb_v3_add(momentum, p);
    angular = hb_v3_add(angular, hb_v3_cross(hb_v3_load(state->x + 3 * k), p));
    if (wanted) out->energy_kinetic[k] = energy;
  }
  out->kinetic += kinetic;
  hb_v3_accumulate(out->momentum, momentum);
  hb_v3_accumulate(out->angular_momentum, angular);
}

/* Gravity's potential. */
static void measure_gravity(const hb_measure *probe, const hb_rod *rod, hb_frame *out) {
  for (int k = 0; hb_force_terms[k]; k++)
    if (hb_force_terms[k]->energy && hb_force_terms[k]->active(probe->model, rod))
      out->gravity += hb_force_terms[k]->energy(probe->model, rod, out->time, probe->state->x);
}

/* The frame before the rods add to it. */
static void begin(const hb_measure *probe, hb_frame *frame) {
  const hb_state *state = probe->state;
  size_t bytes = 3 * (size_t)probe->model->nv * sizeof(double);
  frame->fields = probe->fields;
  frame->time = state->scalar[HB_S_TIME];
  frame->step = (long)state->scalar[HB_S_STEP];
  frame->kinetic = frame->bending = frame->twisting = frame->stretching = frame->gravity = 0;
  frame->length_error = 0;
  memset(frame->momentum, 0, sizeof frame->momentum);
  memset(frame->angular_momentum, 0, sizeof frame->angular_momentum);
  if (probe->fields & (HB_FIELD_BIT(position) | HB_FIELD_BIT(internal_force)))
    memcpy(frame->position, state->x, bytes);
  if (probe->fields & HB_FIELD_BIT(velocity)) memcpy(frame->velocity, state->v, bytes);
}

/* All rods. */
void hb_measure_state(hb_measure *probe, const hb_state *state, hb_frame *frame) {
  const hb_model *m = probe->model;
  const double *scalar = state->scalar;
  probe->state = state;
  begin(probe, frame);
  for (int r = 0; r < m->rod_count; r++) {
    const hb_rod *rod = &m->rods[r];
    frame->length_error = fmax(frame->length_error, measure_edges(probe, rod));
    find_directors(probe, rod);
    frame->bending += measure_bending(probe, rod, frame);
    frame->twisting += measure_twist(probe, rod, frame);
    frame->stretching += measure_stretching(probe, rod, frame);
    measure_frames(probe, rod, frame);
    measure_curvature(probe, rod, frame);
    measure_torsion(probe, rod, frame);
    measure_seam(probe, rod, frame);
    hb_measure_forces(probe, rod, frame);
    measure_motion(probe, rod, frame);
    measure_gravity(probe, rod, frame);
  }
  frame->work_loads = scalar[HB_S_WORK_LOADS];
  frame->work_supports = scalar[HB_S_WORK_SUPPORTS];
  frame->dissipated = scalar[HB_S_DISSIPATED];
  frame->worst_length_error = fmax(frame->length_error, scalar[HB_S_WORST_LENGTH]);
  double energy = frame->kinetic + frame->bending + frame->twisting + frame->stretching;
  frame->balance =
      energy - scalar[HB_S_ENERGY_START] - frame->work_loads - frame->work_supports + frame->dissipated;
}

/* The simulation lends its workspaces. */
void hb_sim_measure(hb_sim *sim, hb_frame *frame) {
  hb_measure_state(&sim->measure, hb_sim_const_state(sim), frame);
}

/* Fields that hang together are measured together. */
void hb_measure_choose(hb_measure *probe, uint64_t fields) { probe->fields = fields & HB_FIELDS_ALL; }

/* What measuring needs beyond the workspaces of a rod. */
hb_status hb_measure_init(hb_measure *probe, const hb_model *model, hb_rod_work *rod_work,
                          hb_project_work *project_work, double *const borrowed[3], hb_error *err) {
  size_t nv = (size_t)model->nv;
  probe->model = model;
  probe->fields = HB_FIELDS_ALL;
  probe->rod_work = rod_work;
  probe->project_work = project_work;
  if (!borrowed) probe->own = hb_alloc(7 * nv, sizeof *probe->own);
  if (!borrowed && !probe->own) return hb_fail_memory(err, "arrays for measuring");
  probe->acceleration = borrowed ? borrowed[0] : probe->own;
  probe->kb = borrowed ? borrowed[1] : probe->own + 3 * nv;
  probe->lambda = borrowed ? borrowed[2] : probe->own + 6 * nv;
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
  if (!status) status = hb_measure_init(&own->measure, model, &own->rod_work, &own->project_work, NULL, err);
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
