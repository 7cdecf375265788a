/* How loads change with place, for statics. */
#include "force/force.h"

/* Which loads have no potential, or depend on more than time and place. */
const hb_force_def *hb_load_first_moving(const hb_model *model, const hb_rod *rod) {
  for (int entry = 0; entry < rod->force_count; entry++) {
    const hb_force_def *def = hb_rod_force_def(model, rod, entry);
    if (!hb_force_def_acts_on(def, rod->index)) continue;
    if (def->follower || def->kind == HB_FORCE_WIND) return def;
  }
  return NULL;
}

/* What a value of the load is multiplied with at vertex slot i; 0: it does not act there. */
static double share(const hb_model *model, const hb_rod *rod, const hb_force_def *def, int i) {
  int point = rod->first + (def->vertex < 0 ? def->vertex + rod->nv : def->vertex);
  if (def->kind == HB_FORCE_WIND || (def->kind == HB_FORCE_POINT && i != point)) return 0;
  return hb_load_share(model, rod, def, i);
}

/* Does it change with place? */
static bool depends_on_place(const hb_force_def *def) {
  for (int c = 0; c < 3; c++)
    for (int k = HB_VAR_X; k <= HB_VAR_Z; k++)
      if (def->value[c] && hb_formula_uses(def->value[c], (hb_variable)k)) return true;
  return false;
}

/* Central differences of the formulas; step^2 and round-off/step are alike for smooth ones. */
bool hb_load_stiffness(const hb_model *model, const hb_rod *rod, double t, const double *x, double *out) {
  bool any = false;
  double step = 1e-5 * rod->length;
  for (int k = 0; k < 9 * rod->nv; k++) out[k] = 0;
  for (int entry = 0; entry < rod->force_count; entry++) {
    const hb_force_def *def = hb_rod_force_def(model, rod, entry);
    if (!hb_force_def_acts_on(def, rod->index) || !depends_on_place(def)) continue;
    hb_load_values values = hb_load_begin(def, t);
    for (int i = rod->first; i < rod->first + rod->nv; i++) {
      double factor = share(model, rod, def, i) / (2 * step);
      for (int c = 0; c < 3 && factor != 0; c++) {
        double place[3] = {x[3 * i], x[3 * i + 1], x[3 * i + 2]};
        place[c] = x[3 * i + c] + step;
        hb_v3 up = hb_load_if_at(&values, model, rod, i, place);
        place[c] = x[3 * i + c] - step;
        hb_v3 change = hb_v3_scale(factor, hb_v3_sub(up, hb_load_if_at(&values, model, rod, i, place)));
        double *to = out + 9 * (i - rod->first) + c;
        to[0] -= change.x;
        to[3] -= change.y;
        to[6] -= change.z;
      }
      any = any || factor != 0;
    }
  }
  return any;
}
