/* The built-in integrators. */
#ifndef HB_TIME_INTEGRATORS_H
#define HB_TIME_INTEGRATORS_H

#include "time/stepper.h"

extern const hb_integrator hb_integrator_symplectic_euler, hb_integrator_verlet;

#endif
