#include "lane/plan.h"

#include "base/memory.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

/* Most rows of a strip: so its arrays stay in the cache of one core. */
#define STRIP_ROWS 256
/* Rods of a bundle differ by at most this part in their edges: shorter ones wait for the longest. */
#define UNEVEN 0.2

/* Cuts of strips at panel ends and pieces; what one strip needs in numbers. */
typedef struct need {
  size_t reals, cuts;
} need;

/* Rods in the order in which they are bundled. */
typedef struct candidate {
  int rod, edges;
  bool twisted, general, loaded, exact;
} candidate;

/* Rods of a kind together, long ones first, then as in the scene. */
static int by_kind_and_size(const void *a, const void *b) {
  const candidate *p = a, *q = b;
  if (p->exact != q->exact) return p->exact ? 1 : -1;
  if (p->general != q->general) return p->general ? -1 : 1;
  if (p->twisted != q->twisted) return p->twisted ? -1 : 1;
  if (p->edges != q->edges) return p->edges > q->edges ? -1 : 1;
  return p->rod - q->rod;
}

/* Is it better cut into pieces than put into a lane of a bundle? A bundle of fewer than half its lanes is
 * slower than its rods one by one; a piece needs some rows. */
static bool in_pieces(const candidate *c, int count, int lanes) {
  return 2 * count <= lanes && c->edges >= lanes * lanes;
}

/* How many of the candidates go into one bundle. */
static int bundle_size(const candidate *c, int count, int lanes) {
  int n = 1;
  while (n < count && n < lanes && c[n].twisted == c[0].twisted && c[n].general == c[0].general &&
         c[n].exact == c[0].exact && c[n].edges >= (1 - UNEVEN) * c[0].edges)
    n++;
  return n;
}

/* Strips of a rod in pieces: as few as keep to STRIP_ROWS, of nearly equal rows. */
static int strips_of(int edges, int lanes) {
  int rows = (edges + lanes - 1) / lanes;
  return (rows + STRIP_ROWS - 1) / STRIP_ROWS;
}

/* Units out of sorted candidates; units NULL: only counts. */
static int divide(const candidate *c, int count, const hb_lane_plan *plan, hb_unit *units, int *strip_count) {
  int n = 0;
  *strip_count = 0;
  for (int at = 0; at < count;) {
    const hb_lane_kernels *kernels = c[at].exact ? plan->once : plan->kernels;
    const int lanes = kernels->lanes;
    int size = bundle_size(c + at, count - at, lanes);
    bool pieces = in_pieces(&c[at], size, lanes);
    if (pieces) size = 1;
    int strips = pieces ? strips_of(c[at].edges, lanes) : 1;
    if (units) {
      units[n].kernels = kernels;
      units[n].pieces = pieces;
      units[n].rod_count = size;
      units[n].strip_count = strips;
      units[n].twisted = c[at].twisted;
      units[n].general = c[at].general;
      for (int l = 0; l < size; l++) {
        units[n].rods[l] = c[at + l].rod;
        units[n].loaded = units[n].loaded || c[at + l].loaded;
      }
    }
    *strip_count += strips;
    at += size;
    n++;
  }
  return n;
}

/* Do all rods of a unit carry one twisting moment each, from the first edge to the last? */
static bool is_uniform(const hb_model *m, const hb_unit *u) {
  for (int n = 0; n < u->rod_count; n++) {
    const hb_rod *rod = &m->rods[u->rods[n]];
    const hb_span *span = &m->spans[rod->first_span];
    if (rod->span_count != 1 || span->first_edge != rod->first || span->last_edge != rod->first + rod->nv - 2)
      return false;
  }
  return true;
}

/* Shapes of the strips of a unit. */
static void shape_strips(const hb_model *m, hb_unit *u) {
  const hb_lane_kernels *k = u->kernels;
  int edges = m->rods[u->rods[0]].nv - 1, lanes = k->lanes;
  int rows = (edges + lanes - 1) / lanes, first = 0;
  for (int g = 0; g < u->strip_count; g++) {
    hb_strip *s = &u->strips[g];
    s->lanes = lanes;
    s->single = k->single;
    s->pieces = u->pieces;
    s->twisted = u->twisted;
    s->general = u->general;
    s->loaded = u->loaded;
    s->uniform = u->twisted && is_uniform(m, u);
    s->relative = m->def->method.length_tolerance_kind == HB_TOLERANCE_RELATIVE;
    s->first_edge = first;
    s->rows = !u->pieces ? edges
                         : (int)((int64_t)rows * (g + 1) / u->strip_count) -
                               (int)((int64_t)rows * g / u->strip_count);
    s->before = u->pieces && g > 0 ? s - 1 : NULL;
    s->after = u->pieces && g + 1 < u->strip_count ? s + 1 : NULL;
    first += s->rows * lanes;
  }
}

/* Edges of a lane. */
static int edges_in_lane(const hb_model *m, const hb_unit *u, const hb_strip *s, int lane) {
  if (!u->pieces) return m->rods[u->rods[lane < u->rod_count ? lane : 0]].nv - 1;
  int left = m->rods[u->rods[0]].nv - 1 - s->first_edge - lane * s->rows;
  return left < 0 ? 0 : left < s->rows ? left : s->rows;
}

/* Marks the rows of one strip at which a panel of some lane begins or ends. mark: one flag per row. */
static void mark_cuts(const hb_model *m, const hb_unit *u, const hb_strip *s, unsigned char *mark) {
  memset(mark, 0, (size_t)s->rows);
  mark[s->rows - 1] = 1;
  for (int n = 0; n < u->rod_count; n++) {
    const hb_rod *rod = &m->rods[u->rods[n]];
    for (int k = rod->first_span; k < rod->first_span + rod->span_count; k++)
      for (int p = m->spans[k].first_panel; p < m->spans[k].first_panel + m->spans[k].panel_count; p++) {
        int ends[2] = {m->panels[p].from - rod->first, m->panels[p].to - rod->first};
        for (int e = 0; e < 2; e++) {
          int row = ends[e] - s->first_edge;
          if (u->pieces) {
            if (row < 0 || row >= s->rows * s->lanes) continue;
            row %= s->rows;
          }
          mark[row] = 1;
        }
      }
  }
}

/* Cuts of one strip into cuts (NULL: only counted). */
static int list_cuts(const hb_model *m, const hb_unit *u, const hb_strip *s, unsigned char *mark, int *cuts) {
  int count = 0;
  if (!u->twisted) return 0;
  mark_cuts(m, u, s, mark);
  for (int r = 0; r < s->rows; r++) {
    if (!mark[r] || (r == 0 && !u->pieces && s->rows > 1)) continue; /* no vertex before the first edge */
    if (cuts) cuts[count] = r;
    count++;
  }
  return count;
}

/* Numbers that a strip holds. */
static size_t reals_of(const hb_strip *s) {
  size_t rows = (size_t)s->rows, sum = 4 * (size_t)s->cut_count;
#define HB_COUNT(name, extra, numbers, text) sum += (rows + (extra)) * (numbers);
  HB_STRIP_FIELDS(HB_COUNT)
  if (s->pieces) {
    HB_STRIP_PIECE_FIELDS(HB_COUNT)
  }
  if (s->general || (s->twisted && !s->uniform)) {
    HB_STRIP_MOMENT_FIELDS(HB_COUNT)
  }
  if (s->general) {
    HB_STRIP_GENERAL_FIELDS(HB_COUNT)
  }
  if (s->loaded) {
    HB_STRIP_LOAD_FIELDS(HB_COUNT)
  }
#undef HB_COUNT
#define HB_COUNT(name, numbers, text) sum += (numbers);
  HB_STRIP_RECORDS(HB_COUNT)
#undef HB_COUNT
  return sum * (size_t)s->lanes;
}

/* Arrays of a strip, one behind the other from *next on. */
static void lay_out(hb_strip *s, char **next) {
  size_t rows = (size_t)s->rows, row = (size_t)s->lanes * (s->single ? sizeof(float) : sizeof(double));
#define HB_PLACE(name, extra, numbers, text)                                                                 \
  s->name = *next;                                                                                           \
  *next += (rows + (extra)) * (numbers)*row;
  HB_STRIP_FIELDS(HB_PLACE)
  if (s->pieces) {
    HB_STRIP_PIECE_FIELDS(HB_PLACE)
  }
  if (s->general || (s->twisted && !s->uniform)) {
    HB_STRIP_MOMENT_FIELDS(HB_PLACE)
  }
  if (s->general) {
    HB_STRIP_GENERAL_FIELDS(HB_PLACE)
  }
  if (s->loaded) {
    HB_STRIP_LOAD_FIELDS(HB_PLACE)
  }
#undef HB_PLACE
#define HB_PLACE(name, numbers, text)                                                                        \
  s->name = *next;                                                                                           \
  *next += (numbers)*row;
  HB_STRIP_RECORDS(HB_PLACE)
#undef HB_PLACE
  s->f_twist = s->inv_pivot; /* 3 arrays of a number per vertex, one behind the other */
  s->turns = *next;
  *next += 4 * (size_t)s->cut_count * row;
}

/* May the frame of this edge turn? */
static bool turns_freely(const hb_model *m, const hb_rod *rod, int j) {
  return j >= 0 && j + 1 < rod->nv && m->frame_of[rod->first + j] < 0;
}

/* Constants of general rods at row r of a lane: vertex and edge j of the rod. */
static void set_general(const hb_model *m, hb_strip *s, const hb_rod *rod, int j, int row, int lane) {
  size_t r = (size_t)row;
  int slot = rod->first + j;
  if (row < s->rows && j + 1 < rod->nv) {
    for (size_t c = 0; c < 3; c++) hb_strip_set(s, s->B, 3 * r + c, lane, m->B[3 * (size_t)slot + c]);
    hb_strip_set(s, s->free, r, lane, turns_freely(m, rod, j));
  }
  if (j < 1 || j + 2 > rod->nv) return;
  bool linked = turns_freely(m, rod, j - 1) && turns_freely(m, rod, j);
  hb_strip_set(s, s->inv_l, r, lane, 1 / m->voronoi[slot]);
  hb_strip_set(s, s->twist_gain, r, lane, m->twist_gain[slot]);
  hb_strip_set(s, s->twist_link, r, lane, linked ? -m->twist_gain[slot] : 0);
  hb_strip_set(s, s->rest_twist, r, lane, m->rest_twist[slot]);
  for (size_t c = 0; c < 4; c++)
    hb_strip_set(s, s->pull, 4 * r + c, lane, m->rest_pull[4 * (size_t)slot + c]);
}

/* Constant tables of a strip. Phantoms: no mobility, no stiffness, length 1. */
static void set_constants(const hb_model *m, const hb_unit *u, hb_strip *s) {
  for (int l = 0; l < s->lanes; l++) {
    const hb_rod *rod =
        &m->rods[u->rods[u->pieces || l >= u->rod_count ? 0 : l]]; /* idle lanes repeat rod 0 */
    int at = u->pieces ? s->first_edge + l * s->rows : 0, last = rod->nv - 1;
    hb_strip_set(s, s->count, 0, l, edges_in_lane(m, u, s, l));
    hb_strip_set(s, s->keep, 0, l, rod->frame_count > 0 ? 1 : 0.9); /* as spin_on in rod/twist_newton.c */
    for (int r = -1; r <= s->rows; r++) {
      int j = at + r;
      bool edge = j >= 0 && j < last, vertex = j >= 0 && j <= last;
      hb_strip_set(s, s->inv_rest, (size_t)(r + 1), l, edge ? m->inv_rest_length[rod->first + j] : 1);
      if (edge && r >= 0 && r < s->rows) {
        double rest = m->rest_length[rod->first + j];
        hb_strip_set(s, s->half_rest2, (size_t)r, l, 0.5 * rest * rest);
      }
      if (!vertex || r < 0) continue;
      hb_strip_set(s, s->mobility, (size_t)r, l, m->inv_mass[3 * (rod->first + j)]);
      if (s->loaded) hb_strip_set(s, s->mass, (size_t)r, l, m->mass[rod->first + j]);
      if (s->loaded) hb_strip_set(s, s->weight, (size_t)r, l, m->weight[rod->first + j]);
      if (s->general) set_general(m, s, rod, j, r, l);
      if (j > 0 && j < last) hb_strip_set(s, s->bend_gain, (size_t)r, l, m->bend_gain[rod->first + j]);
    }
  }
}

/* Rows that are full in every lane. */
static void count_full_rows(const hb_model *m, const hb_unit *u, hb_strip *s) {
  s->full_rows = s->rows;
  for (int l = 0; l < s->lanes; l++) {
    int edges = edges_in_lane(m, u, s, l);
    if (edges < s->full_rows) s->full_rows = edges;
  }
}

/* Counts, allocates, lays out: strips have their shapes, marks is as long as the longest. */
static hb_status build(const hb_model *m, hb_lane_plan *plan, hb_strip *strips, int strip_count,
                       unsigned char *marks, hb_error *err) {
  size_t cuts = 0, lane_bytes = 0, chain = 0;
  for (int k = 0; k < plan->unit_count; k++) {
    hb_unit *u = &plan->units[k];
    for (int g = 0; g < u->strip_count; g++) {
      u->strips[g].cut_count = list_cuts(m, u, &u->strips[g], marks, NULL);
      cuts += (size_t)u->strips[g].cut_count;
      lane_bytes += reals_of(&u->strips[g]) * (u->kernels->single ? sizeof(float) : sizeof(double));
    }
    if (u->pieces) chain += 4 * (size_t)u->strip_count * (size_t)u->kernels->lanes;
  }
  size_t bytes = 64 + lane_bytes + chain * sizeof(double) + cuts * sizeof(int);
  plan->block = hb_alloc(bytes, 1);
  if (!plan->block) return hb_fail_memory(err, "rods in lanes");
  plan->bytes = bytes + (size_t)strip_count * sizeof *strips +
                (size_t)plan->unit_count * sizeof *plan->units +
                (size_t)m->panel_count * sizeof *plan->turns + (size_t)m->rod_count * sizeof *plan->unit_of;
  char *next = (char *)plan->block;
  next += (64 - (uintptr_t)next % 64) % 64;
  double *links = (double *)(void *)(next + lane_bytes);
  int *cut = (int *)(void *)(links + chain);
  for (int k = 0; k < plan->unit_count; k++) {
    hb_unit *u = &plan->units[k];
    if (u->pieces) u->chain = links;
    if (u->pieces) links += 4 * (size_t)u->strip_count * (size_t)u->kernels->lanes;
    for (int g = 0; g < u->strip_count; g++) {
      hb_strip *s = &u->strips[g];
      lay_out(s, &next);
      s->cuts = cut;
      cut += list_cuts(m, u, s, marks, s->cuts);
      count_full_rows(m, u, s);
      set_constants(m, u, s);
    }
    for (int n = 0; n < u->rod_count; n++) plan->unit_of[u->rods[n]] = k;
  }
  return HB_OK;
}

/* Units and strips for the candidates in their order. */
static hb_status fill_plan(const hb_model *m, hb_lane_plan *plan, const candidate *list, int count,
                           hb_error *err) {
  int strip_count, longest = 1;
  plan->unit_count = divide(list, count, plan, NULL, &strip_count);
  plan->units = hb_alloc((size_t)plan->unit_count, sizeof *plan->units);
  plan->unit_of = hb_alloc((size_t)m->rod_count, sizeof *plan->unit_of);
  plan->turns = hb_alloc((size_t)m->panel_count, sizeof *plan->turns);
  hb_strip *strips = hb_alloc((size_t)strip_count, sizeof *strips);
  for (int k = 0; k < count; k++)
    if (list[k].edges > longest) longest = list[k].edges;
  unsigned char *marks = hb_alloc((size_t)longest, 1);
  hb_status status = HB_OK;
  if (!plan->units || !plan->unit_of || !plan->turns || !strips || !marks) {
    hb_free(strips);
    status = hb_fail_memory(err, "rods in lanes");
  } else {
    for (int r = 0; r < m->rod_count; r++) plan->unit_of[r] = -1;
    (void)divide(list, count, plan, plan->units, &strip_count);
    hb_strip *next = strips;
    for (int k = 0; k < plan->unit_count; k++) {
      plan->units[k].strips = next;
      next += plan->units[k].strip_count;
      shape_strips(m, &plan->units[k]);
    }
    status = build(m, plan, strips, strip_count, marks, err);
  }
  hb_free(marks);
  return status;
}

/* Sorts the wanted rods and builds units of them. */
hb_status hb_lane_plan_create(const hb_model *model, const unsigned char *wanted,
                              const hb_lane_kernels *kernels, const hb_lane_kernels *once, hb_lane_plan **out,
                              hb_error *err) {
  *out = NULL;
  int count = 0;
  for (int r = 0; r < model->rod_count; r++) count += wanted[r] != 0;
  if (count == 0) return HB_OK;
  hb_lane_plan *plan = hb_alloc(1, sizeof *plan);
  candidate *list = hb_alloc((size_t)count, sizeof *list);
  if (!plan || !list) {
    hb_free(plan);
    hb_free(list);
    return hb_fail_memory(err, "rods in lanes");
  }
  plan->kernels = kernels;
  plan->once = once;
  count = 0;
  for (int r = 0; r < model->rod_count; r++)
    if (wanted[r]) {
      const hb_rod *rod = &model->rods[r];
      list[count++] = (candidate){r,
                                  rod->nv - 1,
                                  rod->closed_form && !rod->twist_free,
                                  !rod->closed_form,
                                  (wanted[r] & HB_WANTED_LOADED) != 0,
                                  (wanted[r] & HB_WANTED_DOUBLE) != 0};
    }
  qsort(list, (size_t)count, sizeof *list, by_kind_and_size);
  hb_status status = fill_plan(model, plan, list, count, err);
  hb_free(list);
  if (status) {
    hb_lane_plan_free(plan);
    return status;
  }
  *out = plan;
  return HB_OK;
}

/* Frees all of it. */
void hb_lane_plan_free(hb_lane_plan *plan) {
  if (!plan) return;
  if (plan->units) hb_free(plan->units[0].strips); /* all strips are one array */
  hb_free(plan->units);
  hb_free(plan->unit_of);
  hb_free(plan->turns);
  hb_free(plan->block);
  hb_free(plan);
}
