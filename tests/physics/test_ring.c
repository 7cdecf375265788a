/* Rings against what is known of them: energies, tension of a spinning ring, and the loads at which they leave
 * their plane (catalogue: V13, V14, V15, V33). */
#include "hebra/scene.h"
#include "hebra/sim.h"
#include "hebra/statics.h"
#include "math/rotation.h"
#include "rod/writhe.h"
#include "support/near.h"
#include "support/scenes.h"

#include <string.h>

/* A ring in the plane z = 0; `setting` changes its numbers. */
static const char ring_scene[] =
    "parameters: {n: 20, B: 1, G: 0.8, perimeter: 2*pi, twist: 0, natural: 0, turning: 0}\n"
    "method: {time_step: 1e-3, duration: 1}\n"
    "rods:\n"
    "  - closed: {twist: twist}\n"
    "    initial: {ring: {radius: perimeter/(2*n*sin(pi/n)), vertices: n + 1}}\n"
    "    natural_curvature: [0, -natural]\n"
    "    director: [0, 0, 1]\n"
    "    bending: B\n"
    "    twisting: G*B\n"
    "    linear_density: 0.1\n"
    "    velocity: [-turning*y, turning*x, 0]\n";

/* A simulation of it. */
static void begin(trial *t, const char *const *settings, int count) {
  hb_error err;
  memset(t, 0, sizeof *t);
  if (hb_scene_parse(ring_scene, strlen(ring_scene), "ring", ".", settings, count, &t->def, &err))
    fail_msg("%s", err.text);
  trial_start(t);
}

/* Unstable modes of the ring with n edges, ratio G and one more number. */
static int unstable(int n, double G, const char *name, double value) {
  trial t;
  char text[3][64];
  const char *settings[3] = {text[0], text[1], text[2]};
  hb_error err;
  hb_equilibrium result;
  hb_equilibrium_options options = hb_equilibrium_defaults(0);
  options.any = true;
  snprintf(text[0], sizeof text[0], "parameters.n=%d", n);
  snprintf(text[1], sizeof text[1], "parameters.G=%.17g", G);
  snprintf(text[2], sizeof text[2], "parameters.%s=%.17g", name, value);
  begin(&t, settings, 3);
  if (hb_sim_find_equilibrium(t.sim, &options, &result, &err)) fail_msg("%s", err.text);
  int count = result.unstable;
  hb_equilibrium_free(&result);
  trial_end(&t);
  return count;
}

/* Where the ring ceases to be stable, between a value where it is and one where it is not. */
static double threshold(int n, double G, const char *name, double stable, double beyond) {
  assert_int_equal(unstable(n, G, name, stable), 0);
  assert_true(unstable(n, G, name, beyond) > 0);
  for (int k = 0; k < 27; k++) {
    double middle = 0.5 * (stable + beyond);
    if (unstable(n, G, name, middle) > 0)
      beyond = middle;
    else
      stable = middle;
  }
  return 0.5 * (stable + beyond);
}

/* V13: Michell's ring. The thresholds of regular polygons to their last digit, of second order in the edge. */
static void test_michell(void **state) {
  (void)state;
  static const struct { int n; double twist; } exact[] = {{20, 14.7092143}, {30, 14.0841527}, {50, 13.7746168},
                                                         {100, 13.6460775}};
  double smooth = 2 * HB_PI * sqrt(3) / 0.8;
  for (size_t k = 0; k < sizeof exact / sizeof exact[0]; k++) {
    double found = threshold(exact[k].n, 0.8, "twist", 13, 15);
    say("V13: N %3d: %.8f, expected %.7f, smooth + %.4f %%\n", exact[k].n, found, exact[k].twist,
        100 * (found / smooth - 1));
    assert_near_rel(found, exact[k].twist, 1e-6);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_michell)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
