/* Directors at held edges, HB_LANES_DOUBLE rods at a time: math/rotation.h in lanes (docs/theory, 2.3, 3.2
 * and 10.5). Always in doubles: they are carried for many steps, and there are few of them. */
#ifndef HB_LANE_FRAMES_H
#define HB_LANE_FRAMES_H

#include "lane/general.h"

/* A vector of a director's record. */
INLINED v3 director_part(const double *part) { return v3_load((const lanes *)(const void *)part); }

/* To the edges as they are now. */
static bool carry_directors(hb_lane_director *list, int count) {
  lanes lowest = all(2);
  for (int k = 0; k < count; k++) {
    v3 e = director_part(list[k].e), was = director_part(list[k].t);
    v3 is = v3_scale(R(1) / root(v3_dot(e, e)), e);
    lowest = smaller(R(1) + v3_dot(was, is), lowest);
    v3_store((lanes *)(void *)list[k].d, carried(director_part(list[k].d), was, is));
    v3_store((lanes *)(void *)list[k].t, is);
  }
  return !any(lowest <= all(R(HB_FOLD_LIMIT)));
}

/* Angle from a to b, unit vectors normal to t, about t, nearest to *angle. */
INLINED void nearest_between(v3 a, v3 b, v3 t, double *angle) {
  lanes *at = (lanes *)(void *)angle;
  *at = nearest_angle(angle_of(v3_dot(a, b), v3_dot(v3_cross(a, b), t)), *at);
}

/* The director `from`, turned by the rotation over a panel, against `to`. */
static void panel_twist(const double turn[4 * HB_LANES_DOUBLE], const hb_lane_director *from,
                        const hb_lane_director *to, double twist[HB_LANES_DOUBLE]) {
  const lanes *q = (const lanes *)(const void *)turn;
  v3 axis = v3_load(q + 1), d = director_part(from->d);
  lanes s = R(2) / fused(q[0], q[0], v3_dot(axis, axis));
  v3 c = v3_cross(axis, d);
  v3 turned = v3_axpy(d, s, v3_axpy(v3_cross(axis, c), q[0], c));
  nearest_between(turned, director_part(to->d), director_part(to->t), twist);
}

/* Directors of one edge. */
static void director_angle(const hb_lane_director *from, const hb_lane_director *to,
                           double angle[HB_LANES_DOUBLE]) {
  nearest_between(director_part(from->d), director_part(to->d), director_part(from->t), angle);
}

#endif
