/* hebra/modes.h - natural frequencies and modes about an equilibrium (docs/theory, 14). */
#ifndef HEBRA_MODES_H
#define HEBRA_MODES_H

#include "hebra/statics.h"

#ifdef __cplusplus
extern "C" {
#endif

/* One way in which one rod moves by itself: x(t) = x + shape cos(omega t). */
typedef struct hb_mode {
  int rod;           /* its index */
  double square;     /* omega^2, 1/time^2; negative: the equilibrium is left like exp(sqrt(-square) t) */
  double resolution; /* what round-off and unbalanced forces may have added to square; a smaller square counts
                        as 0: the rod moves without resistance */
  double error;      /* bound of the error of square that the iteration left */
  double *shape;     /* 3 per vertex of the rod, sum of mass |shape|^2 = 1: lengths kept to first order */
  double *turn;      /* per edge of the rod (and one unused): turn of the material frame beyond parallel
                        transport, same scale as shape; 0 where it is no unknown */
} hb_mode;

/* The lowest modes of a scene, in order of square. */
typedef struct hb_modes {
  int count;
  hb_mode *mode;
  int unstable;       /* modes in all with square below -resolution */
  int rigid;          /* of those that are listed: square is 0 to the resolution */
  long freedom;       /* how many modes the rods have in all */
  int solves;         /* of the linear system */
  int factorisations; /* of its matrix */
  double *block;
} hb_modes;

/* What the modes do to a rod: circular frequency sqrt(|square|); 0 for rigid ones. */
double hb_mode_omega(const hb_mode *mode);
/* -1: unstable, 0: rigid, 1: vibration. */
int hb_mode_kind(const hb_mode *mode);

/* The `count` lowest modes (all, if there are fewer) about the equilibrium `at` that
 * hb_sim_find_equilibrium found and where sim still is. Material frames have no inertia: they follow in
 * equilibrium. That no mode was missed is proven by the inertia of the shifted matrix. The result is to be
 * given to hb_modes_free, also after an error. HB_ERR_INPUT: count below 1. HB_ERR_NUMERIC: no convergence,
 * or supports that leave a rod no room. */
hb_status hb_sim_find_modes(hb_sim *sim, const hb_equilibrium *at, int count, hb_modes *out, hb_error *err);
void hb_modes_free(hb_modes *modes);

/* Measures the rod in its mode: displaced by shape times a factor that makes the largest displacement
 * amplitude cos(phase), lengths restored, frames following; velocities those of the vibration at that phase;
 * time phase/omega (a mode without frequency: phase/(2 pi)). The state of sim is as before afterwards.
 * HB_ERR_INPUT: lengths cannot be restored so far away. */
hb_status hb_sim_measure_mode(hb_sim *sim, const hb_equilibrium *at, const hb_mode *mode, double amplitude,
                              double phase, hb_frame *frame, hb_error *err);

/* A sparse matrix by its entries, counted from 0; of a symmetric one the lower half. */
typedef struct hb_matrix {
  int rows, columns;
  long entries;
  bool symmetric;
  int *row, *column;
  double *value;
} hb_matrix;

/* Small motions about an equilibrium: M y'' + K y + G^T mu = 0, G y = 0. Unknowns y are what is free: places,
 * and the turns of material frames (which have no mass). K has the tensions' part in it. */
typedef struct hb_matrices {
  hb_matrix M, K, G;
  int *slot;      /* per unknown: vertex or edge slot */
  int *component; /* 0, 1, 2: x, y, z of the vertex; 3: turn of the edge's frame */
  int *edge;      /* per row of G: the edge slot whose length it keeps */
} hb_matrices;

/* The matrices of all rods, one rod after the other. To be given to hb_matrices_free, also after an error. */
hb_status hb_sim_find_matrices(hb_sim *sim, const hb_equilibrium *at, hb_matrices *out, hb_error *err);
void hb_matrices_free(hb_matrices *matrices);

#ifdef __cplusplus
}
#endif
#endif
