/* The built-in integrators. */
#ifndef HB_TIME_INTEGRATORS_H
#define HB_TIME_INTEGRATORS_H

#include "time/stepper.h"

/* Takes every rod from the state's time over h by step_rod, which gets the time at the end of the step. */
hb_status hb_step_rods(hb_stepper *stepper, double h,
                       hb_status (*step_rod)(hb_stepper *, const hb_rod *, double t, double h, hb_error *),
                       hb_error *err);

extern const hb_integrator hb_integrator_symplectic_euler, hb_integrator_verlet;

#endif
