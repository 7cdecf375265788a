/* Stretching of extensible rods: every edge is a spring (docs/theory, 15). Tangents and lengths are those of
 * hb_rod_geometry. */
#include "math/rotation.h"
#include "rod/hessian.h"
#include "rod/rod.h"

/* E A times strain along the edge, towards its middle from both ends. */
void hb_stretch_force(const hb_model *model, const hb_rod *rod, const hb_rod_work *work, double *f) {
  for (int j = 0; rod->extensible && j + 1 < rod->nv; j++) {
    int k = rod->first + j;
    double tension = model->stretching[k] * hb_stretch_strain(model, k, work->inv_length[j]);
    for (int c = 0; c < 3; c++) {
      double pull = tension * work->tangent[3 * j + c];
      f[3 * k + c] += pull;
      f[3 * k + 3 + c] -= pull;
    }
  }
}

/* E A strain^2/2 per rest length. */
double hb_stretch_energy(const hb_model *model, const hb_rod *rod, const hb_rod_work *work) {
  double sum = 0;
  for (int j = 0; rod->extensible && j + 1 < rod->nv; j++) {
    int k = rod->first + j;
    double strain = hb_stretch_strain(model, k, work->inv_length[j]);
    sum += 0.5 * model->stretching[k] * strain * strain * model->rest_length[k];
  }
  return sum;
}

/* E A/rest length along the edge, tension/length across it. */
void hb_stretch_hessian(const hb_model *model, const hb_rod *rod, const hb_rod_work *work, int stride,
                        hb_band *K) {
  for (int j = 0; rod->extensible && j + 1 < rod->nv; j++) {
    int k = rod->first + j, a = stride * j, b = a + stride;
    double inv = work->inv_length[j];
    double across = model->stretching[k] * hb_stretch_strain(model, k, inv) * inv;
    double along = model->stretching[k] * model->inv_rest_length[k] - across;
    const double *t = work->tangent + 3 * j;
    for (int c = 0; c < 3; c++)
      for (int r = 0; r < 3; r++) {
        double value = along * t[c] * t[r] + (c == r ? across : 0);
        hb_band_add(K, b + r, a + c, -value);
        if (r < c) continue;
        hb_band_add(K, a + r, a + c, value);
        hb_band_add(K, b + r, b + c, value);
      }
  }
}
