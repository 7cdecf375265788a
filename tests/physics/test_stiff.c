/* Implicit steps on stiff rods: the two beams on which rod codes are compared, and the scenes of scenes/stiff
 * that an explicit scheme would need some hundred times as many steps for, against numbers from elsewhere:
 * positions that other programs report, formulas of beams and springs, an elastica integrated by Runge and
 * Kutta. */
#include "support/near.h"

#include "hebra/scene.h"
#include "math/vec3.h"
#include "support/scenes.h"

enum { SAMPLES = 20 };

/* A scene of scenes/stiff, with overrides (NULL-terminated). */
static void open_scene(trial *t, const char *name, const char *const *overrides) {
  char path[500];
  hb_error err = {HB_OK, ""};
  int count = 0;
  while (overrides && overrides[count]) count++;
  snprintf(path, sizeof path, "%s/scenes/stiff/%s.yaml", HEBRA_SOURCE_DIR, name);
  if (hb_scene_read(path, overrides, count, &t->def, &err)) fail_msg("%s", err.text);
  trial_start(t);
}

/* To its end. */
static void run_scene(trial *t, const char *name, const char *const *overrides) {
  open_scene(t, name, overrides);
  trial_run(t, hb_sim_total_steps(t->sim));
  say("%s: %g pieces, %g steps of Newton's method, %g matrices\n", name,
      hb_sim_const_state(t->sim)->scalar[HB_S_PIECES], hb_sim_const_state(t->sim)->scalar[HB_S_NEWTON],
      hb_sim_const_state(t->sim)->scalar[HB_S_FACTORISATIONS]);
}

/* Displacement of a vertex (negative: from the end) since the start. */
static hb_v3 displacement(const trial *t, int vertex) {
  int k = 3 * (vertex < 0 ? vertex + t->model->nv : vertex);
  return hb_v3_sub(hb_v3_load(hb_sim_const_state(t->sim)->x + k), hb_v3_load(t->model->initial + k));
}

/* Tips of a beam at every tenth of a second. */
static void follow_tip(const char *name, const char *integrator, double step, int samples, hb_v3 *tip) {
  trial t = {0};
  char a[80], b[80];
  snprintf(a, sizeof a, "method.integrator=%s", integrator);
  snprintf(b, sizeof b, "method.time_step=%.17g", step);
  const char *overrides[] = {a, b, NULL};
  open_scene(&t, name, overrides);
  for (int k = 0; k < samples; k++) {
    trial_run(&t, lround(0.1 / step));
    tip[k] = hb_v3_load(hb_sim_const_state(t.sim)->x + 3 * (t.model->nv - 1));
  }
  trial_end(&t);
}

/* Root of the mean square distance of two tips, over the length 1. */
static double apart(const hb_v3 *a, const hb_v3 *b, int samples) {
  double sum = 0;
  for (int k = 0; k < samples; k++) sum += hb_v3_dot(hb_v3_sub(a[k], b[k]), hb_v3_sub(a[k], b[k]));
  return sqrt(sum / samples);
}

/* Beam B: where four other codes have its tip (they agree to 0.3 % among themselves); errors at coarse steps
 * fall with their square. */
static void test_beam_b(void **state) {
  (void)state;
  hb_v3 fine[SAMPLES], tip[3][SAMPLES];
  static const double steps[3] = {0.02, 0.01, 0.005};
  double error[3];
  follow_tip("beam-B", "implicit", 1.25e-3, SAMPLES, fine);
  assert_near(fine[4].x, 0.1550, 0.003);
  assert_near(fine[4].z, -0.9057, 0.003);
  assert_near(fine[19].x, -0.0935, 0.003);
  assert_near(fine[19].z, -0.8722, 0.003);
  for (int k = 0; k < 3; k++) {
    follow_tip("beam-B", "implicit", steps[k], SAMPLES, tip[k]);
    error[k] = apart(tip[k], fine, SAMPLES);
    say("beam B, step %g: %.3f %%\n", steps[k], 100 * error[k]);
  }
  assert_at_most(error[0], 0.01);
  assert_at_most(error[1], 0.004);
  assert_near(log2(error[1] / error[2]), 2, 0.25);
}

/* Beam A: explicit and implicit schemes meet. */
static void test_beam_a(void **state) {
  (void)state;
  hb_v3 fine[10], tip[10];
  follow_tip("beam-A", "verlet", 4e-4, 10, fine);
  follow_tip("beam-A", "implicit", 0.01, 10, tip);
  say("beam A, step 0.01: %.3f %%\n", 100 * apart(tip, fine, 10));
  assert_at_most(apart(tip, fine, 10), 0.01);
}

/* Steps of 50 ms: no energy comes from nowhere, and the beam goes where it should. */
static void test_long_steps(void **state) {
  (void)state;
  static const char *const names[2] = {"beam-A", "beam-B"};
  const char *overrides[] = {"method.integrator=implicit", "method.time_step=0.05", "method.duration=4",
                             NULL};
  for (int k = 0; k < 2; k++) {
    trial t = {0};
    open_scene(&t, names[k], overrides);
    for (int step = 0; step < 80; step++) {
      trial_run(&t, 1);
      const hb_frame *f = trial_measure(&t);
      assert_at_most(f->balance, 1e-3 * f->work_loads + 1e-6);
      assert_at_most(f->worst_length_error, 1e-10);
    }
    double lost = t.frame->balance / t.frame->work_loads;
    say("%s, steps of 50 ms: %.2f of the work is lost in 4 s, %g pieces\n", names[k], -lost,
        hb_sim_const_state(t.sim)->scalar[HB_S_PIECES]);
    trial_end(&t);
  }
}

/* Depth of the V: half of it is an elastica from a pin to a level tangent, integrated by Runge and Kutta's
 * method. */
static void test_suture(void **state) {
  (void)state;
  trial t = {0};
  run_scene(&t, "suture", NULL);
  assert_near_rel(hb_sim_const_state(t.sim)->x[3 * 50 + 2], -0.0153370994, 2e-3);
  assert_at_most(trial_measure(&t)->kinetic, 1e-15);
  trial_end(&t);
}

/* P L^3/(3 E I) = 1 mm. */
static void test_stiff_beam(void **state) {
  (void)state;
  trial t = {0};
  run_scene(&t, "fifty-gigapascal", NULL);
  assert_near_rel(displacement(&t, -1).z, -1e-3, 5e-4);
  trial_end(&t);
}

/* w L^4/(8 E I). */
static void test_three_millimetres(void **state) {
  (void)state;
  trial t = {0};
  run_scene(&t, "three-millimetres", NULL);
  assert_near_rel(displacement(&t, -1).z, -3.97305e-5, 5e-4);
  trial_end(&t);
}

/* Castigliano's theorem for the helix, clamped at the top: 2.0386 mm down and 0.2695 mm aside; second order
 * in the edges, so extrapolated from two meshes. */
static void test_helix(void **state) {
  (void)state;
  const char *coarse[] = {"rods.spring.rest.helix.vertices=121", "method.time_step=0.01", NULL};
  hb_v3 at[2];
  for (int k = 0; k < 2; k++) {
    trial t = {0};
    run_scene(&t, "hanging-helix", k ? coarse + 1 : coarse);
    at[k] = displacement(&t, -1);
    trial_end(&t);
  }
  say("helix: %.4f, %.4f mm\n", 1e3 * at[0].z, 1e3 * at[1].z);
  hb_v3 limit = hb_v3_axpy(hb_v3_scale(4.0 / 3, at[1]), -1.0 / 3, at[0]);
  assert_near_rel(limit.z, -2.03860e-3, 4e-3);
  assert_near_rel(limit.y, 2.6953e-4, 3e-2);
  assert_at_most(fabs(at[1].z + 2.03860e-3), 0.3 * fabs(at[0].z + 2.03860e-3));
}

/* Twenty turns: the moment G J 40 pi/(L - l) of a straight cord (clamps sit at the middle of their edges);
 * below Greenhill's tension M^2/(4 E I) = 0.88 it leaves the axis, above it does not. */
static void test_twenty_turns(void **state) {
  (void)state;
  const char *slack[] = {"parameters.tension=0.7", "method.duration=2.2", NULL};
  for (int k = 0; k < 2; k++) {
    trial t = {0};
    run_scene(&t, "twenty-turns", k ? slack : NULL);
    const double *x = hb_sim_const_state(t.sim)->x;
    double away = 0;
    for (int i = 0; i < t.model->nv; i++) away = fmax(away, hypot(x[3 * i + 1], x[3 * i + 2]));
    if (k == 0) assert_near_rel(trial_measure(&t)->torque[t.model->nv - 2], 0.02126783440, 1e-5);
    say("tension %s: %.2g away from the axis\n", k ? "0.7" : "1", away);
    if (k == 0)
      assert_at_most(away, 1e-5);
    else
      assert_true(away > 2e-3);
    trial_end(&t);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_beam_b),     cmocka_unit_test(test_beam_a),
      cmocka_unit_test(test_long_steps), cmocka_unit_test(test_suture),
      cmocka_unit_test(test_stiff_beam), cmocka_unit_test(test_three_millimetres),
      cmocka_unit_test(test_helix),      cmocka_unit_test(test_twenty_turns),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
