/* Formulas and curves when memory runs out: every allocation fails once; nothing is left behind. */
#include "hebra/curve.h"
#include "support/failing_alloc.h"
#include "support/near.h"

#include <stdio.h>
#include <stdlib.h>

static const double points[] = {0, 0, 0, 1, 0.5, 0, 1.5, 2, 0.25, 0.5, 3, 1, -1, 2.5, 1.5};
static const double origin[3] = {0, 0, 0}, right[3] = {1, 0, 0.25}, down[3] = {0, 0, -1};

/* Long enough for its program to grow several times. */
static hb_status formula_trial(void *context, hb_error *err) {
  (void)context;
  hb_formula *formula = NULL;
  hb_status status =
      hb_formula_parse("t + s*(u + x*(y + z*(i + L*(t + s*(u + 2*sin(t)))))) + min(t, s, u, x)", HB_VARS_ALL,
                       NULL, 0, &formula, err);
  if (status != HB_OK) assert_null(formula);
  hb_formula_free(formula);
  return status;
}

/* A formula from a number. */
static hb_status constant_trial(void *context, hb_error *err) {
  (void)context;
  hb_formula *formula = NULL;
  hb_status status = hb_formula_constant(0.1, &formula, err);
  if (status != HB_OK) assert_null(formula);
  hb_formula_free(formula);
  return status;
}

/* All that divides curves. */
static hb_status divide_trial(void *context, hb_error *err) {
  (void)context;
  double xyz[3 * 40];
  hb_status status = hb_curve_spline(points, 5, false, 40, xyz, err);
  if (status == HB_OK) status = hb_curve_spline(points, 5, true, 40, xyz, err);
  if (status == HB_OK) status = hb_curve_catenary(origin, right, down, 1.5, 40, xyz, err);
  if (status == HB_OK) status = hb_curve_torus_knot(origin, 2, 0.5, 2, 3, 0, 1, 40, xyz, err);
  if (status == HB_OK) status = hb_curve_resample(points, 5, 40, xyz, err);
  return status;
}

/* Reads the file named by context. */
static hb_status read_trial(void *context, hb_error *err) {
  double *xyz = NULL;
  int count = 0;
  hb_status status = hb_curve_read(context, &xyz, &count, err);
  if (status != HB_OK) assert_null(xyz);
  hb_curve_free(xyz);
  return status;
}

/* Writes a file, reads it with every allocation failing once, removes it. */
static void read_file(const char *name, bool obj) {
  char path[512];
  const char *scratch = getenv("HEBRA_SCRATCH");
  snprintf(path, sizeof path, "%s/%s", scratch ? scratch : ".", name);
  FILE *file = fopen(path, "w");
  assert_non_null(file);
  for (int i = 0; i < 300; i++) fprintf(file, obj ? "v %d 0 0\n" : "%d,0,0\n", i);
  for (int i = 300; obj && i > 1; i--) fprintf(file, "l %d %d\n", i - 1, i);
  fclose(file);
  assert_in_range(failing_alloc_loop(read_trial, path, 1), 3, 100);
  remove(path);
}

/* Both ways to make a formula. */
static void test_formula(void **state) {
  (void)state;
  assert_in_range(failing_alloc_loop(formula_trial, NULL, 1), 4, 20);
  assert_int_equal(failing_alloc_loop(constant_trial, NULL, 1), 3);
}

/* Three allocations in all for each spline, two for the others. */
static void test_divide(void **state) {
  (void)state;
  assert_int_equal(failing_alloc_loop(divide_trial, NULL, 1), 12);
}

/* Both kinds of file. */
static void test_read(void **state) {
  (void)state;
  read_file("few.csv", false);
  read_file("few.obj", true);
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_formula), cmocka_unit_test(test_divide),
                                     cmocka_unit_test(test_read)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
