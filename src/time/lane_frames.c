/* Held frames of bundles, HB_LANES_DOUBLE rods at a time, where no formula turns them: hb_frames_hold and
 * hb_twist_closed in lanes (docs/theory, 10.5). */
#include "time/lane_frames.h"

#include <math.h>
#include <string.h>

/* Lanes of a group. */
#define WIDE HB_LANES_DOUBLE

/* Rod of lane l in a group of lanes; lanes without one repeat the first. */
static const hb_rod *rod_in(const hb_journey *j, int index, int l) {
  int n = index * WIDE + l;
  return &j->s->model->rods[j->u->rods[n < j->u->rod_count ? n : 0]];
}

/* Panels of a rod. */
static int panels_of(const hb_model *m, const hb_rod *rod) {
  int count = 0;
  for (int k = rod->first_span; k < rod->first_span + rod->span_count; k++) count += m->spans[k].panel_count;
  return count;
}

/* The anchor, held frames, and ends of panels inside of spans. */
bool hb_unit_is_alike(const hb_model *m, const hb_unit *u) {
  const hb_rod *first = &m->rods[u->rods[0]];
  int panels = panels_of(m, first);
  if (u->pieces || 1 + first->frame_count + panels > HB_JOURNEY_DIRECTORS) return false;
  for (int n = 1; n < u->rod_count; n++) {
    const hb_rod *rod = &m->rods[u->rods[n]];
    if (rod->frame_count != first->frame_count || rod->span_count != first->span_count) return false;
    for (int k = 0; k < rod->span_count; k++) {
      const hb_span *a = &m->spans[first->first_span + k], *b = &m->spans[rod->first_span + k];
      if (a->panel_count != b->panel_count ||
          a->first_frame - first->first_frame != b->first_frame - rod->first_frame)
        return false;
    }
  }
  return true;
}

/* Do all frames stand at the angles that their constant formulas say? */
bool hb_journey_is_steady(const hb_journey *j) {
  const hb_model *m = j->s->model;
  for (int n = 0; n < j->u->rod_count && j->u->alike; n++) {
    const hb_rod *rod = &m->rods[j->u->rods[n]];
    for (int k = rod->first_frame; k < rod->first_frame + rod->frame_count; k++)
      if (!(j->s->state->frame_angle[k] == j->s->still_angle[k])) return false;
  }
  return j->u->alike;
}

/* Lane l of three numbers. */
static void gather3(double *to, int l, const double *from) {
  for (int c = 0; c < 3; c++) to[c * WIDE + l] = from[c];
}

/* And back. */
static void scatter3(const double *from, int l, double *to) {
  for (int c = 0; c < 3; c++) to[c] = from[c * WIDE + l];
}

/* Edge `row` of a lane of a strip. */
static void gather_edge(const hb_strip *s, int lane, int row, double *to, int l) {
  for (int c = 0; c < 3; c++) {
    size_t at = 3 * (size_t)row + (size_t)c;
    to[c * WIDE + l] = hb_strip_get(s, s->x, at + 3, lane) - hb_strip_get(s, s->x, at, lane);
  }
}

/* Where the directors of one rod are kept: item k of the list. */
typedef struct kept {
  double *d, *t;
  int slot;
} kept;

/* The directors of a group of rods on their way through a step. first_of, last_of: per panel, the items where
 * it begins and ends. */
typedef struct group {
  hb_lane_director list[HB_JOURNEY_DIRECTORS];
  kept items[WIDE][HB_JOURNEY_DIRECTORS];
  int first_of[HB_JOURNEY_DIRECTORS], last_of[HB_JOURNEY_DIRECTORS];
  int count;
} group;

/* The anchor, the frames, the ends of panels inside of spans; of lane l. */
static void list_items(const hb_model *m, hb_state *state, const hb_rod *rod, int l, group *g) {
  int panels = 0;
  kept *items = g->items[l];
  g->count = 1;
  items[0] = (kept){state->anchor_m1 + 3 * rod->index, state->anchor_tangent + 3 * rod->index, rod->first};
  for (int k = rod->first_frame; k < rod->first_frame + rod->frame_count; k++)
    items[g->count++] = (kept){state->frame_m1 + 3 * k, state->frame_tangent + 3 * k, m->frames[k].slot};
  for (int k = rod->first_span; k < rod->first_span + rod->span_count; k++) {
    const hb_span *span = &m->spans[k];
    for (int p = span->first_panel; p < span->first_panel + span->panel_count; p++, panels++) {
      g->first_of[panels] =
          p == span->first_panel ? 1 + span->first_frame - rod->first_frame : g->last_of[panels - 1];
      if (p + 1 == span->first_panel + span->panel_count) {
        g->last_of[panels] = 1 + span->last_frame - rod->first_frame;
        continue;
      }
      items[g->count] = (kept){state->panel_m1 + 3 * p, state->panel_tangent + 3 * p, m->panels[p].to};
      g->last_of[panels] = g->count++;
    }
  }
}

/* All directors of a group to where they are now; false, with nothing written, if one cannot be carried. */
static bool carry_group(const hb_journey *j, int index, group *g) {
  const hb_strip *s = j->u->strips;
  for (int l = 0; l < WIDE; l++) {
    const hb_rod *rod = rod_in(j, index, l);
    int n = index * WIDE + l, lane = n < j->u->rod_count ? n : 0;
    list_items(j->s->model, j->s->state, rod, l, g);
    for (int k = 0; k < g->count; k++) {
      gather3(g->list[k].d, l, g->items[l][k].d);
      gather3(g->list[k].t, l, g->items[l][k].t);
      gather_edge(s, lane, g->items[l][k].slot - rod->first, g->list[k].e, l);
    }
  }
  return j->s->plan->once->carry_directors(g->list, g->count);
}

/* Rods of a group that are there. */
static int rods_in(const hb_journey *j, int index) {
  int left = j->u->rod_count - index * WIDE;
  return left < WIDE ? left : WIDE;
}

/* Groups of a unit. */
static int groups_of(const hb_journey *j) { return (j->u->rod_count + WIDE - 1) / WIDE; }

/* Every director, then everything is written into the state. */
static bool carry_unit(const hb_journey *j, group groups[HB_JOURNEY_GROUPS]) {
  for (int g = 0; g < groups_of(j); g++)
    if (!carry_group(j, g, &groups[g])) return false;
  for (int g = 0; g < groups_of(j); g++)
    for (int l = 0; l < rods_in(j, g); l++)
      for (int k = 0; k < groups[g].count; k++) {
        scatter3(groups[g].list[k].d, l, groups[g].items[l][k].d);
        scatter3(groups[g].list[k].t, l, groups[g].items[l][k].t);
      }
  return true;
}

/* Transport along the p-th panel of a lane: its cuts are the panels' ends where all rods have the same. */
static void gather_turn(const hb_journey *j, int n, int p, const hb_panel *panel, double *to, int l) {
  const hb_strip *s = j->u->strips;
  const hb_rod *rod = &j->s->model->rods[j->u->rods[n]];
  int begins = p == 0 ? 0 : s->cuts[p - 1];
  if (panel->from - rod->first == begins && panel->to - rod->first == s->cuts[p]) {
    for (int c = 0; c < 4; c++) to[c * WIDE + l] = hb_strip_get(s, s->turns, 4 * (size_t)p + (size_t)c, n);
    return;
  }
  hb_quat q = hb_journey_panel(j->u, n, panel->from - rod->first, panel->to - rod->first);
  to[0 * WIDE + l] = q.w;
  to[1 * WIDE + l] = q.v.x;
  to[2 * WIDE + l] = q.v.y;
  to[3 * WIDE + l] = q.v.z;
}

/* Twist of the p-th panel of each rod of a group. */
static void twist_group(const hb_journey *j, int index, int p, const group *g) {
  const hb_model *m = j->s->model;
  hb_state *state = j->s->state;
  _Alignas(64) double turn[4 * WIDE], twist[WIDE];
  const hb_lane_director *from = &g->list[g->first_of[p]], *to = &g->list[g->last_of[p]];
  int panel[WIDE];
  for (int l = 0; l < WIDE; l++) {
    int n = index * WIDE + l;
    panel[l] = m->spans[rod_in(j, index, l)->first_span].first_panel + p;
    gather_turn(j, n < j->u->rod_count ? n : 0, p, &m->panels[panel[l]], turn, l);
    twist[l] = state->panel_twist[panel[l]];
  }
  j->s->plan->once->panel_twist(turn, from, to, twist);
  for (int l = 0; l < rods_in(j, index); l++) {
    state->panel_twist[panel[l]] = twist[l];
    scatter3(to->d, l, state->panel_m1 + 3 * panel[l]);
    scatter3(to->t, l, state->panel_tangent + 3 * panel[l]);
  }
}

/* Moments of the spans of a rod, and what they do to its held frames. */
static void set_moments(const hb_model *m, hb_state *state, const hb_rod *rod) {
  for (int k = rod->first_frame; k < rod->first_frame + rod->frame_count; k++) state->frame_torque[k] = 0;
  for (int k = rod->first_span; k < rod->first_span + rod->span_count; k++) {
    const hb_span *span = &m->spans[k];
    double total = 0;
    state->moment[k] = 0;
    if (span->panel_count == 0) continue;
    for (int p = span->first_panel; p < span->first_panel + span->panel_count; p++)
      total += state->panel_twist[p];
    state->moment[k] = (total - span->natural_twist) / span->compliance;
    state->frame_torque[span->last_frame] += state->moment[k];
    state->frame_torque[span->first_frame] -= state->moment[k];
  }
}

/* Frames and twist in closed form. */
bool hb_journey_settle_steady(const hb_journey *j) {
  group groups[HB_JOURNEY_GROUPS];
  const hb_model *m = j->s->model;
  if (!carry_unit(j, groups)) return false;
  int panels = j->u->twisted ? panels_of(m, &m->rods[j->u->rods[0]]) : 0;
  for (int g = 0; g < groups_of(j); g++)
    for (int p = 0; p < panels; p++) twist_group(j, g, p, &groups[g]);
  for (int n = 0; n < j->u->rod_count; n++) set_moments(m, j->s->state, &m->rods[j->u->rods[n]]);
  return true;
}

/* Frames of general rods, into the lanes, too. */
bool hb_journey_hold_steady(const hb_journey *j) {
  group groups[HB_JOURNEY_GROUPS];
  const hb_model *m = j->s->model;
  const double nothing = 0;
  if (!carry_unit(j, groups)) return false;
  for (int n = 0; n < j->u->rod_count; n++) {
    const hb_rod *rod = &m->rods[j->u->rods[n]];
    for (int k = 0; k < rod->frame_count; k++) {
      double d[3];
      int edge = m->frames[rod->first_frame + k].slot - rod->first;
      scatter3(groups[n / WIDE].list[1 + k].d, n % WIDE, d);
      hb_unit_set_edge(j->u, n, edge, AT(m1), 3, d);
      hb_unit_set_edge(j->u, n, edge, AT(spin), 1, &nothing);
    }
  }
  return true;
}

/* theta^0 of general rods. */
void hb_journey_first_angles(const hb_journey *j) {
  hb_state *state = j->s->state;
  const hb_strip *s = j->u->strips;
  for (int g = 0; g < groups_of(j); g++) {
    hb_lane_director anchor, first;
    _Alignas(64) double angle[WIDE];
    for (int l = 0; l < WIDE; l++) {
      const hb_rod *rod = rod_in(j, g, l);
      int n = g * WIDE + l, lane = n < j->u->rod_count ? n : 0;
      gather3(anchor.d, l, state->anchor_m1 + 3 * rod->index);
      gather3(anchor.t, l, state->anchor_tangent + 3 * rod->index);
      for (int c = 0; c < 3; c++) first.d[c * WIDE + l] = hb_strip_get(s, s->m1, (size_t)c, lane);
      angle[l] = state->theta_0[rod->index];
    }
    j->s->plan->once->director_angle(&anchor, &first, angle);
    for (int l = 0; l < rods_in(j, g); l++) state->theta_0[rod_in(j, g, l)->index] = angle[l];
  }
}
