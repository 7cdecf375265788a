/* Where the three views look, for all frames of a film. */
#include "hebra/render.h"

#include <math.h>

/* Is the vertex a place that can be drawn? */
static bool usable(const double *p) { return fabs(p[0]) < 1e100 && fabs(p[1]) < 1e100 && fabs(p[2]) < 1e100; }

/* Radius of a tube, 0 where it makes no sense. */
static double radius_of(const hb_tube *tube) {
  return tube->radius > 0 && tube->radius < 1e100 ? tube->radius : 0;
}

/* Nothing seen yet. */
void hb_views_start(hb_views *v) {
  *v = (hb_views){.along = {1, 0, 0}, .across = {0, 1, 0}};
  for (int k = 0; k < 3; k++) {
    v->lo[k] = HUGE_VAL;
    v->hi[k] = -HUGE_VAL;
  }
  v->along_range[0] = v->across_range[0] = HUGE_VAL;
  v->along_range[1] = v->across_range[1] = -HUGE_VAL;
}

/* Box, and sums for the principal direction. */
void hb_views_add(hb_views *v, const hb_tube *tubes, int count) {
  for (int n = 0; n < count; n++) {
    double r = radius_of(&tubes[n]);
    for (int i = 0; i < tubes[n].nv; i++) {
      const double *p = tubes[n].xyz + 3 * (size_t)i;
      if (!usable(p)) continue;
      double d[3];
      if (v->sums[7] == 0)
        for (int k = 0; k < 3; k++) v->origin[k] = p[k];
      for (int k = 0; k < 3; k++) {
        v->lo[k] = fmin(v->lo[k], p[k] - r);
        v->hi[k] = fmax(v->hi[k], p[k] + r);
        d[k] = p[k] - v->origin[k];
        v->sums[k] += d[k];
        v->sums[3 + k] += d[k] * d[k];
      }
      v->sums[6] += d[0] * d[1];
      v->sums[7] += 1;
    }
  }
}

/* Principal direction of a symmetric 2 x 2 matrix a b; b c, by square roots alone. Coordinate axes where the
 * points show no direction (false); exactly a coordinate axis where they nearly lie along it. */
static bool principal(double a, double b, double c, double out[2]) {
  double half = 0.5 * (a - c), root = sqrt(half * half + b * b), mean = 0.5 * (a + c);
  out[0] = 1;
  out[1] = 0;
  if (!(root > 0.12 * mean)) return false; /* round, or nothing */
  double cos2 = half / root, x = sqrt(fmax(0, 0.5 * (1 + cos2))), y = sqrt(fmax(0, 0.5 * (1 - cos2)));
  out[0] = x;
  out[1] = b < 0 ? -y : y;
  if (fabs(y) < 0.1) out[0] = 1, out[1] = 0;
  if (fabs(x) < 0.1) out[0] = 0, out[1] = 1;
  if (fabs(x - y) < 0.02) { /* nearly diagonal is meant diagonal */
    out[0] = 0.7071067811865476;
    out[1] = out[1] < 0 ? -out[0] : out[0];
  }
  return true;
}

/* Directions from the sums. */
bool hb_views_aim(hb_views *v) {
  double n = v->sums[7], axis[2];
  if (!(n > 0)) return false;
  double mx = v->sums[0] / n, my = v->sums[1] / n, mz = v->sums[2] / n;
  double xx = v->sums[3] / n - mx * mx, yy = v->sums[4] / n - my * my, zz = v->sums[5] / n - mz * mz;
  bool found = principal(xx, v->sums[6] / n - mx * my, yy, axis);
  v->along[0] = axis[0];
  v->along[1] = axis[1];
  v->along[2] = 0;
  double sign = axis[1] > 0 ? 1 : -1; /* the first component that is not zero is positive */
  v->across[0] = sign * axis[1];
  v->across[1] = -sign * axis[0];
  v->across[2] = 0;
  v->upright = zz > 2 * (xx + yy);
  return found;
}

/* Extents in the directions chosen. */
void hb_views_measure(hb_views *v, const hb_tube *tubes, int count) {
  for (int n = 0; n < count; n++) {
    double r = radius_of(&tubes[n]);
    for (int i = 0; i < tubes[n].nv; i++) {
      const double *p = tubes[n].xyz + 3 * (size_t)i;
      if (!usable(p)) continue;
      double a = p[0] * v->along[0] + p[1] * v->along[1], c = p[0] * v->across[0] + p[1] * v->across[1];
      v->along_range[0] = fmin(v->along_range[0], a - r);
      v->along_range[1] = fmax(v->along_range[1], a + r);
      v->across_range[0] = fmin(v->across_range[0], c - r);
      v->across_range[1] = fmax(v->across_range[1], c + r);
    }
  }
}
