/* hb_model_stable_step: each thing that limits the step, alone and together, against its formula. */
#include "hebra/hebra.h"
#include "support/near.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* The estimate for a straight rod of 11 vertices, length 1 and mass 1 per length, with more keys and forces.
 */
static double stable(const char *keys, const char *forces, int *rod) {
  char text[1024];
  hb_scene_def def;
  hb_model *model = NULL;
  hb_error err = {.status = HB_OK};
  snprintf(text, sizeof text,
           "method: {time_step: 1e-3, duration: 1}\n"
           "rods:\n"
           "  - {name: soft, rest: {line: {to: [0, 0, -1], vertices: 3}}, bending: 0, twisting: 0, "
           "vertex_mass: 1}\n"
           "  - name: rod\n"
           "    rest: {line: {to: [1, 0, 0], vertices: 11}}\n"
           "    linear_density: 1\n"
           "%s%s",
           keys, forces);
  if (hb_scene_parse(text, strlen(text), "t", ".", NULL, 0, &def, &err)) fail_msg("%s", err.text);
  if (hb_model_create(&def, &model, &err)) fail_msg("%s", err.text);
  double step = hb_model_stable_step(model, rod);
  assert_true(step == hb_model_stable_step(model, NULL));
  hb_model_free(model);
  hb_scene_def_free(&def);
  return step;
}

/* Bending, h = l^2/2 sqrt(rho A/B), by the stiffer side of an anisotropic rod. */
static void bending_limits(void **state) {
  (void)state;
  int rod = -1;
  assert_near_rel(stable("    bending: 4\n    twisting: 1\n", "", &rod), 0.0025, 1e-9);
  assert_int_equal(rod, 1);
  assert_near_rel(stable("    bending: [1, 4]\n    twisting: 1\n", "", &rod), 0.0025, 1e-9);
}

/* Nothing to take an estimate from. */
static void nothing_limits(void **state) {
  (void)state;
  int rod = -1;
  assert_true(isinf(stable("    bending: 0\n    twisting: 0\n", "", &rod)));
  /* Gravity on rods that fall freely pulls nothing. */
  assert_true(isinf(stable("    bending: 0\n    twisting: 0\n", "gravity: [0, 0, -9.81]\n", &rod)));
}

/* Tension of a chain: h = l sqrt(rho A/T), T from weight, loads and speeds. */
static void tension_limits(void **state) {
  (void)state;
  static const char held[] = "    bending: 0\n    twisting: 0\n    start: {position: fixed}\n";
  int rod = -1;
  assert_near_rel(stable(held, "gravity: [0, 0, -4]\n", &rod), 0.1 / 2, 1e-9);
  assert_near_rel(stable(held, "forces: [{distributed: [0, 0, 4], rod: rod}]\n", &rod), 0.1 / 2, 1e-9);
  assert_near_rel(stable(held, "forces: [{point: [0, 0, 4], rod: rod, vertex: -1}]\n", &rod), 0.1 / 2, 1e-9);
  assert_near_rel(stable("    bending: 0\n    twisting: 0\n    velocity: [0, 0, 4*(u - 0.5)]\n", "", &rod),
                  0.1 / 2, 1e-9);
  assert_near_rel(
      stable("    bending: 0\n    twisting: 0\n    start: {position: [x, 2*t, fixed]}\n", "", &rod), 0.1 / 2,
      1e-9);
}

/* Viscosity h = 1/c, mass damping h = 1/c (Verlet, at extrapolated velocities), and viscosity with bending on
 * h^2 Omega^2 + 4 h c = 4. */
static void damping_limits(void **state) {
  (void)state;
  int rod = -1;
  double c = 16 * 0.01 / 1e-4, square = 16 * 4 / 1e-4;
  assert_near_rel(stable("    bending: 0\n    twisting: 0\n    damping: {mass: 50}\n", "", &rod), 0.02, 1e-9);
  double h = stable("    bending: 4\n    twisting: 1\n    damping: {bending: 0.01}\n", "", &rod);
  assert_near_rel(h * h * square + 4 * h * c, 4, 1e-9);
  assert_true(h < 1 / c);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(bending_limits),
      cmocka_unit_test(nothing_limits),
      cmocka_unit_test(tension_limits),
      cmocka_unit_test(damping_limits),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
