#include "math/vec3.h"
#include "model/curve_parts.h"

#include <math.h>
#include <string.h>

typedef struct corners {
  const double *points;
  int n;
} corners;

/* Point and direction of a polyline at place p = segment number + fraction. */
static void polyline_at(const void *context, double p, double position[3], double slope[3]) {
  const corners *line = context;
  double whole = floor(p);
  int k = whole < 0 ? 0 : whole > line->n - 2 ? line->n - 2 : (int)whole;
  const double *a = line->points + 3 * (size_t)k, *b = a + 3;
  double f = p - k;
  for (int j = 0; j < 3; j++) {
    slope[j] = b[j] - a[j];
    position[j] = f == 1 ? b[j] : a[j] + f * slope[j];
  }
}

/* Checks, then equal chords on the polyline. */
hb_status hb_curve_resample(const double *points, int n, int count, double *xyz, hb_error *err) {
  if (n < 2)
    return hb_fail(err, HB_ERR_INPUT, "a curve to resample has %d %s, at least 2 are needed", n,
                   n == 1 ? "vertex" : "vertices");
  hb_status status = hb_curve_check_count(n, 2, err);
  if (status == HB_OK) status = hb_curve_check_edges(points, n, err);
  if (status == HB_OK) status = hb_curve_check_count(count, 2, err);
  if (status != HB_OK) return status;
  if (count == 2 && memcmp(points, points + 3 * ((size_t)n - 1), 3 * sizeof *points) == 0)
    return hb_fail(err, HB_ERR_INPUT, "the number of vertices is 2, a closed curve needs at least 3");
  corners line = {points, n};
  hb_path path = {polyline_at, &line, 0, n - 1};
  return hb_path_divide(&path, n, count, xyz, err);
}
