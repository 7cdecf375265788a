/* What a single view needs to be read: which way the axes lead, and how long things are. */
#ifndef HB_RENDER_TRIPOD_H
#define HB_RENDER_TRIPOD_H

#include "hebra/render.h"

/* Draws the three axes with their letters around a point `left` pixels from the left and `bottom` pixels from
 * the bottom of the picture, and, if the camera is parallel, a scale bar in the lower right corner. scale:
 * that of the text, >= 1. */
void hb_render_tripod(hb_image *image, const hb_camera *camera, int scale, int left, int bottom);

#endif
