/* How loads change with velocity, for implicit steps. */
#include "force/force.h"

/* Adds factor (p I + q d d^T). */
static void add_axis(double *out, double factor, double p, double q, hb_v3 d) {
  const double *v = &d.x;
  for (int r = 0; r < 3; r++)
    for (int c = 0; c < 3; c++) out[3 * r + c] += factor * ((r == c ? p : 0) + q * v[r] * v[c]);
}

/* One wind on one vertex: minus the derivative of the force by the velocity, at the tangent as it is. With
 * the relative velocity w split along and across the tangent t, the force per length has the slopes
 * (linear_n + quadratic_n |w_n|)(I - t t^T) + quadratic_n w_n w_n^T/|w_n| across and (linear_t + 2
 * quadratic_t |w_t|) t t^T along: symmetric and positive. */
static void add_wind(const hb_force_def *def, const double square[2], double weight, hb_v3 w, hb_v3 t,
                     double *out) {
  double along = hb_v3_dot(w, t);
  hb_v3 across = hb_v3_axpy(w, -along, t);
  double size = hb_v3_norm(across), n = def->linear[0] + square[0] * size;
  add_axis(out, weight, n, def->linear[1] + 2 * square[1] * fabs(along) - n, t);
  if (size > 0) add_axis(out, weight * square[0] / size, 0, 1, across);
}

/* Tangent at a vertex: along its chord of neighbours, as the wind takes it. */
static hb_v3 vertex_tangent(const hb_rod *rod, int i, const double *x) {
  int a = i > rod->first ? i - 1 : i, b = i + 1 < rod->first + rod->nv ? i + 1 : i;
  return hb_v3_unit(hb_v3_sub(hb_v3_load(x + 3 * b), hb_v3_load(x + 3 * a)));
}

/* Mass damping, and every wind. */
bool hb_load_drag(const hb_model *model, const hb_rod *rod, double t, const double *x, const double *v,
                  double *out) {
  const hb_rod_def *own = &model->def->rods[rod->index];
  bool any = own->mass_damping > 0;
  for (int k = 0; k < 9 * rod->nv; k++) out[k] = 0;
  for (int i = 0; any && i < rod->nv; i++)
    for (int c = 0; c < 3; c++) out[9 * i + 4 * c] = own->mass_damping * model->mass[rod->first + i];
  for (int k = 0; k < model->def->force_count; k++) {
    const hb_force_def *def = &model->def->forces[k];
    if (def->kind != HB_FORCE_WIND || !hb_force_def_acts_on(def, rod->index)) continue;
    hb_load_values values = hb_load_begin(def, t);
    double square[2];
    for (int c = 0; c < 2; c++) square[c] = hb_force_def_quadratic(def, own, c);
    for (int i = rod->first; i < rod->first + rod->nv; i++) {
      hb_v3 w = hb_v3_sub(hb_v3_load(v + 3 * i), hb_load_at(&values, model, rod, i, x));
      add_wind(def, square, model->weight[i], w, vertex_tangent(rod, i, x), out + 9 * (i - rod->first));
    }
    any = true;
  }
  return any;
}
