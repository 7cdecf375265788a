/* The way between state and lanes. */
#include "lane/plan.h"

#include <math.h>
#include <string.h>

/* Where vertex i of the n-th rod is; the rod's last vertex may only exist as the end of a piece. */
hb_lane_place hb_unit_find(const hb_unit *unit, int n, int i) {
  if (!unit->pieces) return (hb_lane_place){unit->strips, n, i};
  int g = 0, lanes = unit->strips->lanes;
  if (unit->strip_count > 1) {
    int low = 0, high = unit->strip_count - 1; /* the strip with first_edge <= i */
    while (low < high) {
      int middle = (low + high + 1) / 2;
      if (unit->strips[middle].first_edge <= i)
        low = middle;
      else
        high = middle - 1;
    }
    g = low;
  }
  hb_strip *s = &unit->strips[g];
  int at = i - s->first_edge, lane = at / s->rows;
  if (lane == lanes) return (hb_lane_place){s, lanes - 1, s->rows};
  return (hb_lane_place){s, lane, at % s->rows};
}

/* Array of a strip by its offset. */
static void *array_of(const hb_strip *s, size_t offset) {
  void *array;
  memcpy(&array, (const char *)s + offset, sizeof array);
  return array;
}

/* Three numbers of a vertex. */
void hb_unit_get3(const hb_unit *unit, int n, int i, size_t array, double out[3]) {
  hb_lane_place p = hb_unit_find(unit, n, i);
  for (int c = 0; c < 3; c++)
    out[c] = hb_strip_get(p.strip, array_of(p.strip, array), 3 * (size_t)p.row + (size_t)c, p.lane);
}

/* The same, back; a vertex that begins a piece ends the one before, too. */
void hb_unit_set3(hb_unit *unit, int n, int i, size_t array, const double in[3]) {
  hb_lane_place p = hb_unit_find(unit, n, i), twin = p;
  bool shared = unit->pieces && p.row == 0 && (p.lane > 0 || p.strip->before);
  if (shared) {
    twin.strip = p.lane > 0 ? p.strip : p.strip - 1;
    twin.lane = p.lane > 0 ? p.lane - 1 : p.strip->lanes - 1;
    twin.row = twin.strip->rows;
  }
  for (int c = 0; c < 3; c++) {
    size_t at = 3 * (size_t)p.row + (size_t)c, copy = 3 * (size_t)twin.row + (size_t)c;
    hb_strip_set(p.strip, array_of(p.strip, array), at, p.lane, in[c]);
    if (shared) hb_strip_set(twin.strip, array_of(twin.strip, array), copy, twin.lane, in[c]);
    for (int l = unit->rod_count; n == 0 && !unit->pieces && l < p.strip->lanes; l++)
      hb_strip_set(p.strip, array_of(p.strip, array), at, l, in[c]);
  }
}

/* Numbers of an edge. */
void hb_unit_get_edge(const hb_unit *unit, int n, int j, size_t array, int numbers, double *out) {
  hb_lane_place p = hb_unit_find(unit, n, j);
  for (int c = 0; c < numbers; c++)
    out[c] = hb_strip_get(p.strip, array_of(p.strip, array), (size_t)(numbers * p.row + c), p.lane);
}

/* The same, back. */
void hb_unit_set_edge(hb_unit *unit, int n, int j, size_t array, int numbers, const double *in) {
  hb_lane_place p = hb_unit_find(unit, n, j);
  for (int c = 0; c < numbers; c++) {
    size_t at = (size_t)(numbers * p.row + c);
    hb_strip_set(p.strip, array_of(p.strip, array), at, p.lane, in[c]);
    for (int l = unit->rod_count; n == 0 && !unit->pieces && l < p.strip->lanes; l++)
      hb_strip_set(p.strip, array_of(p.strip, array), at, l, in[c]);
  }
}

/* One lane of a strip: which rod, its vertex in row 0, its last vertex. */
typedef struct lane_of {
  const hb_rod *rod;
  int first, last;
} lane_of;

/* Rod and first vertex of a lane; idle lanes repeat the first rod. */
static lane_of describe(const hb_model *m, const hb_unit *u, const hb_strip *s, int lane) {
  int n = u->pieces || lane >= u->rod_count ? 0 : lane;
  const hb_rod *rod = &m->rods[u->rods[n]];
  return (lane_of){rod, u->pieces ? s->first_edge + lane * s->rows : 0, rod->nv - 1};
}

/* One vertex array, from the state's (3 per slot). Phantoms get their rod's last entry, or 0. */
static void load3(const hb_strip *s, lane_of l, int lane, const double *from, void *to, bool phantom_zero) {
  for (int r = 0; r <= s->rows; r++) {
    int i = l.first + r;
    bool phantom = i > l.last;
    for (int c = 0; c < 3; c++) {
      double value = phantom && phantom_zero ? 0 : from[3 * (l.rod->first + (phantom ? l.last : i)) + c];
      hb_strip_set(s, to, 3 * (size_t)r + (size_t)c, lane, value);
    }
  }
}

/* And back; copies at the end of a piece are left out. */
static void store3(const hb_strip *s, lane_of l, int lane, const void *from, double *to) {
  for (int r = 0; r <= s->rows && l.first + r <= l.last; r++) {
    if (r == s->rows && s->pieces && l.first + r < l.last) break;
    for (int c = 0; c < 3; c++)
      to[3 * (l.rod->first + l.first + r) + c] = hb_strip_get(s, from, 3 * (size_t)r + (size_t)c, lane);
  }
}

/* The tangent of the edge in slot k. */
static hb_v3 tangent_of(const double *x, int k) {
  hb_v3 e = hb_v3_sub(hb_v3_load(x + 3 * k + 3), hb_v3_load(x + 3 * k));
  double length = sqrt(hb_v3_dot(e, e));
  return (hb_v3){e.x / length, e.y / length, e.z / length};
}

/* The director of the edge in slot k. In lanes it belongs to the edge as it is; in a state that somebody has
 * written to it may belong to another tangent, from which it has to come over. */
static hb_v3 director_of(const hb_state *state, int k) {
  hb_v3 d = hb_v3_load(state->m1 + 3 * k), was = hb_v3_load(state->tangent + 3 * k),
        is = tangent_of(state->x, k);
  return was.x == is.x && was.y == is.y && was.z == is.z ? d : hb_carry(d, was, is);
}

/* Frames and twist of general rods. follow: the state's positions are those that the lanes get, too. */
static void load_frames(const hb_strip *s, lane_of l, int lane, const hb_state *state, bool follow) {
  for (int r = 0; r <= s->rows; r++) {
    int i = l.first + r, slot = l.rod->first + i;
    bool edge = r < s->rows && i < l.last;
    if (r < s->rows) {
      double d[3] = {0, 0, 0};
      if (edge) hb_v3_store(d, follow ? director_of(state, slot) : hb_v3_load(state->m1 + 3 * slot));
      hb_strip_set(s, s->spin, (size_t)r, lane, edge ? state->spin[slot] : 0);
      for (int c = 0; c < 3; c++) hb_strip_set(s, s->m1, 3 * (size_t)r + (size_t)c, lane, d[c]);
    }
    hb_strip_set(s, s->twist, (size_t)r, lane, i > 0 && i < l.last ? state->twist[slot] : 0);
  }
}

/* And back. */
static void store_frames(const hb_strip *s, lane_of l, int lane, hb_state *state) {
  for (int r = 0; r < s->rows && l.first + r < l.last; r++) {
    int slot = l.rod->first + l.first + r;
    double x[6];
    for (int c = 0; c < 3; c++)
      state->m1[3 * slot + c] = hb_strip_get(s, s->m1, 3 * (size_t)r + (size_t)c, lane);
    for (int c = 0; c < 6; c++) x[c] = hb_strip_get(s, s->x, 3 * (size_t)r + (size_t)c, lane);
    hb_v3_store(state->tangent + 3 * slot, tangent_of(x, 0));
    state->spin[slot] = hb_strip_get(s, s->spin, (size_t)r, lane);
    state->twist[slot] = l.first + r > 0 ? hb_strip_get(s, s->twist, (size_t)r, lane) : 0;
  }
}

/* Frames of the n-th rod alone, with new tangents known to the state. */
void hb_unit_load_frames(const hb_model *model, const hb_state *state, hb_unit *unit, int n) {
  for (int g = 0; g < unit->strip_count; g++)
    for (int lane = 0; lane < unit->strips[g].lanes; lane++)
      if (unit->pieces || lane == n || (n == 0 && lane >= unit->rod_count))
        load_frames(&unit->strips[g], describe(model, unit, &unit->strips[g], lane), lane, state, false);
}

/* And back. */
void hb_unit_store_frames(const hb_model *model, hb_state *state, const hb_unit *unit, int n) {
  for (int g = 0; g < unit->strip_count; g++)
    for (int lane = 0; lane < unit->strips[g].lanes; lane++)
      if (unit->pieces || lane == n)
        store_frames(&unit->strips[g], describe(model, unit, &unit->strips[g], lane), lane, state);
}

/* All arrays that carry a run on. */
void hb_unit_load(const hb_model *model, const hb_state *state, hb_unit *unit) {
  for (int g = 0; g < unit->strip_count; g++) {
    hb_strip *s = &unit->strips[g];
    for (int lane = 0; lane < s->lanes; lane++) {
      lane_of l = describe(model, unit, s, lane);
      load3(s, l, lane, state->x, s->x, false);
      load3(s, l, lane, state->v, s->v, true);
      load3(s, l, lane, state->force, s->f, true);
      if (s->general) load_frames(s, l, lane, state, true);
      for (int r = 0; r < s->rows; r++) {
        int j = l.first + r;
        hb_strip_set(s, s->lambda, (size_t)r, lane, j < l.last ? state->lambda[l.rod->first + j] : 0);
      }
    }
  }
}

/* And back. */
void hb_unit_store(const hb_model *model, hb_state *state, const hb_unit *unit) {
  for (int g = 0; g < unit->strip_count; g++) {
    const hb_strip *s = &unit->strips[g];
    for (int lane = 0; lane < (unit->pieces ? s->lanes : unit->rod_count); lane++) {
      lane_of l = describe(model, unit, s, lane);
      store3(s, l, lane, s->x, state->x);
      store3(s, l, lane, s->v, state->v);
      store3(s, l, lane, s->f, state->force);
      if (s->general) store_frames(s, l, lane, state);
      for (int r = 0; r < s->rows && l.first + r < l.last; r++)
        state->lambda[l.rod->first + l.first + r] = hb_strip_get(s, s->lambda, (size_t)r, lane);
    }
  }
}

/* One vertex array of the n-th rod to the state's layout. */
void hb_unit_store3(const hb_model *model, const hb_unit *unit, int n, size_t array, double *to) {
  for (int g = 0; g < unit->strip_count; g++) {
    const hb_strip *s = &unit->strips[g];
    for (int lane = unit->pieces ? 0 : n; lane < (unit->pieces ? s->lanes : n + 1); lane++)
      store3(s, describe(model, unit, s, lane), lane, array_of(s, array), to);
  }
}

/* Adds to one vertex array of the n-th rod, all copies of its vertices. */
void hb_unit_add3(const hb_model *model, hb_unit *unit, int n, size_t array, const double *from) {
  for (int g = 0; g < unit->strip_count; g++) {
    hb_strip *s = &unit->strips[g];
    for (int lane = 0; lane < s->lanes; lane++) {
      lane_of l = describe(model, unit, s, lane);
      if (!unit->pieces && lane != n && !(n == 0 && lane >= unit->rod_count)) continue;
      void *to = array_of(s, array);
      for (int r = 0; r <= s->rows && l.first + r <= l.last; r++)
        for (int c = 0; c < 3; c++) {
          size_t at = 3 * (size_t)r + (size_t)c;
          hb_strip_set(s, to, at, lane,
                       hb_strip_get(s, to, at, lane) + from[3 * (l.rod->first + l.first + r) + c]);
        }
    }
  }
}

/* Sets one vertex array of the n-th rod to zero, all copies. */
void hb_unit_clear3(hb_unit *unit, int n, size_t array) {
  for (int g = 0; g < unit->strip_count; g++) {
    hb_strip *s = &unit->strips[g];
    for (int lane = 0; lane < s->lanes; lane++) {
      if (!unit->pieces && lane != n && !(n == 0 && lane >= unit->rod_count)) continue;
      for (size_t k = 0; k < 3 * ((size_t)s->rows + 1); k++) hb_strip_set(s, array_of(s, array), k, lane, 0);
    }
  }
}
