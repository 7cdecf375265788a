/* hebra/render.h - tubes to pixels, without any graphics library. Deterministic. */
#ifndef HEBRA_RENDER_H
#define HEBRA_RENDER_H

#include "hebra/base.h"

#ifdef __cplusplus
extern "C" {
#endif

/* One strand to draw. Arrays are borrowed. */
typedef struct hb_tube {
  const double *xyz; /* 3 nv */
  const double *m1;  /* 3 (nv-1) first directors; NULL: no stripe */
  int nv;
  double radius;
  double color[3]; /* 0..1; stripe is drawn in a contrasting tone */
} hb_tube;

typedef struct hb_camera {
  double eye[3], target[3], up[3];
  bool orthographic;
  double
      height; /* orthographic: height of the picture in scene units; perspective: vertical angle in radians */
} hb_camera;

/* 8-bit RGB, rows from the top. */
typedef struct hb_image {
  int width, height;
  unsigned char *rgb;
} hb_image;

hb_status hb_image_create(int width, int height, hb_image *image, hb_error *err);
void hb_image_free(hb_image *image);
void hb_image_fill(hb_image *image, const unsigned char rgb[3]);
hb_status hb_image_write_png(const hb_image *image, const char *path, hb_error *err);

/* A camera that shows all of the box lo..hi from direction (from target to eye). */
void hb_camera_fit(const double lo[3], const double hi[3], const double direction[3], const double up[3],
                   bool orthographic, double aspect, hb_camera *camera);
/* Draws tubes into the rectangle x0,y0,w,h of image: shaded, with the twist stripe, ground shadow if ground
 * != NULL (height along up), anti-aliased. */
hb_status hb_render_view(hb_image *image, int x0, int y0, int w, int h, const hb_tube *tubes, int count,
                         const hb_camera *camera, const double *ground, hb_error *err);
/* The thesis's picture: along the rod, along its axis, and 3D, in one image, with titles and the time. lo,
 * hi: the box that all frames of a film share. */
hb_status hb_render_three_views(hb_image *image, const hb_tube *tubes, int count, const double lo[3],
                                const double hi[3], double time, const char *title, hb_error *err);

/* What all frames of a film share, so that its three views stand still: where the rods lead, what space they
 * use. Two passes: start; add the first frame and aim; add the others, and aim again if the first one had no
 * direction; measure every frame. Then draw. */
typedef struct hb_views {
  double lo[3], hi[3]; /* box around all frames, radius included; lo > hi: nothing added yet */
  double along[3];     /* unit, horizontal: first principal direction of the vertices added before aiming */
  double across[3];    /* unit, horizontal, normal to it */
  bool upright;        /* the rods extend upwards more than sideways: the end-on view is from above */
  double along_range[2], across_range[2];
  double sums[8]; /* of x, y, z, xx, yy, zz, xy measured from origin; their number */
  double origin[3];
} hb_views;
void hb_views_start(hb_views *views);
void hb_views_add(hb_views *views, const hb_tube *tubes, int count);
bool hb_views_aim(hb_views *views); /* false: no horizontal direction stands out, x is taken */
void hb_views_measure(hb_views *views, const hb_tube *tubes, int count);
/* The picture of hb_render_three_views with these views. */
hb_status hb_render_views(hb_image *image, const hb_tube *tubes, int count, const hb_views *views,
                          double time, const char *title, hb_error *err);

/* Text in a built-in bitmap font, scale >= 1. */
void hb_image_text(hb_image *image, int x, int y, int scale, const unsigned char rgb[3], const char *text);

#ifdef __cplusplus
}
#endif
#endif
