/* Equilibria against known answers: elliptic integrals, boundary-value problems, and thresholds of the
 * discrete rods themselves, all computed outside this project. "Midpoint": lengths are counted from the
 * middle of a clamped edge, where the discrete clamp acts; then errors are of second order. */
#include "support/solved.h"

#include <stdlib.h>

#define say(...)                                                                                             \
  do {                                                                                                       \
    if (getenv("HEBRA_TEST_VERBOSE")) printf(__VA_ARGS__);                                                   \
  } while (0)

/* Small load: the linear discrete beam has the compliance F L^3/(3 B) (1 - h^2/(4 L^2)), midpoint; the exact
 * elastica at P L^2/B = 0.0125 deflects by 0.0020832961321942/0.0020833333 of the linear one. */
static void cantilever_small_load(void **state) {
  (void)state;
  for (int n = 11; n <= 161; n = 2 * n - 1) {
    solved s;
    char a[80], b[80];
    double P = 0.0125, h = 1 / (n - 1.5);
    solved_begin(&s, "cantilever", false, solved_set(a, "parameters.n", n), solved_set(b, "parameters.P", P),
                 NULL);
    double linear = P / 3 * (1 - 0.25 * h * h), nonlinear = 0.0020832961321942 / 0.0020833333333333;
    assert_near_rel(-solved_tip(&s, 2), linear * nonlinear, 1e-6);
    assert_int_equal(s.found.unstable, 0);
    assert_int_equal(s.found.neutral, 0);
    solved_end(&s);
  }
}

/* Large loads (Bisshopp and Drucker 1945): deflections of the smooth rod; errors of the discrete one at P =
 * 1, 10 to their three printed digits. */
static void cantilever_large_loads(void **state) {
  (void)state;
  static const double table[][3] = {
      /* P, deflection, x of the tip */
      {0.25, 0.08274591535442, 0.99588218159}, {1, 0.3017207737998, 0.9435667637166},
      {3, 0.60325344113, 0.7455798154358},     {5, 0.7137915236119, 0.6123716392756},
      {10, 0.8106090248803, 0.4450044022462},  {15, 0.8477156743323, 0.3647142196379}};
  static const double errors[][3] = {/* n, at P = 1, at P = 10 */
                                     {11, -4.63e-3, -1.16e-2},
                                     {21, -1.10e-3, -2.88e-3},
                                     {41, -2.69e-4, -7.08e-4},
                                     {81, -6.64e-5, -1.75e-4},
                                     {161, -1.65e-5, -4.36e-5}};
  char a[80], b[80];
  solved s;
  for (size_t k = 0; k < sizeof table / sizeof table[0]; k++) {
    double tip[2][2];
    for (int fine = 0; fine < 2; fine++) { /* extrapolated to edges of length 0: n - 1.5 edges */
      solved_begin(&s, "cantilever", false, solved_set(a, "parameters.n", fine ? 401 : 201),
                   solved_set(b, "parameters.P", table[k][0]), NULL);
      tip[fine][0] = -solved_tip(&s, 2);
      tip[fine][1] = solved_tip(&s, 0);
      solved_end(&s);
    }
    double ratio = (399.5 / 199.5) * (399.5 / 199.5);
    for (int c = 0; c < 2; c++)
      assert_near_rel(tip[1][c] + (tip[1][c] - tip[0][c]) / (ratio - 1), table[k][1 + c], 2e-8);
  }
  for (size_t k = 0; k < sizeof errors / sizeof errors[0]; k++)
    for (int load = 0; load < 2; load++) {
      double exact = load ? 0.8106090248803 : 0.3017207737998;
      solved_begin(&s, "cantilever", false, solved_set(a, "parameters.n", errors[k][0]),
                   solved_set(b, "parameters.P", load ? 10 : 1), NULL);
      assert_near_rel(-solved_tip(&s, 2) / exact - 1, errors[k][1 + load], 6e-3);
      assert_true(s.found.iterations <= 8 && s.found.factorisations <= 12); /* from straight */
      solved_end(&s);
    }
}

/* Own weight W = 10 (Rohde 1953): errors of the drop 0.700199715514 to their printed digits. */
static void heavy_beam(void **state) {
  (void)state;
  static const double errors[][2] = {
      {11, -1.53e-2}, {21, -3.76e-3}, {41, -9.26e-4}, {81, -2.29e-4}, {161, -5.69e-5}};
  for (size_t k = 0; k < sizeof errors / sizeof errors[0]; k++) {
    solved s;
    char a[80];
    solved_begin(&s, "heavy-beam", false, solved_set(a, "parameters.n", errors[k][0]), NULL);
    assert_near_rel(-solved_tip(&s, 2) / 0.700199715514 - 1, errors[k][1], 6e-3);
    solved_end(&s);
  }
}

/* Euler's strut beyond its critical load, from exactly straight: unstable there, and left; the buckled shape
 * has the amplitude 2 k/K and the shortening 2 (1 - E/K) of a largest angle of 60 degrees. Errors fall with
 * h^2. */
static void buckled_strut(void **state) {
  (void)state;
  double error[2][2];
  for (int fine = 0; fine < 2; fine++) {
    solved s;
    char a[80];
    solved_begin(&s, "strut", false, solved_set(a, "parameters.n", fine ? 201 : 101), NULL);
    error[fine][0] = hypot(solved_tip(&s, 0), solved_tip(&s, 1)) / (2 * 0.2966038230824) - 1;
    error[fine][1] = solved_tip(&s, 2) / (1 - 0.2589803939237) - 1;
    say("strut: amplitude %.3g, height %.3g, %d iterations\n", error[fine][0], error[fine][1],
        s.found.iterations);
    assert_int_equal(s.found.escapes, 1);
    assert_int_equal(s.found.unstable, 0);
    assert_int_equal(s.found.neutral, 1); /* it turns about its own axis */
    solved_end(&s);
    solved_begin(&s, "strut", true, NULL);
    assert_int_equal(s.found.unstable, 2); /* sideways in two directions */
    assert_near(hypot(solved_tip(&s, 0), solved_tip(&s, 1)), 0, 1e-12);
    assert_near_rel(s.frame->tension[50], -1.151719620469 * 2.4674011002723, 1e-9);
    solved_end(&s);
  }
  for (int c = 0; c < 2; c++) {
    assert_at_most(fabs(error[1][c]), 1e-4);
    assert_near_rel(error[0][c] / error[1][c], (199.5 / 99.5) * (199.5 / 99.5), 0.02);
  }
}

/* Clamped at both ends, shortened by 0.3: force 46.61212087983 B/L^2; errors of the discrete rod to their
 * printed digits. */
static void clamped_arch(void **state) {
  (void)state;
  static const double errors[][2] = {{22, 2.52e-2}, {42, 6.31e-3}, {82, 1.58e-3}, {162, 3.95e-4}};
  for (size_t k = 0; k < sizeof errors / sizeof errors[0]; k++) {
    solved s;
    char a[80];
    solved_begin(&s, "clamped-arch", false, solved_set(a, "parameters.n", errors[k][0]), NULL);
    assert_near_rel(-solved_clamp_force(&s, true, 0) / 46.61212087983 - 1, errors[k][1], 6e-3);
    assert_near(solved_clamp_force(&s, true, 0) + solved_clamp_force(&s, false, 0), 0, 1e-6);
    assert_int_equal(s.found.unstable, 0);
    solved_end(&s);
  }
}

/* Localised buckling: tension and moment of the discrete rod itself, computed outside by another program. The
 * convergence figure of Bergou et al. (2008) without marching in time. */
static void localised_buckling(void **state) {
  (void)state;
  static const double table[][3] = {
      /* n, T, M */
      {41, 32.24606, 14.686934},  {61, 37.02300, 14.540282},  {81, 39.88148, 14.465454},
      {111, 42.42867, 14.403883}, {141, 43.90107, 14.368940}, {181, 45.03562, 14.340925},
      {241, 45.90739, 14.317037}, {361, 46.58108, 14.294050}, {721, 46.96555, 14.272291}};
  for (size_t k = 0; k < sizeof table / sizeof table[0]; k++) {
    solved s;
    char a[80];
    solved_begin(&s, "localised-buckling", false, solved_set(a, "parameters.n", table[k][0]), NULL);
    double T = solved_clamp_force(&s, true, 0), M = s.frame->twisting_moment[s.model->nv / 2];
    say("n = %4.0f: T %.6f (%+.1e), M %.7f (%+.1e), %d iterations, neutral %d\n", table[k][0], T,
        T / table[k][1] - 1, M, M / table[k][2] - 1, s.found.iterations, s.found.neutral);
    double tolerance = table[k][0] >= 361 ? 1e-4 : 1e-5;
    assert_near_rel(T, table[k][1], tolerance);
    assert_near_rel(M, table[k][2], tolerance);
    assert_int_equal(s.found.unstable, 0);
    assert_true(s.found.neutral >= 1);
    solved_end(&s);
  }
}

/* Unstable modes of a ring at a parameter. */
static int ring_modes(const char *scene, int n, const char *key, double value) {
  solved s;
  char a[80], b[80];
  solved_begin(&s, scene, true, solved_set(a, "parameters.n", n), solved_set(b, key, value), NULL);
  int modes = s.found.unstable;
  solved_end(&s);
  return modes;
}

/* Where a ring becomes unstable: between two values, by the count of its unstable modes. */
static double threshold(const char *scene, int n, const char *key, double low, double high) {
  assert_int_equal(ring_modes(scene, n, key, low), 0);
  assert_true(ring_modes(scene, n, key, high) > 0);
  while (high - low > 1e-8 * high) {
    double middle = 0.5 * (low + high);
    *(ring_modes(scene, n, key, middle) > 0 ? &high : &low) = middle;
  }
  return 0.5 * (low + high);
}

/* Michell's ring, bending 1, twisting 0.8: the twist at which the constrained Hessian of the regular polygon
 * changes sign. It exceeds 2 pi sqrt(3)/0.8 = 13.6034952318 by 31.4/n^2 of it. */
static void twisted_ring(void **state) {
  (void)state;
  static const double table[][2] = {{20, 14.7092143}, {30, 14.0841527}, {50, 13.7746168}, {100, 13.6460775}};
  for (size_t k = 0; k < sizeof table / sizeof table[0]; k++) {
    double found = threshold("twisted-ring", (int)table[k][0], "parameters.theta", 13, 15);
    say("twisted ring of %3.0f: %.8f (%+.1e)\n", table[k][0], found, found / table[k][1] - 1);
    assert_near_rel(found, table[k][1], 2e-7);
  }
  solved s;
  solved_begin(&s, "twisted-ring", false, NULL); /* beyond it the ring leaves its plane */
  assert_int_equal(s.found.unstable, 0);
  assert_int_equal(s.found.escapes, 1);
  double highest = 0;
  for (int k = 0; k < s.model->nv; k++) highest = fmax(highest, fabs(s.frame->position[3 * k + 2]));
  assert_true(highest > 0.1);
  solved_end(&s);
}

/* Over-curved ring, twisting/bending = 2/3: natural curvature at which it leaves its plane; 1.808142966966 on
 * fine meshes. */
static void overcurved_ring(void **state) {
  (void)state;
  static const double table[][2] = {{20, 1.86705204}, {50, 1.81738781}, {100, 1.81044784}};
  for (size_t k = 0; k < sizeof table / sizeof table[0]; k++) {
    double found = threshold("overcurved-ring", (int)table[k][0], "parameters.natural", 1.7, 2);
    say("over-curved ring of %3.0f: %.8f (%+.1e)\n", table[k][0], found, found / table[k][1] - 1);
    assert_near_rel(found, table[k][1], 2e-7);
  }
}

/* Helical spring between ends that cannot turn: tension and couple of Love's formulas, at second order. */
static void spring(void **state) {
  (void)state;
  static const double table[][3] = {{0.2, 0.845068943679, 0.0010592817653},
                                    {0.4, 2.29393530606, 0.010489355236},
                                    {0.8, 8.62894499371, 0.081072739899}};
  for (size_t k = 0; k < sizeof table / sizeof table[0]; k++) {
    double T[3];
    for (int level = 0; level < 3; level++) {
      solved s;
      char a[80], b[80];
      solved_begin(&s, "spring", false, solved_set(a, "parameters.n", 1 + 120 * (1 << level)),
                   solved_set(b, "parameters.stretch", table[k][0]), NULL);
      T[level] = solved_clamp_force(&s, true, 2);
      say("spring at %.1f with %d vertices: T %.8f (%+.2e), %d iterations\n", table[k][0], s.model->nv,
          T[level], T[level] / table[k][1] - 1, s.found.iterations);
      assert_int_equal(s.found.unstable, 0);
      solved_end(&s);
    }
    assert_near_rel((T[0] - T[1]) / (T[1] - T[2]), 4, 0.1);
    assert_near_rel(T[2] + (T[2] - T[1]) / 3, table[k][1], 5e-4);
  }
}

/* Strip on its edge: the load at which it gives way sideways, of the discrete rod; 4.2418020971 on fine
 * meshes. */
static void strip(void **state) {
  (void)state;
  static const double table[][2] = {{11, 4.26309849}, {21, 4.24690898}, {41, 4.24304952}, {81, 4.24210941}};
  for (size_t k = 0; k < sizeof table / sizeof table[0]; k++) {
    double found = threshold("strip", (int)table[k][0], "parameters.P", 4, 4.5);
    say("strip of %3.0f: %.8f (%+.1e)\n", table[k][0], found, found / table[k][1] - 1);
    assert_near_rel(found, table[k][1], 5e-7); /* a mode counts as unstable only beyond the resolution */
  }
}

/* Curved cantilever under a load across its plane, P = 600: tip of the smooth rod, at second order. */
static void curved_cantilever(void **state) {
  (void)state;
  static const double exact[3] = {47.1512944, 15.685078162, 53.468598442};
  double tip[3][3], error[3];
  for (int level = 0; level < 3; level++) {
    solved s;
    char a[80];
    solved_begin(&s, "curved-cantilever", false, solved_set(a, "parameters.n", 41 << level), NULL);
    error[level] = 0;
    for (int c = 0; c < 3; c++) {
      tip[level][c] = solved_tip(&s, c);
      error[level] = hypot(error[level], tip[level][c] - exact[c]);
    }
    say("curved cantilever of %3d: tip off by %.3g of the radius, %d iterations\n", s.model->nv,
        error[level] / 100, s.found.iterations);
    assert_int_equal(s.found.unstable, 0);
    solved_end(&s);
  }
  double ratio = pow((164 - 1.5) / (82 - 1.5), 2);
  assert_near_rel(error[1] / error[2], ratio, 0.01);
  for (int c = 0; c < 3; c++) assert_near(tip[2][c] + (tip[2][c] - tip[1][c]) / (ratio - 1), exact[c], 1e-4);
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(cantilever_small_load),
                                     cmocka_unit_test(cantilever_large_loads),
                                     cmocka_unit_test(heavy_beam),
                                     cmocka_unit_test(buckled_strut),
                                     cmocka_unit_test(clamped_arch),
                                     cmocka_unit_test(localised_buckling),
                                     cmocka_unit_test(twisted_ring),
                                     cmocka_unit_test(overcurved_ring),
                                     cmocka_unit_test(spring),
                                     cmocka_unit_test(strip),
                                     cmocka_unit_test(curved_cantilever)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
