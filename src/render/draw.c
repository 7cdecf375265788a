/* Flat drawing: rectangles, smooth lines, tick values. */
#include "render/draw.h"

#include <math.h>
#include <stdio.h>

/* The part of a rectangle inside the image. */
static hb_rect inside(const hb_image *image, hb_rect r) {
  int x1 = r.x + r.w, y1 = r.y + r.h;
  if (r.x < 0) r.x = 0;
  if (r.y < 0) r.y = 0;
  if (x1 > image->width) x1 = image->width;
  if (y1 > image->height) y1 = image->height;
  r.w = x1 > r.x ? x1 - r.x : 0;
  r.h = y1 > r.y ? y1 - r.y : 0;
  return r;
}

/* Where a pixel lies in memory. */
static unsigned char *at(hb_image *image, int x, int y) {
  return image->rgb + 3 * ((size_t)y * (size_t)image->width + (size_t)x);
}

/* Fills a rectangle. */
void hb_draw_rect(hb_image *image, hb_rect rect, const unsigned char rgb[3]) {
  hb_rect r = inside(image, rect);
  for (int y = r.y; y < r.y + r.h; y++)
    for (int x = r.x; x < r.x + r.w; x++)
      for (int k = 0; k < 3; k++) at(image, x, y)[k] = rgb[k];
}

/* Four thin rectangles. */
void hb_draw_outline(hb_image *image, hb_rect r, const unsigned char rgb[3]) {
  hb_draw_rect(image, (hb_rect){r.x, r.y, r.w, 1}, rgb);
  hb_draw_rect(image, (hb_rect){r.x, r.y + r.h - 1, r.w, 1}, rgb);
  hb_draw_rect(image, (hb_rect){r.x, r.y, 1, r.h}, rgb);
  hb_draw_rect(image, (hb_rect){r.x + r.w - 1, r.y, 1, r.h}, rgb);
}

/* Coverage from the distance to the line's axis, a pixel-wide ramp at its edge. */
void hb_draw_line(hb_image *image, hb_rect clip, const double a[2], const double b[2], double width,
                  const unsigned char rgb[3]) {
  if (!isfinite(a[0] + a[1] + b[0] + b[1])) return;
  hb_rect r = inside(image, clip);
  double reach = 0.5 * width + 0.5, dx = b[0] - a[0], dy = b[1] - a[1], length = dx * dx + dy * dy;
  double top = fmin(a[1], b[1]) - reach, bottom = fmax(a[1], b[1]) + reach;
  double left = fmin(a[0], b[0]) - reach, right = fmax(a[0], b[0]) + reach;
  int y0 = (int)fmax(r.y, floor(top)), y1 = (int)fmin(r.y + r.h - 1, ceil(bottom));
  for (int y = y0; y <= y1; y++) {
    double x0 = fmax(r.x, floor(left)), x1 = fmin(r.x + r.w - 1, ceil(right));
    if (fabs(dy) > 1e-9 && fabs(dx) > 1e-9) { /* only the pixels near the line in this row */
      double middle = a[0] + (y + 0.5 - a[1]) * dx / dy, spread = (reach + 1) * sqrt(length) / fabs(dy) + 1;
      x0 = fmax(x0, floor(middle - spread));
      x1 = fmin(x1, ceil(middle + spread));
    }
    for (int x = (int)x0; x <= (int)x1; x++) {
      double px = x + 0.5 - a[0], py = y + 0.5 - a[1];
      double s = length > 0 ? (px * dx + py * dy) / length : 0;
      s = s < 0 ? 0 : s > 1 ? 1 : s;
      double ex = px - s * dx, ey = py - s * dy, weight = reach - sqrt(ex * ex + ey * ey);
      if (weight <= 0) continue;
      if (weight > 1) weight = 1;
      if (width < 1) weight *= width;
      unsigned char *p = at(image, x, y);
      for (int k = 0; k < 3; k++) p[k] = (unsigned char)(p[k] + weight * (rgb[k] - p[k]) + 0.5);
    }
  }
}

/* Powers of ten by multiplication: the same bits everywhere. */
double hb_tick_step(double extent, int most) {
  if (!(extent > 1e-280) || !(extent < 1e280)) return 1;
  double least = extent / (most > 1 ? most : 1), step = 1;
  while (step > least) step /= 10;
  while (step * 10 <= least) step *= 10;
  if (step >= least) return step;
  if (step * 2 >= least) return step * 2;
  if (step * 5 >= least) return step * 5;
  return step * 10;
}

/* Six digits tell neighbouring ticks apart in every picture that a person looks at. */
void hb_tick_text(char *text, size_t size, double value, double step) {
  if (fabs(value) < 1e-6 * step) value = 0;
  snprintf(text, size, "%.6g", value);
}
