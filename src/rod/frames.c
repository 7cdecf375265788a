/* Bishop frames, prescribed material frames, first guesses (docs/theory, 2.3 and 3.1). */
#include "rod/rod.h"

#include "math/rotation.h"
#include "rod/writhe.h"

#include <string.h>

/* t^j. */
static inline hb_v3 tangent_at(const hb_rod_work *w, int j) { return hb_v3_load(w->tangent + 3 * j); }

/* A prescribed formula of time at time t. */
static double at_time(const hb_formula *f, double t) {
  double vars[HB_VAR_COUNT] = {0};
  vars[HB_VAR_T] = t;
  return f ? hb_formula_eval(f, vars) : 0;
}

/* u^0 carried along the rod from edge to edge. */
void hb_frames_bishop(const hb_rod *rod, const hb_rod_work *work, const double u0[3], double *out) {
  hb_v3 t = tangent_at(work, 0), u = hb_v3_load(u0);
  hb_v3_store(out, u);
  for (int j = 1; j <= rod->last_joint; j++) {
    hb_v3 next = tangent_at(work, j);
    u = hb_carry(u, t, next);
    hb_v3_store(out + 3 * j, u);
    t = next;
  }
}

/* The director that support k prescribes at time t, before any extra turn about the tangent. *turned: how far
 * that is turned from where time-parallel transport would have carried it. */
static hb_v3 base_director(const hb_frame_support *f, const hb_state *state, int k, hb_v3 t_now, double t,
                           double *turned) {
  hb_v3 carried =
      hb_carry(hb_v3_load(state->frame_m1 + 3 * k), hb_v3_load(state->frame_tangent + 3 * k), t_now);
  *turned = 0;
  if (f->def->kind != HB_SUPPORT_DIRECTOR) return carried;
  hb_v3 d = {at_time(f->def->value[0], t), at_time(f->def->value[1], t), at_time(f->def->value[2], t)};
  d = hb_project_normal(d, t_now);
  *turned = hb_angle_about(carried, d, t_now);
  return d;
}

/* How far the prescribed angle of support k has advanced since the start; directors given in space turn by
 * all of it. */
static double turned_since_start(const hb_frame_support *f, double angle) {
  return f->def->kind == HB_SUPPORT_ANGLE ? angle - at_time(f->def->angle, 0) : angle;
}

/* Formulas of directors may fail at some time: not finite, or along their edge, where they say nothing. */
hb_status hb_frames_check(const hb_model *model, const hb_rod *rod, const hb_rod_work *work, double t,
                          hb_error *err) {
  for (int k = rod->first_frame; k < rod->first_frame + rod->frame_count; k++) {
    const hb_frame_support *f = &model->frames[k];
    int edge = f->slot - rod->first;
    if (!isfinite(at_time(f->def->angle, t)))
      return hb_fail(err, HB_ERR_NUMERIC, "rod %s: the prescribed angle of edge %d is not finite at t = %.9g",
                     rod->name, edge, t);
    if (f->def->kind != HB_SUPPORT_DIRECTOR) continue;
    hb_v3 d = {at_time(f->def->value[0], t), at_time(f->def->value[1], t), at_time(f->def->value[2], t)};
    double across = hb_v3_norm(hb_v3_cross(d, tangent_at(work, edge)));
    if (!(across > 1e-6 * hb_v3_norm(d)) || !isfinite(across))
      return hb_fail(
          err, HB_ERR_NUMERIC,
          "rod %s: the prescribed director of edge %d, (%g, %g, %g) at t = %.9g, must be finite, not zero "
          "and not along the edge",
          rod->name, edge, d.x, d.y, d.z, t);
  }
  return HB_OK;
}

/* Prescribed directors follow their edge by time-parallel transport and turn by their angle. */
void hb_frames_hold(const hb_model *model, const hb_rod *rod, hb_state *state, hb_rod_work *work, double t) {
  hb_v3 t0 = tangent_at(work, 0);
  double *anchor = state->anchor_m1 + 3 * rod->index, *anchor_t = state->anchor_tangent + 3 * rod->index;
  hb_v3_store(anchor, hb_carry(hb_v3_load(anchor), hb_v3_load(anchor_t), t0));
  hb_v3_store(anchor_t, t0);
  for (int k = rod->first_frame; k < rod->first_frame + rod->frame_count; k++) {
    const hb_frame_support *f = &model->frames[k];
    hb_v3 t_now = tangent_at(work, f->slot - rod->first);
    double angle = at_time(f->def->angle, t), turned;
    hb_v3_store(state->frame_m1 + 3 * k, base_director(f, state, k, t_now, t, &turned));
    hb_v3_store(state->frame_tangent + 3 * k, t_now);
    work->frame_turned[k] = turned + (angle - state->frame_angle[k]);
    state->frame_angle[k] = angle;
  }
  if (rod->closed_form && rod->frame_count > 0)
    state->theta_0[rod->index] += work->frame_turned[rod->first_frame];
  hb_frames_now(model, rod, state, work);
}

/* The directors themselves, from what the state says of them. */
void hb_frames_now(const hb_model *model, const hb_rod *rod, const hb_state *state, hb_rod_work *work) {
  for (int k = rod->first_frame; k < rod->first_frame + rod->frame_count; k++) {
    const hb_frame_support *f = &model->frames[k];
    hb_v3_store(work->frame_now + 3 * k,
                hb_turn(hb_v3_load(state->frame_m1 + 3 * k), tangent_at(work, f->slot - rod->first),
                        turned_since_start(f, state->frame_angle[k])));
  }
}

/* Angle of prescribed frame k at time 0 against the Bishop director u; near: where the branch is looked for.
 */
static double start_angle(const hb_frame_support *f, hb_v3 u, hb_v3 t, double near) {
  double angle = at_time(f->def->angle, 0);
  if (f->def->kind == HB_SUPPORT_ANGLE) return angle;
  hb_v3 d = {at_time(f->def->value[0], 0), at_time(f->def->value[1], 0), at_time(f->def->value[2], 0)};
  return hb_nearest_angle(hb_angle_about(u, hb_project_normal(d, t), t), near) + angle;
}

/* Is the frame held "as the relaxed state has it", so that it is unknown at the start? */
static bool deferred(const hb_frame_support *f) { return f->def->kind == HB_SUPPORT_ANGLE && f->def->held; }

/* How much of the twist between two edges that is beyond the rest joint k takes: l_i/beta_i. */
static double share_of(const hb_model *m, int k) { return m->voronoi[k] / (m->beta[k] > 0 ? m->beta[k] : 1); }

/* Spreads twist evenly (as l_i / beta_i) between edge a (angle known) and edge b (angle known, or free). */
static void spread(const hb_model *m, const hb_rod *rod, double *theta, int a, int b, bool b_known) {
  double rest = 0, compliance = 0;
  for (int i = a + 1; i <= b; i++) {
    int k = rod->first + i;
    rest += m->rest_twist[k];
    compliance += share_of(m, k);
  }
  double excess = b_known ? theta[b] - theta[a] - rest : 0;
  for (int i = a + 1; i < b + (b_known ? 0 : 1); i++) {
    int k = rod->first + i;
    theta[i] = theta[i - 1] + m->rest_twist[k] + excess * share_of(m, k) / compliance;
  }
}

/* Angles of the prescribed frames, and between them; *first, *last: the edges with the first and the last of
 * them, -1 where there is none. */
static void guess_known(const hb_model *m, const hb_rod *rod, const hb_rod_work *work, const double *u,
                        double *theta, int *first, int *last) {
  int last_known = -1;
  double base = 0; /* angle of the last known frame without the turns that its support adds */
  for (int k = rod->first_frame; k < rod->first_frame + rod->frame_count; k++) {
    const hb_frame_support *f = &m->frames[k];
    int j = f->slot - rod->first;
    if (deferred(f)) continue;
    double near = last_known >= 0 ? base : 0;
    for (int i = (last_known >= 0 ? last_known : j) + 1; i <= j; i++) near += m->rest_twist[rod->first + i];
    theta[j] = start_angle(f, hb_v3_load(u + 3 * j), tangent_at(work, j), near);
    /* windings that are asked for here are not looked for again at the next director */
    base = f->def->kind == HB_SUPPORT_DIRECTOR ? theta[j] - at_time(f->def->angle, 0)
                                               : hb_nearest_angle(theta[j], near);
    if (last_known >= 0)
      spread(m, rod, theta, last_known, j, true);
    else
      *first = j;
    last_known = j;
  }
  *last = last_known;
  if (last_known < 0) *first = -1;
}

/* Material angles against the Bishop frame u: exact at prescribed frames, evenly spread between them. */
static void guess_angles(const hb_model *m, const hb_rod *rod, const hb_rod_work *work, const double *u,
                         double *theta) {
  int first, last, ne = rod->nv - 1;
  guess_known(m, rod, work, u, theta, &first, &last);
  for (int i = first; i > 0; i--) theta[i - 1] = theta[i] - m->rest_twist[rod->first + i];
  if (last < 0) {
    theta[0] = 0;
    last = 0;
  }
  if (last < ne - 1) spread(m, rod, theta, last, ne - 1, false);
}

/* Twist with which the ends of a closed rod are joined, in all; `natural` is what it would have by itself. A
 * material frame with so much twist, carried once around, has to be turned by state->seam to meet itself: not
 * at all after whole turns (12.2). */
static double join(const hb_model *m, const hb_rod *rod, hb_state *state, const hb_rod_work *work,
                   const double *u, double natural) {
  const hb_rod_def *def = &m->def->rods[rod->index];
  int n = rod->nv - 1;
  double gap = hb_angle_about(hb_v3_load(u + 3 * n), hb_v3_load(u), tangent_at(work, n));
  double *seam = &state->seam[rod->index], turns = 2 * HB_PI * def->closing_value;
  if (def->closing == HB_CLOSING_TWIST) {
    *seam = hb_nearest_angle(def->closing_value - gap, 0);
    return def->closing_value;
  }
  *seam = hb_nearest_angle(turns, 0);
  if (def->closing == HB_CLOSING_TURNS) return hb_nearest_angle(gap, natural) + turns;
  double writhe = hb_rod_writhe(state->x + 3 * (size_t)rod->first, n, true);
  return hb_nearest_angle(gap + turns, turns - 2 * HB_PI * writhe);
}

/* Material angles of a closed rod, that behind the last edge too: between prescribed frames as above, from
 * the last of them (or the first edge) once around to the first of them evenly. */
static void guess_around(const hb_model *m, const hb_rod *rod, hb_state *state, const hb_rod_work *work,
                         const double *u, double *theta) {
  int first, last, n = rod->nv - 1, o = rod->first;
  double natural = 0, compliance = 0;
  guess_known(m, rod, work, u, theta, &first, &last);
  if (last < 0) {
    first = last = 0;
    theta[0] = 0;
  }
  int count = n - (last - first);
  for (int step = 1; step <= count; step++) {
    int i = last + step > n ? last + step - n : last + step;
    natural += m->rest_twist[o + i];
    compliance += share_of(m, o + i);
  }
  double between = theta[last] - theta[first], total = join(m, rod, state, work, u, between + natural);
  double excess = total - between - natural, at = theta[last];
  for (int step = 1; step <= count; step++) {
    int i = last + step > n ? last + step - n : last + step;
    at += m->rest_twist[o + i] + excess * share_of(m, o + i) / compliance;
    if (i != first) theta[i] = at;
    if (i == n) at -= total;
    if (i == n && first > 0) theta[0] = at;
  }
}

/* Initial frames. */
void hb_frames_start(const hb_model *model, const hb_rod *rod, hb_state *state, hb_rod_work *work) {
  double *u = work->m1, *theta = work->delta;
  int o = rod->first;
  hb_v3 t0 = tangent_at(work, 0);
  hb_v3 start = hb_project_normal(hb_v3_load(model->start_m1 + 3 * rod->index), t0);
  hb_v3_store(state->anchor_m1 + 3 * rod->index, start);
  hb_v3_store(state->anchor_tangent + 3 * rod->index, t0);
  hb_frames_bishop(rod, work, state->anchor_m1 + 3 * rod->index, u);
  if (rod->closed)
    guess_around(model, rod, state, work, u, theta);
  else
    guess_angles(model, rod, work, u, theta);
  state->theta_0[rod->index] = theta[0];
  for (int k = rod->first_frame; k < rod->first_frame + rod->frame_count; k++) {
    int j = model->frames[k].slot - o;
    hb_v3 t = tangent_at(work, j);
    bool director = model->frames[k].def->kind == HB_SUPPORT_DIRECTOR; /* its angle is not in frame_m1 */
    state->frame_angle[k] = at_time(model->frames[k].def->angle, 0);
    double turn = director ? theta[j] - state->frame_angle[k] : theta[j];
    hb_v3_store(state->frame_m1 + 3 * k, hb_turn(hb_v3_load(u + 3 * j), t, turn));
    hb_v3_store(state->frame_tangent + 3 * k, t);
  }
  for (int s = rod->first_span; s < rod->first_span + rod->span_count; s++)
    for (int p = model->spans[s].first_panel; p < model->spans[s].first_panel + model->spans[s].panel_count;
         p++) {
      int from = model->panels[p].from - o, to = model->panels[p].to - o;
      hb_v3 t = tangent_at(work, to);
      hb_v3_store(state->panel_m1 + 3 * p, hb_turn(hb_v3_load(u + 3 * to), t, theta[to]));
      hb_v3_store(state->panel_tangent + 3 * p, t);
      state->panel_twist[p] = theta[to] - theta[from];
    }
  if (rod->closed_form) return;
  for (int j = 0; j <= rod->last_joint; j++) {
    hb_v3 t = tangent_at(work, j);
    bool again = j + 1 == rod->nv; /* the first edge, as the joint of a closed rod sees it */
    hb_v3 m1 = again ? hb_v3_load(state->m1 + 3 * o) : hb_turn(hb_v3_load(u + 3 * j), t, theta[j]);
    hb_v3_store(state->m1 + 3 * (o + j), m1);
    hb_v3_store(state->tangent + 3 * (o + j), t);
    if (j > 0) state->twist[o + j] = theta[j] - theta[j - 1];
  }
}

/* m1 from edge a to b (b > a forward, else backward), each vertex turning by its twist. */
static void walk(const hb_model *m, const hb_rod *rod, hb_rod_work *w, int a, int b, double moment) {
  int step = b > a ? 1 : -1;
  for (int j = a; j != b; j += step) {
    int i = step > 0 ? j + 1 : j, k = rod->first + i;
    double twist = m->rest_twist[k] + (m->twist_gain[k] > 0 ? moment / m->twist_gain[k] : 0);
    hb_v3 t = tangent_at(w, j), next = tangent_at(w, j + step);
    hb_v3 d = hb_carry(hb_v3_load(w->m1 + 3 * j), t, next);
    hb_v3_store(w->m1 + 3 * (j + step), hb_turn(d, next, step * twist));
  }
}

/* Directors of a closed-form rod. */
void hb_frames_closed(const hb_model *model, const hb_rod *rod, const hb_state *state, hb_rod_work *work) {
  int o = rod->first;
  for (int s = rod->first_span; s < rod->first_span + rod->span_count; s++) {
    const hb_span *span = &model->spans[s];
    int a = span->first_edge - o, b = span->last_edge - o;
    if (span->first_frame >= 0) {
      memcpy(work->m1 + 3 * a, work->frame_now + 3 * span->first_frame, 3 * sizeof(double));
      walk(model, rod, work, a, b, state->moment[s]);
      if (span->last_frame >= 0) /* exactly so, also where no twist can pass (beta = 0) */
        memcpy(work->m1 + 3 * b, work->frame_now + 3 * span->last_frame, 3 * sizeof(double));
    } else if (span->last_frame >= 0) {
      memcpy(work->m1 + 3 * b, work->frame_now + 3 * span->last_frame, 3 * sizeof(double));
      walk(model, rod, work, b, a, 0);
    } else {
      memcpy(work->m1 + 3 * a, state->anchor_m1 + 3 * rod->index, 3 * sizeof(double));
      walk(model, rod, work, a, b, state->moment[s]);
      if (rod->closed) memcpy(work->m1 + 3 * b, work->m1 + 3 * a, 3 * sizeof(double));
    }
  }
}
