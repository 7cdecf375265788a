/* Pieces of tube to samples: which piece does a ray meet first, and what passes in front of it nearby. */
#ifndef HB_RENDER_RASTER_H
#define HB_RENDER_RASTER_H

#include "render/strand.h"

/* Samples per pixel and side, pixels per side of a tile. */
enum { HB_FINE = 4, HB_TILE = 32, HB_TILE_SIDE = HB_FINE * HB_TILE };

/* A piece of tube: a cylinder with a ball at each end, from node to node + 1. */
typedef struct hb_piece {
  hb_v3 a, ab;
  double bb, radius;       /* ab.ab; radius of the tube */
  double pa[2], pd[2], pp; /* in pixels: its start, its way, pd.pd */
  double wide;             /* distance in pixels from its axis beyond which no ray meets it */
  double halo;             /* the same for its halo */
  double edge;             /* half width of the tube on the screen */
  double slack[2];         /* pixels that its surface can reach before its start and beyond its end */
  double za, zd;           /* depth of the axis: start, way */
  double front;            /* nothing of it is nearer than this */
  double arc;              /* along its strand */
  int node, strand;
} hb_piece;

typedef struct hb_pieces {
  hb_piece *piece;
  int count;
  int *start, *item; /* pieces that touch a tile */
  int nx, ny;        /* tiles */
  bool halos;
} hb_pieces;

/* What the samples of a tile have met. Pixels where nothing changes have only the samples with i and j even.
 */
typedef struct hb_tile {
  double depth[HB_TILE_SIDE * HB_TILE_SIDE]; /* z of the hit; HUGE_VAL: nothing */
  int piece[HB_TILE_SIDE * HB_TILE_SIDE];    /* -1: nothing */
  float halo[HB_TILE_SIDE * HB_TILE_SIDE];   /* 0..1: how much a tube well in front darkens the sample */
  bool busy[HB_TILE * HB_TILE];              /* this pixel has all its samples */
} hb_tile;

hb_status hb_pieces_make(const hb_strands *strands, const hb_lens *lens, hb_pieces *out, hb_error *err);
void hb_pieces_free(hb_pieces *pieces);
/* Place of the sample (i, j) in its pixel: a lattice turned against the pixels, each sample in a column and a
 * row of its own, so that nearly level edges are smooth too. */
static inline double hb_sample_x(int i, int j) { return (i + (j + 0.5) / HB_FINE) / HB_FINE; }
static inline double hb_sample_y(int i, int j) { return (j + (HB_FINE - i - 0.5) / HB_FINE) / HB_FINE; }
/* The ray through a pixel coordinate in camera space: origin + z * direction is the point at depth z. */
static inline void hb_lens_ray(const hb_lens *lens, double x, double y, hb_v3 *origin, hb_v3 *direction) {
  double u = (x - lens->cx) * lens->unit, v = (y - lens->cy) * lens->unit;
  bool flat = lens->orthographic;
  *origin = flat ? (hb_v3){u, v, 0} : (hb_v3){0, 0, 0};
  *direction = flat ? (hb_v3){0, 0, 1} : (hb_v3){u, v, 1};
}
/* Clears the tile and draws its pieces; tx, ty: which one. */
void hb_tile_draw(hb_tile *tile, const hb_pieces *pieces, const hb_lens *lens, int tx, int ty);

#endif
