/* Steps of rods in lanes: the schemes of symplectic_euler.c and verlet.c, a whole bundle or a rod in pieces
 * at a time (docs/theory, 10). */
#ifndef HB_TIME_LANE_STEP_H
#define HB_TIME_LANE_STEP_H

#include "time/stepper.h"

typedef hb_status (*hb_rod_step)(hb_stepper *, const hb_rod *, double t, double h, hb_error *);

/* One step of a unit to time t. Whatever is out of the ordinary - lengths that do not converge, edges that
 * fold back - is done over by step_rod, rod by rod. Totals go into unit->tally. */
hb_status hb_lane_step_euler(hb_stepper *worker, hb_unit *unit, double t, double h, hb_rod_step step_rod,
                             hb_error *err);
hb_status hb_lane_step_verlet(hb_stepper *worker, hb_unit *unit, double t, double h, hb_rod_step step_rod,
                              hb_error *err);

#endif
