/* Symmetric banded L D L^T: answers, inertia, dropped pivots. */
#include "math/banded.h"
#include "support/near.h"
#include "support/rng.h"

#include <string.h>

enum { N = 60, ROOM = (N + 12) * 13 };

/* A random matrix L D L^T with given signs in D (all pivots between 0.5 and 2), L unit lower with entries up
 * to 0.4. Returns the number of negative pivots. */
static int random_matrix(hb_band *m, rng *r, double negative_share) {
  double L[N][N] = {{0}}, D[N];
  int negative = 0;
  for (int j = 0; j < m->n; j++) {
    bool minus = rng_uniform(r, 0, 1) < negative_share;
    D[j] = rng_uniform(r, 0.5, 2) * (minus ? -1 : 1);
    negative += minus;
    L[j][j] = 1;
    for (int k = 1; k <= m->half && j + k < m->n; k++) L[j + k][j] = rng_uniform(r, -0.4, 0.4);
  }
  hb_band_clear(m);
  for (int j = 0; j < m->n; j++)
    for (int i = j; i <= j + m->half && i < m->n; i++) {
      double sum = 0;
      for (int k = 0; k <= j; k++) sum += L[i][k] * D[k] * L[j][k];
      hb_band_add(m, i, j, sum);
    }
  return negative;
}

/* Solving gives back what was multiplied; the pivots tell the inertia; for many widths, that of statics (12)
 * too. */
static void factor_and_solve(void **state) {
  (void)state;
  rng r = rng_start(11);
  static const int halves[] = {0, 1, 2, 5, 10, 12};
  for (size_t h = 0; h < sizeof halves / sizeof halves[0]; h++)
    for (int trial = 0; trial < 20; trial++) {
      double a[ROOM], factors[ROOM], scratch[N + 12], x[N], b[N + 12];
      int n = rng_int(&r, 1, N);
      hb_band m = {n, halves[h], a}, f = {n, halves[h], factors};
      int negative = random_matrix(&m, &r, trial % 3 == 0 ? 0 : 0.4);
      memcpy(factors, a, hb_band_size(n, m.half) * sizeof *a);
      for (int k = 0; k < n; k++) x[k] = rng_uniform(&r, -1, 1);
      hb_band_multiply(&m, x, b);
      hb_inertia found = hb_band_factor(&f, 1e-14, scratch);
      assert_int_equal(found.negative, negative);
      assert_int_equal(found.positive, n - negative);
      assert_int_equal(found.dropped, 0);
      hb_band_solve(&f, b);
      assert_near_array(b, x, n, 1e-9 * found.growth);
      assert_at_most(found.growth, 1e4);
    }
}

/* The product against the definition, entry by entry. */
static void multiply(void **state) {
  (void)state;
  double a[ROOM], e[N] = {0}, out[N];
  rng r = rng_start(12);
  hb_band m = {N, 7, a};
  (void)random_matrix(&m, &r, 0.5);
  for (int j = 0; j < N; j++) {
    e[j] = 1;
    hb_band_multiply(&m, e, out);
    for (int i = 0; i < N; i++) {
      int low = i < j ? i : j, high = i < j ? j : i;
      assert_same(out[i], high - low <= 7 ? a[8 * low + high - low] : 0);
    }
    e[j] = 0;
  }
}

/* A chain of springs that nothing holds: the last pivot is round-off, is dropped, and its unknown stays 0. */
static void singular(void **state) {
  (void)state;
  double a[ROOM], scratch[N + 1], b[N + 1];
  hb_band m = {N, 1, a};
  hb_band_clear(&m);
  for (int j = 0; j + 1 < N; j++) {
    double k = 0.1 + 0.013 * j;
    hb_band_add(&m, j, j, k);
    hb_band_add(&m, j + 1, j + 1, k);
    hb_band_add(&m, j + 1, j, -k);
  }
  hb_inertia found = hb_band_factor(&m, 1e-13, scratch);
  assert_int_equal(found.positive, N - 1);
  assert_int_equal(found.dropped, 1);
  memset(b, 0, sizeof b);
  b[0] = -1; /* pulls the first against the last */
  b[N - 1] = 1;
  hb_band_solve(&m, b);
  assert_same(b[N - 1], 0);
  double stretch = 0;
  for (int j = 0; j + 1 < N; j++) stretch += 1 / (0.1 + 0.013 * j);
  assert_near_rel(-b[0], stretch, 1e-12);
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(factor_and_solve), cmocka_unit_test(multiply),
                                     cmocka_unit_test(singular)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
