/* A step asks for no memory, whatever the rods, forces and supports are, and measuring neither. */
#include "support/near.h"

#include "hebra/plug.h"
#include "support/failing_alloc.h"
#include "support/moving.h"

/* Every scene, every scheme. */
static void test_no_allocation(void **state) {
  (void)state;
  for (int k = 0; hb_integrators[k]; k++)
    for (int s = 0; s < MOVING_COUNT; s++) {
      trial t = {0};
      trial_build(&t, moving_scenes[s].build, hb_integrators[k]->name, 2e-3);
      double *saved = scene_copy(hb_sim_const_state(t.sim)->block, hb_sim_const_state(t.sim)->count);
      failing_alloc_arm(1); /* the first request would fail, and be counted */
      long before = failing_alloc_count();
      trial_run(&t, 300);
      (void)trial_measure(&t);
      hb_status restored = hb_sim_restore(t.sim, saved, hb_sim_const_state(t.sim)->count, NULL);
      long asked = failing_alloc_count() - before;
      assert_false(failing_alloc_disarm());
      assert_int_equal(restored, HB_OK);
      assert_int_equal(asked, 0);
      hb_free(saved);
      trial_end(&t);
    }
}

/* A scene from definition to measured frame with every allocation failing in turn: an error each time,
 * nothing lost. */
static hb_status whole_run(void *context, hb_error *err) {
  trial *t = context;
  hb_model *model = NULL;
  hb_sim *sim = NULL;
  hb_frame *frame = NULL;
  hb_status status = hb_model_create(&t->def, &model, err);
  if (!status) status = hb_sim_create(model, &sim, err);
  if (!status) status = hb_frame_create(model, &frame, err);
  if (!status) status = hb_sim_step(sim, err);
  if (!status) hb_sim_measure(sim, frame);
  hb_frame_free(frame);
  hb_sim_free(sim);
  hb_model_free(model);
  return status;
}

/* Every scene of the collection, explicit and implicit. */
static void test_every_allocation_fails(void **state) {
  (void)state;
  static const char *const schemes[2] = {"verlet", "implicit"};
  for (int s = 0; s < 2 * MOVING_COUNT; s++) {
    trial t = {0};
    scene_begin(&t.def, schemes[s % 2], 2e-3);
    moving_scenes[s / 2].build(&t.def);
    long count = failing_alloc_loop(whole_run, &t, 1);
    say("%s, %s: %ld allocations\n", schemes[s % 2], moving_scenes[s / 2].name, count);
    assert_true(count > 20);
    hb_scene_def_free(&t.def);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_no_allocation),
      cmocka_unit_test(test_every_allocation_fails),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
