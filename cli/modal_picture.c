/* Panels of modes. */
#include "cli/modal_picture.h"

#include "base/memory.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* Size of a panel, panels side by side, and at most. */
enum { WIDTH = 360, HEIGHT = 300, MARGIN = 26, PER_ROW = 4, MOST = 24 };

/* What drawing a panel works on. */
typedef struct panel {
  const hb_rod *rod;
  double *shape[3]; /* 3 per vertex of the longest rod: at rest, to one side, to the other */
  double *away;     /* from the middle of its vertices, at rest */
  double radius;
} panel;

/* Unit direction along which the vectors a (3 each, count) have the largest sum of squares beside `without`,
 * by powers of their second moments; *share: that sum of squares. */
static void main_direction(const double *a, int count, const double *without, double out[3]) {
  double moments[3][3] = {{0}}, v[3] = {0.5377, 0.6181, 0.5734};
  for (int i = 0; i < count; i++)
    for (int p = 0; p < 3; p++)
      for (int q = 0; q < 3; q++) moments[p][q] += a[3 * i + p] * a[3 * i + q];
  for (int round = 0; round < 200; round++) {
    double next[3] = {0, 0, 0}, size = 0, along = 0;
    for (int p = 0; p < 3; p++)
      for (int q = 0; q < 3; q++) next[p] += moments[p][q] * v[q];
    for (int p = 0; without && p < 3; p++) along += next[p] * without[p];
    for (int p = 0; without && p < 3; p++) next[p] -= along * without[p];
    for (int p = 0; p < 3; p++) size += next[p] * next[p];
    if (!(size > 0)) break;
    for (int p = 0; p < 3; p++) v[p] = next[p] / sqrt(size);
  }
  memcpy(out, v, sizeof v);
}

/* The camera looks across the plane of the rod's extent and of its motion, a little from the side and from
 * above. */
static void aim(const panel *p, const hb_mode *mode, hb_camera *camera) {
  int nv = p->rod->nv;
  double lo[3], hi[3], center[3], along[3], motion[3], across[3], up[3] = {0, 0, 1};
  for (int c = 0; c < 3; c++) {
    lo[c] = HUGE_VAL;
    hi[c] = -HUGE_VAL;
    center[c] = 0;
    for (int k = 0; k < 3 * nv; k++) {
      double x = p->shape[k / nv][3 * (k % nv) + c];
      lo[c] = fmin(lo[c], x - p->radius);
      hi[c] = fmax(hi[c], x + p->radius);
      if (k < nv) center[c] += x / nv;
    }
  }
  for (int k = 0; k < 3 * nv; k++) p->away[k] = p->shape[0][k] - center[k % 3];
  main_direction(p->away, nv, NULL, along);
  main_direction(mode->shape, nv, along, motion);
  for (int c = 0; c < 3; c++)
    across[c] = along[(c + 1) % 3] * motion[(c + 2) % 3] - along[(c + 2) % 3] * motion[(c + 1) % 3];
  double sign = across[2] < -0.1 || (fabs(across[2]) <= 0.1 && across[1] > 0) ? -1 : 1;
  for (int c = 0; c < 3; c++) across[c] = sign * across[c] + 0.22 * along[c] + 0.16 * (c == 2);
  if (fabs(across[2]) > 0.9) {
    up[2] = 0;
    up[fabs(motion[1]) > fabs(motion[0]) ? 1 : 0] = 1;
  }
  hb_camera_fit(lo, hi, across, up, true, (double)WIDTH / (HEIGHT - MARGIN), camera);
}

/* Number and figure of a mode. */
static void caption(const hb_mode *mode, int number, char text[64]) {
  double omega = hb_mode_omega(mode);
  if (hb_mode_kind(mode) > 0)
    snprintf(text, 64, "%d   omega %.5g", number, omega);
  else if (hb_mode_kind(mode) < 0)
    snprintf(text, 64, "%d   unstable, rate %.4g", number, omega);
  else
    snprintf(text, 64, "%d   rigid", number);
}

/* Copies the rod out of a measured frame. */
static void take(panel *p, int place, const hb_frame *frame) {
  size_t from = 3 * (size_t)p->rod->first, size = 3 * (size_t)p->rod->nv * sizeof(double);
  memcpy(p->shape[place], frame->position + from, size);
}

/* Longest side of the box around a rod at rest. */
static double extent(const cli_solution *s, const hb_rod *rod) {
  const double *x = hb_sim_const_state(s->sim)->x + 3 * (size_t)rod->first;
  double most = 0;
  for (int c = 0; c < 3; c++) {
    double lo = HUGE_VAL, hi = -HUGE_VAL;
    for (int i = 0; i < rod->nv; i++) {
      lo = fmin(lo, x[3 * i + c]);
      hi = fmax(hi, x[3 * i + c]);
    }
    most = fmax(most, hi - lo);
  }
  return most;
}

/* Both sides are tried; the frame is overwritten. */
hb_status cli_modal_amplitudes(cli_solution *s, const hb_modes *modes, double part, bool strict,
                               double *amplitude, hb_error *err) {
  for (int k = 0; k < modes->count; k++) {
    const hb_mode *mode = &modes->mode[k];
    hb_status status = HB_ERR_INPUT;
    amplitude[k] = 2 * part * extent(s, &s->model->rods[mode->rod]);
    for (int attempt = 0; status == HB_ERR_INPUT && attempt < (strict ? 1 : 12); attempt++) {
      amplitude[k] *= 0.5;
      status = hb_sim_measure_mode(s->sim, &s->found, mode, amplitude[k], 0, s->frame, err);
      if (!status) status = hb_sim_measure_mode(s->sim, &s->found, mode, -amplitude[k], 0, s->frame, err);
    }
    if (status) return status;
  }
  return HB_OK;
}

/* Draws one mode with its corner at x, y. */
static hb_status draw(cli_solution *s, panel *p, const hb_mode *mode, int number, double amplitude,
                      hb_image *image, int x, int y, hb_error *err) {
  static const double colors[3][3] = {{0.72, 0.72, 0.70}, {0.79, 0.35, 0.27}, {0.15, 0.44, 0.53}};
  const unsigned char ink[3] = {70, 72, 78};
  char text[64];
  hb_status status = HB_OK;
  p->rod = &s->model->rods[mode->rod];
  p->radius = fmax(s->def.rods[mode->rod].radius, 0.004 * p->rod->length);
  for (int place = 0; !status && place < 3; place++) {
    double part = place == 0 ? 0 : place == 1 ? 1 : -1;
    status = hb_sim_measure_mode(s->sim, &s->found, mode, part * amplitude, 0, s->frame, err);
    if (!status) take(p, place, s->frame);
  }
  if (status) return status;
  hb_camera camera;
  hb_tube tubes[3];
  for (int k = 0; k < 3; k++) {
    tubes[k] = (hb_tube){.xyz = p->shape[k], .nv = p->rod->nv, .radius = p->radius};
    memcpy(tubes[k].color, colors[k], sizeof colors[k]);
  }
  aim(p, mode, &camera);
  status = hb_render_view(image, x, y, WIDTH, HEIGHT - MARGIN, tubes, 3, &camera, NULL, err);
  caption(mode, number, text);
  if (!status) hb_image_text(image, x + 12, y + HEIGHT - MARGIN, 2, ink, text);
  return status;
}

/* Arrays for the longest rod. */
static hb_status make(const hb_model *model, panel *p, double **block, hb_error *err) {
  size_t longest = 0;
  for (int r = 0; r < model->rod_count; r++)
    if ((size_t)model->rods[r].nv > longest) longest = (size_t)model->rods[r].nv;
  *block = hb_alloc(12 * longest, sizeof **block);
  if (!*block) return hb_fail_memory(err, "shapes to draw");
  for (int k = 0; k < 3; k++) p->shape[k] = *block + 3 * longest * (size_t)k;
  p->away = *block + 9 * longest;
  return HB_OK;
}

/* As many rows as it takes. */
hb_status cli_modal_picture(cli_solution *s, const hb_modes *modes, const double *amplitude, const char *path,
                            hb_error *err) {
  const unsigned char page[3] = {247, 246, 243};
  int count = modes->count < MOST ? modes->count : MOST, columns = count < PER_ROW ? count : PER_ROW;
  if (count == 0) return hb_fail(err, HB_ERR_INPUT, "there is no mode to draw");
  hb_image image = {0, 0, NULL};
  panel p = {.rod = NULL};
  double *block = NULL;
  hb_status status = make(s->model, &p, &block, err);
  if (!status)
    status = hb_image_create(columns * WIDTH, (count + columns - 1) / columns * HEIGHT, &image, err);
  if (!status) hb_image_fill(&image, page);
  for (int k = 0; !status && k < count; k++)
    status = draw(s, &p, &modes->mode[k], k + 1, amplitude[k], &image, k % columns * WIDTH,
                  k / columns * HEIGHT, err);
  if (!status) status = hb_image_write_png(&image, path, err);
  hb_image_free(&image);
  hb_free(block);
  return status;
}
