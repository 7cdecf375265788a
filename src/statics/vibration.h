/* The lowest modes of one rod about an equilibrium (docs/theory, 14). */
#ifndef HB_STATICS_VIBRATION_H
#define HB_STATICS_VIBRATION_H

#include "statics/equilibrium.h"

/* What the search works on. A mode's vector runs over the unknowns of the band system. */
typedef struct hb_vibration {
  hb_statics *statics; /* matrix assembled */
  const hb_rod *rod;
  int size;         /* unknowns of the band system */
  long freedom;     /* modes in all */
  double scale;     /* omega^2 that the rod's size suggests: bending or load over mass */
  double round_off; /* of omega^2, worst for the highest modes */
  double stray;     /* stiffness per length that unbalanced forces may feign */
  double *mass;     /* per unknown, 0: none */
  int room, found;  /* vectors that fit, that are there */
  int *order;       /* numbers of those by their omega^2 */
  double *vector, *square, *error;
  int steps_room; /* of one run of Lanczos's method */
  double *basis, *diagonal, *beside, *ritz, *trial;
  double strongest; /* largest eigenvalue of the inverse in the last run: round-off is relative to it */
  int solves, factorisations;
  double *block;
} hb_vibration;

/* Arrays for `count` modes of the rod at the equilibrium that the state is in: evaluates it at time t and
 * assembles with these multipliers (per edge of the rod). residual: largest unbalanced force. */
hb_status hb_vibration_begin(hb_vibration *v, hb_statics *statics, const hb_rod *rod, double t,
                             const double *multiplier, double residual, int count, hb_error *err);
void hb_vibration_end(hb_vibration *v);
/* Evaluates the rod and assembles its matrix; a frame that may turn freely is held in place. */
hb_status hb_vibration_assemble(hb_statics *statics, const hb_rod *rod, double t, const double *multiplier,
                                hb_error *err);
/* Fills mass (per unknown of the band system); returns how many are not 0. */
long hb_vibration_masses(const hb_statics *statics, const hb_rod *rod, double *mass);

/* Finds the `count` lowest, all of them proven to be there; v->order names them. */
hb_status hb_vibration_find(hb_vibration *v, int count, hb_error *err);
/* How many have omega^2 below square; negative: supports leave no room. */
int hb_vibration_count(hb_vibration *v, double square);
/* What round-off and unbalanced forces may have added to omega^2 of a found mode. */
double hb_vibration_resolution(const hb_vibration *v, int found);

/* ---- lanczos.c */
/* Modes near `shift` that are not there yet, `wanted` or more where there are so many. Returns how many it
 * found. */
int hb_vibration_lanczos(hb_vibration *v, double shift, int wanted);
/* Modes of the same frequency: turned among themselves so that they move along x, y, z. order: from .. to. */
void hb_vibration_align(hb_vibration *v, int from, int to);

#endif
