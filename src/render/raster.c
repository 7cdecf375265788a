/* Z-buffer of exact ray hits on cylinders and balls: no mesh, so no facets, no cracks, round ends. */
#include "render/raster.h"

#include "base/memory.h"

#include <limits.h>
#include <stdlib.h>

/* Halo of a tube in front: this many radii, and at most this many pixels, beyond its edge. */
#define HALO_RADII 0.45
#define HALO_PIXELS 7.0
/* Radii from the front of a tube to where its halo begins to show. */
#define HALO_BEHIND 2.4

/* Sine, or more, of the turn from the piece before node i to the one after it; 1 where there is only one of
 * them. */
static double turn_at(const hb_strands *s, int i) {
  const hb_node *n = &s->node[i];
  if (n->first || n->last) return 1;
  hb_v3 a = hb_v3_unit(hb_v3_sub(n->p, n[-1].p)), b = hb_v3_unit(hb_v3_sub(n[1].p, n->p));
  return fmin(hb_v3_norm(hb_v3_sub(a, b)), 1);
}

/* The visible side of a tilted cylinder is shifted on the screen towards its far end, by its radius times the
 * tilt; a joint adds a wedge. */
static void set_slack(const hb_strands *s, int i, const hb_lens *lens, hb_piece *p) {
  hb_v3 middle = hb_v3_axpy(p->a, 0.5, p->ab),
        sight = lens->orthographic ? (hb_v3){0, 0, 1} : hb_v3_unit(middle);
  double length = sqrt(p->bb), tilt = length > 0 ? hb_v3_dot(p->ab, sight) / length : 0;
  double blur = lens->orthographic ? 0 : 1.5 * (p->radius + length) / hb_v3_norm(middle);
  if (!(p->pp > 1e-6 * p->edge * p->edge)) { /* seen end-on: no way on the screen to speak of */
    p->slack[0] = p->slack[1] = p->wide + 1;
    return;
  }
  p->slack[0] = p->wide * fmin(fmax(-tilt, 0) + blur + turn_at(s, i), 1) + 1;
  p->slack[1] = p->wide * fmin(fmax(tilt, 0) + blur + turn_at(s, i + 1), 1) + 1;
}

/* Prepares the piece after node i; false if it lies outside the picture or behind the eye. */
static bool prepare(const hb_strands *s, int i, const hb_lens *lens, hb_piece *p) {
  const hb_node *a = &s->node[i], *b = &s->node[i + 1];
  double radius = s->look[a->tube].radius, near = fmin(a->p.z, b->p.z) - radius;
  if (near <= lens->near) return false;
  *p = (hb_piece){.a = a->p,
                  .ab = hb_v3_sub(b->p, a->p),
                  .radius = radius,
                  .za = a->p.z,
                  .arc = a->arc,
                  .node = i,
                  .strand = a->strand};
  p->bb = hb_v3_dot(p->ab, p->ab);
  p->zd = p->ab.z;
  double end[2];
  hb_lens_pixel(lens, a->p, p->pa);
  hb_lens_pixel(lens, b->p, end);
  for (int k = 0; k < 2; k++) p->pd[k] = end[k] - p->pa[k];
  p->pp = p->pd[0] * p->pd[0] + p->pd[1] * p->pd[1];
  p->edge = radius * lens->focal / (lens->orthographic ? 1 : near + radius);
  p->wide =
      lens->orthographic ? p->edge * (1 + 1e-9) + 1e-6 : radius * lens->focal / near * lens->stretch + 0.5;
  p->halo = p->edge + fmin(HALO_RADII * p->edge, HALO_PIXELS) + 0.5;
  set_slack(s, i, lens, p);
  p->front = near;
  return fabs(p->pa[0]) < 1e60 && fabs(p->pa[1]) < 1e60 && p->pp < 1e120;
}

/* Tiles that a piece with its halo can touch; false: none. */
static bool touched(const hb_piece *p, const hb_lens *lens, const hb_pieces *all, int x[2], int y[2]) {
  double reach = fmax(p->wide, p->halo) + 1;
  const double corner[2] = {lens->rect.x, lens->rect.y};
  const int tiles[2] = {all->nx, all->ny};
  int *out[2] = {x, y};
  for (int k = 0; k < 2; k++) {
    double lo = fmin(p->pa[k], p->pa[k] + p->pd[k]) - reach - corner[k];
    double hi = fmax(p->pa[k], p->pa[k] + p->pd[k]) + reach - corner[k];
    if (!(hi >= 0) || !(lo < (double)tiles[k] * HB_TILE)) return false;
    out[k][0] = (int)fmax(lo / HB_TILE, 0);
    out[k][1] = (int)fmin(hi / HB_TILE, tiles[k] - 1);
  }
  return true;
}

/* Sorts the pieces into tiles: counts, sums, fills. */
static bool sort_tiles(hb_pieces *all, const hb_lens *lens) {
  size_t total = 0;
  int tiles = all->nx * all->ny, x[2], y[2];
  all->start = hb_alloc((size_t)tiles + 1, sizeof *all->start);
  if (!all->start) return false;
  for (int pass = 0; pass < 2; pass++) {
    for (int i = 0; i < all->count; i++) {
      if (!touched(&all->piece[i], lens, all, x, y)) continue;
      for (int ty = y[0]; ty <= y[1]; ty++)
        for (int tx = x[0]; tx <= x[1]; tx++) {
          int k = ty * all->nx + tx;
          if (pass) all->item[all->start[k]] = i;
          all->start[k]++;
        }
    }
    if (pass) break;
    for (int k = 0; k <= tiles; k++) {
      int here = all->start[k];
      all->start[k] = (int)total;
      total += (size_t)here;
      if (total > INT_MAX / 2) return false;
    }
    all->item = hb_alloc(total, sizeof *all->item);
    if (!all->item) return false;
  }
  for (int k = tiles; k > 0; k--) all->start[k] = all->start[k - 1];
  all->start[0] = 0;
  return true;
}

/* Order of two pieces: the one nearer to the eye first, so that it hides the others before they are worked
 * on.
 */
static int compare_front(const void *a, const void *b) {
  const hb_piece *p = a, *q = b;
  if (p->front < q->front || p->front > q->front) return p->front < q->front ? -1 : 1;
  return (p->node > q->node) - (p->node < q->node);
}

/* Pieces of all strands, and the tiles that they touch. */
hb_status hb_pieces_make(const hb_strands *s, const hb_lens *lens, hb_pieces *out, hb_error *err) {
  *out =
      (hb_pieces){.nx = (lens->rect.w + HB_TILE - 1) / HB_TILE, .ny = (lens->rect.h + HB_TILE - 1) / HB_TILE};
  out->halos = !s->thicket;
  out->piece = hb_alloc((size_t)s->count, sizeof *out->piece);
  if (!out->piece) return hb_fail_memory(err, "pieces of a picture");
  for (int i = 0; i + 1 < s->count; i++)
    if (!s->node[i].last && prepare(s, i, lens, &out->piece[out->count])) out->count++;
  if (out->count > 1) qsort(out->piece, (size_t)out->count, sizeof *out->piece, compare_front);
  if (sort_tiles(out, lens)) return HB_OK;
  hb_pieces_free(out);
  return hb_fail_memory(err, "tiles of a picture");
}

/* Frees the pieces. */
void hb_pieces_free(hb_pieces *pieces) {
  hb_free(pieces->piece);
  hb_free(pieces->start);
  hb_free(pieces->item);
  *pieces = (hb_pieces){0};
}

/* Depth at which the ray meets a ball whose centre is at origin - d; HUGE_VAL: missed. */
static inline double hit_ball(hb_v3 d, hb_v3 ray, double rr, double radius) {
  double b = hb_v3_dot(ray, d), c = hb_v3_dot(d, d) - radius * radius, h = b * b - rr * c;
  return h >= 0 ? (-b - sqrt(h)) / rr : HUGE_VAL;
}

/* Depth at which the ray meets the piece; HUGE_VAL: missed. */
static inline double hit_piece(const hb_piece *p, hb_v3 origin, hb_v3 ray) {
  hb_v3 d = hb_v3_sub(origin, p->a);
  double br = hb_v3_dot(p->ab, ray), bd = hb_v3_dot(p->ab, d), rr = hb_v3_dot(ray, ray);
  double a = p->bb * rr - br * br;
  if (a > 1e-12 * p->bb * rr) {
    double b = p->bb * hb_v3_dot(ray, d) - bd * br;
    double c = p->bb * (hb_v3_dot(d, d) - p->radius * p->radius) - bd * bd;
    double h = b * b - a * c;
    if (h < 0) return HUGE_VAL;
    double t = -b - sqrt(h), y = a * bd + t * br; /* both times a, to divide only where it is a hit */
    if (y > 0 && y < a * p->bb) return t / a;
    return hit_ball(y <= 0 ? d : hb_v3_sub(d, p->ab), ray, rr, p->radius);
  }
  return fmin(hit_ball(d, ray, rr, p->radius), hit_ball(hb_v3_sub(d, p->ab), ray, rr, p->radius));
}

/* A tile being drawn. */
typedef struct brush {
  hb_tile *tile;
  const hb_pieces *all;
  const hb_lens *lens;
  int corner[2]; /* its pixel */
  enum {
    COARSE,
    FINE,
    HALO
  } pass; /* samples with even i and j; the others of busy pixels; halos on all of these */
} brush;

/* Narrows x[0]..x[1] to where lo <= a x + c <= hi. */
static void narrow(double a, double c, double lo, double hi, double x[2]) {
  if (fabs(a) < 1e-9) {
    if (c < lo || c > hi) x[1] = x[0] - 1;
    return;
  }
  double p = (lo - c) / a, q = (hi - c) / a;
  x[0] = fmax(x[0], fmin(p, q));
  x[1] = fmin(x[1], fmax(p, q));
}

/* Samples from..to of the row whose pixel coordinate is about y, that lie in the strip around the piece. */
static void row_range(const brush *b, const hb_piece *p, double y, int out[2]) {
  bool halo = b->pass == HALO;
  double across = (halo ? p->halo : p->wide) + 0.2, length = sqrt(p->pp);
  double before = (halo ? p->halo : p->slack[0]) + 0.2, beyond = (halo ? p->halo : p->slack[1]) + 0.2;
  double start = b->corner[0] - p->pa[0], row = y - p->pa[1], x[2] = {start, start + HB_TILE};
  if (length > 1e-3) {
    narrow(p->pd[1] / length, -row * p->pd[0] / length, -across, across, x);
    narrow(p->pd[0] / length, row * p->pd[1] / length, -before, length + beyond, x);
  } else {
    if (fabs(row) > across + 1) x[1] = x[0] - 1;
    x[0] = fmax(x[0], -across - 1);
    x[1] = fmin(x[1], across + 1);
  }
  out[0] = (int)fmax(floor((x[0] - start) * HB_FINE) - 1, 0);
  out[1] = x[1] >= x[0] ? (int)fmin(ceil((x[1] - start) * HB_FINE) + 1, HB_TILE_SIDE) : 0;
}

/* Smooth step from 0 at 0 to 1 at 1. */
static inline double smooth(double x) {
  x = x < 0 ? 0 : x > 1 ? 1 : x;
  return x * x * (3 - 2 * x);
}

/* Darkens a sample that lies well behind the piece's axis and near its edge on the screen. */
static inline void test_halo(const brush *b, int k, const hb_piece *p, double x, double y) {
  hb_tile *tile = b->tile;
  double behind = (tile->depth[k] - p->front) / p->radius - HALO_BEHIND;
  if (!(behind > 0) || tile->piece[k] < 0) return;
  x -= p->pa[0];
  y -= p->pa[1];
  const hb_piece *own = &b->all->piece[tile->piece[k]];
  if (own->strand == p->strand) { /* a tube that leads away from the eye is not in front of itself */
    double way = fabs(own->arc - p->arc) / p->radius;
    behind = fmin(behind, 0.5 * (way - 1.5 * behind) - 4);
    if (!(behind > 0)) return;
  }
  double s = p->pp > 0 ? (x * p->pd[0] + y * p->pd[1]) / p->pp : 0;
  s = s < 0 ? 0 : s > 1 ? 1 : s;
  double ex = x - s * p->pd[0], ey = y - s * p->pd[1], dd = ex * ex + ey * ey;
  if (dd >= p->halo * p->halo) return;
  double strength = smooth((p->halo - sqrt(dd)) / (p->halo - p->edge)) * smooth(behind);
  if (strength > (double)tile->halo[k]) tile->halo[k] = (float)strength;
}

/* Keeps the hit at pixel coordinates x, y if it is the nearest one. */
static inline void test_hit(const brush *b, int k, int index, double x, double y) {
  const hb_piece *p = &b->all->piece[index];
  hb_v3 origin, ray;
  hb_lens_ray(b->lens, x, y, &origin, &ray);
  double t = hit_piece(p, origin, ray);
  if (!(t < b->tile->depth[k])) { /* neighbours share a ball: the first one along the tube has it */
    if (t > b->tile->depth[k] || !(t < HUGE_VAL)) return;
    if (b->all->piece[b->tile->piece[k]].node < p->node) return;
  }
  b->tile->depth[k] = t;
  b->tile->piece[k] = index;
}

/* The samples from..to of row j that belong to the pass. */
static void draw_row(const brush *b, int index, int j, const int range[2]) {
  const bool *busy = b->tile->busy + j / HB_FINE * HB_TILE;
  const hb_piece *p = &b->all->piece[index];
  int step = b->pass == COARSE ? 2 : 1, first = b->pass == COARSE ? range[0] & ~1 : range[0];
  for (int i = first; i < range[1]; i += step) {
    bool even = !(i & 1 || j & 1);
    if (even ? b->pass == FINE : !busy[i / HB_FINE]) continue;
    double least = b->pass == HALO ? HALO_BEHIND * p->radius : 0; /* behind its front, to be touched by it */
    if (b->tile->depth[j * HB_TILE_SIDE + i] - p->front <= least) continue;
    double x = b->corner[0] + i / HB_FINE + hb_sample_x(i % HB_FINE, j % HB_FINE);
    double y = b->corner[1] + j / HB_FINE + hb_sample_y(i % HB_FINE, j % HB_FINE);
    if (b->pass == HALO)
      test_halo(b, j * HB_TILE_SIDE + i, p, x, y);
    else
      test_hit(b, j * HB_TILE_SIDE + i, index, x, y);
  }
}

/* Rows of samples inside the piece's box. */
static void draw_piece(const brush *b, int index) {
  const hb_piece *p = &b->all->piece[index];
  double reach = (b->pass == HALO ? p->halo : p->wide) + 0.5;
  double top = fmin(p->pa[1], p->pa[1] + p->pd[1]) - reach - b->corner[1];
  double bottom = fmax(p->pa[1], p->pa[1] + p->pd[1]) + reach - b->corner[1];
  int j0 = (int)fmax(top * HB_FINE, 0), j1 = (int)fmin(bottom * HB_FINE + 1, HB_TILE_SIDE), range[2];
  for (int j = j0; j < j1; j++) {
    if (b->pass == COARSE && j & 1) continue;
    row_range(b, p, b->corner[1] + (j + 0.5) / HB_FINE, range);
    draw_row(b, index, j, range);
  }
}

/* Do two samples see different things: another tube, another depth, or one of them nothing? */
static bool differ(const hb_tile *tile, const hb_pieces *all, int k, int l) {
  if (tile->piece[k] < 0 || tile->piece[l] < 0) return tile->piece[k] >= 0 || tile->piece[l] >= 0;
  return fabs(tile->depth[k] - tile->depth[l]) > 0.5 * all->piece[tile->piece[k]].radius;
}

/* Marks the pixels that need all their samples: near an edge, and at the tile's rim, whose neighbours are
 * unknown. */
static void mark_busy(hb_tile *tile, const hb_pieces *all) {
  enum { STEP = HB_FINE / 2, LAST = HB_TILE - 1 };
  for (int y = 0; y < HB_TILE; y++)
    for (int x = 0; x < HB_TILE; x++) {
      bool busy = x == 0 || y == 0 || x == LAST || y == LAST;
      int first = y * HB_FINE * HB_TILE_SIDE + x * HB_FINE;
      for (int j = -1; j <= 2 && !busy; j++)
        for (int i = -1; i <= 2 && !busy; i++)
          busy = differ(tile, all, first, first + j * STEP * HB_TILE_SIDE + i * STEP);
      tile->busy[y * HB_TILE + x] = busy;
    }
}

/* Do the axes in a tile differ in depth by more than tubes that touch? */
static bool deep(const hb_pieces *all, int tile) {
  double lo = HUGE_VAL, hi = -HUGE_VAL, radius = HUGE_VAL;
  for (int n = all->start[tile]; n < all->start[tile + 1]; n++) {
    const hb_piece *p = &all->piece[all->item[n]];
    lo = fmin(lo, fmin(p->za, p->za + p->zd));
    hi = fmax(hi, fmax(p->za, p->za + p->zd));
    radius = fmin(radius, p->radius);
  }
  return hi - lo > 1.5 * radius;
}

/* The farthest hit in a tile. */
static double deepest(const hb_tile *tile) {
  double depth = -HUGE_VAL;
  for (int k = 0; k < HB_TILE_SIDE * HB_TILE_SIDE; k++)
    if (tile->piece[k] >= 0 && tile->depth[k] > depth) depth = tile->depth[k];
  return depth;
}

/* The farthest depth that a sample of the pass can still be nearer than; HUGE_VAL while one has met nothing.
 */
static double farthest(const brush *b) {
  double depth = -HUGE_VAL;
  int step = b->pass == COARSE ? 2 : 1;
  for (int j = 0; j < HB_TILE_SIDE; j += step)
    for (int i = 0; i < HB_TILE_SIDE; i += step) {
      if ((i & 1 || j & 1) && !b->tile->busy[j / HB_FINE * HB_TILE + i / HB_FINE]) continue;
      depth = fmax(depth, b->tile->depth[j * HB_TILE_SIDE + i]);
      if (depth >= HUGE_VAL) return depth;
    }
  return depth;
}

/* The pieces of the tile, the nearest first, until everything is hidden. */
static void draw_pieces(const brush *b, int tile) {
  enum { OFTEN = 32 };
  const hb_pieces *all = b->all;
  for (int n = all->start[tile], done = 0; n < all->start[tile + 1]; n++, done++) {
    if (done % OFTEN == OFTEN - 1 && farthest(b) <= all->piece[all->item[n]].front) return;
    draw_piece(b, all->item[n]);
  }
}

/* One tile. */
void hb_tile_draw(hb_tile *tile, const hb_pieces *pieces, const hb_lens *lens, int tx, int ty) {
  for (int k = 0; k < HB_TILE_SIDE * HB_TILE_SIDE; k++) {
    tile->depth[k] = HUGE_VAL;
    tile->piece[k] = -1;
    tile->halo[k] = 0;
  }
  int index = ty * pieces->nx + tx;
  brush b = {tile, pieces, lens, {lens->rect.x + tx * HB_TILE, lens->rect.y + ty * HB_TILE}, COARSE};
  draw_pieces(&b, index);
  mark_busy(tile, pieces);
  b.pass = FINE;
  draw_pieces(&b, index);
  if (!pieces->halos || !deep(pieces, index)) return;
  double depth = deepest(tile);
  b.pass = HALO;
  for (int n = pieces->start[index]; n < pieces->start[index + 1]; n++) {
    const hb_piece *p = &pieces->piece[pieces->item[n]];
    if (depth > p->front + HALO_BEHIND * p->radius) draw_piece(&b, pieces->item[n]);
  }
}
