/* V25: chains of one, two and three edges without stiffness are pendula; numbers of the catalogue (complete
 * elliptic integral; DOP853 to 3e-14, checked by Taylor series). V26: a folded chain falls faster than a
 * stone. */
#include "support/near.h"

#include "support/scenes.h"

#define PI 3.14159265358979323846

/* A chain of point masses from the origin, gravity 9.81 to -y. angle: of each link from the downward
 * vertical. */
static void chain(trial *t, int links, const double *length, const double *mass, const double *angle,
                  const char *integrator, double h) {
  double xyz[3 * 8] = {0};
  for (int j = 0; j < links; j++) {
    xyz[3 * j + 3] = xyz[3 * j] + length[j] * sin(angle[j]);
    xyz[3 * j + 4] = xyz[3 * j + 1] - length[j] * cos(angle[j]);
  }
  scene_begin(&t->def, integrator, h);
  hb_rod_def *rod = scene_rod(&t->def, links + 1, xyz, 0, 0, 1);
  for (int j = 0; j < links; j++) rod->mass[j + 1] = mass[j];
  rod->straight_rest = true;
  scene_hold(rod, 0);
  scene_force(&t->def, HB_FORCE_GRAVITY, "0", "-9.81", "0");
  t->def.method.length_tolerance = 1e-13;
}

/* Period of one pendulum: where it is after a quarter of the expected period tells by how much it is early or
 * late. Its support is an edge that both ends hold, for a rod has two edges at least. */
static double period(double expected, double degrees, const char *integrator, long steps) {
  trial t = {0};
  double h = 0.25 * expected / (double)steps;
  chain(&t, 2, (double[]){0.3, 0.5}, (double[]){1, 0.7}, (double[]){PI / 2, degrees * PI / 180}, integrator,
        h);
  scene_hold(&t.def.rods[0], 1);
  trial_start(&t);
  trial_run(&t, steps);
  const hb_frame *f = trial_measure(&t);
  double early = -(f->position[6] - 0.3) / f->velocity[6]; /* time until it passes the vertical */
  trial_end(&t);
  return expected + 4 * early;
}

/* One link, four amplitudes. */
static void test_single(void **state) {
  (void)state;
  static const double degrees[4] = {30, 90, 150, 170},
                      expected[4] = {1.443197791212, 1.674317097909, 2.499691899751, 3.460244198121};
  for (int k = 0; k < 4; k++) {
    double e[2], v[3];
    for (int n = 0; n < 3; n++) v[n] = period(expected[k], degrees[k], "verlet", 2000L << n);
    for (int n = 0; n < 2; n++)
      e[n] = period(expected[k], degrees[k], "symplectic-euler", 2000L << n) - expected[k];
    double best = v[2] + (v[2] - v[1]) / 3, order = log2((v[0] - expected[k]) / (v[1] - expected[k]));
    say("single %3.0f: verlet %.3e (order %.3f, extrapolated %.1e), symplectic Euler %.3e (order %.3f)\n",
        degrees[k], v[1] - expected[k], order, best - expected[k], e[1], log2(e[0] / e[1]));
    assert_near(best, expected[k], 1e-9);
    assert_near(order, 2, 0.02);
    assert_near(log2(e[0] / e[1]), 1, 0.1);
  }
}

/* Places of masses at a time, extrapolated from steps h and h/2 of the symmetric scheme. */
static void place(int links, const double *length, const double *mass, const double *angle, double time,
                  long steps, double *xyz, double error[2]) {
  double x[3][3 * 8];
  for (int n = 0; n < 3; n++) {
    trial t = {0};
    chain(&t, links, length, mass, angle, "verlet", time / (double)(steps << n));
    trial_start(&t);
    trial_run(&t, steps << n);
    memcpy(x[n], trial_measure(&t)->position, 3 * (size_t)(links + 1) * sizeof(double));
    trial_end(&t);
  }
  for (int k = 0; k < 3 * (links + 1); k++) {
    double a = x[1][k] + (x[1][k] - x[0][k]) / 3, b = x[2][k] + (x[2][k] - x[1][k]) / 3;
    xyz[k] = b + (b - a) / 15;
  }
  for (int n = 0; n < 2; n++) error[n] = largest_difference(x[n], xyz, 3 * (size_t)(links + 1));
}

/* Two links, both level at the start. */
static void test_double(void **state) {
  (void)state;
  static const struct {
    double t, x[4];
  } table[] = {{0.5, {-0.202936466893, -0.220945220372, -0.308425824608, -0.390862833963}},
               {1.0, {-0.116997806345, -0.276245386044, -0.288024588199, -0.172563951407}},
               {2.0, {-0.295428667339, -0.0521718555746, -0.248527372862, -0.24659476723}}};
  for (int k = 0; k < 3; k++) {
    double x[9], e[2];
    place(2, (double[]){0.3, 0.2}, (double[]){0.1, 0.15}, (double[]){PI / 2, PI / 2}, table[k].t, 5000L << k,
          x, e);
    double flat[4] = {x[3], x[4], x[6], x[7]};
    say("double t %.1f: off by %.1e, order %.3f, extrapolated %.1e\n", table[k].t, e[0], log2(e[0] / e[1]),
        largest_difference(flat, table[k].x, 4));
    assert_near_array(flat, table[k].x, 4, 1e-9);
    assert_near(log2(e[0] / e[1]), 2, 0.05);
  }
}

/* Three links. */
static void test_triple(void **state) {
  (void)state;
  static const double expected[2][2] = {{-0.416912929515, -0.352582214621},
                                        {-0.37271771365, -0.439218241117}};
  for (int k = 0; k < 2; k++) {
    double x[12], e[2];
    place(3, (double[]){0.2, 0.2, 0.2}, (double[]){0.1, 0.1, 0.05}, (double[]){PI / 3, PI / 2, 2 * PI / 3},
          0.5 * (k + 1), 5000L << k, x, e);
    say("triple t %.1f: off by %.1e, order %.3f, extrapolated %.1e\n", 0.5 * (k + 1), e[0], log2(e[0] / e[1]),
        largest_difference(x + 9, expected[k], 2));
    assert_near_array(x + 9, expected[k], 2, 1e-9);
    assert_near(log2(e[0] / e[1]), 2, 0.05);
  }
}

/* Two links with symplectic Euler: first order to the same place. */
static void test_double_euler(void **state) {
  (void)state;
  static const double expected[4] = {-0.202936466893, -0.220945220372, -0.308425824608, -0.390862833963};
  double e[2];
  for (int n = 0; n < 2; n++) {
    trial t = {0};
    long steps = 16000L << n;
    chain(&t, 2, (double[]){0.3, 0.2}, (double[]){0.1, 0.15}, (double[]){PI / 2, PI / 2}, "symplectic-euler",
          0.5 / (double)steps);
    trial_start(&t);
    trial_run(&t, steps);
    const double *x = trial_measure(&t)->position;
    e[n] = largest_difference((double[]){x[3], x[4], x[6], x[7]}, expected, 4);
    trial_end(&t);
  }
  say("double, symplectic Euler: off by %.2e %.2e\n", e[0], e[1]);
  assert_near(log2(e[0] / e[1]), 1, 0.1);
  assert_at_most(e[1], 1e-4);
}

/* V26: a chain of length 1 held at one end, the other end let go beside it: fall time 0.84721308 of a
 * stone's. */
static void test_folded(void **state) {
  (void)state;
  enum { EDGES = 200 };
  double xyz[3 * (EDGES + 1)] = {0}, edge = 1.0 / EDGES, h = 2e-5;
  int bend = 4; /* edges of the half circle that folds it */
  for (int j = 0; j < EDGES; j++) {
    int into = j - (EDGES - bend) / 2;
    double angle = into < 0       ? 0
                   : into >= bend ? PI
                                  : PI * (into + 0.5) / bend; /* from straight down to straight up */
    xyz[3 * j + 3] = xyz[3 * j] + edge * sin(angle);
    xyz[3 * j + 4] = xyz[3 * j + 1] - edge * cos(angle);
  }
  trial t = {0};
  scene_begin(&t.def, "verlet", h);
  hb_rod_def *rod = scene_rod(&t.def, EDGES + 1, xyz, 0, 0, edge);
  rod->mass[0] = rod->mass[EDGES] = 0.5 * edge;
  rod->straight_rest = true;
  scene_hold(rod, 0);
  scene_force(&t.def, HB_FORCE_GRAVITY, "0", "-9.81", "0");
  trial_start(&t);
  const int tip = 3 * EDGES + 1;
  double start = hb_sim_const_state(t.sim)->x[tip], fallen = 0;
  while (fallen < 0.9) {
    trial_run(&t, 1);
    fallen = start - hb_sim_const_state(t.sim)->x[tip];
  }
  double speed = fabs(hb_sim_const_state(t.sim)->v[tip]), time = hb_sim_time(t.sim);
  say("folded chain: speed %.4f after %.4f in %.5f (a stone: %.5f)\n", speed, fallen, time,
      sqrt(2 * 0.9 / 9.81));
  assert_near_rel(speed, sqrt(9.81 * fallen * (2 - fallen) / (1 - fallen)), 0.01);
  assert_true(time < sqrt(2 * fallen / 9.81));
  trial_end(&t);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_single),       cmocka_unit_test(test_double), cmocka_unit_test(test_triple),
      cmocka_unit_test(test_double_euler), cmocka_unit_test(test_folded),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
