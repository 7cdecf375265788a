/* One scene run in all ways: vertex by vertex, in lanes without special instructions, in lanes with the best
 * that the processor has. Everything here ends the cmocka test that calls it when something differs. */
#ifndef HB_TEST_LANES_H
#define HB_TEST_LANES_H

#include "support/rng.h"
#include "support/scenes.h"

enum { WAY_PLAIN, WAY_PORTABLE, WAY_BEST, WAY_PUSHED, WAY_COUNT };

/* The same model, stepped in every way. WAY_PUSHED is the plain way from a state that trio_push has changed
 * by a little: what it ends up with tells how the scene magnifies round-off. */
typedef struct trio {
  hb_scene_def def; /* to be filled in before trio_start */
  hb_model *model;
  hb_sim *sim[WAY_COUNT];
  hb_frame *frame[2]; /* of trio_compare_totals */
  bool parted;        /* lanes and the plain way differed in their number of projections at some step */
} trio;

/* Model and simulations of def. step > 0: method.time_step is the smaller of step and a fifth of the estimate
 * of the largest stable one. */
void trio_start(trio *t, double step);
/* Takes steps in all ways. After each the two ways in lanes must have the same bits, and vertices that are
 * kept twice must be the same twice. If a step fails it must fail in all ways with the same sentence, which
 * goes to err; err NULL: it must not fail. */
hb_status trio_run(trio *t, long steps, hb_error *err);
/* Moves every free vertex of the pushed simulation by up to size times its rod's length. */
void trio_push(trio *t, rng *r, double size);
void trio_end(trio *t);

/* Do all rods step in lanes? */
bool trio_all_in_lanes(const trio *t);
/* Has any rod been cut into pieces, any been put into a bundle? */
bool trio_any_pieces(const trio *t);
bool trio_any_bundle(const trio *t);

/* How much two of the simulations differ, each part by its natural size. */
typedef struct trio_gap {
  double x;      /* positions, by rod length */
  double v;      /* velocities, by rod length over time step */
  double force;  /* forces, by what bending makes of an error of position of one rod length */
  double twist;  /* moments, torques, angles: by the moment of one radian over the rod, or by what Newton's
                    system of the  twist makes of round-off */
  double energy; /* totals of work and loss, by all energies in the scene */
} trio_gap;
trio_gap trio_compare(const trio *t, int a, int b);
/* What two ways may differ by after many steps: ten times what a push of 1e-14 at the start has become, and a
 * hundred times the round-off of one step. Velocities are round-off of positions over the time step; energies
 * go with them. */
trio_gap trio_bound(trio_gap pushed);
/* Every part at most as large. */
void trio_check(trio_gap gap, trio_gap allowed, const char *what);
/* Prints it if HEBRA_TEST_VERBOSE is set. */
void trio_say(const char *what, trio_gap gap);

/* ---- random scenes ----------------------------------------------------------------------------------------
 */

/* What is held of a random rod. */
typedef enum lane_ends {
  LANE_FREE,
  LANE_PINNED,       /* one end, or both */
  LANE_CLAMPED,      /* the first edge, not twisted */
  LANE_BOTH_CLAMPED, /* both, one turning, with windings */
  LANE_INNER,        /* frames inside, too: several spans */
  LANE_CARRIED,      /* supports that move along formulas; clamped by tangents */
  LANE_ENDS
} lane_ends;

/* Another rod, of random shape, stiffness, mass and velocity. */
void lanes_add_rod(hb_scene_def *def, rng *r, int nv, lane_ends ends);
/* Makes the last rod that was added general: anisotropic, curved at rest, twisted at rest, or all of it. */
void lanes_make_general(hb_scene_def *def, rng *r);
/* Loads on all rods: gravity, wind, damping, points. */
void lanes_add_loads(hb_scene_def *def, rng *r);

#endif
