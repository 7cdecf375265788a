#include "math/rotation.h"
#include "model/curve_parts.h"

#include <math.h>
#include <string.h>

/* Samples per turn of a torus knot, at least. */
#define SAMPLES_PER_TURN 128
/* Most turns of a torus knot. */
#define TURNS_MAX 1000

typedef struct torus_knot {
  double center[3];
  double R, r;
  double p, q;
} torus_knot;

/* Place and derivative at angle a. */
static void torus_knot_at(const void *context, double a, double position[3], double slope[3]) {
  const torus_knot *k = context;
  double cp = cos(k->p * a), sp = sin(k->p * a), cq = cos(k->q * a), sq = sin(k->q * a);
  double reach = k->R + k->r * cq, inward = -k->r * k->q * sq;
  position[0] = k->center[0] + reach * cp;
  position[1] = k->center[1] + reach * sp;
  position[2] = k->center[2] + k->r * sq;
  slope[0] = inward * cp - reach * k->p * sp;
  slope[1] = inward * sp + reach * k->p * cp;
  slope[2] = k->r * k->q * cq;
}

/* Greatest common divisor of two positive numbers. */
static int common_divisor(int a, int b) {
  while (b != 0) {
    int rest = a % b;
    a = b;
    b = rest;
  }
  return a;
}

/* Ranges of a torus knot's parameters. */
static hb_status check_knot(double R, double r, int p, int q, double part, hb_error *err) {
  if (!(isfinite(R) && r > 0 && r < R))
    return hb_fail(err, HB_ERR_INPUT, "the torus has the radii R = %g and r = %g, allowed are 0 < r < R", R,
                   r);
  if (p < 1 || p > TURNS_MAX || q < 1 || q > TURNS_MAX)
    return hb_fail(err, HB_ERR_INPUT, "the torus knot has p = %d and q = %d, allowed are 1 to %d", p, q,
                   TURNS_MAX);
  int g = common_divisor(p, q);
  if (g > 1)
    return hb_fail(
        err, HB_ERR_INPUT,
        "the torus knot has p = %d and q = %d with the common divisor %d, so it would run %d times over "
        "itself; allowed are numbers without a common divisor, such as p = %d and q = %d",
        p, q, g, g, p / g, q / g);
  if (!(part > 0 && part <= 1))
    return hb_fail(err, HB_ERR_INPUT,
                   "the part of the torus knot is %g, allowed are numbers greater than 0 up to 1", part);
  return HB_OK;
}

/* Equal chords; a whole knot ends exactly where it began. */
hb_status hb_curve_torus_knot(const double center[3], double R, double r, int p, int q, double start,
                              double part, int count, double *xyz, hb_error *err) {
  hb_status status = check_knot(R, r, p, q, part, err);
  if (status == HB_OK) status = hb_curve_check_count(count, part == 1 ? 3 : 2, err);
  if (status == HB_OK) status = hb_curve_check_finite("the centre of the torus knot", center, 3, err);
  if (status == HB_OK) status = hb_curve_check_finite("the start angle of the torus knot", &start, 1, err);
  if (status != HB_OK) return status;
  torus_knot knot = {{center[0], center[1], center[2]}, R, r, p, q};
  hb_path path = {torus_knot_at, &knot, start, start + 2 * HB_PI * part};
  double wanted = fmax(SAMPLES_PER_TURN * (double)(p + q), fmin(8.0 * count, HB_CURVE_COUNT_MAX)) + 1;
  status = hb_path_divide(&path, (int)wanted, count, xyz, err);
  if (status == HB_OK && part == 1) memcpy(xyz + 3 * ((size_t)count - 1), xyz, 3 * sizeof *xyz);
  return status;
}

/* Even steps of the parameter; u runs from 0 to 1 and i counts beside it. */
hb_status hb_curve_formula(hb_formula *const f[3], double from, double to, int count, double *xyz,
                           hb_error *err) {
  hb_status status = hb_curve_check_count(count, 2, err);
  if (status == HB_OK) status = hb_curve_check_finite("the start of the parameter", &from, 1, err);
  if (status == HB_OK) status = hb_curve_check_finite("the end of the parameter", &to, 1, err);
  if (status != HB_OK) return status;
  if (from == to)
    return hb_fail(err, HB_ERR_INPUT,
                   "the parameter of the curve runs from %g to %g, allowed are different numbers", from, to);
  for (int i = 0; i < count; i++) {
    double vars[HB_VAR_COUNT] = {0}, u = (double)i / (count - 1);
    double s = 2 * i <= count - 1 ? from + u * (to - from)
                                  : to - (double)(count - 1 - i) / (count - 1) * (to - from);
    vars[HB_VAR_S] = s;
    vars[HB_VAR_U] = u;
    vars[HB_VAR_I] = i;
    for (int k = 0; k < 3; k++) {
      double value = hb_formula_eval(f[k], vars);
      if (!isfinite(value))
        return hb_fail(err, HB_ERR_INPUT,
                       "the formula '%.80s' for %c is %g at s = %g, allowed are finite numbers",
                       hb_formula_text(f[k]), "xyz"[k], value, s);
      xyz[3 * (size_t)i + (size_t)k] = value;
    }
  }
  return hb_curve_check_edges(xyz, count, err);
}
