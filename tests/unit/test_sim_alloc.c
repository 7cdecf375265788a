/* Compiling a model and running it: every allocation may fail, and a step makes none. */
#include "hebra/scene.h"
#include "hebra/sim.h"
#include "support/failing_alloc.h"
#include "support/near.h"

#include <string.h>

/* Closed-form and general rods, viscosity, every kind of support and load. */
static const char scene[] = "method: {time_step: 1e-4, duration: 1}\n"
                            "gravity: [0, 0, -9.81]\n"
                            "rods:\n"
                            "  - name: a\n"
                            "    rest: {line: {from: [0, 0, 0], to: [1, 0, 0], vertices: 150}}\n"
                            "    initial: {displace: [0, 0, 0.05*sin(pi*u)]}\n"
                            "    lengths: initial\n"
                            "    bending: 0.01\n"
                            "    twisting: 0.01\n"
                            "    linear_density: 0.1\n"
                            "    start: {position: fixed, tangent: fixed, material_angle: 3*pi*t}\n"
                            "    end: {position: ['x - 0.01*t', y, z], material_angle: 0}\n"
                            "  - name: b\n"
                            "    rest: {helix: {radius: 0.1, pitch: 0.05, turns: 2, vertices: 30}}\n"
                            "    bending: [0.01, 0.02]\n"
                            "    twisting: 0.01\n"
                            "    linear_density: 0.1\n"
                            "    damping: {mass: 0.1, bending: 1e-5}\n"
                            "    start: {clamp: true}\n"
                            "    supports: [{edge: 20, material: fixed}]\n"
                            "  - name: c\n"
                            "    rest: {line: {from: [0, 0, 1], to: [1, 0, 1], vertices: 4}}\n"
                            "    bending: 0.01\n"
                            "    twisting: 0.01\n"
                            "    linear_density: 0.1\n"
                            "    start: {position: fixed}\n"
                            "    end: {position: fixed}\n"
                            "forces:\n"
                            "  - {point: [0, 0.1, t], rod: a, vertex: 50, follower: true}\n"
                            "  - wind: {velocity: [1, 0, 0], drag: {density: 1.2}}\n";

/* Compiles, steps, measures, frees. */
static hb_status trial(void *context, hb_error *err) {
  const hb_scene_def *def = context;
  hb_model *model = NULL;
  hb_sim *sim = NULL;
  hb_frame *frame = NULL;
  hb_state *copy = NULL;
  hb_status status = hb_model_create(def, &model, err);
  if (!status) status = hb_state_create(model, &copy, err);
  if (!status) status = hb_sim_create(model, &sim, err);
  if (!status) status = hb_frame_create(model, &frame, err);
  for (int k = 0; !status && k < 3; k++) {
    long before = failing_alloc_count();
    status = hb_sim_step(sim, err);
    hb_sim_snapshot(sim, true, copy);
    hb_sim_measure(sim, frame);
    assert_int_equal(failing_alloc_count(), before);
  }
  hb_state_free(copy);
  hb_frame_free(frame);
  hb_sim_free(sim);
  hb_model_free(model);
  return status;
}

/* The n-th allocation fails, for every n. */
static void every_allocation_may_fail(void **state) {
  (void)state;
  assert_true(failing_alloc_scene(trial, scene) > 30);
}

/* What a simulation says of its memory is what it has taken: with lanes and threads, and without. */
static void memory_is_counted(void **state) {
  (void)state;
  static const char *const texts[] = {
      scene,
      "method: {time_step: 1e-6, duration: 1}\nrods:\n"
      "  - {name: h, copies: 40, rest: {line: {to: [0, 0, 1], vertices: 70}}, bending: 1e-4,\n"
      "     twisting: 1e-4, linear_density: 1, start: {position: fixed}}\n"
      "  - {rest: {helix: {radius: 0.1, pitch: 0.05, turns: 2, vertices: 900}}, bending: [1e-6, 2e-6],\n"
      "     twisting: 1e-6, linear_density: 1}\n"
      "gravity: [0, 0, -1]\n"};
  for (int n = 0; n < 4; n++) {
    hb_scene_def def;
    hb_model *model = NULL;
    hb_sim *sim = NULL;
    hb_error err = {HB_OK, ""};
    if (hb_scene_parse(texts[n / 2], strlen(texts[n / 2]), "scene.yaml", NULL, NULL, 0, &def, &err))
      fail_msg("%s", err.text);
    def.method.threads = 1 + 2 * (n % 2);
    assert_int_equal(hb_model_create(&def, &model, &err), HB_OK);
    long before = failing_alloc_bytes();
    assert_int_equal(hb_sim_create(model, &sim, &err), HB_OK);
    double taken = (double)(failing_alloc_bytes() - before), said = (double)hb_sim_memory(sim);
    assert_at_most(fabs(taken - said), 0.01 * taken + 1000); /* the system rounds each block up */
    hb_sim_free(sim);
    assert_int_equal(failing_alloc_bytes(), before);
    hb_model_free(model);
    hb_scene_def_free(&def);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(every_allocation_may_fail),
                                     cmocka_unit_test(memory_is_counted)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
