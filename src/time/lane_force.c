/* Frames, twist and forces of rods in lanes. */
#include "time/lane_frames.h"

#include <float.h>
#include <string.h>

/* Twist that has not settled by then, or wants to turn further than this at once, is led by the rod's own
 * functions, which search. */
#define TWIST_ITERATIONS 12
#define LONG_TURN 0.3

/* Tangent of one edge into the rod's workspace. */
static void fill_tangent(const hb_journey *j, int n, int edge) {
  hb_lane_place p = hb_unit_find(j->u, n, edge);
  double e[3];
  for (int c = 0; c < 3; c++) {
    size_t at = 3 * (size_t)p.row + (size_t)c;
    e[c] = hb_strip_get(p.strip, p.strip->x, at + 3, p.lane) - hb_strip_get(p.strip, p.strip->x, at, p.lane);
  }
  hb_v3_store(j->s->rod_work.tangent + 3 * edge, hb_v3_unit(hb_v3_load(e)));
}

/* Tangents of the first edge and of those whose frames are held. */
static void fill_held_tangents(const hb_journey *j, int n) {
  const hb_rod *rod = &j->s->model->rods[j->u->rods[n]];
  fill_tangent(j, n, 0);
  for (int k = rod->first_frame; k < rod->first_frame + rod->frame_count; k++)
    if (j->s->model->frames[k].slot > rod->first)
      fill_tangent(j, n, j->s->model->frames[k].slot - rod->first);
}

/* Transport along one panel: the products of its cuts, one behind the other. */
hb_quat hb_journey_panel(const hb_unit *u, int n, int from, int to) {
  hb_quat q = {1, {0, 0, 0}};
  hb_lane_place at = hb_unit_find(u, n, from + 1), end = hb_unit_find(u, n, to);
  int cut = 0;
  while (at.strip->cuts[cut] < at.row) cut++;
  for (;;) {
    const hb_strip *s = at.strip;
    double w[4];
    for (int c = 0; c < 4; c++) w[c] = hb_strip_get(s, s->turns, 4 * (size_t)cut + (size_t)c, at.lane);
    q = hb_quat_mul((hb_quat){w[0], {w[1], w[2], w[3]}}, q);
    double largest_part = fmax(fmax(fabs(q.w), fabs(q.v.x)), fmax(fabs(q.v.y), fabs(q.v.z)));
    double inv = 1 / largest_part;
    q = (hb_quat){inv * q.w, hb_v3_scale(inv, q.v)};
    if (s == end.strip && at.lane == end.lane && s->cuts[cut] == end.row) return q;
    if (++cut < s->cut_count) continue;
    cut = 0;
    if (++at.lane == s->lanes) {
      at.strip++;
      at.lane = 0;
    }
  }
}

/* Prescribed frames and, in closed form, the twist of the n-th rod at the new positions. */
static hb_status settle_frames(const hb_journey *j, int n, hb_error *err) {
  const hb_model *m = j->s->model;
  const hb_rod *rod = &m->rods[j->u->rods[n]];
  hb_quat *turns = j->s->plan->turns;
  fill_held_tangents(j, n);
  hb_status status = hb_frames_check(m, rod, &j->s->rod_work, j->t, err);
  if (status) return status;
  hb_frames_hold(m, rod, j->s->state, &j->s->rod_work, j->t);
  if (rod->twist_free) return HB_OK;
  for (int k = rod->first_span; k < rod->first_span + rod->span_count; k++)
    for (int p = m->spans[k].first_panel; p < m->spans[k].first_panel + m->spans[k].panel_count; p++) {
      if (m->frame_of[m->panels[p].to] < 0) fill_tangent(j, n, m->panels[p].to - rod->first);
      turns[p] = hb_journey_panel(j->u, n, m->panels[p].from - rod->first, m->panels[p].to - rod->first);
    }
  hb_twist_closed(m, rod, j->s->state, &j->s->rod_work, turns);
  return HB_OK;
}

/* Moment of each span to its vertices, in every copy. */
static void fill_moments(const hb_journey *j, int n) {
  const hb_model *m = j->s->model;
  hb_unit *u = j->u;
  const hb_rod *rod = &m->rods[u->rods[n]];
  for (int g = 0; g < u->strip_count; g++) {
    hb_strip *s = &u->strips[g];
    if (s->uniform) {
      double moment = j->s->state->moment[rod->first_span];
      if (!u->pieces) hb_strip_set(s, s->rod_moment, 0, n, moment);
      for (int l = u->pieces ? 0 : n > 0 ? s->lanes : u->rod_count; l < s->lanes; l++)
        hb_strip_set(s, s->rod_moment, 0, l, moment);
      continue;
    }
    for (int l = 0; l < s->lanes; l++) {
      bool mine = u->pieces || l == n || (n == 0 && l >= u->rod_count);
      int at = rod->first + (u->pieces ? s->first_edge + l * s->rows : 0);
      for (int k = rod->first_span; mine && k < rod->first_span + rod->span_count; k++) {
        int from = m->spans[k].first_edge + 1 - at, to = m->spans[k].last_edge - at;
        double moment = j->s->state->moment[k];
        if (from < 0) from = 0;
        for (int r = from; r <= to && r <= s->rows; r++) hb_strip_set(s, s->moment, (size_t)r, l, moment);
      }
    }
  }
}

/* Is an edge of the n-th rod folded back onto its neighbour? */
static bool rod_folded(const hb_unit *u, int n) {
  for (int g = 0; g < u->strip_count; g++)
    for (int l = u->pieces ? 0 : n; l < (u->pieces ? u->strips->lanes : n + 1); l++)
      if (!(hb_strip_get(&u->strips[g], u->strips[g].lowest_chi, 0, l) > HB_FOLD_LIMIT)) return true;
  return false;
}

/* Or of any rod? */
static bool folded(const hb_unit *u) {
  for (int n = 0; n < u->rod_count; n++)
    if (rod_folded(u, n)) return true;
  return false;
}

/* Loads on the n-th rod that are not uniform: by the rod's own functions. Their work over this step; that of
 * their values before it has been booked. */
static void add_general_loads(const hb_journey *j, int n, unsigned terms) {
  hb_stepper *s = j->s;
  hb_state *state = s->state;
  const hb_rod *rod = &s->model->rods[j->u->rods[n]];
  size_t from = 3 * (size_t)rod->first, to = from + 3 * (size_t)rod->nv;
  double *x = state->x, *v = state->v, *moved = s->x_old, work = 0;
  hb_unit_store3(s->model, j->u, n, AT(x), x);
  hb_unit_store3(s->model, j->u, n, AT(x_old), moved);
  for (size_t k = from; k < to; k++) moved[k] = x[k] - moved[k];
  if (s->rates[rod->index] && j->along) {
    v = s->v_predicted;
    hb_unit_store3(s->model, j->u, n, AT(v_old), v);
    for (size_t k = from; k < to; k++) v[k] = 2 * (moved[k] / j->h) - v[k];
  } else if (s->rates[rod->index]) {
    hb_unit_store3(s->model, j->u, n, AT(v), v);
  }
  memset(state->load + from, 0, (to - from) * sizeof(double));
  memset(state->force + from, 0, (to - from) * sizeof(double));
  for (int k = 0; s->terms[k]; k++)
    if (terms & (1u << k))
      s->terms[k]->add(s->model, rod, j->t, x, v, NULL,
                       s->terms[k]->dissipative ? state->force : state->load);
  for (size_t k = from; k < to; k++) {
    work += state->load[k] * moved[k];
    state->force[k] += state->load[k];
  }
  hb_unit_add3(s->model, j->u, n, AT(load), state->load);
  hb_unit_add3(s->model, j->u, n, AT(f), state->force);
  j->u->tally[HB_S_WORK_LOADS] += 0.5 * work;
}

/* What the loads' formulas are now, into the lanes. */
static void set_uniform_loads(const hb_journey *j) {
  const hb_stepper *s = j->s;
  bool windy = false, damped = false;
  for (int n = 0; n < j->u->rod_count; n++) {
    const hb_rod *rod = &s->model->rods[j->u->rods[n]];
    hb_uniform_load sum = {.damping = 0};
    for (int k = 0; s->terms[k]; k++)
      if (s->uniform[rod->index] & (1u << k)) (void)s->terms[k]->uniform(s->model, rod, s->values, &sum);
    hb_unit_set_loads(j->u, n, &sum);
    for (int c = 0; c < 2; c++) windy = windy || sum.linear[c] != 0 || sum.quadratic[c] != 0;
    damped = damped || sum.damping != 0;
  }
  for (int g = 0; g < j->u->strip_count; g++) {
    j->u->strips[g].windy = windy;
    j->u->strips[g].damped = damped;
  }
}

/* Loads on all rods of the unit, their work (half of the force before the step and half of that after it),
 * and what damping takes. */
static void add_loads(const hb_journey *j) {
  const hb_stepper *s = j->s;
  hb_unit *u = j->u;
  unsigned active = 0;
  for (int n = 0; n < u->rod_count; n++) active |= s->active[u->rods[n]];
  if (!active) return;
  for (int g = 0; g < u->strip_count; g++) j->k->assemble(&u->strips[g]);
  set_uniform_loads(j);
  hb_journey_pass(j, LOADS);
  for (int g = 0; g < u->strip_count; g++)
    for (int l = 0; l < hb_journey_lanes(u); l++) {
      const hb_strip *strip = &u->strips[g];
      u->tally[HB_S_WORK_LOADS] += 0.5 * hb_strip_get(strip, strip->work, 0, l);
      if (strip->damped)
        u->tally[HB_S_DISSIPATED] += hb_strip_get(strip, strip->law, HB_LAW_NUMBERS - 1, l) / j->h *
                                     hb_strip_get(strip, strip->lost, 0, l);
    }
  for (int n = 0; n < u->rod_count; n++) {
    unsigned left = s->active[u->rods[n]] & ~s->uniform[u->rods[n]];
    if (left) add_general_loads(j, n, left);
  }
}

/* Forces at the new positions where something is folded: by the rod's own functions. */
static hb_status evaluate_rods(const hb_journey *j, hb_error *err) {
  hb_unit *u = j->u;
  hb_status status = HB_OK;
  for (int g = 0; g < u->strip_count; g++) u->strips[g].split = false;
  for (int n = 0; !status && n < u->rod_count; n++) {
    const hb_rod *rod = &j->s->model->rods[u->rods[n]];
    hb_unit_store3(j->s->model, u, n, AT(x), j->s->state->x);
    status = hb_rod_settle(j->s->model, rod, j->s->state, &j->s->rod_work, j->t, j->h, err);
    if (status) break;
    hb_rod_force(j->s->model, rod, j->s->state, &j->s->rod_work);
    if (!(j->s->rod_work.lowest_chi > HB_FOLD_LIMIT)) {
      u->tally[HB_S_FOLDS]++;
      u->tally[HB_S_FOLD_SLOT] = rod->first + hb_rod_find_fold(rod, &j->s->rod_work);
    }
    hb_unit_clear3(u, n, AT(f));
    hb_unit_add3(j->s->model, u, n, AT(f), j->s->state->force);
  }
  if (!status) add_loads(j);
  if (!status) hb_journey_pass(j, SUM_UP);
  return status;
}

/* Prescribed frames of the n-th rod, a general one: their directors into the lanes. */
static hb_status hold_frames(const hb_journey *j, int n, hb_error *err) {
  const hb_model *m = j->s->model;
  const hb_rod *rod = &m->rods[j->u->rods[n]];
  hb_rod_work *w = &j->s->rod_work;
  fill_held_tangents(j, n);
  hb_status status = hb_frames_check(m, rod, w, j->t, err);
  if (status) return status;
  hb_frames_hold(m, rod, j->s->state, w, j->t);
  for (int k = rod->first_frame; k < rod->first_frame + rod->frame_count; k++) {
    hb_unit_set_edge(j->u, n, m->frames[k].slot - rod->first, AT(m1), 3, w->frame_now + 3 * k);
    hb_unit_set_edge(j->u, n, m->frames[k].slot - rod->first, AT(spin), 1, &w->frame_turned[k]);
  }
  return HB_OK;
}

/* How the twist of each rod of a unit is coming on. */
typedef struct twisting {
  double residual[HB_LANES_MAX]; /* at the last look */
  bool irregular[HB_LANES_MAX];
  int going;
} twisting;

/* Judges a look: which rods are in equilibrium, which need the rod's own functions. */
static void judge_twist(const hb_journey *j, int iteration, bool closed, twisting *g) {
  hb_unit *u = j->u;
  hb_strip *s = u->strips;
  double epsilon = j->k->single ? (double)FLT_EPSILON : DBL_EPSILON;
  g->going = 0;
  for (int n = 0; n < u->rod_count; n++) {
    if (!(hb_strip_get(s, s->active, 0, n) > 0)) continue;
    double residual = hb_journey_largest(u, AT(worst), n), scale = hb_journey_largest(u, AT(scale), n);
    double small = 16 * epsilon * scale + 4 * epsilon * hb_journey_largest(u, AT(floor), n) + DBL_MIN;
    bool stuck = iteration > 0 && residual >= 0.5 * g->residual[n] && residual <= 4e4 * epsilon * scale;
    bool sound = closed && hb_journey_full(u, n) && residual < HUGE_VAL;
    if (!sound || (iteration > 0 && residual > g->residual[n] && !stuck) || iteration > TWIST_ITERATIONS)
      g->irregular[n] = true;
    g->residual[n] = residual;
    if (g->irregular[n] || residual <= small || stuck)
      hb_strip_set(s, s->active, 0, n, 0);
    else
      g->going++;
  }
}

/* Judges the turns that were found: long ones are none of Newton's any more. */
static void judge_turns(const hb_journey *j, twisting *g) {
  hb_unit *u = j->u;
  hb_strip *s = u->strips;
  for (int n = 0; n < u->rod_count; n++) {
    if (!(hb_strip_get(s, s->active, 0, n) > 0)) continue;
    if (hb_journey_largest(u, AT(left), n) <= LONG_TURN) {
      u->tally[HB_S_TWIST_ITERATIONS]++;
      continue;
    }
    g->irregular[n] = true;
    hb_strip_set(s, s->active, 0, n, 0);
    for (int h = 0; h < u->strip_count; h++) j->k->drop_turns(&u->strips[h], u->pieces ? -1 : n);
  }
}

/* Lanes of idle rods do as the first. */
static void copy_active(const hb_unit *u) {
  hb_strip *s = u->strips;
  double first = hb_strip_get(s, s->active, 0, 0);
  if (u->pieces) {
    for (int g = 0; g < u->strip_count; g++)
      for (int l = 0; l < s->lanes; l++) hb_strip_set(&u->strips[g], u->strips[g].active, 0, l, first);
  } else {
    for (int l = u->rod_count; l < s->lanes; l++) hb_strip_set(s, s->active, 0, l, first);
  }
}

/* Newton on the turns of all general rods of a unit. */
static void settle_twist(const hb_journey *j, twisting *g) {
  hb_unit *u = j->u;
  hb_journey_set(u, AT(active), 1);
  for (int iteration = 0;; iteration++) {
    hb_journey_pass(j, iteration == 0 ? FIRST_LOOK : LOOK);
    bool closed = !u->pieces || j->k->close(u->strips, u->strip_count, true, u->chain);
    if (iteration == 0)
      for (int n = 0; n < u->rod_count; n++) g->irregular[n] = rod_folded(u, n);
    judge_twist(j, iteration, closed, g);
    if (g->going == 0) return;
    copy_active(u);
    hb_journey_pass(j, SOLVE_TURNS);
    judge_turns(j, g);
    hb_journey_pass(j, TURN);
  }
}

/* The n-th rod's twist by its own functions, from where its frames are. */
static hb_status resume_twist(const hb_journey *j, int n, hb_error *err) {
  hb_stepper *s = j->s;
  const hb_rod *rod = &s->model->rods[j->u->rods[n]];
  double *x = s->state->x;
  hb_unit_store3(s->model, j->u, n, AT(x), x);
  hb_unit_store_frames(s->model, s->state, j->u, n);
  if (!hb_rod_geometry(rod, x, &s->rod_work))
    return hb_fail(err, HB_ERR_NUMERIC, "rod %s: a vertex position is not finite, or an edge has length zero",
                   rod->name);
  hb_status status = hb_twist_resume(s->model, rod, s->state, &s->rod_work, err);
  hb_unit_load_frames(s->model, s->state, j->u, n);
  if (!(rod_folded(j->u, n))) return status;
  j->u->tally[HB_S_FOLDS]++;
  j->u->tally[HB_S_FOLD_SLOT] = rod->first + hb_rod_find_fold(rod, &s->rod_work);
  return status;
}

/* The same for general rods. */
static hb_status evaluate_general(const hb_journey *j, hb_error *err) {
  hb_unit *u = j->u;
  hb_state *state = j->s->state;
  twisting g = {.going = 0};
  bool again = false;
  hb_stepper_begin(j->s);
  hb_journey_pass(j, CARRY);
  bool steady = u->steady && hb_journey_hold_steady(j);
  for (int n = 0; n < u->rod_count && !steady; n++) {
    hb_status status = hold_frames(j, n, err);
    if (status) return status;
  }
  settle_twist(j, &g);
  for (int n = 0; n < u->rod_count; n++) {
    double m1[3];
    hb_status status = g.irregular[n] ? resume_twist(j, n, err) : HB_OK;
    if (status) return status;
    again = again || g.irregular[n];
    if (steady) continue;
    hb_unit_get_edge(u, n, 0, AT(m1), 3, m1);
    fill_tangent(j, n, 0);
    hb_twist_first_angle(&j->s->model->rods[u->rods[n]], state, m1, &j->s->rod_work);
  }
  if (steady) hb_journey_first_angles(j);
  if (again) hb_journey_pass(j, LOOK);
  hb_stepper_end(j->s, HB_STAGE_TWIST);
  hb_journey_pass(j, GENERAL);
  for (int h = 0; h < u->strip_count; h++) j->k->join_elastic(&u->strips[h]);
  for (int n = 0; n < u->rod_count; n++) {
    const hb_rod *rod = &j->s->model->rods[u->rods[n]];
    for (int k = rod->first_frame; k < rod->first_frame + rod->frame_count; k++)
      hb_unit_get_edge(u, n, j->s->model->frames[k].slot - rod->first, AT(turn_gradient), 1,
                       &state->frame_torque[k]);
  }
  hb_stepper_end(j->s, HB_STAGE_ELASTIC);
  add_loads(j);
  hb_stepper_end(j->s, HB_STAGE_LOADS);
  return HB_OK;
}

/* Elastic forces, twist in equilibrium, loads, at the new positions. */
hb_status hb_journey_evaluate(const hb_journey *j, hb_error *err) {
  hb_unit *u = j->u;
  if (u->general) return evaluate_general(j, err);
  bool flexed = u->twisted && u->strips->uniform;
  hb_stepper_begin(j->s);
  if (u->twisted) hb_journey_pass(j, flexed ? FLEX : TRANSPORT);
  if (u->twisted && folded(u)) return evaluate_rods(j, err);
  bool steady = u->steady && hb_journey_settle_steady(j);
  for (int n = 0; n < u->rod_count; n++) {
    hb_status status = steady ? HB_OK : settle_frames(j, n, err);
    if (status) return status;
    if (u->twisted) fill_moments(j, n);
  }
  hb_stepper_end(j->s, HB_STAGE_TWIST);
  if (!flexed) hb_journey_pass(j, ELASTIC);
  for (int g = 0; g < u->strip_count; g++) j->k->join_elastic(&u->strips[g]);
  if (!u->twisted && folded(u)) return evaluate_rods(j, err);
  for (int n = 0; n < u->rod_count && !steady; n++) {
    const hb_rod *rod = &j->s->model->rods[u->rods[n]];
    for (int k = rod->first_frame; k < rod->first_frame + rod->frame_count; k++)
      j->s->state->frame_torque[k] = hb_rod_frame_torque(j->s->model, rod, j->s->state, &j->s->rod_work, k);
  }
  hb_stepper_end(j->s, HB_STAGE_ELASTIC);
  add_loads(j);
  hb_stepper_end(j->s, HB_STAGE_LOADS);
  return HB_OK;
}
