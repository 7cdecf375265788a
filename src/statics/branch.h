/* Branches of equilibria of one rod over a parameter (docs/theory, 16). */
#ifndef HB_STATICS_BRANCH_H
#define HB_STATICS_BRANCH_H

#include "statics/equilibrium.h"

/* Rods that differ in the value of a parameter only. */
typedef struct hb_family {
  /* Puts the supports and held frames of `state` where they are at the value p of the parameter, and tells
   * the model and the time to which it belongs then; nothing is evaluated. The model stays valid until the
   * next call but HB_FAMILY_KEPT - 1. HB_ERR_NUMERIC or HB_ERR_INPUT: there is no such rod. */
  hb_status (*enter)(void *context, double p, hb_state *state, const hb_model **model, double *t,
                     hb_error *err);
  void *context;
} hb_family;
enum { HB_FAMILY_KEPT = 6 };

enum { HB_BRANCH_MODES = 4, HB_BRANCH_RIGID = 7 };

/* A point of a branch. */
typedef struct hb_branch_point {
  hb_state *state;
  double *multiplier; /* per edge */
  double *tangent;    /* per unknown of the band: how it changes along the branch */
  double *rate;       /* derivative of the equations by the parameter */
  double *turns;      /* per edge: how frames turn with the parameter alone */
  double p, tangent_p;
  double arc;            /* along the branch from its beginning */
  int unstable, neutral; /* modes */
  double resolution, residual, scale, last_step, elastic;
  int iterations; /* that it took */
} hb_branch_point;

/* The workspace. */
typedef struct hb_branch {
  hb_statics s;
  hb_family family;
  const hb_rod *rod; /* of the model that was entered last */
  double p, t;       /* where that was */
  double lower, upper, range;
  double tolerance;
  double metric;        /* of squared displacements times lengths: 1/(rod's length)^3 */
  double *rate;         /* derivative of the equations by the parameter, at fixed unknowns */
  double *column;       /* the same as it borders the matrix */
  double *row, corner;  /* the condition that picks a point of the branch */
  double *left, *right; /* A^-1 row, A^-1 column */
  double delta_left, delta_right;
  double *answer, *wanted, *rest, *held; /* scratch, per unknown */
  double shift;                          /* that the factors have */
  hb_state *center;                      /* where the parameter's derivative is taken */
  double *turns;                         /* per edge: how frames turn with the parameter */
  double *mode;                          /* HB_BRANCH_MODES vectors */
  double *rigid;                         /* HB_BRANCH_RIGID vectors: moves that cost nothing */
  int rigid_count;
  int room;         /* doubles of one vector */
  hb_error trouble; /* why the last evaluation failed; HB_OK: none did since this was cleared */
  int factorisations, iterations;
  hb_equilibrium counted; /* where the statics room books its costs */
} hb_branch;

/* Workspace for the rods of a family, which all look like `model`; values of the parameter are lower ..
 * upper.
 */
hb_status hb_branch_create(hb_branch *b, const hb_model *model, const hb_force_term *const *terms,
                           const hb_family *family, double lower, double upper, hb_error *err);
void hb_branch_free(hb_branch *b);
hb_status hb_branch_point_create(const hb_branch *b, const hb_model *model, hb_branch_point *point,
                                 hb_error *err);
void hb_branch_point_free(hb_branch_point *point);
void hb_branch_point_copy(const hb_branch *b, hb_branch_point *to, const hb_branch_point *from);

/* ---- branch.c: one point */
/* Takes the state of a point into the workspace, at its value of the parameter. */
hb_status hb_branch_return(hb_branch *b, const hb_branch_point *from, hb_error *err);
/* Frames, twist, forces at the workspace's positions and the value p; turn: a guess of how far frames turn
 * per edge, NULL: none. */
hb_status hb_branch_evaluate(hb_branch *b, double p, const double *turn, hb_error *err);
/* Newton from the workspace's state until the equations hold, with row . (unknowns) + corner p moved by gap.
 * False: it does not get there. */
bool hb_branch_correct(hb_branch *b, double gap, double longest_turn, int *iterations, double *last_step);
/* Writes the workspace into a point, finds its tangent (on the side where row . tangent > 0) and its modes.
 */
hb_status hb_branch_finish(hb_branch *b, hb_branch_point *out, hb_error *err);
/* The condition that moves along the tangent of a point, and the one that holds the parameter. */
void hb_branch_along(hb_branch *b, const hb_branch_point *point);
void hb_branch_hold(hb_branch *b, double sign);
/* The point at distance `step` along the tangent of `from`: predicts, corrects, finishes. False: not found.
 */
bool hb_branch_step(hb_branch *b, const hb_branch_point *from, double step, hb_branch_point *out);
/* The same where the parameter has the value p. step: about how far that is. */
bool hb_branch_land(hb_branch *b, const hb_branch_point *from, double step, double p, hb_branch_point *out);
/* The point whose displacement from a bifurcation has the part `amount` along a mode (b->mode's scale), on
 * the branch that leaves it that way. */
bool hb_branch_leave(hb_branch *b, const hb_branch_point *from, const double *mode, double amount,
                     hb_branch_point *out);
/* Inner product of tangents. */
double hb_branch_product(const hb_branch *b, const hb_branch_point *x, const hb_branch_point *y);
/* Distance of `to` from `from` along the tangent of `from`. */
double hb_branch_distance(const hb_branch *b, const hb_branch_point *from, const hb_branch_point *to);

/* ---- branch_border.c: the band with one more row and column */
/* Assembles where the workspace is and factors; leaves right-hand sides in s.kkt.right. False: no factors. */
bool hb_branch_factor(hb_branch *b);
/* To be called after hb_branch_factor and whenever column, row or corner changed. */
void hb_branch_border(hb_branch *b);
/* Solves for unknowns (in place of f) and parameter. */
void hb_branch_solve(hb_branch *b, double *f, double g, double *dp);
/* Derivative of the equations by the parameter into b->rate, by differences of fourth order inside the
 * allowed values. The workspace stays where it is. */
hb_status hb_branch_differentiate(hb_branch *b, hb_error *err);

/* ---- branch_modes.c: after hb_branch_factor */
/* Moves of the rod as a whole that its supports allow and that cost nothing; or the `most` of them that cost
 * least, negative: what round-off cannot tell from nothing. */
void hb_branch_find_rigid(hb_branch *b, int most);
/* `count` modes whose stiffness is nearest to 0 but for those, into b->mode; their stiffness per length.
 * fresh: from the start, else from those found last. */
void hb_branch_softest(hb_branch *b, int count, bool fresh, double *stiffness);
/* Of the first `count` modes (of one stiffness) the one member that moves the rod most along z, or y, or x,
 * into mode 0, scaled to 1 in the metric. False: nothing moves but frames. */
bool hb_branch_choose_mode(hb_branch *b, int count);

/* ---- branch_events.c */
/* What lies between two neighbouring points of a branch. */
typedef struct hb_branch_events {
  bool fold;
  int change;   /* of the number of unstable modes, but for the one that changes at a fold */
  bool unclear; /* too much to be told apart: the points are to be closer */
} hb_branch_events;
/* before: number of unstable modes at a, or where it was clear last. */
hb_branch_events hb_branch_compare(const hb_branch_point *a, const hb_branch_point *z, int before);
/* The fold between a and z = its neighbour at distance `end`. False: not found. */
bool hb_branch_find_fold(hb_branch *b, const hb_branch_point *a, const hb_branch_point *z, double end,
                         hb_branch_point *out);
/* The first change of the number of unstable modes between distances start (where it is `before`) and end
 * (where it is `after`) from a: *at, and *multiplicity modes change there; b->mode holds them. *left: their
 * number behind it. False: not found. */
bool hb_branch_find_bifurcation(hb_branch *b, const hb_branch_point *a, double start, double end, int before,
                                int after, double *at, int *multiplicity, int *left, hb_branch_point *out);

/* ---- small symmetric matrices (branch_modes.c): n <= HB_BRANCH_RIGID; values ascending, vectors in columns
 */
void hb_small_eigen(int n, double a[HB_BRANCH_RIGID][HB_BRANCH_RIGID],
                    double vectors[HB_BRANCH_RIGID][HB_BRANCH_RIGID], double *values);

#endif
