/* Light and colour. Intensities are linear; a picture's byte is 255 times the square root. */
#ifndef HB_RENDER_SHADE_H
#define HB_RENDER_SHADE_H

#include "render/occlude.h"
#include "render/raster.h"
#include "render/thicket.h"

typedef struct hb_shading {
  const hb_lens *lens;
  const hb_strands *strands;
  const hb_pieces *pieces;
  const hb_occlusion *occlusion; /* light on single tubes */
  const hb_thicket *thicket;     /* in its place where strands are a thicket, else NULL */
  hb_v3 key, rim, half_key;      /* directions towards the lamps; unit */
} hb_shading;

/* Direction towards the key lamp in camera space: from above, from the left, from the viewer's side. */
hb_v3 hb_key_light(const hb_lens *lens);
/* Where the rim lamp stands, and so on. */
void hb_shading_make(hb_shading *shading);
/* Light from sample k of the tile, that has met a piece; x, y: its pixel coordinates. */
void hb_shade_sample(const hb_shading *shading, const hb_tile *tile, int k, double x, double y,
                     double light[3]);

#endif
