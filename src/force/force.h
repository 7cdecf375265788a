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
/* The same if the vertex were at another place. */
hb_v3 hb_load_if_at(const hb_load_values *values, const hb_model *model, const hb_rod *rod, int i,
                    const double place[3]);

/* What the value of a dead load is multiplied with at vertex slot i where it acts: a mass, a length, or 1. */
double hb_load_share(const hb_model *model, const hb_rod *rod, const hb_force_def *def, int i);

/* stiffness.c: for statics */
/* The first load on the rod that is not a function of time and place alone (a follower, a wind), or NULL. */
const hb_force_def *hb_load_first_moving(const hb_model *model, const hb_rod *rod);
/* Minus the derivative of the loads' force on each vertex by its own place, row by row: 9 per vertex of the
 * rod, by central differences of the formulas. False: no load depends on place, and all are 0. */
bool hb_load_stiffness(const hb_model *model, const hb_rod *rod, double t, const double *x, double *out);

/* drag.c: for implicit steps */
/* Minus the derivative of the loads' force on each vertex by its own velocity, as x and v (3 per slot) are:
 * symmetric, not negative, 9 per vertex of the rod. False: no load depends on velocity, and all are 0. */
bool hb_load_drag(const hb_model *model, const hb_rod *rod, double t, const double *x, const double *v,
                  double *out);

#endif
