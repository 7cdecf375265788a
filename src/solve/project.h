/* Fast projection onto the lengths of a rod: tridiagonal, mass-weighted, to any tolerance (docs/theory, 6).
 */
#ifndef HB_SOLVE_PROJECT_H
#define HB_SOLVE_PROJECT_H

#include "hebra/model.h"

/* Arrays for the longest rod. */
typedef struct hb_project_work {
  double *gradient;     /* 3 per edge: dC_j/dx_{j+1} now */
  double *direction;    /* 3 per edge: the gradient that corrections go along, where it is another one */
  double *pivot;        /* per edge: 1/pivot */
  double *link;         /* per edge: how the row before it in the elimination depends on it */
  double *corner;       /* per edge of a closed rod: how it depends on the first edge */
  double *right;        /* per edge: right-hand sides, then unknowns */
  double *support_pull; /* 3 per prescribed vertex of the model: what corrections along fixed directions
                           pulled it by; over h^2 the constraint force on it */
  double *block;
  size_t bytes;
} hb_project_work;

hb_status hb_project_work_create(const hb_model *model, hb_project_work *work, hb_error *err);
void hb_project_work_free(hb_project_work *work);

/* How a projection went. */
typedef struct hb_projection {
  int iterations;
  double error;  /* max |C_j|/|e-bar^j| (or max |C_j| for an absolute tolerance) at the end */
  int edge;      /* where it was largest at the last look, slot */
  bool singular; /* the rows hang on each other: the rod is taut and straight between its supports */
} hb_projection;

/* Moves the free coordinates x (3 per slot) of one rod until every edge has its length to the model's
 * tolerance, and v by the same over h. x_old NULL: fast projection, each correction along the gradient at the
 * current iterate (Goldenthal et al. 2007). x_old not NULL: corrections along the gradient at x_old (SHAKE;
 * Ryckaert et al. 1977). lambda (per slot, may be NULL): set to the sum of the
 * multipliers, as the pull per edge vector; with x_old its entry value is the first guess. HB_ERR_NUMERIC
 * with edge and error if the tolerance is not reached. Extensible rods have no lengths to keep: here and
 * below nothing moves, and multipliers are 0. */
hb_status hb_project_positions(const hb_model *model, const hb_rod *rod, double *x, double *v, double h,
                               const double *x_old, double *lambda, hb_project_work *work,
                               hb_projection *result, hb_error *err);

/* Takes the stretching part out of the velocities v: dC/dt = 0 at x (RATTLE; Andersen 1983). One linear
 * solve; leaves the multipliers (impulses: v -= M^-1 G^T mu) in work->right. */
void hb_project_velocities(const hb_model *model, const hb_rod *rod, const double *x, double *v,
                           hb_project_work *work);

/* Multipliers at this instant: forces f, velocities v and prescribed accelerations a (3 per slot; read where
 * the inverse mass is 0) such that all d2C/dt2 = 0. The constraint force on vertex j+1 is -lambda_j
 * dC_j/dx_{j+1}; the tension of edge j is lambda_j |dC_j/dx_{j+1}|. lambda: per edge of the rod, from 0. */
void hb_project_tension(const hb_model *model, const hb_rod *rod, const double *x, const double *v,
                        const double *f, const double *a, double *lambda, hb_project_work *work);

/* Largest relative length error ||e|/|e-bar| - 1| of one rod; 0 if it is extensible. */
double hb_project_length_error(const hb_model *model, const hb_rod *rod, const double *x);

#endif
