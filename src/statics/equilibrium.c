/* Newton's method on the shapes of the right lengths, made to go downhill (docs/theory, 11.5). */
#include "statics/equilibrium.h"

#include "force/force.h"
#include "math/vec3.h"
#include "model/compile.h"

#include <float.h>
#include <stdio.h>
#include <string.h>

/* No edge turns further than this in one iteration: beyond, the second derivatives say little. */
#define LONGEST_TURN 0.8
/* Edges that are springs get longer by the square of their turn, and nothing restores their lengths. */
#define LONGEST_SPRING_TURN 0.3
/* Supports are moved so far at a time that no edge turns further than this. */
#define LONGEST_CARRY 0.3
/* A step must lower the energy by at least this part of what its slope promises. */
#define ARMIJO 1e-4
#define SMALLEST_PART 1e-9
/* Stiffnesses below this part of (bending stiffness)/length^4 count as 0, or below the round-off of the
 * matrix. */
#define SOFT 1e-8
/* Iterations between two moves of the supports. */
#define RELAXATIONS 8

/* One iteration's findings. */
typedef struct look {
  double slope; /* work of the unbalanced forces along the whole step, >= 0 where the step goes down */
  double turn, longest;
  double residual, scale; /* largest unbalanced force, and what it is compared with */
  double shift;           /* stiffness that had to be added */
  bool fitted;            /* do the multipliers of the step fit better here than those before? */
} look;

/* What forces, stiffnesses and round-off of this rod are compared with. */
void hb_statics_find_scales(hb_statics *s, const hb_rod *rod) {
  const hb_model *m = s->model;
  double B = 0, load = 0, stretching = 0, shortest = rod->length, length = rod->length;
  for (int k = rod->first; k + 1 < rod->first + rod->nv; k++) {
    B = fmax(B, fmax(m->B[3 * k], m->B[3 * k + 2]));
    stretching = fmax(stretching, m->stretching[k]);
    shortest = fmin(shortest, m->rest_length[k]);
  }
  for (int k = rod->first; k < rod->first + rod->nv; k++)
    load += hb_v3_norm(hb_v3_load(s->state->load + 3 * k));
  s->unit = fmax(B / (length * length), load);
  double stiffness = s->unit / (length * length), ratio = length / shortest;
  double round_off =
      16 * DBL_EPSILON * (B * ratio * ratio / (length * length) + stretching + s->unit) * ratio * ratio;
  s->floor = SOFT * stiffness;
  s->softest = fmax(s->floor, round_off / (length * length));
}

/* Multipliers that fit the forces best: those with which the rod would start to move. */
static void guess_multipliers(hb_statics *s, const hb_rod *rod) {
  hb_project_tension(s->model, rod, s->state->x, s->none, s->state->force, s->none,
                     s->multiplier + rod->first, &s->project_work);
}

/* The pull of edge j on its first vertex. */
static hb_v3 pull_of(const hb_statics *s, const hb_rod *rod, const double *multiplier, int j) {
  const double *x = s->state->x + 3 * (size_t)(rod->first + j);
  return hb_v3_scale(2 * multiplier[j] * s->model->inv_rest_length[rod->first + j],
                     hb_v3_sub(hb_v3_load(x + 3), hb_v3_load(x)));
}

/* Largest force on a free coordinate that neither loads, elasticity nor lengths balance. */
double hb_statics_unbalanced(const hb_statics *s, const hb_rod *rod, const double *multiplier) {
  const hb_model *m = s->model;
  double most = 0;
  int last = rod->first + rod->nv - 1;
  hb_v3 before = {0, 0, 0};
  if (rod->closed) before = pull_of(s, rod, multiplier, rod->nv - 2);
  for (int i = 0; i + rod->closed < rod->nv; i++) {
    int k = rod->first + i;
    hb_v3 pull = {0, 0, 0}, force_on = hb_v3_load(s->state->force + 3 * k);
    if (i + 1 < rod->nv) pull = pull_of(s, rod, multiplier, i);
    if (rod->closed && i == 0) force_on = hb_v3_add(force_on, hb_v3_load(s->state->force + 3 * last));
    hb_v3 rest = hb_v3_add(force_on, hb_v3_sub(pull, before));
    const double *force = &rest.x;
    for (int c = 0; c < 3; c++)
      if (m->inv_mass[3 * k + c] != 0) most = fmax(most, fabs(force[c]));
    before = pull;
  }
  return most;
}

/* Largest tension, by the multipliers or by the strains. */
double hb_statics_largest_tension(const hb_statics *s, const hb_rod *rod, const double *multiplier) {
  const hb_model *m = s->model;
  double most = 0;
  for (int j = 0; j + 1 < rod->nv; j++) {
    double strain = rod->extensible ? hb_stretch_strain(m, rod->first + j, s->rod_work.inv_length[j]) : 0;
    most = fmax(most, 2 * fabs(multiplier[j]) + fabs(m->stretching[rod->first + j] * strain));
  }
  return most;
}

/* Fills s->direction with the Newton step from here, turns and new multipliers with it. The right-hand side
 * is what assembly left there plus the forces. */
static void solve_step(hb_statics *s, const hb_rod *rod, look *now) {
  double *right = s->kkt.right;
  for (int i = 0; i < rod->nv; i++)
    for (int c = 0; c < 3; c++)
      if (s->kkt.weight[HB_KKT_STRIDE * i + c] != 0)
        right[HB_KKT_STRIDE * i + c] += s->state->force[3 * (rod->first + i) + c];
  hb_kkt_solve(&s->kkt);
  memcpy(s->direction, right, (size_t)(HB_KKT_STRIDE * rod->nv) * sizeof *right);
  now->turn = hb_statics_turn(s, rod, &now->longest);
  now->slope = 0;
  for (int i = 0; i < rod->nv; i++)
    now->slope += hb_v3_dot(hb_v3_load(s->direction + HB_KKT_STRIDE * i),
                            hb_v3_load(s->state->force + 3 * (rod->first + i)));
  for (int j = 0; j + 1 < rod->nv; j++) /* what brings the lengths right is no descent */
    now->slope += s->direction[HB_KKT_STRIDE * (j + 1) + HB_KKT_MULTIPLIER] * s->kkt.length[j];
}

/* Multipliers of the step, which belong to where it leads; copied into `out`. */
static void new_multipliers(const hb_statics *s, const hb_rod *rod, double *out) {
  for (int j = 0; j + 1 < rod->nv; j++) out[j] = s->direction[HB_KKT_STRIDE * (j + 1) + HB_KKT_MULTIPLIER];
}

/* Places of the supports at time t as displacements of the rod, in s->moved; the state is left as it is.
 * Returns the longest. */
static double displacements(hb_statics *s, const hb_rod *rod, double t) {
  double longest = 0;
  size_t size = 3 * (size_t)rod->nv * sizeof(double);
  double *x = s->state->x + 3 * (size_t)rod->first;
  memcpy(s->scratch, x, size);
  s->place(s->context, rod, t);
  for (int k = 0; k < 3 * rod->nv; k++) {
    s->moved[k] = x[k] - s->scratch[k];
    longest = fmax(longest, fabs(s->moved[k]));
  }
  memcpy(x, s->scratch, size);
  return longest;
}

/* Displacement of the whole rod that goes with that of its supports, with as little change of energy as
 * possible. */
static hb_status follow_supports(hb_statics *s, const hb_rod *rod, double t, hb_equilibrium *result,
                                 hb_error *err) {
  hb_kkt *kkt = &s->kkt;
  hb_kkt_assemble(kkt, s->model, rod, s->state, &s->rod_work, t, s->multiplier + rod->first, s->moved);
  if (hb_statics_factor(s, rod, s->unit / (rod->length * rod->length), false, result) < 0)
    return hb_fail(err, HB_ERR_NUMERIC, "rod %s: the rod leaves its supports no room to move", rod->name);
  for (int k = 0; k < kkt->matrix.n; k++) {
    bool multiplier = k % HB_KKT_STRIDE == HB_KKT_MULTIPLIER && k >= HB_KKT_STRIDE;
    kkt->right[k] = multiplier || kkt->weight[k] != 0 ? kkt->right[k] - kkt->pull[k] : 0;
  }
  hb_kkt_solve(kkt);
  for (int k = 0; k < kkt->matrix.n; k++) s->direction[k] = kkt->right[k];
  for (int i = 0; i < rod->nv; i++)
    for (int c = 0; c < 3; c++)
      if (kkt->weight[HB_KKT_STRIDE * i + c] == 0) s->direction[HB_KKT_STRIDE * i + c] = s->moved[3 * i + c];
  return HB_OK;
}

/* A rod that nothing holds has an equilibrium only if its loads add up to nothing. */
static hb_status check_held(hb_statics *s, const hb_rod *rod, hb_error *err) {
  hb_v3 sum = {0, 0, 0};
  double size = 0;
  for (int k = rod->first; k < rod->first + rod->nv; k++) {
    hb_v3 load = hb_v3_load(s->state->load + 3 * k);
    sum = hb_v3_add(sum, load);
    size += hb_v3_norm(load);
  }
  if (rod->position_count > 0 || hb_v3_norm(sum) <= 1e-12 * size) return HB_OK;
  return hb_fail(
      err, HB_ERR_INPUT,
      "rod %s: no support holds a vertex against the loads, which add up to (%.4g, %.4g, %.4g): there is no "
      "equilibrium",
      rod->name, sum.x, sum.y, sum.z);
}

/* Goes along s->direction as far as the energy falls enough. False: it does not fall beyond round-off. */
static bool descend(hb_statics *s, const hb_rod *rod, double t, const look *now) {
  double change, before = s->energy;
  hb_statics_keep(s, rod);
  double longest = rod->extensible ? LONGEST_SPRING_TURN : LONGEST_TURN;
  for (double part = fmin(1, longest / now->turn); part > SMALLEST_PART; part *= 0.5) {
    bool there = hb_statics_try(s, rod, t, part, &change);
    double noise = (32 + rod->nv) * DBL_EPSILON * s->magnitude;
    if (there && change <= -ARMIJO * part * now->slope + noise) return true;
    hb_statics_undo(s, rod);
    s->energy = before;
  }
  (void)hb_statics_evaluate(s, rod, t, NULL);
  return false;
}

/* One look at the forces where the rod is: the Newton step, new multipliers, and what does not balance. */
static hb_status look_around(hb_statics *s, const hb_rod *rod, double t, bool any, look *now,
                             hb_equilibrium *result, hb_error *err) {
  double *multiplier = s->multiplier + rod->first, turn_before = now->turn;
  for (;;) {
    hb_kkt_assemble(&s->kkt, s->model, rod, s->state, &s->rod_work, t, multiplier, NULL);
    now->shift = hb_statics_factor(s, rod, fmax(s->floor, now->shift / 64), any, result);
    if (now->shift < 0)
      return hb_fail(err, HB_ERR_NUMERIC, "rod %s: the lengths cannot be kept: its supports leave it no room",
                     rod->name);
    solve_step(s, rod, now);
    /* what was predicted for this place, or what fits it now: whichever fits better tells how far off it is
     */
    new_multipliers(s, rod, s->scratch);
    double expected = hb_statics_unbalanced(s, rod, multiplier),
           fitted = hb_statics_unbalanced(s, rod, s->scratch);
    now->residual = fmin(expected, fitted);
    now->fitted = fitted < expected;
    now->scale = fmax(s->unit, hb_statics_largest_tension(s, rod, multiplier));
    /* next to equilibrium a long step is round-off along a mode without stiffness */
    if (now->residual > 1e-3 * now->scale || now->turn < 10 * turn_before || s->floor >= s->softest)
      return HB_OK;
    s->floor = s->softest;
  }
}

/* Without asking for the energy: to the next equilibrium, whatever it is. */
static hb_status go_anyhow(hb_statics *s, const hb_rod *rod, double t, const look *now, hb_error *err) {
  double change, part = fmin(1, 0.25 * LONGEST_TURN / now->turn), before = s->energy;
  hb_statics_keep(s, rod);
  for (; !hb_statics_try(s, rod, t, part, &change); part *= 0.5) {
    hb_statics_undo(s, rod);
    s->energy = before;
    if (part < SMALLEST_PART)
      return hb_fail(err, HB_ERR_NUMERIC, "rod %s: the lengths cannot be kept", rod->name);
  }
  return HB_OK;
}

/* Books an equilibrium. */
static void book(const hb_statics *s, const look *now, int unstable, int neutral, hb_equilibrium *result) {
  result->unstable += unstable;
  result->neutral += neutral;
  result->resolution = fmax(result->resolution, s->resolution);
  result->residual = fmax(result->residual, now->residual);
  result->force_scale = fmax(result->force_scale, now->scale);
  result->last_step = fmax(result->last_step, now->longest);
  result->elastic += s->energy;
}

/* A sentence for a search that did not end. Frames that are held on edges which may turn are the usual
 * reason. */
static hb_status not_found(const hb_statics *s, const hb_rod *rod, const look *now, int iterations,
                           double tolerance, hb_error *err) {
  int edge = -1;
  for (int k = rod->first_frame; k < rod->first_frame + rod->frame_count; k++) {
    const double *mass = s->model->inv_mass + 3 * (size_t)s->model->frames[k].slot;
    for (int c = 0; c < 6; c++)
      if (mass[c] != 0) edge = s->model->frames[k].slot - rod->first;
  }
  char hint[256] = "";
  if (edge >= 0)
    snprintf(
        hint, sizeof hint,
        "; the material frame of edge %d is held, but the edge may turn: the torque of such a support has no "
        "potential, and statics needs one (clamp: true holds both)",
        edge);
  return hb_fail(
      err, HB_ERR_NUMERIC,
      "rod %s: no equilibrium in %d iterations: the largest unbalanced force is %.3g (allowed: %.3g), and "
      "the next step would turn an edge by %.3g%s",
      rod->name, iterations, now->residual, tolerance * now->scale, now->turn, hint);
}

/* Newton until the forces balance, at fixed supports and time; at most `limit` iterations. Where `strict` is
 * not set it may end before that without having found anything. */
static hb_status balance(hb_statics *s, const hb_rod *rod, double t, const hb_equilibrium_options *options,
                         int limit, bool strict, hb_equilibrium *result, hb_error *err) {
  double previous = HUGE_VAL;
  look now = {.turn = HUGE_VAL, .shift = 0};
  for (int iteration = 0;; iteration++) {
    hb_status status = look_around(s, rod, t, options->any, &now, result, err);
    if (status) return status;
    double noise = (32 + rod->nv) * DBL_EPSILON * s->magnitude;
    double allowed = options->tolerance * now.scale; /* forces far below it turn only what has no stiffness */
    bool done = now.residual <= allowed && now.turn <= (now.residual <= 1e-2 * allowed ? 1e-3 : 1e-5);
    /* at the bottom round-off decides */
    bool stalled = now.turn < 1e-4 && fabs(now.slope) <= noise && now.residual >= 0.25 * previous;
    if (done || stalled) {
      int unstable, neutral;
      if (!strict) return HB_OK;
      hb_statics_count_modes(s, rod, now.residual, result, &unstable, &neutral);
      if (unstable == 0 || options->any) {
        if (now.fitted) new_multipliers(s, rod, s->multiplier + rod->first);
        book(s, &now, unstable, neutral, result);
        return HB_OK;
      }
      if (!hb_statics_escape(s, rod, t, result))
        return hb_fail(err, HB_ERR_NUMERIC,
                       "rod %s: an equilibrium with %d unstable modes was found, but no way down from it",
                       rod->name, unstable);
      previous = HUGE_VAL;
      continue;
    }
    if (iteration >= limit)
      return strict ? not_found(s, rod, &now, iteration, options->tolerance, err) : HB_OK;
    new_multipliers(s, rod, s->multiplier + rod->first);
    result->iterations++;
    previous = now.residual;
    if (options->any)
      status = go_anyhow(s, rod, t, &now, err);
    else if (!descend(s, rod, t, &now) && now.turn >= 1e-4)
      return strict ? not_found(s, rod, &now, iteration, options->tolerance, err) : HB_OK;
    if (status) return status;
  }
}

/* Moves the supports to where they are at time t, the rod with them, if no edge turns too far by it; *good
 * tells. */
static hb_status carry_once(hb_statics *s, const hb_rod *rod, double now, double t, bool *good,
                            hb_equilibrium *result, hb_error *err) {
  double longest, change;
  hb_status status = follow_supports(s, rod, now, result, err);
  if (status) return status;
  double turn = hb_statics_turn(s, rod, &longest);
  hb_statics_keep(s, rod);
  *good = turn <= LONGEST_CARRY && hb_statics_try(s, rod, t, 1, &change);
  if (*good) return HB_OK;
  hb_statics_undo(s, rod);
  return hb_statics_evaluate(s, rod, now, err);
}

/* Carries the supports to where they are at time t, in as many moves as it takes. Where it takes several the
 * rod is let go downhill a little after each: it then follows its equilibria, and snaps where they end. */
static hb_status carry_supports(hb_statics *s, const hb_rod *rod, double from, double t,
                                const hb_equilibrium_options *options, hb_equilibrium *result,
                                hb_error *err) {
  double now = from, stride = t - from;
  hb_status status = HB_OK;
  while (!status && now < t) {
    double next = now + stride < t ? now + stride : t;
    bool good = displacements(s, rod, next) == 0;
    if (!good) status = carry_once(s, rod, now, next, &good, result, err);
    if (status) break;
    if (!good) {
      stride *= 0.5;
      if (stride < 1e-9 * (t - from))
        return hb_fail(err, HB_ERR_NUMERIC, "rod %s: its supports cannot be carried beyond t = %.9g",
                       rod->name, now);
      continue;
    }
    now = next;
    stride *= 2;
    if (now < t) status = balance(s, rod, now, options, RELAXATIONS, false, result, err);
  }
  return status;
}

/* Carries the supports, then balances. */
hb_status hb_statics_solve(hb_statics *s, const hb_rod *rod, double from, double t,
                           const hb_equilibrium_options *options, hb_equilibrium *result, hb_error *err) {
  const hb_force_def *moving = hb_load_first_moving(s->model, rod);
  if (moving)
    return hb_compile_fail(s->model->def, moving->line, moving->column, err,
                           "%s has no potential: statics knows loads that depend on time and place only",
                           moving->follower ? "a load that turns with the rod (follower)" : "wind");
  hb_kkt_begin(&s->kkt, s->model, rod);
  s->magnitude = 0;
  hb_status status = hb_statics_evaluate(s, rod, from, err);
  if (status) return status;
  hb_statics_find_scales(s, rod);
  guess_multipliers(s, rod);
  status = carry_supports(s, rod, from, t, options, result, err);
  if (!status) status = hb_statics_evaluate(s, rod, t, err);
  if (status) return status;
  s->magnitude = fabs(s->energy);
  hb_statics_find_scales(s, rod);
  guess_multipliers(s, rod);
  status = check_held(s, rod, err);
  return status ? status : balance(s, rod, t, options, options->max_iterations, true, result, err);
}
