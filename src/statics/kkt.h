/* The linear system of constrained equilibrium of one rod (docs/theory, 11.4).
 *
 * Unknowns: displacements of the vertices, turns of the material frames, multipliers of the lengths, in the
 * order of the vertices so that the matrix is a band: vertex i at 5 i, 5 i + 1, 5 i + 2, the multiplier of
 * edge i - 1 at 5 i + 3, the turn of edge i at 5 i + 4. What is prescribed, or is no unknown of this rod, has
 * a row of its own with 1 on the diagonal. */
#ifndef HB_STATICS_KKT_H
#define HB_STATICS_KKT_H

#include "math/banded.h"
#include "rod/rod.h"

enum { HB_KKT_STRIDE = 5, HB_KKT_MULTIPLIER = 3, HB_KKT_TURN = 4, HB_KKT_HALF = 12 };

typedef struct hb_kkt {
  hb_band matrix, factors;
  int capacity;         /* vertices that fit */
  double *weight;       /* per unknown: the metric, length for places, length^3 for turns; 0: none */
  double *right, *pull; /* per unknown (and HB_KKT_HALF more): right-hand side, then answer; K times what
                           supports were moved by */
  double *scratch;
  double *length; /* per edge: C_j */
  double *along;  /* per edge: multiple of the square of its constraint that is in the matrix */
  double *load;   /* 9 per vertex: stiffness of the loads */
  bool *unknown;  /* per edge: is its turn unknown? */
  double augment; /* multiple of the natural stiffness that is added along the edges */
  int constraints;
  double *block;
  size_t bytes;
} hb_kkt;

/* For rods of up to nv vertices. */
hb_status hb_kkt_create(int nv, hb_kkt *kkt, hb_error *err);
void hb_kkt_free(hb_kkt *kkt);

/* Metric and unknowns of a rod; once per rod. */
void hb_kkt_begin(hb_kkt *kkt, const hb_model *model, const hb_rod *rod);

/* Assembles at the state's positions after hb_rod_settle (h = 0): second derivatives of the elastic energy,
 * of the loads at time t, of the lengths with multipliers lambda (per edge of the rod), the gradients of the
 * lengths, and a multiple of their squares. moved: displacement of prescribed coordinates (3 per vertex of
 * the rod), whose effect goes to kkt->pull; NULL: none. */
void hb_kkt_assemble(hb_kkt *kkt, const hb_model *model, const hb_rod *rod, const hb_state *state,
                     const hb_rod_work *work, double t, const double *lambda, const double *moved);

/* Factors the matrix plus shift times the metric. Returns the number of eigenvalues below -shift (in the
 * metric, on the displacements that keep the lengths): the negative pivots beyond those of the multipliers.
 * Negative: the multipliers' own pivots failed; a larger kkt->augment is needed. */
int hb_kkt_factor(hb_kkt *kkt, double shift);

/* Solves for kkt->right in place. */
void hb_kkt_solve(hb_kkt *kkt);

#endif
