/* Second derivatives of the elastic energy (docs/theory, 11). */
#ifndef HB_ROD_HESSIAN_H
#define HB_ROD_HESSIAN_H

#include "math/banded.h"
#include "rod/rod.h"

/* Adds the second derivatives of the bending, twisting and stretching energy of one rod to K, after
 * hb_rod_settle without viscosity (h = 0). The unknowns are the vertices and the turns delta^j of the
 * material frames beyond time-parallel transport from where they are now, exact to second order: coordinate c
 * of vertex i has the number stride i + c, delta^j the number stride j + stride - 1. K is symmetric and has
 * half >= 2 stride + 2. Of a closed rod the joint writes into the columns behind the last vertex, nv - 1,
 * whose unknowns are those of vertex 0, as if vertex nv were vertex 1: K has room for them (hb_band). In
 * spans of closed-form rods that can untwist (no panels) there is no twist energy, and all entries of their
 * angles are 0. */
void hb_rod_hessian(const hb_model *model, const hb_rod *rod, const hb_state *state, const hb_rod_work *work,
                    int stride, hb_band *K);

/* Adds the second derivatives of the stretching energy of an extensible rod; numbers as above (stretch.c). */
void hb_stretch_hessian(const hb_model *model, const hb_rod *rod, const hb_rod_work *work, int stride,
                        hb_band *K);

/* Which angles are unknowns: frames that nothing holds, where they cost energy at all. unknown: one per edge.
 */
void hb_rod_free_angles(const hb_model *model, const hb_rod *rod, bool *unknown);

/* Bending, twisting and stretching energy of one rod after hb_rod_settle without viscosity. */
double hb_rod_energy(const hb_model *model, const hb_rod *rod, const hb_state *state,
                     const hb_rod_work *work);

#endif
