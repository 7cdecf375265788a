/* A camera made ready for a rectangle of pixels.
 *
 * Camera space: x to the right, y down, z away from the eye, lengths as in the scene; right-handed. */
#ifndef HB_RENDER_LENS_H
#define HB_RENDER_LENS_H

#include "hebra/render.h"
#include "math/vec3.h"
#include "render/draw.h"

typedef struct hb_lens {
  hb_v3 eye, right, down, forward; /* in the scene */
  hb_v3 up;                        /* the scene's vertical, in camera space */
  bool orthographic;
  double focal;   /* orthographic: pixels per unit; perspective: pixels per unit at distance 1 */
  double unit;    /* 1 / focal */
  double cx, cy;  /* pixel coordinates of the axis */
  double near;    /* nothing nearer than this is drawn; -HUGE_VAL: no limit */
  double pixel;   /* size of a pixel at the target, in scene units */
  double stretch; /* how much a ball grows at the corner of a perspective picture, >= 1 */
  hb_rect rect;
} hb_lens;

/* Not-a-number and degenerate directions are replaced by something that shows a picture. */
void hb_lens_make(const hb_camera *camera, hb_rect rect, hb_lens *lens);
/* From the scene to camera space. */
hb_v3 hb_lens_look(const hb_lens *lens, hb_v3 p);
/* From camera space to pixel coordinates. */
void hb_lens_pixel(const hb_lens *lens, hb_v3 p, double out[2]);
/* tan(angle), 0 <= angle < 1.5, the same bits with every C library. */
double hb_lens_tan(double angle);

#endif
