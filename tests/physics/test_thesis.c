/* The three examples of the thesis, read from scenes/: what the text says of them, and what theory says of
 * the same discrete rods. */
#include "support/near.h"

#include "hebra/scene.h"
#include "support/scenes.h"

#define NV 25
#define PI 3.14159265358979323846

/* Reads scenes/name with overrides (NULL-terminated). */
static void read_scene(trial *t, const char *name, const char *const *overrides) {
  char path[512];
  hb_error err = {HB_OK, ""};
  int count = 0;
  while (overrides && overrides[count]) count++;
  snprintf(path, sizeof path, "%s/scenes/%s", HEBRA_SOURCE_DIR, name);
  if (hb_scene_read(path, overrides, count, &t->def, &err)) fail_msg("%s", err.text);
}

/* The same, and starts it. */
static void open_scene(trial *t, const char *name, const char *const *overrides) {
  read_scene(t, name, overrides);
  trial_start(t);
  assert_int_equal(t->model->nv, NV);
}

/* Overrides of step and integrator. */
static void open_with(trial *t, const char *name, const char *integrator, double step) {
  char a[64], b[64];
  snprintf(a, sizeof a, "method.time_step=%.17g", step);
  snprintf(b, sizeof b, "method.integrator=%s", integrator);
  open_scene(t, name, (const char *const[]){a, b, NULL});
}

/* Halving the step converges to one trajectory at the claimed order: the file's scene at time end, steps from
 * first on. */
static void check_convergence(const char *name, const char *integrator, double order, double end,
                              double first) {
  double x[4][3 * NV], d[3];
  for (int k = 0; k < 4; k++) {
    trial t = {0};
    open_with(&t, name, integrator, first / (1 << k));
    trial_run(&t, lrint(end / first) << k);
    memcpy(x[k], hb_sim_const_state(t.sim)->x, sizeof x[k]);
    assert_at_most(trial_measure(&t)->worst_length_error, 1e-10);
    trial_end(&t);
  }
  for (int k = 0; k < 3; k++) d[k] = largest_difference(x[k], x[k + 1], 3 * NV);
  say("%s %s at t = %g: %.2e %.2e %.2e, order %.3f\n", name, integrator, end, d[0], d[1], d[2],
      log2(d[1] / d[2]));
  assert_near(log2(d[1] / d[2]), order, 0.1);
}

/* ---- example 1: a straight rod with three half turns
 * -------------------------------------------------------- */

/* A straight rod of edges h with twisting moment M needs the tension max over p of M sin(p)/h - 2 alpha/h^2
 * (1 - cos p) to be stable against helices that turn by p from edge to edge: from the second variation of the
 * discrete energy. */
static double stabilising_tension(double M, double alpha, double h) {
  return hypot(M / h, 2 * alpha / (h * h)) - 2 * alpha / (h * h);
}

/* Tensions of the far half, which stays straight, at the end of a run. */
static void run_twisted(const char *integrator, double step, double *low, double *high) {
  trial t = {0};
  open_with(&t, "thesis-1-twisted.yaml", integrator, step);
  trial_run(&t, lrint(0.5 / step));
  const hb_frame *f = trial_measure(&t);
  *low = HUGE_VAL;
  *high = -HUGE_VAL;
  for (int j = NV - 9; j < NV - 1; j++) {
    *low = fmin(*low, f->tension[j]);
    *high = fmax(*high, f->tension[j]);
  }
  double needed = stabilising_tension(f->twisting_moment[NV / 2], 0.1, sqrt(2) / 24);
  say("example 1 %s step %.2e: tension %.1f .. %.1f, needed %.1f, twist %.3f\n", integrator, step, *low,
      *high, needed, f->theta[NV - 2] - f->theta[0]);
  assert_true(*low > needed);
  for (int j = 0; j < NV - 1; j++) assert_true(f->tension[j] > 0);
  assert_at_most(f->worst_length_error, 1e-10);
  trial_end(&t);
}

/* The rod ends under tension, 1270 to 1390; at the file's step the damping of symplectic Euler takes part of
 * it. */
static void test_twisted(void **state) {
  (void)state;
  double low, high;
  run_twisted("verlet", 3e-3 * (0.5 / 0.501), &low, &high);
  assert_true(low > 1270 && high < 1390);
  run_twisted("verlet", 1.25e-4, &low, &high);
  assert_true(low > 1270 && high < 1390);
  run_twisted("symplectic-euler", 1.25e-5, &low, &high);
  assert_true(low > 1270 && high < 1390);
  run_twisted("symplectic-euler", 3e-3 * (0.5 / 0.501), &low, &high);
}

/* To one trajectory. */
static void test_twisted_converges(void **state) {
  (void)state;
  check_convergence("thesis-1-twisted.yaml", "verlet", 2, 0.5, 5e-4);
  check_convergence("thesis-1-twisted.yaml", "symplectic-euler", 1, 0.5, 1e-4);
}

/* The printed lengths leave no room, which is said; the printed tolerance stretches edges, by up to 8 %. */
static void test_as_printed(void **state) {
  (void)state;
  trial t = {0};
  open_scene(&t, "thesis-1-as-printed.yaml", NULL);
  bool told = false;
  for (int k = 0; k < t.model->note_count; k++) told = told || strstr(t.model->notes[k], "leave no room");
  assert_true(told);
  trial_run(&t, hb_sim_total_steps(t.sim));
  const hb_frame *f = trial_measure(&t);
  say("as printed: worst length error %.3f\n", f->worst_length_error);
  /* |C| = l |(e/l)^2 - 1| <= 1e-2 with l = sqrt(2)/24 allows e/l up to 1.0815 */
  assert_true(f->worst_length_error > 0.01 && f->worst_length_error < 0.0816);
  trial_end(&t);
}

/* ---- example 2: the twisted catenary
 * ------------------------------------------------------------------------ */

/* How far the shape is from (x, y, z)_i = (1 - x, 1 - y, z)_{n+1-i}. */
static double asymmetry(const double *x) {
  double worst = 0;
  for (int i = 0; i < NV; i++) {
    const double *a = x + 3 * i, *b = x + 3 * (NV - 1 - i);
    worst = fmax(worst, fmax(fmax(fabs(a[0] + b[0] - 1), fabs(a[1] + b[1] - 1)), fabs(a[2] - b[2])));
  }
  return worst;
}

/* Symmetric to the end; the energy, 94.05 of it twist at the start, swings by 1e-5 of itself and does not
 * drift. */
static void test_catenary(void **state) {
  (void)state;
  trial t = {0};
  open_scene(&t, "thesis-2-catenary.yaml", NULL);
  assert_string_equal(t.def.method.integrator, "verlet");
  long steps = hb_sim_total_steps(t.sim);
  const hb_frame *f = trial_measure(&t);
  double start = f->kinetic + f->bending + f->twisting, worst = 0, skew = 0, early = 0, late = 0;
  assert_near(f->twisting, 94.05, 0.005);
  for (long k = 1; k <= steps; k++) {
    trial_run(&t, 1);
    f = trial_measure(&t);
    double away = fabs(f->kinetic + f->bending + f->twisting - start);
    worst = fmax(worst, away);
    if (f->time > 0.7 * t.def.method.duration)
      late = fmax(late, away);
    else
      early = fmax(early, away);
    skew = fmax(skew, asymmetry(f->position));
  }
  say("example 2: energy %.6f, off by at most %.2e (%.2e before 0.7 of the time, %.2e after), asymmetry "
      "%.1e\n",
      start, worst, early, late, skew);
  assert_at_most(skew, 1e-8);
  assert_at_most(worst, 2e-5 * start);
  assert_at_most(late, 1.2 * early);
  assert_at_most(f->worst_length_error, 1e-10);
  trial_end(&t);
}

/* To one trajectory, up to t = 1. */
static void test_catenary_converges(void **state) {
  (void)state;
  check_convergence("thesis-2-catenary.yaml", "verlet", 2, 1, 1e-3);
  check_convergence("thesis-2-catenary.yaml", "symplectic-euler", 1, 1, 1e-4);
}

/* ---- example 3: the tree
 * ------------------------------------------------------------------------------------ */

/* The tree's numbers: edges, bending modulus, mass per vertex. */
#define EDGE (1.0 / 24)
#define ALPHA 100.0
#define MASS 50.0

/* Tip of the discrete rod at rest under a force of 5 on every vertex: turning by p at a vertex costs 2
 * alpha/h tan^2(p/2); its derivative is the moment of the forces beyond. Solved by repeated substitution. */
static void static_tip(double force, double *x, double *z) {
  double turn[NV] = {0}, px[NV] = {0}, pz[NV] = {0};
  for (int sweep = 0; sweep < 400; sweep++) {
    double angle = 0;
    for (int i = 1; i < NV; i++) {
      if (i > 1) angle += turn[i - 1];
      px[i] = px[i - 1] + EDGE * sin(angle);
      pz[i] = pz[i - 1] + EDGE * cos(angle);
    }
    for (int i = 1; i + 1 < NV; i++) {
      double moment = 0;
      for (int k = i + 1; k < NV; k++) moment += force * (pz[k] - pz[i]);
      double t = tan(0.5 * turn[i]);
      turn[i] = 2 * atan(moment * EDGE / (2 * ALPHA) / (1 + t * t));
    }
  }
  *x = px[NV - 1];
  *z = pz[NV - 1];
}

/* Lowest circular frequency of small sway: inverse iteration. A load w m bends vertex i by moment * h/alpha.
 */
static double sway_frequency(double *shape) {
  double omega2 = 0, w[NV];
  for (int i = 0; i < NV; i++) w[i] = i * i;
  for (int turn = 0; turn < 100; turn++) {
    double slope = 0, next[NV] = {0};
    for (int i = 1; i + 1 < NV; i++) {
      double moment = 0;
      for (int k = i + 1; k < NV; k++) moment += MASS * w[k] * EDGE * (k - i);
      slope += moment * EDGE / ALPHA;
      next[i + 1] = next[i] + EDGE * slope;
    }
    omega2 = w[NV - 1] / next[NV - 1];
    for (int i = 0; i < NV; i++) w[i] = next[i] / next[NV - 1];
  }
  memcpy(shape, w, sizeof w);
  return sqrt(omega2);
}

/* The run of the file: in the plane, without twist, over and back. */
static void test_tree(void **state) {
  (void)state;
  trial t = {0};
  open_scene(&t, "thesis-3-tree.yaml", NULL);
  long steps = hb_sim_total_steps(t.sim);
  double tip = 0, when = 0, back = HUGE_VAL;
  for (long k = 1; k <= steps; k++) {
    trial_run(&t, 1);
    const double *x = hb_sim_const_state(t.sim)->x + 3 * (NV - 1);
    if (x[0] > tip) {
      tip = x[0];
      when = hb_sim_time(t.sim);
    }
    if (hb_sim_time(t.sim) > when + 1) back = fmin(back, x[0]);
    if (k % 100) continue;
    const hb_frame *f = trial_measure(&t);
    for (int i = 0; i < NV; i++) assert_near(f->position[3 * i + 1], 0, 1e-15);
    assert_same(f->twisting, 0);
    for (int j = 0; j < NV - 1; j++) assert_near(f->theta[j], f->theta[0], 1e-15);
  }
  say("example 3: tip %.5f at %.3f, back to %.4f\n", tip, when, back);
  assert_near(tip, 0.2839, 5e-5);
  assert_near(when, 3.04, 0.01);
  assert_true(back < 0.1 * tip);
  trial_end(&t);
}

/* With friction it comes to rest where the discrete rod's statics put it. */
static void test_tree_at_rest(void **state) {
  (void)state;
  trial t = {0};
  double x, z;
  static_tip(5, &x, &z);
  assert_near(x, 0.143039539, 6e-10);
  assert_near(z, 0.987936821, 6e-10);
  read_scene(&t, "thesis-3-tree.yaml",
             (const char *const[]){"method.time_step=2e-3", "method.length_tolerance=1e-13", NULL});
  t.def.rods[0].mass_damping = 2;
  trial_start(&t);
  trial_run(&t, 20000);
  const double *tip = hb_sim_const_state(t.sim)->x + 3 * (NV - 1);
  say("example 3 at rest: x %.12f z %.12f; statics %.12f %.12f\n", tip[0], tip[2], x, z);
  assert_near(tip[0], x, 1e-11);
  assert_near(tip[2], z, 1e-11);
  trial_end(&t);
}

/* In a small wind: the period of the tip within 1 % of linear theory, that of the mode itself to 1e-6. */
static void test_tree_sways(void **state) {
  (void)state;
  trial t = {0};
  double shape[NV], omega = sway_frequency(shape), before = 0, mode_before = 0, tip_period = 0, period = 0;
  open_scene(&t, "thesis-3-tree.yaml", (const char *const[]){"forces[0].per_vertex=[1e-3, 0, 0]", NULL});
  int turns = 0, tip_turns = 0;
  double h = t.def.method.time_step;
  while (hb_sim_time(t.sim) < 4.2 * 2 * PI / omega) {
    trial_run(&t, 1);
    const double *v = hb_sim_const_state(t.sim)->v;
    double mode = 0, tip = v[3 * (NV - 1)], now = hb_sim_time(t.sim);
    for (int i = 0; i < NV; i++) mode += shape[i] * v[3 * i];
    /* from swinging back to swinging out: a whole period is over */
    if (mode_before < 0 && mode >= 0) period = (now - h * mode / (mode - mode_before)) / ++turns;
    if (before < 0 && tip >= 0) tip_period = (now - h * tip / (tip - before)) / ++tip_turns;
    before = tip;
    mode_before = mode;
  }
  say("example 3 in a small wind: period %.8f, of the tip %.5f; linear theory %.8f (%d, %d turns)\n", period,
      tip_period, 2 * PI / omega, turns, tip_turns);
  assert_int_equal(turns, 4);
  assert_near_rel(period, 2 * PI / omega, 1e-6);
  assert_near_rel(tip_period, 2 * PI / omega, 1e-2);
  trial_end(&t);
}

/* To one trajectory. */
static void test_tree_converges(void **state) {
  (void)state;
  check_convergence("thesis-3-tree.yaml", "verlet", 2, 1, 1.25e-4);
  check_convergence("thesis-3-tree.yaml", "symplectic-euler", 1, 1, 1e-3);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_twisted),
      cmocka_unit_test(test_twisted_converges),
      cmocka_unit_test(test_as_printed),
      cmocka_unit_test(test_catenary),
      cmocka_unit_test(test_catenary_converges),
      cmocka_unit_test(test_tree),
      cmocka_unit_test(test_tree_at_rest),
      cmocka_unit_test(test_tree_sways),
      cmocka_unit_test(test_tree_converges),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
