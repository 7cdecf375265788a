/* The system of constrained equilibrium: its inertia against all eigenvalues of the dense matrix, its answers
 * against the matrix itself, for random rods under random tensions and compressions. */
#include "solve/kkt.h"
#include "support/near.h"
#include "support/rods.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { ROOM = 5 * 14 };

/* A dense symmetric matrix. */
typedef struct dense {
  int n;
  double a[ROOM][ROOM];
} dense;

/* The band as it is. */
static void unpack(const hb_band *m, dense *d) {
  d->n = m->n;
  memset(d->a, 0, sizeof d->a);
  for (int j = 0; j < m->n; j++)
    for (int k = 0; k <= m->half && j + k < m->n; k++)
      d->a[j][j + k] = d->a[j + k][j] = m->a[(m->half + 1) * j + k];
}

/* One plane rotation of Jacobi's method: entry (p, q) becomes 0. */
static void rotate(dense *d, int p, int q) {
  double apq = d->a[p][q];
  if (apq == 0) return;
  double theta = (d->a[q][q] - d->a[p][p]) / (2 * apq);
  double t = (theta >= 0 ? 1 : -1) / (fabs(theta) + sqrt(theta * theta + 1)), c = 1 / sqrt(t * t + 1),
         s = t * c;
  for (int k = 0; k < d->n; k++) {
    double x = d->a[k][p], y = d->a[k][q];
    d->a[k][p] = c * x - s * y;
    d->a[k][q] = s * x + c * y;
  }
  for (int k = 0; k < d->n; k++) {
    double x = d->a[p][k], y = d->a[q][k];
    d->a[p][k] = c * x - s * y;
    d->a[q][k] = s * x + c * y;
  }
}

/* Negative eigenvalues, by cyclic Jacobi; *least: smallest absolute value of any. */
static int negative_eigenvalues(dense *d, double *least) {
  for (int sweep = 0; sweep < 12; sweep++)
    for (int p = 0; p < d->n; p++)
      for (int q = p + 1; q < d->n; q++) rotate(d, p, q);
  int negative = 0;
  *least = HUGE_VAL;
  for (int k = 0; k < d->n; k++) {
    negative += d->a[k][k] < 0;
    *least = fmin(*least, fabs(d->a[k][k]));
  }
  return negative;
}

/* A random rod, some of its vertices held, with multipliers of the size of its bending forces. */
static void begin(rod_case *c, rng *r, int trial, hb_kkt *kkt, double *lambda) {
  hb_error err;
  rod_case_random(c, r, (rod_family)(trial % ROD_FAMILY_COUNT), (rod_ends)(trial / 4 % ROD_ENDS_COUNT), 1);
  int nv = c->def.rods[0].nv;
  int first = trial % 2 ? 0 : nv - 1;
  for (int i = 0; i < nv; i++)
    if (i == first || rng_int(r, 0, 3) == 0) rod_hold_vertex(&c->def.rods[0], i);
  rod_case_compile(c);
  rod_case_start(c, NULL);
  double h = c->model->rest_length[0],
         size = c->model->B[0] / (h * h) * rng_uniform(r, 0, trial % 3 == 0 ? 3 : 0.1);
  for (int j = 0; j < nv; j++) lambda[j] = size * rng_uniform(r, -1, 0.5);
  assert_int_equal(hb_kkt_create(nv, kkt, &err), HB_OK);
  hb_kkt_begin(kkt, c->model, c->rod);
}

/* Modes with negative stiffness by the band, and by all eigenvalues of the matrix without anything added. */
static void inertia(void **state) {
  (void)state;
  rng r = rng_start(41);
  int unstable = 0, compared = 0;
  for (int trial = 0; trial < 320; trial++) {
    rod_case c;
    hb_kkt kkt;
    dense d;
    double lambda[ROOM], least;
    begin(&c, &r, trial, &kkt, lambda);
    kkt.augment = 0;
    hb_kkt_assemble(&kkt, c.model, c.rod, c.state, &c.work, 0, lambda, NULL);
    unpack(&kkt.matrix, &d);
    int idle = 0; /* rows of edges between held vertices are empty */
    for (int j = 0; j < d.n; j++) {
      bool empty = true;
      for (int k = 0; k < d.n; k++) empty = empty && d.a[j][k] == 0;
      if (empty) d.a[j][j] = 1;
      idle += empty;
    }
    double scale = fabs(kkt.matrix.a[0]);
    for (int k = 0; k < d.n; k++) scale = fmax(scale, fabs(d.a[k][k]));
    int negative = negative_eigenvalues(&d, &least);
    assert_int_equal(kkt.constraints, c.rod->nv - 1 - idle);
    kkt.augment = 2;
    hb_kkt_assemble(&kkt, c.model, c.rod, c.state, &c.work, 0, lambda, NULL);
    int found = hb_kkt_factor(&kkt, 0);
    if (least > 1e-9 * scale) { /* else a mode is neutral to round-off, and either count is right */
      assert_int_equal(found, negative - kkt.constraints);
      unstable += found > 0;
      compared++;
    }
    hb_kkt_free(&kkt);
    rod_case_free(&c);
  }
  if (getenv("HEBRA_TEST_VERBOSE")) printf("%d compared, %d unstable\n", compared, unstable);
  assert_true(compared > 200 && unstable > 60 && compared - unstable > 60);
}

/* The answer fulfils the equations; prescribed coordinates do not move; lengths come right to first order. */
static void answers(void **state) {
  (void)state;
  rng r = rng_start(42);
  double worst = 0;
  for (int trial = 0; trial < 160; trial++) {
    rod_case c;
    hb_kkt kkt;
    double lambda[ROOM], right[ROOM], product[ROOM];
    begin(&c, &r, trial, &kkt, lambda);
    hb_kkt_assemble(&kkt, c.model, c.rod, c.state, &c.work, 0, lambda, NULL);
    double shift = 0.01 * c.model->B[0] / pow(c.model->rest_length[0], 4);
    (void)hb_kkt_factor(&kkt, shift);
    for (int k = 0; k < kkt.matrix.n; k++)
      right[k] = kkt.right[k] += kkt.weight[k] != 0 ? rng_uniform(&r, -1, 1) : 0;
    double size = rod_largest(right, kkt.matrix.n);
    hb_kkt_solve(&kkt);
    hb_band_multiply(&kkt.matrix, kkt.right, product);
    for (int k = 0; k < kkt.matrix.n; k++) {
      bool multiplier = k % HB_KKT_STRIDE == HB_KKT_MULTIPLIER && k >= HB_KKT_STRIDE;
      product[k] += shift * kkt.weight[k] * kkt.right[k];
      if (kkt.weight[k] == 0 && !multiplier) assert_same(kkt.right[k], 0);
    }
    worst = fmax(worst, rod_difference(product, right, kkt.matrix.n) / size);
    hb_kkt_free(&kkt);
    rod_case_free(&c);
  }
  if (getenv("HEBRA_TEST_VERBOSE")) printf("largest residual %.2e\n", worst);
  assert_at_most(worst, 1e-9);
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(inertia), cmocka_unit_test(answers)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
