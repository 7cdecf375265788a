/* Comparisons of doubles for cmocka tests (its own go through float), with messages that say what differs.
 * Includes cmocka with what it needs. A not-a-number never compares equal. */
#ifndef HB_TEST_NEAR_H
#define HB_TEST_NEAR_H

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

/* |actual - expected| <= tolerance */
#define assert_near(actual, expected, tolerance)                                                             \
  near_check((actual), (expected), (tolerance), #actual, #expected, __FILE__, __LINE__)

/* |actual - expected| <= tolerance * max(|actual|, |expected|) */
#define assert_near_rel(actual, expected, tolerance)                                                         \
  near_check_rel((actual), (expected), (tolerance), #actual, #expected, __FILE__, __LINE__)

/* |actual[i] - expected[i]| <= tolerance for i < count; says where the largest difference is */
#define assert_near_array(actual, expected, count, tolerance)                                                \
  near_check_array((actual), (expected), (size_t)(count), (tolerance), #actual, #expected, __FILE__, __LINE__)

/* The same number, bit for bit up to the sign of zero; a not-a-number fails. */
#define assert_same(actual, expected) assert_near(actual, expected, 0.0)

/* value <= bound */
#define assert_at_most(value, bound) near_check_at_most((value), (bound), #value, #bound, __FILE__, __LINE__)

/* Behind assert_near. */
static inline void near_check(double actual, double expected, double tolerance, const char *actual_text,
                              const char *expected_text, const char *file, int line) {
  double difference = fabs(actual - expected);
  if (difference <= tolerance || (isinf(actual) && actual == expected)) return;
  print_error("%s is %.17g, expected %s = %.17g: differs by %.3g, allowed %.3g\n", actual_text, actual,
              expected_text, expected, difference, tolerance);
  _fail(file, line);
}

/* Behind assert_near_rel. */
static inline void near_check_rel(double actual, double expected, double tolerance, const char *actual_text,
                                  const char *expected_text, const char *file, int line) {
  double difference = fabs(actual - expected), scale = fmax(fabs(actual), fabs(expected));
  if (difference <= tolerance * scale) return;
  print_error("%s is %.17g, expected %s = %.17g: differs by %.3g of its size, allowed %.3g\n", actual_text,
              actual, expected_text, expected, difference / scale, tolerance);
  _fail(file, line);
}

/* Behind assert_near_array. */
static inline void near_check_array(const double *actual, const double *expected, size_t count,
                                    double tolerance, const char *actual_text, const char *expected_text,
                                    const char *file, int line) {
  size_t worst = 0, wrong = 0;
  double largest = -1.0;
  for (size_t i = 0; i < count; i++) {
    double difference = fabs(actual[i] - expected[i]);
    if (difference <= tolerance) continue;
    wrong++;
    if (!(difference <= largest)) {
      largest = isnan(difference) ? HUGE_VAL : difference;
      worst = i;
    }
  }
  if (wrong == 0) return;
  print_error(
      "%s differs from %s in %zu of %zu entries (allowed %.3g), most at [%zu]: %.17g, expected %.17g, "
      "difference %.3g\n",
      actual_text, expected_text, wrong, count, tolerance, worst, actual[worst], expected[worst],
      fabs(actual[worst] - expected[worst]));
  _fail(file, line);
}

/* Behind assert_at_most. */
static inline void near_check_at_most(double value, double bound, const char *value_text,
                                      const char *bound_text, const char *file, int line) {
  if (value <= bound) return;
  print_error("%s is %.17g, allowed at most %s = %.17g\n", value_text, value, bound_text, bound);
  _fail(file, line);
}

#endif
