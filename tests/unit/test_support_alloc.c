/* The tests' own tools: failing allocations, comparisons of doubles, random numbers. */
#include "base/memory.h"
#include "support/failing_alloc.h"
#include "support/near.h"
#include "support/rng.h"

#include <string.h>

/* Two allocations, with everything right. */
static hb_status two_blocks(void *context, hb_error *err) {
  (void)context;
  char *a = hb_alloc(3, 4);
  if (!a) return hb_fail_memory(err, "first block");
  char *b = hb_strdup("second");
  hb_free(a);
  if (!b) return hb_fail_memory(err, "second block");
  hb_free(b);
  return HB_OK;
}

/* The loop tries every allocation, also in steps, and counts them. */
static void loop_counts(void **state) {
  (void)state;
  assert_int_equal(failing_alloc_loop(two_blocks, NULL, 1), 2);
  assert_int_equal(failing_alloc_loop(two_blocks, NULL, 5), 2);
}

/* The n-th allocation fails, no other; realloc too, and it leaves its block alive. */
static void only_nth_fails(void **state) {
  (void)state;
  long live = failing_alloc_live();
  failing_alloc_arm(2);
  char *a = hb_alloc(1, 1), *b = hb_alloc(1, 1), *c = hb_alloc(1, 1);
  assert_true(failing_alloc_disarm());
  assert_non_null(a);
  assert_null(b);
  assert_non_null(c);
  assert_int_equal(failing_alloc_live(), live + 2);
  failing_alloc_arm(1);
  assert_null(hb_realloc(a, 100, 1));
  assert_true(failing_alloc_disarm());
  assert_int_equal(failing_alloc_live(), live + 2);
  a = hb_realloc(a, 100, 1);
  assert_non_null(a);
  assert_int_equal(failing_alloc_live(), live + 2);
  hb_free(a);
  hb_free(c);
  assert_int_equal(failing_alloc_live(), live);
  failing_alloc_arm(1);
  assert_false(failing_alloc_disarm());
}

/* Comparisons pass where they have to; wrong_ones_fail shows that they fail elsewhere. */
static void near_passes(void **state) {
  (void)state;
  const double a[] = {1, 2, 3}, b[] = {1, 2 + 1e-13, 3};
  assert_near(1.0, 1.0 + 1e-13, 1e-12);
  assert_near(-(double)INFINITY, -(double)INFINITY, 0);
  assert_near_rel(1e9, 1e9 + 0.1, 1e-9);
  assert_near_rel(0.0, 0.0, 0.0);
  assert_near_array(a, b, 3, 1e-12);
  assert_same(0.1 + 0.2, 0.30000000000000004);
  assert_at_most(1.0, 1.0);
}

/* From here on: wrong comparisons, each of which has to fail its test. Off by more than is allowed. */
static void wrong_near(void **state) {
  (void)state;
  assert_near(1.0, 1.0 + 1e-11, 1e-12);
}

/* Too far apart for equal, close enough for float. */
static void wrong_float(void **state) {
  (void)state;
  assert_same(1.0, 1.0 + 1e-15);
}

/* Not a number, against any tolerance. */
static void wrong_nan(void **state) {
  (void)state;
  assert_near((double)NAN, 1.0, 1e300);
}

/* A tenth is more than a twentieth. */
static void wrong_rel(void **state) {
  (void)state;
  assert_near_rel(1.0, 1.1, 0.05);
}

/* One entry that is not a number. */
static void wrong_array(void **state) {
  (void)state;
  const double a[] = {1, 2, (double)NAN}, b[] = {1, 2, 3};
  assert_near_array(a, b, 3, 1e300);
}

/* Not a number is below nothing. */
static void wrong_bound(void **state) {
  (void)state;
  assert_at_most((double)NAN, 1.0);
}

/* Leaves a block behind when the second allocation fails. */
static hb_status leaks(void *context, hb_error *err) {
  char **kept = context;
  char *a = hb_alloc(3, 4);
  if (!a) return hb_fail_memory(err, "first block");
  char *b = hb_alloc(1, 1);
  if (!b) {
    *kept = a;
    return hb_fail_memory(err, "second block");
  }
  hb_free(a);
  hb_free(b);
  return HB_OK;
}

/* A trial that loses a block. */
static void wrong_leak(void **state) { failing_alloc_loop(leaks, *state, 1); }

/* Goes on as if nothing had happened. */
static hb_status ignores(void *context, hb_error *err) {
  (void)context;
  (void)err;
  hb_free(hb_alloc(1, 1));
  return HB_OK;
}

/* A trial that hides the failure. */
static void wrong_status(void **state) {
  (void)state;
  failing_alloc_loop(ignores, NULL, 1);
}

/* Every wrong comparison fails; what it prints is not wanted. */
static void wrong_ones_fail(void **state) {
  (void)state;
  static char *kept;
  static char **where = &kept;
  const struct CMUnitTest wrong[] = {
      cmocka_unit_test(wrong_near),
      cmocka_unit_test(wrong_float),
      cmocka_unit_test(wrong_nan),
      cmocka_unit_test(wrong_rel),
      cmocka_unit_test(wrong_array),
      cmocka_unit_test(wrong_bound),
      cmocka_unit_test_prestate(wrong_leak, (void *)&where),
      cmocka_unit_test(wrong_status),
  };
  assert_int_equal(cmocka_run_group_tests_name("meant to fail", wrong, NULL, NULL),
                   sizeof wrong / sizeof wrong[0]);
  hb_free(kept);
}

/* Random numbers: named by seed and counter, in range, with the right mean and spread. */
static void random_numbers(void **state) {
  (void)state;
  rng a = rng_start(5), b = rng_start(5), c = rng_start(6);
  double mean = 0, square = 0, direction[3];
  int low = 0, high = 0;
  for (int i = 0; i < 20000; i++) {
    uint64_t bits = rng_bits(&a);
    assert_true(bits == rng_bits(&b));
    assert_true(bits != rng_bits(&c));
  }
  for (int i = 0; i < 20000; i++) {
    double u = rng_uniform(&a, -1, 3), n = rng_normal(&a);
    int k = rng_int(&a, -2, 2);
    assert_true(u >= -1 && u < 3 && k >= -2 && k <= 2);
    low += k == -2;
    high += k == 2;
    mean += u / 20000;
    square += n * n / 20000;
  }
  assert_near(mean, 1.0, 0.04);
  assert_near(square, 1.0, 0.04);
  assert_near(low, 4000, 250);
  assert_near(high, 4000, 250);
  rng_direction(&a, direction);
  assert_near(direction[0] * direction[0] + direction[1] * direction[1] + direction[2] * direction[2], 1,
              1e-15);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(loop_counts),     cmocka_unit_test(only_nth_fails), cmocka_unit_test(near_passes),
      cmocka_unit_test(wrong_ones_fail), cmocka_unit_test(random_numbers),
  };
  return cmocka_run_group_tests_name("support", tests, NULL, NULL);
}
