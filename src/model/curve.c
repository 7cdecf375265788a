#include "hebra/curve.h"

#include "base/memory.h"
#include "math/rotation.h"
#include "model/curve_parts.h"

#include <math.h>

/* Directions closer than this (sine of the angle) count as parallel. */
#define PARALLEL 1e-9

/* Range of the number of vertices. */
hb_status hb_curve_check_count(int count, int least, hb_error *err) {
  if (count >= least && count <= HB_CURVE_COUNT_MAX) return HB_OK;
  return hb_fail(err, HB_ERR_INPUT, "the number of vertices is %d, allowed are %d to %d", count, least,
                 HB_CURVE_COUNT_MAX);
}

/* Names the first number that is not finite. */
hb_status hb_curve_check_finite(const char *what, const double *values, int n, hb_error *err) {
  for (int k = 0; k < n; k++)
    if (!isfinite(values[k]))
      return hb_fail(err, HB_ERR_INPUT, "%s has the value %g, allowed are finite numbers", what, values[k]);
  return HB_OK;
}

/* A not-a-number is refused too. */
hb_status hb_curve_check_positive(const char *what, double value, hb_error *err) {
  if (isfinite(value) && value > 0) return HB_OK;
  return hb_fail(err, HB_ERR_INPUT, "%s is %g, allowed are finite numbers greater than 0", what, value);
}

/* Vertex by vertex. */
hb_status hb_curve_check_edges(const double *xyz, int count, hb_error *err) {
  for (int k = 0; k < count; k++) {
    const double *p = xyz + 3 * (size_t)k;
    if (!isfinite(p[0]) || !isfinite(p[1]) || !isfinite(p[2]))
      return hb_fail(err, HB_ERR_INPUT, "vertex %d of the curve is (%g, %g, %g), which is not finite", k,
                     p[0], p[1], p[2]);
    if (k > 0 && p[0] == p[-3] && p[1] == p[-2] && p[2] == p[-1])
      return hb_fail(err, HB_ERR_INPUT, "vertices %d and %d of the curve coincide at (%g, %g, %g)", k - 1, k,
                     p[0], p[1], p[2]);
  }
  return HB_OK;
}

/* Evenly spaced in the parameter; both ends exact. */
hb_status hb_curve_line(const double a[3], const double b[3], int count, double *xyz, hb_error *err) {
  hb_status status = hb_curve_check_count(count, 2, err);
  if (status == HB_OK) status = hb_curve_check_finite("the start of the line", a, 3, err);
  if (status == HB_OK) status = hb_curve_check_finite("the end of the line", b, 3, err);
  if (status != HB_OK) return status;
  if (a[0] == b[0] && a[1] == b[1] && a[2] == b[2])
    return hb_fail(err, HB_ERR_INPUT,
                   "the line starts and ends at (%g, %g, %g), allowed are two different points", a[0], a[1],
                   a[2]);
  for (int i = 0; i < count; i++)
    for (int k = 0; k < 3; k++) {
      double from_a = (double)i / (count - 1), from_b = (double)(count - 1 - i) / (count - 1);
      /* from the nearer end, so that a curve and its reversal are the same points */
      double near_a = a[k] + from_a * (b[k] - a[k]), near_b = b[k] + from_b * (a[k] - b[k]);
      xyz[3 * (size_t)i + (size_t)k] = 2 * i < count - 1   ? near_a
                                       : 2 * i > count - 1 ? near_b
                                                           : (a[k] + b[k]) / 2;
    }
  return hb_curve_check_edges(xyz, count, err);
}

/* Right-handed orthonormal axes from an axis and a direction that is projected on its plane. */
static hb_status axes(const char *axis_name, const double axis[3], const double start[3], hb_v3 out[3],
                      hb_error *err) {
  hb_status status = hb_curve_check_finite(axis_name, axis, 3, err);
  if (status == HB_OK) status = hb_curve_check_finite("the start direction", start, 3, err);
  if (status != HB_OK) return status;
  double size = hypot(hypot(axis[0], axis[1]), axis[2]), reach = hypot(hypot(start[0], start[1]), start[2]);
  if (!(size > 0)) return hb_fail(err, HB_ERR_INPUT, "%s is (0, 0, 0), a direction is needed", axis_name);
  if (!(reach > 0))
    return hb_fail(err, HB_ERR_INPUT, "the start direction is (0, 0, 0), a direction is needed");
  hb_v3 n = {axis[0] / size, axis[1] / size, axis[2] / size};
  hb_v3 d = {start[0] / reach, start[1] / reach, start[2] / reach};
  n = hb_v3_unit(n);
  d = hb_v3_axpy(d, -hb_v3_dot(d, n), n);
  if (!(hb_v3_norm(d) > PARALLEL))
    return hb_fail(err, HB_ERR_INPUT,
                   "the start direction (%g, %g, %g) is parallel to %s, allowed is any other direction",
                   start[0], start[1], start[2], axis_name);
  d = hb_v3_unit(d);
  d = hb_v3_unit(
      hb_v3_axpy(d, -hb_v3_dot(d, n), n)); /* once more: the first projection may have lost digits */
  out[0] = d;
  out[1] = hb_v3_cross(n, d);
  out[2] = n;
  return HB_OK;
}

/* center + radius (cos a axis1 + sin a axis2) + height axis3 */
static void turned_point(const double center[3], const hb_v3 axis[3], double radius, double angle,
                         double height, double *out) {
  hb_v3 p = hb_v3_load(center);
  p = hb_v3_add(p, hb_v3_scale(radius * cos(angle), axis[0]));
  p = hb_v3_add(p, hb_v3_scale(radius * sin(angle), axis[1]));
  hb_v3_store(out, hb_v3_add(p, hb_v3_scale(height, axis[2])));
}

/* Equal angles; a full turn ends exactly where it began. */
hb_status hb_curve_arc(const double center[3], const double normal[3], const double start_direction[3],
                       double radius, double angle, int count, double *xyz, hb_error *err) {
  hb_v3 axis[3] = {{0, 0, 0}};
  bool full = fabs(fabs(angle) - 2 * HB_PI) <= 1e-12;
  hb_status status = hb_curve_check_count(count, 2, err);
  if (status == HB_OK) status = hb_curve_check_finite("the centre of the arc", center, 3, err);
  if (status == HB_OK) status = hb_curve_check_positive("the radius of the arc", radius, err);
  if (status == HB_OK) status = axes("the normal of the arc", normal, start_direction, axis, err);
  if (status != HB_OK) return status;
  if (!full && !(fabs(angle) > 0 && fabs(angle) < 2 * HB_PI))
    return hb_fail(err, HB_ERR_INPUT,
                   "the angle of the arc is %g, allowed are -2*pi to 2*pi (radians) except 0", angle);
  if (full && count < 3)
    return hb_fail(err, HB_ERR_INPUT, "the number of vertices is %d, a full circle needs at least 3", count);
  for (int i = 0; i < count; i++)
    turned_point(center, axis, radius, angle * ((double)i / (count - 1)), 0, xyz + 3 * (size_t)i);
  if (full)
    for (size_t k = 0; k < 3; k++) xyz[3 * (size_t)(count - 1) + k] = xyz[k];
  return hb_curve_check_edges(xyz, count, err);
}

/* Equal angles and heights. Whole turns are taken off the angle before rounding can spoil it. */
hb_status hb_curve_helix(const double center[3], const double axis_direction[3],
                         const double start_direction[3], double radius, double pitch, double turns,
                         int count, double *xyz, hb_error *err) {
  hb_v3 axis[3] = {{0, 0, 0}};
  hb_status status = hb_curve_check_count(count, 2, err);
  if (status == HB_OK) status = hb_curve_check_finite("the centre of the helix", center, 3, err);
  if (status == HB_OK) status = hb_curve_check_positive("the radius of the helix", radius, err);
  if (status == HB_OK) status = hb_curve_check_finite("the pitch of the helix", &pitch, 1, err);
  if (status == HB_OK) status = hb_curve_check_finite("the number of turns", &turns, 1, err);
  if (status == HB_OK) status = axes("the axis of the helix", axis_direction, start_direction, axis, err);
  if (status != HB_OK) return status;
  if (turns == 0) return hb_fail(err, HB_ERR_INPUT, "the number of turns is 0, allowed is any other number");
  double steps = count - 1;
  for (int i = 0; i < count; i++) {
    double whole = turns * i, rest = fma(turns, i, -whole);
    double turn = (remainder(whole, steps) + rest) / steps;
    turned_point(center, axis, radius, 2 * HB_PI * turn, pitch * fabs(turns) * (i / steps),
                 xyz + 3 * (size_t)i);
  }
  return hb_curve_check_edges(xyz, count, err);
}

/* Sum of the edges. */
double hb_curve_length(const double *xyz, int count) {
  double length = 0;
  for (int i = 1; i < count; i++) {
    const double *p = xyz + 3 * (size_t)i;
    length += hb_v3_norm(hb_v3_sub(hb_v3_load(p), hb_v3_load(p - 3)));
  }
  return length;
}

/* Vertices come from the allocator of the library. */
void hb_curve_free(double *xyz) { hb_free(xyz); }
