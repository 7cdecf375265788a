/* Flat drawing for frames around the pictures: text, smooth lines, panels, ticks. */
#ifndef HB_RENDER_DRAW_H
#define HB_RENDER_DRAW_H

#include "hebra/render.h"

/* Size of a character's cell at scale 1: five columns and a gap; seven rows, two for descenders. */
enum { HB_TEXT_ADVANCE = 6, HB_TEXT_CAP = 7, HB_TEXT_HEIGHT = 9 };

typedef struct hb_rect {
  int x, y, w, h;
} hb_rect;

/* Width in pixels of a text. */
int hb_text_width(const char *text, int scale);
/* Fills the part of the rectangle that lies inside the image. */
void hb_draw_rect(hb_image *image, hb_rect rect, const unsigned char rgb[3]);
/* Outline one pixel wide, inside the rectangle. */
void hb_draw_outline(hb_image *image, hb_rect rect, const unsigned char rgb[3]);
/* Smooth line from a to b (pixel coordinates), `width` pixels wide, clipped to rect. Not-a-number draws
 * nothing. */
void hb_draw_line(hb_image *image, hb_rect clip, const double a[2], const double b[2], double width,
                  const unsigned char rgb[3]);

/* A step of 1, 2 or 5 times a power of ten with at most `most` steps in an extent (> 0). */
double hb_tick_step(double extent, int most);
/* Text of a tick: short, without a minus sign before zero. */
void hb_tick_text(char *text, size_t size, double value, double step);

#endif
