/* The constraint that keeps each edge at its rest length: C_j = |e^j|^2/|e-bar^j| - |e-bar^j|. */
#ifndef HB_ROD_INEXTENSIBLE_H
#define HB_ROD_INEXTENSIBLE_H

#include "hebra/plug.h"
#include "math/vec3.h"

/* Value of C_j; *gradient: its derivative by the far vertex, 2 e^j/|e-bar^j| (by the near one: minus that).
 */
static inline double hb_inextensible_edge(const double *x, double rest, double inv_rest, hb_v3 *gradient) {
  hb_v3 e = {x[3] - x[0], x[4] - x[1], x[5] - x[2]};
  *gradient = hb_v3_scale(2 * inv_rest, e);
  return hb_v3_dot(e, e) * inv_rest - rest;
}

extern const hb_constraint hb_constraint_inextensible;

#endif
