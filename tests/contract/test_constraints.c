/* What every constraint in the list must satisfy: its rows are the derivatives of its values, it is met at
 * rest, and it does not care where the rod lies. */
#include "hebra/plug.h"
#include "support/near.h"
#include "support/rods.h"

#include <string.h>

#define TRIALS 30
#define ROOM 128

/* A random rod at its initial shape, shaken so that the constraint is not met; whichever rod of two in the
 * numbering. */
typedef struct trial {
  rod_case c;
  double x[ROOM], values[ROOM], rows[6 * ROOM];
  int count;
} trial;

/* A random rod without supports, its vertices moved by up to shake. */
static void begin(trial *t, rng *r, const hb_constraint *constraint, double shake) {
  rod_case_random(&t->c, r, (rod_family)rng_int(r, 0, ROD_FAMILY_COUNT - 1), ROD_FREE_FREE, 0);
  rod_case_compile(&t->c);
  for (int k = 0; k < 3 * t->c.rod->nv; k++) t->x[k] = t->c.model->initial[k] + rng_uniform(r, -shake, shake);
  t->count = constraint->count(t->c.model, t->c.rod);
  assert_in_range(t->count, 0, t->c.rod->nv);
  constraint->evaluate(t->c.model, t->c.rod, t->x, t->values, t->rows);
}

/* Every constraint under one check. */
typedef void (*check)(const hb_constraint *constraint, trial *t, rng *r);
/* Every constraint in the list on as many random rods. */
static void sweep(uint64_t seed, double shake, check one) {
  for (int k = 0; hb_constraints[k]; k++) {
    rng r = rng_start(seed);
    for (int n = 0; n < TRIALS; n++) {
      trial t;
      begin(&t, &r, hb_constraints[k], shake);
      one(hb_constraints[k], &t, &r);
      rod_case_free(&t.c);
    }
  }
}

/* Symmetric differences of the values, two steps extrapolated: exact for polynomials up to degree 4. */
static void rows_are_derivatives(const hb_constraint *constraint, trial *t, rng *r) {
  (void)r;
  double far[2][ROOM], near[2][ROOM], h = 0.25 * t->c.model->rest_length[0];
  double scale = rod_largest(t->rows, 6 * t->count);
  for (int k = 0; k < 3 * t->c.rod->nv; k++) {
    double keep = t->x[k];
    for (int side = 0; side < 2; side++) {
      t->x[k] = keep + (side ? h : -h);
      constraint->evaluate(t->c.model, t->c.rod, t->x, far[side], NULL);
      t->x[k] = keep + (side ? 0.5 * h : -0.5 * h);
      constraint->evaluate(t->c.model, t->c.rod, t->x, near[side], NULL);
    }
    t->x[k] = keep;
    for (int row = 0; row < t->count; row++) {
      double whole = (far[1][row] - far[0][row]) / (2 * h), half = (near[1][row] - near[0][row]) / h;
      int place = k - 3 * row; /* rows know vertices row and row + 1 only */
      double expected = place >= 0 && place < 6 ? t->rows[6 * row + place] : 0;
      assert_near((4 * half - whole) / 3, expected, 1e-12 * scale);
    }
  }
}

/* Rows against differences. */
static void test_rows(void **state) {
  (void)state;
  sweep(501, 0.03, rows_are_derivatives);
}

/* Asked without rows it gives the same values. */
static void values_alone(const hb_constraint *constraint, trial *t, rng *r) {
  (void)r;
  double values[ROOM];
  constraint->evaluate(t->c.model, t->c.rod, t->x, values, NULL);
  assert_memory_equal(values, t->values, (size_t)t->count * sizeof(double));
}

/* Values without rows. */
static void test_values(void **state) {
  (void)state;
  sweep(502, 0.03, values_alone);
}

/* Met where the edges have their rest lengths, violated where they have not. */
static void met_at_rest(const hb_constraint *constraint, trial *t, rng *r) {
  (void)r;
  double h = t->c.model->rest_length[0];
  for (int row = 0; row < t->count; row++) assert_near(t->values[row], 0, 1e-14 * (1 + h));
  for (int k = 0; k < 3 * t->c.rod->nv; k++) t->x[k] *= 1.1;
  constraint->evaluate(t->c.model, t->c.rod, t->x, t->values, NULL);
  for (int row = 0; row < t->count; row++) assert_true(fabs(t->values[row]) > 1e-3 * h);
}

/* At rest. */
static void test_rest(void **state) {
  (void)state;
  sweep(503, 0, met_at_rest);
}

/* Turned and shifted as a whole: same values, rows turned along; rows of one constraint add up to nothing. */
static void rigid_motion(const hb_constraint *constraint, trial *t, rng *r) {
  double rotation[9], shift[3] = {1, -2, 0.5}, moved[ROOM], values[ROOM], rows[6 * ROOM], turned[6 * ROOM];
  rod_random_rotation(r, rotation);
  rod_move(rotation, shift, t->x, t->c.rod->nv, moved);
  constraint->evaluate(t->c.model, t->c.rod, moved, values, rows);
  rod_move(rotation, NULL, t->rows, 2 * t->count, turned);
  assert_near_array(values, t->values, t->count, 1e-13);
  assert_near_array(rows, turned, 6 * t->count, 1e-12 * rod_largest(t->rows, 6 * t->count));
  for (int row = 0; row < t->count; row++)
    for (int c = 0; c < 3; c++) assert_near(t->rows[6 * row + c] + t->rows[6 * row + 3 + c], 0, 0);
}

/* Turned and shifted. */
static void test_rigid_motion(void **state) {
  (void)state;
  sweep(504, 0.03, rigid_motion);
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_rows), cmocka_unit_test(test_values),
                                     cmocka_unit_test(test_rest), cmocka_unit_test(test_rigid_motion)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
