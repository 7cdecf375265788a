/* The formulas of the thesis, corrected, in dense arrays against the library's force in O(n). */
#include "support/dense.h"
#include "support/near.h"
#include "support/rods.h"

#define TRIALS 14
#define ROOM 64

/* A random rod, solved, and its energy bound at the library's angles. */
typedef struct trial {
  rod_case c;
  rod_energy e;
  double theta[ROOM];
  int numbers;
} trial;

/* Draws, solves and binds. */
static void begin(trial *t, rng *r, rod_family family, rod_ends ends) {
  rod_case_random(&t->c, r, family, ends, 10);
  rod_case_compile(&t->c);
  rod_case_start(&t->c, NULL);
  rod_case_angles(&t->c, t->theta);
  rod_energy_create(&t->e, &t->c.def.rods[0]);
  rod_energy_bind(&t->e, t->c.state->x, t->c.state->anchor_m1, t->theta);
  t->numbers = 3 * t->c.rod->nv;
}

/* Frees a trial. */
static void finish(trial *t) {
  rod_energy_free(&t->e);
  rod_case_free(&t->c);
}

/* With current lengths the dense formulas are the exact gradient: equal as they stand. */
static void test_current_lengths(void **state) {
  (void)state;
  rng r = rng_start(401);
  double f[ROOM];
  for (int family = 0; family < ROD_FAMILY_COUNT; family++)
    for (int ends = 0; ends < ROD_ENDS_COUNT; ends++)
      for (int k = 0; k < TRIALS; k++) {
        trial t;
        begin(&t, &r, (rod_family)family, (rod_ends)ends);
        dense_force(&t.e, t.c.state->x, DENSE_CURRENT, f);
        assert_at_most(rod_difference(f, rod_case_force(&t.c), t.numbers), 1e-11 * rod_largest(f, t.numbers));
        finish(&t);
      }
}

/* With rest lengths, as printed, they differ from it by a part along the edges only. */
static void test_rest_lengths(void **state) {
  (void)state;
  rng r = rng_start(402);
  double f[ROOM], own[ROOM], furthest = 0;
  for (int family = 0; family < ROD_FAMILY_COUNT; family++)
    for (int ends = 0; ends < ROD_ENDS_COUNT; ends++)
      for (int k = 0; k < TRIALS; k++) {
        trial t;
        begin(&t, &r, (rod_family)family, (rod_ends)ends);
        dense_force(&t.e, t.c.state->x, DENSE_REST, f);
        for (int i = 0; i < t.numbers; i++) own[i] = rod_case_force(&t.c)[i];
        double scale = rod_largest(own, t.numbers);
        furthest = fmax(furthest, rod_difference(f, own, t.numbers) / scale);
        dense_project(t.c.rod->nv, t.c.state->x, f);
        dense_project(t.c.rod->nv, t.c.state->x, own);
        assert_at_most(rod_difference(f, own, t.numbers), 1e-11 * scale);
        finish(&t);
      }
  assert_true(furthest > 1e-2); /* otherwise the projection above would have nothing to do */
}

/* The special formula for isotropic rods, both ways. */
static void test_isotropic(void **state) {
  (void)state;
  rng r = rng_start(403);
  double f[ROOM], own[ROOM];
  for (int ends = 0; ends < ROD_CLAMPED_INNER; ends++)
    for (int k = 0; k < 2 * TRIALS; k++) {
      trial t;
      begin(&t, &r, ROD_ISOTROPIC, (rod_ends)ends);
      for (int i = 0; i < t.numbers; i++) own[i] = rod_case_force(&t.c)[i];
      double scale = rod_largest(own, t.numbers);
      dense_force_isotropic(&t.e, t.c.state->x, DENSE_CURRENT, f);
      assert_at_most(rod_difference(f, own, t.numbers), 1e-11 * scale);
      dense_force_isotropic(&t.e, t.c.state->x, DENSE_REST, f);
      dense_project(t.c.rod->nv, t.c.state->x, f);
      dense_project(t.c.rod->nv, t.c.state->x, own);
      assert_at_most(rod_difference(f, own, t.numbers), 1e-11 * scale);
      finish(&t);
    }
}

/* The thesis's dE/dtheta: 0 on free edges, the support's torque on held ones. */
static void test_theta_gradient(void **state) {
  (void)state;
  rng r = rng_start(404);
  double gradient[ROOM];
  for (int family = 0; family < ROD_FAMILY_COUNT; family++)
    for (int ends = 0; ends < ROD_ENDS_COUNT; ends++)
      for (int k = 0; k < TRIALS; k++) {
        trial t;
        begin(&t, &r, (rod_family)family, (rod_ends)ends);
        dense_theta_gradient(&t.e, t.c.state->x, DENSE_REST, gradient);
        (void)rod_energy_moved(&t.e, t.c.state->x, -1, 0);
        double again[ROOM], scale = rod_energy_gradient(&t.e, t.theta, again);
        for (int j = 0; j + 1 < t.c.rod->nv; j++) {
          int frame = t.c.model->frame_of[j];
          double torque = frame >= 0 ? t.c.state->frame_torque[frame] : 0;
          assert_near(gradient[j], torque, 1e-12 * scale);
        }
        finish(&t);
      }
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_current_lengths),
                                     cmocka_unit_test(test_rest_lengths), cmocka_unit_test(test_isotropic),
                                     cmocka_unit_test(test_theta_gradient)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
