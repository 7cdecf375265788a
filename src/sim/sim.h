/* Inside of a running simulation. */
#ifndef HB_SIM_SIM_H
#define HB_SIM_SIM_H

#include "hebra/sim.h"
#include "time/stepper.h"

/* Measures states with borrowed workspaces. */
struct hb_measure {
  const hb_model *model;
  const hb_state *state; /* the one that is being measured */
  uint64_t fields;       /* to be measured */
  const double *m1;      /* 3 per edge: directors of the rod at hand */
  hb_rod_work *rod_work;
  hb_project_work *project_work;
  double *acceleration; /* 3 per slot: of prescribed coordinates */
  double *kb;           /* 3 per vertex: binormals of the rod at hand */
  double *lambda;       /* per slot: multipliers at the instant */
  double *own;          /* the three, where they are not borrowed */
};
/* borrowed: acceleration and kb, 3 per slot each, and lambda, 1 per slot; or NULL. */
hb_status hb_measure_init(hb_measure *probe, const hb_model *model, hb_rod_work *rod_work,
                          hb_project_work *project_work, double *const borrowed[3], hb_error *err);
void hb_measure_release(hb_measure *probe); /* of an initialised or zeroed one */

struct hb_sim {
  const hb_model *model;
  hb_state *state;
  const hb_integrator *integrator;
  hb_stepper stepper;
  hb_stepper *lane_owner; /* the stepper once more, for bringing the state up to date on reading */
  hb_measure measure;     /* works in the stepper's workspaces */
  double initial_correction;
  int time_every; /* time every n-th step; 0: never */
  long steps_timed, steps_taken;
};

/* Initial state: lengths, supports, frames, twist, forces (start.c). */
hb_status hb_sim_start(hb_sim *sim, hb_error *err);

#endif
