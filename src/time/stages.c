/* One piece of an implicit step: its stages, the velocities and accelerations between them, what they did
 * (docs/theory, 13.1, 13.2, 13.5).
 *
 * TR-BDF2 (Bank et al. 1985; Hosea and Shampine 1996) goes to the middle, at 2 - sqrt(2) of the piece, by the
 * trapezoidal rule and from there to the end by a backward difference over both; backward Euler has one
 * stage. */
#include "time/implicit.h"

#include "math/vec3.h"

#include <string.h>

/* Of the piece: ch of both stages, where the middle is, the weight of start and middle at the end. */
#define ROOT 1.4142135623730951
#define PART (1 - 0.5 * ROOT)
#define MIDDLE (2 - ROOT)
#define WEIGHT (0.25 * ROOT)
/* A first guess turns no edge further. */
#define LONGEST_GUESS 0.5
/* Accelerations of supports are differences of their velocities over this part of the piece. */
#define GLANCE 1e-3

/* A piece under way. */
typedef struct piece {
  hb_marcher *w;
  const hb_rod *rod;
  double from, h;
} piece;

/* What all functions begin with. */
static inline hb_implicit *shared(const piece *p) { return p->w->stepper.implicit; }

/* Accelerations of prescribed coordinates around time t. */
static void find_given(const piece *p, double t) {
  const hb_model *m = p->w->stepper.model;
  const hb_state *state = p->w->stepper.state;
  double d = GLANCE * p->h, before = t > d ? t - d : 0, inv = 1 / (t + d - before), x[3] = {0, 0, 0};
  double *after = shared(p)->given, *past = p->w->stepper.v_predicted;
  for (int n = p->rod->first_position; n < p->rod->first_position + p->rod->position_count; n++) {
    const hb_position_support *s = &m->positions[n];
    int base = 3 * (s->tangent ? s->base : s->slot), own = 3 * s->slot;
    for (int c = 0; c < 3; c++) after[own + c] = past[own + c] = 0;
    hb_support_at(m, s, t + d, state->x + base, after + base, x, after + own);
    hb_support_at(m, s, before, state->x + base, past + base, x, past + own);
  }
  for (int n = p->rod->first_position; n < p->rod->first_position + p->rod->position_count; n++)
    for (int k = 3 * m->positions[n].slot; k < 3 * m->positions[n].slot + 3; k++)
      after[k] = inv * (after[k] - past[k]);
}

/* Forces and the pull of the edges together; of a closed rod half of it to each slot of the vertex where its
 * ends meet, as they have half of its mass. lambda: per edge. */
static void balance_forces(const piece *p, const double *lambda) {
  const hb_stepper *s = &p->w->stepper;
  const hb_state *state = s->state;
  hb_v3 before = {0, 0, 0};
  for (int i = 0; i < p->rod->nv; i++) {
    int k = p->rod->first + i;
    hb_v3 pull = {0, 0, 0};
    if (i + 1 < p->rod->nv)
      pull = hb_v3_scale(2 * lambda[i] * s->model->inv_rest_length[k],
                         hb_v3_sub(hb_v3_load(state->x + 3 * k + 3), hb_v3_load(state->x + 3 * k)));
    hb_v3_store(s->implicit->balance + 3 * k,
                hb_v3_add(hb_v3_load(state->force + 3 * k), hb_v3_sub(pull, before)));
    before = pull;
  }
  hb_rod_share_seam(p->rod, s->implicit->balance);
}

/* The state as an instant: the multipliers that keep the lengths' second derivatives, accelerations with
 * them, and what supports must give then (9.1). */
static void find_instant(const piece *p, double t, hb_instant *out) {
  hb_stepper *s = &p->w->stepper;
  hb_implicit *im = s->implicit;
  const hb_model *m = s->model;
  const hb_state *state = s->state;
  size_t o = (size_t)p->rod->first, n = 3 * (size_t)p->rod->nv;
  double *lambda = im->lambda + o;
  find_given(p, t);
  hb_project_tension(m, p->rod, state->x, state->v, state->force, im->given, lambda, &s->project_work);
  memcpy(out->x + 3 * o, state->x + 3 * o, n * sizeof(double));
  memcpy(out->v + 3 * o, state->v + 3 * o, n * sizeof(double));
  balance_forces(p, lambda);
  for (size_t k = 3 * o; k < 3 * o + n; k++)
    out->a[k] = m->inv_mass[k] == 0 ? im->given[k] : m->inv_mass[k] * im->balance[k];
  for (int q = p->rod->first_position; q < p->rod->first_position + p->rod->position_count; q++)
    for (int c = 0; c < 3; c++) {
      int k = 3 * m->positions[q].slot + c;
      im->reaction[3 * q + c] = m->inv_mass[k] == 0 ? m->mass[k / 3] * out->a[k] - im->balance[k] : 0;
    }
}

/* Leaves prescribed vertices where they are at time t, with their exact velocities. */
static void place(const piece *p, double t) { hb_stepper_place(&p->w->stepper, p->rod, t, p->h, true); }

/* The guess x = from + d v + d^2/2 a + d^3/6 (a - past)/between, shortened where it would turn edges too far;
 * past NULL: without the last term. */
static void guess(const piece *p, const hb_instant *from, const double *past, double between, double d) {
  hb_stepper *s = &p->w->stepper;
  hb_implicit *im = s->implicit;
  int o = 3 * p->rod->first, n = 3 * p->rod->nv;
  double turn = 0, third = past ? d / (3 * between) : 0;
  for (int k = o; k < o + n; k++) {
    double a = from->a[k];
    if (past) a += third * (a - past[k]);
    im->now[k] = d * (from->v[k] + 0.5 * d * a);
  }
  for (int k = o; k + 3 < o + n; k += 3) {
    hb_v3 change = hb_v3_sub(hb_v3_load(im->now + k + 3), hb_v3_load(im->now + k));
    turn = fmax(turn, hb_v3_norm(change) * s->model->inv_rest_length[k / 3]);
  }
  double part = turn > LONGEST_GUESS ? LONGEST_GUESS / turn : 1;
  if (!isfinite(turn)) part = 0;
  for (int k = o; k < o + n; k++) s->state->x[k] = from->x[k] + (part > 0 ? part * im->now[k] : 0);
}

/* Viscosity's target: the material curvatures that the stage would end with at no rate, rates weighed like
 * velocities. */
static void set_targets(const piece *p, double of_start, double of_middle) {
  const hb_model *m = p->w->stepper.model;
  hb_state *state = p->w->stepper.state;
  const hb_implicit *im = shared(p);
  if (!m->def->rods[p->rod->index].viscosity) return;
  for (int k = 4 * p->rod->first; k < 4 * (p->rod->first + p->rod->nv); k++) {
    double target = im->omega_start[k] + of_start * im->rate_start[k];
    if (of_middle != 0) target += of_middle * im->rate_middle[k];
    state->omega_1[k] = state->omega_2[k] = target;
  }
}

/* Rates of material curvature at the end of the stage, and what viscosity took over it, from the mean rate.
 * The state's omega_1 is still the target. */
static void find_rates(const piece *p, const hb_stage_now *stage, double *rate) {
  hb_stepper *s = &p->w->stepper;
  hb_implicit *im = s->implicit;
  const hb_model *m = s->model;
  double lost = 0, inv = 1 / stage->ch;
  for (int i = 1; i <= p->rod->last_joint; i++) {
    int k = p->rod->first + i;
    for (int c = 0; c < 4; c++) {
      double now = s->rod_work.omega[4 * i + c], change = now - im->omega_now[4 * k + c];
      rate[4 * k + c] = inv * (now - s->state->omega_1[4 * k + c]);
      lost += m->viscosity[k - 1 + c / 2] * change * change / (m->voronoi[k] * stage->duration);
      im->omega_now[4 * k + c] = now;
    }
  }
  s->state->scalar[HB_S_DISSIPATED] += lost;
}

/* Work of loads, damping and supports over the stage by the trapezoidal rule; old: where it began. */
static void book(const piece *p, const hb_stage_now *stage, const double *old) {
  hb_stepper *s = &p->w->stepper;
  const hb_implicit *im = s->implicit;
  const hb_model *m = s->model;
  const hb_rod *rod = p->rod;
  double work = 0, lost = 0, given = 0, c = m->def->rods[rod->index].mass_damping;
  for (int k = 3 * rod->first; s->active[rod->index] && k < 3 * (rod->first + rod->nv); k++) {
    double moved = s->state->x[k] - old[k];
    work += 0.5 * (im->load_old[k] + s->state->load[k]) * moved;
    lost += m->mass[k / 3] * moved * moved;
  }
  for (int q = 3 * rod->first_position; q < 3 * (rod->first_position + rod->position_count); q++) {
    int k = 3 * m->positions[q / 3].slot + q % 3;
    given += 0.5 * (im->reaction_old[q] + im->reaction[q]) * (s->state->x[k] - old[k]);
  }
  for (int k = rod->first_frame; k < rod->first_frame + rod->frame_count; k++)
    given += 0.5 * (im->torque_old[k] + s->state->frame_torque[k]) * s->rod_work.frame_turned[k];
  s->state->scalar[HB_S_WORK_LOADS] += work;
  s->state->scalar[HB_S_WORK_SUPPORTS] += given;
  s->state->scalar[HB_S_DISSIPATED] += c * lost / stage->duration;
}

/* What is known where a stage begins is kept: loads, reactions, torques, and the state itself. */
static void begin_stage(const piece *p) {
  hb_stepper *s = &p->w->stepper;
  hb_implicit *im = s->implicit;
  const hb_rod *rod = p->rod;
  int q = rod->first_position, k = rod->first_frame;
  memcpy(im->load_old + 3 * rod->first, s->state->load + 3 * rod->first,
         3 * (size_t)rod->nv * sizeof(double));
  memcpy(im->reaction_old + 3 * q, im->reaction + 3 * q, 3 * (size_t)rod->position_count * sizeof(double));
  memcpy(im->torque_old + k, s->state->frame_torque + k, (size_t)rod->frame_count * sizeof(double));
  hb_state_copy_rod(s->model, rod, im->kept, s->state);
}

/* From the guess in the state to the end of the stage: position, velocity along the lengths, acceleration;
 * books. old: where it began; rate: of material curvature, at the end. */
static bool finish_stage(const piece *p, const hb_stage_now *stage, const hb_instant *old, double *rate,
                         hb_instant *out) {
  hb_stepper *s = &p->w->stepper;
  hb_implicit *im = s->implicit;
  const hb_rod *rod = p->rod;
  int from = 3 * rod->first, to = from + 3 * rod->nv;
  place(p, stage->t);
  for (int k = from; k < to; k++) im->now[k] = s->state->x[k] - im->start.x[k];
  if (!hb_march_solve(p->w, rod, stage)) return false;
  hb_stepper_begin(s);
  double inv = 1 / stage->ch;
  for (int k = from; k < to; k++) s->state->v[k] = inv * (im->moved[k] - im->reach[k]);
  place(p, stage->t);
  hb_project_velocities(s->model, rod, s->state->x, s->state->v, &s->project_work);
  if (s->rates[rod->index]) hb_stepper_forces(s, rod, stage->t, s->state->v);
  if (s->model->def->rods[rod->index].viscosity) find_rates(p, stage, rate);
  find_instant(p, stage->t, out);
  book(p, stage, old->x);
  hb_stepper_end(s, HB_STAGE_MOVE);
  return true;
}

/* Rates of material curvature where the piece begins: the state has it as the curvatures one time step
 * before, had the rates been the same. */
static void begin_viscosity(const piece *p) {
  const hb_model *m = p->w->stepper.model;
  const hb_state *state = p->w->stepper.state;
  hb_implicit *im = shared(p);
  double inv = 1 / m->def->method.time_step;
  if (!m->def->rods[p->rod->index].viscosity) return;
  for (int k = 4 * p->rod->first; k < 4 * (p->rod->first + p->rod->nv); k++) {
    im->omega_start[k] = im->omega_now[k] = state->omega_1[k];
    im->rate_start[k] = inv * (state->omega_1[k] - state->omega_2[k]);
  }
}

/* The same, written down. */
static void end_viscosity(const piece *p, const double *rate) {
  const hb_model *m = p->w->stepper.model;
  hb_state *state = p->w->stepper.state;
  const hb_implicit *im = shared(p);
  if (!m->def->rods[p->rod->index].viscosity) return;
  for (int k = 4 * p->rod->first; k < 4 * (p->rod->first + p->rod->nv); k++) {
    state->omega_1[k] = im->omega_now[k];
    state->omega_2[k] = im->omega_now[k] - m->def->method.time_step * rate[k];
  }
}

/* Displacement = reach + ch v, v = speed + ch a: what is known of both, from the start and, in the second
 * stage, the middle. */
static void set_known(const piece *p, double of_start, double of_middle) {
  hb_implicit *im = shared(p);
  const hb_instant *a = &im->start, *b = &im->middle;
  for (int k = 3 * p->rod->first; k < 3 * (p->rod->first + p->rod->nv); k++) {
    im->reach[k] = of_start * a->v[k] + (of_middle != 0 ? of_middle * b->v[k] : 0);
    im->speed[k] = a->v[k] + of_start * a->a[k] + (of_middle != 0 ? of_middle * b->a[k] : 0);
  }
}

/* The largest displacement that the weighted velocities amount to over the piece, smoothed by the last
 * stage's factors: what is too fast for the step is not taken for an error (13.6). */
static double estimate(const piece *p, const hb_stage_now *last, double of_start, double of_middle,
                       double of_end) {
  hb_marcher *w = p->w;
  const hb_model *m = w->stepper.model;
  const hb_implicit *im = shared(p);
  int stride = w->kkt.stride;
  double inertia = 1 / (last->ch * last->ch), worst = 0;
  double *right = w->kkt.right;
  if (!(m->def->method.error_tolerance > 0)) return 0;
  memset(right, 0, (size_t)w->kkt.matrix.n * sizeof *right);
  for (int i = 0; i < p->rod->nv; i++)
    for (int c = 0; c < 3; c++) {
      int k = 3 * (p->rod->first + i) + c;
      double sum = of_start * im->start.v[k] + of_end * im->end.v[k];
      if (of_middle != 0) sum += of_middle * im->middle.v[k];
      if (w->kkt.weight[stride * i + c] != 0) right[stride * i + c] = inertia * m->mass[k / 3] * p->h * sum;
    }
  hb_kkt_solve(&w->kkt);
  for (int i = 0; i < p->rod->nv; i++) worst = fmax(worst, hb_v3_norm(hb_v3_load(right + stride * i)));
  return worst / p->rod->length;
}

/* Both stages of TR-BDF2. */
static bool take_two(const piece *p, double *error) {
  hb_implicit *im = shared(p);
  double h = p->h, middle = MIDDLE * h;
  const hb_stage_now first = {p->from + middle, PART * h, middle},
                     second = {p->from + h, PART * h, h - middle};
  set_known(p, PART * h, 0);
  set_targets(p, PART * h, 0);
  begin_stage(p);
  guess(p, &im->start, NULL, 1, middle);
  if (!finish_stage(p, &first, &im->start, im->rate_middle, &im->middle)) return false;
  set_known(p, WEIGHT * h, WEIGHT * h);
  set_targets(p, WEIGHT * h, WEIGHT * h);
  begin_stage(p);
  guess(p, &im->middle, im->start.a, middle, h - middle);
  if (!finish_stage(p, &second, &im->middle, im->rate_end, &im->end)) return false;
  *error = estimate(p, &second, (ROOT - 1) / 3, -1.0 / 3, (2 - ROOT) / 3);
  return true;
}

/* The one stage of backward Euler. */
static bool take_one(const piece *p, double *error) {
  hb_implicit *im = shared(p);
  const hb_stage_now only = {p->from + p->h, p->h, p->h};
  set_known(p, 0, 0);
  set_targets(p, 0, 0);
  begin_stage(p);
  guess(p, &im->start, NULL, 1, p->h);
  if (!finish_stage(p, &only, &im->start, im->rate_end, &im->end)) return false;
  *error = estimate(p, &only, -0.5, 0, 0.5);
  return true;
}

/* A piece; the state is put back if it fails. */
bool hb_march_piece(hb_marcher *w, const hb_rod *rod, double from, double to, double *error) {
  hb_stepper *s = &w->stepper;
  hb_implicit *im = s->implicit;
  const piece p = {w, rod, from, to - from};
  hb_state_copy_rod(s->model, rod, im->begin, s->state);
  find_instant(&p, from, &im->start);
  begin_viscosity(&p);
  if (im->second_order ? take_two(&p, error) : take_one(&p, error)) {
    end_viscosity(&p, im->rate_end);
    return true;
  }
  hb_state_copy_rod(s->model, rod, s->state, im->begin);
  return false;
}
