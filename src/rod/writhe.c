/* Writhe as a sum over pairs of edges (Banchoff 1976; Klenin and Langowski 2000): the directions in which one
 * edge sees the other cover a spherical quadrilateral; its signed area over 4 pi is the pair's share, counted
 * twice. */
#include "rod/writhe.h"

#include "math/rotation.h"

/* Signed area of the spherical triangle of directions a, b, c, whatever their lengths (Van Oosterom and
 * Strackee 1983). */
static double triangle(hb_v3 a, hb_v3 b, hb_v3 c) {
  double la = hb_v3_norm(a), lb = hb_v3_norm(b), lc = hb_v3_norm(c);
  double below = la * lb * lc + hb_v3_dot(a, b) * lc + hb_v3_dot(b, c) * la + hb_v3_dot(c, a) * lb;
  return 2 * atan2(hb_v3_dot(a, hb_v3_cross(b, c)), below);
}

/* Area of the quadrilateral that the edges a0 a1 and b0 b1 see of each other. */
static double seen_area(hb_v3 a0, hb_v3 a1, hb_v3 b0, hb_v3 b1) {
  hb_v3 p = hb_v3_sub(b0, a0), q = hb_v3_sub(b1, a0), r = hb_v3_sub(b1, a1), s = hb_v3_sub(b0, a1);
  return triangle(p, r, q) + triangle(p, s, r);
}

/* All pairs of edges that have no vertex in common; neighbours lie in one plane and see nothing of each
 * other. */
double hb_rod_writhe(const double *x, int nv, bool closed) {
  int edges = closed ? nv : nv - 1;
  double sum = 0;
  for (int i = 0; i < edges; i++) {
    hb_v3 a0 = hb_v3_load(x + 3 * i), a1 = hb_v3_load(x + 3 * ((i + 1) % nv));
    for (int j = i + 2; j < edges; j++) {
      if (closed && i == 0 && j == edges - 1) continue;
      sum += seen_area(a0, a1, hb_v3_load(x + 3 * j), hb_v3_load(x + 3 * ((j + 1) % nv)));
    }
  }
  return sum / (2 * HB_PI);
}
