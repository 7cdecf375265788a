/* Parallel transport around closed polygons: holonomy = 2 pi writhe, to round-off, and the link that follows
 * from it. */
#include "math/rotation.h"
#include "rod/writhe.h"
#include "support/near.h"
#include "support/rods.h"

#include <stdio.h>

#define POINTS_MAX 1010

/* The torus knot ((R + r cos qt) cos pt, (R + r cos qt) sin pt, r sin qt) at n equally spaced t. */
static void torus(int p, int q, double R, double r, int n, double *x) {
  for (int k = 0; k < n; k++) {
    double t = 2 * HB_PI * k / n;
    x[3 * k] = (R + r * cos(q * t)) * cos(p * t);
    x[3 * k + 1] = (R + r * cos(q * t)) * sin(p * t);
    x[3 * k + 2] = r * sin(q * t);
  }
}

/* An open rod on the closed polygon of n vertices x (room for two more): its last edge repeats its first. */
static void closed_rod(rod_case *c, int n, double *x) {
  for (int k = 0; k < 6; k++) x[3 * n + k] = x[k];
  rod_case_straight(c, n + 2, 1, 1, 1);
  for (int k = 0; k < 3 * n + 6; k++) c->def.rods[0].initial[k] = x[k];
  c->def.rods[0].lengths_from_initial = true;
}

/* By how much a Bishop frame carried once around has turned, in turns, within (-1/2, 1/2]. */
static double holonomy(int n, double *x) {
  rod_case c;
  double u[3 * POINTS_MAX];
  closed_rod(&c, n, x);
  rod_case_compile(&c);
  assert_true(hb_rod_geometry(c.rod, x, &c.work));
  hb_v3 t = hb_v3_load(c.work.tangent);
  hb_v3_store(u, hb_any_normal(t));
  double start[3] = {u[0], u[1], u[2]};
  hb_frames_bishop(c.rod, &c.work, start, u);
  double turned = hb_angle_about(hb_v3_load(start), hb_v3_load(u + 3 * n), t) / (2 * HB_PI);
  rod_case_free(&c);
  return turned;
}

/* Polygon writhe of the trefoil R = 2, r = 1 on 12 to 200 vertices (the first four from the formula of Klenin
 * and Langowski in 40 digits), and five smooth curves (V30) by fine polygons. */
static void test_writhe(void **state) {
  (void)state;
  double x[3 * POINTS_MAX];
  static const int counts[] = {12, 24, 50, 100, 200};
  static const double writhes[] = {-3.24838713366827, -3.42519421308046, -3.49466849320252, -3.51221914835252,
                                   -3.51672614676};
  for (int k = 0; k < 5; k++) {
    torus(2, 3, 2, 1, counts[k], x);
    assert_near(hb_rod_writhe(x, counts[k], true), writhes[k], k < 4 ? 2e-13 : 1e-11);
  }
  static const struct {
    int p, q;
    double R, r, writhe;
  } curves[] = {{2, 3, 2, 1, -3.51823923104},
                {2, 3, 1, 0.35, -3.25671939707},
                {2, 5, 2, 0.8, -6.43262978049},
                {1, 4, 1, 0.3, -1.43439791006},
                {1, 10, 1, 0.1, -2.92453974222}};
  for (int k = 0; k < 5; k++) { /* smooth curves: polygons come near them with the square of the spacing */
    double error[2];
    for (int fine = 0; fine < 2; fine++) {
      int n = fine ? 400 : 200;
      torus(curves[k].p, curves[k].q, curves[k].R, curves[k].r, n, x);
      error[fine] = hb_rod_writhe(x, n, true) - curves[k].writhe;
    }
    assert_near(log2(error[0] / error[1]), 2, 0.05);
    assert_near((4 * error[1] - error[0]) / 3, 0, 2e-5);
  }
}

/* Writhe does not care where the polygon starts, nor which way it runs; a mirror turns its sign; plane curves
 * have none. */
static void test_writhe_symmetry(void **state) {
  (void)state;
  double x[3 * POINTS_MAX], y[3 * POINTS_MAX];
  int n = 60;
  torus(2, 5, 2, 0.8, n, x);
  double writhe = hb_rod_writhe(x, n, true);
  for (int k = 0; k < n; k++)
    for (int c = 0; c < 3; c++) y[3 * k + c] = x[3 * ((k + 17) % n) + c];
  assert_near(hb_rod_writhe(y, n, true), writhe, 1e-12);
  for (int k = 0; k < n; k++)
    for (int c = 0; c < 3; c++) y[3 * k + c] = x[3 * (n - 1 - k) + c];
  assert_near(hb_rod_writhe(y, n, true), writhe, 1e-12);
  for (int k = 0; k < n; k++)
    for (int c = 0; c < 3; c++) y[3 * k + c] = c == 1 ? -x[3 * k + c] : 1e-3 * x[3 * k + c] * 1e3;
  assert_near(hb_rod_writhe(y, n, true), -writhe, 1e-12);
  for (int k = 0; k < n; k++) y[3 * k + 1] = 0.3;
  for (int k = 0; k < n; k++) y[3 * k + 2] = cos(0.1 * k) * k, y[3 * k] = sin(0.1 * k) * k;
  assert_near(hb_rod_writhe(y, n, false), 0, 1e-13);
}

/* V31: the curve, the random ones, and every number of the table. */
static void test_holonomy(void **state) {
  (void)state;
  double x[3 * POINTS_MAX];
  static const int counts[] = {50, 200, 1000};
  static const double turns[] = {-0.381609824872, -0.431093714674, -0.434265732045};
  for (int k = 0; k < 3; k++) {
    torus(1, 4, 1, 0.3, counts[k], x);
    double turned = holonomy(counts[k], x), writhe = hb_rod_writhe(x, counts[k], true);
    assert_near(turned, turns[k], 2e-12);
    assert_near(turned, writhe + 1, 1e-12);
  }
  rng r = rng_start(301);
  for (int k = 0; k < 60; k++) {
    int n = rng_int(&r, 5, 90);
    double wave[3][4][2];
    for (int c = 0; c < 3; c++)
      for (int m = 0; m < 4; m++)
        for (int part = 0; part < 2; part++) wave[c][m][part] = rng_uniform(&r, -1, 1) / (m + 1);
    for (int i = 0; i < n; i++)
      for (int c = 0; c < 3; c++) {
        x[3 * i + c] = 0;
        for (int m = 0; m < 4; m++) {
          double angle = 2 * HB_PI * (m + 1) * i / n;
          x[3 * i + c] += wave[c][m][0] * cos(angle) + wave[c][m][1] * sin(angle);
        }
      }
    double difference = holonomy(n, x) - hb_rod_writhe(x, n, true);
    assert_near(difference, rint(difference), 1e-12);
  }
}

/* V32: a regular polygonal helix, edges at angle g to its axis, n per turn; the smooth helix has 1 - cos g.
 */
static void test_helix(void **state) {
  (void)state;
  static const struct {
    double degrees;
    int n;
    double writhe;
  } rows[] = {{30, 8, 0.1229378460175},
              {30, 16, 0.1311977320687},
              {60, 8, 0.4799591329709},
              {60, 16, 0.4951340801121}};
  for (int k = 0; k < 4; k++) {
    double x[3 * 40] = {0}, u[3 * 40], g = rows[k].degrees * HB_PI / 180;
    int n = rows[k].n, turns = 2;
    for (int j = 0; j < turns * n + 1; j++) {
      double t[3] = {sin(g) * cos(2 * HB_PI * j / n), sin(g) * sin(2 * HB_PI * j / n), cos(g)};
      for (int c = 0; c < 3; c++) x[3 * j + 3 + c] = x[3 * j + c] + t[c];
    }
    assert_near(1 - n / HB_PI * atan(cos(g) * tan(HB_PI / n)), rows[k].writhe, 1e-13);
    rod_case c;
    rod_case_straight(&c, turns * n + 2, 1, 1, 1);
    rod_case_compile(&c);
    assert_true(hb_rod_geometry(c.rod, x, &c.work));
    hb_v3 t = hb_v3_load(c.work.tangent);
    hb_v3_store(u, hb_any_normal(t));
    double start[3] = {u[0], u[1], u[2]};
    hb_frames_bishop(c.rod, &c.work, start, u);
    for (int turn = 1; turn <= turns; turn++) {
      double turned = hb_angle_about(hb_v3_load(start), hb_v3_load(u + 3 * turn * n), t) / (2 * HB_PI);
      double difference = turned - turn * rows[k].writhe;
      assert_near(difference, rint(difference), 1e-13);
    }
    rod_case_free(&c);
  }
}

/* V33: a ring of length 1 with two turns of twist: energy beta (2 pi Lk)^2 / (2 L), exactly, on any polygon.
 */
static void test_ring(void **state) {
  (void)state;
  double x[3 * 110];
  for (int n = 10; n <= 100; n *= 10) {
    double radius = 0.5 / (n * sin(HB_PI / n));
    for (int k = 0; k < n; k++) {
      x[3 * k] = radius * cos(2 * HB_PI * k / n);
      x[3 * k + 1] = radius * sin(2 * HB_PI * k / n);
      x[3 * k + 2] = 0;
    }
    rod_case c;
    closed_rod(&c, n, x);
    for (int i = 0; i < n + 2; i++) c.def.rods[0].beta[i] = 0.015;
    rod_hold_angle(&c.def.rods[0], 0, "0");
    rod_hold_angle(&c.def.rods[0], -1, "4*pi");
    rod_case_compile(&c);
    rod_case_start(&c, NULL);
    double moment = c.state->moment[0], energy = 0.5 * moment * 4 * HB_PI;
    assert_near_rel(energy, 1.184352528131, 1e-12);
    rod_case_free(&c);
  }
}

/* V50, 10: a closed rod that moves without cutting itself keeps its link, twist + writhe; anisotropic and
 * isotropic. */
static void test_link(void **state) {
  (void)state;
  int n = 48;
  for (int general = 0; general < 2; general++) {
    rod_case c;
    double x[3 * 60], theta[60], link = 0;
    torus(1, 4, 1, 0.1, n, x);
    closed_rod(&c, n, x);
    hb_rod_def *def = &c.def.rods[0];
    def->straight_rest = true;
    if (general) rod_set_bending(def, 0.5, 0.1, 1.5);
    rod_hold_angle(def, 0, "0");
    rod_hold_angle(def, -1, "7 - 2*pi*t");
    rod_case_compile(&c);
    rod_case_start(&c, NULL);
    for (int step = 0; step <= 200; step++) {
      double t = step / 200.0;
      torus(1, 4, 1 + 0.5 * t, 0.1 + 0.8 * t, n, x);
      for (int k = 0; k < n; k++) x[3 * k] *= 1 + 0.4 * sin(3 * t) * x[3 * k + 2];
      for (int k = 0; k < 6; k++) x[3 * n + k] = x[k];
      rod_case_evaluate(&c, x, t);
      rod_case_angles(&c, theta);
      double now = (theta[n] - theta[0]) / (2 * HB_PI) + hb_rod_writhe(x, n, true) + t;
      if (step == 0) link = now;
      assert_near(now, link, 1e-10);
    }
    rod_case_free(&c);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_writhe),   cmocka_unit_test(test_writhe_symmetry),
                                     cmocka_unit_test(test_holonomy), cmocka_unit_test(test_helix),
                                     cmocka_unit_test(test_ring),     cmocka_unit_test(test_link)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
