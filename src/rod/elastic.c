/* Bending and twisting forces, one pass over the vertices (docs/theory, 5).
 *
 * The energy depends on the edges; with q^j the force on edge vector e^j (minus dE/de^j, plus what the
 * turning of the Bishop frame does), vertex i feels q^{i-1} - q^i. The twist is in equilibrium, so its own
 * variation drops out and each interior vertex contributes only its twisting moment times the gradient of its
 * holonomy. */
#include "rod/rod.h"

#include "math/rotation.h"

/* Adds the stress q to edge j: pulls vertex j+1 along q and vertex j against it. */
static inline void pull_edge(double *f, int j, hb_v3 q) {
  f[3 * j] -= q.x;
  f[3 * j + 1] -= q.y;
  f[3 * j + 2] -= q.z;
  f[3 * j + 3] = q.x;
  f[3 * j + 4] = q.y;
  f[3 * j + 5] = q.z;
}

/* Isotropic and straight at rest. With c = t.t', chi = 1 + c: E = alpha |kb|^2/l = 4 alpha (1-c)/(l chi),
 * hence -dE/de = 8 alpha/(l chi^2) (t' - c t)/|e| and the same with the edges exchanged; d psi/de = -(t x
 * t')/(chi |e|). */
static void closed_span(const hb_model *m, int o, int a, int b, double moment, hb_rod_work *w, hb_v3 *carry,
                        double *f) {
  double lowest = w->lowest_chi;
  hb_v3 t = hb_v3_load(w->tangent + 3 * a);
  for (int i = a + 1; i <= b; i++) {
    hb_v3 n = hb_v3_load(w->tangent + 3 * i), x = hb_v3_cross(t, n);
    double c = hb_v3_dot(t, n), chi = 1 + c;
    lowest = chi < lowest ? chi : lowest;
    chi = chi > HB_FOLD_LIMIT ? chi : HB_FOLD_LIMIT;
    double inv = 1 / chi, k = m->bend_gain[o + i] * (inv * inv), g = moment * inv;
    double k0 = k * w->inv_length[i - 1], k1 = k * w->inv_length[i], g0 = g * w->inv_length[i - 1],
           g1 = g * w->inv_length[i];
    hb_v3 q0 = {k0 * (n.x - c * t.x) - g0 * x.x, k0 * (n.y - c * t.y) - g0 * x.y,
                k0 * (n.z - c * t.z) - g0 * x.z};
    pull_edge(f, i - 1, hb_v3_add(*carry, q0));
    *carry = (hb_v3){k1 * (t.x - c * n.x) - g1 * x.x, k1 * (t.y - c * n.y) - g1 * x.y,
                     k1 * (t.z - c * n.z) - g1 * x.z};
    t = n;
  }
  w->lowest_chi = lowest;
}

/* The stress on the last edge; of a closed rod it is that on its first edge, from the joint with the last. */
static void pull_last(const hb_rod *rod, double *own, hb_v3 q) {
  if (!rod->closed) {
    pull_edge(own, rod->nv - 2, q);
    return;
  }
  hb_v3_accumulate(own, hb_v3_scale(-1, q));
  hb_v3_accumulate(own + 3, q);
}

/* Span by span, each with its own moment. */
void hb_elastic_closed(const hb_model *model, const hb_rod *rod, const hb_state *state, hb_rod_work *work,
                       double *f) {
  int o = rod->first;
  double *own = f + 3 * (size_t)o;
  hb_v3 carry = {0, 0, 0};
  own[0] = own[1] = own[2] = 0;
  work->lowest_chi = 2;
  for (int s = rod->first_span; s < rod->first_span + rod->span_count; s++)
    closed_span(model, o, model->spans[s].first_edge - o, model->spans[s].last_edge - o, state->moment[s],
                work, &carry, own);
  pull_last(rod, own, carry);
}

/* General rods: g = dE/d(kb) at fixed material angle, then the gradient of kb = 2 t x t'/chi by the edges. */
void hb_elastic_general(const hb_model *model, const hb_rod *rod, const hb_state *state, hb_rod_work *w,
                        double *f) {
  int o = rod->first;
  double *own = f + 3 * (size_t)o;
  const double *m1 = state->m1 + 3 * (size_t)o;
  hb_v3 carry = {0, 0, 0}, t = hb_v3_load(w->tangent);
  own[0] = own[1] = own[2] = 0;
  w->lowest_chi = 2;
  for (int i = 1; i <= rod->last_joint; i++) {
    hb_v3 n = hb_v3_load(w->tangent + 3 * i), kb = hb_v3_load(w->kb + 3 * i), g = {0, 0, 0};
    const double *b = w->stress + 4 * i;
    double inv_l = 1 / model->voronoi[o + i], chi = 1 + hb_v3_dot(t, n);
    double inv = 1 / (chi > HB_FOLD_LIMIT ? chi : HB_FOLD_LIMIT);
    if (chi < w->lowest_chi) w->lowest_chi = chi;
    for (int side = 0; side < 2; side++) {
      hb_v3 d1 = hb_v3_load(m1 + 3 * (i - 1 + side)), d2 = hb_v3_cross(side ? n : t, d1);
      g = hb_v3_axpy(g, inv_l * b[2 * side], d2);
      g = hb_v3_axpy(g, -inv_l * b[2 * side + 1], d1);
    }
    double along = hb_v3_dot(g, kb), half_moment = 0.5 * w->moment[i];
    hb_v3 sum = hb_v3_scale(along * inv, hb_v3_add(t, n));
    hb_v3 r0 = hb_v3_axpy(hb_v3_axpy(sum, -2 * inv, hb_v3_cross(n, g)), -half_moment, kb);
    hb_v3 r1 = hb_v3_axpy(hb_v3_axpy(sum, 2 * inv, hb_v3_cross(t, g)), -half_moment, kb);
    pull_edge(own, i - 1, hb_v3_axpy(carry, w->inv_length[i - 1], r0));
    carry = hb_v3_scale(w->inv_length[i], r1);
    t = n;
  }
  pull_last(rod, own, carry);
}

/* What viscosity took over the step just done, with the mean rates of material curvature (second order), and
 * the new history. */
double hb_elastic_commit(const hb_model *m, const hb_rod *rod, hb_state *state, const hb_rod_work *w,
                         double h) {
  double lost = 0;
  if (!m->def->rods[rod->index].viscosity) return 0;
  for (int i = 1; i <= rod->last_joint; i++) {
    int k = rod->first + i;
    double inv_l = 1 / m->voronoi[k];
    for (int c = 0; c < 4; c++) {
      double now = w->omega[4 * i + c], *past = &state->omega_1[4 * k + c],
             *older = &state->omega_2[4 * k + c];
      double change = now - *past;
      lost += inv_l * m->viscosity[k - 1 + c / 2] * change * change / h;
      *older = *past;
      *past = now;
    }
  }
  return lost;
}
