/* Tangents and lengths of the polyline (docs/theory, 2.1). */
#include "rod/rod.h"

#include "math/rotation.h"

/* t^j = e^j/|e^j| and 1/|e^j|. */
bool hb_rod_geometry(const hb_rod *rod, const double *x, hb_rod_work *work) {
  const double *p = x + 3 * (size_t)rod->first;
  double sum = 0;
  for (int j = 0; j + 1 < rod->nv; j++, p += 3) {
    hb_v3 e = {p[3] - p[0], p[4] - p[1], p[5] - p[2]};
    double inv = 1 / sqrt(hb_v3_dot(e, e));
    work->inv_length[j] = inv;
    work->tangent[3 * j] = inv * e.x;
    work->tangent[3 * j + 1] = inv * e.y;
    work->tangent[3 * j + 2] = inv * e.z;
    sum += inv;
  }
  if (rod->closed) { /* behind the last edge comes the first */
    int n = rod->nv - 1;
    work->inv_length[n] = work->inv_length[0];
    for (int c = 0; c < 3; c++) work->tangent[3 * n + c] = work->tangent[c];
  }
  return isfinite(sum) && sum > 0;
}

/* First vertex whose edges are opposite to within HB_FOLD_LIMIT. */
int hb_rod_find_fold(const hb_rod *rod, const hb_rod_work *work) {
  for (int i = 1; i <= rod->last_joint; i++) {
    double c = hb_v3_dot(hb_v3_load(work->tangent + 3 * i - 3), hb_v3_load(work->tangent + 3 * i));
    if (!(1 + c > HB_FOLD_LIMIT)) return i;
  }
  return -1;
}
