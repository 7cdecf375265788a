/* Drag of a moving medium on the rod, split along and across the rod.
 *
 * With the relative velocity w = (velocity of the rod) - (velocity of the medium), its part along the local
 * tangent w_t and the rest w_n, the force per length is -(linear_n + quadratic_n |w_n|) w_n - (linear_t +
 * quadratic_t |w_t|) w_t: resistive-force theory in the linear terms, the cross-flow law of Taylor (1952) in
 * the quadratic ones. */
#include "force/force.h"

/* Is it a wind, and for this rod? */
static bool acts_on(const hb_force_def *def, const hb_rod *rod) {
  return def->kind == HB_FORCE_WIND && hb_force_def_acts_on(def, rod->index);
}

/* Is there a medium around this rod? */
static bool active(const hb_model *model, const hb_rod *rod) {
  for (int n = 0; n < rod->force_count; n++)
    if (acts_on(hb_rod_force_def(model, rod, n), rod)) return true;
  return false;
}

/* Tangent at a vertex: along its chord of neighbours. */
static hb_v3 vertex_tangent(const hb_rod *rod, int i, const double *x) {
  int last = rod->first + rod->nv - 1, a = i > rod->first ? i - 1 : i, b = i < last ? i + 1 : i;
  if (rod->closed && (i == rod->first || i == last)) {
    a = last - 1;
    b = rod->first + 1;
  }
  return hb_v3_unit(hb_v3_sub(hb_v3_load(x + 3 * b), hb_v3_load(x + 3 * a)));
}

/* Adds the drag. */
static void add(const hb_model *model, const hb_rod *rod, double t, const double *x, const double *v,
                const double *m1, double *f) {
  (void)m1;
  for (int entry = 0; entry < rod->force_count; entry++) {
    const hb_force_def *def = hb_rod_force_def(model, rod, entry);
    if (!acts_on(def, rod)) continue;
    hb_load_values values = hb_load_begin(def, t);
    double square[2];
    for (int c = 0; c < 2; c++) square[c] = hb_force_def_quadratic(def, &model->def->rods[rod->index], c);
    for (int i = rod->first; i < rod->first + rod->nv; i++) {
      hb_v3 w = hb_v3_sub(hb_v3_load(v + 3 * i), hb_load_at(&values, model, rod, i, x));
      hb_v3 tangent = vertex_tangent(rod, i, x);
      double along = hb_v3_dot(w, tangent);
      hb_v3 across = hb_v3_axpy(w, -along, tangent);
      double n = def->linear[0] + square[0] * hb_v3_norm(across);
      double a = (def->linear[1] + square[1] * fabs(along)) * along;
      hb_v3 force = hb_v3_axpy(hb_v3_scale(n, across), a, tangent);
      hb_v3_accumulate(f + 3 * i, hb_v3_scale(-model->weight[i], force));
    }
  }
}

/* One medium that moves as a whole; a second one would have a drag of its own. */
static bool uniform(const hb_model *model, const hb_rod *rod, const hb_force_value *values,
                    hb_uniform_load *sum) {
  int winds = 0;
  for (int entry = 0; entry < rod->force_count; entry++) {
    const int k = model->rod_forces[rod->first_force + entry];
    const hb_force_def *def = &model->def->forces[k];
    if (!acts_on(def, rod)) continue;
    if (!values[k].uniform || ++winds > 1) return false;
    hb_v3_store(sum->medium, hb_v3_load(values[k].value));
    for (int c = 0; c < 2; c++) {
      sum->linear[c] = def->linear[c];
      sum->quadratic[c] = hb_force_def_quadratic(def, &model->def->rods[rod->index], c);
    }
  }
  return true;
}

const hb_force_term hb_force_wind = {
    "wind", "linear and quadratic drag of a moving medium", active, add, NULL, true, false, uniform};
