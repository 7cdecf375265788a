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

/* One lane of a strip: which rod, its vertex in row 0 (nv: no vertex at all), its last vertex. */
typedef struct lane_of {
  const hb_rod *rod;
  int first, last;
} lane_of;

/* Rod and first vertex of a lane; idle lanes repeat the first rod. */
static lane_of describe(const hb_model *m, const hb_unit *u, const hb_strip *s, int lane) {
  int n = u->pieces || lane >= u->rod_count ? 0 : lane;
  const hb_rod *rod = &m->rods[u->rods[n]];
  int first = u->pieces ? s->first_edge + lane * s->rows : 0;
  return (lane_of){rod, first < rod->nv ? first : rod->nv, rod->nv - 1};
}

/* Numbers first .. first + count - 1 of one lane of an array, in double: the loops that everything here is
 * made of, without a question per number. */
static void fetch(const hb_strip *s, const void *array, size_t first, int lane, int count,
                  double *restrict to) {
  if (s->single) {
    const float *from = (const float *)array + HB_LANES_SINGLE * first + (size_t)lane;
    for (int k = 0; k < count; k++) to[k] = (double)from[HB_LANES_SINGLE * k];
  } else {
    const double *from = (const double *)array + HB_LANES_DOUBLE * first + (size_t)lane;
    for (int k = 0; k < count; k++) to[k] = from[HB_LANES_DOUBLE * k];
  }
}

/* And back. */
static void put(const hb_strip *s, void *array, size_t first, int lane, int count,
                const double *restrict from) {
  if (s->single) {
    float *to = (float *)array + HB_LANES_SINGLE * first + (size_t)lane;
    for (int k = 0; k < count; k++) to[HB_LANES_SINGLE * k] = (float)from[k];
  } else {
    double *to = (double *)array + HB_LANES_DOUBLE * first + (size_t)lane;
    for (int k = 0; k < count; k++) to[HB_LANES_DOUBLE * k] = from[k];
  }
}

/* Adds to them. */
static void add_to(const hb_strip *s, void *array, size_t first, int lane, int count,
                   const double *restrict from) {
  if (s->single) {
    float *to = (float *)array + HB_LANES_SINGLE * first + (size_t)lane;
    for (int k = 0; k < count; k++)
      to[HB_LANES_SINGLE * k] = (float)((double)to[HB_LANES_SINGLE * k] + from[k]);
  } else {
    double *to = (double *)array + HB_LANES_DOUBLE * first + (size_t)lane;
    for (int k = 0; k < count; k++) to[HB_LANES_DOUBLE * k] += from[k];
  }
}

/* Sets them to zero. */
static void wipe(const hb_strip *s, void *array, size_t first, int lane, int count) {
  if (s->single) {
    float *to = (float *)array + HB_LANES_SINGLE * first + (size_t)lane;
    for (int k = 0; k < count; k++) to[HB_LANES_SINGLE * k] = 0;
  } else {
    double *to = (double *)array + HB_LANES_DOUBLE * first + (size_t)lane;
    for (int k = 0; k < count; k++) to[HB_LANES_DOUBLE * k] = 0;
  }
}

/* How many of a lane's rows 0 .. K hold vertices of its rod. */
static int vertices_in(const hb_strip *s, lane_of l) {
  int count = l.last - l.first + 1;
  return count < 0 ? 0 : count <= s->rows ? count : s->rows + 1;
}

/* How many of its rows 0 .. K - 1 hold edges. */
static int edges_in(const hb_strip *s, lane_of l) {
  int count = l.last - l.first;
  return count < 0 ? 0 : count < s->rows ? count : s->rows;
}

/* One vertex array, from the state's (3 per slot). Phantoms get their rod's last entry, or 0. */
static void load3(const hb_strip *s, lane_of l, int lane, const double *from, void *to, bool phantom_zero) {
  int real = vertices_in(s, l);
  const double *rod = from + 3 * l.rod->first;
  put(s, to, 0, lane, 3 * real, rod + 3 * l.first);
  if (phantom_zero) wipe(s, to, 3 * (size_t)real, lane, 3 * (s->rows + 1 - real));
  for (int r = real; !phantom_zero && r <= s->rows; r++) put(s, to, 3 * (size_t)r, lane, 3, rod + 3 * l.last);
}

/* And back; copies at the end of a piece are left out. */
static void store3(const hb_strip *s, lane_of l, int lane, const void *from, double *to) {
  int count = vertices_in(s, l);
  if (s->pieces && l.first + s->rows < l.last) count = s->rows;
  fetch(s, from, 0, lane, 3 * count, to + 3 * (l.rod->first + l.first));
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
  int edges = edges_in(s, l), slot = l.rod->first + l.first, rest = s->rows - edges;
  int from = l.first == 0, to = edges < s->rows ? edges : l.first + s->rows < l.last ? s->rows + 1 : s->rows;
  put(s, s->spin, 0, lane, edges, state->spin + slot);
  wipe(s, s->spin, (size_t)edges, lane, rest);
  put(s, s->m1, 0, lane, 3 * edges, state->m1 + 3 * slot);
  for (int r = 0; follow && r < edges; r++) {
    double d[3];
    hb_v3_store(d, director_of(state, slot + r));
    put(s, s->m1, 3 * (size_t)r, lane, 3, d);
  }
  wipe(s, s->m1, 3 * (size_t)edges, lane, 3 * rest);
  wipe(s, s->twist, 0, lane, s->rows + 1); /* of ends and phantoms */
  if (to > from) put(s, s->twist, (size_t)from, lane, to - from, state->twist + slot + from);
}

/* And back. */
static void store_frames(const hb_strip *s, lane_of l, int lane, hb_state *state) {
  int edges = edges_in(s, l), slot = l.rod->first + l.first;
  if (edges == 0) return;
  fetch(s, s->m1, 0, lane, 3 * edges, state->m1 + 3 * slot);
  fetch(s, s->spin, 0, lane, edges, state->spin + slot);
  fetch(s, s->twist, 0, lane, edges, state->twist + slot);
  if (l.first == 0) state->twist[slot] = 0;
  for (int r = 0; r < edges; r++) {
    double x[6];
    fetch(s, s->x, 3 * (size_t)r, lane, 6, x);
    hb_v3_store(state->tangent + 3 * (slot + r), tangent_of(x, 0));
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
    s->split = s->known_t = false;
    for (int lane = 0; lane < s->lanes; lane++) {
      lane_of l = describe(model, unit, s, lane);
      load3(s, l, lane, state->x, s->x, false);
      load3(s, l, lane, state->v, s->v, true);
      load3(s, l, lane, state->force, s->f, true);
      if (s->loaded) load3(s, l, lane, state->load, s->load, true);
      if (s->general) load_frames(s, l, lane, state, true);
      int edges = edges_in(s, l);
      put(s, s->lambda, 0, lane, edges, state->lambda + l.rod->first + l.first);
      wipe(s, s->lambda, (size_t)edges, lane, s->rows - edges);
    }
  }
}

/* And back. */
void hb_unit_store(const hb_model *model, hb_state *state, hb_unit *unit) {
  for (int g = 0; g < unit->strip_count; g++) {
    hb_strip *s = &unit->strips[g];
    unit->kernels->assemble(s);
    for (int lane = 0; lane < (unit->pieces ? s->lanes : unit->rod_count); lane++) {
      lane_of l = describe(model, unit, s, lane);
      store3(s, l, lane, s->x, state->x);
      store3(s, l, lane, s->v, state->v);
      store3(s, l, lane, s->f, state->force);
      if (s->loaded) store3(s, l, lane, s->load, state->load);
      if (s->general) store_frames(s, l, lane, state);
      fetch(s, s->lambda, 0, lane, edges_in(s, l), state->lambda + l.rod->first + l.first);
    }
  }
}

/* Directors and twists without the tangents that they belong to, which are those of the edges. */
static void store_directors(const hb_strip *s, lane_of l, int lane, hb_state *state) {
  int edges = edges_in(s, l), slot = l.rod->first + l.first;
  if (edges == 0) return;
  fetch(s, s->m1, 0, lane, 3 * edges, state->m1 + 3 * slot);
  fetch(s, s->twist, 0, lane, edges, state->twist + slot);
  if (l.first == 0) state->twist[slot] = 0;
}

/* Less than what carries a run on. */
void hb_unit_store_measured(const hb_model *model, hb_state *state, hb_unit *unit, bool forces) {
  for (int g = 0; g < unit->strip_count; g++) {
    hb_strip *s = &unit->strips[g];
    if (forces) unit->kernels->assemble(s);
    for (int lane = 0; lane < (unit->pieces ? s->lanes : unit->rod_count); lane++) {
      lane_of l = describe(model, unit, s, lane);
      store3(s, l, lane, s->x, state->x);
      store3(s, l, lane, s->v, state->v);
      if (forces) store3(s, l, lane, s->f, state->force);
      if (s->general) store_directors(s, l, lane, state);
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
      add_to(s, array_of(s, array), 0, lane, 3 * vertices_in(s, l), from + 3 * (l.rod->first + l.first));
    }
  }
}

/* Sets one vertex array of the n-th rod to zero, all copies. */
void hb_unit_clear3(hb_unit *unit, int n, size_t array) {
  for (int g = 0; g < unit->strip_count; g++) {
    hb_strip *s = &unit->strips[g];
    for (int lane = 0; lane < s->lanes; lane++) {
      if (!unit->pieces && lane != n && !(n == 0 && lane >= unit->rod_count)) continue;
      wipe(s, array_of(s, array), 0, lane, 3 * (s->rows + 1));
    }
  }
}

/* The same in every lane of a rod in pieces; for the first rod of a bundle in the idle lanes, too. */
void hb_unit_set_loads(hb_unit *unit, int n, const hb_uniform_load *load) {
  double numbers[HB_LAW_NUMBERS];
  _Static_assert(sizeof numbers == sizeof *load, "lanes know all numbers of a uniform load");
  memcpy(numbers, load, sizeof numbers);
  for (int g = 0; g < unit->strip_count; g++) {
    hb_strip *s = &unit->strips[g];
    int first = unit->pieces ? 0 : n, end = unit->pieces ? s->lanes : n + 1;
    for (int lane = first; lane < end; lane++) put(s, s->law, 0, lane, HB_LAW_NUMBERS, numbers);
    for (int lane = unit->rod_count; n == 0 && !unit->pieces && lane < s->lanes; lane++)
      put(s, s->law, 0, lane, HB_LAW_NUMBERS, numbers);
  }
}
