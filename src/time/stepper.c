#include "time/integrators.h"

#include "base/clock.h"
#include "base/memory.h"
#include "force/force.h"
#include "math/rotation.h"

#include <math.h>
#include <string.h>

/* Loads whose formulas depend on time alone: what they are at the ends of the steps to come. */
void hb_stepper_look_at_forces(hb_stepper *s, double h) {
  int count = s->model->def->force_count;
  for (int step = 0; step < s->block; step++)
    for (int k = 0; k < count; k++) {
      hb_force_value *value = &s->values[step * count + k];
      double t = (s->state->scalar[HB_S_STEP] + step + 1) * h;
      if (value->uniform) hb_v3_store(value->value, hb_load_begin(&s->model->def->forces[k], t).value);
    }
}

/* Which terms act on which rod, which of them as a uniform load, and which rods feel forces that depend on
 * velocity. */
static void list_terms(hb_stepper *s) {
  int count = s->model->def->force_count;
  for (int k = 0; k < HB_BLOCK_STEPS * count; k++)
    s->values[k].uniform = hb_load_is_uniform(&s->model->def->forces[k % count]);
  for (int r = 0; r < s->model->rod_count; r++) {
    const hb_rod *rod = &s->model->rods[r];
    for (int k = 0; s->terms[k] && k < HB_TERMS_MAX; k++) {
      if (!s->terms[k]->active(s->model, rod)) continue;
      hb_uniform_load unused = {.damping = 0};
      s->active[r] |= 1u << k;
      if (s->terms[k]->uses_velocity) s->rates[r] = 1;
      if (s->terms[k]->uniform && s->terms[k]->uniform(s->model, rod, s->values, &unused))
        s->uniform[r] |= 1u << k;
    }
  }
}

/* Angles of prescribed frames that never turn. */
static void find_still_angles(hb_stepper *s) {
  const double vars[HB_VAR_COUNT] = {0};
  for (int k = 0; k < s->model->frame_count; k++) {
    const hb_support_def *def = s->model->frames[k].def;
    bool still = def->kind == HB_SUPPORT_ANGLE && (!def->angle || hb_formula_is_constant(def->angle));
    double angle = still && def->angle ? hb_formula_eval(def->angle, vars) : 0;
    s->still_angle[k] = still && isfinite(angle) ? angle : (double)NAN;
  }
}

/* Workspace of a run. */
hb_status hb_stepper_init(hb_stepper *s, const hb_model *model, hb_state *state,
                          const hb_force_term *const *terms, hb_error *err) {
  memset(s, 0, sizeof *s);
  s->model = model;
  s->state = state;
  s->terms = terms;
  size_t n = 3 * (size_t)model->nv;
  hb_status status = hb_rod_work_create(model, &s->rod_work, err);
  if (!status) status = hb_project_work_create(model, &s->project_work, err);
  if (status) return status;
  s->x_old = hb_alloc(n, sizeof *s->x_old);
  s->v_old = hb_alloc(n, sizeof *s->v_old);
  s->v_predicted = hb_alloc(n, sizeof *s->v_predicted);
  s->force_old = hb_alloc(3 * (size_t)model->position_count, sizeof *s->force_old);
  s->torque_old = hb_alloc((size_t)model->frame_count, sizeof *s->torque_old);
  s->still_angle = hb_alloc((size_t)model->frame_count, sizeof *s->still_angle);
  s->rates = hb_alloc((size_t)model->rod_count, sizeof *s->rates);
  s->active = hb_alloc((size_t)model->rod_count, sizeof *s->active);
  s->uniform = hb_alloc((size_t)model->rod_count, sizeof *s->uniform);
  s->values = hb_alloc(HB_BLOCK_STEPS * (size_t)model->def->force_count, sizeof *s->values);
  if (model->any_follower) s->follower_m1 = hb_alloc(n, sizeof *s->follower_m1);
  if (!s->x_old || !s->v_old || !s->v_predicted || !s->force_old || !s->torque_old || !s->still_angle ||
      !s->rates || !s->active || !s->uniform || !s->values || (model->any_follower && !s->follower_m1))
    return hb_fail_memory(err, "workspace of the run");
  list_terms(s);
  find_still_angles(s);
  return HB_OK;
}

/* Frees it; also after a failed init. */
void hb_stepper_release(hb_stepper *s) {
  hb_rod_work_free(&s->rod_work);
  hb_project_work_free(&s->project_work);
  hb_free(s->x_old);
  hb_free(s->v_old);
  hb_free(s->v_predicted);
  hb_free(s->force_old);
  hb_free(s->torque_old);
  hb_free(s->still_angle);
  hb_free(s->rates);
  hb_free(s->active);
  hb_free(s->uniform);
  hb_free(s->values);
  hb_free(s->follower_m1);
  hb_implicit_free(s->implicit);
  hb_stepper_release_workers(s);
  hb_lane_plan_free(s->plan);
  hb_pool_free(s->pool);
}

/* Restarts the stage clock. */
void hb_stepper_begin(hb_stepper *s) {
  if (s->timed) s->stage_started = hb_clock_now();
}

/* Books the time since begin. */
void hb_stepper_end(hb_stepper *s, hb_stage stage) {
  if (!s->timed) return;
  double now = hb_clock_now();
  s->stage_seconds[stage] += now - s->stage_started;
  s->stage_started = now;
}

/* Where the rod was. */
void hb_stepper_keep(hb_stepper *s, const hb_rod *rod) {
  size_t o = 3 * (size_t)rod->first, n = 3 * (size_t)rod->nv * sizeof(double);
  memcpy(s->x_old + o, s->state->x + o, n);
  memcpy(s->v_old + o, s->state->v + o, n);
  for (int k = rod->first_position; k < rod->first_position + rod->position_count; k++)
    memcpy(s->force_old + 3 * k, s->state->force + 3 * s->model->positions[k].slot, 3 * sizeof(double));
  for (int k = rod->first_frame; k < rod->first_frame + rod->frame_count; k++)
    s->torque_old[k] = s->state->frame_torque[k];
}

/* Back to where the step began. */
void hb_stepper_undo(hb_stepper *s, const hb_rod *rod) {
  size_t o = 3 * (size_t)rod->first, n = 3 * (size_t)rod->nv * sizeof(double);
  memcpy(s->state->x + o, s->x_old + o, n);
  memcpy(s->state->v + o, s->v_old + o, n);
}

/* v += kick M^-1 force. */
void hb_stepper_kick(hb_stepper *s, const hb_rod *rod, double h) {
  size_t from = 3 * (size_t)rod->first, to = from + 3 * (size_t)rod->nv;
  double *restrict v = s->state->v;
  const double *restrict f = s->state->force, *restrict w = s->model->inv_mass;
  for (size_t k = from; k < to; k++) v[k] += h * (w[k] * f[k]);
}

/* The same, then x += drift v. */
void hb_stepper_kick_drift(hb_stepper *s, const hb_rod *rod, double kick, double drift) {
  size_t from = 3 * (size_t)rod->first, to = from + 3 * (size_t)rod->nv;
  double *restrict v = s->state->v, *restrict x = s->state->x;
  const double *restrict f = s->state->force, *restrict w = s->model->inv_mass;
  for (size_t k = from; k < to; k++) {
    v[k] += kick * (w[k] * f[k]);
    x[k] += drift * v[k];
  }
}

/* Direction formulas to a unit vector and its rate. */
static void unit_direction(const hb_position_support *p, const double *vars, hb_v3 *unit, hb_v3 *rate) {
  double d[3], r[3];
  for (int c = 0; c < 3; c++) hb_formula_eval_dt(p->def->value[c], vars, &d[c], &r[c]);
  double inv = 1 / hb_v3_norm(hb_v3_load(d));
  *unit = hb_v3_scale(inv, hb_v3_load(d));
  hb_v3 turn = hb_v3_scale(inv, hb_v3_load(r));
  *rate = hb_v3_axpy(turn, -hb_v3_dot(turn, *unit), *unit);
}

/* Position and velocity that a support asks for. Coordinates that it leaves free are not touched. */
void hb_support_at(const hb_model *model, const hb_position_support *p, double t, const double base_x[3],
                   const double base_v[3], double x[3], double v[3]) {
  double vars[HB_VAR_COUNT] = {0};
  vars[HB_VAR_T] = t;
  if (p->tangent) {
    hb_v3 unit = hb_v3_load(p->initial), rate = {0, 0, 0};
    double reach = p->sign * model->rest_length[p->edge];
    for (int c = 0; c < 3; c++) vars[HB_VAR_X + c] = model->initial[3 * p->base + c];
    if (!p->def->held) unit_direction(p, vars, &unit, &rate);
    hb_v3_store(x, hb_v3_axpy(hb_v3_load(base_x), reach, unit));
    hb_v3_store(v, hb_v3_axpy(hb_v3_load(base_v), reach, rate));
    return;
  }
  for (int c = 0; c < 3; c++) vars[HB_VAR_X + c] = p->initial[c];
  for (int c = 0; c < 3; c++) {
    if (!p->fixed[c]) continue;
    if (p->def->value[c]) {
      hb_formula_eval_dt(p->def->value[c], vars, &x[c], &v[c]);
    } else {
      x[c] = p->initial[c];
      v[c] = 0;
    }
  }
}

/* All prescribed vertices of a rod. */
void hb_stepper_place(hb_stepper *s, const hb_rod *rod, double t, double h, bool exact) {
  for (int k = rod->first_position; k < rod->first_position + rod->position_count; k++) {
    const hb_position_support *p = &s->model->positions[k];
    double *x = s->state->x + 3 * p->slot, *v = s->state->v + 3 * p->slot, rate[3] = {0, 0, 0};
    const double *base = p->tangent ? s->state->x + 3 * p->base : x,
                 *base_v = s->state->v + 3 * (p->tangent ? p->base : p->slot);
    hb_support_at(s->model, p, t, base, base_v, x, rate);
    for (int c = 0; c < 3; c++)
      if (p->fixed[c]) v[c] = exact ? rate[c] : (x[c] - s->x_old[3 * p->slot + c]) / h;
  }
}

/* Directors for follower loads. */
static const double *follower_frames(hb_stepper *s, const hb_rod *rod) {
  if (!s->follower_m1) return NULL;
  if (!rod->closed_form) return s->state->m1;
  hb_frames_closed(s->model, rod, s->state, &s->rod_work);
  memcpy(s->follower_m1 + 3 * rod->first, s->rod_work.m1, 3 * (size_t)rod->nv * sizeof(double));
  return s->follower_m1;
}

/* Elastic force and loads, after the twist. */
void hb_stepper_forces(hb_stepper *s, const hb_rod *rod, double t, const double *v) {
  hb_state *state = s->state;
  hb_rod_force(s->model, rod, state, &s->rod_work);
  hb_stepper_end(s, HB_STAGE_ELASTIC);
  if (!s->active[rod->index]) return;
  size_t from = 3 * (size_t)rod->first, to = from + 3 * (size_t)rod->nv;
  const double *m1 = follower_frames(s, rod);
  memset(state->load + from, 0, (to - from) * sizeof(double));
  for (int k = 0; s->terms[k]; k++)
    if (s->active[rod->index] & (1u << k))
      s->terms[k]->add(s->model, rod, t, state->x, v, m1,
                       s->terms[k]->dissipative ? state->force : state->load);
  hb_rod_share_seam(rod, state->force);
  hb_rod_share_seam(rod, state->load);
  for (size_t k = from; k < to; k++) state->force[k] += state->load[k];
  hb_stepper_end(s, HB_STAGE_LOADS);
}

/* Everything at the new place; folds are counted. */
hb_status hb_stepper_evaluate(hb_stepper *s, const hb_rod *rod, double t, const double *v, double h,
                              hb_error *err) {
  hb_state *state = s->state;
  hb_stepper_begin(s);
  hb_status status = hb_rod_settle(s->model, rod, state, &s->rod_work, t, h, err);
  if (status) return status;
  hb_stepper_end(s, HB_STAGE_TWIST);
  hb_stepper_forces(s, rod, t, v);
  if (!(s->rod_work.lowest_chi > HB_FOLD_LIMIT)) {
    state->scalar[HB_S_FOLDS]++;
    state->scalar[HB_S_FOLD_SLOT] = rod->first + hb_rod_find_fold(rod, &s->rod_work);
  }
  return HB_OK;
}

/* Lengths. */
hb_status hb_stepper_project(hb_stepper *s, const hb_rod *rod, double h, bool at_old, hb_error *err) {
  hb_projection p;
  hb_status status =
      hb_project_positions(s->model, rod, s->state->x, s->state->v, h, at_old ? s->x_old : NULL,
                           s->state->lambda, &s->project_work, &p, err);
  s->state->scalar[HB_S_PROJECTIONS] += p.iterations;
  if (!status && p.error > s->length_error) s->length_error = p.error;
  return status;
}

/* Half of load . dx and, over the damped rods, the loss c m |dx|^2/h. */
void hb_stepper_book_work(hb_stepper *s, const hb_rod *rod, double h) {
  size_t from = 3 * (size_t)rod->first, to = from + 3 * (size_t)rod->nv;
  double c = s->model->def->rods[rod->index].mass_damping, work = 0, lost = 0;
  if (!s->active[rod->index]) return;
  for (size_t k = from; k < to; k++) work += s->state->load[k] * (s->state->x[k] - s->x_old[k]);
  s->state->scalar[HB_S_WORK_LOADS] += 0.5 * work;
  if (!(c > 0)) return;
  for (size_t k = from; k < to; k++) {
    double moved = s->state->x[k] - s->x_old[k];
    lost += s->model->mass[k / 3] * moved * moved;
  }
  s->state->scalar[HB_S_DISSIPATED] += 0.5 * c / h * lost;
}

/* Does the support move at all? */
bool hb_support_moves(const hb_model *m, const hb_position_support *p) {
  if (p->tangent) {
    const hb_position_support *base = p;
    while (base > m->positions && base->slot != p->base) base--; /* bases come first */
    return !p->def->held || base->slot != p->base || hb_support_moves(m, base);
  }
  for (int c = 0; c < 3; c++)
    if (p->def->value[c] && !hb_formula_is_constant(p->def->value[c])) return true;
  return false;
}

/* Force of the multipliers of the velocity projection (mu[0] belongs to the rod's first edge) on vertex slot
 * i, coordinate c, times h. */
static double velocity_pull(const hb_model *m, const hb_rod *rod, const double *mu, const double *x, int i,
                            int c) {
  double pull = 0;
  int j = i - rod->first, k = 3 * i + c;
  if (j > 0) pull -= mu[j - 1] * 2 * m->inv_rest_length[i - 1] * (x[k] - x[k - 3]);
  if (j + 1 < rod->nv) pull += mu[j] * 2 * m->inv_rest_length[i] * (x[k + 3] - x[k]);
  return pull;
}

/* The correction, times 1/h, is what the velocities have beyond the kick; projecting it gives its
 * multipliers. */
void hb_stepper_find_pull(hb_stepper *s, const hb_rod *rod, double h, double kick) {
  const hb_model *m = s->model;
  hb_project_work *w = &s->project_work;
  double *rest = s->v_predicted;
  bool any = false;
  for (int n = rod->first_position; n < rod->first_position + rod->position_count; n++)
    any = any || hb_support_moves(m, &m->positions[n]);
  if (!any) return; /* supports that stand still do no work */
  for (int k = 3 * rod->first; k < 3 * (rod->first + rod->nv); k++)
    rest[k] =
        m->inv_mass[k] == 0 ? 0 : s->state->v[k] - s->v_old[k] - kick * (m->inv_mass[k] * s->state->force[k]);
  hb_project_velocities(m, rod, s->state->x, rest, w);
  for (int n = rod->first_position; n < rod->first_position + rod->position_count; n++)
    for (int c = 0; c < 3; c++)
      w->support_pull[3 * n + c] = -h * velocity_pull(m, rod, w->right, s->state->x, m->positions[n].slot, c);
}

/* Momentum balance of a prescribed vertex over the step gives the support's mean force; times the way it
 * went. Frames work through their torque. */
void hb_stepper_book_supports(hb_stepper *s, const hb_rod *rod, double h, bool rattle) {
  hb_state *state = s->state;
  const hb_model *m = s->model;
  const hb_project_work *w = &s->project_work;
  double work = 0;
  for (int n = rod->first_position; n < rod->first_position + rod->position_count; n++) {
    const hb_position_support *p = &m->positions[n];
    if (!hb_support_moves(m, p)) continue;
    for (int c = 0; c < 3; c++) {
      int k = 3 * p->slot + c, i = p->slot;
      if (!p->fixed[c]) continue;
      double pull = w->support_pull[3 * n + c] / (h * h);
      if (rattle) pull += velocity_pull(m, rod, w->right, state->x, i, c) / h;
      double given = rattle ? 0.5 * (s->force_old[3 * n + c] + state->force[k]) : s->force_old[3 * n + c];
      double force = m->mass[i] * (state->v[k] - s->v_old[k]) / h - given - pull;
      work += force * (state->x[k] - s->x_old[k]);
    }
  }
  for (int k = rod->first_frame; k < rod->first_frame + rod->frame_count; k++)
    work += 0.5 * (s->torque_old[k] + state->frame_torque[k]) * s->rod_work.frame_turned[k];
  state->scalar[HB_S_WORK_SUPPORTS] += work;
}
