#include "support/energy.h"

#include "base/memory.h"
#include "support/near.h"

#include <string.h>

#define VERTICES_MAX 2048

typedef double complex number;

/* a . b without conjugation: it must stay analytic. */
static number dot(const number a[3], const number b[3]) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

/* a x b */
static void cross(const number a[3], const number b[3], number out[3]) {
  out[0] = a[1] * b[2] - a[2] * b[1];
  out[1] = a[2] * b[0] - a[0] * b[2];
  out[2] = a[0] * b[1] - a[1] * b[0];
}

/* Arc tangent of a number near 0 with an infinitesimal imaginary part, to first order in that. */
static number arc_tangent(number z) {
  double re = creal(z);
  return rod_complex(atan(re), cimag(z) / (1 + re * re));
}

/* Rotation matrix about a x b that takes a to b (Rodrigues; c = a.b, axis times sine = a x b), times d. */
static void rotate(const number a[3], const number b[3], const number d[3], number out[3]) {
  number c = dot(a, b), s[3], sd[3];
  cross(a, b, s);
  cross(s, d, sd);
  number along = dot(s, d) / (1 + c);
  for (int k = 0; k < 3; k++) out[k] = c * d[k] + sd[k] + along * s[k];
}

/* Unit tangent of edge j. */
static void tangent(const number *x, int j, number out[3]) {
  number e[3], n;
  for (int k = 0; k < 3; k++) e[k] = x[3 * j + 3 + k] - x[3 * j + k];
  n = csqrt(dot(e, e));
  for (int k = 0; k < 3; k++) out[k] = e[k] / n;
}

/* d normal to t and of length one. */
static void normalise(const number t[3], const double d[3], number out[3]) {
  number p[3], along = t[0] * d[0] + t[1] * d[1] + t[2] * d[2], n;
  for (int k = 0; k < 3; k++) p[k] = d[k] - along * t[k];
  n = csqrt(dot(p, p));
  for (int k = 0; k < 3; k++) out[k] = p[k] / n;
}

/* u cos angle + (t x u) sin angle. */
static void turn(const number t[3], const number u[3], number angle, number out[3]) {
  number v[3], c = ccos(angle), s = csin(angle);
  cross(t, u, v);
  for (int k = 0; k < 3; k++) out[k] = c * u[k] + s * v[k];
}

/* 2 t x t'/(1 + t.t'). */
static void binormal(const number a[3], const number b[3], number out[3]) {
  cross(a, b, out);
  for (int k = 0; k < 3; k++) out[k] *= 2 / (1 + dot(a, b));
}

/* (kb.m2, -kb.m1). */
static void material(const number kb[3], const number t[3], const number m1[3], number out[2]) {
  number m2[3];
  cross(t, m1, m2);
  out[0] = dot(kb, m2);
  out[1] = -dot(kb, m1);
}

/* So many doubles, all 0. */
static double *zeros(int count) {
  double *a = hb_alloc((size_t)count, sizeof *a);
  assert_non_null(a);
  return a;
}

/* Rest curvatures and twists from the rest shape. */
static void measure_rest(rod_energy *e) {
  const hb_rod_def *def = e->def;
  number x[3 * VERTICES_MAX], t[3], next[3], m1[3], m1_next[3], carried[3], kb[3], w[4], v[3];
  for (int k = 0; k < 3 * e->nv; k++) x[k] = def->rest[k];
  tangent(x, 0, t);
  normalise(t, def->rest_m1 ? def->rest_m1 : def->first_director, m1);
  for (int i = 1; i + 1 < e->nv; i++) {
    tangent(x, i, next);
    rotate(t, next, m1, carried);
    double natural = def->natural_twist ? def->natural_twist[i] * e->voronoi[i] / 2 : 0;
    if (def->rest_m1) {
      normalise(next, def->rest_m1 + 3 * i, m1_next);
      cross(next, carried, v);
      natural += atan2(creal(dot(v, m1_next)), creal(dot(carried, m1_next)));
    } else {
      turn(next, carried, natural, m1_next);
    }
    e->rest_twist[i] = natural;
    binormal(t, next, kb);
    material(kb, t, m1, w);
    material(kb, next, m1_next, w + 2);
    for (int c = 0; c < 4 && !def->straight_rest; c++) e->rest_omega[4 * i + c] = creal(w[c]);
    memcpy(t, next, sizeof t);
    memcpy(m1, m1_next, sizeof m1);
  }
}

/* Lengths, rest curvature and held edges from the definition. */
void rod_energy_create(rod_energy *e, const hb_rod_def *def) {
  int nv = def->nv;
  assert_true(nv <= VERTICES_MAX);
  memset(e, 0, sizeof *e);
  e->def = def;
  e->nv = nv;
  e->voronoi = zeros(nv);
  e->rest_omega = zeros(4 * nv);
  e->rest_twist = zeros(nv);
  e->tangent = zeros(3 * nv);
  e->held_m1 = zeros(3 * nv);
  e->theta = zeros(nv);
  e->solved = zeros(nv);
  e->held = hb_alloc((size_t)nv, sizeof *e->held);
  e->t = hb_alloc(3 * (size_t)nv, sizeof *e->t);
  e->u = hb_alloc(3 * (size_t)nv, sizeof *e->u);
  e->angle = hb_alloc((size_t)nv, sizeof *e->angle);
  e->omega = hb_alloc(4 * (size_t)nv, sizeof *e->omega);
  assert_true(e->held && e->t && e->u && e->angle && e->omega);
  const double *shape = def->lengths_from_initial ? def->initial : def->rest;
  double before = 0;
  for (int j = 0; j + 1 < nv; j++) {
    double length = hypot(hypot(shape[3 * j + 3] - shape[3 * j], shape[3 * j + 4] - shape[3 * j + 1]),
                          shape[3 * j + 5] - shape[3 * j + 2]);
    e->voronoi[j] = j > 0 ? before + length : 0;
    before = length;
  }
  measure_rest(e);
  for (int k = 0; k < def->support_count; k++) {
    const hb_support_def *s = &def->supports[k];
    if (s->kind != HB_SUPPORT_ANGLE && s->kind != HB_SUPPORT_DIRECTOR) continue;
    e->held[s->index < 0 ? s->index + nv - 1 : s->index] = true;
  }
}

/* Frees what create made. */
void rod_energy_free(rod_energy *e) {
  void *all[] = {e->voronoi, e->rest_omega, e->rest_twist, e->tangent, e->held_m1, e->theta,
                 e->solved,  e->held,       e->t,          e->u,       e->angle,   e->omega};
  for (size_t k = 0; k < sizeof all / sizeof all[0]; k++) hb_free(all[k]);
  memset(e, 0, sizeof *e);
}

/* Tangents at x, and Bishop directors from the reference's u0 carried to the first edge. */
static void frames(rod_energy *e, const number *x) {
  number reference[3], u0[3];
  for (int j = 0; j + 1 < e->nv; j++) tangent(x, j, e->t + 3 * j);
  for (int k = 0; k < 3; k++) {
    reference[k] = e->tangent[k];
    u0[k] = e->u0[k];
  }
  rotate(reference, e->t, u0, e->u);
  for (int j = 1; j + 1 < e->nv; j++) rotate(e->t + 3 * j - 3, e->t + 3 * j, e->u + 3 * j - 3, e->u + 3 * j);
}

/* Keeps the reference: tangents, directors, angles. */
void rod_energy_bind(rod_energy *e, const double *x, const double u0[3], const double *theta) {
  number here[3 * VERTICES_MAX];
  for (int k = 0; k < 3 * e->nv; k++) here[k] = x[k];
  memcpy(e->u0, u0, sizeof e->u0);
  memcpy(e->theta, theta, (size_t)(e->nv - 1) * sizeof *theta);
  memcpy(e->solved, theta, (size_t)(e->nv - 1) * sizeof *theta);
  for (int j = 0; j + 1 < e->nv; j++) {
    number t[3];
    tangent(here, j, t);
    for (int k = 0; k < 3; k++) e->tangent[3 * j + k] = creal(t[k]);
  }
  frames(e, here);
  for (int j = 0; j + 1 < e->nv; j++) {
    number m1[3];
    turn(e->t + 3 * j, e->u + 3 * j, theta[j], m1);
    for (int k = 0; k < 3; k++) e->held_m1[3 * j + k] = creal(m1[k]);
  }
}

/* Angle of held edge j now: the reference's, plus how far its carried director has turned against the carried
 * angle. */
static number held_angle(const rod_energy *e, int j) {
  number was_t[3], was_m1[3], m1[3], same[3], across[3];
  for (int k = 0; k < 3; k++) {
    was_t[k] = e->tangent[3 * j + k];
    was_m1[k] = e->held_m1[3 * j + k];
  }
  rotate(was_t, e->t + 3 * j, was_m1, m1);
  turn(e->t + 3 * j, e->u + 3 * j, e->theta[j], same);
  cross(e->t + 3 * j, same, across);
  return e->theta[j] + arc_tangent(dot(m1, across) / dot(m1, same));
}

/* Material curvatures with angles e->angle. */
static void curvatures(rod_energy *e) {
  for (int i = 1; i + 1 < e->nv; i++) {
    number kb[3], m1[3];
    binormal(e->t + 3 * i - 3, e->t + 3 * i, kb);
    for (int side = 0; side < 2; side++) {
      int j = i - 1 + side;
      turn(e->t + 3 * j, e->u + 3 * j, e->angle[j], m1);
      material(kb, e->t + 3 * j, m1, e->omega + 4 * i + 2 * side);
    }
  }
}

/* Section 2 of the theory, term by term. */
static number sum_energy(const rod_energy *e) {
  number sum = 0;
  for (int i = 1; i + 1 < e->nv; i++) {
    number m = e->angle[i] - e->angle[i - 1] - e->rest_twist[i];
    for (int side = 0; side < 2; side++) {
      const double *B = e->def->B + 3 * (i - 1 + side), *rest = e->rest_omega + 4 * i + 2 * side;
      number a = e->omega[4 * i + 2 * side] - rest[0], b = e->omega[4 * i + 2 * side + 1] - rest[1];
      sum += (a * (B[0] * a + B[1] * b) + b * (B[1] * a + B[2] * b)) / (2 * e->voronoi[i]);
    }
    sum += e->def->beta[i] * m * m / e->voronoi[i];
  }
  return sum;
}

/* Frames, angles, curvatures, sum. */
/* Springs along the edges. */
static number stretching(const rod_energy *e, const number *x) {
  const double *rest = e->def->lengths_from_initial ? e->def->initial : e->def->rest;
  number sum = 0;
  for (int j = 0; e->def->stretching && j + 1 < e->nv; j++) {
    number d[3];
    double r[3], length;
    for (int k = 0; k < 3; k++) {
      d[k] = x[3 * j + 3 + k] - x[3 * j + k];
      r[k] = rest[3 * j + 3 + k] - rest[3 * j + k];
    }
    length = sqrt(r[0] * r[0] + r[1] * r[1] + r[2] * r[2]);
    number longer = csqrt(dot(d, d)) - length;
    sum += 0.5 * e->def->stretching[j] / length * longer * longer;
  }
  return sum;
}

/* Everything anew at x. */
number rod_energy_value(rod_energy *e, const number *x, const double *theta) {
  frames(e, x);
  for (int j = 0; j + 1 < e->nv; j++) e->angle[j] = e->held[j] ? held_angle(e, j) : theta[j];
  curvatures(e);
  return sum_energy(e) + stretching(e, x);
}

/* One coordinate moved. */
number rod_energy_moved(rod_energy *e, const double *x, int k, number step) {
  number here[3 * VERTICES_MAX];
  for (int c = 0; c < 3 * e->nv; c++) here[c] = x[c];
  if (k >= 0) here[k] += step;
  return rod_energy_value(e, here, e->theta);
}

/* Material curvature of edge j at vertex i for the angle given, from that for the angle that it was measured
 * at. */
static void turned_omega(const rod_energy *e, const double *theta, int i, int side, double out[2]) {
  int j = i - 1 + side;
  double a = theta[j] - creal(e->angle[j]), c = cos(a), s = sin(a);
  double p = creal(e->omega[4 * i + 2 * side]), q = creal(e->omega[4 * i + 2 * side + 1]);
  out[0] = c * p + s * q; /* d omega/d theta = -J omega */
  out[1] = c * q - s * p;
}

/* omega^T J B (omega - rest)/l and twisting moments, term by term. */
double rod_energy_gradient(const rod_energy *e, const double *theta, double *gradient) {
  double scale = 0;
  memset(gradient, 0, (size_t)(e->nv - 1) * sizeof *gradient);
  for (int i = 1; i + 1 < e->nv; i++) {
    double moment = 2 * e->def->beta[i] * (theta[i] - theta[i - 1] - e->rest_twist[i]) / e->voronoi[i];
    gradient[i] += moment;
    gradient[i - 1] -= moment;
    scale = fmax(scale, 2 * e->def->beta[i] * (fabs(theta[i] - theta[i - 1]) + fabs(e->rest_twist[i])) /
                            e->voronoi[i]);
    for (int side = 0; side < 2; side++) {
      double w[2];
      const double *B = e->def->B + 3 * (i - 1 + side), *rest = e->rest_omega + 4 * i + 2 * side;
      turned_omega(e, theta, i, side, w);
      double a = w[0] - rest[0], b = w[1] - rest[1], p = B[0] * a + B[1] * b, q = B[1] * a + B[2] * b;
      gradient[i - 1 + side] += (w[1] * p - w[0] * q) / e->voronoi[i]; /* omega^T J B (omega - rest) */
      scale = fmax(scale, (fabs(w[1]) + fabs(w[0])) * (fabs(p) + fabs(q)) / e->voronoi[i]);
    }
  }
  return scale;
}

/* Diagonal entries; those beside it are constant. */
void rod_energy_hessian(const rod_energy *e, const double *theta, double *diagonal) {
  memset(diagonal, 0, (size_t)(e->nv - 1) * sizeof *diagonal);
  for (int i = 1; i + 1 < e->nv; i++)
    for (int side = 0; side < 2; side++) {
      double w[2];
      const double *B = e->def->B + 3 * (i - 1 + side), *rest = e->rest_omega + 4 * i + 2 * side;
      turned_omega(e, theta, i, side, w);
      double a = w[0] - rest[0], b = w[1] - rest[1];
      double turned = w[1] * (B[0] * w[1] - B[1] * w[0]) - w[0] * (B[1] * w[1] - B[2] * w[0]);
      double pulled = w[0] * (B[0] * a + B[1] * b) + w[1] * (B[1] * a + B[2] * b);
      diagonal[i - 1 + side] += 2 * e->def->beta[i] / e->voronoi[i] + (turned - pulled) / e->voronoi[i];
    }
}

/* Tridiagonal elimination from the first edge on. */
double rod_energy_newton(rod_energy *e, double *theta) {
  double pivot[VERTICES_MAX], right[VERTICES_MAX], longest = 0;
  int ne = e->nv - 1;
  (void)rod_energy_gradient(e, theta, right);
  rod_energy_hessian(e, theta, pivot);
  for (int j = 0; j < ne; j++) {
    double off = j > 0 && !e->held[j - 1] && !e->held[j] ? -2 * e->def->beta[j] / e->voronoi[j] : 0,
           whole = fabs(pivot[j]);
    right[j] = e->held[j] ? 0 : -right[j];
    if (off != 0 && pivot[j - 1] != 0) {
      right[j] -= off / pivot[j - 1] * right[j - 1];
      pivot[j] -= off / pivot[j - 1] * off;
    }
    if (fabs(pivot[j]) < 1e-11 * whole) pivot[j] = right[j] = 0;
  }
  for (int j = ne - 1; j >= 0; j--) {
    double next = j + 1 < ne && !e->held[j + 1] && !e->held[j]
                      ? -2 * e->def->beta[j + 1] / e->voronoi[j + 1] * right[j + 1]
                      : 0;
    right[j] = e->held[j] || pivot[j] == 0 ? 0 : (right[j] - next) / pivot[j];
    theta[j] += right[j];
    longest = fmax(longest, fabs(right[j]));
  }
  return longest;
}

/* Newton from the reference, at most 40 steps. */
double rod_energy_resolved(rod_energy *e, const double *x, int k, double step) {
  number here[3 * VERTICES_MAX];
  for (int c = 0; c < 3 * e->nv; c++) here[c] = x[c];
  if (k >= 0) here[k] += step;
  memcpy(e->solved, e->theta, (size_t)(e->nv - 1) * sizeof *e->theta);
  (void)rod_energy_value(e, here, e->solved);
  for (int j = 0; j + 1 < e->nv; j++) e->solved[j] = creal(e->angle[j]);
  for (int round = 0; round < 40 && rod_energy_newton(e, e->solved) > 1e-12; round++) {
  }
  return creal(rod_energy_value(e, here, e->solved));
}

/* Ridders: symmetric differences of ever smaller steps, extrapolated; the entry that agrees best with its
 * neighbours. */
double rod_energy_slope(rod_energy *e, const double *x, int k, double step) {
  enum { ROUNDS = 8 };
  double table[ROUNDS][ROUNDS], best = 0, least = HUGE_VAL;
  for (int i = 0; i < ROUNDS; i++, step *= 0.5) {
    double factor = 1;
    table[0][i] = (rod_energy_resolved(e, x, k, step) - rod_energy_resolved(e, x, k, -step)) / (2 * step);
    for (int order = 1; order <= i; order++) {
      factor *= 4;
      table[order][i] = (factor * table[order - 1][i] - table[order - 1][i - 1]) / (factor - 1);
      double doubt =
          fmax(fabs(table[order][i] - table[order - 1][i]), fabs(table[order][i] - table[order - 1][i - 1]));
      if (!(doubt <= least)) continue;
      least = doubt;
      best = table[order][i];
    }
  }
  return best;
}
