/* Cross-sections: against closed forms, a published table, 50-digit sums of the torsion series, and moments
 * that are summed over small squares. */
#include "hebra/curve.h"
#include "support/near.h"

#include <string.h>

static const double pi = 3.14159265358979323846;

/* Computes or fails the test with the sentence. */
static hb_section_moduli moduli(hb_section_kind kind, double a, double b, double E, double G, double rho) {
  const hb_section section = {kind, a, b};
  hb_section_moduli out = {0, 0, 0, 0, 0, 0};
  hb_error err = {HB_OK, ""};
  if (hb_section_compute(&section, E, G, rho, &out, &err) != HB_OK) fail_msg("%s", err.text);
  return out;
}

/* Circle of radius 2: area 4 pi, I = 4 pi, J = 8 pi. */
static void test_circle(void **state) {
  (void)state;
  hb_section_moduli m = moduli(HB_SECTION_CIRCLE, 2, 0, 10, 3, 7);
  assert_near_rel(m.area, 12.566370614359172, 1e-15);
  assert_near_rel(m.B11, 125.66370614359172, 1e-15);
  assert_near_rel(m.B22, 125.66370614359172, 1e-15);
  assert_near_rel(m.beta, 75.398223686155035, 1e-15);
  assert_near_rel(m.mass_per_length, 87.964594300514207, 1e-15);
  assert_near_rel(m.EA, 125.66370614359172, 1e-15);
}

/* Tube: full circle less the bore; nearly solid; thin wall of thickness d: I = pi r^3 d, J = 2 pi r^3 d. */
static void test_tube(void **state) {
  (void)state;
  hb_section_moduli m = moduli(HB_SECTION_TUBE, 3, 2, 1, 1, 1);
  assert_near_rel(m.area, 5 * pi, 1e-15);
  assert_near_rel(m.B11, 65 * pi / 4, 1e-15);
  assert_same(m.B22, m.B11);
  assert_near_rel(m.beta, 65 * pi / 2, 1e-15);
  m = moduli(HB_SECTION_TUBE, 1, 1e-9, 1, 1, 1);
  assert_near_rel(m.B11, pi / 4, 1e-15);
  const double d = 0x1p-30; /* 1 - d and 1 + d are exact */
  m = moduli(HB_SECTION_TUBE, 1 + d / 2, 1 - d / 2, 1, 1, 1);
  assert_near_rel(m.area, 2 * pi * d, 1e-15);
  assert_near_rel(m.B11, pi * d, 1e-15);
  assert_near_rel(m.beta, 2 * pi * d, 1e-15);
}

/* Ellipse: closed forms, the circle as a limit, and what a quarter turn does. */
static void test_ellipse(void **state) {
  (void)state;
  hb_section_moduli m = moduli(HB_SECTION_ELLIPSE, 3, 1, 2, 5, 1);
  assert_near_rel(m.area, 3 * pi, 1e-15);
  assert_near_rel(m.B11, 2 * pi * 27 / 4, 1e-15);
  assert_near_rel(m.B22, 2 * pi * 3 / 4, 1e-15);
  assert_near_rel(m.beta, 5 * pi * 27 / 10, 1e-15);
  hb_section_moduli turned = moduli(HB_SECTION_ELLIPSE, 1, 3, 2, 5, 1);
  assert_near_rel(turned.B11, m.B22, 1e-15);
  assert_near_rel(turned.B22, m.B11, 1e-15);
  assert_near_rel(turned.beta, m.beta, 1e-15);
  hb_section_moduli round = moduli(HB_SECTION_ELLIPSE, 1.7, 1.7, 2, 5, 1),
                    circle = moduli(HB_SECTION_CIRCLE, 1.7, 0, 2, 5, 1);
  assert_near_rel(round.B11, circle.B11, 2e-15);
  assert_near_rel(round.B22, circle.B22, 2e-15);
  assert_near_rel(round.beta, circle.beta, 2e-15);
}

/* Torsion constants of rectangles with sides r and 1: the series summed to 50 digits. */
static void test_rectangle_torsion(void **state) {
  (void)state;
  static const double known[][2] = {{1, 0.1405770149551537},   {1.2, 0.19934269209459016},
                                    {1.5, 0.293641063313316},  {2, 0.45736335423914154},
                                    {2.5, 0.6234126867704659}, {3, 0.7899507930045003},
                                    {4, 1.1232518332307095},   {5, 1.4565837709399443},
                                    {10, 3.123250374572054},   {100, 33.123250374572045}};
  for (size_t k = 0; k < sizeof known / sizeof known[0]; k++) {
    assert_near_rel(moduli(HB_SECTION_RECTANGLE, known[k][0], 1, 1, 1, 1).beta, known[k][1], 1e-15);
    assert_near_rel(moduli(HB_SECTION_RECTANGLE, 1, known[k][0], 1, 1, 1).beta, known[k][1], 1e-15);
    assert_near_rel(moduli(HB_SECTION_RECTANGLE, 3, 3 * known[k][0], 1, 2, 1).beta, 162 * known[k][1], 2e-15);
  }
}

/* The table k_1 of Timoshenko and Goodier, art. 109: J = k_1 a b^3. */
static void test_rectangle_table(void **state) {
  (void)state;
  static const double table[][2] = {{1, 0.1406}, {1.2, 0.166}, {1.5, 0.196}, {2, 0.229},  {2.5, 0.249},
                                    {3, 0.263},  {4, 0.281},   {5, 0.291},   {10, 0.312}, {1e6, 0.3333}};
  for (size_t k = 0; k < sizeof table / sizeof table[0]; k++)
    assert_near(moduli(HB_SECTION_RECTANGLE, table[k][0], 1, 1, 1, 1).beta / table[k][0], table[k][1], 6e-4);
}

/* B11 belongs to bending about m2, which moves the section along m1: it is E times the integral of (place
 * along m1)^2. Summed over small squares, for a section that is longer along m1 than along m2. */
static void test_which_is_which(void **state) {
  (void)state;
  const double a = 2, b = 1;
  double ellipse[2] = {0, 0}, rectangle[2] = {0, 0}, h = 1.0 / 512, weight = h * h;
  for (double x = -a + h / 2; x < a; x += h)
    for (double y = -b + h / 2; y < b; y += h) {
      bool inside = x * x / (a * a) + y * y / (b * b) < 1;
      ellipse[0] += inside ? x * x * weight : 0;
      ellipse[1] += inside ? y * y * weight : 0;
      bool half = fabs(x) < a / 2 && fabs(y) < b / 2; /* width a along m1, height b along m2 */
      rectangle[0] += half ? x * x * weight : 0;
      rectangle[1] += half ? y * y * weight : 0;
    }
  hb_section_moduli m = moduli(HB_SECTION_ELLIPSE, a, b, 1, 1, 1);
  assert_near_rel(m.B11, ellipse[0], 1e-4);
  assert_near_rel(m.B22, ellipse[1], 1e-4);
  assert_true(m.B11 > 3.9 * m.B22);
  m = moduli(HB_SECTION_RECTANGLE, a, b, 1, 1, 1);
  assert_near_rel(m.B11, rectangle[0], 1e-4);
  assert_near_rel(m.B22, rectangle[1], 1e-4);
  assert_near_rel(m.B11, 8.0 / 12, 1e-15);
  assert_near_rel(m.B22, 2.0 / 12, 1e-15);
}

/* Every sentence. */
static void test_sentences(void **state) {
  (void)state;
  const double inf = HUGE_VAL, nan_value = (double)NAN;
#define GREATER ", allowed are finite numbers greater than 0"
  const struct {
    hb_section section;
    double E, G, rho;
    const char *sentence;
  } broken[] = {
      {{HB_SECTION_CIRCLE, 0, 0}, 1, 1, 1, "the radius of the circle is 0" GREATER},
      {{HB_SECTION_CIRCLE, nan_value, 0}, 1, 1, 1, "the radius of the circle is nan" GREATER},
      {{HB_SECTION_TUBE, -1, 0.5}, 1, 1, 1, "the outer radius of the tube is -1" GREATER},
      {{HB_SECTION_TUBE, 1, 0}, 1, 1, 1, "the inner radius of the tube is 0" GREATER},
      {{HB_SECTION_TUBE, 1, 1},
       1,
       1,
       1,
       "the inner radius of the tube is 1, allowed are numbers smaller than its outer radius 1"},
      {{HB_SECTION_ELLIPSE, 0, 1}, 1, 1, 1, "the half-axis of the ellipse along m1 is 0" GREATER},
      {{HB_SECTION_ELLIPSE, 1, inf}, 1, 1, 1, "the half-axis of the ellipse along m2 is inf" GREATER},
      {{HB_SECTION_RECTANGLE, -2, 1}, 1, 1, 1, "the width of the rectangle is -2" GREATER},
      {{HB_SECTION_RECTANGLE, 2, 0}, 1, 1, 1, "the height of the rectangle is 0" GREATER},
      {{HB_SECTION_CIRCLE, 1, 0}, 0, 1, 1, "Young's modulus E is 0" GREATER},
      {{HB_SECTION_CIRCLE, 1, 0}, 1, -1, 1, "the shear modulus G is -1" GREATER},
      {{HB_SECTION_CIRCLE, 1, 0}, 1, 1, nan_value, "the density is nan" GREATER},
      {{(hb_section_kind)7, 1, 1},
       1,
       1,
       1,
       "the kind of section is 7, allowed are circle, tube, ellipse and rectangle"},
      {{HB_SECTION_CIRCLE, 1e-90, 0},
       1,
       1,
       1,
       "the section of sizes 1e-90 and 0 with E = 1, G = 1 and density 1 is beyond the range of numbers; "
       "choose other "
       "units"},
      {{HB_SECTION_RECTANGLE, 1e90, 1e90},
       1,
       1,
       1,
       "the section of sizes 1e+90 and 1e+90 with E = 1, G = 1 and density 1 is beyond the range of numbers; "
       "choose "
       "other units"},
  };
  for (size_t k = 0; k < sizeof broken / sizeof broken[0]; k++) {
    hb_section_moduli out;
    hb_error err = {HB_OK, ""};
    assert_int_equal(
        hb_section_compute(&broken[k].section, broken[k].E, broken[k].G, broken[k].rho, &out, &err),
        HB_ERR_INPUT);
    assert_string_equal(err.text, broken[k].sentence);
    assert_int_equal(err.status, HB_ERR_INPUT);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_circle),          cmocka_unit_test(test_tube),
      cmocka_unit_test(test_ellipse),         cmocka_unit_test(test_rectangle_torsion),
      cmocka_unit_test(test_rectangle_table), cmocka_unit_test(test_which_is_which),
      cmocka_unit_test(test_sentences),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
