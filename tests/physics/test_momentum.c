/* Free rods keep their momenta (catalogue V50.1, V50.3, V47). */
#include "support/near.h"

#include "support/rng.h"
#include "support/scenes.h"

#define NV 9
#define STEPS 100000L

/* Curved at rest, anisotropic, twisted: every internal force there is. */
static void free_general(hb_scene_def *def) {
  double rest[3 * NV], xyz[3 * NV], v[3 * NV];
  rng r = rng_start(7);
  shape_bent(NV, 0.125, (double[]){0.4, 0.9, 0.5, 0.4}, rest);
  shape_bent(NV, 0.125, (double[]){-0.6, 0.5, 0.2, 0.6}, xyz);
  hb_rod_def *rod = scene_rod(def, NV, rest, 0.05, 0.04, 0.125);
  scene_form(rod, 0.06, 0.01, 0.02);
  scene_initial(rod, xyz);
  for (int k = 0; k < 3 * NV; k++) v[k] = rng_uniform(&r, -0.5, 0.5) + (k % 3 == 0 ? 1.0 : 0.3);
  scene_velocity(rod, v);
}

/* Isotropic and straight, with masses that differ. */
static void free_closed_form(hb_scene_def *def) {
  free_general(def);
  double line[3 * NV];
  rng r = rng_start(11);
  shape_line(NV, 1, 0, 0, line);
  memcpy(def->rods[0].rest, line, sizeof line);
  scene_form(&def->rods[0], 0.05, 0, 0.05);
  for (int i = 0; i < NV; i++) def->rods[0].mass[i] = rng_uniform(&r, 0.05, 0.3);
}

/* What became of the momenta over a run, relative to their size at the start. */
typedef struct drift {
  double linear, angular;
} drift;

/* Largest deviation, looked at a hundred times. */
static drift run_drift(scene_builder build, const char *integrator, double h, long steps) {
  trial t = {0};
  trial_build(&t, build, integrator, h);
  double p[3], l[3];
  drift d = {0, 0};
  memcpy(p, trial_measure(&t)->momentum, sizeof p);
  memcpy(l, t.frame->angular_momentum, sizeof l);
  double size_p = sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]),
         size_l = sqrt(l[0] * l[0] + l[1] * l[1] + l[2] * l[2]);
  for (int k = 0; k < 100; k++) {
    trial_run(&t, steps / 100);
    const hb_frame *f = trial_measure(&t);
    d.linear = fmax(d.linear, largest_difference(f->momentum, p, 3) / size_p);
    d.angular = fmax(d.angular, largest_difference(f->angular_momentum, l, 3) / size_l);
    assert_at_most(f->worst_length_error, 1e-10);
  }
  trial_end(&t);
  return d;
}

/* Second order: both momenta, over 1e5 steps. */
static void test_verlet(void **state) {
  (void)state;
  drift a = run_drift(free_general, "verlet", 1e-3, STEPS),
        b = run_drift(free_closed_form, "verlet", 1e-3, STEPS);
  say("verlet: linear %.1e %.1e, angular %.1e %.1e\n", a.linear, b.linear, a.angular, b.angular);
  assert_at_most(a.linear, 1e-12);
  assert_at_most(b.linear, 1e-12);
  assert_at_most(a.angular, 1e-10);
  assert_at_most(b.angular, 1e-10);
}

/* Symplectic Euler keeps the linear momentum. */
static void test_euler_linear(void **state) {
  (void)state;
  drift a = run_drift(free_general, "symplectic-euler", 1e-3, STEPS),
        b = run_drift(free_closed_form, "symplectic-euler", 1e-3, STEPS);
  say("symplectic-euler: linear %.1e %.1e, angular %.1e %.1e\n", a.linear, b.linear, a.angular, b.angular);
  assert_at_most(a.linear, 1e-12);
  assert_at_most(b.linear, 1e-12);
}

/* Its projection pulls along the edges as they are at the end of the step: the angular momentum drifts, over
 * the same time half as much with half the step. */
static void test_euler_angular(void **state) {
  (void)state;
  scene_builder builders[] = {free_general, free_closed_form};
  for (int k = 0; k < 2; k++) {
    double d[4];
    for (int n = 0; n < 4; n++)
      d[n] = run_drift(builders[k], "symplectic-euler", 2e-3 / (1 << n), 1000L << n).angular;
    say("angular drift %.2e %.2e %.2e %.2e\n", d[0], d[1], d[2], d[3]);
    assert_near(d[2] / d[3], 2, 0.1);
    assert_near(d[1] / d[2], 2, 0.2);
  }
}

/* Internal forces of any shape: no resultant, no moment. A clamped frame adds its torque about its tangent.
 */
static void test_internal_forces(void **state) {
  (void)state;
  for (int seed = 0; seed < 20; seed++) {
    trial t = {0};
    rng r = rng_start((uint64_t)seed + 100);
    double xyz[3 * NV], line[3 * NV];
    scene_begin(&t.def, "verlet", 1e-3);
    shape_line(NV, 1, 0, 0, line);
    shape_bent(NV, 0.125,
               (double[]){rng_uniform(&r, -1, 1), rng_uniform(&r, -1, 1), rng_uniform(&r, -1, 1), 0.4}, xyz);
    hb_rod_def *rod = scene_rod(&t.def, NV, seed % 2 ? line : xyz, 0.05, 0.4, 0.125);
    if (seed % 4 > 1) scene_form(rod, 0.3, -0.02, 0.05);
    shape_bent(NV, 0.125,
               (double[]){rng_uniform(&r, -1, 1), rng_uniform(&r, -1, 1), rng_uniform(&r, -1, 1), 0.1}, xyz);
    scene_initial(rod, xyz);
    scene_angle(rod, 0, "1");
    scene_angle(rod, -1, "4");
    trial_start(&t);
    const hb_frame *f = trial_measure(&t);
    const double *x = f->position, *force = hb_sim_state(t.sim)->force;
    double sum[3] = {0, 0, 0}, moment[3] = {0, 0, 0}, scale = 0;
    for (int i = 0; i < NV; i++)
      for (int c = 0; c < 3; c++) {
        int a = 3 * i + (c + 1) % 3, b = 3 * i + (c + 2) % 3;
        sum[c] += force[3 * i + c];
        moment[c] += x[a] * force[b] - x[b] * force[a];
        scale = fmax(scale, fabs(force[3 * i + c]));
      }
    for (int c = 0; c < 3; c++) {
      /* turning everything together costs nothing: the supports' torques give what the forces give back */
      moment[c] -= f->torque[0] * f->tangent[c] + f->torque[NV - 2] * f->tangent[3 * (NV - 2) + c];
      assert_near(sum[c], 0, 1e-13 * scale * NV);
      assert_near(moment[c], 0, 1e-13 * scale * NV);
    }
    trial_end(&t);
  }
}

/* V47: a straight free rod that spins, with the tensions of the discrete rod: an edge carries what keeps the
 * masses beyond it on their circles. Verlet keeps the spin. Fast projection slows it down: with the angle d
 * turned in a step the next one is atan(sin d/(2 - cos d)) = d - d^3, so after n steps the square of the spin
 * is down by 1 + 2 n d^2. */
static void test_spinning(void **state) {
  (void)state;
  static const double expected[5] = {0.01, 0.026, 0.038, 0.046, 0.05};
  enum { N = 11, TURNS = 5000 };
  for (int euler = 0; euler < 2; euler++) {
    trial t = {0};
    double xyz[3 * N], v[3 * N], h = 1e-4, d = 2 * h;
    const double axis[3] = {2.0 / 3, -1.0 / 3, 2.0 / 3}, along[3] = {1 / sqrt(5), 2 / sqrt(5), 0};
    scene_begin(&t.def, euler ? "symplectic-euler" : "verlet", h);
    for (int i = 0; i < N; i++)
      for (int c = 0; c < 3; c++) xyz[3 * i + c] = (0.1 * i - 0.5) * along[c];
    for (int i = 0; i < N; i++)
      for (int c = 0; c < 3; c++)
        v[3 * i + c] =
            2 * (axis[(c + 1) % 3] * xyz[3 * i + (c + 2) % 3] - axis[(c + 2) % 3] * xyz[3 * i + (c + 1) % 3]);
    hb_rod_def *rod = scene_rod(&t.def, N, xyz, 0.02, 0.02, 0.01);
    rod->mass[0] = rod->mass[N - 1] = 0.005;
    scene_velocity(rod, v);
    trial_start(&t);
    const hb_frame *f = trial_measure(&t);
    for (int j = 0; j < N - 1; j++) assert_near(f->tension[j], expected[j < 5 ? j : 9 - j], 1e-14);
    for (int c = 0; c < 3; c++) assert_near(f->angular_momentum[c], 0.017 * axis[c], 1e-15);
    trial_run(&t, TURNS);
    f = trial_measure(&t);
    double spin2 = euler ? 1 / (1 + 2 * TURNS * d * d) : 1;
    for (int j = 0; j < N - 1; j++) assert_near_rel(f->tension[j], spin2 * expected[j < 5 ? j : 9 - j], 1e-6);
    if (!euler)
      for (int c = 0; c < 3; c++) assert_near(f->angular_momentum[c], 0.017 * axis[c], 1e-14);
    trial_end(&t);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_verlet),        cmocka_unit_test(test_euler_linear),
      cmocka_unit_test(test_euler_angular), cmocka_unit_test(test_internal_forces),
      cmocka_unit_test(test_spinning),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
