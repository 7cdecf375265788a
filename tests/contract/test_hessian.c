/* The Hessian of the elastic energy against differences of the exact force, over random rods of every kind:
 * 208 with the twist solved anew at every displaced shape, and as many with all frames held. */
#include "support/near.h"
#include "support/rods.h"

#include "base/memory.h"
#include "math/rotation.h"
#include "rod/hessian.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define TRIALS 13 /* times 16 kinds: 208 rods */
#define TURNS 6.0
enum { VERTICES = 16, ROOM = 4 * VERTICES, STRIDE = 4, HALF = 2 * STRIDE + 2 };

/* A dense symmetric matrix. */
typedef struct dense {
  int n;
  double a[ROOM][ROOM];
} dense;

/* The Hessian at the shape that the case is at, both halves. */
static void hessian(rod_case *c, dense *h) {
  hb_band K = {.n = STRIDE * c->rod->nv, .half = HALF, .a = NULL};
  K.a = rod_array((int)hb_band_size(K.n, K.half));
  hb_rod_hessian(c->model, c->rod, c->state, &c->work, STRIDE, &K);
  memset(h, 0, sizeof *h);
  h->n = K.n;
  for (int col = 0; col < K.n; col++)
    for (int k = 0; k <= HALF && col + k < K.n; k++)
      h->a[col][col + k] = h->a[col + k][col] = K.a[(HALF + 1) * col + k];
  hb_free(K.a);
}

/* Eliminates unknown k: the others then follow with it in equilibrium. Its row keeps what tells how it
 * follows. */
static void eliminate(dense *h, int k) {
  double pivot = h->a[k][k];
  assert_true(fabs(pivot) > 0);
  for (int i = 0; i < h->n; i++) {
    if (i == k || h->a[i][k] == 0) continue;
    double ratio = h->a[i][k] / pivot;
    for (int j = 0; j < h->n; j++)
      if (j != k) h->a[i][j] -= ratio * h->a[k][j];
  }
  for (int i = 0; i < h->n; i++)
    if (i != k) h->a[i][k] = h->a[k][i] = 0;
}

/* Force at x displaced by amount in coordinate k, from the same state. */
static void force_at(rod_case *c, const double *x, int k, double amount, const double *saved, double *force) {
  double moved[ROOM];
  memcpy(c->state->block, saved, c->state->count * sizeof *saved);
  memcpy(moved, x, 3 * (size_t)c->rod->nv * sizeof *x);
  moved[k] += amount;
  rod_case_evaluate(c, moved, 0);
  memcpy(force, rod_case_force(c), 3 * (size_t)c->rod->nv * sizeof *force);
}

/* Minus the derivative of the force by coordinate k: central differences with three steps, extrapolated
 * twice. */
static void slope(rod_case *c, const double *x, int k, double step, const double *saved, double *out) {
  double table[3][ROOM], up[ROOM], down[ROOM];
  int n = 3 * c->rod->nv;
  for (int level = 0; level < 3; level++, step *= 0.5) {
    force_at(c, x, k, step, saved, up);
    force_at(c, x, k, -step, saved, down);
    for (int i = 0; i < n; i++) table[level][i] = -(up[i] - down[i]) / (2 * step);
  }
  for (int i = 0; i < n; i++) {
    double once = (4 * table[1][i] - table[0][i]) / 3, again = (4 * table[2][i] - table[1][i]) / 3;
    out[i] = (16 * again - once) / 15;
  }
}

/* Largest difference of the Hessian from the slopes of the force, relative to its largest entry. fixed: per
 * vertex; those are not displaced, and what comes out on them is not compared. Negative: nothing is free. */
static double worst_slope(rod_case *c, const dense *h, const bool *fixed) {
  int nv = c->rod->nv;
  double x[ROOM], by_force[ROOM], most = 0, scale = 0;
  double *saved = rod_array((int)c->state->count);
  memcpy(saved, c->state->block, c->state->count * sizeof *saved);
  memcpy(x, c->state->x, 3 * (size_t)nv * sizeof *x);
  for (int i = 0; i < nv; i++)
    for (int k = 0; k < 3; k++) {
      if (fixed[i]) continue;
      slope(c, x, 3 * i + k, 1e-3 * c->model->rest_length[0], saved, by_force);
      for (int n = 0; n < 3 * nv; n++) {
        if (fixed[n / 3]) continue;
        double expected = h->a[STRIDE * (n / 3) + n % 3][STRIDE * i + k];
        most = fmax(most, fabs(expected - by_force[n]));
        scale = fmax(scale, fabs(expected));
      }
    }
  memcpy(c->state->block, saved, c->state->count * sizeof *saved);
  hb_free(saved);
  return scale > 0 ? most / scale : -1;
}

/* Springs along the edges, a tenth longer than at rest. */
static void stretch(rod_case *c, rng *r) {
  hb_rod_def *def = &c->def.rods[0];
  rod_make_extensible(c, r);
  for (int k = 0; k < 3 * def->nv; k++) def->initial[k] *= 1.1;
}

/* Twist solved anew. Edges with held frames stand still: what "held" means for an edge that turns is a
 * convention (3.1), under which the torque of the support turns with it and the force has no potential. */
static void test_twist_eliminated(void **state) {
  (void)state;
  rng r = rng_start(301), springs = rng_start(304);
  double worst = 0;
  for (int family = 0; family < ROD_FAMILY_COUNT; family++)
    for (int ends = 0; ends < ROD_ENDS_COUNT; ends++)
      for (int trial = 0; trial < TRIALS;) {
        rod_case c;
        dense h;
        bool fixed[VERTICES] = {false}, unknown[VERTICES];
        rod_case_random(&c, &r, (rod_family)family, (rod_ends)ends, TURNS);
        if (trial % 2) stretch(&c, &springs);
        rod_case_compile(&c);
        rod_case_start(&c, NULL);
        for (int k = 0; k < c.model->frame_count; k++)
          fixed[c.model->frames[k].slot] = fixed[c.model->frames[k].slot + 1] = true;
        hessian(&c, &h);
        hb_rod_free_angles(c.model, c.rod, unknown);
        for (int j = 0; j + 1 < c.rod->nv; j++)
          if (unknown[j] && h.a[STRIDE * j + 3][STRIDE * j + 3] != 0) eliminate(&h, STRIDE * j + 3);
        double error = worst_slope(&c, &h, fixed);
        if (error >= 0) trial++;
        worst = fmax(worst, error);
        assert_at_most(worst, 1e-9);
        rod_case_free(&c);
      }
  if (getenv("HEBRA_TEST_VERBOSE")) printf("twist eliminated: %.2e\n", worst);
}

/* All frames held where they had come to rest: then nothing follows, and no support has a torque, so that the
 * block of the vertices stands alone. */
static void test_frames_held(void **state) {
  (void)state;
  rng r = rng_start(302);
  double worst = 0;
  for (int family = ROD_ANISOTROPIC; family < ROD_FAMILY_COUNT; family++)
    for (int trial = 0; trial < 5 * TRIALS; trial++) {
      rod_case c;
      dense h;
      bool fixed[VERTICES] = {false};
      rod_case_random(&c, &r, (rod_family)family, ROD_FREE_FREE, TURNS);
      for (int j = 0; j + 1 < c.def.rods[0].nv; j++)
        rod_add_support(&c.def.rods[0], HB_SUPPORT_ANGLE, j)->held = true;
      rod_case_compile(&c);
      if (!c.rod->closed_form) {
        rod_case_start(&c, NULL);
        hessian(&c, &h);
        worst = fmax(worst, worst_slope(&c, &h, fixed));
        assert_at_most(worst, 1e-9);
      }
      rod_case_free(&c);
    }
  if (getenv("HEBRA_TEST_VERBOSE")) printf("frames held: %.2e\n", worst);
}

/* Rows of the angles: a vertex moves, and the frames come to rest where the rows say. */
static void test_angles_follow(void **state) {
  (void)state;
  rng r = rng_start(303);
  double worst = 0;
  for (int trial = 0; trial < 4 * TRIALS; trial++) {
    rod_case c;
    dense h, rows;
    rod_case_random(&c, &r, ROD_ANISOTROPIC, ROD_FREE_FREE, TURNS);
    rod_case_compile(&c);
    rod_case_start(&c, NULL);
    if (c.rod->closed_form || c.def.rods[0].B[0] == c.def.rods[0].B[2]) {
      rod_case_free(&c);
      continue;
    }
    int ne = c.rod->nv - 1, moved = 3 * rng_int(&r, 0, ne) + rng_int(&r, 0, 2);
    double before[3 * VERTICES], tangents[3 * VERTICES], after[2][3 * VERTICES],
        step = 1e-4 * c.model->rest_length[0];
    double x[ROOM], *saved = rod_array((int)c.state->count);
    hessian(&c, &h);
    rows = h;
    memcpy(saved, c.state->block, c.state->count * sizeof *saved);
    memcpy(x, c.state->x, 3 * (size_t)(ne + 1) * sizeof *x);
    rod_case_directors(&c, before);
    memcpy(tangents, c.work.tangent, 3 * (size_t)ne * sizeof *tangents);
    double turned[2][VERTICES];
    for (int side = 0; side < 2; side++) {
      memcpy(c.state->block, saved, c.state->count * sizeof *saved);
      double y[ROOM];
      memcpy(y, x, sizeof y);
      y[moved] += side ? -step : step;
      rod_case_evaluate(&c, y, 0);
      rod_case_directors(&c, after[side]);
      for (int j = 0; j < ne; j++) {
        hb_v3 t = hb_v3_load(c.work.tangent + 3 * j);
        hb_v3 carried = hb_carry(hb_v3_load(before + 3 * j), hb_v3_load(tangents + 3 * j), t);
        turned[side][j] = hb_angle_about(carried, hb_v3_load(after[side] + 3 * j), t);
      }
    }
    for (int j = 0; j < ne; j++) { /* sum of row times (move, turns) must vanish */
      double sum = rows.a[4 * j + 3][4 * (moved / 3) + moved % 3], size = fabs(sum);
      for (int k = 0; k < ne; k++) {
        double part = rows.a[4 * j + 3][4 * k + 3] * (turned[0][k] - turned[1][k]) / (2 * step);
        sum += part;
        size += fabs(part);
      }
      if (size > 0) worst = fmax(worst, fabs(sum) / size);
    }
    assert_at_most(worst, 1e-5); /* plain central differences of angles */
    hb_free(saved);
    rod_case_free(&c);
  }
  if (getenv("HEBRA_TEST_VERBOSE")) printf("angles follow: %.2e\n", worst);
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_twist_eliminated),
                                     cmocka_unit_test(test_frames_held),
                                     cmocka_unit_test(test_angles_follow)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
