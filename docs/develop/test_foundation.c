/* A long rod on springs under a point load: it sinks by P lambda/(2 k), lambda = (k/(4 B))^(1/4), under the
 * load (Hetenyi, Beams on Elastic Foundation, 1946). And the force is minus the slope of the energy. */
#include "support/near.h"

#include "force/force.h"
#include "hebra/scene.h"
#include "hebra/sim.h"

#include <string.h>

/* B = 0.1, k = 250: lambda = 5. The rod reaches 10/lambda to each side, where next to nothing is left of the
 * deflection. Damped nearly critically, so that 3 time units bring it to rest. */
static const char scene[] = "parameters: {n: 101}\n"
                            "method: {time_step: 5e-4*(101/n)^2, duration: 3}\n"
                            "rods:\n"
                            "  - rest: {line: {from: [-2, 0, 0], to: [2, 0, 0], vertices: n}}\n"
                            "    bending: 0.1\n"
                            "    twisting: 0.1\n"
                            "    linear_density: 1\n"
                            "    damping: {mass: 25}\n"
                            "forces:\n"
                            "  - foundation: [0, 250, 250]\n"
                            "  - {point: [0, 0, -0.01], vertex: (n - 1)/2}\n";

/* A running simulation of the scene with one setting changed. */
typedef struct bed {
  hb_scene_def def;
  hb_model *model;
  hb_sim *sim;
} bed;

/* Text to simulation; the test fails with the sentence if that fails. */
static void make(bed *b, const char *setting) {
  hb_error err = {.status = HB_OK};
  hb_status status = hb_scene_parse(scene, strlen(scene), "foundation", ".", &setting, 1, &b->def, &err);
  if (!status) status = hb_model_create(&b->def, &b->model, &err);
  if (!status) status = hb_sim_create(b->model, &b->sim, &err);
  if (status) fail_msg("%s", err.text);
}

/* Frees it. */
static void unmake(bed *b) {
  hb_sim_free(b->sim);
  hb_model_free(b->model);
  hb_scene_def_free(&b->def);
}

/* How far the middle sinks. */
static double sinking(const char *setting) {
  bed b;
  hb_error err;
  make(&b, setting);
  for (long n = hb_sim_total_steps(b.sim); n > 0; n--) assert_int_equal(hb_sim_step(b.sim, &err), HB_OK);
  double z = hb_sim_state(b.sim)->x[3 * (b.model->nv / 2) + 2];
  unmake(&b);
  return -z;
}

/* The error is that of second-order differences: a quarter at half the edge length, and small. */
static void test_point_load(void **state) {
  (void)state;
  const double exact = 0.01 * 5 / (2 * 250);
  double coarse = sinking("parameters.n=51"), fine = sinking("parameters.n=101");
  assert_near_rel(fine, exact, 1e-2);
  assert_near_rel((coarse - exact) / (fine - exact), 4, 0.1);
}

/* The force against the slope of the energy, which is quadratic: central differences are exact to round-off.
 */
static void test_slope(void **state) {
  (void)state;
  bed b;
  make(&b, "parameters.n=11");
  const hb_rod *rod = &b.model->rods[0];
  double x[33], f[33] = {0};
  for (int k = 0; k < 33; k++) x[k] = b.model->initial[k] + 0.01 * (k % 7);
  hb_force_foundation.add(b.model, rod, 0, x, NULL, NULL, f);
  for (int k = 0; k < 33; k++) {
    double kept = x[k], h = 0.01;
    x[k] = kept + h;
    double above = hb_force_foundation.energy(b.model, rod, 0, x);
    x[k] = kept - h;
    double below = hb_force_foundation.energy(b.model, rod, 0, x);
    x[k] = kept;
    assert_near(f[k], (below - above) / (2 * h), 1e-12);
  }
  unmake(&b);
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_point_load), cmocka_unit_test(test_slope)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
