/* V23: a chain without stiffness, hung between two points, comes to rest in the equilibrium polygon of its
 * own weights; numbers of the catalogue, from the polygon's equations. V24: its small swings. */
#include "support/near.h"

#include "support/scenes.h"

#define LENGTH 1.2
#define WEIGHT 0.4905 /* per length */
#define GRAVITY 9.81
#define MOST 101

/* A chain of n edges along the x axis of a frame in which gravity points to -y, from the left end to the
 * right one, at first along an arc of a circle; its interior vertices weigh WEIGHT times the edge. */
static void hang(trial *t, int n, const double end[2], const char *integrator, double h, double damping) {
  double xyz[3 * MOST], span = hypot(end[0], end[1]), low = 1e-6, high = 3.1, edge = LENGTH / n;
  while (high - low >
         1e-15) { /* half the angle of the polygon's arc: chord of n edges that turn by 2 a/n each */
    double a = 0.5 * (low + high), chord = edge * sin(a) / sin(a / n);
    if (chord > span)
      low = a;
    else
      high = a;
  }
  double tilt = atan2(end[1], end[0]), x = 0, y = 0;
  for (int i = 0; i <= n; i++) {
    double angle = tilt - low + (2 * i + 1) * low / n;
    xyz[3 * i] = x;
    xyz[3 * i + 1] = y;
    xyz[3 * i + 2] = 0;
    x += edge * cos(angle);
    y += edge * sin(angle);
  }
  scene_begin(&t->def, integrator, h);
  hb_rod_def *rod = scene_rod(&t->def, n + 1, xyz, 0, 0, WEIGHT / GRAVITY * edge);
  rod->straight_rest = true;
  rod->mass_damping = damping;
  scene_hold(rod, 0);
  scene_path(rod, n, n > 0 && end[1] == 0 ? "1" : "0.8", end[1] == 0 ? "0" : "0.5", NULL);
  scene_force(&t->def, HB_FORCE_GRAVITY, "0", "-9.81", "0");
  t->def.method.length_tolerance = 1e-13;
  trial_start(t);
}

/* Level ends: horizontal pull, depth of the lowest vertex, angle of the first edge. */
static void test_level(void **state) {
  (void)state;
  static const struct {
    int n;
    double H, depth, angle;
  } cases[] = {{10, 0.2296358053366, 0.293864249331, -0.8565292808985},
               {20, 0.2301412287281, 0.2927214753075, -0.8820962807801},
               {50, 0.2302830812877, 0.2924041189528, -0.8970035018214},
               {100, 0.2303033576562, 0.2923588741314, -0.9019052845767}};
  for (int k = 0; k < 4; k++) {
    trial t = {0};
    int n = cases[k].n;
    hang(&t, n, (double[]){1, 0}, "verlet", 1e-3, 6);
    trial_run(&t, 9000);
    const hb_frame *f = trial_measure(&t);
    double lowest = 0;
    for (int i = 0; i <= n; i++) lowest = fmin(lowest, f->position[3 * i + 1]);
    assert_near(-lowest, cases[k].depth, 2e-12);
    assert_near(atan2(f->tangent[1], f->tangent[0]), cases[k].angle, 1e-11);
    for (int j = 0; j < n; j++) {
      /* vertical part of the tension: the weight between here and the middle */
      double vertical = (j + 0.5 - 0.5 * n) * WEIGHT * LENGTH / n;
      assert_near(f->tension[j] * f->tangent[3 * j], cases[k].H, 1e-11);
      assert_near(f->tension[j] * f->tangent[3 * j + 1], vertical, 1e-11);
    }
    assert_near(f->reaction[0], -cases[k].H, 1e-11);
    assert_near(f->reaction[3 * n], cases[k].H, 1e-11);
    assert_near(f->reaction[1] + f->reaction[3 * n + 1], WEIGHT * LENGTH * (n + 1) / n, 1e-11);
    assert_near(f->kinetic, 0, 1e-22);
    trial_end(&t);
  }
}

/* Fast projection takes its directions at the unprojected positions, h^2 g away: where a symplectic Euler run
 * comes to rest is off by the square of the step. */
static void test_level_euler(void **state) {
  (void)state;
  double error[3];
  for (int k = 0; k < 3; k++) {
    trial t = {0};
    hang(&t, 10, (double[]){1, 0}, "symplectic-euler", 2e-3 / (1 << k), 6);
    trial_run(&t, 4500L << k);
    const hb_frame *f = trial_measure(&t);
    error[k] = fabs(f->position[16] + 0.293864249331);
    assert_near(f->kinetic, 0, 1e-22);
    trial_end(&t);
  }
  say("level, symplectic Euler: depth off by %.3e %.3e %.3e\n", error[0], error[1], error[2]);
  assert_at_most(error[2], 1e-6);
  assert_near(error[0] / error[1], 4, 0.05);
  assert_near(error[1] / error[2], 4, 0.05);
}

/* Ends at different heights: tensions of the smooth catenary, approached with the square of the edge. */
static void test_inclined(void **state) {
  (void)state;
  const double H = 0.1395491687252, left = 0.2093051594662, right = 0.4545551594662;
  double error[2];
  for (int k = 0; k < 2; k++) {
    trial t = {0};
    int n = 50 << k;
    hang(&t, n, (double[]){0.8, 0.5}, "verlet", 1e-3, 6);
    trial_run(&t, 12000);
    const hb_frame *f = trial_measure(&t);
    double pull = f->tension[0] * f->tangent[0], half = 0.5 * WEIGHT * LENGTH / n;
    error[k] = pull - H;
    /* at the ends half an edge's weight more than in the middle of the end edges */
    assert_near(hypot(pull, f->tension[0] * f->tangent[1] - half), left, 2e-4 / (1 << 2 * k));
    assert_near(hypot(pull, f->tension[n - 1] * f->tangent[3 * n - 2] + half), right, 2e-4 / (1 << 2 * k));
    trial_end(&t);
  }
  say("inclined: error of H %.3e %.3e\n", error[0], error[1]);
  assert_near(error[0] / error[1], 4, 0.05);
}

/* V24: frequency of the first small swing of a rope that hangs from one end, mesh-exact: half a mass at the
 * free end. omega sqrt(L/g) of the catalogue, from the eigenvalues of the hanging chain; the shape is found
 * by inverse iteration on its stiffness: tension under vertex i over the edge length. */
static void test_hanging_swings(void **state) {
  (void)state;
  static const struct {
    int n;
    double omega;
  } cases[] = {{5, 1.18839322629}, {10, 1.19886077397}, {20, 1.20152326331}, {40, 1.20219039367}};
  for (int k = 0; k < 4; k++) {
    int n = cases[k].n;
    double edge = 1.0 / n, xyz[3 * 41] = {0}, shape[41] = {0}, load[41], omega2 = 0;
    for (int i = 1; i <= n; i++) shape[i] = i * edge;
    for (int turn = 0; turn < 60; turn++) {
      /* tension of edge j over its length times its tilt carries the loads below: T_j/edge (y_{j+1} - y_j) =
       * sum */
      double below = 0, tilt[41], norm = 0;
      for (int i = n; i >= 1; i--) {
        load[i] = (i == n ? 0.5 : 1) * edge * shape[i];
        below += load[i];
        tilt[i] = below / ((n - i + 0.5) * edge);
      }
      for (int i = 1; i <= n; i++) shape[i] = shape[i - 1] + edge * tilt[i];
      norm = shape[n];
      omega2 = 1 / norm;
      for (int i = 1; i <= n; i++) shape[i] /= norm;
    }
    assert_near(sqrt(omega2), cases[k].omega, 1e-10);
    trial t = {0};
    long steps = 20000;
    double quarter = 0.5 * 3.14159265358979323846 / cases[k].omega, amplitude = 1e-5;
    for (int i = 0; i <= n; i++) {
      xyz[3 * i] = amplitude * shape[i];
      xyz[3 * i + 1] =
          i ? xyz[3 * i - 2] - sqrt(edge * edge - amplitude * amplitude * pow(shape[i] - shape[i - 1], 2))
            : 0;
    }
    scene_begin(&t.def, "verlet", quarter / (double)steps);
    hb_rod_def *rod = scene_rod(&t.def, n + 1, xyz, 0, 0, edge);
    rod->mass[n] *= 0.5;
    rod->straight_rest = true;
    scene_hold(rod, 0);
    scene_force(&t.def, HB_FORCE_GRAVITY, "0", "-1", "0");
    t.def.method.length_tolerance = 1e-13;
    trial_start(&t);
    trial_run(&t, steps); /* now it should pass the vertical: x = -amplitude * (omega - expected) * quarter */
    const hb_frame *f = trial_measure(&t);
    double shift = f->position[3 * n] / f->velocity[3 * n];
    say("hanging rope n %d: omega %.11f expected %.11f\n", n, cases[k].omega * quarter / (quarter - shift),
        cases[k].omega);
    assert_near(cases[k].omega * quarter / (quarter - shift), cases[k].omega, 2e-9);
    trial_end(&t);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_level),
      cmocka_unit_test(test_level_euler),
      cmocka_unit_test(test_inclined),
      cmocka_unit_test(test_hanging_swings),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
