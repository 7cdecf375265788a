/* Small vectors by value. Pure functions, no memory. */
#ifndef HB_MATH_VEC3_H
#define HB_MATH_VEC3_H

#include <math.h>

typedef struct hb_v3 {
  double x, y, z;
} hb_v3;

/* Vector from three doubles in a row. */
static inline hb_v3 hb_v3_load(const double *p) { return (hb_v3){p[0], p[1], p[2]}; }
/* Vector to three doubles in a row. */
static inline void hb_v3_store(double *p, hb_v3 a) {
  p[0] = a.x;
  p[1] = a.y;
  p[2] = a.z;
}
/* p += a. */
static inline void hb_v3_accumulate(double *p, hb_v3 a) {
  p[0] += a.x;
  p[1] += a.y;
  p[2] += a.z;
}
/* a + b. */
static inline hb_v3 hb_v3_add(hb_v3 a, hb_v3 b) { return (hb_v3){a.x + b.x, a.y + b.y, a.z + b.z}; }
static inline hb_v3 hb_v3_sub(hb_v3 a, hb_v3 b) { return (hb_v3){a.x - b.x, a.y - b.y, a.z - b.z}; }
static inline hb_v3 hb_v3_scale(double s, hb_v3 a) { return (hb_v3){s * a.x, s * a.y, s * a.z}; }
/* a + s b. */
static inline hb_v3 hb_v3_axpy(hb_v3 a, double s, hb_v3 b) {
  return (hb_v3){a.x + s * b.x, a.y + s * b.y, a.z + s * b.z};
}
/* a . b. */
static inline double hb_v3_dot(hb_v3 a, hb_v3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
/* a x b. */
static inline hb_v3 hb_v3_cross(hb_v3 a, hb_v3 b) {
  return (hb_v3){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
/* |a|. */
static inline double hb_v3_norm(hb_v3 a) { return sqrt(hb_v3_dot(a, a)); }
/* a/|a|; the zero vector stays zero. */
static inline hb_v3 hb_v3_unit(hb_v3 a) {
  double n = hb_v3_norm(a);
  return n > 0 ? hb_v3_scale(1 / n, a) : a;
}

#endif
