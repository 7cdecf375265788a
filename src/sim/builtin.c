/* The one list of the built-in parts, in the order in which they run. */
#include "force/force.h"
#include "rod/inextensible.h"
#include "time/integrators.h"

const hb_force_term *const hb_force_terms[] = {&hb_force_gravity, &hb_force_load, &hb_force_wind,
                                               &hb_force_damping, NULL};

const hb_constraint *const hb_constraints[] = {&hb_constraint_inextensible, NULL};

const hb_integrator *const hb_integrators[] = {&hb_integrator_symplectic_euler, &hb_integrator_verlet,
                                               &hb_integrator_implicit, &hb_integrator_backward_euler, NULL};
