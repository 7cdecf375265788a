/* The built-in integrators. */
#ifndef HB_TIME_INTEGRATORS_H
#define HB_TIME_INTEGRATORS_H

#include "time/lane_step.h"

/* A scheme, for rods one by one and for rods in lanes; both get the time at the end of the step. */
typedef struct hb_scheme {
  hb_rod_step step_rod;
  hb_status (*step_lanes)(hb_stepper *, hb_unit *, double t, double h, hb_rod_step step_rod, hb_error *);
} hb_scheme;

/* Takes every rod from the state's time over h. */
hb_status hb_step_rods(hb_stepper *stepper, double h, const hb_scheme *scheme, hb_error *err);

extern const hb_integrator hb_integrator_symplectic_euler, hb_integrator_verlet, hb_integrator_implicit,
    hb_integrator_backward_euler;

#endif
