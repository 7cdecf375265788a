/* Axes and scale bar over a finished picture. */
#include "render/tripod.h"

#include "render/lens.h"

#include <stdio.h>

static const unsigned char ink[3] = {70, 72, 78};
static const unsigned char axis_color[3][3] = {{186, 73, 58}, {72, 128, 72}, {52, 98, 168}};

/* One axis from the middle of the tripod, with its letter beyond the end. */
static void draw_axis(hb_image *image, const hb_lens *lens, int axis, int scale, const double middle[2]) {
  const hb_rect all = {0, 0, image->width, image->height};
  const hb_v3 unit[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  const char letter[2] = {"xyz"[axis], 0};
  double arm = 20.0 * scale, gap = 7.0 * scale;
  double dx = hb_v3_dot(unit[axis], lens->right), dy = hb_v3_dot(unit[axis], lens->down);
  const double end[2] = {middle[0] + arm * dx, middle[1] + arm * dy};
  hb_draw_line(image, all, middle, end, 1.3 * scale, axis_color[axis]);
  double n = sqrt(dx * dx + dy * dy);
  if (n > 0.2) { /* one that leads towards the eye has its letter aside */
    dx /= n;
    dy /= n;
  } else {
    dx = -0.7;
    dy = 0.7;
  }
  double x = end[0] + gap * dx - 0.5 * hb_text_width(letter, scale);
  double y = end[1] + gap * dy - 0.5 * HB_TEXT_CAP * scale;
  hb_image_text(image, (int)floor(x + 0.5), (int)floor(y + 0.5), scale, axis_color[axis], letter);
}

/* A bar of a round length, about an eighth of the picture wide. */
static void draw_bar(hb_image *image, const hb_lens *lens, int scale) {
  double length = hb_tick_step(image->width * lens->unit, 10);
  int width = (int)(length * lens->focal + 0.5), thick = scale;
  int x = image->width - 10 * scale - width, y = image->height - 10 * scale;
  char text[32];
  hb_tick_text(text, sizeof text, length, length);
  hb_draw_rect(image, (hb_rect){x, y, width, thick}, ink);
  hb_draw_rect(image, (hb_rect){x, y - 2 * scale, thick, 4 * scale + thick}, ink);
  hb_draw_rect(image, (hb_rect){x + width - thick, y - 2 * scale, thick, 4 * scale + thick}, ink);
  int left = x + (width - hb_text_width(text, scale)) / 2,
      most = image->width - hb_text_width(text, scale) - 1;
  hb_image_text(image, left < most ? left : most, y - 11 * scale, scale, ink, text);
}

/* The axes that lead away from the eye first. */
void hb_render_tripod(hb_image *image, const hb_camera *camera, int scale, int left, int bottom) {
  hb_lens lens;
  hb_lens_make(camera, (hb_rect){0, 0, image->width, image->height}, &lens);
  const double depth[3] = {lens.forward.x, lens.forward.y, lens.forward.z};
  const double middle[2] = {left, image->height - bottom};
  int order[3] = {0, 1, 2};
  for (int i = 0; i < 2; i++)
    for (int j = 0; j < 2 - i; j++)
      if (depth[order[j]] < depth[order[j + 1]]) {
        int swap = order[j];
        order[j] = order[j + 1];
        order[j + 1] = swap;
      }
  for (int i = 0; i < 3; i++) draw_axis(image, &lens, order[i], scale, middle);
  if (camera->orthographic) draw_bar(image, &lens, scale);
}
