/* Runs that go wrong, or could: what is said of them, and what must not happen silently. */
#include "hebra/scene.h"
#include "hebra/sim.h"
#include "support/near.h"

#include <stdio.h>
#include <string.h>

/* A rod clamped at its first edge, with room for more keys of the scene and of the rod. */
static const char pattern[] = "method: {time_step: %g, duration: 1}\n"
                              "%s\n"
                              "rods:\n"
                              "  - name: rod\n"
                              "    rest: {line: {from: [0, 0, 0], to: [1, 0, 0], vertices: 20}}\n"
                              "    bending: 0.1\n"
                              "    linear_density: 20\n"
                              "    start: {clamp: edge}\n"
                              "%s\n";

/* Runs the scene for so many steps; energies[3] of the end. The sentence of what failed is in err. */
static hb_status run(double h, const char *scene_keys, const char *rod_keys, int steps, double energies[3],
                     hb_error *err) {
  char text[2048];
  hb_scene_def def;
  hb_model *model = NULL;
  hb_sim *sim = NULL;
  hb_frame *frame = NULL;
  snprintf(text, sizeof text, pattern, h, scene_keys, rod_keys);
  hb_status status = hb_scene_parse(text, strlen(text), "scene.yaml", NULL, NULL, 0, &def, err);
  if (status) fail_msg("%s", err->text);
  status = hb_model_create(&def, &model, err);
  if (!status) status = hb_sim_create(model, &sim, err);
  if (!status) status = hb_frame_create(model, &frame, err);
  for (int k = 0; !status && k < steps; k++) status = hb_sim_step(sim, err);
  if (!status) {
    hb_sim_measure(sim, frame);
    energies[0] = frame->kinetic;
    energies[1] = frame->bending;
    energies[2] = frame->twisting;
  }
  hb_frame_free(frame);
  hb_sim_free(sim);
  hb_model_free(model);
  hb_scene_def_free(&def);
  return status;
}

/* A rod curled at rest hangs in the plane of its curl, bent the wrong way: by symmetry dE/dtheta = 0, but the
 * frames want to turn over. It must not stay there until round-off decides: a push out of the plane of 1e-9
 * of the weight gives the same energies. */
static void test_saddle_in_time(void **state) {
  (void)state;
  const char *rod = "    natural_curvature: [5, 0]\n    twisting: 1e-3";
  double flat[3], pushed[3];
  hb_error err = {HB_OK, ""};
  assert_int_equal(run(1e-4, "gravity: [0, 0, -9.81]", rod, 3000, flat, &err), HB_OK);
  assert_int_equal(run(1e-4, "gravity: [0, 1e-9, -9.81]", rod, 3000, pushed, &err), HB_OK);
  assert_near_rel(flat[1], pushed[1], 0.02);
}

/* Expects a failure with this sentence. */
static void expect(hb_status status, hb_status expected, const hb_error *err, const char *sentence) {
  assert_int_equal(status, expected);
  if (!strstr(err->text, sentence)) fail_msg("\"%s\" does not say \"%s\"", err->text, sentence);
}

/* Formulas of supports and loads that stop meaning anything. */
static void test_formulas_that_fail(void **state) {
  (void)state;
  double e[3];
  hb_error err = {HB_OK, ""};
  hb_status status =
      run(1e-3, "", "    twisting: 0.1\n    end: {material_frame: ['0', 'sqrt(0.05-t)', '1']}", 100, e, &err);
  expect(status, HB_ERR_NUMERIC, &err, "the prescribed director of edge 18");
  expect(status, HB_ERR_NUMERIC, &err, "step 51 (t = 0.051)");
  status = run(1e-3, "", "    twisting: 0.1\n    end: {material_frame: ['1', '0', '0.05-t']}", 100, e, &err);
  expect(status, HB_ERR_NUMERIC, &err, "and not along the edge");
  status = run(1e-3, "", "    twisting: 0.1\n    end: {material_angle: '1/(0.05-t)^0.5'}", 100, e, &err);
  expect(status, HB_ERR_NUMERIC, &err, "the prescribed angle of edge 18 is not finite");
  status = run(1e-3, "forces: [{point: [0, 0, 'sqrt(0.05-t)'], rod: rod, vertex: 7}]", "    twisting: 0.1",
               100, e, &err);
  expect(status, HB_ERR_NUMERIC, &err, "the load of vertex 7 is not finite any more");
}

/* A frame that jumps by 50 turns in one step: all of it must arrive, in closed form and by Newton. */
static void test_fifty_turns_at_once(void **state) {
  (void)state;
  double closed[3], newton[3];
  hb_error err = {HB_OK, ""};
  const char *angle = "    end: {position: fixed, tangent: fixed, material_angle: '100*pi*step(t-0.0005)'}";
  char rod[512];
  snprintf(rod, sizeof rod, "    twisting: 0.1\n%s", angle);
  assert_int_equal(run(1e-3, "", rod, 1, closed, &err), HB_OK);
  snprintf(rod, sizeof rod, "    twisting: 0.1\n    damping: {bending: 1e-30}\n%s",
           angle); /* makes the rod general */
  if (run(1e-3, "", rod, 1, newton, &err)) fail_msg("%s", err.text);
  assert_near_rel(newton[2], closed[2], 1e-9);
  assert_near_rel(closed[2],
                  0.5 * 0.1 * (100 * 3.14159265358979324) * (100 * 3.14159265358979324) / (18.0 / 19), 1e-9);
}

/* A stiff rod cannot start folded; a chain can. */
static void test_initial_fold(void **state) {
  (void)state;
  double e[3];
  hb_error err = {HB_OK, ""};
  const char *folded = "    twisting: 0\n    initial: {displace: ['if(i > 10, 20/19 - 2*s, 0)', 0, 0]}";
  hb_status status = run(1e-3, "", folded, 1, e, &err);
  expect(status, HB_ERR_INPUT, &err, "the initial shape folds back onto itself at vertex 10");
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_saddle_in_time), cmocka_unit_test(test_formulas_that_fail),
      cmocka_unit_test(test_fifty_turns_at_once), cmocka_unit_test(test_initial_fold)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
