/* The energy of one rod from its definition, written a second time and in another way than in the library:
 * Bishop frames by rotation matrices, every length, rest curvature and rest twist from the definition,
 * complex arithmetic throughout, so that a step of 1e-30 along the imaginary axis gives exact derivatives
 * (complex step).
 *
 * Held edges: their directors are carried by time-parallel transport from the reference shape, so their angle
 * against the Bishop frame follows the holonomy, windings and all. */
#ifndef HB_TEST_ENERGY_H
#define HB_TEST_ENERGY_H

#include "hebra/model.h"

#include <complex.h>
#include <string.h>

/* re + i im, also where CMPLX is missing (clang 14 with glibc). */
static inline double complex rod_complex(double re, double im) {
  double parts[2] = {re, im};
  double complex z;
  memcpy(&z, parts, sizeof z);
  return z;
}

typedef struct rod_energy {
  const hb_rod_def *def;
  int nv;
  double *voronoi;               /* per vertex: l_i */
  double *rest_omega;            /* 4 per vertex */
  double *rest_twist;            /* per vertex */
  double u0[3];                  /* reference: director of the first Bishop frame */
  double *tangent;               /* 3 per edge: reference */
  double *held_m1;               /* 3 per edge: reference, where held */
  double *theta;                 /* per edge: reference */
  bool *held;                    /* per edge */
  double complex *t, *u, *angle; /* 3, 3, 1 per edge: at the last shape */
  double complex *omega;         /* 4 per vertex: at the last shape */
  double *solved;                /* per edge: angles at the last solve */
} rod_energy;

void rod_energy_create(rod_energy *e, const hb_rod_def *def);
void rod_energy_free(rod_energy *e);
/* Reference: positions x, Bishop director u0 of the first edge, angles theta; held may be NULL (taken from
 * the definition's supports). Held directors are the Bishop directors turned by theta. */
void rod_energy_bind(rod_energy *e, const double *x, const double u0[3], const double *theta);
/* Energy at shape x with the free edges' angles as given; part[0], part[1] (may be NULL): bending and
 * twisting. */
double complex rod_energy_value(rod_energy *e, const double complex *x, const double *theta);
/* The same at the reference's angles, the vertex coordinate k moved by step; real arithmetic inside where
 * step is. */
double complex rod_energy_moved(rod_energy *e, const double *x, int k, double complex step);
/* Coordinate k moved by step (real) and the twist solved again, Newton from the reference's angles to
 * round-off. */
double rod_energy_resolved(rod_energy *e, const double *x, int k, double step);
/* dE/dx of coordinate k by finite differences of the energy with the twist solved again, extrapolated from
 * the step given downwards (Ridders 1982). */
double rod_energy_slope(rod_energy *e, const double *x, int k, double step);
/* dE/dtheta of all edges at the last shape with angles theta; the size of the terms it is made of is
 * returned. */
double rod_energy_gradient(const rod_energy *e, const double *theta, double *gradient);
/* One plain Newton step of the free angles theta at the last shape, with no guard of any kind (a direction
 * without stiffness is left alone). Returns the largest change. */
double rod_energy_newton(rod_energy *e, double *theta);
/* Diagonal of d2E/dtheta2 at the last shape; the entry between edges i-1 and i is -2 beta_i/l_i. */
void rod_energy_hessian(const rod_energy *e, const double *theta, double *diagonal);

#endif
