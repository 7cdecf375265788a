#include "math/banded.h"

#include <math.h>
#include <string.h>

/* Bandwidths of the matrices of statics; loops over a constant number of entries are unrolled. */
#define KKT_HALF 12
#define SLIM_HALF 10
/* Each use has a constant bandwidth; only inlined is it compiled for it. */
#define INLINED static inline __attribute__((always_inline))

/* With the room that elimination may overrun. */
size_t hb_band_size(int n, int half) { return (size_t)(half + 1) * (size_t)(n + half); }

/* Clears the room behind the last column too. */
void hb_band_clear(hb_band *m) { memset(m->a, 0, hb_band_size(m->n, m->half) * sizeof *m->a); }

/* Column by column, each entry for itself and for its mirror. */
void hb_band_multiply(const hb_band *m, const double *v, double *out) {
  memset(out, 0, (size_t)m->n * sizeof *out);
  for (int j = 0; j < m->n; j++) {
    const double *column = m->a + (size_t)(m->half + 1) * (size_t)j;
    int reach = m->n - 1 - j < m->half ? m->n - 1 - j : m->half;
    double sum = column[0] * v[j];
    for (int k = 1; k <= reach; k++) {
      sum += column[k] * v[j + k];
      out[j + k] += column[k] * v[j];
    }
    out[j] += sum;
  }
}

/* Column after column; what is subtracted from later columns is contiguous. Entries behind the end are zero,
 * and stay so. */
INLINED hb_inertia factor(hb_band *m, int half, double round_off, double *scale) {
  hb_inertia found = {0, 0, 0, 1};
  size_t width = (size_t)half + 1;
  for (int j = 0; j < m->n; j++) scale[j] = fabs(m->a[width * (size_t)j]);
  for (int j = 0; j < m->n; j++) {
    double *restrict column = m->a + width * (size_t)j, pivot = column[0];
    if (!(fabs(pivot) > round_off * scale[j])) {
      found.dropped++;
      for (int k = 0; k <= half; k++) column[k] = 0;
      continue;
    }
    if (fabs(pivot) * found.growth < scale[j]) found.growth = scale[j] / fabs(pivot);
    if (pivot > 0)
      found.positive++;
    else
      found.negative++;
    double inv = 1 / pivot;
    for (int k = 1; k <= half; k++) {
      double ratio = column[k] * inv;
      if (ratio == 0) continue;
      double *restrict later = column + width * (size_t)k;
      scale[j + k] += fabs(ratio * column[k]);
      for (int q = 0; q <= half - k; q++) later[q] -= ratio * column[k + q];
    }
    column[0] = inv;
    for (int k = 1; k <= half; k++) column[k] *= inv;
  }
  return found;
}

/* Forwards through L, by D, backwards through L^T. */
INLINED void solve(const hb_band *m, int half, double *restrict b) {
  size_t width = (size_t)half + 1;
  for (int k = 0; k < half; k++) b[m->n + k] = 0;
  for (int j = 0; j < m->n; j++) {
    const double *restrict column = m->a + width * (size_t)j;
    double now = b[j];
    for (int k = 1; k <= half; k++) b[j + k] -= column[k] * now;
  }
  for (int k = 0; k < half; k++) b[m->n + k] = 0;
  for (int j = m->n - 1; j >= 0; j--) {
    const double *restrict column = m->a + width * (size_t)j;
    double even = column[0] * b[j], odd = 0;
    int k = 1;
    for (; k + 1 <= half; k += 2) {
      even -= column[k] * b[j + k];
      odd -= column[k + 1] * b[j + k + 1];
    }
    if (k <= half) even -= column[k] * b[j + k];
    b[j] = even + odd;
  }
}

/* The common bandwidths are compiled for themselves. */
hb_inertia hb_band_factor(hb_band *m, double round_off, double *scratch) {
  memset(scratch, 0, (size_t)(m->n + m->half) * sizeof *scratch);
  if (m->half == KKT_HALF) return factor(m, KKT_HALF, round_off, scratch);
  if (m->half == SLIM_HALF) return factor(m, SLIM_HALF, round_off, scratch);
  return factor(m, m->half, round_off, scratch);
}

/* Likewise. */
void hb_band_solve(const hb_band *factors, double *b) {
  if (factors->half == KKT_HALF)
    solve(factors, KKT_HALF, b);
  else if (factors->half == SLIM_HALF)
    solve(factors, SLIM_HALF, b);
  else
    solve(factors, factors->half, b);
}
