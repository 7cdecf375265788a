/* Rods for tests: built by hand or at random, compiled, and evaluated at any shape with the inner parts of
 * the library. Everything here ends the cmocka test that calls it when the library reports an error. */
#ifndef HB_TEST_RODS_H
#define HB_TEST_RODS_H

#include "hebra/hebra.h"
#include "rod/rod.h"
#include "support/rng.h"

/* What a random rod is made of. */
typedef enum rod_family {
  ROD_ISOTROPIC,   /* straight, B = alpha 1, one alpha and one beta */
  ROD_ANISOTROPIC, /* straight, one B, one beta */
  ROD_CURVED,      /* curved at rest, with natural twist; B isotropic or not */
  ROD_VARYING,     /* B and beta vary along the rod; straight or curved; isotropic or not */
  ROD_FAMILY_COUNT
} rod_family;

/* Which material frames are held. */
typedef enum rod_ends {
  ROD_FREE_FREE,
  ROD_CLAMPED_FREE,
  ROD_CLAMPED_CLAMPED,
  ROD_CLAMPED_INNER, /* both ends or one of them, and an edge inside */
  ROD_ENDS_COUNT
} rod_ends;

/* One rod with everything that evaluating it needs. */
typedef struct rod_case {
  hb_scene_def def;
  hb_model *model;
  const hb_rod *rod;
  hb_state *state;
  hb_rod_work work;
  bool work_made;
} rod_case;

/* A scene of one straight rod of nv vertices and edge length h along x: mass 1, B = alpha 1, director y.
 * Free. */
void rod_case_straight(rod_case *c, int nv, double h, double alpha, double beta);
/* A random rod: its initial shape is smooth, its edges have their rest lengths. turns: largest end twist. */
void rod_case_random(rod_case *c, rng *r, rod_family family, rod_ends ends, double turns);
void rod_case_free(rod_case *c);

/* Another support; everything 0. edge or vertex counted as in hb_support_def. */
hb_support_def *rod_add_support(hb_rod_def *def, hb_support_kind kind, int index);
/* Prescribes the angle (a formula of t) or the director (constants) of an edge, or holds a vertex. */
void rod_hold_angle(hb_rod_def *def, int edge, const char *angle);
void rod_hold_director(hb_rod_def *def, int edge, const double director[3], double angle);
void rod_hold_vertex(hb_rod_def *def, int vertex);
/* An array of count doubles, owned by whoever frees it with hb_free. */
double *rod_array(int count);
/* Random E A on every edge, between weak and much stiffer than bending. */
void rod_make_extensible(rod_case *c, rng *r);
/* B = ((b11, b12), (b12, b22)) on every edge. */
void rod_set_bending(hb_rod_def *def, double b11, double b12, double b22);

/* Compiles the definition and makes state and workspace. Done once per case, after which the definition is
 * fixed. */
void rod_case_compile(rod_case *c);
/* The start of a run at positions x (3 per vertex; NULL: the initial shape as it is): frames, relaxed twist,
 * force. */
void rod_case_start(rod_case *c, const double *x);
/* Positions x (NULL: as they are) at time t: frames carried, twist solved, force. */
void rod_case_evaluate(rod_case *c, const double *x, double t);
/* Material angles of all edges (nv - 1) against the Bishop frame from the anchor director; windings in
 * differences. */
void rod_case_angles(rod_case *c, double *theta);
/* Directors of all edges, 3 each. */
void rod_case_directors(rod_case *c, double *m1);
/* Elastic force on the vertices, 3 each. */
const double *rod_case_force(const rod_case *c);

/* A smooth random polyline whose edges have the given lengths. bend: largest angle between neighbouring
 * edges, about. */
void rod_random_shape(rng *r, int nv, const double *lengths, double bend, double *x);
/* A random rotation matrix, row by row. */
void rod_random_rotation(rng *r, double rotation[9]);
/* out = rotation a (+ shift, which may be NULL), for count vectors; out may be a. */
void rod_move(const double rotation[9], const double *shift, const double *a, int count, double *out);
/* Largest absolute entry; largest absolute difference of two arrays. */
double rod_largest(const double *a, int count);
double rod_difference(const double *a, const double *b, int count);

#endif
