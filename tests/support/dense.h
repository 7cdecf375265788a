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

/* Misprints of the thesis that change a formula of the force (docs/theory/errata.md), to be put back on
 * purpose. */
typedef enum dense_misprint {
  DENSE_E1 = 1 << 0, /* + kb e^T in both gradients of kb */
  DENSE_E3 = 1 << 1, /* Psi^j with the holonomy of the vertex behind edge j */
  DENSE_E5 = 1 << 2, /* + dE/dtheta dtheta/dx */
  DENSE_P1 = 1 << 3, /* kb e^T as a scalar product, added to every entry */
  DENSE_P2 = 1 << 4, /* J clockwise */
  DENSE_P3 = 1 << 5, /* dE/dtheta of the last edge with the twist of the whole rod over the last l */
  DENSE_P4 = 1 << 6, /* no holonomy at the last vertex but two, in the term of the last frame */
  DENSE_E10 = 1 << 7 /* nabla_1 instead of nabla_{n-1} at the last interior vertex, in the same term */
} dense_misprint;

/* Force on all vertices (3 each) of a rod whose angles are those that e was bound with, at shape x; the first
 * edge's Bishop director is e's. */
void dense_force(const rod_energy *e, const double *x, dense_lengths lengths, double *force);
/* The same with rest lengths and misprints (a sum of dense_misprint). */
void dense_force_misprinted(const rod_energy *e, const double *x, unsigned misprints, double *force);
/* The special formula for rods that are isotropic and straight at rest, one alpha and one beta, both end
 * edges held (or only one: then the twist is 0). */
void dense_force_isotropic(const rod_energy *e, const double *x, dense_lengths lengths, double *force);
/* dE/dtheta of every edge by the thesis's formula. */
void dense_theta_gradient(const rod_energy *e, const double *x, dense_lengths lengths, double *gradient);
/* Takes out of f its part along the gradients of the edge lengths (unit masses, all vertices free): what is
 * left is tangent to the constraint. */
void dense_project(int nv, const double *x, double *f);

#endif
