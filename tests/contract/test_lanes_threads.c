/* Contract of threads: 1, 2 and 3 of them give the same bits where many units share the work, and the same
 * sentence about the same rod at the same step where a unit fails. */
#include "support/lanes.h"

#include "sim/sim.h"

#define RODS 72

/* Isotropic and general rods of two lengths, some clamped, under weight: over 2,000 vertices, 18 units.
 * failing: two rods far from each other have loads that stop being numbers, the second one earlier. */
static void start(trial *t, const char *integrator, int threads, bool failing) {
  rng r = rng_start(7);
  *t = (trial){0};
  scene_begin(&t->def, integrator, 1e-4);
  t->def.method.duration = 1;
  t->def.method.threads = threads;
  for (int n = 0; n < RODS; n++) {
    lanes_add_rod(&t->def, &r, n % 3 ? 42 : 30, n % 2 ? LANE_FREE : LANE_CLAMPED);
    if (n % 4 == 1) lanes_make_general(&t->def, &r);
  }
  (void)scene_force(&t->def, HB_FORCE_GRAVITY, "0", "0.5", "-1");
  if (failing) {
    scene_force(&t->def, HB_FORCE_PER_VERTEX, "0.01*sqrt(0.00455 - t)", NULL, NULL)->rod = 3;
    scene_force(&t->def, HB_FORCE_PER_VERTEX, "0.01*sqrt(0.00345 - t)", NULL, NULL)->rod = 60;
  }
  trial_start(t);
  const hb_lane_plan *plan = t->sim->stepper.plan;
  assert_true(plan && plan->unit_count >= RODS / 4);
  assert_int_equal(hb_pool_threads(t->sim->stepper.pool), threads);
}

/* Blocks of steps, odd ones. */
static void test_same_bits(void **state) {
  (void)state;
  for (int k = 0; hb_integrators[k] && !hb_integrators[k]->implicit; k++) {
    uint64_t hash[3];
    for (int threads = 1; threads <= 3; threads++) {
      trial t;
      start(&t, hb_integrators[k]->name, threads, false);
      trial_run(&t, 37);
      hash[threads - 1] = hb_state_hash(hb_sim_const_state(t.sim));
      trial_end(&t);
    }
    assert_true(hash[0] == hash[1] && hash[0] == hash[2]);
  }
}

/* The earliest failure counts, whoever finds it. */
static void test_same_failure(void **state) {
  (void)state;
  for (int k = 0; hb_integrators[k] && !hb_integrators[k]->implicit; k++) {
    hb_error first = {HB_OK, ""};
    for (int threads = 1; threads <= 3; threads++) {
      trial t;
      hb_error err = {HB_OK, ""};
      start(&t, hb_integrators[k]->name, threads, true);
      assert_int_equal(hb_sim_advance(t.sim, 100, &err), HB_ERR_NUMERIC);
      if (threads == 1) first = err;
      say("%s, %d threads: %s\n", hb_integrators[k]->name, threads, err.text);
      assert_non_null(strstr(err.text, "step 35 "));
      assert_non_null(strstr(err.text, "rod rod61:"));
      assert_string_equal(err.text, first.text);
      trial_end(&t);
    }
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_same_bits), cmocka_unit_test(test_same_failure)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
