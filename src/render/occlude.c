/* Shadows and sky light of tubes, worked out at points around every node and interpolated between them. */
#include "render/occlude.h"

#include "base/memory.h"
#include "math/rotation.h"

#include <limits.h>
#include <stdlib.h>

/* The lamp is a disc that spans this many radians each side, so shadows grow soft with distance. */
#define LAMP_HALF_ANGLE 0.09
/* A blocker counts in the sky up to this many radii. */
#define SKY_REACH 6.0
enum { MOST_CELLS_ACROSS = 256 };

/* Runs round the square |x| + |y| = 1 like an angle runs round a circle. */
double hb_around(double x, double y) {
  double sum = fabs(x) + fabs(y);
  if (!(sum > 0)) return 0;
  double turn = y / sum; /* -1..1 */
  turn = x < 0 ? 2 - turn : turn < 0 ? 4 + turn : turn;
  turn *= HB_AROUND / 4.0;
  return turn < HB_AROUND ? turn : 0;
}

/* The direction at a place on the square, not normalised. */
static void around_direction(int place, double *x, double *y) {
  double turn = 4.0 * place / HB_AROUND;
  *x = turn < 2 ? 1 - turn : turn - 3;
  *y = turn < 1 ? turn : turn < 3 ? 2 - turn : turn - 4;
}

/* Joins short pieces while they are short and straight enough; returns the number, fills out if not NULL. */
static int join_pieces(const hb_strands *s, hb_blocker *out) {
  int count = 0, start = 0;
  for (int i = 0; i + 1 < s->count; i++) {
    if (s->node[i].first) start = i;
    if (s->node[i].last) continue;
    const hb_node *a = &s->node[start], *b = &s->node[i + 1];
    double radius = s->look[a->tube].radius, wish = fmax(1.5 * radius, s->size / 400);
    hb_v3 ab = hb_v3_sub(b->p, a->p);
    double length = hb_v3_norm(ab);
    if (!b->last && length < wish && hb_v3_dot(a->t, b->t) > 0.97) continue;
    if (out) out[count] = (hb_blocker){a->p, ab, length, radius};
    count++;
    start = i + 1;
  }
  return count;
}

/* Allocates the starts of buckets. */
static bool buckets_open(hb_buckets *b, int count) {
  b->count = count;
  b->start = hb_alloc((size_t)count + 1, sizeof *b->start);
  return b->start != NULL;
}

/* Counts in start become places in item, which is allocated. */
static bool buckets_sum(hb_buckets *b) {
  size_t total = 0;
  for (int k = 0; k <= b->count; k++) {
    int here = b->start[k];
    b->start[k] = (int)total;
    total += (size_t)here;
    if (total > INT_MAX / 2) return false;
  }
  b->item = hb_alloc(total, sizeof *b->item);
  return b->item != NULL;
}

/* Filling moved every start to its end: moves them back. */
static void buckets_settle(hb_buckets *b) {
  for (int k = b->count; k > 0; k--) b->start[k] = b->start[k - 1];
  b->start[0] = 0;
}

/* Cells from..to along one axis, clipped to the plane. */
static void cells(double lo, double hi, double origin, double cell, int n, int out[2]) {
  out[0] = (int)fmin(fmax(floor((lo - origin) / cell), 0), n - 1);
  out[1] = (int)fmin(fmax(floor((hi - origin) / cell), 0), n - 1);
}

/* Height of a blocker's upper end, of one in the light's own coordinates. */
static double upper_end(const hb_blocker *b) { return fmax(b->a.z, b->a.z + b->ab.z); }

/* Order of two blockers by their upper ends. */
static int compare_height(const void *a, const void *b) {
  double x = upper_end(a), y = upper_end(b);
  return (x > y) - (x < y);
}

/* A vector in the light's own coordinates: two across, one towards the lamp. */
static hb_v3 to_light(const hb_occlusion *o, hb_v3 p) {
  return (hb_v3){hb_v3_dot(p, o->e1), hb_v3_dot(p, o->e2), hb_v3_dot(p, o->key)};
}

/* Blockers in the light's own coordinates, the lowest first. */
static void sort_heights(hb_occlusion *o) {
  for (int i = 0; i < o->blocker_count; i++) {
    const hb_blocker *b = &o->blocker[i];
    o->lit[i] = (hb_blocker){to_light(o, b->a), to_light(o, b->ab), b->length, b->radius};
    o->span = fmax(o->span, fabs(o->lit[i].ab.z));
  }
  if (o->blocker_count > 1) qsort(o->lit, (size_t)o->blocker_count, sizeof *o->lit, compare_height);
}

/* Puts every blocker in the cells that its shadow can touch; counts only while item is NULL. */
static void sort_plane(const hb_occlusion *o, hb_layer *l) {
  for (int i = 0; i < o->blocker_count; i++) {
    const hb_blocker *b = &o->lit[i];
    double bx = b->a.x + b->ab.x, by = b->a.y + b->ab.y;
    int cx[2], cy[2];
    cells(fmin(b->a.x, bx) - l->reach, fmax(b->a.x, bx) + l->reach, l->x0, l->cell, l->nx, cx);
    cells(fmin(b->a.y, by) - l->reach, fmax(b->a.y, by) + l->reach, l->y0, l->cell, l->ny, cy);
    for (int y = cy[0]; y <= cy[1]; y++)
      for (int x = cx[0]; x <= cx[1]; x++) {
        int k = y * l->nx + x;
        if (l->plane.item) l->plane.item[l->plane.start[k]] = i;
        l->plane.start[k]++;
      }
  }
}

/* The plane across the light for one layer: cells, blockers in them. lo, hi: box around the blockers. */
static bool make_plane(const hb_occlusion *o, hb_layer *l, const double lo[2], const double hi[2]) {
  double extent = fmax(hi[0] - lo[0], hi[1] - lo[1]) + 2 * l->reach;
  l->cell = fmax(l->reach, extent / MOST_CELLS_ACROSS);
  if (!(l->cell > 0)) l->cell = 1;
  l->x0 = lo[0] - l->reach;
  l->y0 = lo[1] - l->reach;
  l->nx = (int)fmin((hi[0] + l->reach - l->x0) / l->cell, MOST_CELLS_ACROSS) + 1;
  l->ny = (int)fmin((hi[1] + l->reach - l->y0) / l->cell, MOST_CELLS_ACROSS) + 1;
  if (!buckets_open(&l->plane, l->nx * l->ny)) return false;
  sort_plane(o, l);
  if (!buckets_sum(&l->plane)) return false;
  sort_plane(o, l);
  buckets_settle(&l->plane);
  return true;
}

/* Half width of a shadow's edge at a height above it. */
static double softness(const hb_occlusion *o, double height) {
  return fmin(fmax(o->soft * height, o->least_soft), o->most_soft);
}

/* All layers: near ones have narrow shadows, so a point has few blockers to look at in them. */
static bool make_layers(hb_occlusion *o, double radius) {
  double lo[2] = {0, 0}, hi[2] = {0, 0};
  for (int i = 0; i < o->blocker_count; i++)
    for (int end = 0; end < 2; end++) {
      hb_v3 p = hb_v3_axpy(o->lit[i].a, end, o->lit[i].ab);
      double q[2] = {p.x, p.y};
      for (int k = 0; k < 2; k++) {
        lo[k] = i + end > 0 ? fmin(lo[k], q[k]) : q[k];
        hi[k] = i + end > 0 ? fmax(hi[k], q[k]) : q[k];
      }
    }
  double top = o->most_soft / o->soft;
  for (int n = HB_LAYERS - 1; n >= 0; n--, top /= 4) {
    hb_layer *l = &o->layer[n];
    l->top = n == HB_LAYERS - 1 ? HUGE_VAL : top;
    l->reach = (radius + softness(o, l->top)) * (1 + 1e-9);
    if (!make_plane(o, l, lo, hi)) return false;
  }
  return true;
}

/* Bucket of a cell in space. */
static int hash_cell(const hb_occlusion *o, const int64_t cell[3]) {
  uint64_t h = (uint64_t)cell[0] * 0x9e3779b97f4a7c15u ^ (uint64_t)cell[1] * 0xc2b2ae3d27d4eb4fu ^
               (uint64_t)cell[2] * 0x165667b19e3779f9u;
  return (int)((h ^ h >> 29) % (uint64_t)o->space.count);
}

/* Cell of a point in space. */
static void cell_of(const hb_occlusion *o, hb_v3 p, int64_t cell[3]) {
  const double q[3] = {p.x, p.y, p.z};
  for (int k = 0; k < 3; k++) cell[k] = (int64_t)fmin(fmax(floor(q[k] / o->hash_cell), -1e15), 1e15);
}

/* Middle of a blocker. */
static hb_v3 middle(const hb_blocker *b) { return hb_v3_axpy(b->a, 0.5, b->ab); }

/* Blockers by the cell of their middle. */
static bool make_space(hb_occlusion *o) {
  if (!buckets_open(&o->space, 2 * o->blocker_count + 1)) return false;
  for (int pass = 0; pass < 2; pass++) {
    for (int i = 0; i < o->blocker_count; i++) {
      int64_t cell[3];
      cell_of(o, middle(&o->blocker[i]), cell);
      int k = hash_cell(o, cell);
      if (pass) o->space.item[o->space.start[k]] = i;
      o->space.start[k]++;
    }
    if (!pass && !buckets_sum(&o->space)) return false;
  }
  buckets_settle(&o->space);
  return true;
}

/* Smooth step from 0 at 0 to 1 at 1. */
static double smooth(double x) {
  x = x < 0 ? 0 : x > 1 ? 1 : x;
  return x * x * (3 - 2 * x);
}

/* How dark the shadow of one blocker is at a point, both in the light's own coordinates. */
static double shade_of(const hb_occlusion *o, const hb_blocker *b, hb_v3 p, double own) {
  double ax = b->a.x - p.x, ay = b->a.y - p.y;
  double bx = b->ab.x, by = b->ab.y, bb = bx * bx + by * by;
  double s = bb > 0 ? -(ax * bx + ay * by) / bb : 0;
  s = s < 0 ? 0 : s > 1 ? 1 : s;
  double height = b->a.z - p.z + s * b->ab.z;
  if (height < 0.5 * own) return 0; /* its own tube, or one below */
  double dx = ax + s * bx, dy = ay + s * by, soft = softness(o, height);
  if (dx * dx + dy * dy >= (b->radius + soft) * (b->radius + soft)) return 0;
  double shade = smooth((b->radius + soft - sqrt(dx * dx + dy * dy)) / (2 * soft));
  if (b->radius < soft) shade *= b->radius / soft;
  if (own > 0) shade *= smooth((height - 0.5 * own) / own);
  return shade;
}

/* The first of a bucket's blockers whose upper end is not below a height. */
static int first_above(const hb_occlusion *o, const hb_buckets *b, int bucket, double height) {
  int lo = b->start[bucket], hi = b->start[bucket + 1];
  while (lo < hi) {
    int middle = lo + (hi - lo) / 2;
    if (upper_end(&o->lit[b->item[middle]]) < height)
      lo = middle + 1;
    else
      hi = middle;
  }
  return lo;
}

/* No shadow from this height is darker than this: a thin tube does not cover the lamp. */
static double darkest(const hb_occlusion *o, double height) {
  double soft = softness(o, height), radius = o->strands->radius;
  return radius < soft ? radius / soft : 1;
}

/* The darkest of all blockers; neighbours on one tube overlap, so they are not added. Layer by layer from the
 * point up, and no farther than something darker than what has been found can come from. */
double hb_occlusion_sun(const hb_occlusion *o, hb_v3 point, double own) {
  hb_v3 p = to_light(o, point);
  double dark = 0, bottom = 0;
  for (int n = 0; n < HB_LAYERS && dark < darkest(o, bottom); n++) {
    const hb_layer *l = &o->layer[n];
    double fx = floor((p.x - l->x0) / l->cell), fy = floor((p.y - l->y0) / l->cell), from = bottom;
    bottom = l->top;
    if (!(fx >= 0 && fy >= 0 && fx < l->nx && fy < l->ny)) continue;
    int k = (int)fy * l->nx + (int)fx;
    for (int i = first_above(o, &l->plane, k, p.z + from); i < l->plane.start[k + 1]; i++) {
      const hb_blocker *b = &o->lit[l->plane.item[i]];
      double least = upper_end(b) - o->span - p.z; /* every later one is higher than this */
      if (least > l->top || (dark > 0 && dark >= darkest(o, least))) break;
      double shade = shade_of(o, b, p, own);
      if (shade > dark) dark = shade;
    }
  }
  return 1 - dark;
}

/* Vector from a point to the nearest one of a blocker's axis; d: from the point to its start. */
static hb_v3 towards(const hb_blocker *b, hb_v3 d) {
  double ll = b->length * b->length, s = ll > 0 ? -hb_v3_dot(d, b->ab) / ll : 0;
  return hb_v3_axpy(d, s < 0 ? 0 : s > 1 ? 1 : s, b->ab);
}

/* Blockers that can take sky from the surface around a node, `radius` away from it; returns their number, at
 * most `most`. */
static int gather(const hb_occlusion *o, hb_v3 p, double radius, int *near, int most) {
  int64_t centre[3], cell[3], other[3];
  int count = 0;
  cell_of(o, p, centre);
  for (int n = 0; n < 27; n++) {
    cell[0] = centre[0] + n % 3 - 1;
    cell[1] = centre[1] + n / 3 % 3 - 1;
    cell[2] = centre[2] + n / 9 - 1;
    int k = hash_cell(o, cell);
    for (int i = o->space.start[k]; i < o->space.start[k + 1] && count < most; i++) {
      const hb_blocker *b = &o->blocker[o->space.item[i]];
      hb_v3 way = towards(b, hb_v3_sub(b->a, p));
      double reach = SKY_REACH * b->radius + 1.001 * radius;
      if (hb_v3_dot(way, way) > reach * reach) continue;
      cell_of(o, middle(b), other);
      if (other[0] == cell[0] && other[1] == cell[1] && other[2] == cell[2]) near[count++] = o->space.item[i];
    }
  }
  return count;
}

/* Share of the sky above a surface point that blockers take: the projected area of each, over distance
 * squared. */
static double sky_taken(const hb_occlusion *o, hb_v3 p, hb_v3 n, const int *near, int count) {
  double taken = 0;
  for (int i = 0; i < count; i++) {
    const hb_blocker *b = &o->blocker[near[i]];
    hb_v3 v = towards(b, hb_v3_sub(b->a, p));
    double dd = hb_v3_dot(v, v), up = hb_v3_dot(v, n), reach = SKY_REACH * b->radius;
    if (!(up > 0) || dd >= reach * reach) continue;
    double distance = sqrt(dd), along = b->length > 0 ? hb_v3_dot(v, b->ab) / (distance * b->length) : 0;
    double across = sqrt(fmax(0, 1 - along * along)), fade = 1 - dd / (reach * reach);
    double area = 2 * b->radius * fmin(b->length, 2 * distance) * across;
    taken += up / distance * area / (HB_PI * fmax(dd, b->radius * b->radius)) * fade * fade;
  }
  return taken;
}

/* Normal of a tube at a node and an angle around it; the point of its surface there. */
static hb_v3 surface(const hb_node *node, double radius, int angle, hb_v3 *p) {
  double x, y;
  around_direction(angle, &x, &y);
  hb_v3 v = hb_v3_cross(node->t, node->u);
  hb_v3 n = hb_v3_unit(hb_v3_axpy(hb_v3_scale(x, node->u), y, v));
  *p = hb_v3_axpy(node->p, radius, n);
  return n;
}

/* The sky at all angles of a node at once: they share their neighbours. */
double hb_occlusion_node_sky(const hb_occlusion *o, int index, int angle) {
  enum { MOST_NEAR = 512 };
  float *row = o->sky + (size_t)index * HB_AROUND;
  if (row[angle] >= 0) return (double)row[angle];
  const hb_node *node = &o->strands->node[index];
  double radius = o->strands->look[node->tube].radius;
  int near[MOST_NEAR], count = gather(o, node->p, radius, near, MOST_NEAR);
  for (int a = 0; a < HB_AROUND; a++) {
    hb_v3 p, n = surface(node, radius, a, &p);
    row[a] = (float)(1 / (1 + 1.8 * sky_taken(o, p, n, near, count)));
  }
  return (double)row[angle];
}

/* The lamp is asked for a step away from the surface, or the soft edge of its own shadow would darken it. */
double hb_occlusion_node_sun(const hb_occlusion *o, int index, int angle) {
  float *sun = o->sun + (size_t)index * HB_AROUND + angle;
  if (*sun >= 0) return (double)*sun;
  const hb_node *node = &o->strands->node[index];
  double radius = o->strands->look[node->tube].radius;
  hb_v3 p, n = surface(node, radius, angle, &p);
  hb_v3 above = hb_v3_axpy(p, o->least_soft, n);
  *sun = hb_v3_dot(n, o->key) > -0.2 ? (float)hb_occlusion_sun(o, above, radius) : 0.0f;
  return (double)*sun;
}

/* Builds everything. */
hb_status hb_occlusion_make(const hb_strands *s, hb_v3 key, double pixel, hb_occlusion *o, hb_error *err) {
  *o = (hb_occlusion){.strands = s, .key = key};
  o->e1 = hb_any_normal(key);
  o->e2 = hb_v3_cross(key, o->e1);
  o->soft = LAMP_HALF_ANGLE;
  o->least_soft = fmax(0.3 * s->radius, 2.5 * pixel);
  o->most_soft = fmax(0.035 * s->size, 2 * o->least_soft);
  o->reach = SKY_REACH * s->radius;
  o->hash_cell = fmax(o->reach + fmax(1.5 * s->radius, s->size / 400), 1e-200);
  o->blocker_count = join_pieces(s, NULL);
  size_t points = (size_t)s->count * HB_AROUND;
  o->blocker = hb_alloc((size_t)o->blocker_count, sizeof *o->blocker);
  o->lit = hb_alloc((size_t)o->blocker_count, sizeof *o->lit);
  o->sky = hb_alloc(points, sizeof *o->sky);
  o->sun = hb_alloc(points, sizeof *o->sun);
  bool ready = o->blocker && o->lit && o->sky && o->sun;
  if (ready) {
    join_pieces(s, o->blocker);
    sort_heights(o);
    ready = make_layers(o, s->radius) && make_space(o);
  }
  if (!ready) {
    hb_occlusion_free(o);
    return hb_fail_memory(err, "shadows of a picture");
  }
  for (size_t k = 0; k < points; k++) o->sky[k] = o->sun[k] = -1;
  return HB_OK;
}

/* Frees the tables. */
void hb_occlusion_free(hb_occlusion *o) {
  hb_free(o->blocker);
  hb_free(o->lit);
  for (int n = 0; n < HB_LAYERS; n++) {
    hb_free(o->layer[n].plane.start);
    hb_free(o->layer[n].plane.item);
  }
  hb_free(o->space.start);
  hb_free(o->space.item);
  hb_free(o->sky);
  hb_free(o->sun);
  *o = (hb_occlusion){0};
}
