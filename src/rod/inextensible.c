/* Inextensibility as a constraint (Goldenthal et al. 2007, eq. 4; docs/theory, 6.1). */
#include "rod/inextensible.h"

/* One row per edge. */
static int count(const hb_model *model, const hb_rod *rod) {
  (void)model;
  return rod->nv - 1;
}

/* Values and, where asked for, derivatives. */
static void evaluate(const hb_model *model, const hb_rod *rod, const double *x, double *values,
                     double *rows) {
  for (int j = 0; j + 1 < rod->nv; j++) {
    int k = rod->first + j;
    hb_v3 g;
    values[j] = hb_inextensible_edge(x + 3 * k, model->rest_length[k], model->inv_rest_length[k], &g);
    if (!rows) continue;
    hb_v3_store(rows + 6 * j, hb_v3_scale(-1, g));
    hb_v3_store(rows + 6 * j + 3, g);
  }
}

const hb_constraint hb_constraint_inextensible = {"inextensible", "every edge keeps its rest length", count,
                                                  evaluate};
