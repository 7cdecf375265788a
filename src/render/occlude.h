/* What stands in the light: the key lamp's soft shadow, and how much of the sky a point on a tube sees. */
#ifndef HB_RENDER_OCCLUDE_H
#define HB_RENDER_OCCLUDE_H

#include "render/strand.h"

/* Angles around a tube at which the light is worked out. */
enum { HB_AROUND = 12 };

/* A straight stretch of tube that keeps light away. */
typedef struct hb_blocker {
  hb_v3 a, ab; /* camera space */
  double length, radius;
} hb_blocker;

/* Blockers sorted into buckets: those of bucket k are item[start[k]] .. item[start[k + 1] - 1]. */
typedef struct hb_buckets {
  int *start, *item;
  int count;
} hb_buckets;

typedef struct hb_occlusion {
  hb_v3 key, e1, e2; /* towards the lamp; two directions across */
  hb_blocker *blocker;
  int blocker_count;
  double soft, most_soft, least_soft; /* half width of a shadow's edge: per distance; limits */
  double x0, y0, cell;                /* the plane across the light, in cells */
  int nx, ny;
  hb_buckets plane;        /* blockers whose shadow touches a cell */
  double reach, hash_cell; /* sky: how far a blocker counts */
  hb_buckets space;        /* blockers by the hash of the cell of their middle */
  float *sky, *sun;        /* per node and angle around it: 1 open, 0 dark */
} hb_occlusion;

/* key: unit vector towards the lamp, camera space. pixel: size of a pixel in the scene. */
hb_status hb_occlusion_make(const hb_strands *strands, hb_v3 key, double pixel, hb_occlusion *out,
                            hb_error *err);
void hb_occlusion_free(hb_occlusion *occlusion);
/* Share of the lamp that a point sees, 0..1; own: radius of the tube that the point is on, 0: not on a tube.
 */
double hb_occlusion_sun(const hb_occlusion *occlusion, hb_v3 p, double own);
/* Place of the direction (x, y) on a square instead of a circle, 0 <= place < HB_AROUND: no arc tangent. */
double hb_around(double x, double y);

#endif
