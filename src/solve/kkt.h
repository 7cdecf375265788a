/* The linear system of constrained equilibrium, or of one implicit step, of one rod
 * (docs/theory, 11.4, 13.3).
 *
 * Unknowns: displacements of the vertices, turns of the material frames, multipliers of the lengths, in the
 * order of the vertices so that the matrix is a band: vertex i at 5 i, 5 i + 1, 5 i + 2, the multiplier of
 * edge i - 1 at 5 i + 3, the turn of edge i at 5 i + 4. What is prescribed, or is no unknown of this rod, has
 * a row of its own with 1 on the diagonal. Slim systems leave the turns out of rods that no twist can get
 * into: vertex i at 4 i, 4 i + 1, 4 i + 2, the multiplier of edge i - 1 at 4 i + 3, half the work. */
#ifndef HB_SOLVE_KKT_H
#define HB_SOLVE_KKT_H

#include "math/banded.h"
#include "rod/rod.h"

enum { HB_KKT_STRIDE = 5, HB_KKT_MULTIPLIER = 3, HB_KKT_TURN = 4, HB_KKT_HALF = 12 };
enum { HB_KKT_SLIM_STRIDE = 4, HB_KKT_SLIM_HALF = 10 };
/* The border of a closed rod's matrix: vertex 0, vertex 1, turn and multiplier of edge 0, and one that is
 * none. */
enum { HB_KKT_BORDER = 9 };

typedef struct hb_kkt {
  hb_band matrix, factors;
  int capacity;         /* vertices that fit */
  bool slim;            /* wanted: no turns where there is no twist; set between create and begin */
  int stride;           /* unknowns per vertex of this rod: HB_KKT_STRIDE, or HB_KKT_SLIM_STRIDE */
  double *weight;       /* per unknown: the metric, length for places, length^3 for turns; 0: none */
  double *right, *pull; /* per unknown (and HB_KKT_HALF more): right-hand side, then answer; K times what
                           supports were moved by */
  double *scratch;
  double *length;   /* per edge: C_j */
  double *load;     /* 9 per vertex: stiffness of the loads */
  double *along;    /* per edge: what was added along it, */
  double *gradient; /* 3 per edge: and the direction, dC_j/dx_{j+1} */
  bool *unknown;    /* per edge: is its turn unknown? */
  double augment;   /* multiple of the natural stiffness that is added along the edges */
  int constraints;
  double *block;
  size_t bytes;
  /* closed rods (docs/theory, 12.6): a matrix of n slots as that of an open rod, whose joint writes into the
   * columns behind the last; hb_kkt_factor takes what belongs to the first unknowns out into a border */
  bool closed;
  double *border; /* HB_KKT_BORDER rows of n + HB_KKT_HALF: couplings with the others, or NULL: no room */
  double *spread; /* the same: what the others do when one of the border is pulled at */
  double *core;   /* HB_KKT_BORDER^2: what is left of the border's own block, inverted */
  double *border_block;               /* all three */
  bool border_unknown[HB_KKT_BORDER]; /* is it one, or prescribed? */
} hb_kkt;

/* The number that unknown k of the matrix, or of the columns behind it, really has: of a closed rod the last
 * slot and the one behind it are the first two vertices. */
static inline int hb_kkt_fold(const hb_kkt *kkt, int k) {
  int last = kkt->matrix.n - HB_KKT_STRIDE;
  return kkt->closed && k >= last && k != last + HB_KKT_MULTIPLIER ? k - last : k;
}

/* For rods of up to nv vertices. */
hb_status hb_kkt_create(int nv, hb_kkt *kkt, hb_error *err);
void hb_kkt_free(hb_kkt *kkt);
/* Room for closed rods too, after hb_kkt_create. */
hb_status hb_kkt_add_border(hb_kkt *kkt, hb_error *err);

/* Metric and unknowns of a rod; once per rod. */
void hb_kkt_begin(hb_kkt *kkt, const hb_model *model, const hb_rod *rod);

/* Assembles at the state's positions after hb_rod_settle (h = 0): second derivatives of the elastic energy,
 * of the loads at time t, of the lengths with multipliers lambda (per edge of the rod), the gradients of the
 * lengths, and a multiple of their squares. moved: displacement of prescribed coordinates (3 per vertex of
 * the rod), whose effect goes to kkt->pull; NULL: none. */
void hb_kkt_assemble(hb_kkt *kkt, const hb_model *model, const hb_rod *rod, const hb_state *state,
                     const hb_rod_work *work, double t, const double *lambda, const double *moved);

/* Adds what motion has to the matrix, after hb_kkt_assemble: inertia times the masses and, where drag is not
 * NULL, rate times drag (9 per vertex of the rod, symmetric, as of hb_load_drag). */
void hb_kkt_add_motion(hb_kkt *kkt, const hb_model *model, const hb_rod *rod, double inertia,
                       const double *drag, double rate);

/* Factors the matrix plus shift times the metric. Returns the number of eigenvalues below -shift (in the
 * metric, on the displacements that keep the lengths): the negative pivots beyond those of the multipliers.
 * Negative: the multipliers' own pivots failed; a larger kkt->augment is needed. */
int hb_kkt_factor(hb_kkt *kkt, double shift);

/* out = K v, of the matrix that was assembled. v: of a closed rod with the same entries in both slots of the
 * vertex where its ends meet; the rows of `out` in the last slot are then parts, to be added to those of the
 * first. Room for HB_KKT_HALF more in both. */
void hb_kkt_multiply(const hb_kkt *kkt, const double *v, double *out);

/* Solves for kkt->right in place. The two slots of the vertex where a closed rod's ends meet get the same
 * answer; what stands in them at first is added up. */
void hb_kkt_solve(hb_kkt *kkt);

#endif
