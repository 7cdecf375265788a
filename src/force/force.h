/* The built-in loads and what they share. */
#ifndef HB_FORCE_FORCE_H
#define HB_FORCE_FORCE_H

#include "hebra/plug.h"
#include "math/vec3.h"

extern const hb_force_term hb_force_gravity, hb_force_load, hb_force_wind, hb_force_damping;

/* Three formulas of a load at one time: evaluated once where they are the same everywhere, else per vertex.
 */
typedef struct hb_load_values {
  const hb_force_def *def;
  double t;
  bool uniform;
  hb_v3 value; /* if uniform */
} hb_load_values;

/* Are the load's formulas the same everywhere? */
bool hb_load_is_uniform(const hb_force_def *def);
hb_load_values hb_load_begin(const hb_force_def *def, double t);
/* Value at vertex slot i, which is at x[3 i]. */
hb_v3 hb_load_at(const hb_load_values *values, const hb_model *model, const hb_rod *rod, int i,
                 const double *x);

#endif
