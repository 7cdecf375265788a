/* Lanczos's method on the shifted and inverted pencil, with full orthogonalisation (docs/theory, 14.3). */
#include "statics/vibration.h"

#include "base/memory.h"
#include "math/tridiagonal.h"

#include <float.h>
#include <math.h>
#include <string.h>

/* A pair is taken when what is left of it is below this part of its eigenvalue. */
#define TAKEN 1e-11
/* A basis vector below this part of the largest eigenvalue is round-off: the space is exhausted. */
#define EXHAUSTED 1e-13
/* Pairs whose eigenvalue is below this part of the largest have lost too many digits; they are for another
 * shift.
 */
#define WEAK 1e-5
/* Steps between two looks at the pairs. */
#define LOOK 6

/* Inner product with the masses. */
static double product(const hb_vibration *v, const double *a, const double *b) {
  double sum = 0;
  for (int k = 0; k < v->size; k++) sum += v->mass[k] * a[k] * b[k];
  return sum;
}

/* a += factor b. */
static void add(const hb_vibration *v, double *a, double factor, const double *b) {
  for (int k = 0; k < v->size; k++) a[k] += factor * b[k];
}

/* What the rod does under inertial forces of a, by the factors as they are; turns of the frames follow. */
static void apply(hb_vibration *v, const double *a, double *out) {
  double *right = v->statics->kkt.right;
  for (int k = 0; k < v->size; k++) right[k] = v->mass[k] * a[k];
  hb_kkt_solve(&v->statics->kkt);
  memcpy(out, right, (size_t)v->size * sizeof *out);
  v->solves++;
}

/* Takes the parts along what is known out of a, twice: once leaves round-off of what was taken out. */
static void orthogonalise(const hb_vibration *v, double *a, int steps) {
  for (int round = 0; round < 2; round++) {
    for (int k = 0; k < v->found; k++) {
      const double *known = v->vector + (size_t)v->size * (size_t)k;
      add(v, a, -product(v, a, known), known);
    }
    for (int k = 0; k < steps; k++) {
      const double *known = v->basis + (size_t)v->size * (size_t)k;
      add(v, a, -product(v, a, known), known);
    }
  }
}

/* First basis vector: what forces without any order do. False: nothing is left to be found. */
static bool start(hb_vibration *v) {
  uint64_t random = 0x9e3779b97f4a7c15u + (uint64_t)v->solves;
  double *first = v->basis;
  for (int k = 0; k < v->size; k++) {
    random = random * 6364136223846793005u + 1442695040888963407u;
    v->trial[k] = v->mass[k] != 0 ? (double)(random >> 11) / 9007199254740992.0 - 0.5 : 0;
  }
  apply(v, v->trial, first);
  double before = sqrt(product(v, first, first));
  orthogonalise(v, first, 0);
  double size = sqrt(product(v, first, first));
  if (!(size > 1e-12 * before)) return false;
  for (int k = 0; k < v->size; k++) first[k] /= size;
  return true;
}

/* Residual of pair k of `steps`: the size of the next basis vector by the pair's part of the last one. */
static bool good(const hb_vibration *v, int k, double last_part, double next) {
  return fabs(next * last_part) <= TAKEN * fabs(v->ritz[k]) && fabs(v->ritz[k]) >= WEAK * v->strongest;
}

/* How many pairs are good after so many steps. Eigenvalues are left in v->ritz, Q (rows x steps) as in
 * hb_tridiagonal_eigen. */
static int look(hb_vibration *v, int steps, double next, int rows, double *Q) {
  double *beside = v->ritz + v->steps_room;
  memcpy(v->ritz, v->diagonal, (size_t)steps * sizeof *v->ritz);
  memcpy(beside, v->beside, (size_t)steps * sizeof *beside);
  if (!hb_tridiagonal_eigen(steps, v->ritz, beside, rows, Q)) return 0;
  int count = 0;
  v->strongest = 0;
  for (int k = 0; k < steps; k++) v->strongest = fmax(v->strongest, fabs(v->ritz[k]));
  for (int k = 0; k < steps; k++)
    count += good(v, k, Q[(size_t)steps * (size_t)(rows - 1) + (size_t)k], next);
  return count;
}

/* omega^2 by the energy of a vector of mass 1: what the factors say has to agree with it. */
static double energy(const hb_vibration *v, double *a) {
  for (int k = HB_KKT_MULTIPLIER; k < v->size; k += HB_KKT_STRIDE) a[k] = 0;
  hb_kkt_multiply(&v->statics->kkt, a, v->trial);
  double sum = 0;
  for (int k = 0; k < v->size; k++) sum += a[k] * v->trial[k];
  return sum;
}

/* Takes pair k of the basis into the found ones, if it is one. */
static bool take(hb_vibration *v, int k, int steps, double shift, const double *Q, double next) {
  double theta = v->ritz[k], *a = v->vector + (size_t)v->size * (size_t)v->found;
  double part = Q[(size_t)steps * (size_t)(steps - 1) + (size_t)k];
  if (!good(v, k, part, next) || v->found == v->room) return false;
  memset(a, 0, (size_t)v->size * sizeof *a);
  for (int i = 0; i < steps; i++)
    add(v, a, Q[(size_t)steps * (size_t)i + (size_t)k], v->basis + (size_t)v->size * (size_t)i);
  double size = sqrt(product(v, a, a)), square = shift + 1 / theta;
  for (int i = 0; i < v->size; i++) a[i] /= size;
  double allowed = 1e-6 * (fabs(square) + fabs(shift) + v->scale) + 100 * v->round_off;
  if (!(fabs(size - 1) < 1e-6) || !(fabs(energy(v, a) - square) <= allowed)) return false;
  v->square[v->found] = square;
  v->error[v->found] = fabs(next * part) / (theta * theta);
  int at = v->found++;
  for (; at > 0 && v->square[v->order[at - 1]] > square; at--) v->order[at] = v->order[at - 1];
  v->order[at] = v->found - 1;
  return true;
}

/* One run. */
int hb_vibration_lanczos(hb_vibration *v, double shift, int wanted) {
  (void)hb_vibration_count(v, shift); /* factors */
  if (!start(v)) return 0;
  int steps = 0, most = v->freedom - v->found < v->steps_room ? (int)(v->freedom - v->found) : v->steps_room;
  double next = 0, largest = 0, *Q = v->basis + (size_t)v->size * (size_t)(v->steps_room + 1);
  for (;;) {
    const double *now = v->basis + (size_t)v->size * (size_t)steps;
    double *then = v->basis + (size_t)v->size * (size_t)(steps + 1);
    apply(v, now, then);
    v->diagonal[steps] = product(v, now, then);
    steps++;
    orthogonalise(v, then, steps);
    v->beside[steps - 1] = next = sqrt(product(v, then, then));
    largest = fmax(largest, fabs(v->diagonal[steps - 1]));
    if (!isfinite(next)) return 0;
    bool end = steps == most || next <= EXHAUSTED * largest;
    if (!end)
      for (int k = 0; k < v->size; k++) then[k] /= next;
    if (steps % LOOK == 0 && !end) { /* the last row alone tells how good they are */
      memset(Q, 0, (size_t)steps * sizeof *Q);
      Q[steps - 1] = 1;
      end = look(v, steps, next, 1, Q) >= wanted;
    }
    if (end) break;
  }
  memset(Q, 0, (size_t)steps * (size_t)steps * sizeof *Q);
  for (int k = 0; k < steps; k++) Q[(size_t)(steps + 1) * (size_t)k] = 1;
  (void)look(v, steps, next, steps, Q);
  int found = v->found;
  for (int k = 0; k < steps; k++) (void)take(v, k, steps, shift, Q, next);
  return v->found - found;
}

/* Rotates two found modes into each other by the angle that makes the form below vanish between them. */
static void turn_pair(hb_vibration *v, double *a, double *b) {
  double aa = 0, ab = 0, bb = 0;
  for (int k = 0; k < v->size; k++) { /* x, y, z weigh differently */
    double weight = v->mass[k] * (1 + k % HB_KKT_STRIDE);
    aa += weight * a[k] * a[k];
    ab += weight * a[k] * b[k];
    bb += weight * b[k] * b[k];
  }
  double angle = 0.5 * atan2(2 * ab, aa - bb), c = cos(angle), s = sin(angle);
  if (fabs(ab) <= 1e-15 * (aa + bb)) return;
  for (int k = 0; k < v->size; k++) {
    double left = a[k], right = b[k];
    a[k] = c * left + s * right;
    b[k] = c * right - s * left;
  }
}

/* Jacobi's method on the form; any mixture of them is a mode as well. */
void hb_vibration_align(hb_vibration *v, int from, int to) {
  for (int sweep = 0; sweep < 8; sweep++)
    for (int p = from; p < to; p++)
      for (int q = p + 1; q < to; q++)
        turn_pair(v, v->vector + (size_t)v->size * (size_t)v->order[p],
                  v->vector + (size_t)v->size * (size_t)v->order[q]);
}
