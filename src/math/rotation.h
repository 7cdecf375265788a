/* Rotations and parallel transport, in half-angle algebra: no sines, no cosines, except for prescribed
 * angles.
 *
 * The rotation P that takes the unit tangent a to the unit tangent b about a x b is the unit quaternion along
 * (1 + a.b, a x b); it is not defined for b = -a (Bergou et al. 2008, section 4). */
#ifndef HB_MATH_ROTATION_H
#define HB_MATH_ROTATION_H

#include "math/vec3.h"

#define HB_PI 3.14159265358979323846
/* Below this value of 1 + a.b two tangents count as opposite: within 1e-5 rad of a fold. */
#define HB_FOLD_LIMIT 5e-11

/* Quaternion w + (x, y, z), not normalised. */
typedef struct hb_quat {
  double w;
  hb_v3 v;
} hb_quat;

/* Product a b: first b, then a. */
static inline hb_quat hb_quat_mul(hb_quat a, hb_quat b) {
  hb_v3 c = hb_v3_cross(a.v, b.v);
  return (hb_quat){
      a.w * b.w - hb_v3_dot(a.v, b.v),
      {a.w * b.v.x + b.w * a.v.x + c.x, a.w * b.v.y + b.w * a.v.y + c.y, a.w * b.v.z + b.w * a.v.z + c.z}};
}

/* Rotates p by q, whatever the norm of q (> 0). */
static inline hb_v3 hb_quat_rotate(hb_quat q, hb_v3 p) {
  double s = 2 / (q.w * q.w + hb_v3_dot(q.v, q.v));
  hb_v3 c = hb_v3_cross(q.v, p);
  hb_v3 d = hb_v3_cross(q.v, c);
  return (hb_v3){p.x + s * (q.w * c.x + d.x), p.y + s * (q.w * c.y + d.y), p.z + s * (q.w * c.z + d.z)};
}

/* Some unit vector normal to the unit vector t: the coordinate axis farthest from t, projected. */
static inline hb_v3 hb_any_normal(hb_v3 t) {
  double ax = fabs(t.x), ay = fabs(t.y), az = fabs(t.z);
  hb_v3 axis = {0, 0, 0};
  if (az <= ax && az <= ay)
    axis.z = 1;
  else if (ay <= ax)
    axis.y = 1;
  else
    axis.x = 1;
  return hb_v3_unit(hb_v3_axpy(axis, -hb_v3_dot(axis, t), t));
}

/* Component of d normal to the unit vector t, normalised; some normal of t if d is along t. */
static inline hb_v3 hb_project_normal(hb_v3 d, hb_v3 t) {
  hb_v3 p = hb_v3_axpy(d, -hb_v3_dot(d, t), t);
  double n = hb_v3_norm(p);
  return n > 1e-9 * hb_v3_norm(d) && n > 0 ? hb_v3_scale(1 / n, p) : hb_any_normal(t);
}

/* Parallel transport of d (normal to a) from tangent a to tangent b. Where it is undefined d is kept, made
 * normal to b: for b = -a every d normal to a is normal to b, and keeping it is the limit along one of the
 * folds. */
static inline hb_v3 hb_transport(hb_v3 d, hb_v3 a, hb_v3 b) {
  double chi = 1 + hb_v3_dot(a, b);
  if (!(chi > HB_FOLD_LIMIT)) return hb_project_normal(d, b);
  double s = hb_v3_dot(d, b) / chi;
  return (hb_v3){d.x - s * (a.x + b.x), d.y - s * (a.y + b.y), d.z - s * (a.z + b.z)};
}

/* The same, with the round-off of norm and normality taken out, for directors that are carried for many
 * steps. */
static inline hb_v3 hb_carry(hb_v3 d, hb_v3 a, hb_v3 b) {
  hb_v3 r = hb_transport(d, a, b);
  r = hb_v3_axpy(r, -hb_v3_dot(r, b), b);
  return hb_v3_scale(1.5 - 0.5 * hb_v3_dot(r, r), r);
}

/* d (normal to the unit vector t) turned about t by angle. */
static inline hb_v3 hb_turn(hb_v3 d, hb_v3 t, double angle) {
  if (angle == 0) return d;
  double c = cos(angle), s = sin(angle);
  hb_v3 n = hb_v3_cross(t, d);
  return (hb_v3){c * d.x + s * n.x, c * d.y + s * n.y, c * d.z + s * n.z};
}

/* Angle from a to b about t, in (-pi, pi]; a, b normal to t. */
static inline double hb_angle_about(hb_v3 a, hb_v3 b, hb_v3 t) {
  return atan2(hb_v3_dot(hb_v3_cross(a, b), t), hb_v3_dot(a, b));
}

/* The value equal to angle modulo 2 pi that is nearest to target: how windings are counted. */
static inline double hb_nearest_angle(double angle, double target) {
  return angle + 2 * HB_PI * rint((target - angle) / (2 * HB_PI));
}

#endif
