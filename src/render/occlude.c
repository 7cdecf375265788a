/* Shadows and sky light of tubes, worked out at points around every node and interpolated between them. */
#include "render/occlude.h"

#include "base/memory.h"
#include "math/rotation.h"

#include <limits.h>

/* The lamp is a disc that spans this many radians each side, so shadows grow soft with distance. */
#define LAMP_HALF_ANGLE 0.09
/* A blocker counts in the sky up to this many radii. */
#define SKY_REACH 6.0
enum { MOST_CELLS_ACROSS = 192 };

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

/* Puts every blocker in the cells that its shadow can touch; counts only while item is NULL. */
static void sort_plane(hb_occlusion *o) {
  for (int i = 0; i < o->blocker_count; i++) {
    const hb_blocker *b = &o->blocker[i];
    double reach = b->radius + o->most_soft;
    double ax = hb_v3_dot(b->a, o->e1), ay = hb_v3_dot(b->a, o->e2);
    double bx = ax + hb_v3_dot(b->ab, o->e1), by = ay + hb_v3_dot(b->ab, o->e2);
    int cx[2], cy[2];
    cells(fmin(ax, bx) - reach, fmax(ax, bx) + reach, o->x0, o->cell, o->nx, cx);
    cells(fmin(ay, by) - reach, fmax(ay, by) + reach, o->y0, o->cell, o->ny, cy);
    for (int y = cy[0]; y <= cy[1]; y++)
      for (int x = cx[0]; x <= cx[1]; x++) {
        int k = y * o->nx + x;
        if (o->plane.item) o->plane.item[o->plane.start[k]] = i;
        o->plane.start[k]++;
      }
  }
}

/* The plane across the light: limits, cells, blockers in them. */
static bool make_plane(hb_occlusion *o, const hb_strands *s) {
  double lo[2] = {0, 0}, hi[2] = {0, 0};
  for (int i = 0; i < o->blocker_count; i++)
    for (int end = 0; end < 2; end++) {
      hb_v3 p = hb_v3_axpy(o->blocker[i].a, end, o->blocker[i].ab);
      double q[2] = {hb_v3_dot(p, o->e1), hb_v3_dot(p, o->e2)};
      for (int k = 0; k < 2; k++) {
        lo[k] = i + end > 0 ? fmin(lo[k], q[k]) : q[k];
        hi[k] = i + end > 0 ? fmax(hi[k], q[k]) : q[k];
      }
    }
  double margin = s->radius + o->most_soft, extent = fmax(hi[0] - lo[0], hi[1] - lo[1]) + 2 * margin;
  o->cell = fmax(margin, extent / MOST_CELLS_ACROSS);
  if (!(o->cell > 0)) o->cell = 1;
  o->x0 = lo[0] - margin;
  o->y0 = lo[1] - margin;
  o->nx = (int)fmin((hi[0] + margin - o->x0) / o->cell, MOST_CELLS_ACROSS) + 1;
  o->ny = (int)fmin((hi[1] + margin - o->y0) / o->cell, MOST_CELLS_ACROSS) + 1;
  if (!buckets_open(&o->plane, o->nx * o->ny)) return false;
  sort_plane(o);
  if (!buckets_sum(&o->plane)) return false;
  sort_plane(o);
  buckets_settle(&o->plane);
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

/* The darkest of all blockers in the cell; neighbours on one tube overlap, so they are not added. */
double hb_occlusion_sun(const hb_occlusion *o, hb_v3 p, double own) {
  double x = hb_v3_dot(p, o->e1), y = hb_v3_dot(p, o->e2);
  double fx = floor((x - o->x0) / o->cell), fy = floor((y - o->y0) / o->cell), dark = 0;
  if (!(fx >= 0 && fy >= 0 && fx < o->nx && fy < o->ny)) return 1;
  int k = (int)fy * o->nx + (int)fx;
  for (int n = o->plane.start[k]; n < o->plane.start[k + 1]; n++) {
    const hb_blocker *b = &o->blocker[o->plane.item[n]];
    hb_v3 d = hb_v3_sub(b->a, p);
    double ax = hb_v3_dot(d, o->e1), ay = hb_v3_dot(d, o->e2);
    double bx = hb_v3_dot(b->ab, o->e1), by = hb_v3_dot(b->ab, o->e2), bb = bx * bx + by * by;
    double s = bb > 0 ? -(ax * bx + ay * by) / bb : 0;
    s = s < 0 ? 0 : s > 1 ? 1 : s;
    double height = hb_v3_dot(d, o->key) + s * hb_v3_dot(b->ab, o->key);
    if (height < 0.5 * own) continue; /* its own tube, or one below */
    double dx = ax + s * bx, dy = ay + s * by;
    double soft = fmin(fmax(o->soft * height, o->least_soft), o->most_soft);
    if (dx * dx + dy * dy >= (b->radius + soft) * (b->radius + soft)) continue;
    double shade = smooth((b->radius + soft - sqrt(dx * dx + dy * dy)) / (2 * soft));
    if (b->radius < soft) shade *= b->radius / soft;
    if (own > 0) shade *= smooth((height - 0.5 * own) / own);
    if (shade > dark) dark = shade;
  }
  return 1 - dark;
}

/* Blockers near a node; returns their number, at most `most`. */
static int gather(const hb_occlusion *o, hb_v3 p, int *near, int most) {
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
    hb_v3 d = hb_v3_sub(b->a, p);
    double ll = b->length * b->length, s = ll > 0 ? -hb_v3_dot(d, b->ab) / ll : 0;
    hb_v3 v = hb_v3_axpy(d, s < 0 ? 0 : s > 1 ? 1 : s, b->ab);
    double dd = hb_v3_dot(v, v), up = hb_v3_dot(v, n), reach = SKY_REACH * b->radius;
    if (!(up > 0) || dd >= reach * reach) continue;
    double distance = sqrt(dd), along = ll > 0 ? hb_v3_dot(v, b->ab) / (distance * b->length) : 0;
    double across = sqrt(fmax(0, 1 - along * along)), fade = 1 - dd / (reach * reach);
    double area = 2 * b->radius * fmin(b->length, 2 * distance) * across;
    taken += up / distance * area / (HB_PI * fmax(dd, b->radius * b->radius)) * fade * fade;
  }
  return taken;
}

/* Sky and sun at the points around every node. */
static void fill_tables(hb_occlusion *o, const hb_strands *s) {
  enum { MOST_NEAR = 512 };
  int near[MOST_NEAR];
  for (int i = 0; i < s->count; i++) {
    const hb_node *node = &s->node[i];
    double radius = s->look[node->tube].radius;
    hb_v3 v = hb_v3_cross(node->t, node->u);
    int count = gather(o, node->p, near, MOST_NEAR);
    for (int a = 0; a < HB_AROUND; a++) {
      double x, y;
      around_direction(a, &x, &y);
      hb_v3 n = hb_v3_unit(hb_v3_axpy(hb_v3_scale(x, node->u), y, v)), p = hb_v3_axpy(node->p, radius, n);
      size_t k = (size_t)i * HB_AROUND + (size_t)a;
      double taken = sky_taken(o, p, n, near, count);
      o->sky[k] = (float)(1 / (1 + 1.8 * taken));
      /* a step away from the surface, or the soft edge of its own shadow would darken it */
      hb_v3 above = hb_v3_axpy(p, o->least_soft, n);
      o->sun[k] = hb_v3_dot(n, o->key) > -0.2 ? (float)hb_occlusion_sun(o, above, radius) : 0.0f;
    }
  }
}

/* Builds everything. */
hb_status hb_occlusion_make(const hb_strands *s, hb_v3 key, double pixel, hb_occlusion *o, hb_error *err) {
  *o = (hb_occlusion){.key = key};
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
  o->sky = hb_alloc(points, sizeof *o->sky);
  o->sun = hb_alloc(points, sizeof *o->sun);
  bool ready = o->blocker && o->sky && o->sun;
  if (ready) {
    join_pieces(s, o->blocker);
    ready = make_plane(o, s) && make_space(o);
  }
  if (!ready) {
    hb_occlusion_free(o);
    return hb_fail_memory(err, "shadows of a picture");
  }
  fill_tables(o, s);
  return HB_OK;
}

/* Frees the tables. */
void hb_occlusion_free(hb_occlusion *o) {
  hb_free(o->blocker);
  hb_free(o->plane.start);
  hb_free(o->plane.item);
  hb_free(o->space.start);
  hb_free(o->space.item);
  hb_free(o->sky);
  hb_free(o->sun);
  *o = (hb_occlusion){0};
}
