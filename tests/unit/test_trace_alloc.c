/* Following branches: every allocation may fail. */
#include "hebra/hebra.h"
#include "support/failing_alloc.h"
#include "support/near.h"

#include <string.h>

/* A bifurcation and both of its sides, in few points; a frame that is held by its angle. */
static const char scene[] = "parameters: {P: 0}\n"
                            "method: {time_step: 1e-4, duration: 0}\n"
                            "rods:\n"
                            "  - rest: {line: {to: [1, 0, 0], vertices: 6}}\n"
                            "    bending: 1\n"
                            "    twisting: 1\n"
                            "    linear_density: 1\n"
                            "    start: {position: fixed, tangent: fixed, material: fixed}\n"
                            "    supports: [{vertex: -1, position: [free, free, 0]}]\n"
                            "forces:\n"
                            "  - {point: [-P, 0, 0], vertex: -1}\n"
                            "trace: {parameter: P, from: 3, to: 5, step: 1, points: 5, branches: 2}\n";

/* Measures, as the program does. */
static hb_status take(void *context, const hb_trace_point *point, hb_error *err) {
  hb_frame *frame = NULL;
  hb_status status = hb_frame_create(hb_sim_model(point->sim), &frame, err);
  if (!status) hb_sim_measure_equilibrium(point->sim, &point->found, frame);
  hb_frame_free(frame);
  *(int *)context += 1;
  return status;
}

/* A branch that could not be entered because there was no memory must not pass for one that is not there. */
static hb_status finish(void *context, const hb_trace_end *end, hb_error *err) {
  (void)context;
  (void)err;
  assert_false(end->failed);
  return HB_OK;
}

/* Reads, traces, frees. */
static hb_status trial(void *context, hb_error *err) {
  hb_scene_def def;
  int points = 0;
  hb_status status = hb_scene_parse(scene, strlen(scene), "scene.yaml", ".", NULL, 0, &def, err);
  if (status) return status;
  hb_scene_range range = {&def, def.trace.parameter, 0};
  hb_trace_family family = hb_scene_family(&range);
  hb_trace_options options = {def.trace.from, def.trace.to, def.trace.step, def.trace.points, 2, false};
  hb_trace_sink sink = {take, finish, &points};
  status = hb_trace(&family, &options, &sink, NULL, err);
  if (!status) *(int *)context = points;
  hb_scene_def_free(&def);
  return status;
}

/* The n-th allocation fails, for every 997th n. */
static void every_allocation_may_fail(void **state) {
  (void)state;
  int points = 0;
  assert_true(failing_alloc_loop(trial, &points, 997) > 1000);
  assert_true(points > 6); /* both branches */
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(every_allocation_may_fail)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
