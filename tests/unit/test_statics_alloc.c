/* Looking for an equilibrium: every allocation may fail. */
#include "hebra/modes.h"
#include "hebra/scene.h"
#include "hebra/sim.h"
#include "hebra/statics.h"
#include "support/failing_alloc.h"
#include "support/near.h"

/* Closed-form and general rods, supports that move, loads that depend on place. */
static const char scene[] = "method: {time_step: 1e-4, duration: 1}\n"
                            "gravity: [0, 0, -9.81]\n"
                            "rods:\n"
                            "  - name: a\n"
                            "    rest: {line: {from: [0, 0, 0], to: [1, 0, 0], vertices: 21}}\n"
                            "    initial: {displace: [0, 0, 0.05*sin(pi*u)]}\n"
                            "    lengths: initial\n"
                            "    bending: 0.01\n"
                            "    twisting: 0.01\n"
                            "    linear_density: 0.1\n"
                            "    start: {position: fixed, tangent: fixed, material_angle: pi*t}\n"
                            "    end: {position: ['x - 0.1*t', y, z]}\n"
                            "  - name: b\n"
                            "    rest: {helix: {radius: 0.1, pitch: 0.05, turns: 2, vertices: 30}}\n"
                            "    bending: [0.01, 0.02]\n"
                            "    twisting: 0.01\n"
                            "    linear_density: 0.01\n"
                            "    start: {position: fixed, tangent: fixed, material: fixed}\n"
                            "  - name: c\n"
                            "    initial: {ring: {radius: 0.1, vertices: 9}}\n"
                            "    closed: {link: 1}\n"
                            "    straight_rest: true\n"
                            "    bending: [0.01, 0.01001]\n"
                            "    twisting: 0.01\n"
                            "    linear_density: 0.001\n"
                            "    supports: [{vertex: 0, position: fixed}]\n"
                            "forces:\n"
                            "  - {point: [0, 0, -z], rod: a, vertex: 10}\n";

/* Compiles, solves, measures, looks for modes, starts again from what was measured, frees. */
static hb_status trial(void *context, hb_error *err) {
  const hb_scene_def *def = context;
  hb_model *model = NULL;
  hb_sim *sim = NULL;
  hb_frame *frame = NULL;
  hb_equilibrium found = {.multiplier = NULL};
  hb_modes modes = {.count = 0};
  hb_matrices matrices = {.slot = NULL};
  hb_equilibrium_options options = hb_equilibrium_defaults(1);
  hb_status status = hb_model_create(def, &model, err);
  if (!status) status = hb_sim_create(model, &sim, err);
  if (!status) status = hb_frame_create(model, &frame, err);
  if (!status) status = hb_sim_find_equilibrium(sim, &options, &found, err);
  if (!status) hb_sim_measure_equilibrium(sim, &found, frame);
  if (!status) status = hb_sim_find_modes(sim, &found, 3, &modes, err);
  if (!status) status = hb_sim_find_matrices(sim, &found, &matrices, err);
  if (!status) status = hb_sim_resume(sim, frame, err);
  if (!status) status = hb_sim_measure_mode(sim, &found, &modes.mode[0], 1e-3, 0, frame, err);
  hb_modes_free(&modes);
  hb_matrices_free(&matrices);
  hb_equilibrium_free(&found);
  hb_frame_free(frame);
  hb_sim_free(sim);
  hb_model_free(model);
  return status;
}

/* The n-th allocation fails, for every n. */
static void every_allocation_may_fail(void **state) {
  (void)state;
  assert_true(failing_alloc_scene(trial, scene) > 60);
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(every_allocation_may_fail)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
