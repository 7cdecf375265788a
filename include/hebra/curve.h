/* hebra/curve.h - polylines to start a rod from, and cross-sections to give it stiffness and mass.
 *
 * All generators write count vertices as (vertex, xyz) into xyz[3*count]; lengths in the user's unit, angles
 * in radians. They return HB_ERR_INPUT with a sentence when a parameter is out of range. */
#ifndef HEBRA_CURVE_H
#define HEBRA_CURVE_H

#include "hebra/base.h"
#include "hebra/formula.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Straight from a to b. count >= 2, a != b. */
hb_status hb_curve_line(const double a[3], const double b[3], int count, double *xyz, hb_error *err);
/* Circular arc about center, starting at center + radius * axis1 and turning towards axis2 = normal x axis1
 * by angle (radians, either sign, 0 < |angle| <= 2 pi). start_direction is projected on the plane of normal
 * and gives axis1. */
hb_status hb_curve_arc(const double center[3], const double normal[3], const double start_direction[3],
                       double radius, double angle, int count, double *xyz, hb_error *err);
/* Helix about axis through center, first vertex in start_direction, advance pitch per turn (pitch < 0: to
 * -axis), turns > 0 right-handed about axis, turns < 0 left-handed. */
hb_status hb_curve_helix(const double center[3], const double axis[3], const double start_direction[3],
                         double radius, double pitch, double turns, int count, double *xyz, hb_error *err);
/* Catenary of given length hung between a and b, gravity along down; equal edges of the *polygon's* arc.
 * length > |b - a|. */
hb_status hb_curve_catenary(const double a[3], const double b[3], const double down[3], double length,
                            int count, double *xyz, hb_error *err);
/* Cubic spline (natural, centripetal parameter) through n >= 2 points, sampled at equal arc length. */
hb_status hb_curve_spline(const double *points, int n, bool closed, int count, double *xyz, hb_error *err);
/* Torus knot ((R + r cos q a) cos p a, (R + r cos q a) sin p a, r sin q a), a = start .. start + 2 pi * part,
 * 0 < part <= 1; p, q >= 1. A trefoil is p = 2, q = 3. */
hb_status hb_curve_torus_knot(const double center[3], double R, double r, int p, int q, double start,
                              double part, int count, double *xyz, hb_error *err);
/* x(p), y(p), z(p): formulas whose variable `s` runs evenly from `from` to `to`. */
hb_status hb_curve_formula(hb_formula *const f[3], double from, double to, int count, double *xyz,
                           hb_error *err);
/* Vertices from a CSV file (three columns, optional header, # comments) or an OBJ polyline (v and l lines).
 * *xyz is allocated (free with hb_curve_free). Sentences carry path:line. */
hb_status hb_curve_read(const char *path, double **xyz, int *count, hb_error *err);
void hb_curve_free(double *xyz);
/* Resamples a polyline of n vertices to count vertices at equal edge lengths (chords, solved to 1e-13). */
hb_status hb_curve_resample(const double *points, int n, int count, double *xyz, hb_error *err);
double hb_curve_length(const double *xyz, int count);

typedef enum hb_section_kind {
  HB_SECTION_CIRCLE,
  HB_SECTION_TUBE,
  HB_SECTION_ELLIPSE,
  HB_SECTION_RECTANGLE
} hb_section_kind;

/* A cross-section. a and b are the half-axes along m1 and m2 (ellipse), or width along m1 and height along m2
 * (rectangle), or radius and 0 (circle), or outer and inner radius (tube). */
typedef struct hb_section {
  hb_section_kind kind;
  double a, b;
} hb_section;

/* What a section of Young's modulus E, shear modulus G and density rho amounts to.
 * B11 is the stiffness for omega_1 = kb.m2 (bending about m2), B22 for omega_2 = -kb.m1 (bending about m1).
 */
typedef struct hb_section_moduli {
  double area, B11, B22, beta, mass_per_length, EA;
} hb_section_moduli;

/* Ellipse: Saint-Venant beta = G pi a^3 b^3/(a^2+b^2); rectangle: the series solution to round-off
 * (Timoshenko and Goodier, Theory of Elasticity, art. 109). All inputs > 0, tube inner < outer. */
hb_status hb_section_compute(const hb_section *section, double E, double G, double rho,
                             hb_section_moduli *out, hb_error *err);

#ifdef __cplusplus
}
#endif
#endif
