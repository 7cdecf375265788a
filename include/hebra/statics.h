/* hebra/statics.h - equilibrium without marching in time (docs/theory, 11). */
#ifndef HEBRA_STATICS_H
#define HEBRA_STATICS_H

#include "hebra/plug.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct hb_sim hb_sim;     /* hebra/sim.h */
typedef struct hb_frame hb_frame; /* hebra/sim.h */

/* How an equilibrium is looked for. */
typedef struct hb_equilibrium_options {
  double time;        /* loads and supports are those of this time, >= 0 */
  int load_steps;     /* equilibria on the way from the state's time to that one, the last included, >= 1 */
  int max_iterations; /* Newton iterations per load step, >= 1 */
  double tolerance;   /* unbalanced force allowed, relative to hb_equilibrium.force_scale, > 0 */
  bool any;           /* accept also unstable equilibria: plain Newton, which goes to the nearest one */
} hb_equilibrium_options;

/* time: the argument; one load step, 200 iterations, 1e-10, stable equilibria only. */
hb_equilibrium_options hb_equilibrium_defaults(double time);

/* What was found. Counts of all rods; worst values over the rods, at the last load step. */
typedef struct hb_equilibrium {
  int iterations;     /* Newton iterations of all load steps */
  int factorisations; /* of the band matrix, in all */
  int escapes;        /* times that an unstable equilibrium was left along its unstable mode */
  int unstable;       /* modes in which the energy falls at second order: 0 is stable */
  int neutral;        /* modes whose stiffness is 0 to the resolution below */
  double resolution;  /* smallest stiffness per length of rod that counts as other than 0 */
  double residual;    /* largest unbalanced force on a free coordinate */
  double force_scale; /* what it is compared with: largest tension, total load, bending stiffness/length^2 */
  double last_step;   /* largest displacement in the last iteration */
  double elastic;     /* bending + twisting energy */
  double *multiplier; /* one per slot: the multiplier of each edge's length, tension/2 on exact lengths */
} hb_equilibrium;

/* Puts the state of sim where a measured moment was: its time, positions, material frames with their windings
 * (the fields time, position, m1, twist, bishop_u and theta of frame are read); velocities 0. The moment must
 * be of the same model, supports in their places of that time. HB_ERR_INPUT: it does not fit. */
hb_status hb_sim_resume(hb_sim *sim, const hb_frame *frame, hb_error *err);

/* Moves the state of sim to an equilibrium: positions, frames; velocities 0, time = options->time. Each rod
 * is solved by itself. The result is to be given to hb_equilibrium_free, also after an error. HB_ERR_INPUT: a
 * load that turns with the rod or drags it, a rod that nothing holds against its loads. HB_ERR_NUMERIC: no
 * convergence. The state is there to be measured, or to look on from; hb_sim_step counts time in steps and
 * does not go on from it. */
hb_status hb_sim_find_equilibrium(hb_sim *sim, const hb_equilibrium_options *options, hb_equilibrium *result,
                                  hb_error *err);
void hb_equilibrium_free(hb_equilibrium *result);

/* As hb_sim_measure, with the tensions and reactions of the equilibrium instead of those of a motion that
 * would begin there. */
void hb_sim_measure_equilibrium(hb_sim *sim, const hb_equilibrium *result, hb_frame *frame);

#ifdef __cplusplus
}
#endif
#endif
