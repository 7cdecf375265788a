/* What pieces of one rod see of each other: edges beyond the ends of a lane. */
#ifndef HB_LANE_SEAM_H
#define HB_LANE_SEAM_H

#include "lane/lane.h"

/* Edge in row r of a vertex array. */
INLINED v3 edge_of(const lanes *x, int r) { return v3_sub(v3_load(x + 3 * r + 3), v3_load(x + 3 * r)); }

/* The edge before row 0 of each lane; `beyond` where there is none. x_before: the same array of the strip
 * before. */
INLINED v3 edge_before(const hb_strip *s, const lanes *x, const lanes *x_before, v3 beyond) {
  v3 e = edge_of(x, s->rows - 1);
  if (!s->before) return (v3){up(e.x, beyond.x[0]), up(e.y, beyond.y[0]), up(e.z, beyond.z[0])};
  const lanes *p = x_before + 3 * (s->before->rows - 1);
  const int w = HB_LANES - 1;
  return (v3){up(e.x, p[3][w] - p[0][w]), up(e.y, p[4][w] - p[1][w]), up(e.z, p[5][w] - p[2][w])};
}

/* The edge behind the last row of each lane. */
INLINED v3 edge_behind(const hb_strip *s, const lanes *x, const lanes *x_after, v3 beyond) {
  v3 e = edge_of(x, 0);
  const lanes *p = x_after;
  if (!s->after) return (v3){down(e.x, beyond.x[0]), down(e.y, beyond.y[0]), down(e.z, beyond.z[0])};
  return (v3){down(e.x, p[3][0] - p[0][0]), down(e.y, p[4][0] - p[1][0]), down(e.z, p[5][0] - p[2][0])};
}

/* Lanes that have an edge in row r. */
INLINED lane_mask real_edges(const hb_strip *s, int r) { return *(const lanes *)s->count > all((hb_real)r); }

/* A unit vector along x in every lane: the direction of phantom edges. */
INLINED v3 some_direction(void) { return (v3){all(1), none(), none()}; }

#endif
