/* What closed rods must satisfy, whatever the rod: the force is minus the gradient of an energy that is
 * written here a second time, around the curve with the closing angle; no net force or torque; the same
 * answer wherever the list of vertices begins, however the rod lies and whichever way it is counted; lengths
 * and momenta kept by the projection; the same bits after a restart. */
#include "hebra/hebra.h"
#include "math/rotation.h"
#include "rod/hessian.h"
#include "rod/writhe.h"
#include "solve/project.h"
#include "support/energy.h"
#include "support/near.h"
#include "support/rods.h"
#include "support/scenes.h"

#include <complex.h>
#include <string.h>

#define TRIALS 12
#define EDGES_MAX 24
#define ROOM (3 * (EDGES_MAX + 1))

typedef double complex number;

/* What a random closed rod is made of. */
enum { ISOTROPIC, ANISOTROPIC, CURVED, DIRECTED, HELD, KINDS };

/* ---- random closed rods -----------------------------------------------------------------------------------
 */

/* A smooth random closed polygon of n edges; the first vertex once more at its end. */
static void random_ring(rng *r, int n, double *x) {
  double wave[3][3][2];
  for (int c = 0; c < 3; c++)
    for (int k = 0; k < 3; k++)
      for (int p = 0; p < 2; p++) wave[c][k][p] = rng_uniform(r, -0.3, 0.3) / (k + 1);
  for (int i = 0; i < n; i++) {
    double a = 2 * HB_PI * (i + 0.1 * sin(1.7 * i)) / n, base[3] = {cos(a), sin(a), 0};
    for (int c = 0; c < 3; c++) {
      x[3 * i + c] = base[c];
      for (int k = 0; k < 3; k++)
        x[3 * i + c] += wave[c][k][0] * cos((k + 1) * a) + wave[c][k][1] * sin((k + 1) * a);
    }
  }
  memcpy(x + 3 * n, x, 3 * sizeof *x);
}

/* The definition of a random closed rod; HELD: curved, and the frames of one or two edges are held. */
static void draw(rod_case *c, rng *r, int kind) {
  int n = rng_int(r, 6, EDGES_MAX - 1);
  rod_case_straight(c, n + 1, 0.1, 1, 1);
  hb_rod_def *def = &c->def.rods[0];
  bool even = kind == ISOTROPIC, straight = kind == ISOTROPIC || kind == ANISOTROPIC;
  double a = rng_uniform(r, 0.05, 0.5), b = even ? a : rng_uniform(r, 0.02, 0.5),
         phase = rng_uniform(r, 0, 6);
  random_ring(r, n, def->initial);
  if (!straight) random_ring(r, n, def->rest);
  if (straight && rng_int(r, 0, 1)) memcpy(def->rest, def->initial, 3 * (size_t)(n + 1) * sizeof(double));
  def->straight_rest = straight;
  for (int j = 0; j < n; j++) {
    double swell = 1 + 0.4 * sin(phase + 0.7 * j);
    def->B[3 * j] = swell * a;
    def->B[3 * j + 1] = even ? 0 : 0.3 * swell * fmin(a, b) * sin(phase);
    def->B[3 * j + 2] = swell * b;
  }
  for (int i = 0; i <= n; i++) def->beta[i] = 0.1 * (1 + 0.5 * sin(2 * phase + 0.9 * i));
  for (int i = 0; i <= n; i++) def->mass[i] = rng_uniform(r, 0.5, 2);
  rng_direction(r, def->first_director);
  if (kind == DIRECTED) {
    def->rest_m1 = rod_array(3 * n);
    for (int j = 0; j < n; j++) {
      double angle = 2 * HB_PI * j / n;
      double d[3] = {0.3 * cos(angle), 0.3 * sin(angle), 1 + 0.1 * sin(2 * angle)};
      memcpy(def->rest_m1 + 3 * j, d, sizeof d);
    }
  } else if (rng_int(r, 0, 1)) {
    def->natural_twist = rod_array(n + 1);
    for (int i = 0; i <= n; i++) def->natural_twist[i] = rng_uniform(r, -1, 1);
  }
  def->closing = (hb_closing)rng_int(r, HB_CLOSING_TURNS, HB_CLOSING_LINK);
  def->closing_value = def->closing == HB_CLOSING_TWIST ? rng_uniform(r, -9, 9) : rng_int(r, -2, 2);
  if (kind != HELD) return;
  rod_hold_angle(def, rng_int(r, 0, n / 2 - 1), "0.4");
  if (rng_int(r, 0, 1)) rod_hold_angle(def, rng_int(r, n / 2, n - 1), "-0.9");
}

/* Compiled and relaxed. */
static void begin(rod_case *c, rng *r, int kind) {
  draw(c, r, kind);
  rod_case_compile(c);
  rod_case_start(c, NULL);
}

/* ---- the energy once more
 * ---------------------------------------------------------------------------------- */

/* Sums without conjugation: analytic. */
static number dot(const number *a, const number *b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

/* a x b */
static void cross(const number *a, const number *b, number *out) {
  for (int k = 0; k < 3; k++) out[k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
}

/* The angle whose cosine and sine are c and s, with infinitesimal imaginary parts. */
static number angle_of(number c, number s) {
  double re = creal(c), im = creal(s);
  return rod_complex(atan2(im, re), (re * cimag(s) - im * cimag(c)) / (re * re + im * im));
}

/* Rodrigues' rotation about a x b. */
static void rotate(const number *a, const number *b, const number *d, number *out) {
  number s[3], sd[3], c = dot(a, b);
  cross(a, b, s);
  cross(s, d, sd);
  number along = dot(s, d) / (1 + c);
  for (int k = 0; k < 3; k++) out[k] = c * d[k] + sd[k] + along * s[k];
}

/* u cos angle + (t x u) sin angle. */
static void turn(const number *t, const number *u, number angle, number *out) {
  number v[3], c = ccos(angle), s = csin(angle);
  cross(t, u, v);
  for (int k = 0; k < 3; k++) out[k] = c * u[k] + s * v[k];
}

/* The library's answer to which this energy is compared: angles against the Bishop frame of the shape x0. */
typedef struct reference {
  const hb_model *m;
  int n;
  double u0[3], t0[3], theta[EDGES_MAX + 1],
      total;                          /* total: theta behind the last edge minus that of the first */
  double held_m1[ROOM], held_t[ROOM]; /* director and tangent of held edges */
} reference;

/* Angles from the library's directors and twists at its present shape. */
static void refer(reference *ref, rod_case *c) {
  double m1[ROOM];
  ref->m = c->model;
  ref->n = c->rod->nv - 1;
  rod_case_directors(c, m1);
  memcpy(ref->t0, c->work.tangent, sizeof ref->t0);
  memcpy(ref->u0, c->state->anchor_m1, sizeof ref->u0);
  memcpy(ref->held_m1, m1, 3 * (size_t)ref->n * sizeof *m1);
  memcpy(ref->held_t, c->work.tangent, 3 * (size_t)ref->n * sizeof *m1);
  double at = hb_angle_about(hb_v3_load(ref->u0), hb_v3_load(m1), hb_v3_load(ref->t0));
  ref->theta[0] = at;
  for (int i = 1; i <= ref->n; i++) {
    double moment = c->state->moment[0];
    at +=
        c->rod->closed_form ? c->model->rest_twist[i] + moment / c->model->twist_gain[i] : c->state->twist[i];
    ref->theta[i] = at;
  }
  ref->total = ref->theta[ref->n] - ref->theta[0];
}

/* Bending and twisting energy at the shape x (n vertices) with the angles of the reference, held directors
 * carried in time. The angle behind the last edge is that of the first plus what the Bishop frame has turned
 * less on its way around. */
static number energy(const reference *ref, const number *x) {
  const hb_model *m = ref->m;
  number t[EDGES_MAX + 1][3], u[EDGES_MAX + 1][3], theta[EDGES_MAX + 1], e[3], sum = 0;
  int n = ref->n;
  for (int j = 0; j < n; j++) {
    for (int k = 0; k < 3; k++) e[k] = x[3 * ((j + 1) % n) + k] - x[3 * j + k];
    number size = csqrt(dot(e, e));
    for (int k = 0; k < 3; k++) t[j][k] = e[k] / size;
  }
  memcpy(t[n], t[0], sizeof t[0]);
  number old_t[3] = {ref->t0[0], ref->t0[1], ref->t0[2]}, old_u[3] = {ref->u0[0], ref->u0[1], ref->u0[2]};
  rotate(old_t, t[0], old_u, u[0]);
  for (int j = 1; j <= n; j++) rotate(t[j - 1], t[j], u[j - 1], u[j]);
  for (int j = 0; j < n; j++) {
    theta[j] = ref->theta[j];
    if (m->frame_of[j] < 0) continue;
    number d[3], from[3], then[3], v[3];
    for (int k = 0; k < 3; k++) then[k] = ref->held_t[3 * j + k];
    for (int k = 0; k < 3; k++) from[k] = ref->held_m1[3 * j + k];
    rotate(then, t[j], from, d);
    cross(t[j], u[j], v);
    number angle = angle_of(dot(d, u[j]), dot(d, v));
    theta[j] = angle + 2 * HB_PI * rint((ref->theta[j] - creal(angle)) / (2 * HB_PI));
  }
  number v[3];
  cross(t[0], u[n], v);
  number gap = angle_of(dot(u[n], u[0]), dot(v, u[0])); /* from the carried director to the first */
  gap += ref->total - creal(gap);                       /* whole turns and the cut, at the reference itself */
  theta[n] = theta[0] + gap;
  for (int i = 1; i <= n; i++) {
    int side_edge[2] = {i - 1, i % n};
    number kb[3], m1[3], m2[3], l = m->voronoi[i], twist = theta[i] - theta[i - 1] - m->rest_twist[i];
    cross(t[i - 1], t[i], kb);
    for (int k = 0; k < 3; k++) kb[k] *= 2 / (1 + dot(t[i - 1], t[i]));
    for (int side = 0; side < 2; side++) {
      int j = side_edge[side];
      const double *B = m->def->rods[0].B + 3 * j, *rest = m->rest_omega + 4 * i + 2 * side;
      turn(t[j], u[j], theta[j], m1);
      cross(t[j], m1, m2);
      number p = dot(kb, m2) - rest[0], q = -dot(kb, m1) - rest[1];
      sum += (B[0] * p * p + 2 * B[1] * p * q + B[2] * q * q) / (2 * l);
    }
    sum += m->beta[i] * twist * twist / l;
  }
  return sum;
}

/* ---- forces
 * ------------------------------------------------------------------------------------------------ */

/* The force on vertex i of n: halves are added up. */
static hb_v3 force_on(const rod_case *c, int i) {
  hb_v3 f = hb_v3_load(c->state->force + 3 * i);
  return i > 0 ? f : hb_v3_add(f, hb_v3_load(c->state->force + 3 * (c->rod->nv - 1)));
}

/* A check of one random rod. */
typedef void (*check)(rod_case *c, rng *r, int kind);

/* Over all kinds. */
static void sweep(uint64_t seed, check one) {
  rng r = rng_start(seed);
  for (int kind = 0; kind < KINDS; kind++)
    for (int k = 0; k < TRIALS; k++) {
      rod_case c;
      begin(&c, &r, kind);
      one(&c, &r, kind);
      rod_case_free(&c);
    }
}

/* Complex steps; the energy itself as well. */
static void complex_step(rod_case *c, rng *r, int kind) {
  (void)r;
  (void)kind;
  reference ref;
  number x[ROOM];
  double force[ROOM], found[ROOM];
  refer(&ref, c);
  for (int k = 0; k < 3 * ref.n; k++) x[k] = c->state->x[k];
  double e = creal(energy(&ref, x));
  assert_true(e > 0);
  assert_near_rel(hb_rod_energy(c->model, c->rod, c->state, &c->work), e, 1e-12);
  for (int k = 0; k < 3 * ref.n; k++) {
    x[k] = rod_complex(c->state->x[k], 1e-30);
    force[k] = -cimag(energy(&ref, x)) / 1e-30;
    x[k] = c->state->x[k];
  }
  for (int i = 0; i < ref.n; i++) hb_v3_store(found + 3 * i, force_on(c, i));
  assert_at_most(rod_difference(force, found, 3 * ref.n), 1e-12 * rod_largest(force, 3 * ref.n));
}

/* 60 rods of every kind. */
static void test_complex_step(void **state) {
  (void)state;
  sweep(11, complex_step);
}

/* Energy with one coordinate moved, the twist solved again. */
static double moved_energy(rod_case *c, int k, double step) {
  double x[ROOM];
  int n = c->rod->nv - 1;
  memcpy(x, c->state->x, 3 * (size_t)(n + 1) * sizeof *x);
  x[k] += step;
  if (k < 3) x[3 * n + k] = x[k];
  double kept[ROOM];
  memcpy(kept, c->state->x, sizeof kept);
  rod_case_evaluate(c, x, 0);
  double e = hb_rod_energy(c->model, c->rod, c->state, &c->work);
  rod_case_evaluate(c, kept, 0);
  return e;
}

/* Differences of the library's own energy, to fourth order. */
static void differences(rod_case *c, rng *r, int kind) {
  (void)kind;
  double h = 2e-4 * c->model->rest_length[0], scale = 2 * rod_largest(c->state->force, 3 * c->rod->nv);
  for (int round = 0; round < 6; round++) {
    int k = round < 3 ? round : rng_int(r, 3, 3 * (c->rod->nv - 1) - 1);
    double one = moved_energy(c, k, h) - moved_energy(c, k, -h);
    double two = moved_energy(c, k, 2 * h) - moved_energy(c, k, -2 * h);
    hb_v3 f = force_on(c, k / 3);
    double slope = (8 * one - two) / (12 * h);
    assert_near((&f.x)[k % 3], -slope, 1e-7 * scale);
  }
}

/* By differences. */
static void test_differences(void **state) {
  (void)state;
  sweep(12, differences);
}

/* Newton and Euler: what held frames take up is all that is left. */
static void balance(rod_case *c, rng *r, int kind) {
  (void)r;
  (void)kind;
  hb_v3 sum = {0, 0, 0}, torque = {0, 0, 0};
  double scale = rod_largest(c->state->force, 3 * c->rod->nv);
  for (int i = 0; i < c->rod->nv; i++) {
    hb_v3 f = hb_v3_load(c->state->force + 3 * i);
    sum = hb_v3_add(sum, f);
    torque = hb_v3_add(torque, hb_v3_cross(hb_v3_load(c->state->x + 3 * i), f));
  }
  for (int k = 0; k < c->model->frame_count; k++) {
    hb_v3 t = hb_v3_load(c->work.tangent + 3 * c->model->frames[k].slot);
    torque = hb_v3_axpy(torque, -c->state->frame_torque[k], t);
    scale = fmax(scale, fabs(c->state->frame_torque[k]));
  }
  assert_at_most(hb_v3_norm(sum), 3e-13 * scale);
  assert_at_most(hb_v3_norm(torque), 1e-12 * scale);
}

/* No net force, no net torque. */
static void test_balance(void **state) {
  (void)state;
  sweep(13, balance);
}

/* Puts rows of so many doubles in the order that begins with row `from`. */
static void roll(double *a, int rows, int width, int from) {
  double kept[4 * ROOM];
  memcpy(kept, a, (size_t)(rows * width) * sizeof *a);
  for (int i = 0; i < rows; i++)
    memcpy(a + width * i, kept + width * ((i + from) % rows), (size_t)width * sizeof *a);
}

/* The list of vertices begins elsewhere: the same energy, the same forces. */
static void test_first_vertex(void **state) {
  (void)state;
  rng r = rng_start(14);
  for (int round = 0; round < 3 * TRIALS; round++) {
    rod_case a, b;
    rng again;
    int kind = round % 2 ? DIRECTED : ISOTROPIC;
    for (;;) { /* natural twist has a place where the list begins, and so has a cut */
      again = r;
      draw(&a, &r, kind);
      if (!a.def.rods[0].natural_twist && a.def.rods[0].closing != HB_CLOSING_TWIST) break;
      rod_case_free(&a);
    }
    draw(&b, &again, kind);
    hb_rod_def *first = &a.def.rods[0], *second = &b.def.rods[0];
    int n = first->nv - 1, from = rng_int(&r, 1, n - 1);
    first->beta[n] = second->beta[n] = first->beta[0];
    if (kind == DIRECTED) { /* near its rest shape there is one way to lie, far from it there are several */
      first->closing = second->closing = HB_CLOSING_TURNS;
      first->closing_value = second->closing_value = 0;
      for (int k = 0; k < 3 * (n + 1); k++)
        first->initial[k] = second->initial[k] = first->rest[k] + 0.2 * (first->initial[k] - first->rest[k]);
    }
    roll(second->beta, n, 1, from);
    second->beta[n] = second->beta[0];
    roll(second->B, n, 3, from);
    double *shapes[2] = {second->rest, second->initial};
    for (int s = 0; s < 2; s++) {
      roll(shapes[s], n, 3, from);
      memcpy(shapes[s] + 3 * n, shapes[s], 3 * sizeof(double));
    }
    if (kind == ISOTROPIC) memcpy(first->rest, first->initial, 3 * (size_t)(n + 1) * sizeof(double));
    if (kind == ISOTROPIC) memcpy(second->rest, second->initial, 3 * (size_t)(n + 1) * sizeof(double));
    if (second->rest_m1) roll(second->rest_m1, n, 3, from);
    rod_case_compile(&a);
    rod_case_start(&a, NULL);
    double m1[ROOM];
    rod_case_directors(&a, m1);
    memcpy(second->first_director, m1 + 3 * from, 3 * sizeof *m1);
    rod_case_compile(&b);
    rod_case_start(&b, NULL);
    double e = hb_rod_energy(a.model, a.rod, a.state, &a.work), scale = rod_largest(a.state->force, 3 * n);
    assert_near_rel(hb_rod_energy(b.model, b.rod, b.state, &b.work), e, 1e-11);
    for (int i = 0; i < n; i++) {
      hb_v3 f = force_on(&a, (i + from) % n), g = force_on(&b, i);
      assert_at_most(hb_v3_norm(hb_v3_sub(f, g)), 1e-10 * scale);
    }
    rod_case_free(&a);
    rod_case_free(&b);
  }
}

/* Turned, shifted, counted the other way round: forces follow. */
static void test_placed_otherwise(void **state) {
  (void)state;
  rng r = rng_start(15);
  for (int round = 0; round < 2 * TRIALS; round++) {
    rod_case a, b;
    rng again = r;
    int kind = round % 2 ? CURVED : ISOTROPIC;
    double rotation[9], shift[3] = {0.4, -3, 1}, m1[3];
    draw(&a, &r, kind);
    draw(&b, &again, kind);
    rod_random_rotation(&r, rotation);
    hb_rod_def *def = &b.def.rods[0];
    int n = def->nv - 1;
    bool backwards = kind == ISOTROPIC;
    rod_case_compile(&a);
    rod_case_start(&a, NULL);
    if (backwards) { /* joints and edges in the opposite order; twists keep their sign */
      for (int i = 0; i < (n + 1) / 2; i++)
        for (int c = 0; c < 3; c++) {
          double keep = def->initial[3 * i + c];
          def->initial[3 * i + c] = def->initial[3 * (n - i) + c];
          def->initial[3 * (n - i) + c] = keep;
          keep = def->rest[3 * i + c];
          def->rest[3 * i + c] = def->rest[3 * (n - i) + c];
          def->rest[3 * (n - i) + c] = keep;
        }
      for (int i = 0; i < n / 2; i++)
        for (int c = 0; c < 3; c++) {
          double keep = def->B[3 * i + c];
          def->B[3 * i + c] = def->B[3 * (n - 1 - i) + c];
          def->B[3 * (n - 1 - i) + c] = keep;
        }
      double *along[2] = {def->beta, def->natural_twist};
      for (int k = 0; k < 2; k++)
        for (int i = 0; along[k] && i < (n + 1) / 2; i++) {
          double keep = along[k][i];
          along[k][i] = along[k][n - i];
          along[k][n - i] = keep;
        }
      memset(def->first_director, 0, sizeof def->first_director);
    }
    rod_move(rotation, shift, def->initial, n + 1, def->initial);
    rod_move(rotation, shift, def->rest, n + 1, def->rest);
    memcpy(m1, a.def.rods[0].first_director, sizeof m1);
    if (!backwards) rod_move(rotation, NULL, m1, 1, def->first_director);
    rod_case_compile(&b);
    rod_case_start(&b, NULL);
    double e = hb_rod_energy(a.model, a.rod, a.state, &a.work), scale = rod_largest(a.state->force, 3 * n);
    assert_near_rel(hb_rod_energy(b.model, b.rod, b.state, &b.work), e, 1e-11);
    for (int i = 0; i < n; i++) {
      double turned[3];
      hb_v3 f = force_on(&a, i);
      rod_move(rotation, NULL, &f.x, 1, turned);
      hb_v3 g = force_on(&b, backwards ? (n - i) % n : i);
      assert_at_most(hb_v3_norm(hb_v3_sub(hb_v3_load(turned), g)), 1e-10 * scale);
    }
    rod_case_free(&a);
    rod_case_free(&b);
  }
}

/* ---- rest shapes
 * ------------------------------------------------------------------------------------------- */

/* At its closed rest shape a rod feels nothing, wherever that lies. */
static void test_at_rest(void **state) {
  (void)state;
  rng r = rng_start(16);
  for (int round = 0; round < 2 * TRIALS; round++) {
    rod_case c;
    double rotation[9], shift[3] = {1, 2, 3};
    draw(&c, &r, round % 2 ? CURVED : DIRECTED);
    hb_rod_def *def = &c.def.rods[0];
    rod_random_rotation(&r, rotation);
    rod_move(rotation, shift, def->rest, def->nv, def->initial);
    rod_move(rotation, NULL, def->rest_m1 ? def->rest_m1 : def->first_director, 1, def->first_director);
    if (!def->rest_m1) { /* the rest shape has the director that is moved along */
      double back[9];
      for (int a = 0; a < 9; a++) back[a] = rotation[3 * (a % 3) + a / 3];
      def->rest_m1 = NULL;
      rod_move(back, NULL, def->initial, 0, def->initial);
      memcpy(def->initial, def->rest, 3 * (size_t)def->nv * sizeof(double));
      rod_move(back, NULL, def->first_director, 1, def->first_director);
    }
    def->closing = HB_CLOSING_TURNS;
    def->closing_value = 0;
    rod_case_compile(&c);
    rod_case_start(&c, NULL);
    double stiffness = rod_largest(def->B, 3 * (def->nv - 1)), shortest = 1;
    for (int j = 0; j + 1 < def->nv; j++) shortest = fmin(shortest, c.model->rest_length[j]);
    assert_at_most(hb_rod_energy(c.model, c.rod, c.state, &c.work), 1e-24 * stiffness / shortest);
    assert_at_most(rod_largest(c.state->force, 3 * def->nv), 1e-12 * stiffness / (shortest * shortest));
    rod_case_free(&c);
  }
}

/* A rod that was an open arc is the same all around once it is joined to a ring, and the joint shows nowhere.
 */
static void test_open_at_rest(void **state) {
  (void)state;
  enum { N = 20 };
  rod_case c;
  rod_case_straight(&c, N + 1, 0.1, 0.3, 0.2);
  hb_rod_def *def = &c.def.rods[0];
  double bend = 0.37, radius = 0.05 / sin(HB_PI / N);
  for (int i = 0; i <= N; i++) {
    double a = 2 * HB_PI * (i % N) / N;
    def->initial[3 * i] = radius * cos(a);
    def->initial[3 * i + 1] = radius * sin(a);
    for (int k = 0; i > 0 && k < 3; k++) {
      double t[3] = {cos(bend * i), sin(bend * i), 0};
      def->rest[3 * i + k] = def->rest[3 * i - 3 + k] + 0.1 * t[k];
    }
  }
  def->first_director[1] = 0;
  def->first_director[2] = 1;
  def->closing = HB_CLOSING_TURNS;
  rod_case_compile(&c);
  rod_case_start(&c, NULL);
  assert_near(c.model->rest_twist[N], 0, 1e-15);
  for (int i = 1; i <= N; i++)
    for (int k = 0; k < 4; k++)
      assert_near(c.model->rest_omega[4 * i + k], k % 2 == 0 ? 0 : -2 * tan(bend / 2), 1e-14);
  /* the same moment everywhere pulls at no vertex */
  assert_at_most(rod_largest(c.state->force, 3 * (N + 1)), 1e-13 * 0.3 / (0.1 * 0.1));
  assert_near_rel(hb_rod_energy(c.model, c.rod, c.state, &c.work),
                  N * 0.3 * 4 * pow(tan(HB_PI / N) - tan(bend / 2), 2) / 0.2, 1e-12);
  rod_case_free(&c);
}

/* ---- lengths
 * ----------------------------------------------------------------------------------------------- */

/* Rates of all lengths. */
static double largest_rate(const rod_case *c, const double *v) {
  double most = 0;
  for (int j = 0; j + 1 < c->rod->nv; j++) {
    hb_v3 e = hb_v3_sub(hb_v3_load(c->state->x + 3 * j + 3), hb_v3_load(c->state->x + 3 * j));
    hb_v3 rate = hb_v3_sub(hb_v3_load(v + 3 * j + 3), hb_v3_load(v + 3 * j));
    most = fmax(most, fabs(hb_v3_dot(e, rate)) / hb_v3_norm(e));
  }
  return most;
}

/* Sum of mass times vector, and of its moment. */
static void momenta(const rod_case *c, const double *v, hb_v3 *linear, hb_v3 *angular) {
  *linear = *angular = (hb_v3){0, 0, 0};
  for (int i = 0; i < c->rod->nv; i++) {
    hb_v3 p = hb_v3_scale(c->model->mass[i], hb_v3_load(v + 3 * i));
    *linear = hb_v3_add(*linear, p);
    *angular = hb_v3_add(*angular, hb_v3_cross(hb_v3_load(c->state->x + 3 * i), p));
  }
}

/* The projection of velocities is the one and only: no rates left, nothing changed along what they keep. */
static void velocities(rod_case *c, rng *r, int kind) {
  (void)kind;
  hb_error err;
  hb_project_work work;
  double v[ROOM], before[ROOM];
  int n = c->rod->nv - 1;
  hb_v3 p, q, l, k;
  assert_int_equal(hb_project_work_create(c->model, &work, &err), HB_OK);
  for (int i = 0; i < 3 * n; i++) v[i] = rng_normal(r);
  memcpy(v + 3 * n, v, 3 * sizeof *v);
  memcpy(before, v, sizeof v);
  momenta(c, v, &p, &l);
  hb_project_velocities(c->model, c->rod, c->state->x, v, &work);
  momenta(c, v, &q, &k);
  assert_at_most(largest_rate(c, v), 1e-11);
  assert_at_most(hb_v3_norm(hb_v3_sub(p, q)), 1e-12 * (double)n);
  assert_at_most(hb_v3_norm(hb_v3_sub(l, k)), 1e-12 * (double)n);
  assert_memory_equal(v, v + 3 * n, 3 * sizeof *v);
  double work_done = 0, size = 0;
  for (int i = 0; i < 3 * (n + 1); i++) {
    work_done += c->model->mass[i / 3] * (v[i] - before[i]) * v[i];
    size += c->model->mass[i / 3] * before[i] * before[i];
  }
  assert_at_most(fabs(work_done), 1e-11 * size);
  hb_project_work_free(&work);
}

/* And that of places, along either gradient: lengths right, the centre of mass where it was. */
static void places(rod_case *c, rng *r, int kind) {
  (void)kind;
  hb_error err;
  hb_project_work work;
  int n = c->rod->nv - 1;
  assert_int_equal(hb_project_work_create(c->model, &work, &err), HB_OK);
  for (int along = 0; along < 2; along++) {
    double x[ROOM], v[ROOM] = {0}, old[ROOM], lambda[ROOM] = {0};
    hb_v3 p, q, l, k;
    hb_projection result;
    memcpy(old, c->model->initial, 3 * (size_t)(n + 1) * sizeof *old);
    hb_status status = hb_project_positions(c->model, c->rod, old, v, 1, NULL, NULL, &work, &result, &err);
    if (status) continue; /* the initial shape is longer than the rod can be */
    memset(v, 0, sizeof v);
    double unit = 0.01 * c->model->rest_length[0];
    for (int i = 0; i < 3 * n; i++) x[i] = old[i] + unit * rng_normal(r);
    memcpy(x + 3 * n, x, 3 * sizeof *x);
    momenta(c, x, &p, &l);
    assert_int_equal(
        hb_project_positions(c->model, c->rod, x, v, 1, along ? old : NULL, lambda, &work, &result, &err),
        HB_OK);
    momenta(c, x, &q, &k);
    assert_at_most(hb_project_length_error(c->model, c->rod, x), 1e-10);
    assert_at_most(hb_v3_norm(hb_v3_sub(p, q)), 1e-12 * (double)n);
    assert_memory_equal(x, x + 3 * n, 3 * sizeof *x);
    assert_memory_equal(v, v + 3 * n, 3 * sizeof *x);
    assert_true(result.iterations < 12);
  }
  hb_project_work_free(&work);
}

/* Tensions keep the second derivatives of all lengths at 0. */
static void tensions(rod_case *c, rng *r, int kind) {
  (void)kind;
  hb_error err;
  hb_project_work work;
  double v[ROOM], f[ROOM], a[ROOM] = {0}, lambda[ROOM], scale = 0;
  int n = c->rod->nv - 1;
  assert_int_equal(hb_project_work_create(c->model, &work, &err), HB_OK);
  for (int i = 0; i < 3 * n; i++) {
    v[i] = rng_normal(r);
    f[i] = rng_normal(r);
  }
  memcpy(v + 3 * n, v, 3 * sizeof *v);
  memcpy(f + 3 * n, f, 3 * sizeof *f); /* halves of the force on one vertex */
  hb_project_tension(c->model, c->rod, c->state->x, v, f, a, lambda, &work);
  for (int i = 0; i < n; i++) {
    const double *x = c->state->x;
    int before = i > 0 ? i - 1 : n - 1, slot = i > 0 ? i : n;
    hb_v3 total = hb_v3_load(f + 3 * i);
    double mass = c->model->mass[i] * (i > 0 ? 1 : 2);
    if (i == 0) total = hb_v3_scale(2, total);
    hb_v3 pull = hb_v3_scale(2 * lambda[i] * c->model->inv_rest_length[i],
                             hb_v3_sub(hb_v3_load(x + 3 * i + 3), hb_v3_load(x + 3 * i)));
    hb_v3 drag = hb_v3_scale(2 * lambda[before] * c->model->inv_rest_length[before],
                             hb_v3_sub(hb_v3_load(x + 3 * slot), hb_v3_load(x + 3 * slot - 3)));
    hb_v3_store(a + 3 * i, hb_v3_scale(1 / mass, hb_v3_add(total, hb_v3_sub(pull, drag))));
    scale = fmax(scale, hb_v3_norm(pull) / mass);
  }
  memcpy(a + 3 * n, a, 3 * sizeof *a);
  for (int j = 0; j < n; j++) {
    hb_v3 e = hb_v3_sub(hb_v3_load(c->state->x + 3 * j + 3), hb_v3_load(c->state->x + 3 * j));
    hb_v3 rate = hb_v3_sub(hb_v3_load(v + 3 * j + 3), hb_v3_load(v + 3 * j));
    hb_v3 change = hb_v3_sub(hb_v3_load(a + 3 * j + 3), hb_v3_load(a + 3 * j));
    assert_near(hb_v3_dot(e, change) + hb_v3_dot(rate, rate), 0, 1e-11 * (1 + scale));
  }
  hb_project_work_free(&work);
}

/* All three. */
static void test_lengths(void **state) {
  (void)state;
  sweep(17, velocities);
  sweep(18, places);
  sweep(19, tensions);
}

/* ---- runs
 * -------------------------------------------------------------------------------------------------- */

/* A closed rod in motion, between two open ones. */
static void build(hb_scene_def *def, const char *integrator, int kind, bool alone) {
  double ring[ROOM], line[3 * 6];
  int n = 17;
  rng r = rng_start(21);
  scene_begin(def, integrator, 1e-3);
  shape_line(6, 0.5, 0, 0, line);
  if (!alone) scene_velocity(scene_rod(def, 6, line, 0.1, 0.1, 0.1), line);
  random_ring(&r, n, ring);
  hb_rod_def *rod = scene_rod(def, n + 1, ring, 0.1, 0.1, 0.1);
  rod->closing = HB_CLOSING_LINK;
  rod->closing_value = 2;
  rod->straight_rest = kind == ISOTROPIC;
  double v[ROOM];
  for (int k = 0; k < 3 * n; k++) v[k] = 0.5 * rng_normal(&r);
  memcpy(v + 3 * n, v, 3 * sizeof *v);
  scene_velocity(rod, v);
  if (kind != ISOTROPIC) scene_form(rod, 0.1, 0.02, 0.05);
  if (kind == HELD) scene_angle(rod, 4, "0.3*t");
  if (kind == DIRECTED) scene_viscosity(rod, 1e-4);
  if (!alone) scene_clamp_start(scene_rod(def, 6, line, 0.1, 0.1, 0.1));
  scene_force(def, HB_FORCE_GRAVITY, "0", "0", "-0.3");
  hb_force_def *wind = scene_force(def, HB_FORCE_WIND, "0.2*x", "0.1", "0");
  wind->linear[0] = 0.3;
  wind->linear[1] = 0.1;
}

/* Restarted from a block, and beside other rods: the same bits. Lk = Tw + Wr all the time, halves together.
 */
static void test_runs(void **state) {
  (void)state;
  static const char *const schemes[4] = {"verlet", "symplectic-euler", "implicit", "backward-euler"};
  for (int scheme = 0; scheme < 4; scheme++)
    for (int kind = 0; kind < KINDS; kind++) {
      trial a = {0}, b = {0}, lonely = {0};
      hb_error err;
      build(&a.def, schemes[scheme], kind, false);
      build(&b.def, schemes[scheme], kind, false);
      build(&lonely.def, schemes[scheme], kind, true);
      trial_start(&a);
      trial_start(&b);
      trial_start(&lonely);
      trial_run(&a, 60);
      const hb_state *half = hb_sim_const_state(a.sim);
      assert_int_equal(hb_sim_restore(b.sim, half->block, half->count, &err), HB_OK);
      trial_run(&a, 60);
      trial_run(&b, 60);
      trial_run(&lonely, 120);
      const hb_state *s = hb_sim_const_state(a.sim), *own = hb_sim_const_state(lonely.sim);
      assert_true(hb_state_hash(s) == hb_state_hash(hb_sim_const_state(b.sim)));
      const hb_rod *rod = &a.model->rods[1];
      int last = rod->first + rod->nv - 1;
      assert_memory_equal(s->x + 3 * rod->first, own->x, 3 * (size_t)rod->nv * sizeof(double));
      assert_memory_equal(s->v + 3 * rod->first, own->v, 3 * (size_t)rod->nv * sizeof(double));
      assert_memory_equal(s->x + 3 * rod->first, s->x + 3 * last, 3 * sizeof(double));
      assert_memory_equal(s->v + 3 * rod->first, s->v + 3 * last, 3 * sizeof(double));
      const hb_frame *f = trial_measure(&a);
      double twist = 0;
      for (int k = rod->first + 1; k <= last; k++) twist += f->twist[k];
      assert_near(f->theta[last] - f->theta[rod->first], twist, 1e-12);
      double link = twist / (2 * HB_PI) + hb_rod_writhe(s->x + 3 * rod->first, rod->nv - 1, true);
      assert_near(link, 2, 1e-12);
      assert_memory_equal(f->m1 + 3 * rod->first, f->m1 + 3 * last, 3 * sizeof(double));
      trial_end(&a);
      trial_end(&b);
      trial_end(&lonely);
    }
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_complex_step),
                                     cmocka_unit_test(test_differences),
                                     cmocka_unit_test(test_balance),
                                     cmocka_unit_test(test_first_vertex),
                                     cmocka_unit_test(test_placed_otherwise),
                                     cmocka_unit_test(test_at_rest),
                                     cmocka_unit_test(test_open_at_rest),
                                     cmocka_unit_test(test_lengths),
                                     cmocka_unit_test(test_runs)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
