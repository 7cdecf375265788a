/* Starting from a measured moment instead of from the scene. */
#ifndef HB_ROD_RESUME_H
#define HB_ROD_RESUME_H

#include "rod/rod.h"

/* Fills every frame field of the rod's state, after hb_rod_geometry at the positions of a measured moment,
 * from what was measured at time t: directors m1 (3 per slot) and twists (per slot), Bishop director and
 * material angle of the first edge. */
void hb_frames_resume(const hb_model *model, const hb_rod *rod, hb_state *state, const hb_rod_work *work,
                      double t, const double *m1, const double *twist, const double *u0, double theta_0);

#endif
