#include "base/memory.h"
#include "math/vec3.h"
#include "model/curve_parts.h"

#include <math.h>
#include <string.h>

/* Samples per piece of the spline, at least. */
#define SAMPLES_PER_PIECE 32

/* Cubic pieces between knots: points and second derivatives there, one entry per knot (a closed spline
 * repeats its first knot at the end). */
typedef struct spline {
  int pieces;
  const double *points; /* 3 (pieces + 1) */
  double *knots;        /* pieces + 1 */
  double *bend;         /* 3 (pieces + 1) second derivatives */
} spline;

/* Piece that holds the parameter p. */
static int find_piece(const spline *s, double p) {
  int low = 0, high = s->pieces - 1;
  while (low < high) {
    int middle = (low + high + 1) / 2;
    if (s->knots[middle] <= p)
      low = middle;
    else
      high = middle - 1;
  }
  return low;
}

/* Place and derivative at parameter p. */
static void spline_at(const void *context, double p, double position[3], double slope[3]) {
  const spline *s = context;
  int k = find_piece(s, p);
  double h = s->knots[k + 1] - s->knots[k], b = (p - s->knots[k]) / h, a = 1 - b;
  const double *y = s->points + 3 * (size_t)k, *m = s->bend + 3 * (size_t)k;
  double cubic_a = -a * b * (1 + a) * h * h / 6, cubic_b = -a * b * (1 + b) * h * h / 6;
  double slope_a = (1 - 3 * a * a) * h / 6, slope_b = (3 * b * b - 1) * h / 6;
  for (int j = 0; j < 3; j++) {
    position[j] = a * y[j] + b * y[j + 3] + cubic_a * m[j] + cubic_b * m[j + 3];
    slope[j] = (y[j + 3] - y[j]) / h + slope_a * m[j] + slope_b * m[j + 3];
  }
}

/* Tridiagonal system: diagonal, next[k] couples k and k + 1 (symmetric); x comes in as the right side, width
 * doubles per row. diagonal is overwritten. The matrices here are diagonally dominant: no pivoting. */
static void solve_tridiagonal(int n, double *diagonal, const double *next, int width, double *x) {
  for (int k = 1; k < n; k++) {
    double factor = next[k - 1] / diagonal[k - 1];
    diagonal[k] -= factor * next[k - 1];
    for (int j = 0; j < width; j++) x[width * k + j] -= factor * x[width * (k - 1) + j];
  }
  for (int k = n - 1; k >= 0; k--)
    for (int j = 0; j < width; j++) {
      if (k < n - 1) x[width * k + j] -= next[k] * x[width * (k + 1) + j];
      x[width * k + j] /= diagonal[k];
    }
}

/* Six times the change of slope at knot k between piece `before` and piece `after`. */
static double slope_change(const spline *s, int before, int after, int j) {
  const double *y = s->points;
  double h0 = s->knots[before + 1] - s->knots[before], h1 = s->knots[after + 1] - s->knots[after];
  double d0 = (y[3 * before + 3 + j] - y[3 * before + j]) / h0,
         d1 = (y[3 * after + 3 + j] - y[3 * after + j]) / h1;
  return 6 * (d1 - d0);
}

/* Second derivatives of the natural spline: 0 at both ends. work: 5 doubles per knot. */
static void bend_natural(spline *s, double *work) {
  int n = s->pieces - 1; /* inner knots */
  double *diagonal = work, *next = work + s->pieces + 1;
  for (int k = 0; k < n; k++) {
    diagonal[k] = 2 * (s->knots[k + 2] - s->knots[k]);
    next[k] = s->knots[k + 2] - s->knots[k + 1];
    for (int j = 0; j < 3; j++) s->bend[3 * (k + 1) + j] = slope_change(s, k, k + 1, j);
  }
  solve_tridiagonal(n, diagonal, next, 3, s->bend + 3);
}

/* Second derivatives of the closed spline: the corner elements of the cyclic system are a rank-one change
 * (Sherman and Morrison); the fourth column of the right side carries its solution. work: 6 doubles per knot.
 */
static void bend_closed(spline *s, double *work) {
  int n = s->pieces; /* knot k is between pieces k - 1 and k, cyclic */
  double *diagonal = work, *next = work + n + 1, *x = work + 2 * (n + 1);
  double corner = s->knots[n] - s->knots[n - 1]; /* couples the knots n - 1 and 0 */
  for (int k = 0; k < n; k++) {
    int before = k > 0 ? k - 1 : n - 1;
    double h0 = s->knots[before + 1] - s->knots[before], h1 = s->knots[k + 1] - s->knots[k];
    diagonal[k] = 2 * (h0 + h1);
    next[k] = h1;
    for (int j = 0; j < 3; j++) x[4 * k + j] = slope_change(s, before, k, j);
    x[4 * k + 3] = 0;
  }
  double gamma = -diagonal[0]; /* splits the corners off without weakening the diagonal */
  diagonal[0] -= gamma;
  diagonal[n - 1] -= corner * corner / gamma;
  x[3] = gamma;
  x[4 * (n - 1) + 3] = corner;
  solve_tridiagonal(n, diagonal, next, 4, x);
  double ratio = corner / gamma, denominator = 1 + x[3] + ratio * x[4 * (n - 1) + 3];
  for (int j = 0; j < 3; j++) {
    double factor = (x[j] + ratio * x[4 * (n - 1) + j]) / denominator;
    for (int k = 0; k < n; k++) s->bend[3 * k + j] = x[4 * k + j] - factor * x[4 * k + 3];
    s->bend[3 * n + j] = s->bend[j];
  }
}

/* Knots at the sums of the square roots of the distances (centripetal: no loops between uneven points). */
static void set_knots(spline *s) {
  s->knots[0] = 0;
  for (int k = 0; k < s->pieces; k++) {
    hb_v3 a = hb_v3_load(s->points + 3 * (size_t)k), b = hb_v3_load(s->points + 3 * (size_t)k + 3);
    s->knots[k + 1] = s->knots[k] + sqrt(hb_v3_norm(hb_v3_sub(b, a)));
  }
}

/* Number of points that count: a closed spline whose last point repeats the first drops it. HB_ERR_INPUT if
 * they do not make a spline. */
static hb_status check_points(const double *points, int *n, bool closed, int count, hb_error *err) {
  int least = closed ? 3 : 2;
  hb_status status = hb_curve_check_count(count, least, err);
  if (status != HB_OK) return status;
  if (closed && *n > 1 && memcmp(points, points + 3 * ((size_t)*n - 1), 3 * sizeof *points) == 0) (*n)--;
  if (*n < least || *n > HB_CURVE_COUNT_MAX / SAMPLES_PER_PIECE)
    return hb_fail(err, HB_ERR_INPUT, "the spline has %d %spoints, allowed are %d to %d", *n,
                   closed ? "different " : "", least, HB_CURVE_COUNT_MAX / SAMPLES_PER_PIECE);
  for (int k = 0; k < *n; k++) {
    const double *p = points + 3 * (size_t)k;
    status = hb_curve_check_finite("a point of the spline", p, 3, err);
    if (status != HB_OK) return status;
    if (k > 0 && p[0] == p[-3] && p[1] == p[-2] && p[2] == p[-1])
      return hb_fail(err, HB_ERR_INPUT, "points %d and %d of the spline coincide at (%g, %g, %g)", k - 1, k,
                     p[0], p[1], p[2]);
  }
  return HB_OK;
}

/* Builds the spline and divides it. memory: 3 + 1 + 3 + 6 doubles per knot. */
hb_status hb_curve_spline(const double *points, int n, bool closed, int count, double *xyz, hb_error *err) {
  hb_status status = check_points(points, &n, closed, count, err);
  if (status != HB_OK) return status;
  size_t knots = (size_t)n + (closed ? 1 : 0);
  double *memory = hb_alloc(13 * knots, sizeof *memory);
  if (!memory) return hb_fail_memory(err, "a spline");
  memcpy(memory, points, 3 * (size_t)n * sizeof *memory);
  if (closed) memcpy(memory + 3 * (size_t)n, points, 3 * sizeof *memory);
  spline s = {(int)knots - 1, memory, memory + 3 * knots, memory + 4 * knots};
  set_knots(&s);
  if (closed)
    bend_closed(&s, memory + 7 * knots);
  else if (s.pieces > 1)
    bend_natural(&s, memory + 7 * knots);
  hb_path path = {spline_at, &s, 0, s.knots[s.pieces]};
  double wanted = fmax(SAMPLES_PER_PIECE * (double)s.pieces, fmin(8.0 * count, HB_CURVE_COUNT_MAX)) + 1;
  status = hb_path_divide(&path, (int)wanted, count, xyz, err);
  if (status == HB_OK) memcpy(xyz + 3 * ((size_t)count - 1), memory + 3 * (knots - 1), 3 * sizeof *xyz);
  hb_free(memory);
  return status;
}
