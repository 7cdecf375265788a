/* Lanes are made when a simulation is made, and never grow: every allocation may fail, and no step asks for
 * one. */
#include "support/near.h"

#include "hebra/plug.h"
#include "support/failing_alloc.h"
#include "support/lanes.h"

/* One rod in pieces, with twist and without; one that needs several strips; two bundles. */
static void build(hb_scene_def *def, const char *integrator) {
  static const int nv[] = {1100, 60, 40, 12, 12, 11, 8, 7, 7, 7};
  rng r = rng_start(3);
  scene_begin(def, integrator, 1e-4);
  for (size_t n = 0; n < sizeof nv / sizeof nv[0]; n++)
    lanes_add_rod(def, &r, nv[n], n == 1 || n > 5 ? LANE_BOTH_CLAMPED : LANE_CLAMPED);
  lanes_add_loads(def, &r);
}

/* Model and simulation. */
static hb_status make(void *context, hb_error *err) {
  const hb_scene_def *def = context;
  hb_model *model = NULL;
  hb_sim *sim = NULL;
  hb_status status = hb_model_create(def, &model, err);
  if (!status) status = hb_sim_create(model, &sim, err);
  if (!status) status = hb_sim_step(sim, err);
  hb_sim_free(sim);
  hb_model_free(model);
  return status;
}

/* Fails each in turn. */
static void test_every_allocation_fails(void **state) {
  (void)state;
  hb_scene_def def;
  long count[2];
  build(&def, "verlet");
  for (int off = 0; off < 2; off++) {
    def.method.lanes = off ? HB_LANES_OFF : HB_LANES_BEST;
    count[off] = failing_alloc_loop(make, &def, 1);
  }
  say("%ld allocations with lanes, %ld without\n", count[0], count[1]);
  assert_true(count[0] > count[1] + 5);
  hb_scene_def_free(&def);
}

/* Neither a step nor looking at the state, writing to it or putting one back. */
static void test_no_allocation(void **state) {
  (void)state;
  for (int k = 0; hb_integrators[k] && !hb_integrators[k]->implicit; k++) {
    trio t = {0};
    build(&t.def, hb_integrators[k]->name);
    trio_start(&t, 0);
    assert_true(trio_all_in_lanes(&t) && trio_any_pieces(&t) && trio_any_bundle(&t));
    size_t count = hb_sim_const_state(t.sim[WAY_BEST])->count;
    double *saved = scene_copy(hb_sim_const_state(t.sim[WAY_BEST])->block, count);
    failing_alloc_arm(1);
    trio_run(&t, 5, NULL);
    hb_sim_state(t.sim[WAY_BEST])->v[0] += 0;
    hb_status restored = hb_sim_restore(t.sim[WAY_BEST], saved, count, NULL);
    long asked = failing_alloc_count();
    assert_false(failing_alloc_disarm());
    assert_int_equal(restored, HB_OK);
    assert_int_equal(asked, 0);
    hb_free(saved);
    trio_end(&t);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_every_allocation_fails),
      cmocka_unit_test(test_no_allocation),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
