/* Mass-proportional damping: -c m v. */
#include "force/force.h"

/* Is it switched on for this rod? */
static bool active(const hb_model *model, const hb_rod *rod) {
  return model->def->rods[rod->index].mass_damping > 0;
}

/* Adds -c m v. */
static void add(const hb_model *model, const hb_rod *rod, double t, const double *x, const double *v,
                const double *m1, double *f) {
  (void)t;
  (void)x;
  (void)m1;
  double c = model->def->rods[rod->index].mass_damping;
  for (int i = rod->first; i < rod->first + rod->nv; i++)
    hb_v3_accumulate(f + 3 * i, hb_v3_scale(-c * model->mass[i], hb_v3_load(v + 3 * i)));
}

/* Always. */
static bool uniform(const hb_model *model, const hb_rod *rod, const hb_force_value *values,
                    hb_uniform_load *sum) {
  (void)values;
  sum->damping += model->def->rods[rod->index].mass_damping;
  return true;
}

const hb_force_term hb_force_damping = {"damping", "mass-proportional damping", active, add, NULL, true, true,
                                        uniform};
