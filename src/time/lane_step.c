#include "time/lane_step.h"

#include <float.h>
#include <string.h>

#define AT(name) offsetof(hb_strip, name)
/* As in solve/project.c: along fixed directions lengths may have no solution. */
#define FIXED_ITERATIONS 16
/* Twist that has not settled by then, or wants to turn further than this at once, is led by the rod's own
 * functions, which search. */
#define TWIST_ITERATIONS 12
#define LONG_TURN 0.3

/* One unit under way. */
typedef struct journey {
  hb_stepper *s;
  hb_unit *u;
  const hb_lane_kernels *k;
  double t, h;
  bool along; /* lengths along the edges at the start of the step, velocities projected (second order) */
} journey;

/* One pass over all strips of a unit, whose strips may be passed over at the same time. */
typedef enum pass {
  ADVANCE,
  ELIMINATE,
  SPREAD,
  RATES,
  SPREAD_RATES,
  TRANSPORT,
  ELASTIC,
  CARRY,
  FIRST_LOOK,
  LOOK,
  SOLVE_TURNS,
  TURN,
  GENERAL,
  LOADS,
  SUM_UP
} pass;

/* How an attempt went. */
typedef enum outcome { REGULAR, IRREGULAR } outcome;

/* Lanes that count: idle ones repeat the first rod. */
static int busy_lanes(const hb_unit *u) { return u->pieces ? u->strips->lanes : u->rod_count; }

/* May lengths be off by so much that 1/|e| needs a root? (docs/theory, 10.4) */
static bool coarse_lengths(const journey *j) {
  const hb_method_def *method = &j->s->model->def->method;
  return method->length_tolerance_kind != HB_TOLERANCE_RELATIVE ||
         method->length_tolerance > (j->k->single ? 1e-4 : 5e-9);
}

/* One pass over one strip. */
static void do_pass(const journey *j, hb_strip *s, pass which) {
  double half = 0.5 * j->h;
  switch (which) {
  case ADVANCE: j->k->advance(s, j->along ? half : j->h, j->h, j->along); break;
  case ELIMINATE: j->k->eliminate(s, j->along); break;
  case SPREAD: j->k->spread(s, j->along, 1 / j->h); break;
  case RATES: j->k->eliminate_rates(s, half, 1 / j->h); break;
  case SPREAD_RATES: j->k->spread_rates(s); break;
  case TRANSPORT: j->k->transport(s, coarse_lengths(j)); break;
  case ELASTIC: j->k->elastic(s, coarse_lengths(j)); break;
  case CARRY: j->k->carry(s, coarse_lengths(j)); break;
  case FIRST_LOOK: j->k->look(s, true); break;
  case LOOK: j->k->look(s, false); break;
  case SOLVE_TURNS: j->k->solve_turns(s); break;
  case TURN: j->k->turn(s); break;
  case GENERAL: j->k->general(s); break;
  case LOADS: j->k->loads(s, j->h, j->along); break;
  case SUM_UP: j->k->sum_up(s); break;
  }
}

/* A pass as the pool wants it. */
typedef struct pass_task {
  const journey *j;
  pass which;
} pass_task;

/* One strip of it. */
static void pass_strip(void *context, int index, int worker) {
  const pass_task *task = context;
  (void)worker;
  do_pass(task->j, &task->j->u->strips[index], task->which);
}

/* One pass over all strips; by all threads where the unit has many and the threads have nothing else to do.
 */
static void all_strips(const journey *j, pass which) {
  pass_task task = {j, which};
  hb_pool_run(j->u->strip_count >= HB_SHARED_STRIPS ? j->s->pool : NULL, j->u->strip_count, pass_strip,
              &task);
}

/* A strip's record in every lane. */
static void set_record(hb_unit *u, size_t record, double value) {
  for (int g = 0; g < u->strip_count; g++) {
    void *array;
    memcpy(&array, (char *)&u->strips[g] + record, sizeof array);
    for (int l = 0; l < u->strips[g].lanes; l++) hb_strip_set(&u->strips[g], array, 0, l, value);
  }
}

/* Largest of a record over the lanes of a rod in pieces, or in one lane of a bundle; not-a-number stays. */
static double largest(const hb_unit *u, size_t record, int lane) {
  double worst = 0;
  for (int g = 0; g < u->strip_count; g++) {
    void *array;
    memcpy(&array, (const char *)&u->strips[g] + record, sizeof array);
    for (int l = u->pieces ? 0 : lane; l < (u->pieces ? u->strips[g].lanes : lane + 1); l++) {
      double value = hb_strip_get(&u->strips[g], array, 0, l);
      if (!(value <= worst)) worst = value;
      if (worst != worst) return worst;
    }
  }
  return worst;
}

/* Had all rows of a rod sound pivots? */
static bool all_full(const hb_unit *u, int lane) {
  for (int g = 0; g < u->strip_count; g++)
    for (int l = u->pieces ? 0 : lane; l < (u->pieces ? u->strips[g].lanes : lane + 1); l++)
      if (!(hb_strip_get(&u->strips[g], u->strips[g].full, 0, l) > 0)) return false;
  return true;
}

/* What was at the start of the step becomes the old; the new is written over what was old before. */
static void turn_over(const journey *j) {
  for (int g = 0; g < j->u->strip_count; g++) {
    hb_strip *s = &j->u->strips[g];
    void *x = s->x, *v = s->v, *lambda = s->lambda;
    s->x = s->x_old;
    s->x_old = x;
    s->v = s->v_old;
    s->v_old = v;
    if (!j->along) continue; /* nobody looks at the multipliers of the other scheme */
    s->lambda = s->lambda_old;
    s->lambda_old = lambda;
  }
}

/* Prescribed vertices to their places at time t. exact: their velocity is the formula's, else the way over h.
 * Those that do not move stay by themselves, without mobility and velocity; only a state that was written to
 * may have them elsewhere. */
static void place(const journey *j, bool exact) {
  const hb_model *m = j->s->model;
  if (!j->u->fresh && !j->u->moving) return;
  for (int n = 0; n < j->u->rod_count; n++) {
    const hb_rod *rod = &m->rods[j->u->rods[n]];
    for (int k = rod->first_position; k < rod->first_position + rod->position_count; k++) {
      const hb_position_support *p = &m->positions[k];
      double x[3], v[3], old[3], rate[3] = {0, 0, 0}, base[3] = {0}, base_v[3] = {0};
      if (!j->u->fresh && !hb_support_moves(m, p)) continue;
      int i = p->slot - rod->first;
      hb_unit_get3(j->u, n, i, AT(x), x);
      hb_unit_get3(j->u, n, i, AT(v), v);
      hb_unit_get3(j->u, n, i, AT(x_old), old);
      if (p->tangent) {
        hb_unit_get3(j->u, n, p->base - rod->first, AT(x), base);
        hb_unit_get3(j->u, n, p->base - rod->first, AT(v), base_v);
      }
      hb_support_at(m, p, j->t, base, base_v, x, rate);
      for (int c = 0; c < 3; c++) v[c] = exact ? rate[c] : (x[c] - old[c]) / j->h;
      hb_unit_set3(j->u, n, i, AT(x), x);
      hb_unit_set3(j->u, n, i, AT(v), v);
    }
  }
}

/* Elimination of all strips and, in pieces, of what is left of them. */
static bool solve_rows(const journey *j, bool rates) {
  hb_unit *u = j->u;
  all_strips(j, rates ? RATES : ELIMINATE);
  return !u->pieces || j->k->close(u->strips, u->strip_count, false, u->chain);
}

/* Which rods are done after a look at their lengths; -1 if one never will be. */
static int judge_lengths(const journey *j, int iteration, const double *tolerance, double *worst) {
  hb_unit *u = j->u;
  int going = 0, limit = j->s->model->def->method.max_projections;
  if (limit > FIXED_ITERATIONS) limit = FIXED_ITERATIONS;
  for (int n = 0; n < u->rod_count; n++) {
    hb_strip *s = u->strips;
    if (!(hb_strip_get(s, s->active, 0, n) > 0)) continue;
    worst[n] = largest(u, AT(worst), n);
    if (worst[n] <= *tolerance) {
      hb_strip_set(s, s->active, 0, n, 0);
      if (worst[n] > u->length_error) u->length_error = worst[n];
    } else if (!(worst[n] < HUGE_VAL) || iteration >= limit) {
      return -1;
    } else {
      going++;
    }
  }
  return going;
}

/* Are two neighbouring vertices led by formulas? No correction changes the edge between them, so what one
 * leaves says nothing of its length. Tangents keep it by themselves. */
static bool leads_edges(const hb_model *m, const hb_rod *rod) {
  for (int k = rod->first_position; k < rod->first_position + rod->position_count; k++) {
    const hb_position_support *p = &m->positions[k];
    if (p->tangent || !hb_support_moves(m, p)) continue;
    const double *w = m->inv_mass + 3 * p->slot;
    if ((p->slot > rod->first && w[-3] == 0) || (p->slot + 1 < rod->first + rod->nv && w[3] == 0))
      return true;
  }
  return false;
}

/* Which are done because what a correction leaves is known to be nothing; how many are not. */
static int judge_corrections(const journey *j, bool closed, double tolerance, const double *worst) {
  hb_unit *u = j->u;
  int going = 0;
  for (int n = 0; n < u->rod_count; n++) {
    hb_strip *s = u->strips;
    if (!(hb_strip_get(s, s->active, 0, n) > 0)) continue;
    u->tally[HB_S_PROJECTIONS]++;
    double left = largest(u, AT(left), n);
    if (closed && left <= 0.25 * tolerance && worst[n] < 1e-2 && tolerance >= 1e-12 && all_full(u, n) &&
        !(j->u->moving && leads_edges(j->s->model, &j->s->model->rods[u->rods[n]]))) {
      hb_strip_set(s, s->active, 0, n, 0);
      if (left > u->length_error) u->length_error = left;
    } else {
      going++;
    }
  }
  return going;
}

/* Newton on the lengths of all rods of the unit; rods that are done wait. */
static outcome fit_lengths(const journey *j) {
  hb_unit *u = j->u;
  double tolerance = j->s->model->def->method.length_tolerance, worst[HB_LANES_MAX] = {0};
  set_record(u, AT(active), 1);
  for (int iteration = 0;; iteration++) {
    bool closed = solve_rows(j, false);
    int going = judge_lengths(j, iteration, &tolerance, worst);
    if (going < 0) return IRREGULAR;
    if (going == 0) return REGULAR;
    all_strips(j, SPREAD);
    for (int g = 0; g < u->strip_count; g++) j->k->join_spread(&u->strips[g], j->along);
    if (judge_corrections(j, closed, tolerance, worst) == 0) return REGULAR;
  }
}

/* Tangent of one edge into the rod's workspace. */
static void fill_tangent(const journey *j, int n, int edge) {
  hb_lane_place p = hb_unit_find(j->u, n, edge);
  double e[3];
  for (int c = 0; c < 3; c++) {
    size_t at = 3 * (size_t)p.row + (size_t)c;
    e[c] = hb_strip_get(p.strip, p.strip->x, at + 3, p.lane) - hb_strip_get(p.strip, p.strip->x, at, p.lane);
  }
  hb_v3_store(j->s->rod_work.tangent + 3 * edge, hb_v3_unit(hb_v3_load(e)));
}

/* Tangents of the first edge and of those whose frames are held. */
static void fill_held_tangents(const journey *j, int n) {
  const hb_rod *rod = &j->s->model->rods[j->u->rods[n]];
  fill_tangent(j, n, 0);
  for (int k = rod->first_frame; k < rod->first_frame + rod->frame_count; k++)
    if (j->s->model->frames[k].slot > rod->first)
      fill_tangent(j, n, j->s->model->frames[k].slot - rod->first);
}

/* Transport along one panel: the products of its cuts, one behind the other. */
static hb_quat panel_transport(const hb_unit *u, int n, int from, int to) {
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
static hb_status settle_frames(const journey *j, int n, hb_error *err) {
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
      turns[p] = panel_transport(j->u, n, m->panels[p].from - rod->first, m->panels[p].to - rod->first);
    }
  hb_twist_closed(m, rod, j->s->state, &j->s->rod_work, turns);
  return HB_OK;
}

/* Moment of each span to its vertices, in every copy. */
static void fill_moments(const journey *j, int n) {
  const hb_model *m = j->s->model;
  hb_unit *u = j->u;
  const hb_rod *rod = &m->rods[u->rods[n]];
  for (int g = 0; g < u->strip_count; g++) {
    hb_strip *s = &u->strips[g];
    for (int l = 0; l < s->lanes && s->uniform; l++)
      if (u->pieces || l == n || (n == 0 && l >= u->rod_count))
        hb_strip_set(s, s->rod_moment, 0, l, j->s->state->moment[rod->first_span]);
    for (int l = 0; l < s->lanes && !s->uniform; l++) {
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
static void add_general_loads(const journey *j, int n, unsigned terms) {
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
static void set_uniform_loads(const journey *j) {
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
static void add_loads(const journey *j) {
  const hb_stepper *s = j->s;
  hb_unit *u = j->u;
  unsigned active = 0;
  for (int n = 0; n < u->rod_count; n++) active |= s->active[u->rods[n]];
  if (!active) return;
  set_uniform_loads(j);
  all_strips(j, LOADS);
  for (int g = 0; g < u->strip_count; g++)
    for (int l = 0; l < busy_lanes(u); l++) {
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
static hb_status evaluate_rods(const journey *j, hb_error *err) {
  hb_unit *u = j->u;
  hb_status status = HB_OK;
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
  return status;
}

/* Prescribed frames of the n-th rod, a general one: their directors into the lanes. */
static hb_status hold_frames(const journey *j, int n, hb_error *err) {
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
static void judge_twist(const journey *j, int iteration, bool closed, twisting *g) {
  hb_unit *u = j->u;
  hb_strip *s = u->strips;
  double epsilon = j->k->single ? (double)FLT_EPSILON : DBL_EPSILON;
  g->going = 0;
  for (int n = 0; n < u->rod_count; n++) {
    if (!(hb_strip_get(s, s->active, 0, n) > 0)) continue;
    double residual = largest(u, AT(worst), n), scale = largest(u, AT(scale), n);
    double small = 16 * epsilon * scale + 4 * epsilon * largest(u, AT(floor), n) + DBL_MIN;
    bool stuck = iteration > 0 && residual >= 0.5 * g->residual[n] && residual <= 4e4 * epsilon * scale;
    bool sound = closed && all_full(u, n) && residual < HUGE_VAL;
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
static void judge_turns(const journey *j, twisting *g) {
  hb_unit *u = j->u;
  hb_strip *s = u->strips;
  for (int n = 0; n < u->rod_count; n++) {
    if (!(hb_strip_get(s, s->active, 0, n) > 0)) continue;
    if (largest(u, AT(left), n) <= LONG_TURN) {
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
static void settle_twist(const journey *j, twisting *g) {
  hb_unit *u = j->u;
  set_record(u, AT(active), 1);
  for (int iteration = 0;; iteration++) {
    all_strips(j, iteration == 0 ? FIRST_LOOK : LOOK);
    bool closed = !u->pieces || j->k->close(u->strips, u->strip_count, true, u->chain);
    if (iteration == 0)
      for (int n = 0; n < u->rod_count; n++) g->irregular[n] = rod_folded(u, n);
    judge_twist(j, iteration, closed, g);
    if (g->going == 0) return;
    copy_active(u);
    all_strips(j, SOLVE_TURNS);
    judge_turns(j, g);
    all_strips(j, TURN);
  }
}

/* The n-th rod's twist by its own functions, from where its frames are. */
static hb_status resume_twist(const journey *j, int n, hb_error *err) {
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
static hb_status evaluate_general(const journey *j, hb_error *err) {
  hb_unit *u = j->u;
  hb_state *state = j->s->state;
  twisting g = {.going = 0};
  bool again = false;
  hb_stepper_begin(j->s);
  all_strips(j, CARRY);
  for (int n = 0; n < u->rod_count; n++) {
    hb_status status = hold_frames(j, n, err);
    if (status) return status;
  }
  settle_twist(j, &g);
  for (int n = 0; n < u->rod_count; n++) {
    double m1[3];
    hb_status status = g.irregular[n] ? resume_twist(j, n, err) : HB_OK;
    if (status) return status;
    again = again || g.irregular[n];
    hb_unit_get_edge(u, n, 0, AT(m1), 3, m1);
    fill_tangent(j, n, 0);
    hb_twist_first_angle(&j->s->model->rods[u->rods[n]], state, m1, &j->s->rod_work);
  }
  if (again) all_strips(j, LOOK);
  hb_stepper_end(j->s, HB_STAGE_TWIST);
  all_strips(j, GENERAL);
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
static hb_status evaluate(const journey *j, hb_error *err) {
  hb_unit *u = j->u;
  if (u->general) return evaluate_general(j, err);
  hb_stepper_begin(j->s);
  if (u->twisted) all_strips(j, TRANSPORT);
  if (u->twisted && folded(u)) return evaluate_rods(j, err);
  for (int n = 0; n < u->rod_count; n++) {
    hb_status status = settle_frames(j, n, err);
    if (status) return status;
    if (u->twisted) fill_moments(j, n);
  }
  hb_stepper_end(j->s, HB_STAGE_TWIST);
  all_strips(j, ELASTIC);
  for (int g = 0; g < u->strip_count; g++) j->k->join_elastic(&u->strips[g]);
  if (!u->twisted && folded(u)) return evaluate_rods(j, err);
  for (int n = 0; n < u->rod_count; n++) {
    const hb_rod *rod = &j->s->model->rods[u->rods[n]];
    for (int k = rod->first_frame; k < rod->first_frame + rod->frame_count; k++)
      j->s->state->frame_torque[k] = hb_rod_frame_torque(j->s->model, rod, j->s->state, &j->s->rod_work, k);
  }
  hb_stepper_end(j->s, HB_STAGE_ELASTIC);
  add_loads(j);
  hb_stepper_end(j->s, HB_STAGE_LOADS);
  return HB_OK;
}

/* Forces on prescribed vertices and torques on frames at the start of the step, for the work of supports. */
static void keep_support_forces(const journey *j) {
  hb_stepper *s = j->s;
  for (int n = 0; n < j->u->rod_count; n++) {
    const hb_rod *rod = &s->model->rods[j->u->rods[n]];
    for (int k = rod->first_position; j->u->moving && k < rod->first_position + rod->position_count; k++)
      if (hb_support_moves(s->model, &s->model->positions[k]))
        hb_unit_get3(j->u, n, s->model->positions[k].slot - rod->first, AT(f), s->force_old + 3 * k);
    for (int k = rod->first_frame; k < rod->first_frame + rod->frame_count; k++)
      s->torque_old[k] = s->state->frame_torque[k];
  }
}

/* Pull of the edges on vertex i: unknown_i e^i - unknown_{i-1} e^{i-1}, edges taken from the array at `way`.
 */
static void edge_pull(const journey *j, int n, int i, bool rates, size_t way, double out[3]) {
  int last = j->s->model->rods[j->u->rods[n]].nv - 1;
  out[0] = out[1] = out[2] = 0;
  for (int side = 0; side < 2; side++) {
    int edge = i - 1 + side;
    double a[3], b[3];
    if (edge < 0 || edge >= last) continue;
    hb_lane_place p = hb_unit_find(j->u, n, edge);
    double unknown = hb_strip_get(p.strip, rates ? p.strip->right : p.strip->lambda, (size_t)p.row, p.lane);
    hb_unit_get3(j->u, n, edge, way, a);
    hb_unit_get3(j->u, n, edge + 1, way, b);
    for (int c = 0; c < 3; c++) out[c] += (side ? 1 : -1) * unknown * (b[c] - a[c]);
  }
}

/* Work of moving supports over a second-order step, from the momentum that they must have given. */
static void book_supports(const journey *j) {
  hb_stepper *s = j->s;
  double work = 0;
  for (int n = 0; n < j->u->rod_count; n++) {
    const hb_rod *rod = &s->model->rods[j->u->rods[n]];
    for (int k = rod->first_position; j->u->moving && k < rod->first_position + rod->position_count; k++) {
      const hb_position_support *p = &s->model->positions[k];
      double x[3], x_old[3], v[3], v_old[3], f[3], pull[3], rate_pull[3];
      int i = p->slot - rod->first;
      if (!hb_support_moves(s->model, p)) continue;
      hb_unit_get3(j->u, n, i, AT(x), x);
      hb_unit_get3(j->u, n, i, AT(x_old), x_old);
      hb_unit_get3(j->u, n, i, AT(v), v);
      hb_unit_get3(j->u, n, i, AT(v_old), v_old);
      hb_unit_get3(j->u, n, i, AT(f), f);
      edge_pull(j, n, i, false, AT(x_old), pull);
      edge_pull(j, n, i, true, AT(x), rate_pull);
      for (int c = 0; c < 3; c++) {
        double given = 0.5 * (s->force_old[3 * k + c] + f[c]);
        double force = s->model->mass[p->slot] * (v[c] - v_old[c]) / j->h - given - pull[c] / (j->h * j->h) -
                       rate_pull[c] / j->h;
        work += force * (x[c] - x_old[c]);
      }
    }
    for (int k = rod->first_frame; k < rod->first_frame + rod->frame_count; k++)
      work += 0.5 * (s->torque_old[k] + s->state->frame_torque[k]) * s->rod_work.frame_turned[k];
  }
  j->u->tally[HB_S_WORK_SUPPORTS] += work;
}

/* Is every force and velocity a number? */
static bool is_finite(const hb_unit *u) {
  double sum = 0;
  for (int g = 0; g < u->strip_count; g++)
    for (int l = 0; l < busy_lanes(u); l++) sum += hb_strip_get(&u->strips[g], u->strips[g].finite, 0, l);
  return isfinite(sum);
}

/* The same of a unit whose rods have been stepped one by one: what the state says. */
static bool state_is_finite(const hb_stepper *s, const hb_unit *u) {
  double sum = 0;
  for (int n = 0; n < u->rod_count; n++) {
    const hb_rod *rod = &s->model->rods[u->rods[n]];
    for (int k = 3 * rod->first; k < 3 * (rod->first + rod->nv); k++)
      sum += s->state->force[k] + s->state->v[k];
  }
  return isfinite(sum);
}

/* The step once more, rod by rod, from where it began. */
static hb_status step_rods(const journey *j, hb_rod_step step_rod, hb_error *err) {
  hb_stepper *s = j->s;
  hb_unit *u = j->u;
  hb_status status = HB_OK;
  turn_over(j);
  memset(u->tally, 0, HB_S_COUNT * sizeof *u->tally);
  u->length_error = 0;
  hb_unit_store(s->model, s->state, u);
  s->length_error = 0;
  for (int n = 0; !status && n < u->rod_count; n++)
    status = step_rod(s, &s->model->rods[u->rods[n]], j->t, j->h, err);
  hb_unit_load(s->model, s->state, u);
  u->length_error = s->length_error;
  u->finite = state_is_finite(s, u);
  return status;
}

/* Beginning of a step. */
static void begin(const journey *j) {
  memset(j->u->tally, 0, HB_S_COUNT * sizeof *j->u->tally);
  j->u->length_error = 0;
  hb_stepper_begin(j->s);
  keep_support_forces(j);
  turn_over(j);
}

/* Symplectic Euler with fast projection. */
hb_status hb_lane_step_euler(hb_stepper *s, hb_unit *u, double t, double h, hb_rod_step step_rod,
                             hb_error *err) {
  journey j = {s, u, s->plan->kernels, t, h, false};
  begin(&j);
  all_strips(&j, ADVANCE);
  if (u->fresh) place(&j, false); /* none of them moves (time/rods.c) */
  hb_stepper_end(s, HB_STAGE_MOVE);
  if (fit_lengths(&j) == IRREGULAR) return step_rods(&j, step_rod, err);
  hb_stepper_end(s, HB_STAGE_PROJECT);
  hb_status status = evaluate(&j, err);
  if (status) return status;
  if (u->fresh > 0) u->fresh--;
  book_supports(&j);
  all_strips(&j, SUM_UP);
  u->finite = is_finite(u);
  return HB_OK;
}

/* Constrained velocity Verlet (SHAKE and RATTLE). */
hb_status hb_lane_step_verlet(hb_stepper *s, hb_unit *u, double t, double h, hb_rod_step step_rod,
                              hb_error *err) {
  journey j = {s, u, s->plan->kernels, t, h, true};
  begin(&j);
  all_strips(&j, ADVANCE);
  place(&j, false);
  hb_stepper_end(s, HB_STAGE_MOVE);
  if (fit_lengths(&j) == IRREGULAR) return step_rods(&j, step_rod, err);
  hb_stepper_end(s, HB_STAGE_PROJECT);
  hb_status status = evaluate(&j, err);
  if (status) return status;
  hb_stepper_begin(s);
  place(&j, true);
  (void)solve_rows(&j, true);
  all_strips(&j, SPREAD_RATES);
  for (int g = 0; g < u->strip_count; g++) j.k->join_spread(&u->strips[g], false);
  hb_stepper_end(s, HB_STAGE_PROJECT);
  if (u->fresh > 0) u->fresh--;
  book_supports(&j);
  u->finite = is_finite(u);
  return HB_OK;
}
