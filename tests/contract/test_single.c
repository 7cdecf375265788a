/* Contract of single precision: the run of a scene in floats stays near the one in doubles, keeps lengths to
 * its own tolerance, and is the same to the last bit for any threads, instructions and restarts. */
#include "support/near.h"

#include "hebra/scene.h"
#include "support/scenes.h"

/* A rod of n vertices, clamped at one end and turned there, falling; general: anisotropic, curved at rest. */
static void build(trial *t, const char *integrator, int n, bool general, bool single, hb_lane_choice lanes,
                  int threads) {
  char text[2048];
  hb_error err = {HB_OK, ""};
  int length = snprintf(
      text, sizeof text,
      "method: {integrator: %s, time_step: %.17g, duration: 1, precision: %s, length_tolerance: 1e-5}\n"
      "rods:\n  - name: rod\n    copies: 5\n"
      "    rest: {helix: {radius: 0.1, pitch: 0.2, turns: 1.5, vertices: %d}}\n    straight_rest: %s\n"
      "    velocity: ['0.1*sin(3*s + k)', '0.2*cos(2*s)', 0]\n    bending: %s\n    twisting: 0.02\n"
      "    linear_density: 0.2\n    start: {clamp: edge, material_angle: 1}\n    end: {position: fixed, "
      "material_angle: 0}\n"
      "gravity: [0, 0, -9.81]\n",
      integrator, fmin(2e-4, 0.75 / ((n - 1) * (n - 1))), single ? "single" : "double", n,
      general ? "false" : "true", general ? "[0.02, 0.03]" : "0.02");
  assert_true(length > 0 && (size_t)length < sizeof text);
  if (hb_scene_parse(text, (size_t)length, "text", ".", NULL, 0, &t->def, &err)) fail_msg("%s", err.text);
  t->def.method.lanes = lanes;
  t->def.method.threads = threads;
  trial_start(t);
}

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
#define CASES (sizeof cases / sizeof cases[0])

/* 200 steps: floats round at 6e-8 of a coordinate, each step adds some of it, and bending waves spread it. */
static void test_near_double(void **state) {
  (void)state;
  for (size_t k = 0; k < CASES; k++) {
    trial a = {0}, b = {0};
    build(&a, cases[k].integrator, cases[k].n, cases[k].general, false, HB_LANES_BEST, 1);
    build(&b, cases[k].integrator, cases[k].n, cases[k].general, true, HB_LANES_BEST, 1);
    trial_run(&a, 200);
    trial_run(&b, 200);
    size_t count = 3 * (size_t)a.model->nv;
    double away = largest_difference(hb_sim_const_state(a.sim)->x, hb_sim_const_state(b.sim)->x, count);
    double moved = largest_difference(hb_sim_const_state(a.sim)->x, a.model->initial, count);
    double worst = trial_measure(&b)->worst_length_error;
    say("%s %d %s: single off by %.1e, moved %.2g, lengths %.1e\n", cases[k].integrator, cases[k].n,
        cases[k].general ? "general" : "isotropic", away, moved, worst);
    assert_at_most(away, 1e-5);
    assert_true(moved > 1e-3);
    assert_true(away > 1e-12); /* floats they are */
    assert_at_most(worst, 1.1e-5);
    trial_end(&a);
    trial_end(&b);
  }
}

/* The same bits from every kind of instructions, any number of threads, and after a restart. */
static void test_same_bits(void **state) {
  (void)state;
  for (size_t k = 0; k < CASES; k++) {
    trial a = {0}, b = {0}, c = {0};
    hb_error err = {HB_OK, ""};
    build(&a, cases[k].integrator, cases[k].n, cases[k].general, true, HB_LANES_BEST, 1);
    build(&b, cases[k].integrator, cases[k].n, cases[k].general, true, HB_LANES_PORTABLE, 3);
    build(&c, cases[k].integrator, cases[k].n, cases[k].general, true, HB_LANES_BEST, 2);
    trial_run(&a, 37);
    size_t count = hb_sim_const_state(a.sim)->count;
    double *saved = scene_copy(hb_sim_const_state(a.sim)->block, count);
    trial_run(&a, 43);
    trial_run(&b, 80);
    assert_int_equal(hb_sim_restore(c.sim, saved, count, &err), HB_OK);
    trial_run(&c, 43);
    uint64_t hash = hb_state_hash(hb_sim_const_state(a.sim));
    assert_true(hash == hb_state_hash(hb_sim_const_state(b.sim)));
    assert_true(hash == hb_state_hash(hb_sim_const_state(c.sim)));
    hb_free(saved);
    trial_end(&a);
    trial_end(&b);
    trial_end(&c);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_near_double), cmocka_unit_test(test_same_bits)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
