/* Optical depths on a grid. */
#include "render/thicket.h"

#include "base/memory.h"
#include "math/rotation.h"

/* Cells along the longest side. */
enum { LONGEST = 72 };
/* Mean width of a tube of any direction, seen along a line, over its diameter. */
#define MEAN_WIDTH 0.7853981633974483
/* Share of the light that a hair takes out of the way for good; the rest goes on, scattered. */
#define TAKEN_SUN 0.55
#define TAKEN_SKY 0.40

/* exp(-x) for x >= 0, within 2 %: by arithmetic alone, the same bits with every C library. */
static double fading(double x) {
  double y = 1 + x * (0.125 + x * (1.0 / 128 + x * (1.0 / 3072))); /* of exp(x / 8) */
  y *= y;
  y *= y;
  y *= y;
  return 1 / y;
}

/* A point in the grid's coordinates, in cells; the middle of cell i is at i. */
static void locate(const hb_thicket *t, hb_v3 p, double at[3]) {
  for (int k = 0; k < 3; k++) at[k] = (hb_v3_dot(p, t->axis[k]) - t->corner[k]) / t->cell - 0.5;
}

/* Index of a cell. */
static size_t cell_of(const hb_thicket *t, int x, int y, int z) {
  return ((size_t)z * (size_t)t->n[1] + (size_t)y) * (size_t)t->n[0] + (size_t)x;
}

/* Puts an amount into the eight cells around a place. */
static void deposit(const hb_thicket *t, const double at[3], double amount, float *density) {
  int low[3];
  double f[3];
  for (int k = 0; k < 3; k++) {
    low[k] = (int)fmin(fmax(floor(at[k]), 0), t->n[k] - 2);
    f[k] = fmin(fmax(at[k] - low[k], 0), 1);
  }
  for (int c = 0; c < 8; c++) {
    double share = (c & 1 ? f[0] : 1 - f[0]) * (c & 2 ? f[1] : 1 - f[1]) * (c & 4 ? f[2] : 1 - f[2]);
    density[cell_of(t, low[0] + (c & 1), low[1] + (c >> 1 & 1), low[2] + (c >> 2 & 1))] +=
        (float)(share * amount);
  }
}

/* Area of tube per volume, times the size of a cell: the optical depth of a cell. */
static void fill(const hb_thicket *t, const hb_strands *s, float *density) {
  for (int i = 0; i + 1 < s->count; i++) {
    const hb_node *a = &s->node[i], *b = a + 1;
    if (a->last) continue;
    hb_v3 way = hb_v3_sub(b->p, a->p);
    double length = hb_v3_norm(way), at[3];
    int steps = (int)fmin(ceil(length / (0.5 * t->cell)), 1000);
    double area =
        2 * s->look[a->tube].radius * length * MEAN_WIDTH / (t->cell * t->cell) / (steps > 0 ? steps : 1);
    for (int k = 0; k < steps; k++) {
      locate(t, hb_v3_axpy(a->p, (k + 0.5) / steps, way), at);
      deposit(t, at, area, density);
    }
  }
}

/* Sums the depths of cells from one side of the grid to the other, along one axis. */
static void sum_way(const hb_thicket *t, const float *density, int way) {
  int axis = way / 2, u = axis == 0 ? 1 : 0, v = axis == 2 ? 1 : 2, at[3];
  for (at[u] = 0; at[u] < t->n[u]; at[u]++)
    for (at[v] = 0; at[v] < t->n[v]; at[v]++) {
      double sum = 0;
      for (int k = 0; k < t->n[axis]; k++) {
        at[axis] = way % 2 ? k : t->n[axis] - 1 - k; /* even: from the positive side */
        size_t cell = cell_of(t, at[0], at[1], at[2]);
        t->depth[cell * HB_THICKET_WAYS + (size_t)way] = (float)(sum + 0.5 * (double)density[cell]);
        sum += (double)density[cell];
      }
    }
}

/* The grid around all nodes: a cell wider than they are on every side. */
static void place(const hb_strands *s, hb_thicket *t) {
  double lo[3] = {0, 0, 0}, hi[3] = {0, 0, 0}, longest = 0;
  for (int i = 0; i < s->count; i++)
    for (int k = 0; k < 3; k++) {
      double x = hb_v3_dot(s->node[i].p, t->axis[k]);
      lo[k] = i ? fmin(lo[k], x) : x;
      hi[k] = i ? fmax(hi[k], x) : x;
    }
  for (int k = 0; k < 3; k++) longest = fmax(longest, hi[k] - lo[k]);
  t->cell = longest > 0 ? longest / LONGEST : 1;
  for (int k = 0; k < 3; k++) {
    t->corner[k] = lo[k] - t->cell;
    t->n[k] = (int)((hi[k] - lo[k]) / t->cell) + 3;
  }
}

/* Cells, amounts, sums. */
hb_status hb_thicket_make(const hb_strands *strands, hb_v3 key, hb_thicket *out, hb_error *err) {
  *out = (hb_thicket){.axis = {{0, 0, 0}, {0, 0, 0}, key}};
  out->axis[0] = hb_any_normal(key);
  out->axis[1] = hb_v3_cross(key, out->axis[0]);
  place(strands, out);
  size_t cells = (size_t)out->n[0] * (size_t)out->n[1] * (size_t)out->n[2];
  float *density = hb_alloc(cells, sizeof *density);
  out->depth = hb_alloc(cells, HB_THICKET_WAYS * sizeof *out->depth);
  if (!density || !out->depth) {
    hb_free(density);
    hb_thicket_free(out);
    return hb_fail_memory(err, "light of a picture");
  }
  fill(out, strands, density);
  for (int way = 0; way < HB_THICKET_WAYS; way++) sum_way(out, density, way);
  hb_free(density);
  return HB_OK;
}

/* Frees the grid. */
void hb_thicket_free(hb_thicket *thicket) {
  hb_free(thicket->depth);
  *thicket = (hb_thicket){.depth = NULL};
}

/* Depths at a point between the cells' middles; beside the grid there is nothing, below it the whole depth.
 */
static void depths(const hb_thicket *t, hb_v3 p, int from, int to, double out[HB_THICKET_WAYS]) {
  double at[3], f[3];
  int low[3];
  locate(t, p, at);
  for (int w = from; w < to; w++) out[w] = 0;
  for (int k = 0; k < 3; k++) {
    if (!(k == 2 ? at[k] < t->n[k] : at[k] > -1 && at[k] < t->n[k])) return;
    low[k] = (int)fmin(fmax(floor(at[k]), 0), t->n[k] - 2);
    f[k] = fmin(fmax(at[k] - low[k], 0), 1);
  }
  for (int c = 0; c < 8; c++) {
    double share = (c & 1 ? f[0] : 1 - f[0]) * (c & 2 ? f[1] : 1 - f[1]) * (c & 4 ? f[2] : 1 - f[2]);
    size_t cell = cell_of(t, low[0] + (c & 1), low[1] + (c >> 1 & 1), low[2] + (c >> 2 & 1));
    for (int w = from; w < to; w++) out[w] += share * (double)t->depth[cell * HB_THICKET_WAYS + (size_t)w];
  }
}

/* Towards the lamp. */
double hb_thicket_sun(const hb_thicket *thicket, hb_v3 p) {
  double depth[HB_THICKET_WAYS];
  depths(thicket, p, 4, 5, depth);
  return fading(TAKEN_SUN * depth[4]);
}

/* The sky comes from all sides, most of it from where the lamp is, little from below. */
void hb_thicket_light(const hb_thicket *thicket, hb_v3 p, double *sun, double *sky) {
  static const double weight[HB_THICKET_WAYS] = {0.16, 0.16, 0.16, 0.16, 0.30, 0.06};
  double depth[HB_THICKET_WAYS];
  depths(thicket, p, 0, HB_THICKET_WAYS, depth);
  *sun = fading(TAKEN_SUN * depth[4]);
  *sky = 0;
  for (int w = 0; w < HB_THICKET_WAYS; w++) *sky += weight[w] * fading(TAKEN_SKY * depth[w]);
}
