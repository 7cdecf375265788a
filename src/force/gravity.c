/* Weight: mass times an acceleration that may depend on time and place. */
#include "force/force.h"

#include "math/vec3.h"

/* Is it weight, and for this rod? */
static bool acts_on(const hb_force_def *def, const hb_rod *rod) {
  return def->kind == HB_FORCE_GRAVITY && hb_force_def_acts_on(def, rod->index);
}

/* Is there weight on this rod? */
static bool active(const hb_model *model, const hb_rod *rod) {
  for (int n = 0; n < rod->force_count; n++)
    if (acts_on(hb_rod_force_def(model, rod, n), rod)) return true;
  return false;
}

/* f += m g. */
static void add(const hb_model *model, const hb_rod *rod, double t, const double *x, const double *v,
                const double *m1, double *f) {
  (void)v;
  (void)m1;
  for (int entry = 0; entry < rod->force_count; entry++) {
    const hb_force_def *def = hb_rod_force_def(model, rod, entry);
    if (!acts_on(def, rod)) continue;
    hb_load_values values = hb_load_begin(def, t);
    for (int i = rod->first; i < rod->first + rod->nv; i++)
      hb_v3_accumulate(f + 3 * i, hb_v3_scale(model->mass[i], hb_load_at(&values, model, rod, i, x)));
  }
}

/* -m g.x where the field is the same everywhere. */
static double energy(const hb_model *model, const hb_rod *rod, double t, const double *x) {
  double sum = 0;
  for (int entry = 0; entry < rod->force_count; entry++) {
    const hb_force_def *def = hb_rod_force_def(model, rod, entry);
    hb_load_values values = hb_load_begin(def, t);
    if (!acts_on(def, rod) || !values.uniform) continue;
    for (int i = rod->first; i < rod->first + rod->nv; i++)
      sum -= model->mass[i] * hb_v3_dot(values.value, hb_v3_load(x + 3 * i));
  }
  return sum;
}

/* A field that is the same everywhere. */
static bool uniform(const hb_model *model, const hb_rod *rod, const hb_force_value *values,
                    hb_uniform_load *sum) {
  for (int entry = 0; entry < rod->force_count; entry++) {
    const int k = model->rod_forces[rod->first_force + entry];
    if (!acts_on(&model->def->forces[k], rod)) continue;
    if (!values[k].uniform) return false;
    hb_v3_accumulate(sum->acceleration, hb_v3_load(values[k].value));
  }
  return true;
}

const hb_force_term hb_force_gravity = {
    "gravity", "weight of every vertex in a field of acceleration", active, add, energy, false, false,
    uniform};
