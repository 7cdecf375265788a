#include "math/vec3.h"
#include "model/curve_parts.h"

#include <float.h>
#include <math.h>

/* Least horizontal distance of the ends, as a share of the length: below, the rope folds back on itself. */
#define FOLDED 1e-6
/* Places that show the shape, at least. */
#define SAMPLES 2049

/* A catenary by its arc length p from the first end, in the plane of `across` (horizontal) and `up`. */
typedef struct catenary {
  double start[3];
  hb_v3 across, up;
  double scale;     /* radius of curvature at the lowest point */
  double from;      /* arc from the lowest point to the first end, in units of scale */
  double from_root; /* sqrt(1 + from^2) */
} catenary;

/* sinh(w)/w - 1 to round-off for small w too. */
static double sinhc_minus_1(double w) {
  double q = w * w;
  if (w > 1) return sinh(w) / w - 1;
  double sum = 0;
  for (int k = 12; k >= 1; k--) sum = (1 + sum) * q / (2.0 * k * (2.0 * k + 1));
  return sum;
}

/* Half span over scale, w with sinh(w)/w = 1 + excess. Newton on the logarithm, which is nearly straight for
 * slack ropes and quadratic for taut ones; both converge from the right. */
static double solve_half_span(double excess) {
  double target = log1p(excess), w = excess < 1 ? sqrt(6 * excess) : target + log(2 * target + 4);
  for (int round = 0; round < 60; round++) {
    double value = w > 20 ? w - log(2 * w) : log1p(sinhc_minus_1(w));
    double coth = 1 / tanh(w);
    double slope = w < 0.1 ? w / 3 - w * w * w / 45 : coth - 1 / w;
    double step = (value - target) / slope;
    w -= step;
    if (fabs(step) <= 2 * DBL_EPSILON * w) break;
  }
  return w;
}

/* Place and tangent at arc length p. Both are written as differences from the first end, without
 * cancellation. */
static void catenary_at(const void *context, double p, double position[3], double slope[3]) {
  const catenary *c = context;
  double v = c->from, step = p / c->scale, u = v + step;
  double root = sqrt(1 + u * u), root_v = c->from_root;
  /* asinh(u) - asinh(v) = asinh(u sqrt(1+v^2) - v sqrt(1+u^2)); on one side of the lowest point by
   * conjugation */
  double argument = u * v > 0 ? step * (u + v) / (u * root_v + v * root) : u * root_v - v * root;
  double x = c->scale * asinh(argument), y = p * (u + v) / (root + root_v);
  hb_v3 place = hb_v3_add(hb_v3_scale(x, c->across), hb_v3_scale(y, c->up));
  hb_v3 tangent = hb_v3_add(hb_v3_scale(1 / root, c->across), hb_v3_scale(u / root, c->up));
  hb_v3_store(position, hb_v3_add(hb_v3_load(c->start), place));
  hb_v3_store(slope, tangent);
}

/* Shape from span (> 0, along across), rise (along up) and length. */
static void catenary_shape(catenary *c, double span, double rise, double length) {
  double flat = sqrt((length - rise) * (length + rise)); /* the length that a rope without rise would have */
  double chord = hypot(span, rise);
  double excess = (length - chord) * (length + chord) / (span * (flat + span));
  double w = solve_half_span(excess);
  c->scale = span / (2 * w);
  /* the tangent half-way between the ends (in x) is rise/length */
  double middle = 0.5 * (log1p(rise / length) - log1p(-rise / length));
  c->from = sinh(middle - w);
  c->from_root = cosh(middle - w);
}

/* Plane of the rope: across is the horizontal direction from a to b. */
static hb_status catenary_plane(const double a[3], const double b[3], const double down[3], double length,
                                catenary *c, double *span, double *rise, hb_error *err) {
  double size = hypot(hypot(down[0], down[1]), down[2]);
  if (!(size > 0))
    return hb_fail(err, HB_ERR_INPUT, "the down direction is (0, 0, 0), a direction is needed");
  hb_v3 chord = hb_v3_sub(hb_v3_load(b), hb_v3_load(a));
  c->up = hb_v3_unit((hb_v3){-down[0] / size, -down[1] / size, -down[2] / size});
  double distance = hb_v3_norm(chord);
  if (!(length > distance))
    return hb_fail(
        err, HB_ERR_INPUT,
        "the length of the catenary is %.17g, allowed are numbers greater than the distance of its ends, "
        "%.17g",
        length, distance);
  *rise = hb_v3_dot(chord, c->up);
  hb_v3 flat = hb_v3_axpy(chord, -*rise, c->up);
  *span = hb_v3_norm(flat);
  if (!(*span > FOLDED * length))
    return hb_fail(
        err, HB_ERR_INPUT,
        "the ends of the catenary are %g apart horizontally, allowed are at least %g times its length; "
        "closer, it folds back on itself",
        *span, FOLDED);
  c->across = hb_v3_unit(flat);
  return HB_OK;
}

/* Solves for the shape, then equal chords on it. */
hb_status hb_curve_catenary(const double a[3], const double b[3], const double down[3], double length,
                            int count, double *xyz, hb_error *err) {
  catenary c = {{a[0], a[1], a[2]}, {0, 0, 0}, {0, 0, 0}, 0, 0, 0};
  double span = 0, rise = 0;
  hb_status status = hb_curve_check_count(count, 2, err);
  if (status == HB_OK) status = hb_curve_check_finite("the first end of the catenary", a, 3, err);
  if (status == HB_OK) status = hb_curve_check_finite("the last end of the catenary", b, 3, err);
  if (status == HB_OK) status = hb_curve_check_finite("the down direction", down, 3, err);
  if (status == HB_OK) status = hb_curve_check_positive("the length of the catenary", length, err);
  if (status == HB_OK) status = catenary_plane(a, b, down, length, &c, &span, &rise, err);
  if (status != HB_OK) return status;
  catenary_shape(&c, span, rise, length);
  hb_path path = {catenary_at, &c, 0, length};
  int samples = count > SAMPLES / 8 && count < HB_CURVE_COUNT_MAX / 8 ? 8 * count + 1 : SAMPLES;
  status = hb_path_divide(&path, samples > count ? samples : count + 1, count, xyz, err);
  if (status != HB_OK) return status;
  for (size_t k = 0; k < 3; k++) xyz[3 * ((size_t)count - 1) + k] = b[k];
  return HB_OK;
}
