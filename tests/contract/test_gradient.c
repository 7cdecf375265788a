/* The elastic force is minus the gradient of the energy with the twist solved: 208 random rods of every kind,
 * with every kind of ends and end twists of up to 10 turns, by complex steps and by finite differences. */
#include "support/energy.h"
#include "support/near.h"
#include "support/rods.h"

#define TRIALS 13 /* times 16 kinds: 208 rods */
#define ROOM 64
#define TURNS 10.0

typedef struct trial {
  rod_case c;
  rod_energy e;
  double theta[ROOM];
  int numbers;
} trial;

/* A random rod at its initial shape, or at one whose edges are up to 15 % longer or shorter than at rest;
 * of half of those the edges are springs. */
static void begin(trial *t, rng *r, rod_family family, rod_ends ends, bool stretched) {
  double x[ROOM];
  rod_case_random(&t->c, r, family, ends, TURNS);
  if (stretched && rng_int(r, 0, 1)) rod_make_extensible(&t->c, r);
  rod_case_compile(&t->c);
  t->numbers = 3 * t->c.rod->nv;
  for (int k = 0; k < t->numbers; k++) x[k] = t->c.model->initial[k];
  if (stretched) {
    double lengths[ROOM];
    for (int j = 0; j + 1 < t->c.rod->nv; j++)
      lengths[j] = t->c.model->rest_length[j] * rng_uniform(r, 0.85, 1.15);
    rod_random_shape(r, t->c.rod->nv, lengths, 0.5, x);
  }
  rod_case_start(&t->c, x);
  rod_case_angles(&t->c, t->theta);
  rod_energy_create(&t->e, &t->c.def.rods[0]);
  rod_energy_bind(&t->e, t->c.state->x, t->c.state->anchor_m1, t->theta);
}

/* Frees a trial. */
static void finish(trial *t) {
  rod_energy_free(&t->e);
  rod_case_free(&t->c);
}

/* By the envelope theorem the derivative at fixed free angles, with the held ones following their frames, is
 * the whole derivative: complex steps give it to round-off. */
static void test_complex_step(void **state) {
  (void)state;
  rng r = rng_start(101);
  for (int family = 0; family < ROD_FAMILY_COUNT; family++)
    for (int ends = 0; ends < ROD_ENDS_COUNT; ends++)
      for (int k = 0; k < TRIALS; k++) {
        trial t;
        double force[ROOM];
        begin(&t, &r, (rod_family)family, (rod_ends)ends, k % 3 == 0);
        for (int i = 0; i < t.numbers; i++)
          force[i] = -cimag(rod_energy_moved(&t.e, t.c.state->x, i, rod_complex(0, 1e-30))) / 1e-30;
        double scale = rod_largest(force, t.numbers);
        assert_true(scale > 0);
        assert_at_most(rod_difference(force, rod_case_force(&t.c), t.numbers), 1e-12 * scale);
        finish(&t);
      }
}

/* Finite differences, the twist solved again at every displaced shape. */
static void test_finite_differences(void **state) {
  (void)state;
  rng r = rng_start(102);
  for (int family = 0; family < ROD_FAMILY_COUNT; family++)
    for (int ends = 0; ends < ROD_ENDS_COUNT; ends++)
      for (int k = 0; k < TRIALS; k++) {
        trial t;
        double force[ROOM];
        begin(&t, &r, (rod_family)family, (rod_ends)ends, k % 3 == 0);
        double step = 0.02 * t.c.model->rest_length[0];
        for (int i = 0; i < t.numbers; i++) force[i] = -rod_energy_slope(&t.e, t.c.state->x, i, step);
        assert_at_most(rod_difference(force, rod_case_force(&t.c), t.numbers),
                       1e-8 * rod_largest(force, t.numbers));
        finish(&t);
      }
}

/* The free edges' angles make the energy stationary, to round-off; the independent energy says so. */
static void test_stationary(void **state) {
  (void)state;
  rng r = rng_start(103);
  for (int family = 0; family < ROD_FAMILY_COUNT; family++)
    for (int ends = 0; ends < ROD_ENDS_COUNT; ends++)
      for (int k = 0; k < TRIALS; k++) {
        trial t;
        double gradient[ROOM];
        begin(&t, &r, (rod_family)family, (rod_ends)ends, false);
        (void)rod_energy_moved(&t.e, t.c.state->x, -1, 0);
        double scale = rod_energy_gradient(&t.e, t.theta, gradient);
        for (int j = 0; j + 1 < t.c.rod->nv; j++)
          if (!t.e.held[j]) assert_near(gradient[j], 0, 5e-14 * scale);
        finish(&t);
      }
}

/* Held frames are where the definition puts them: angles with their windings, directors in space. */
static void test_held(void **state) {
  (void)state;
  rng r = rng_start(104);
  double vars[HB_VAR_COUNT] = {0};
  for (int ends = ROD_CLAMPED_FREE; ends < ROD_ENDS_COUNT; ends++)
    for (int k = 0; k < 4 * TRIALS; k++) {
      trial t;
      double m1[ROOM];
      begin(&t, &r, (rod_family)(k % ROD_FAMILY_COUNT), (rod_ends)ends, false);
      rod_case_directors(&t.c, m1);
      const hb_support_def *anchor = NULL;
      int anchor_edge = 0;
      for (int n = 0; n < t.c.model->frame_count; n++) {
        const hb_support_def *s = t.c.model->frames[n].def;
        int j = t.c.model->frames[n].slot;
        const double *at = t.c.state->x + 3 * j, *d = m1 + 3 * j;
        double angle = hb_formula_eval(s->angle, vars), tangent[3], length = t.c.model->rest_length[j];
        for (int c = 0; c < 3; c++) tangent[c] = (at[3 + c] - at[c]) / length;
        assert_near(d[0] * tangent[0] + d[1] * tangent[1] + d[2] * tangent[2], 0, 1e-13);
        if (s->kind == HB_SUPPORT_DIRECTOR) {
          double p[3], q[3], along = 0, size = 0;
          for (int c = 0; c < 3; c++) along += hb_formula_eval(s->value[c], vars) * tangent[c];
          for (int c = 0; c < 3; c++) p[c] = hb_formula_eval(s->value[c], vars) - along * tangent[c];
          for (int c = 0; c < 3; c++) size += p[c] * p[c];
          for (int c = 0; c < 3; c++)
            q[c] = tangent[(c + 1) % 3] * p[(c + 2) % 3] - tangent[(c + 2) % 3] * p[(c + 1) % 3];
          for (int c = 0; c < 3; c++)
            assert_near(d[c], (cos(angle) * p[c] + sin(angle) * q[c]) / sqrt(size), 1e-12);
          continue;
        }
        /* between two prescribed angles the whole difference counts, turn by turn */
        if (anchor)
          assert_near(t.theta[j] - t.theta[anchor_edge], angle - hb_formula_eval(anchor->angle, vars), 1e-11);
        anchor = s;
        anchor_edge = j;
      }
      finish(&t);
    }
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_complex_step),
                                     cmocka_unit_test(test_finite_differences),
                                     cmocka_unit_test(test_stationary), cmocka_unit_test(test_held)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
