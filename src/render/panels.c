/* The picture with three views: two flat ones with axes, and one in perspective over a grid on the floor. */
#include "hebra/render.h"

#include "render/lens.h"

#include <stdio.h>

static const unsigned char page_color[3] = {241, 239, 234}, panel_color[3] = {252, 251, 249};
static const unsigned char hairline[3] = {211, 206, 197}, grid_color[3] = {232, 229, 222};
static const unsigned char ink[3] = {44, 48, 57}, muted[3] = {122, 118, 110};

/* What all panels of a picture share. */
typedef struct sheet {
  hb_image *image;
  const hb_tube *tubes;
  int count;
  const hb_views *views;
  int scale;                                /* of the text */
  double lo[3], hi[3], along[2], across[2]; /* the views' ranges made wide enough to be drawn */
  double size;                              /* largest extent */
} sheet;

/* Makes a range at least `least` long, about its middle; a range without anything becomes one about zero. */
static void widen(double lo, double hi, double least, double out[2]) {
  if (!(lo <= hi) || !(hi - lo < 1e100)) lo = hi = 0;
  double middle = 0.5 * (lo + hi), half = fmax(0.5 * (hi - lo), 0.5 * least);
  out[0] = middle - half;
  out[1] = middle + half;
}

/* Ranges for drawing: no view is zoomed more than eight times as far as the widest one. */
static void make_ranges(sheet *s) {
  const hb_views *v = s->views;
  double size = 0, range[2];
  for (int k = 0; k < 3; k++)
    if (v->hi[k] - v->lo[k] < 1e100) size = fmax(size, v->hi[k] - v->lo[k]);
  if (!(size > 0)) size = 1;
  s->size = size;
  for (int k = 0; k < 3; k++) {
    widen(v->lo[k], v->hi[k], size / 8, range);
    s->lo[k] = range[0];
    s->hi[k] = range[1];
  }
  widen(v->along_range[0], v->along_range[1], size / 8, s->along);
  widen(v->across_range[0], v->across_range[1], size / 8, s->across);
}

/* A horizontal direction as a word: x, y, or a sum. */
static void direction_name(const double d[3], char *out, size_t size) {
  if (d[0] > 0.9999)
    snprintf(out, size, "x");
  else if (d[1] > 0.9999)
    snprintf(out, size, "y");
  else if (fabs(fabs(d[0]) - fabs(d[1])) < 1e-6)
    snprintf(out, size, "(%sx%cy)/1.41", d[0] < 0 ? "-" : "", d[1] < 0 ? '-' : '+');
  else
    snprintf(out, size, "%.2fx%c%.2fy", d[0], d[1] < 0 ? '-' : '+', fabs(d[1]));
}

/* A flat view: which scene directions lead right and up, and their ranges. */
typedef struct flat {
  const char *title;
  const double *right, *up;
  double x[2], y[2];
  hb_rect frame; /* pixels */
  double unit;   /* pixels per length */
} flat;

/* Fits the ranges into the frame with equal scales, and widens them to fill it. */
static void fit_flat(flat *f, double size) {
  const double room = 0.90;
  double fit_x = f->frame.w * room / (f->x[1] - f->x[0]), fit_y = f->frame.h * room / (f->y[1] - f->y[0]);
  f->unit = fmin(fit_x, fit_y);
  if (!(f->unit > 0)) f->unit = f->frame.h / size;
  double cx = 0.5 * (f->x[0] + f->x[1]), cy = 0.5 * (f->y[0] + f->y[1]);
  f->x[0] = cx - 0.5 * f->frame.w / f->unit;
  f->x[1] = cx + 0.5 * f->frame.w / f->unit;
  f->y[0] = cy - 0.5 * f->frame.h / f->unit;
  f->y[1] = cy + 0.5 * f->frame.h / f->unit;
}

/* Grid lines and numbers along both axes of a flat view. */
static void flat_axes(const sheet *s, const flat *f) {
  int scale = s->scale, cap = HB_TEXT_CAP * scale;
  char text[32];
  hb_rect r = f->frame;
  double step = hb_tick_step(f->x[1] - f->x[0], r.w / (44 * scale) + 1), first = ceil(f->x[0] / step);
  for (int n = 0; n < 40 && (first + n) * step <= f->x[1]; n++) {
    double value = (first + n) * step;
    int x = r.x + (int)((value - f->x[0]) * f->unit + 0.5);
    hb_draw_rect(s->image, (hb_rect){x, r.y, 1, r.h}, grid_color);
    hb_draw_rect(s->image, (hb_rect){x, r.y + r.h, 1, 2 * scale}, hairline);
    hb_tick_text(text, sizeof text, value, step);
    int width = hb_text_width(text, scale), left = x - width / 2;
    if (left + width > r.x + r.w + 4 * scale) left = r.x + r.w + 4 * scale - width;
    hb_image_text(s->image, left, r.y + r.h + 4 * scale, scale, muted, text);
  }
  step = hb_tick_step(f->y[1] - f->y[0], r.h / (17 * scale) + 1);
  first = ceil(f->y[0] / step);
  for (int n = 0; n < 40 && (first + n) * step <= f->y[1]; n++) {
    double value = (first + n) * step;
    int y = r.y + r.h - 1 - (int)((value - f->y[0]) * f->unit + 0.5);
    if (y < r.y) continue;
    hb_draw_rect(s->image, (hb_rect){r.x, y, r.w, 1}, grid_color);
    hb_draw_rect(s->image, (hb_rect){r.x - 2 * scale, y, 2 * scale, 1}, hairline);
    hb_tick_text(text, sizeof text, value, step);
    hb_image_text(s->image, r.x - 4 * scale - hb_text_width(text, scale), y - cap / 2, scale, muted, text);
  }
  hb_draw_outline(s->image, r, hairline);
}

/* Background, border and title of a panel; returns the room below the title. */
static hb_rect panel(const sheet *s, hb_rect r, const char *title, const char *axes) {
  int scale = s->scale, pad = 6 * scale;
  hb_draw_rect(s->image, r, panel_color);
  hb_draw_outline(s->image, r, hairline);
  hb_image_text(s->image, r.x + pad, r.y + pad, scale, ink, title);
  int width = hb_text_width(axes, scale);
  if (hb_text_width(title, scale) + width + 3 * pad < r.w)
    hb_image_text(s->image, r.x + r.w - pad - width, r.y + pad, scale, muted, axes);
  int top = pad + HB_TEXT_HEIGHT * scale + pad / 2;
  return (hb_rect){r.x, r.y + top, r.w, r.h - top};
}

/* A flat view in its panel. */
static hb_status draw_flat(const sheet *s, hb_rect area, flat *f, const char *axes, hb_error *err) {
  int scale = s->scale;
  hb_rect room = panel(s, area, f->title, axes);
  int left = 40 * scale, bottom = 16 * scale, edge = 8 * scale;
  int gap = 3 * scale; /* half a number rises above the frame */
  f->frame = (hb_rect){room.x + left, room.y + gap, room.w - left - edge, room.h - gap - bottom};
  if (f->frame.w < 8 || f->frame.h < 8) return HB_OK; /* too small a picture for it */
  fit_flat(f, s->size);
  flat_axes(s, f);
  hb_v3 right = hb_v3_load(f->right), up = hb_v3_load(f->up), forward = hb_v3_cross(up, right);
  hb_v3 middle = {0.5 * (s->lo[0] + s->hi[0]), 0.5 * (s->lo[1] + s->hi[1]), 0.5 * (s->lo[2] + s->hi[2])};
  middle = hb_v3_axpy(middle, 0.5 * (f->x[0] + f->x[1]) - hb_v3_dot(middle, right), right);
  middle = hb_v3_axpy(middle, 0.5 * (f->y[0] + f->y[1]) - hb_v3_dot(middle, up), up);
  hb_camera camera = {.orthographic = true, .height = f->frame.h / f->unit};
  hb_v3_store(camera.target, middle);
  hb_v3_store(camera.up, up);
  hb_v3_store(camera.eye, hb_v3_axpy(middle, -2 * s->size, forward));
  return hb_render_view(s->image, f->frame.x + 1, f->frame.y + 1, f->frame.w - 2, f->frame.h - 2, s->tubes,
                        s->count, &camera, NULL, err);
}

/* The floor of the view in perspective. */
typedef struct floor_plan {
  hb_lens lens;
  double lo[2], hi[2], height, top; /* rectangle in x, y; z of the floor; z where the vertical axis ends */
  int near[2];                      /* 1 if the upper limit in x, y is nearer to the eye */
} floor_plan;

/* A scene point in pixels. */
static void to_pixel(const floor_plan *plan, double x, double y, double z, double out[2]) {
  hb_lens_pixel(&plan->lens, hb_lens_look(&plan->lens, (hb_v3){x, y, z}), out);
}

/* Where text of the view in perspective already stands. */
typedef struct labels {
  hb_rect area; /* text stays inside */
  hb_rect taken[96];
  int count;
} labels;

/* Moves a rectangle into the area and says whether it is free of other text. */
static bool place(const labels *l, int gap, hb_rect *r) {
  const hb_rect *a = &l->area;
  if (r->x + r->w > a->x + a->w) r->x = a->x + a->w - r->w;
  if (r->x < a->x) r->x = a->x;
  if (r->y + r->h > a->y + a->h) r->y = a->y + a->h - r->h;
  if (r->y < a->y) r->y = a->y;
  for (int k = 0; k < l->count; k++) {
    const hb_rect *t = &l->taken[k];
    if (r->x < t->x + t->w + gap && t->x < r->x + r->w + gap && r->y < t->y + t->h + gap &&
        t->y < r->y + r->h + gap)
      return false;
  }
  return true;
}

/* Text beside a pixel, on the side that leads away from `from`; a number that would touch other text is left
 * out, a name (in ink) moves on. */
static void label(const sheet *s, labels *l, const double at[2], const double from[2],
                  const unsigned char rgb[3], const char *text) {
  double dx = at[0] - from[0], dy = at[1] - from[1], n = sqrt(dx * dx + dy * dy);
  if (!(n > 0) || !(fabs(at[0]) < 1e6) || !(fabs(at[1]) < 1e6)) return;
  dx /= n;
  dy /= n;
  bool name = rgb == ink;
  int scale = s->scale, width = hb_text_width(text, scale), height = HB_TEXT_CAP * scale;
  double gap = 4 * scale;
  for (int k = 0; k < (name ? 60 : 1); k++) { /* ahead, then beside it on both sides */
    double ahead = 3.0 * scale * (k / 5), aside = 9.0 * scale * ((k % 5 + 1) / 2) * (k & 1 ? 1 : -1);
    double x = at[0] + dx * (gap + 0.5 * width + ahead) - dy * aside - 0.5 * width;
    double y = at[1] + dy * (gap + 0.5 * height + ahead) + dx * aside - 0.5 * height;
    hb_rect r = {(int)floor(x + 0.5), (int)floor(y + 0.5), width, height};
    if (!place(l, 2 * scale, &r)) continue;
    if (l->count < (int)(sizeof l->taken / sizeof l->taken[0])) l->taken[l->count++] = r;
    hb_image_text(s->image, r.x, r.y, scale, rgb, text);
    return;
  }
}

/* Grid lines normal to axis k (0: x, 1: y) and numbers where they meet the near edge of the floor. */
static void floor_lines(const sheet *s, const floor_plan *plan, int k, hb_rect clip, labels *l) {
  double a[2], b[2], centre[2], lo = plan->lo[k], hi = plan->hi[k],
                                other[2] = {plan->lo[1 - k], plan->hi[1 - k]};
  double front = other[plan->near[1 - k]], inside = 0.5 * (other[0] + other[1]);
  char text[32];
  to_pixel(plan, k ? front : lo, k ? lo : front, plan->height, a);
  to_pixel(plan, k ? front : hi, k ? hi : front, plan->height, b);
  double length = sqrt((a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]));
  double step = hb_tick_step(s->size, 8);
  double label_step = hb_tick_step(hi - lo, (int)(length / (32 * s->scale)) + 1);
  for (double value = ceil(lo / step - 1e-9) * step; value <= hi + 1e-9 * step; value += step) {
    to_pixel(plan, k ? other[0] : value, k ? value : other[0], plan->height, a);
    to_pixel(plan, k ? other[1] : value, k ? value : other[1], plan->height, b);
    hb_draw_line(s->image, clip, a, b, 0.5 * s->scale, grid_color);
  }
  for (double value = ceil(lo / label_step - 1e-9) * label_step; value <= hi + 1e-9 * label_step;
       value += label_step) {
    to_pixel(plan, k ? front : value, k ? value : front, plan->height, a);
    to_pixel(plan, k ? inside : value, k ? value : inside, plan->height, centre);
    if (k && fabs(value - (plan->near[1] ? hi : lo)) * length < 20 * s->scale * (hi - lo))
      continue; /* taken by x */
    hb_tick_text(text, sizeof text, value, label_step);
    label(s, l, a, centre, muted, text);
  }
}

/* The letter of axis k, beyond the numbers at the near edge of the floor. */
static void axis_name(const sheet *s, const floor_plan *plan, int k, labels *l) {
  double a[2], centre[2], lo = plan->lo[k], hi = plan->hi[k];
  double other[2] = {plan->lo[1 - k], plan->hi[1 - k]};
  double front = other[plan->near[1 - k]], inside = 0.5 * (other[0] + other[1]);
  double middle = 0.5 * (lo + hi);
  to_pixel(plan, k ? front : middle, k ? middle : front, plan->height, a);
  to_pixel(plan, k ? inside : middle, k ? middle : inside, plan->height, centre);
  double dx = a[0] - centre[0], dy = a[1] - centre[1], n = sqrt(dx * dx + dy * dy);
  for (int c = 0; n > 0 && c < 2; c++) a[c] += (c ? dy : dx) / n * (14 + 18 * fabs(dx) / n) * s->scale;
  label(s, l, a, centre, ink, k ? "y" : "x");
}

/* The vertical axis at the left corner of the floor. */
static void vertical_axis(const sheet *s, const floor_plan *plan, hb_rect clip, labels *l) {
  double best = HUGE_VAL, x = 0, y = 0, a[2], b[2], centre[2];
  for (int corner = 0; corner < 4; corner++) {
    double cx = corner & 1 ? plan->hi[0] : plan->lo[0], cy = corner & 2 ? plan->hi[1] : plan->lo[1];
    to_pixel(plan, cx, cy, plan->height, a);
    if (a[0] < best) {
      best = a[0];
      x = cx;
      y = cy;
    }
  }
  to_pixel(plan, x, y, plan->height, a);
  to_pixel(plan, x, y, plan->top, b);
  hb_draw_line(s->image, clip, a, b, 0.5 * s->scale, hairline);
  double step = hb_tick_step(plan->top - plan->height, (int)(fabs(a[1] - b[1]) / (18 * s->scale)) + 1);
  char text[32];
  for (double value = ceil(plan->height / step) * step; value <= plan->top + 1e-9 * step; value += step) {
    to_pixel(plan, x, y, value, a);
    b[0] = a[0] - 3 * s->scale;
    b[1] = a[1];
    hb_draw_line(s->image, clip, a, b, 0.5 * s->scale, hairline);
    hb_tick_text(text, sizeof text, value, step);
    centre[0] = a[0] + 100;
    centre[1] = a[1];
    label(s, l, b, centre, muted, text);
  }
  to_pixel(plan, x, y, plan->top, a);
  centre[0] = a[0];
  centre[1] = a[1] + 100;
  label(s, l, a, centre, ink, "z");
}

/* Floor, border, axes. */
static void draw_floor(const sheet *s, const floor_plan *plan, hb_rect clip) {
  double corner[4][2];
  int edge = 3 * s->scale, title = 18 * s->scale;
  labels l = {.area = {clip.x + edge, clip.y + title, clip.w - 2 * edge, clip.h - title - edge}};
  for (int k = 0; k < 2; k++) floor_lines(s, plan, k, clip, &l);
  for (int k = 0; k < 4; k++)
    to_pixel(plan, k == 1 || k == 2 ? plan->hi[0] : plan->lo[0], k > 1 ? plan->hi[1] : plan->lo[1],
             plan->height, corner[k]);
  for (int k = 0; k < 4; k++)
    hb_draw_line(s->image, clip, corner[k], corner[(k + 1) % 4], 0.5 * s->scale, hairline);
  vertical_axis(s, plan, clip, &l);
  for (int k = 0; k < 2; k++) axis_name(s, plan, k, &l);
}

/* The view in perspective, from the right, in front and above. */
static hb_status draw_solid(const sheet *s, hb_rect area, hb_error *err) {
  hb_rect room = panel(s, area, "in space", "");
  int edge = 20 * s->scale;
  room = (hb_rect){room.x + edge + 8 * s->scale, room.y + 4 * s->scale, room.w - 2 * edge - 8 * s->scale,
                   room.h - edge - 8 * s->scale};
  if (room.w < 8 || room.h < 8) return HB_OK;
  floor_plan plan;
  double lo[3], hi[3], pad = 0.06 * s->size, step = hb_tick_step(s->size, 16);
  for (int k = 0; k < 2; k++) {
    lo[k] = plan.lo[k] = floor((s->lo[k] - pad) / step) * step;
    hi[k] = plan.hi[k] = ceil((s->hi[k] + pad) / step) * step;
  }
  const hb_views *v = s->views;
  plan.height = lo[2] = s->lo[2] - 0.04 * s->size;
  plan.top = hi[2] = s->hi[2] + 0.02 * s->size;
  const double *a = v->along, up[3] = {0, 0, 1};
  hb_v3 side = hb_v3_cross(hb_v3_load(a), (hb_v3){0, 0, 1}); /* towards the eye of the view along the rod */
  hb_v3 dir = hb_v3_axpy(hb_v3_scale(0.42, hb_v3_load(a)), 0.9, side);
  double tall = (s->hi[2] - s->lo[2]) / (0.6 * s->size); /* flat things are seen from higher up */
  double from[3] = {dir.x, dir.y, 0.42 + 0.35 * (1 - fmin(tall, 1))};
  hb_camera camera;
  hb_camera_fit(lo, hi, from, up, false, (double)room.w / room.h, &camera);
  hb_lens_make(&camera, room, &plan.lens);
  plan.near[0] = dir.x > 0;
  plan.near[1] = dir.y > 0;
  draw_floor(s, &plan, (hb_rect){area.x + 1, area.y + 1, area.w - 2, area.h - 2});
  return hb_render_view(s->image, room.x, room.y, room.w, room.h, s->tubes, s->count, &camera, &plan.height,
                        err);
}

/* Title and time above the panels; returns the height used. */
static int header(const sheet *s, double time, const char *title, int margin) {
  char text[48];
  int scale = s->scale, y = margin + scale;
  snprintf(text, sizeof text, "t = %#.4g", time);
  int width = hb_text_width(text, scale), right = s->image->width - margin - width;
  hb_image_text(s->image, right, y, scale, ink, text);
  if (title && *title) {
    int fits = (right - 3 * margin) / (HB_TEXT_ADVANCE * scale);
    char cut[200];
    int length = snprintf(cut, sizeof cut, "%s", title);
    if (length >= (int)sizeof cut) length = (int)sizeof cut - 1;
    if (fits < 0) fits = 0;
    while (length > 0 && hb_text_width(cut, 1) > fits * HB_TEXT_ADVANCE) {
      do cut[--length] = 0;
      while (length > 0 && ((unsigned char)cut[length - 1] & 0xc0) == 0x80);
    }
    hb_image_text(s->image, margin + scale, y, scale, ink, cut);
  }
  return HB_TEXT_HEIGHT * scale + 2 * margin + scale;
}

static const double vertical[3] = {0, 0, 1};

/* The view along the rod: height over the principal direction. */
static hb_status draw_side(const sheet *s, hb_rect area, hb_error *err) {
  flat f = {.title = "along the rod",
            .right = s->views->along,
            .up = vertical,
            .x = {s->along[0], s->along[1]},
            .y = {s->lo[2], s->hi[2]}};
  char name[32], axes[64];
  direction_name(s->views->along, name, sizeof name);
  snprintf(axes, sizeof axes, "z over %s", name);
  return draw_flat(s, area, &f, axes, err);
}

/* The view along its axis: height over the other horizontal direction; from above where the rod stands
 * upright. */
static hb_status draw_end(const sheet *s, hb_rect area, hb_error *err) {
  const hb_views *v = s->views;
  char across[32], along[32], axes[72];
  direction_name(v->across, across, sizeof across);
  direction_name(v->along, along, sizeof along);
  if (v->upright) {
    hb_v3 up = hb_v3_cross((hb_v3){0, 0, 1}, hb_v3_load(v->along)), given = hb_v3_load(v->across);
    bool turned = hb_v3_dot(up, given) < 0; /* seen from above, not from below */
    flat f = {.title = "along its axis",
              .right = turned ? v->across : v->along,
              .up = turned ? v->along : v->across};
    const double *x = turned ? s->across : s->along, *y = turned ? s->along : s->across;
    for (int k = 0; k < 2; k++) {
      f.x[k] = x[k];
      f.y[k] = y[k];
    }
    snprintf(axes, sizeof axes, "%s over %s", turned ? along : across, turned ? across : along);
    return draw_flat(s, area, &f, axes, err);
  }
  flat f = {.title = "along its axis",
            .right = v->across,
            .up = vertical,
            .x = {s->across[0], s->across[1]},
            .y = {s->lo[2], s->hi[2]}};
  snprintf(axes, sizeof axes, "z over %s", across);
  return draw_flat(s, area, &f, axes, err);
}

/* In space on the left; along the rod and along its axis on the right. */
hb_status hb_render_views(hb_image *image, const hb_tube *tubes, int count, const hb_views *views,
                          double time, const char *title, hb_error *err) {
  sheet s = {.image = image, .tubes = tubes, .count = count, .views = views};
  int by_height = (image->height + 200) / 360, by_width = image->width / 480;
  s.scale = by_height < by_width ? by_height : by_width;
  if (s.scale < 1) s.scale = 1;
  make_ranges(&s);
  hb_image_fill(image, page_color);
  int margin = 5 * s.scale, top = header(&s, time, title, margin);
  int left = (image->width - 3 * margin) * 56 / 100, right = image->width - 3 * margin - left;
  int height = image->height - top - margin, upper = (height - margin) / 2;
  hb_rect solid = {margin, top, left, height}, side = {2 * margin + left, top, right, upper};
  hb_rect end = {side.x, top + upper + margin, right, height - upper - margin};
  hb_status status = draw_solid(&s, solid, err);
  if (status == HB_OK) status = draw_side(&s, side, err);
  if (status == HB_OK) status = draw_end(&s, end, err);
  return status;
}

/* The box stands for all frames; the tubes of this one show where the rods lead. */
hb_status hb_render_three_views(hb_image *image, const hb_tube *tubes, int count, const double lo[3],
                                const double hi[3], double time, const char *title, hb_error *err) {
  hb_views views;
  hb_views_start(&views);
  hb_views_add(&views, tubes, count);
  (void)hb_views_aim(&views);
  const double box[6] = {lo[0], lo[1], lo[2], hi[0], hi[1], hi[2]};
  for (int corner = 0; corner < 8; corner++) {
    const double p[3] = {box[corner & 1 ? 3 : 0], box[corner & 2 ? 4 : 1], box[corner & 4 ? 5 : 2]};
    const hb_tube ball = {.xyz = p, .nv = 1};
    hb_views_measure(&views, &ball, 1);
  }
  for (int k = 0; k < 3; k++) {
    views.lo[k] = lo[k];
    views.hi[k] = hi[k];
  }
  return hb_render_views(image, tubes, count, &views, time, title, err);
}
