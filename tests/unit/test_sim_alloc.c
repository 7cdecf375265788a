/* Compiling a model and running it: every allocation may fail, and a step makes none. */
#include "hebra/scene.h"
#include "hebra/sim.h"
#include "support/failing_alloc.h"
#include "support/near.h"

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
  hb_status status = hb_model_create(def, &model, err);
  if (!status) status = hb_sim_create(model, &sim, err);
  if (!status) status = hb_frame_create(model, &frame, err);
  for (int k = 0; !status && k < 3; k++) {
    long before = failing_alloc_count();
    status = hb_sim_step(sim, err);
    hb_sim_measure(sim, frame);
    assert_int_equal(failing_alloc_count(), before);
  }
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

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(every_allocation_may_fail)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
