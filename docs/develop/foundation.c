/* Springs in the ground: every piece of the rod is drawn to its initial place, in proportion to its length.
 *
 * With stiffness k per length of rod, one for each axis: F_i = -w_i k (x_i - initial x_i), the elastic
 * foundation of Winkler (1867). */
#include "force/force.h"

/* Is this entry of forces a foundation under the rod? */
static bool acts_on(const hb_force_def *def, const hb_rod *rod) {
  return def->kind == HB_FORCE_FOUNDATION && hb_force_def_acts_on(def, rod->index);
}

/* Does this rod lie on springs? */
static bool active(const hb_model *model, const hb_rod *rod) {
  for (int k = 0; k < model->def->force_count; k++)
    if (acts_on(&model->def->forces[k], rod)) return true;
  return false;
}

/* Force on vertex slot i, from its present place. */
static hb_v3 pull(const hb_model *model, hb_v3 stiffness, int i, const double *x) {
  hb_v3 away = hb_v3_sub(hb_v3_load(x + 3 * i), hb_v3_load(model->initial + 3 * i));
  double w = model->weight[i];
  return (hb_v3){-w * stiffness.x * away.x, -w * stiffness.y * away.y, -w * stiffness.z * away.z};
}

/* Adds the springs' force. */
static void add(const hb_model *model, const hb_rod *rod, double t, const double *x, const double *v,
                const double *m1, double *f) {
  (void)v;
  (void)m1;
  for (int k = 0; k < model->def->force_count; k++) {
    const hb_force_def *def = &model->def->forces[k];
    if (!acts_on(def, rod)) continue;
    hb_load_values values = hb_load_begin(def, t);
    for (int i = rod->first; i < rod->first + rod->nv; i++)
      hb_v3_accumulate(f + 3 * i, pull(model, hb_load_at(&values, model, rod, i, x), i, x));
  }
}

/* w k |x - initial x|^2/2, where the stiffness does not depend on place. */
static double energy(const hb_model *model, const hb_rod *rod, double t, const double *x) {
  double sum = 0;
  for (int k = 0; k < model->def->force_count; k++) {
    const hb_force_def *def = &model->def->forces[k];
    hb_load_values values = hb_load_begin(def, t);
    if (!acts_on(def, rod) || !values.uniform) continue;
    for (int i = rod->first; i < rod->first + rod->nv; i++) {
      hb_v3 away = hb_v3_sub(hb_v3_load(x + 3 * i), hb_v3_load(model->initial + 3 * i));
      sum -= 0.5 * hb_v3_dot(pull(model, values.value, i, x), away);
    }
  }
  return sum;
}

const hb_force_term hb_force_foundation = {
    "foundation", "springs that draw every piece to its initial place", active, add, energy, false, false,
    NULL};
