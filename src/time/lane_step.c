#include "time/lane_step.h"

#include "time/lane_frames.h"

#include <string.h>

/* What was at the start of the step becomes the old; the new is written over what was old before. */
static void turn_over(const hb_journey *j) {
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
static void place(const hb_journey *j, bool exact) {
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
      hb_unit_set3(j->u, n, i, AT(x), x);
      hb_unit_get3(j->u, n, i, AT(x), x); /* as it is in the lanes, where it may have been rounded */
      for (int c = 0; c < 3; c++) v[c] = exact ? rate[c] : (x[c] - old[c]) / j->h;
      hb_unit_set3(j->u, n, i, AT(v), v);
    }
  }
}

/* Forces on prescribed vertices and torques on frames at the start of the step, for the work of supports. */
static void keep_support_forces(const hb_journey *j) {
  hb_stepper *s = j->s;
  if (j->u->steady && !j->u->moving) return; /* they do no work */
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
static void edge_pull(const hb_journey *j, int n, int i, bool rates, size_t way, double out[3]) {
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
static void book_supports(const hb_journey *j) {
  hb_stepper *s = j->s;
  double work = 0;
  if (j->u->steady && !j->u->moving) return;
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
    for (int l = 0; l < hb_journey_lanes(u); l++)
      sum += hb_strip_get(&u->strips[g], u->strips[g].finite, 0, l) +
             (u->strips[g].split ? hb_strip_get(&u->strips[g], u->strips[g].rod_moment, 0, l) : 0);
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
static hb_status step_rods(const hb_journey *j, hb_rod_step step_rod, hb_error *err) {
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
static void begin(const hb_journey *j) {
  memset(j->u->tally, 0, HB_S_COUNT * sizeof *j->u->tally);
  j->u->length_error = 0;
  hb_stepper_begin(j->s);
  j->u->steady = hb_journey_is_steady(j);
  keep_support_forces(j);
  turn_over(j);
}

/* Symplectic Euler with fast projection. */
hb_status hb_lane_step_euler(hb_stepper *s, hb_unit *u, double t, double h, hb_rod_step step_rod,
                             hb_error *err) {
  hb_journey j = {s, u, u->kernels, t, h, false};
  begin(&j);
  hb_journey_pass(&j, ADVANCE);
  if (u->fresh) place(&j, false); /* none of them moves (time/rods.c) */
  hb_stepper_end(s, HB_STAGE_MOVE);
  if (hb_journey_fit(&j) == IRREGULAR) return step_rods(&j, step_rod, err);
  hb_stepper_end(s, HB_STAGE_PROJECT);
  hb_status status = hb_journey_evaluate(&j, err);
  if (status) return status;
  if (u->fresh > 0) u->fresh--;
  book_supports(&j);
  if (u->loaded) hb_journey_pass(&j, SUM_UP); /* else elastic forces tell of all */
  u->finite = is_finite(u);
  return HB_OK;
}

/* Constrained velocity Verlet (SHAKE and RATTLE). */
hb_status hb_lane_step_verlet(hb_stepper *s, hb_unit *u, double t, double h, hb_rod_step step_rod,
                              hb_error *err) {
  hb_journey j = {s, u, u->kernels, t, h, true};
  begin(&j);
  hb_journey_pass(&j, ADVANCE);
  place(&j, false);
  hb_stepper_end(s, HB_STAGE_MOVE);
  if (hb_journey_fit(&j) == IRREGULAR) return step_rods(&j, step_rod, err);
  hb_stepper_end(s, HB_STAGE_PROJECT);
  hb_status status = hb_journey_evaluate(&j, err);
  if (status) return status;
  hb_stepper_begin(s);
  place(&j, true);
  (void)hb_journey_solve(&j, true);
  hb_journey_pass(&j, SPREAD_RATES);
  for (int g = 0; g < u->strip_count; g++) j.k->join_spread(&u->strips[g], false);
  hb_stepper_end(s, HB_STAGE_PROJECT);
  if (u->fresh > 0) u->fresh--;
  book_supports(&j);
  u->finite = is_finite(u);
  return HB_OK;
}
