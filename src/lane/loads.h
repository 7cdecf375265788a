/* Loads that follow one law all along a rod, in lanes: src/force in the same operations (docs/theory, 8 and
 * 10.7). */
#ifndef HB_LANE_LOADS_H
#define HB_LANE_LOADS_H

#include "lane/seam.h"

/* The law of each lane. */
typedef struct burden {
  v3 acceleration, per_length, per_vertex, medium;
  lanes linear_n, linear_t, square_n, square_t, damping;
  hb_real keep, gain; /* the velocity that counts: keep v + gain (way of the step) */
} burden;

/* What lanes add up. */
typedef struct account {
  lanes work, lost;
} account;

/* Reads it from the record, which has the members of hb_uniform_load one behind the other. predict: 2 way/h -
 * v_old, the velocity at the end of a step of second order. */
INLINED burden burden_of(const hb_strip *s, double h, bool predict) {
  const lanes *u = s->law;
  return (burden){.acceleration = v3_load(u),
                  .per_length = v3_load(u + 3),
                  .per_vertex = v3_load(u + 6),
                  .medium = v3_load(u + 9),
                  .linear_n = u[12],
                  .linear_t = u[13],
                  .square_n = u[14],
                  .square_t = u[15],
                  .damping = u[HB_LAW_NUMBERS - 1],
                  .keep = predict ? R(-1) : R(1),
                  .gain = predict ? (hb_real)(2 / h) : R(0)};
}

/* Drag per length, with its sign turned, on a vertex between neighbours that are `chord` apart. */
INLINED v3 drag(const burden *b, v3 chord, v3 rate) {
  lanes square = v3_dot(chord, chord);
  v3 w = v3_sub(rate, b->medium), t = v3_scale(only(square > none(), R(1) / root(square)), chord);
  lanes along = v3_dot(w, t);
  v3 across = v3_less(w, along, t);
  lanes n = fused(b->square_n, root(v3_dot(across, across)), b->linear_n);
  lanes a = fused(b->square_t, size_of(along), b->linear_t) * along;
  return v3_axpy(v3_scale(n, across), a, t);
}

/* All of it at vertex r; before, after: places of the neighbours, the vertex's own where there is none. */
INLINED void load_vertex(hb_strip *s, const burden *b, int r, bool damped, bool windy, v3 before, v3 now,
                         v3 after, lane_mask counts, account *sum) {
  lanes m = ((const lanes *)s->mass)[r], w = ((const lanes *)s->weight)[r];
  lanes *load = (lanes *)s->load + 3 * r, *f = (lanes *)s->f + 3 * r;
  const lanes *v = b->keep < 0 ? s->v_old : s->v;
  v3 way = v3_sub(now, v3_load((const lanes *)s->x_old + 3 * r)), rate = v3_zero();
  v3 push = v3_axpy(v3_axpy(b->per_vertex, m, b->acceleration), w, b->per_length);
  if (damped || windy) rate = v3_axpy(v3_scale(all(b->keep), v3_load(v + 3 * r)), all(b->gain), way);
  if (windy) push = v3_less(push, w, drag(b, v3_sub(after, before), rate));
  push = v3_only(m > none(), push); /* phantoms have no mass */
  sum->work += only(counts, v3_dot(v3_add(v3_load(load), push), way));
  v3_store(load, push);
  v3 force = v3_add(v3_load(f), push);
  if (damped) {
    sum->lost += only(counts, m * v3_dot(way, way));
    force = v3_less(force, b->damping * m, rate);
  }
  v3_store(f, force);
}

/* The vertex before row 0 of each lane, `own` where there is none. */
INLINED v3 vertex_before(const hb_strip *s, v3 own) {
  const lanes *x = (const lanes *)s->x + 3 * (s->rows - 1);
  if (!s->before) return (v3){up(x[0], own.x[0]), up(x[1], own.y[0]), up(x[2], own.z[0])};
  const lanes *p = (const lanes *)s->before->x + 3 * (s->before->rows - 1);
  const int w = HB_LANES - 1;
  return (v3){up(x[0], p[0][w]), up(x[1], p[1][w]), up(x[2], p[2][w])};
}

/* The vertex behind the last row: row 1 of the next lane, if that lane has an edge. */
INLINED v3 vertex_behind(const hb_strip *s, v3 own) {
  const lanes *x = (const lanes *)s->x + 3, *count = s->count;
  if (!s->after) {
    lane_mask more = down(count[0], 0) > none();
    return v3_choose(more, (v3){down(x[0], 0), down(x[1], 0), down(x[2], 0)}, own);
  }
  const lanes *p = (const lanes *)s->after->x + 3;
  lane_mask more = down(count[0], (*(const lanes *)s->after->count)[0]) > none();
  return v3_choose(more, (v3){down(x[0], p[0][0]), down(x[1], p[1][0]), down(x[2], p[2][0])}, own);
}

/* Vertices that count where lanes end: of those that pieces share the copy that begins a piece does. */
INLINED lane_mask counts_at_end(const hb_strip *s) {
  lane_mask end = {0};
  if (!s->pieces) return all(1) > none();
  if (!s->after) end[HB_LANES - 1] = -1;
  return end;
}

/* All vertices of a strip. */
INLINED void load_rows(hb_strip *s, double h, bool predict, bool damped, bool windy) {
  const burden b = burden_of(s, h, predict);
  const lane_mask each = all(1) > none();
  const lanes *x = s->x;
  account sum = {none(), none()};
  v3 now = v3_load(x), before = s->pieces && windy ? vertex_before(s, now) : now;
  for (int r = 0; r < s->rows; r++) {
    v3 next = v3_load(x + 3 * r + 3), after = next;
    if (windy && r >= s->full_rows) after = v3_choose(real_edges(s, r), next, now);
    load_vertex(s, &b, r, damped, windy, before, now, after, each, &sum);
    before = now;
    now = next;
  }
  v3 after = s->pieces && windy ? vertex_behind(s, now) : now;
  load_vertex(s, &b, s->rows, damped, windy, before, now, after, counts_at_end(s), &sum);
  *(lanes *)s->work = sum.work;
  *(lanes *)s->lost = sum.lost;
}

/* Uniform loads, compiled for what there is. */
static void loads(hb_strip *s, double h, bool predict) {
  if (s->windy && s->damped)
    load_rows(s, h, predict, true, true);
  else if (s->windy)
    load_rows(s, h, predict, false, true);
  else if (s->damped)
    load_rows(s, h, predict, true, false);
  else
    load_rows(s, h, predict, false, false);
}

#endif
