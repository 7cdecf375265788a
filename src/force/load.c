/* Point, distributed and per-vertex loads, fixed in space or turning with the rod. */
#include "force/force.h"

#include "math/rotation.h"

/* They may read the time, nothing else. */
bool hb_load_is_uniform(const hb_force_def *def) {
  for (int c = 0; c < 3; c++)
    for (int k = 0; k < HB_VAR_COUNT; k++)
      if (k != HB_VAR_T && def->value[c] && hb_formula_uses(def->value[c], (hb_variable)k)) return false;
  return true;
}

/* Evaluates what does not depend on the vertex. */
hb_load_values hb_load_begin(const hb_force_def *def, double t) {
  double vars[HB_VAR_COUNT] = {0}, out[3];
  vars[HB_VAR_T] = t;
  for (int c = 0; c < 3; c++) out[c] = def->value[c] ? hb_formula_eval(def->value[c], vars) : 0;
  return (hb_load_values){.def = def, .t = t, .uniform = hb_load_is_uniform(def), .value = hb_v3_load(out)};
}

/* The value at one vertex. */
hb_v3 hb_load_at(const hb_load_values *values, const hb_model *model, const hb_rod *rod, int i,
                 const double *x) {
  return values->uniform ? values->value : hb_load_if_at(values, model, rod, i, x + 3 * i);
}

/* The value at one vertex if it were at some place. */
hb_v3 hb_load_if_at(const hb_load_values *values, const hb_model *model, const hb_rod *rod, int i,
                    const double place[3]) {
  double vars[HB_VAR_COUNT] = {0}, out[3];
  vars[HB_VAR_T] = values->t;
  vars[HB_VAR_S] = model->arc[i];
  vars[HB_VAR_U] = model->arc[i] / rod->length;
  vars[HB_VAR_I] = i - rod->first;
  vars[HB_VAR_L] = rod->length;
  for (int c = 0; c < 3; c++) vars[HB_VAR_X + c] = place[c];
  for (int c = 0; c < 3; c++)
    out[c] = values->def->value[c] ? hb_formula_eval(values->def->value[c], vars) : 0;
  return hb_v3_load(out);
}

/* Is it a load of this file, and for this rod? */
static bool acts_on(const hb_force_def *def, const hb_rod *rod) {
  bool kind =
      def->kind == HB_FORCE_POINT || def->kind == HB_FORCE_DISTRIBUTED || def->kind == HB_FORCE_PER_VERTEX;
  return kind && hb_force_def_acts_on(def, rod->index);
}

/* Is there a load on this rod? */
static bool active(const hb_model *model, const hb_rod *rod) {
  for (int n = 0; n < rod->force_count; n++)
    if (acts_on(hb_rod_force_def(model, rod, n), rod)) return true;
  return false;
}

/* a t + b m1 + c m2 on the frame of edge j. */
static hb_v3 on_frame(hb_v3 a, int j, const double *x, const double *m1) {
  hb_v3 t = hb_v3_unit(hb_v3_sub(hb_v3_load(x + 3 * j + 3), hb_v3_load(x + 3 * j)));
  hb_v3 d1 = hb_v3_load(m1 + 3 * j), d2 = hb_v3_cross(t, d1);
  return hb_v3_axpy(hb_v3_axpy(hb_v3_scale(a.x, t), a.y, d1), a.z, d2);
}

/* A follower's components at vertex i turned into space: half with each neighbouring edge, all with the only
 * one. */
static hb_v3 follow(hb_v3 a, const hb_rod *rod, int i, const double *x, const double *m1) {
  int last = rod->first + rod->nv - 1;
  if (rod->closed && (i == rod->first || i == last))
    return hb_v3_scale(0.5, hb_v3_add(on_frame(a, last - 1, x, m1), on_frame(a, rod->first, x, m1)));
  if (i == rod->first) return on_frame(a, i, x, m1);
  if (i == last) return on_frame(a, i - 1, x, m1);
  return hb_v3_scale(0.5, hb_v3_add(on_frame(a, i - 1, x, m1), on_frame(a, i, x, m1)));
}

/* Half of a vertex gets half of the load. */
double hb_load_share(const hb_model *model, const hb_rod *rod, const hb_force_def *def, int i) {
  bool half = rod->closed && (i == rod->first || i == rod->first + rod->nv - 1);
  switch (def->kind) {
  case HB_FORCE_GRAVITY: return model->mass[i];
  case HB_FORCE_DISTRIBUTED: return model->weight[i];
  case HB_FORCE_PER_VERTEX: return half ? 0.5 : 1;
  default: return 1;
  }
}

/* Adds every load on the rod. */
static void add(const hb_model *model, const hb_rod *rod, double t, const double *x, const double *v,
                const double *m1, double *f) {
  (void)v;
  for (int entry = 0; entry < rod->force_count; entry++) {
    const hb_force_def *def = hb_rod_force_def(model, rod, entry);
    if (!acts_on(def, rod)) continue;
    hb_load_values values = hb_load_begin(def, t);
    int point = rod->first + (def->vertex < 0 ? def->vertex + rod->nv : def->vertex);
    int from = def->kind == HB_FORCE_POINT ? point : rod->first;
    int to = def->kind == HB_FORCE_POINT ? point + 1 : rod->first + rod->nv;
    for (int i = from; i < to; i++) {
      hb_v3 value = hb_load_at(&values, model, rod, i, x);
      if (def->follower) value = follow(value, rod, i, x, m1);
      double share = hb_load_share(model, rod, def, i);
      hb_v3_accumulate(f + 3 * i, hb_v3_scale(share, value));
    }
  }
}

/* Dead loads without places of their own. */
static bool uniform(const hb_model *model, const hb_rod *rod, const hb_force_value *values,
                    hb_uniform_load *sum) {
  for (int entry = 0; entry < rod->force_count; entry++) {
    const int k = model->rod_forces[rod->first_force + entry];
    const hb_force_def *def = &model->def->forces[k];
    if (!acts_on(def, rod)) continue;
    if (def->kind == HB_FORCE_POINT || def->follower || !values[k].uniform) return false;
    double *to = def->kind == HB_FORCE_DISTRIBUTED ? sum->per_length : sum->per_vertex;
    hb_v3_accumulate(to, hb_v3_load(values[k].value));
  }
  return true;
}

const hb_force_term hb_force_load = {
    "load", "point, distributed and per-vertex loads, dead or follower", active, add, NULL, false, false,
    uniform};
