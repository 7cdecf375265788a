/* What the solvers of open and of closed rods share (docs/theory, 6 and 12.5). */
#ifndef HB_SOLVE_PROJECT_PARTS_H
#define HB_SOLVE_PROJECT_PARTS_H

#include "math/vec3.h"
#include "solve/project.h"

/* Rows whose pivot falls below this part of its diagonal hang on the others: no room to move. */
#define HB_LENGTH_SINGULAR 1e-13

/* sum over coordinates of a_c w_c b_c. */
static inline double hb_weighted(hb_v3 a, const double *w, hb_v3 b) {
  return a.x * w[0] * b.x + a.y * w[1] * b.y + a.z * w[2] * b.z;
}

/* What the right-hand side is: lengths C_j, their rates G v, or what is in work->right already. */
typedef enum hb_right_side { HB_RIGHT_LENGTHS, HB_RIGHT_RATES, HB_RIGHT_GIVEN } hb_right_side;

/* What all rows share. */
typedef struct hb_length_system {
  const hb_model *m;
  const hb_rod *rod;
  const double *x, *v;
  hb_project_work *w;
  bool along, relative;
  hb_right_side kind;
} hb_length_system;

/* What the elimination finds on the way. */
typedef struct hb_length_finding {
  double worst;
  int edge;
  bool full; /* every row has a sound pivot */
} hb_length_finding;

/* How corrections are put into effect. */
typedef struct hb_length_effect {
  double *x, *v;           /* what moves */
  double x_part, v_part;   /* by which multiple of the correction; 0: not */
  const double *direction; /* 3 per edge */
  double *lambda;          /* sums of multipliers by edge of the rod, or NULL */
  bool relative;
  bool judged; /* is what is left of the lengths asked for? */
} hb_length_effect;

/* ring.c: the same for closed rods */
/* Eliminates and solves: the unknowns go to work->right. */
hb_length_finding hb_ring_solve(const hb_length_system *system);
/* Moves all vertices by the multipliers `unknown` (per edge), which are added to effect->lambda. Returns the
 * largest |C_j| that is left, where that is asked for. */
double hb_ring_apply(const hb_model *model, const hb_rod *rod, const double *unknown,
                     const hb_length_effect *effect);

#endif
