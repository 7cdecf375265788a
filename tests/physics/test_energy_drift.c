/* Energy of the second-order scheme over a million steps: it swings, the swing shrinks with the square of the
 * step, and nothing grows (catalogue V50.2). Symplectic Euler only loses. */
#include "support/near.h"

#include "support/scenes.h"

#define NV 5
#define STEPS (1000000L / SHORTER)
#define SAMPLES 10000

/* Free, curved at rest, anisotropic, moving; near enough to its rest shape that its quasi-static frames never
 * snap from one equilibrium to another, which would release energy (the frames have no inertia to keep it).
 */
static void free_general(hb_scene_def *def) {
  double rest[3 * NV], xyz[3 * NV], v[3 * NV];
  shape_bent(NV, 0.25, (double[]){0.4, 0.9, 0.5, 0.4}, rest);
  shape_bent(NV, 0.25, (double[]){0.6, 0.8, 0.4, 0.5}, xyz);
  hb_rod_def *rod = scene_rod(def, NV, rest, 0.05, 0.04, 0.25);
  scene_form(rod, 0.06, 0.01, 0.02);
  scene_initial(rod, xyz);
  for (int i = 0; i < NV; i++) {
    v[3 * i] = 0.02;
    v[3 * i + 1] = 0.1 * i;
    v[3 * i + 2] = 0.01 * (i - 2) * (i - 2);
  }
  scene_velocity(rod, v);
}

/* Clamped at one end, heavy. */
static void cantilever(hb_scene_def *def) {
  double line[3 * NV];
  shape_line(NV, 1, 0, 0, line);
  scene_clamp_start(scene_rod(def, NV, line, 0.05, 0.05, 0.25));
  scene_force(def, HB_FORCE_GRAVITY, "0", "0.03", "-0.5");
}

/* Clamped at both ends with a twist held in space. */
static void twisted(hb_scene_def *def) {
  double line[3 * (NV + 2)], xyz[3 * (NV + 2)];
  shape_line(NV + 2, 1.5, 0, 0, line);
  shape_bent(NV + 2, 0.25, (double[]){0.9, -0.7, 0.3, 0}, xyz);
  hb_rod_def *rod = scene_rod(def, NV + 2, line, 0.05, 0.05, 0.25);
  scene_initial(rod, xyz);
  scene_clamp_start(rod);
  scene_hold(rod, -1);
  scene_hold(rod, -2);
  scene_angle(rod, -1, "5");
  scene_force(def, HB_FORCE_GRAVITY, "0", "0.03", "-0.1");
}

/* The energy of a run: its swing (largest minus smallest), that of its first and of its second half, and the
 * means there. */
typedef struct record {
  double swing, first_swing, last_swing, first_mean, last_mean, slope, kinetic;
} record;

/* Of the rod and its weight. */
static double total_energy(trial *t) {
  const hb_frame *f = trial_measure(t);
  return f->kinetic + f->bending + f->twisting + f->gravity;
}

/* A run, looked at SAMPLES times. */
static record run_energy(scene_builder build, const char *integrator, double h, long steps) {
  trial t = {0};
  record r = {0};
  double low[3] = {HUGE_VAL, HUGE_VAL, HUGE_VAL}, high[3] = {-HUGE_VAL, -HUGE_VAL, -HUGE_VAL}, sum = 0,
         sum_n = 0;
  trial_build(&t, build, integrator, h);
  double start = total_energy(&t);
  for (int n = 0; n < SAMPLES; n++) {
    trial_run(&t, steps / SAMPLES);
    double e = total_energy(&t) - start, place = (n + 0.5) / SAMPLES - 0.5;
    int part = n < SAMPLES / 2 ? 1 : 2;
    low[0] = fmin(low[0], e);
    high[0] = fmax(high[0], e);
    low[part] = fmin(low[part], e);
    high[part] = fmax(high[part], e);
    if (part == 1) r.first_mean += e / (SAMPLES / 2);
    if (part == 2) r.last_mean += e / (SAMPLES / 2);
    sum += e * place;
    sum_n += place * place;
    r.kinetic = fmax(r.kinetic, t.frame->kinetic);
  }
  r.slope = sum / sum_n;
  r.swing = high[0] - low[0];
  r.first_swing = high[1] - low[1];
  r.last_swing = high[2] - low[2];
  assert_at_most(t.frame->worst_length_error, 1e-10);
  trial_end(&t);
  return r;
}

/* Bounded, without trend, of second order. */
static void check_verlet(scene_builder build, const char *name, double h) {
  record r = run_energy(build, "verlet", h, STEPS), half = run_energy(build, "verlet", h / 2, 100000);
  record twice = run_energy(build, "verlet", h, 50000);
  say("%-13s kinetic %.2e swing %.2e (first %.2e last %.2e) means %.2e %.2e trend over the run %.2e; half "
      "step %.2e\n",
      name, r.kinetic, r.swing, r.first_swing, r.last_swing, r.first_mean, r.last_mean, r.slope, half.swing);
  assert_at_most(r.swing, 2e-3 * r.kinetic);         /* bounded */
  assert_at_most(r.last_swing, 1.5 * r.first_swing); /* nothing grows */
  assert_at_most(fabs(r.slope), 0.1 * r.swing);      /* no trend */
  assert_near(twice.swing / half.swing, 4, 1.5);     /* of second order */
}

/* Nothing holds it. */
static void test_free_rod(void **state) {
  (void)state;
  check_verlet(free_general, "free general", 5e-3);
}

/* One end held. */
static void test_cantilever(void **state) {
  (void)state;
  check_verlet(cantilever, "cantilever", 5e-3);
}

/* Both ends held, twisted. */
static void test_twisted(void **state) {
  (void)state;
  check_verlet(twisted, "twisted", 5e-3);
}

/* Fast projection: a loss of first order in the step, nothing gained. */
static void test_euler_loses(void **state) {
  (void)state;
  double lost[3];
  for (int k = 0; k < 3; k++) {
    trial t = {0};
    trial_build(&t, cantilever, "symplectic-euler", 1e-3 / (1 << k));
    double start = total_energy(&t);
    trial_run(&t, 20000L << k);
    lost[k] = start - total_energy(&t);
    trial_end(&t);
  }
  say("symplectic Euler loses %.3e %.3e %.3e\n", lost[0], lost[1], lost[2]);
  assert_true(lost[2] > 0);
  assert_near(lost[1] / lost[2], 2, 0.2);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_free_rod),
      cmocka_unit_test(test_cantilever),
      cmocka_unit_test(test_twisted),
      cmocka_unit_test(test_euler_loses),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
