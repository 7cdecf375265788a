/* One view of tubes into a rectangle of a picture. */
#include "hebra/render.h"

#include "base/memory.h"
#include "render/shade.h"

/* Pixels between the points where the ground's shadow is worked out. */
enum { LATTICE = 2, CORNERS = HB_TILE / LATTICE + 1 };
/* How much light the shadow takes from the background. */
#define SHADOW_DEPTH 0.42

typedef struct view {
  hb_image *image;
  hb_shading shading;
  bool ground;
  double height; /* of the ground along lens.up, measured from the eye */
} view;

/* Share of the lamp that the ground under a pixel sees; 1 where there is no ground. */
static double ground_sun(const view *v, double x, double y) {
  hb_v3 origin, ray, up = v->shading.lens->up;
  hb_lens_ray(v->shading.lens, x, y, &origin, &ray);
  double slope = hb_v3_dot(up, ray);
  if (!(slope < -0.02)) return 1;
  double t = (v->height - hb_v3_dot(up, origin)) / slope;
  if (!(t > v->shading.lens->near) || !(t < 1e100)) return 1;
  hb_v3 p = hb_v3_axpy(origin, t, ray);
  double sun = v->shading.thicket ? hb_thicket_sun(v->shading.thicket, p)
                                  : hb_occlusion_sun(v->shading.occlusion, p, 0);
  double fade = slope < -0.12 ? 1 : (-slope - 0.02) / 0.10;
  return 1 - (1 - sun) * fade;
}

/* The ground's shadow at the corners of a tile's lattice; false if there is none in it. */
static bool tile_shadow(const view *v, const int corner[2], double shadow[CORNERS * CORNERS]) {
  bool any = false;
  for (int j = 0; j < CORNERS; j++)
    for (int i = 0; i < CORNERS; i++) {
      double dark = v->ground ? 1 - ground_sun(v, corner[0] + i * LATTICE, corner[1] + j * LATTICE) : 0;
      shadow[j * CORNERS + i] = dark;
      any = any || dark > 0;
    }
  return any;
}

/* Shadow at a pixel of the tile, between the corners of the lattice. */
static double shadow_at(const double *shadow, int px, int py) {
  const double *at = shadow + py / LATTICE * CORNERS + px / LATTICE;
  double fx = (px % LATTICE + 0.5) / LATTICE, fy = (py % LATTICE + 0.5) / LATTICE;
  double top = at[0] + fx * (at[1] - at[0]);
  double bottom = at[CORNERS] + fx * (at[CORNERS + 1] - at[CORNERS]);
  return top + fy * (bottom - top);
}

/* Light to a byte: square root, rounded. */
static unsigned char to_byte(double light) {
  double v = 255 * sqrt(light > 0 ? light : 0) + 0.5;
  return (unsigned char)(v < 255 ? v : 255);
}

/* Where a pixel lies in memory. */
static unsigned char *pixel(const view *v, int x, int y) {
  return v->image->rgb + 3 * ((size_t)y * (size_t)v->image->width + (size_t)x);
}

/* The background's light with the ground's shadow on it. Shadows are a little blue. */
static double background(unsigned char byte, double shadow, int channel) {
  const double tint[3] = {1.0, 0.985, 0.95};
  double back = byte / 255.0;
  return back * back * (1 - SHADOW_DEPTH * shadow * tint[channel]);
}

/* One pixel: mean light of its samples, over what is already there. */
static void resolve(const view *v, const hb_tile *tile, const int at[2], const int corner[2], double shadow) {
  int first = at[1] * HB_FINE * HB_TILE_SIDE + at[0] * HB_FINE, x = corner[0] + at[0], y = corner[1] + at[1];
  double sum[3] = {0, 0, 0}, light[3];
  int covered = 0, used = 0;
  bool few = !tile->busy[at[1] * HB_TILE + at[0]];
  for (int j = 0; j < HB_FINE; j++)
    for (int i = 0; i < HB_FINE; i++) {
      int k = first + j * HB_TILE_SIDE + i;
      if (few && (i & 1 || j & 1)) continue;
      used++;
      if (tile->piece[k] < 0) continue;
      covered++;
      hb_shade_sample(&v->shading, tile, k, x + hb_sample_x(i, j), y + hb_sample_y(i, j), light);
      for (int c = 0; c < 3; c++) sum[c] += light[c] < 1 ? light[c] : 1;
    }
  if (!covered && !(shadow > 0)) return;
  unsigned char *rgb = pixel(v, x, y);
  for (int c = 0; c < 3; c++)
    rgb[c] = to_byte((sum[c] + (used - covered) * background(rgb[c], shadow, c)) / used);
}

/* One tile: tubes, if there are any, and shadow. */
static void draw_tile(const view *v, hb_tile *tile, int tx, int ty) {
  const hb_pieces *pieces = v->shading.pieces;
  const hb_rect rect = v->shading.lens->rect;
  const int corner[2] = {rect.x + tx * HB_TILE, rect.y + ty * HB_TILE};
  int k = ty * pieces->nx + tx;
  double shadow[CORNERS * CORNERS];
  bool shaded = tile_shadow(v, corner, shadow), tubes = pieces->start[k] < pieces->start[k + 1];
  if (!shaded && !tubes) return;
  if (tubes) hb_tile_draw(tile, pieces, v->shading.lens, tx, ty);
  int x1 = rect.x + rect.w < v->image->width ? rect.x + rect.w : v->image->width;
  int y1 = rect.y + rect.h < v->image->height ? rect.y + rect.h : v->image->height;
  for (int py = 0; py < HB_TILE && corner[1] + py < y1; py++)
    for (int px = 0; px < HB_TILE && corner[0] + px < x1; px++) {
      if (corner[0] + px < 0 || corner[1] + py < 0) continue;
      const int at[2] = {px, py};
      double dark = shaded ? shadow_at(shadow, px, py) : 0;
      if (tubes)
        resolve(v, tile, at, corner, dark);
      else if (dark > 0) {
        unsigned char *rgb = pixel(v, corner[0] + px, corner[1] + py);
        for (int c = 0; c < 3; c++) rgb[c] = to_byte(background(rgb[c], dark, c));
      }
    }
}

/* Prepares everything, draws, frees. */
hb_status hb_render_view(hb_image *image, int x0, int y0, int w, int h, const hb_tube *tubes, int count,
                         const hb_camera *camera, const double *ground, hb_error *err) {
  if (w < 1 || h < 1 || w > 16384 || h > 16384)
    return hb_fail(err, HB_ERR_INPUT, "the view's size is %d x %d; each side must be 1 to 16384 pixels", w,
                   h);
  hb_lens lens;
  hb_strands strands;
  hb_pieces pieces = {0};
  hb_occlusion occlusion = {0};
  hb_thicket thicket = {.depth = NULL};
  hb_lens_make(camera, (hb_rect){x0, y0, w, h}, &lens);
  hb_status status = hb_strands_make(tubes, count, &lens, &strands, err);
  if (status != HB_OK) return status;
  hb_tile *tile = hb_alloc(1, sizeof *tile);
  if (!tile) status = hb_fail_memory(err, "tile of a picture");
  if (status == HB_OK) status = hb_pieces_make(&strands, &lens, &pieces, err);
  if (status == HB_OK && strands.thicket)
    status = hb_thicket_make(&strands, hb_key_light(&lens), &thicket, err);
  else if (status == HB_OK)
    status = hb_occlusion_make(&strands, hb_key_light(&lens), lens.pixel, &occlusion, err);
  if (status == HB_OK && strands.count > 1) {
    view v = {.image = image,
              .shading = {.lens = &lens, .strands = &strands, .pieces = &pieces, .occlusion = &occlusion}};
    if (strands.thicket) v.shading.thicket = &thicket;
    hb_shading_make(&v.shading);
    v.ground = ground && fabs(*ground) < 1e100;
    hb_v3 up = hb_v3_add(hb_v3_scale(lens.up.x, lens.right),
                         hb_v3_add(hb_v3_scale(lens.up.y, lens.down), hb_v3_scale(lens.up.z, lens.forward)));
    if (v.ground) v.height = *ground - hb_v3_dot(up, lens.eye);
    for (int ty = 0; ty < pieces.ny; ty++)
      for (int tx = 0; tx < pieces.nx; tx++) draw_tile(&v, tile, tx, ty);
  }
  hb_occlusion_free(&occlusion);
  hb_thicket_free(&thicket);
  hb_pieces_free(&pieces);
  hb_strands_free(&strands);
  hb_free(tile);
  return status;
}
