/* Order of convergence of the integrators: positions, velocities and the energy balance of smooth runs at one
 * time, with the step halved again and again. The differences between neighbouring steps shrink by 2 for
 * order one, by 4 for two. */
#include "support/near.h"

#include "support/moving.h"

#define LEVELS 5

/* State of a run at the end, and the energy balance there. */
typedef struct finish {
  double x[3 * NV], v[3 * NV], balance, length_error;
} finish;

/* Runs a scene to the end. */
static finish run_to(scene_builder build, const char *integrator, double time, long steps) {
  trial t = {0};
  finish out;
  trial_build(&t, build, integrator, time / (double)steps);
  trial_run(&t, steps);
  const hb_frame *frame = trial_measure(&t);
  memcpy(out.x, frame->position, sizeof out.x);
  memcpy(out.v, frame->velocity, sizeof out.v);
  out.balance = frame->balance;
  out.length_error = frame->worst_length_error;
  trial_end(&t);
  return out;
}

/* Orders of positions, velocities and balance on the finest steps, against what is claimed. Returns the end
 * of the finest run with what is left of the leading error taken out of the positions. */
static finish check_order(const moving_scene *scene, const char *integrator, double claimed) {
  finish runs[LEVELS];
  for (int k = 0; k < LEVELS; k++) {
    runs[k] = run_to(scene->build, integrator, 1.0, scene->steps << k);
    assert_at_most(runs[k].length_error, 1e-10);
  }
  double dx[LEVELS], dv[LEVELS], db[LEVELS];
  for (int k = 1; k < LEVELS; k++) {
    dx[k] = largest_difference(runs[k - 1].x, runs[k].x, 3 * NV);
    dv[k] = largest_difference(runs[k - 1].v, runs[k].v, 3 * NV);
    db[k] = fabs(runs[k].balance);
  }
  double x = log2(dx[LEVELS - 2] / dx[LEVELS - 1]), v = log2(dv[LEVELS - 2] / dv[LEVELS - 1]),
         b = log2(db[LEVELS - 2] / db[LEVELS - 1]);
  say("%-14s %-16s x %.3f (%.1e) v %.3f (%.1e) balance %.3f (%.1e)\n", scene->name, integrator, x,
      dx[LEVELS - 1], v, dv[LEVELS - 1], b, db[LEVELS - 1]);
  assert_near(x, claimed, 0.1);
  assert_near(v, claimed, 0.1);
  assert_near(b, claimed, 0.15);
  finish end = runs[LEVELS - 1];
  for (int k = 0; k < 3 * NV; k++) end.x[k] += (end.x[k] - runs[LEVELS - 2].x[k]) / (exp2(claimed) - 1);
  return end;
}

/* Both schemes on every scene; they must come to the same end. */
static void test_orders(void **state) {
  (void)state;
  for (int k = 0; k < MOVING_COUNT; k++) {
    const moving_scene *scene = &moving_scenes[k];
    finish euler = check_order(scene, "symplectic-euler", 1), verlet = check_order(scene, "verlet", 2);
    assert_near_array(euler.x, verlet.x, 3 * NV, 2e-6);
    say("  limits agree to %.1e\n", largest_difference(euler.x, verlet.x, 3 * NV));
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_orders)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
