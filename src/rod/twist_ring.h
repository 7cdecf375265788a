/* Newton's linear system for the twist of a closed rod: the Hessian is tridiagonal but for the entry by which
 * the last edge and the first know each other (docs/theory, 12.3). */
#ifndef HB_ROD_TWIST_RING_H
#define HB_ROD_TWIST_RING_H

#include "rod/rod.h"

/* A pivot below this part of its diagonal is better known from the sum of what makes it. */
#define HB_TWIST_SOFT 1e-9

/* The last pivot of a chain of edges that nothing holds: where bending is next to nothing beside twisting,
 * elimination leaves only round-off of it, but it is the stiffness against turning all edges alike, the sum
 * of their bending parts. Where that is negative its size is taken (the step then goes downhill); where it is
 * noise the chain is not turned. */
static inline double hb_twist_soft_pivot(double bending_sum, double noise) {
  return fabs(bending_sum) > noise ? fabs(bending_sum) : HUGE_VAL;
}

/* Solves for the turns w->delta of all edges; false if a pivot is not clearly positive. convex: negative
 * bending parts are left out. shift: added to the diagonal. noise: what round-off there may be in the bending
 * parts. */
bool hb_twist_solve_ring(const hb_rod *rod, hb_rod_work *w, bool convex, double shift, double noise);

/* Does the energy fall at second order in some direction? */
bool hb_twist_ring_on_saddle(const hb_rod *rod, hb_rod_work *w);

#endif
