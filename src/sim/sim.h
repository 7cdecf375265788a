/* Inside of a running simulation. */
#ifndef HB_SIM_SIM_H
#define HB_SIM_SIM_H

#include "hebra/sim.h"
#include "time/stepper.h"

struct hb_sim {
  const hb_model *model;
  hb_state *state;
  const hb_integrator *integrator;
  hb_stepper stepper;
  hb_stepper *lane_owner; /* the stepper once more, for bringing the state up to date on reading */
  double *acceleration;   /* 3 per slot: of prescribed coordinates, for measuring */
  double *lambda;         /* per slot: multipliers at an instant, for measuring */
  double initial_correction;
  int time_every; /* time every n-th step; 0: never */
  long steps_timed, steps_taken;
};

/* Initial state: lengths, supports, frames, twist, forces (start.c). */
hb_status hb_sim_start(hb_sim *sim, hb_error *err);

#endif
