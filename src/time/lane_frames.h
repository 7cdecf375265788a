/* Held frames of bundles of like rods, several rods at a time. */
#ifndef HB_TIME_LANE_FRAMES_H
#define HB_TIME_LANE_FRAMES_H

#include "time/journey.h"

/* Most directors of a rod that are carried so: its anchor, held frames, ends of panels. */
#define HB_JOURNEY_DIRECTORS 8
#define HB_JOURNEY_GROUPS (HB_LANES_MAX / HB_LANES_DOUBLE)

/* Is this a bundle of rods with as many held frames and panels each, not too many? */
bool hb_unit_is_alike(const hb_model *model, const hb_unit *unit);
/* And do all frames stand at angles that do not change? Depends on scene and state alone. */
bool hb_journey_is_steady(const hb_journey *journey);
/* Frames, twist and moments of a steady unit in closed form, torques of its supports; after the transport.
 * false, with nothing changed, if an edge turned back and the rods' own functions are needed. */
bool hb_journey_settle_steady(const hb_journey *journey);
/* Frames of a steady unit of general rods, into the state and the lanes. The same. */
bool hb_journey_hold_steady(const hb_journey *journey);
/* After their twist: the angle of the first edge of each rod. */
void hb_journey_first_angles(const hb_journey *journey);

/* lane_force.c: transport along a panel of the unit's n-th rod. */
hb_quat hb_journey_panel(const hb_unit *unit, int n, int from, int to);

#endif
