/* Inside of measuring: what its files share. */
#ifndef HB_SIM_MEASURE_H
#define HB_SIM_MEASURE_H

#include "sim/sim.h"

/* Fields that the material directors of closed-form rods are needed for. */
#define HB_MEASURE_DIRECTORS (HB_FIELD_BIT(m1) | HB_FIELD_BIT(m2) | HB_FIELD_BIT(theta) | HB_FIELD_BIT(omega))
/* Fields that are made of internal moments. */
#define HB_MEASURE_MOMENTS                                                                                   \
  (HB_FIELD_BIT(internal_moment) | HB_FIELD_BIT(bending_moment) | HB_FIELD_BIT(internal_force))
/* What of the frame others of its fields are made of. */
#define HB_MEASURE_TWIST                                                                                     \
  (HB_FIELD_BIT(twist) | HB_FIELD_BIT(twist_density) | HB_FIELD_BIT(twisting_moment) |                       \
   HB_FIELD_BIT(energy_twisting) | HB_MEASURE_MOMENTS)
/* A binormal whose square is below this is round-off and has no direction. */
#define HB_MEASURE_STRAIGHT 1e-24

/* Tension, reactions, torques, internal moments and forces of a rod whose edges have been measured, as far as
 * they are wanted (measure_forces.c). */
void hb_measure_forces(hb_measure *probe, const hb_rod *rod, hb_frame *out);
/* Tension of edge slot k of an extensible rod at x; 0 of others. */
double hb_measure_spring(const hb_model *model, int k, const double *x);
/* Internal forces of a rod from its tensions and internal moments in the frame. */
void hb_measure_internal_force(const hb_rod *rod, hb_frame *frame);

#endif
