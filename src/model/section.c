#include "hebra/curve.h"

#include "math/rotation.h"

#include <math.h>

/* HB_ERR_INPUT unless value is finite and > 0. */
static hb_status positive(const char *what, double value, hb_error *err) {
  if (isfinite(value) && value > 0) return HB_OK;
  return hb_fail(err, HB_ERR_INPUT, "%s is %g, allowed are finite numbers greater than 0", what, value);
}

/* Torsion constant of a rectangle: long h^3 (1/3 - 64/pi^5 (h/long) sum over odd n of tanh(n pi
 * long/(2h))/n^5), h the shorter side. With tanh x = 1 - 2/(e^(2x) + 1) the slow part of the sum is 31/32
 * zeta(5) and the rest is below round-off after a few terms. */
static double rectangle_torsion(double a, double b) {
  double wide = fmax(a, b), thin = fmin(a, b), ratio = wide / thin;
  double sum = 1.0045237627951396; /* 31/32 zeta(5) = sum over odd n of n^-5 */
  for (int n = 1; n <= 13; n += 2) sum -= 2 / (exp(n * HB_PI * ratio) + 1) / pow(n, 5);
  double pi5 = HB_PI * HB_PI * HB_PI * HB_PI * HB_PI;
  return wide * thin * thin * thin * (1.0 / 3 - 64 / pi5 * sum / ratio);
}

/* Area, second moments for bending about m2 (I1) and about m1 (I2), torsion constant. */
typedef struct shape {
  double area, I1, I2, J;
} shape;

/* Bending about m2 moves along m1: its second moment is that of the distance along m1, so a counts cubed in
 * I1. */
static shape measure(const hb_section *s) {
  double a = s->a, b = s->b;
  switch (s->kind) {
  case HB_SECTION_CIRCLE: {
    double I = HB_PI * a * a * a * a / 4;
    return (shape){HB_PI * a * a, I, I, 2 * I};
  }
  case HB_SECTION_TUBE: {
    double ring = (a - b) * (a + b), I = HB_PI * ring * (a * a + b * b) / 4;
    return (shape){HB_PI * ring, I, I, 2 * I};
  }
  case HB_SECTION_ELLIPSE:
    return (shape){HB_PI * a * b, HB_PI * a * a * a * b / 4, HB_PI * a * b * b * b / 4,
                   HB_PI * a * a * a * b * b * b / (a * a + b * b)};
  default: return (shape){a * b, a * a * a * b / 12, a * b * b * b / 12, rectangle_torsion(a, b)};
  }
}

/* The two sizes of a section, by what they are called. */
static hb_status check_sizes(const hb_section *s, hb_error *err) {
  static const char *const names[][2] = {
      {"the radius of the circle", NULL},
      {"the outer radius of the tube", "the inner radius of the tube"},
      {"the half-axis of the ellipse along m1", "the half-axis of the ellipse along m2"},
      {"the width of the rectangle", "the height of the rectangle"}};
  int kind = (int)s->kind;
  if (kind < 0 || kind > HB_SECTION_RECTANGLE)
    return hb_fail(err, HB_ERR_INPUT,
                   "the kind of section is %d, allowed are circle, tube, ellipse and rectangle", kind);
  hb_status status = positive(names[kind][0], s->a, err);
  if (status == HB_OK && names[kind][1]) status = positive(names[kind][1], s->b, err);
  if (status == HB_OK && s->kind == HB_SECTION_TUBE && !(s->b < s->a))
    return hb_fail(err, HB_ERR_INPUT,
                   "the inner radius of the tube is %g, allowed are numbers smaller than its outer radius %g",
                   s->b, s->a);
  return status;
}

/* Moduli times moments. */
hb_status hb_section_compute(const hb_section *section, double E, double G, double rho,
                             hb_section_moduli *out, hb_error *err) {
  hb_status status = check_sizes(section, err);
  if (status == HB_OK) status = positive("Young's modulus E", E, err);
  if (status == HB_OK) status = positive("the shear modulus G", G, err);
  if (status == HB_OK) status = positive("the density", rho, err);
  if (status != HB_OK) return status;
  shape s = measure(section);
  const double values[] = {s.area, E * s.I1, E * s.I2, G * s.J, rho * s.area, E * s.area};
  bool in_range = true;
  for (int k = 0; k < 6; k++) in_range = in_range && values[k] > 0 && isfinite(values[k]);
  *out = (hb_section_moduli){values[0], values[1], values[2], values[3], values[4], values[5]};
  if (in_range) return HB_OK;
  return hb_fail(
      err, HB_ERR_INPUT,
      "the section of sizes %g and %g with E = %g, G = %g and density %g is beyond the range of numbers; "
      "choose other units",
      section->a, section->b, E, G, rho);
}
