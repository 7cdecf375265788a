/* Equilibrium of one rod after the other, on a state (docs/theory, 11.5 to 11.7). */
#ifndef HB_STATICS_EQUILIBRIUM_H
#define HB_STATICS_EQUILIBRIUM_H

#include "hebra/statics.h"
#include "rod/rod.h"
#include "solve/kkt.h"
#include "solve/project.h"

/* Puts the prescribed vertices of a rod where they are at time t. */
typedef void (*hb_place)(void *context, const hb_rod *rod, double t);

/* What the search works on. */
typedef struct hb_statics {
  const hb_model *model;
  hb_state *state;
  const hb_force_term *const *terms; /* NULL-terminated */
  hb_place place;
  void *context;
  hb_rod_work rod_work;
  hb_project_work project_work;
  hb_kkt kkt;
  hb_state *kept;     /* where a rod was before a trial */
  double *multiplier; /* per slot: of each edge's length, current guess */
  double *none;       /* 3 per slot: zeros, as velocities and accelerations */
  double *scratch;    /* 3 per slot */
  double *moved;      /* 3 per vertex of the longest rod */
  double *direction;  /* per unknown of kkt: the step */
  /* of the rod at hand */
  double energy;     /* bending + twisting at the last evaluation */
  double magnitude;  /* what round-off of energies and works is relative to */
  double unit;       /* bending stiffness/length^2, or total load: the natural force */
  double floor;      /* stiffness per length that is always added, so that neutral modes do not drift */
  double softest;    /* stiffness per length that round-off tells from 0 */
  double resolution; /* the same at an equilibrium with its unbalanced forces */
} hb_statics;

hb_status hb_statics_create(hb_statics *s, const hb_model *model, hb_state *state,
                            const hb_force_term *const *terms, hb_place place, void *context, hb_error *err);
void hb_statics_free(hb_statics *s);

/* One rod from its state to equilibrium at time t, its supports carried from time `from`. Adds to *result. */
hb_status hb_statics_solve(hb_statics *s, const hb_rod *rod, double from, double t,
                           const hb_equilibrium_options *options, hb_equilibrium *result, hb_error *err);

/* What forces, stiffnesses and round-off of this rod are compared with: unit, floor, softest. */
void hb_statics_find_scales(hb_statics *s, const hb_rod *rod);
/* Largest force on a free coordinate that neither loads, elasticity nor lengths balance. multiplier: per edge
 * of the rod. */
double hb_statics_unbalanced(const hb_statics *s, const hb_rod *rod, const double *multiplier);
/* Largest multiplier as a tension. */
double hb_statics_largest_tension(const hb_statics *s, const hb_rod *rod, const double *multiplier);

/* ---- trial.c: places, energies, trials */

/* Keeps, or puts back, everything of the state that belongs to the rod. */
void hb_statics_keep(hb_statics *s, const hb_rod *rod);
void hb_statics_undo(hb_statics *s, const hb_rod *rod);
/* Frames, twist, forces, loads and energy at the state's positions. */
hb_status hb_statics_evaluate(hb_statics *s, const hb_rod *rod, double t, hb_error *err);
/* Moves the rod from where it is kept by part of s->direction, lengths restored, and evaluates there.
 * *change: of energy minus work of the loads since it was kept. False: there is no such place. */
bool hb_statics_try(hb_statics *s, const hb_rod *rod, double t, double part, double *change);
/* Largest turn of an edge or frame in s->direction, and the longest displacement. */
double hb_statics_turn(const hb_statics *s, const hb_rod *rod, double *displacement);

/* ---- mode.c: after hb_kkt_assemble */

/* Factors with the smallest shift from `start` on that makes the energy convex on the displacements that keep
 * the lengths; any: that only keeps the lengths. Returns the shift, or a negative number if there is none. */
double hb_statics_factor(hb_statics *s, const hb_rod *rod, double start, bool any, hb_equilibrium *result);
/* Modes of negative and of no stiffness, at unbalanced forces of size residual; sets s->resolution. */
void hb_statics_count_modes(hb_statics *s, const hb_rod *rod, double residual, hb_equilibrium *result,
                            int *unstable, int *neutral);
/* Leaves an unstable equilibrium along its most unstable mode, to the side where the energy is lower. False:
 * neither side is lower. */
bool hb_statics_escape(hb_statics *s, const hb_rod *rod, double t, hb_equilibrium *result);

#endif
