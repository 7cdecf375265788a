/* QR steps with a shift, one rotation after the other (Francis 1961; Wilkinson 1968). */
#include "math/tridiagonal.h"

#include <float.h>
#include <math.h>

/* The eigenvalue of the last two by two entries that is nearer to the last one. */
static double shift_of(double a, double b, double last) {
  double half = 0.5 * (a - last), root = hypot(half, b);
  return last - (root > 0 ? b * b / (half + (half >= 0 ? root : -root)) : 0);
}

/* Columns k and k + 1 of Q turn into each other. */
static void turn_columns(int n, int rows, double *Q, int k, double c, double s) {
  for (int r = 0; r < rows; r++) {
    double *at = Q + (long)n * r + k, left = at[0], right = at[1];
    at[0] = c * left + s * right;
    at[1] = c * right - s * left;
  }
}

/* One step on entries first .. last: the first rotation is that of the shifted matrix, the others bring the
 * entry that it put beside the band back in. */
static void step(int n, double *d, double *e, int rows, double *Q, int first, int last) {
  double x = d[first] - shift_of(d[last - 1], e[last - 1], d[last]), outside = e[first];
  for (int k = first; k < last; k++) {
    double size = hypot(x, outside), c = size > 0 ? x / size : 1, s = size > 0 ? outside / size : 0;
    if (k > first) e[k - 1] = size;
    double up = d[k], down = d[k + 1], both = e[k];
    d[k] = c * c * up + 2 * c * s * both + s * s * down;
    d[k + 1] = s * s * up - 2 * c * s * both + c * c * down;
    e[k] = c * s * (down - up) + (c * c - s * s) * both;
    turn_columns(n, rows, Q, k, c, s);
    if (k + 1 == last) break;
    x = e[k];
    outside = s * e[k + 1];
    e[k + 1] *= c;
  }
}

/* From the end on: what stands beside the diagonal becomes round-off of its neighbours, entry by entry. */
bool hb_tridiagonal_eigen(int n, double *d, double *e, int rows, double *Q) {
  int rounds = 0;
  for (int last = n - 1; last > 0;) {
    int first = last;
    while (first > 0 && fabs(e[first - 1]) > DBL_EPSILON * (fabs(d[first - 1]) + fabs(d[first]))) first--;
    if (first == last) {
      last--;
      rounds = 0;
      continue;
    }
    if (++rounds > 60) return false;
    step(n, d, e, rows, Q, first, last);
  }
  return true;
}
