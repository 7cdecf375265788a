/* A closed rod's matrix is that of an open one whose slots behind the last vertex are once more the first two
 * vertices. The unknowns of those two, nine columns, are a border: the rest is a band, factored as ever; what
 * is left of the border's own block after elimination is small and dense, and its eigenvalues tell its
 * inertia. */
#include "solve/kkt_ring.h"

#include "base/memory.h"

#include <float.h>
#include <math.h>
#include <string.h>

/* As in kkt.c. */
#define ROUND_OFF (32 * DBL_EPSILON)
enum { B = HB_KKT_BORDER, SWEEPS = 30 };

/* Room. */
hb_status hb_kkt_add_border(hb_kkt *k, hb_error *err) {
  size_t width = (size_t)HB_KKT_STRIDE * (size_t)k->capacity + HB_KKT_HALF, total = 2 * B * width + B * B;
  k->border_block = hb_alloc(total, sizeof *k->border_block);
  if (!k->border_block) return hb_fail_memory(err, "matrix of the equilibrium");
  k->border = k->border_block;
  k->spread = k->border + B * width;
  k->core = k->spread + B * width;
  k->bytes += total * sizeof(double);
  return HB_OK;
}

/* Length of a row of the border. */
static size_t row_width(const hb_kkt *k) { return (size_t)HB_KKT_STRIDE * (size_t)k->capacity + HB_KKT_HALF; }

/* Is it one of the border, as it stands or folded? */
static bool in_border(const hb_kkt *kkt, int k) { return hb_kkt_fold(kkt, k) < B; }

/* Moves every entry that has to do with the border out of the band, which gets rows of the identity there. */
static void take_out(hb_kkt *kkt, double core[B][B]) {
  hb_band *K = &kkt->factors;
  size_t width = (size_t)K->half + 1, row = row_width(kkt);
  int end = K->n + HB_KKT_STRIDE, from = K->n - HB_KKT_STRIDE - K->half;
  memset(kkt->border, 0, B * row * sizeof *kkt->border);
  for (int c = 0; c < end; c++) {
    if (c == B && from > B) c = from; /* nothing between */
    double *column = K->a + width * (size_t)c;
    for (int k = 0; k <= K->half && c + k < end; k++) {
      int r = hb_kkt_fold(kkt, c + k), q = hb_kkt_fold(kkt, c);
      double value = column[k];
      if (r >= B && q >= B) continue;
      column[k] = 0;
      if (r < B && q < B) {
        core[r][q] += value;
        if (k > 0) core[q][r] += value;
      } else if (r < B) {
        kkt->border[row * (size_t)r + (size_t)q] += value;
      } else {
        kkt->border[row * (size_t)q + (size_t)r] += value;
      }
    }
    if (c < K->n && in_border(kkt, c)) column[0] = 1;
  }
}

/* Eigenvalues of a small symmetric matrix by Jacobi's rotations: a becomes diagonal, v its eigenvectors. */
static void diagonalise(double a[B][B], double v[B][B]) {
  for (int p = 0; p < B; p++)
    for (int q = 0; q < B; q++) v[p][q] = p == q;
  for (int sweep = 0; sweep < SWEEPS; sweep++)
    for (int p = 0; p < B; p++)
      for (int q = p + 1; q < B; q++) {
        if (a[p][q] == 0) continue;
        double angle = 0.5 * atan2(2 * a[p][q], a[q][q] - a[p][p]), c = cos(angle), s = sin(angle);
        for (int k = 0; k < B; k++) {
          double x = a[k][p], y = a[k][q];
          a[k][p] = c * x - s * y;
          a[k][q] = s * x + c * y;
        }
        for (int k = 0; k < B; k++) {
          double x = a[p][k], y = a[q][k];
          a[p][k] = c * x - s * y;
          a[q][k] = s * x + c * y;
        }
        for (int k = 0; k < B; k++) {
          double x = v[k][p], y = v[k][q];
          v[k][p] = c * x - s * y;
          v[k][q] = s * x + c * y;
        }
        a[p][q] = a[q][p] = 0;
      }
}

/* Inverts the symmetric matrix; parts of it that are round-off of what it was made of are left out. Rows are
 * of different units: brought to the same size first. Returns the number of negative eigenvalues. */
static int invert(double a[B][B], double made[B][B], double *out) {
  double scale[B], v[B][B], noise[B];
  int negative = 0;
  for (int p = 0; p < B; p++) scale[p] = 1;
  for (int round = 0; round < 8; round++)
    for (int p = 0; p < B; p++) {
      double most = 0;
      for (int q = 0; q < B; q++) most = fmax(most, scale[p] * scale[q] * fabs(made[p][q]));
      if (most > 0) scale[p] /= sqrt(most);
    }
  for (int p = 0; p < B; p++)
    for (int q = 0; q < B; q++) a[p][q] *= scale[p] * scale[q];
  diagonalise(a, v);
  for (int k = 0; k < B; k++) {
    noise[k] = B * ROUND_OFF; /* rows are of size 1 */
    if (fabs(a[k][k]) > noise[k] && a[k][k] < 0) negative++;
  }
  for (int p = 0; p < B; p++)
    for (int q = 0; q < B; q++) {
      double sum = 0;
      for (int k = 0; k < B; k++)
        if (fabs(a[k][k]) > noise[k]) sum += v[p][k] * v[q][k] / a[k][k];
      out[B * p + q] = scale[p] * scale[q] * sum;
    }
  return negative;
}

/* Band, then border. */
int hb_kkt_ring_factor(hb_kkt *k, double shift) {
  size_t width = (size_t)k->matrix.half + 1, row = row_width(k);
  double core[B][B] = {{0}}, made[B][B];
  memcpy(k->factors.a, k->matrix.a, hb_band_size(k->matrix.n, k->matrix.half) * sizeof(double));
  for (int j = 0; j < k->matrix.n; j++) k->factors.a[width * (size_t)j] += shift * k->weight[j];
  take_out(k, core);
  for (int p = 0; p < B; p++) {
    if (k->border_unknown[p]) continue;
    for (int q = 0; q < B; q++) core[p][q] = core[q][p] = p == q;
    memset(k->border + row * (size_t)p, 0, row * sizeof(double));
  }
  hb_inertia found = hb_band_factor(&k->factors, ROUND_OFF, k->scratch);
  memcpy(k->spread, k->border, B * row * sizeof(double));
  for (int p = 0; p < B; p++) hb_band_solve(&k->factors, k->spread + row * (size_t)p);
  for (int p = 0; p < B; p++)
    for (int q = 0; q < B; q++) {
      const double *a = k->border + row * (size_t)p, *b = k->spread + row * (size_t)q;
      made[p][q] = fabs(core[p][q]);
      for (int j = 0; j < k->matrix.n; j++) {
        if (a[j] == 0) continue;
        core[p][q] -= a[j] * b[j];
        made[p][q] += fabs(a[j] * b[j]);
      }
    }
  for (int p = 0; p < B; p++) /* symmetric to the last bit */
    for (int q = 0; q < p; q++) {
      core[p][q] = core[q][p] = 0.5 * (core[p][q] + core[q][p]);
      made[p][q] = made[q][p] = fmax(made[p][q], made[q][p]);
    }
  return found.negative + invert(core, made, k->core);
}

/* Band, border, band. */
void hb_kkt_ring_solve(hb_kkt *k) {
  int n = k->matrix.n, last = n - HB_KKT_STRIDE;
  size_t row = row_width(k);
  double own[B], answer[B], *right = k->right;
  for (int p = 0; p < B; p++) own[p] = right[p];
  for (int j = last; j < n; j++)
    if (in_border(k, j)) own[hb_kkt_fold(k, j)] += right[j];
  for (int j = 0; j < n; j++)
    if (in_border(k, j)) right[j] = 0;
  hb_band_solve(&k->factors, right);
  for (int p = 0; p < B; p++) {
    if (!k->border_unknown[p]) own[p] = 0;
    const double *a = k->border + row * (size_t)p;
    for (int j = B; j < n; j++) own[p] -= a[j] * right[j];
  }
  for (int p = 0; p < B; p++) {
    answer[p] = 0;
    for (int q = 0; q < B; q++) answer[p] += k->core[B * p + q] * own[q];
  }
  for (int p = 0; p < B; p++) {
    const double *b = k->spread + row * (size_t)p;
    for (int j = B; j < n; j++) right[j] -= b[j] * answer[p];
  }
  for (int p = 0; p < B; p++) right[p] = answer[p];
  for (int j = last; j < n; j++)
    if (in_border(k, j)) right[j] = answer[hb_kkt_fold(k, j)];
}

/* The band over one slot more, which has the entries of the second vertex. */
void hb_kkt_ring_multiply(const hb_kkt *kkt, const double *v, double *out) {
  hb_band longer = kkt->matrix;
  int n = kkt->matrix.n;
  double next[HB_KKT_STRIDE], beyond[HB_KKT_STRIDE] = {0};
  for (int k = 0; k < HB_KKT_STRIDE; k++) next[k] = k < 3 ? v[HB_KKT_STRIDE + k] : 0;
  hb_band_multiply(&longer, v, out);
  /* entries of the slot beyond the last, and their mirrors */
  for (int c = n - longer.half; c < n + HB_KKT_STRIDE; c++)
    for (int k = 0; k <= longer.half; k++) {
      int r = c + k;
      if (r < n || r >= n + HB_KKT_STRIDE) continue;
      double value = longer.a[(size_t)(longer.half + 1) * (size_t)c + (size_t)k];
      if (c < n) out[c] += value * next[r - n];
      beyond[r - n] += value * (c < n ? v[c] : next[c - n]);
      if (c >= n && c != r) beyond[c - n] += value * next[r - n];
    }
  for (int k = 0; k < 3; k++) out[HB_KKT_STRIDE + k] += beyond[k];
}
