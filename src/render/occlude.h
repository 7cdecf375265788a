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

/* Shadows that fall from a stretch of heights above a point: the plane across the light, in cells. */
typedef struct hb_layer {
  double top;   /* heights end here */
  double reach; /* no shadow from there is wider than this, either way */
  double x0, y0, cell;
  int nx, ny;
  hb_buckets plane; /* blockers whose shadow touches a cell, by the height of their upper end */
} hb_layer;
enum { HB_LAYERS = 3 };

typedef struct hb_occlusion {
  const hb_strands *strands;
  hb_v3 key, e1, e2;   /* towards the lamp; two directions across */
  hb_blocker *blocker; /* in the order of the nodes */
  hb_blocker *lit;     /* x, y, z along e1, e2, key; sorted by the height of their upper ends */
  int blocker_count;
  double span;                        /* difference in height of a blocker's ends, at most */
  double soft, most_soft, least_soft; /* half width of a shadow's edge: per distance; limits */
  hb_layer layer[HB_LAYERS];          /* each one four times as high as the one before */
  double reach, hash_cell;            /* sky: how far a blocker counts */
  hb_buckets space;                   /* blockers by the hash of the cell of their middle */
  float *sky, *sun; /* per node and angle around it: 1 open, 0 dark, below 0 not worked out yet */
} hb_occlusion;

/* key: unit vector towards the lamp, camera space. pixel: size of a pixel in the scene. The strands stay in
 * use. */
hb_status hb_occlusion_make(const hb_strands *strands, hb_v3 key, double pixel, hb_occlusion *out,
                            hb_error *err);
void hb_occlusion_free(hb_occlusion *occlusion);
/* Share of the lamp that a point sees, 0..1; own: radius of the tube that the point is on, 0: not on a tube.
 */
double hb_occlusion_sun(const hb_occlusion *occlusion, hb_v3 p, double own);
/* Share of the sky and of the lamp at a node and one of the angles around it, 0 <= angle < HB_AROUND. They
 * are worked out when somebody asks for the first time: most of a thicket is never seen. */
double hb_occlusion_node_sky(const hb_occlusion *occlusion, int node, int angle);
double hb_occlusion_node_sun(const hb_occlusion *occlusion, int node, int angle);
/* Place of the direction (x, y) on a square instead of a circle, 0 <= place < HB_AROUND: no arc tangent. */
double hb_around(double x, double y);

#endif
