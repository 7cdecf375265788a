/* Eigenvalues of symmetric tridiagonal matrices against a matrix whose eigenvalues are known, and against the
 * matrices themselves. */
#include "math/tridiagonal.h"

#include "support/near.h"
#include "support/rng.h"

#include <string.h>

enum { MOST = 60 };

/* Increasing order. */
static void sort(int n, double *a) {
  for (int i = 1; i < n; i++)
    for (int k = i; k > 0 && a[k] < a[k - 1]; k--) {
      double swap = a[k];
      a[k] = a[k - 1];
      a[k - 1] = swap;
    }
}

/* Second differences: 2 - 2 cos(k pi/(n + 1)). */
static void second_differences(void **state) {
  (void)state;
  for (int n = 1; n <= MOST; n++) {
    double d[MOST], e[MOST] = {0}, Q[1] = {0};
    for (int k = 0; k < n; k++) d[k] = 2;
    for (int k = 0; k + 1 < n; k++) e[k] = -1;
    assert_true(hb_tridiagonal_eigen(n, d, e, 0, Q));
    sort(n, d);
    for (int k = 0; k < n; k++)
      assert_near(d[k], 2 - 2 * cos((k + 1) * 3.14159265358979323846 / (n + 1)), 1e-14);
  }
}

/* Random matrices, some in blocks: A q = eigenvalue q for every column, columns orthonormal; one row of the
 * identity gives that row of Q. */
static void vectors(void **state) {
  (void)state;
  rng r = rng_start(7);
  for (int trial = 0; trial < 40; trial++) {
    int n = rng_int(&r, 1, 30), row = rng_int(&r, 0, n - 1);
    double a[MOST], b[MOST], d[2][MOST], e[MOST], Q[30 * 30] = {0}, one[30] = {0};
    for (int k = 0; k < n; k++) {
      a[k] = rng_normal(&r) * (trial % 3 == 0 ? pow(10, rng_int(&r, -6, 6)) : 1);
      b[k] = rng_int(&r, 0, 4) == 0 ? 0 : rng_normal(&r);
      Q[n * k + k] = 1;
    }
    one[row] = 1;
    for (int once = 0; once < 2; once++) {
      memcpy(d[once], a, sizeof a);
      memcpy(e, b, sizeof b);
      assert_true(hb_tridiagonal_eigen(n, d[once], e, once ? 1 : n, once ? one : Q));
    }
    double size = 1;
    for (int k = 0; k < n; k++) size = fmax(size, fabs(d[0][k]));
    for (int c = 0; c < n; c++) {
      assert_same(d[0][c], d[1][c]);
      assert_same(Q[n * row + c], one[c]);
      for (int k = 0; k < n; k++) {
        double left = a[k] * Q[n * k + c];
        if (k > 0) left += b[k - 1] * Q[n * (k - 1) + c];
        if (k + 1 < n) left += b[k] * Q[n * (k + 1) + c];
        assert_near(left, d[0][c] * Q[n * k + c], 1e-13 * size);
      }
      for (int other = 0; other <= c; other++) {
        double dot = 0;
        for (int k = 0; k < n; k++) dot += Q[n * k + c] * Q[n * k + other];
        assert_near(dot, other == c, 1e-13);
      }
    }
  }
}

/* Not a number: no endless search. */
static void not_a_number(void **state) {
  (void)state;
  double d[3] = {1, (double)NAN, 2}, e[2] = {1, 1}, Q[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  assert_false(hb_tridiagonal_eigen(3, d, e, 3, Q) && isfinite(d[0]) && isfinite(d[1]) && isfinite(d[2]));
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(second_differences), cmocka_unit_test(vectors),
                                     cmocka_unit_test(not_a_number)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
