/* Contract of single precision: the run of a scene in floats stays near the one in doubles, keeps lengths to
 * its own tolerance, and is the same to the last bit for any threads, instructions and restarts. */
#include "support/near.h"

#include "hebra/scene.h"
#include "sim/sim.h"
#include "support/scenes.h"

/* Cases: in lanes side by side, and in pieces. */
static const struct {
  const char *integrator;
  int n;
  bool general;
} cases[] = {{"verlet", 21, false},
             {"verlet", 101, true},
             {"symplectic-euler", 40, true},
             {"verlet", 150, false},
             {"symplectic-euler", 101, false}};
#define CASES ((int)(sizeof cases / sizeof cases[0]))

/* Copies of a rod, clamped at one end and turned there, falling; general: anisotropic, curved at rest. */
static void build(trial *t, int which, bool single, hb_lane_choice lanes, int threads, int copies) {
  char text[2048];
  hb_error err = {HB_OK, ""};
  int n = cases[which].n;
  bool general = cases[which].general;
  int length = snprintf(
      text, sizeof text,
      "method: {integrator: %s, time_step: %.17g, duration: 1, precision: %s, length_tolerance: 1e-5}\n"
      "rods:\n  - name: rod\n    copies: %d\n"
      "    rest: {helix: {radius: 0.1, pitch: 0.2, turns: 1.5, vertices: %d}}\n    straight_rest: %s\n"
      "    velocity: ['0.1*sin(3*s + k)', '0.2*cos(2*s)', 0]\n    bending: %s\n    twisting: 0.02\n"
      "    linear_density: 0.2\n    start: {clamp: edge, material_angle: 1}\n    end: {position: fixed, "
      "material_angle: 0}\n"
      "gravity: [0, 0, -9.81]\n",
      cases[which].integrator, fmin(2e-4, 0.75 / ((n - 1) * (n - 1))), single ? "single" : "double", copies,
      n, general ? "false" : "true", general ? "[0.02, 0.03]" : "0.02");
  assert_true(length > 0 && (size_t)length < sizeof text);
  if (hb_scene_parse(text, (size_t)length, "text", ".", NULL, 0, &t->def, &err)) fail_msg("%s", err.text);
  t->def.method.lanes = lanes;
  t->def.method.threads = threads;
  trial_start(t);
}

/* 200 steps: floats round at 6e-8 of a coordinate, each step adds some of it, and bending waves spread it. */
static void test_near_double(void **state) {
  (void)state;
  for (int k = 0; k < CASES; k++) {
    trial a = {0}, b = {0};
    build(&a, k, false, HB_LANES_BEST, 1, 5);
    build(&b, k, true, HB_LANES_BEST, 1, 5);
    trial_run(&a, 200);
    trial_run(&b, 200);
    size_t count = 3 * (size_t)a.model->nv;
    double away = largest_difference(hb_sim_const_state(a.sim)->x, hb_sim_const_state(b.sim)->x, count);
    double moved = largest_difference(hb_sim_const_state(a.sim)->x, a.model->initial, count);
    double worst = trial_measure(&b)->worst_length_error;
    say("%s %d %s: single off by %.1e, moved %.2g, lengths %.1e\n", cases[k].integrator, cases[k].n,
        cases[k].general ? "general" : "isotropic", away, moved, worst);
    assert_at_most(away, 2e-6);
    double energy = trial_measure(&a)->kinetic;
    assert_near(trial_measure(&b)->kinetic, energy, 1e-3 * energy);
    assert_true(moved > 1e-3);
    assert_true(away > 1e-12); /* floats they are */
    assert_at_most(worst, 1.1e-5);
    trial_end(&a);
    trial_end(&b);
  }
}

/* The same bits from every kind of instructions, any number of threads, and after a restart, in both
 * precisions; copies: enough for threads to share, or one. */
static void check_bits(int k, bool single, int copies) {
  trial a = {0}, b = {0}, c = {0};
  hb_error err = {HB_OK, ""};
  build(&a, k, single, HB_LANES_BEST, 1, copies);
  build(&b, k, single, HB_LANES_PORTABLE, 3, copies);
  build(&c, k, single, HB_LANES_BEST, 2, copies);
  trial_run(&a, 17);
  size_t count = hb_sim_const_state(a.sim)->count;
  double *saved = scene_copy(hb_sim_const_state(a.sim)->block, count);
  trial_run(&a, 23);
  trial_run(&b, 40);
  assert_int_equal(hb_sim_restore(c.sim, saved, count, &err), HB_OK);
  assert_int_equal(hb_sim_advance(c.sim, 23, &err), HB_OK);
  uint64_t hash = hb_state_hash(hb_sim_const_state(a.sim));
  assert_true(hash == hb_state_hash(hb_sim_const_state(b.sim)));
  assert_true(hash == hb_state_hash(hb_sim_const_state(c.sim)));
  hb_free(saved);
  trial_end(&a);
  trial_end(&b);
  trial_end(&c);
}

/* Bundles of copies, more vertices than one thread keeps to itself, and single rods. */
static void test_same_bits(void **state) {
  (void)state;
  for (int k = 0; k < CASES; k++)
    for (int single = 0; single < 2; single++) {
      check_bits(k, single, 1);
      check_bits(k, single, 4000 / cases[k].n);
    }
}

/* Floats far from the origin, and on led supports, do not hold what lengths ask for: such rods stay in
 * doubles, in lanes, beside rods that are in floats. */
static void test_stays_double(void **state) {
  (void)state;
  static const char *const places[2] = {"[1000, 0, 0], to: [1001, 0, 0]", "[0, 0, 0], to: [1, 0, 0]"};
  for (int k = 0; k < 2; k++) {
    char text[1024];
    static double x[2][606];
    for (int single = 0; single < 2; single++) {
      trial t = {0};
      hb_error err = {HB_OK, ""};
      snprintf(
          text, sizeof text,
          "method: {integrator: verlet, time_step: 1e-4, duration: 1, precision: %s, length_tolerance: "
          "1e-5}\nrods:\n  - name: rod\n    rest: {line: {from: %s, vertices: 101}}\n    bending: 0.01\n"
          "    twisting: 0.02\n    linear_density: 0.2\n    start: {position: [%s, 0, 0]}\n  - name: near\n"
          "    rest: {line: {from: [-0.5, 0, 0], to: [0.5, 0, 0], vertices: 101}}\n    bending: 0.01\n"
          "    twisting: 0.02\n    linear_density: 0.2\n    start: {position: fixed}\ngravity: [0, 0, "
          "-9.81]\n",
          single ? "single" : "double", places[k], k ? "0.01*sin(9*t)" : "1000");
      if (hb_scene_parse(text, strlen(text), "text", ".", NULL, 0, &t.def, &err)) fail_msg("%s", err.text);
      trial_start(&t);
      const hb_lane_plan *plan = t.sim->stepper.plan;
      for (int r = 0; r < 2; r++) {
        assert_true(plan && plan->unit_of[r] >= 0);
        assert_int_equal(plan->units[plan->unit_of[r]].strips->single, single && r == 1);
      }
      trial_run(&t, 50);
      memcpy(x[single], hb_sim_const_state(t.sim)->x, sizeof x[single]);
      trial_end(&t);
    }
    assert_memory_equal(x[0], x[1], 303 * sizeof(double));
    assert_memory_not_equal(x[0] + 303, x[1] + 303, 303 * sizeof(double));
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_near_double), cmocka_unit_test(test_same_bits),
                                     cmocka_unit_test(test_stays_double)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
