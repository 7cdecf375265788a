/* The softest modes of an equilibrium, and those that cost nothing because the rod moves as a whole
 * (docs/theory, 16.5). */
#include "statics/branch.h"

#include "math/vec3.h"

#include <float.h>
#include <math.h>
#include <string.h>

#define ROUNDS 80
/* Stiffnesses have converged if they change by less, relative to the largest of them or to the least that can
 * be told from 0. */
#define STEADY 1e-9
#define BLURRED 0.02
/* A rotation of the rod's length by round-off. */
#define NOTHING 1e-9

enum { ROLL = 6 }; /* every frame about its own tangent; before: three shifts, three rotations */

/* Jacobi's method. */
void hb_small_eigen(int n, double a[HB_BRANCH_RIGID][HB_BRANCH_RIGID],
                    double vectors[HB_BRANCH_RIGID][HB_BRANCH_RIGID], double *values) {
  for (int i = 0; i < n; i++)
    for (int j = 0; j < n; j++) vectors[i][j] = i == j;
  for (int sweep = 0; sweep < 30; sweep++)
    for (int p = 0; p < n; p++)
      for (int q = p + 1; q < n; q++) {
        if (fabs(a[p][q]) <= 1e-18 * (fabs(a[p][p]) + fabs(a[q][q]))) continue;
        double angle = 0.5 * atan2(2 * a[p][q], a[q][q] - a[p][p]), c = cos(angle), s = sin(angle);
        for (int k = 0; k < n; k++) {
          double x = a[k][p], y = a[k][q];
          a[k][p] = c * x - s * y;
          a[k][q] = s * x + c * y;
        }
        for (int k = 0; k < n; k++) {
          double x = a[p][k], y = a[q][k];
          a[p][k] = c * x - s * y;
          a[q][k] = s * x + c * y;
          x = vectors[k][p], y = vectors[k][q];
          vectors[k][p] = c * x - s * y;
          vectors[k][q] = s * x + c * y;
        }
      }
  for (int i = 0; i < n; i++) { /* ascending */
    int least = i;
    values[i] = a[i][i];
    for (int j = i; j < n; j++)
      if (a[j][j] < a[least][least]) least = j;
    if (least == i) continue;
    double swapped = a[least][least];
    a[least][least] = a[i][i];
    values[i] = a[i][i] = swapped;
    for (int k = 0; k < n; k++) {
      double x = vectors[k][i];
      vectors[k][i] = vectors[k][least];
      vectors[k][least] = x;
    }
  }
}

/* Product in the metric of the modes. */
static double product(const hb_branch *b, const double *x, const double *y) {
  const double *w = b->s.kkt.weight;
  double sum = 0;
  for (int k = 0; k < b->s.kkt.matrix.n; k++) sum += w[k] * x[k] * y[k];
  return sum;
}

/* x += part * y. */
static void add(const hb_branch *b, double *x, double part, const double *y) {
  for (int k = 0; k < b->s.kkt.matrix.n; k++) x[k] += part * y[k];
}

/* x Hessian y; the lengths are kept by both. */
static double stiffness(hb_branch *b, const double *x, const double *y) {
  double sum = 0;
  hb_band_multiply(&b->s.kkt.matrix, y, b->held);
  for (int k = 0; k < b->s.kkt.matrix.n; k++) sum += x[k] * b->held[k];
  return sum;
}

/* Displacement and turn that rigid motion `kind` gives vertex and edge i. */
static void rigid_at(const hb_branch *b, const double center[3], int kind, int i, double out[4]) {
  const double *x = b->s.state->x + 3 * (b->rod->first + i), *next = x + 3;
  hb_v3 axis = {kind % 3 == 0, kind % 3 == 1, kind % 3 == 2}, d = {0, 0, 0}, e = {0, 0, 0};
  if (i + 1 < b->rod->nv) e = hb_v3_unit(hb_v3_sub(hb_v3_load(next), hb_v3_load(x)));
  if (kind < 3) d = axis;
  if (kind >= 3 && kind < ROLL) d = hb_v3_cross(axis, hb_v3_sub(hb_v3_load(x), hb_v3_load(center)));
  hb_v3_store(out, d);
  out[3] = kind == ROLL ? 1 : kind >= 3 && kind < ROLL ? hb_v3_dot(axis, e) : 0;
}

/* Squares of what supports forbid, of all seven motions: 0 on those that they allow. */
static void forbid(const hb_branch *b, const double center[3], double a[HB_BRANCH_RIGID][HB_BRANCH_RIGID]) {
  const hb_model *m = b->s.model;
  double move[HB_BRANCH_RIGID][4];
  memset(a, 0, HB_BRANCH_RIGID * sizeof a[0]);
  for (int i = 0; i < b->rod->nv; i++) {
    int slot = b->rod->first + i;
    bool held = i + 1 < b->rod->nv && m->frame_of[slot] >= 0;
    for (int k = 0; k < HB_BRANCH_RIGID; k++) rigid_at(b, center, k, i, move[k]);
    for (int c = 0; c < 4; c++) {
      if (c < 3 ? m->inv_mass[3 * slot + c] != 0 : !held) continue;
      double length = b->rod->length, unit = c < 3 ? 1 / length : 1;
      for (int k = 0; k < HB_BRANCH_RIGID; k++)
        for (int l = 0; l < HB_BRANCH_RIGID; l++)
          a[k][l] += unit * (k < 3 ? length : 1) * move[k][c] * unit * (l < 3 ? length : 1) * move[l][c];
    }
  }
}

/* One allowed motion as a vector of unknowns. */
static void write_motion(const hb_branch *b, const double center[3], const double *part, double *out) {
  double move[4];
  memset(out, 0, (size_t)b->room * sizeof *out);
  for (int i = 0; i < b->rod->nv; i++)
    for (int kind = 0; kind < HB_BRANCH_RIGID; kind++) {
      rigid_at(b, center, kind, i, move);
      double size = part[kind] * (kind < 3 ? b->rod->length : 1);
      double *to = out + HB_KKT_STRIDE * i;
      for (int c = 0; c < 3; c++) to[c] += size * move[c];
      to[HB_KKT_TURN] += size * move[3];
    }
  for (int k = 0; k < b->s.kkt.matrix.n; k++)
    if (b->s.kkt.weight[k] == 0) out[k] = 0;
}

/* Those of the allowed motions whose energy does not change, or the `most` that change it least: in the span
 * of `count` vectors, which are replaced.
 */
static int keep_neutral(hb_branch *b, int count, int most) {
  double a[HB_BRANCH_RIGID][HB_BRANCH_RIGID], v[HB_BRANCH_RIGID][HB_BRANCH_RIGID], values[HB_BRANCH_RIGID];
  size_t room = (size_t)b->room;
  int kept = 0;
  for (int i = 0; i < count; i++)
    for (int j = 0; j < count; j++) a[i][j] = stiffness(b, b->rigid + i * room, b->rigid + j * room);
  hb_small_eigen(count, a, v, values);
  bool keep[HB_BRANCH_RIGID];
  for (int i = 0; i < count; i++) {
    int softer = 0;
    for (int j = 0; j < count; j++) softer += fabs(values[j]) < fabs(values[i]);
    keep[i] = most < 0 ? fabs(values[i]) <= 4 * b->s.softest : softer < most;
  }
  for (size_t k = 0; k < room; k++) {
    double old[HB_BRANCH_RIGID], now;
    for (int i = 0; i < count; i++) old[i] = b->rigid[i * room + k];
    kept = 0;
    for (int i = 0; i < count; i++) {
      if (!keep[i]) continue;
      now = 0;
      for (int j = 0; j < count; j++) now += old[j] * v[j][i];
      b->rigid[kept++ * room + k] = now;
    }
  }
  return kept;
}

/* Null vectors of what supports forbid, made orthogonal, then tried. */
void hb_branch_find_rigid(hb_branch *b, int most) {
  double a[HB_BRANCH_RIGID][HB_BRANCH_RIGID], v[HB_BRANCH_RIGID][HB_BRANCH_RIGID], values[HB_BRANCH_RIGID];
  double center[3] = {0, 0, 0}, part[HB_BRANCH_RIGID];
  size_t room = (size_t)b->room;
  int count = 0;
  for (int i = 0; i < b->rod->nv; i++)
    for (int c = 0; c < 3; c++) center[c] += b->s.state->x[3 * (b->rod->first + i) + c] / b->rod->nv;
  forbid(b, center, a);
  hb_small_eigen(HB_BRANCH_RIGID, a, v, values);
  for (int k = 0; k < HB_BRANCH_RIGID; k++) {
    if (values[k] > NOTHING * b->rod->nv) continue;
    double *to = b->rigid + count * room;
    for (int i = 0; i < HB_BRANCH_RIGID; i++) part[i] = v[i][k];
    write_motion(b, center, part, to);
    for (int j = 0; j < count; j++) add(b, to, -product(b, to, b->rigid + j * room), b->rigid + j * room);
    double size = sqrt(product(b, to, to));
    if (!(size > NOTHING * sqrt(b->rod->length) * b->rod->length)) continue;
    for (size_t n = 0; n < room; n++) to[n] /= size;
    count++;
  }
  b->rigid_count = count > 0 ? keep_neutral(b, count, most) : 0;
}

/* One round of inverse iteration for every mode, orthogonal to what is known and to one another. */
static void iterate(hb_branch *b, int count) {
  const hb_kkt *kkt = &b->s.kkt;
  size_t room = (size_t)b->room;
  for (int i = 0; i < count; i++) {
    double *v = b->mode + i * room;
    for (int k = 0; k < kkt->matrix.n; k++) v[k] *= kkt->weight[k];
    hb_band_solve(&kkt->factors, v);
    for (int k = 0; k < kkt->matrix.n; k++)
      if (kkt->weight[k] == 0) v[k] = 0;
    for (int twice = 0; twice < 2; twice++) {
      for (int j = 0; j < b->rigid_count; j++)
        add(b, v, -product(b, v, b->rigid + j * room), b->rigid + j * room);
      for (int j = 0; j < i; j++) add(b, v, -product(b, v, b->mode + j * room), b->mode + j * room);
      double size = sqrt(product(b, v, v));
      for (int k = 0; k < kkt->matrix.n; k++) v[k] /= size;
    }
  }
}

/* The best combinations of the modes (Rayleigh and Ritz). */
static void combine(hb_branch *b, int count, double *values) {
  double a[HB_BRANCH_RIGID][HB_BRANCH_RIGID], v[HB_BRANCH_RIGID][HB_BRANCH_RIGID], old[HB_BRANCH_MODES];
  size_t room = (size_t)b->room;
  for (int i = 0; i < count; i++)
    for (int j = 0; j <= i; j++) a[i][j] = a[j][i] = stiffness(b, b->mode + i * room, b->mode + j * room);
  hb_small_eigen(count, a, v, values);
  for (size_t k = 0; k < room; k++) {
    for (int i = 0; i < count; i++) old[i] = b->mode[i * room + k];
    for (int i = 0; i < count; i++) {
      double now = 0;
      for (int j = 0; j < count; j++) now += old[j] * v[j][i];
      b->mode[i * room + k] = now;
    }
  }
}

/* Subspace iteration. */
void hb_branch_softest(hb_branch *b, int count, bool fresh, double *values) {
  const hb_kkt *kkt = &b->s.kkt;
  double last[HB_BRANCH_MODES] = {0};
  for (int i = 0; fresh && i < count; i++)
    for (int k = 0; k < b->room; k++) /* no symmetry in it */
      b->mode[i * b->room + k] =
          k < kkt->matrix.n && kkt->weight[k] != 0
              ? sin(1.0 + i + (0.7 + 0.31 * i) * k) + 0.3 * cos((0.013 + 0.008 * i) * k)
              : 0;
  for (int round = 0; round < ROUNDS; round++) {
    double change = 0, size = 0;
    iterate(b, count);
    combine(b, count, values);
    for (int i = 0; i < count; i++) {
      change = fmax(change, fabs(values[i] - last[i]));
      size = fmax(size, fabs(values[i]));
      last[i] = values[i];
    }
    if (round > 2 && change <= STEADY * size + BLURRED * b->s.softest) break;
  }
}

/* The member is a choice, the same on every machine: motion along one axis, as much as there is. */
bool hb_branch_choose_mode(hb_branch *b, int count) {
  double a[HB_BRANCH_RIGID][HB_BRANCH_RIGID], v[HB_BRANCH_RIGID][HB_BRANCH_RIGID], values[HB_BRANCH_RIGID];
  double best = 0, part[HB_BRANCH_MODES] = {1};
  const double *w = b->s.kkt.weight;
  int axis = 2;
  for (int c = 2; c >= 0; c--) {
    for (int i = 0; i < count; i++)
      for (int j = 0; j < count; j++) {
        a[i][j] = 0;
        for (int k = c; k < b->s.kkt.matrix.n; k += HB_KKT_STRIDE)
          a[i][j] += w[k] * b->mode[i * b->room + k] * b->mode[j * b->room + k];
      }
    hb_small_eigen(count, a, v, values);
    if (values[count - 1] <= 1.01 * best) continue;
    best = values[count - 1];
    axis = c;
    for (int i = 0; i < count; i++) part[i] = v[i][count - 1];
  }
  double most = 0, size = 0;
  for (int k = 0; k < b->room; k++) {
    double now = 0;
    for (int i = 0; i < count; i++) now += part[i] * b->mode[i * b->room + k];
    b->mode[k] = now;
    if (k < b->s.kkt.matrix.n && k % HB_KKT_STRIDE < 3) size += b->metric * w[k] * now * now;
    if (k < b->s.kkt.matrix.n && k % HB_KKT_STRIDE == axis && fabs(now) > 1.0001 * fabs(most)) most = now;
  }
  if (!(size > 0)) return false;
  for (int k = 0; k < b->room; k++) b->mode[k] /= (most < 0 ? -1 : 1) * sqrt(size);
  return true;
}
