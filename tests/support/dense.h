/* The force as the thesis writes it, with its printed errors put right: gradients of every quantity by every
 * vertex kept in arrays of n x n (x n) blocks, and summed. Slow and plain; compared with the O(n) force. */
#ifndef HB_TEST_DENSE_H
#define HB_TEST_DENSE_H

#include "support/energy.h"

typedef enum dense_lengths {
  DENSE_REST,   /* chi and the holonomy with rest lengths, as the thesis: equal on inextensible rods, up to a
                   part   along the edges */
  DENSE_CURRENT /* with the lengths that the edges have: the exact gradient of the energy */
} dense_lengths;

/* Force on all vertices (3 each) of a rod whose angles are those that e was bound with, at shape x; the first
 * edge's Bishop director is e's. */
void dense_force(const rod_energy *e, const double *x, dense_lengths lengths, double *force);
/* The special formula for rods that are isotropic and straight at rest, one alpha and one beta, both end
 * edges held (or only one: then the twist is 0). */
void dense_force_isotropic(const rod_energy *e, const double *x, dense_lengths lengths, double *force);
/* dE/dtheta of every edge by the thesis's formula. */
void dense_theta_gradient(const rod_energy *e, const double *x, dense_lengths lengths, double *gradient);
/* Takes out of f its part along the gradients of the edge lengths (unit masses, all vertices free): what is
 * left is tangent to the constraint. */
void dense_project(int nv, const double *x, double *f);

#endif
