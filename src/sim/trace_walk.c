/* One branch from point to point (docs/theory, 16.4 and 16.6). */
#include "sim/trace.h"

#include "base/memory.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* Tangents of neighbouring points have at least this cosine. */
#define STRAIGHT 0.93
/* No edge turns further between two points. */
#define LONGEST_TURN 0.35
/* Steps grow after so many corrections, and shrink after so many. */
#define FEW 4
#define MANY 8
/* Parts of the longest step: the first one, and the least before a branch is given up. */
#define FIRST 0.25
#define LEAST 1e-6
/* Below this part of the longest step a bend of the branch is taken as it is. */
#define SHARP 1e-3
/* Points in a row with an additional neutral mode before it is taken for one that stays. */
#define PATIENCE 8

/* What came of one attempt. */
typedef struct attempt {
  bool good, landed;
  hb_branch_events events;
  double distance;
} attempt;

/* The point in the sim of its scene, as `hebra solve` would give it. */
hb_status hb_tracer_tell(hb_tracer *t, const hb_branch_point *point, hb_trace_kind kind, int bifurcation,
                         int multiplicity, hb_error *err) {
  hb_member *member;
  hb_status status = hb_members_find(&t->members, point->p, &member, err);
  if (!status) status = hb_member_start(member, err);
  if (status) return status;
  hb_state *state = hb_sim_state(member->sim);
  hb_state_copy(state, point->state);
  state->scalar[HB_S_TIME] = member->t;
  t->costs.points++;
  hb_trace_point out = {.branch = t->branch,
                        .index = t->index++,
                        .kind = kind,
                        .parameter = point->p,
                        .arc = point->arc,
                        .bifurcation = bifurcation,
                        .multiplicity = multiplicity,
                        .found = {.iterations = point->iterations,
                                  .unstable = point->unstable,
                                  .neutral = point->neutral,
                                  .resolution = point->resolution,
                                  .residual = point->residual,
                                  .force_scale = point->scale,
                                  .last_step = point->last_step,
                                  .elastic = point->elastic,
                                  .multiplier = point->multiplier},
                        .sim = member->sim};
  return t->sink->point(t->sink->context, &out, err);
}

/* Is it one that is known? Rods that may turn about an axis pass it elsewhere on its orbit. */
static int find_known(const hb_tracer *t, const hb_branch_point *point) {
  const hb_rod *rod = t->b.rod;
  for (int k = 0; k < t->crossing_count; k++) {
    const hb_branch_point *other = &t->crossings[k].at;
    double far = 0;
    if (fabs(other->p - point->p) > 1e-6 * t->b.range) continue;
    for (int i = 3 * rod->first; i < 3 * (rod->first + rod->nv); i++)
      far = fmax(far, fabs(other->state->x[i] - point->state->x[i]));
    if (far <= 1e-4 * rod->length) return k;
  }
  return -1;
}

/* A bifurcation that waits, if there is room for its branches. */
static hb_status keep_crossing(hb_tracer *t, int multiplicity, int *number, hb_error *err) {
  const hb_branch_point *point = &t->special;
  *number = find_known(t, point);
  if (*number >= 0) return HB_OK;
  *number = t->crossing_count;
  if (t->crossing_count == t->options->max_branches) return HB_OK; /* told, but not followed */
  hb_crossing *c = &t->crossings[t->crossing_count];
  hb_status status = hb_branch_point_create(&t->b, t->members.first.model, &c->at, err);
  if (!status) {
    c->mode = hb_alloc((size_t)t->b.room, sizeof *c->mode);
    if (!c->mode) status = hb_fail_memory(err, "mode of a bifurcation");
  }
  t->crossing_count++; /* freed with the others */
  if (status) return status;
  hb_branch_point_copy(&t->b, &c->at, point);
  c->number = *number;
  c->branch = t->branch;
  c->multiplicity = multiplicity;
  int count = multiplicity < HB_BRANCH_MODES ? multiplicity : HB_BRANCH_MODES;
  if (!hb_branch_choose_mode(&t->b, count))
    c->multiplicity = 0; /* only frames turn: no way to leave along it */
  memcpy(c->mode, t->b.mode, (size_t)t->b.room * sizeof *c->mode);
  return HB_OK;
}

/* Folds and bifurcations between here and there, told in order. */
static hb_status tell_events(hb_tracer *t, const attempt *now, hb_error *err) {
  hb_status status = HB_OK;
  int before = t->clear, multiplicity, number, left;
  double start = 0, at;
  if (now->events.fold) {
    if (!hb_branch_find_fold(&t->b, &t->here, &t->there, now->distance, &t->special)) {
      t->unlocated = true;
      return HB_OK;
    }
    t->met = find_known(t, &t->special);
    return hb_tracer_tell(t, &t->special, t->met < 0 ? HB_TRACE_FOLD : HB_TRACE_BIFURCATION, t->met,
                          t->met < 0 ? 0 : t->crossings[t->met].multiplicity, err);
  }
  int after = before + now->events.change;
  while (!status && before != after) {
    if (!hb_branch_find_bifurcation(&t->b, &t->here, start, now->distance, before, after, &at, &multiplicity,
                                    &left, &t->special)) {
      t->unlocated = true;
      return HB_OK;
    }
    status = keep_crossing(t, multiplicity, &number, err);
    if (!status) status = hb_tracer_tell(t, &t->special, HB_TRACE_BIFURCATION, number, multiplicity, err);
    start = at;
    before = left;
  }
  return status;
}

/* Longest step from here by the turn of edges, and not beyond the range of the parameter by more than it
 * takes to land. */
static double longest_step(hb_tracer *t) {
  double longest;
  memcpy(t->b.s.direction, t->here.tangent, (size_t)t->b.s.kkt.matrix.n * sizeof(double));
  double turn = hb_statics_turn(&t->b.s, t->b.rod, &longest);
  return fmin(t->options->step, LONGEST_TURN / fmax(turn, 1e-12));
}

/* The limit that lies in the direction of the tangent, and how far it is. */
static double distance_to_limit(const hb_tracer *t, double *limit) {
  *limit = t->here.tangent_p > 0 ? t->b.upper : t->b.lower;
  return t->here.tangent_p != 0 ? (*limit - t->here.p) / t->here.tangent_p : HUGE_VAL;
}

/* A mode that round-off cannot tell from neutral says nothing about stability, unless the branch always has
 * it. */
static bool is_clear(const hb_tracer *t) { return t->there.neutral <= t->usual; }

/* Remembers what is clear about the point that was taken. */
static void remember(hb_tracer *t, bool fresh) {
  t->blurred = is_clear(t) ? 0 : t->blurred + 1;
  if (fresh || t->blurred > PATIENCE) t->usual = t->there.neutral;
  if (!is_clear(t)) return;
  t->usual = t->there.neutral;
  t->clear = t->there.unstable;
}

/* One attempt at the next point with the given step. */
static attempt try_step(hb_tracer *t, double step, bool fresh) {
  attempt now = {.good = false};
  double limit, to_limit = distance_to_limit(t, &limit);
  now.distance = fmin(step, to_limit);
  if (step < to_limit) {
    now.good = hb_branch_step(&t->b, &t->here, step, &t->there);
    if (now.good && (t->there.p > t->b.upper || t->there.p < t->b.lower)) { /* bent over the limit */
      limit = t->there.p > t->b.upper ? t->b.upper : t->b.lower;
      now.distance = step * (limit - t->here.p) / (t->there.p - t->here.p);
      now.landed = true;
    }
  } else {
    now.landed = true;
  }
  if (now.landed) {
    now.good = hb_branch_land(&t->b, &t->here, now.distance, limit, &t->there);
    if (now.good) now.distance = hb_branch_distance(&t->b, &t->here, &t->there);
  }
  if (!now.good) return now;
  bool sharp = hb_branch_product(&t->b, &t->here, &t->there) < STRAIGHT && step > SHARP * t->options->step;
  if (!fresh && is_clear(t)) now.events = hb_branch_compare(&t->here, &t->there, t->clear);
  if (!fresh && !is_clear(t)) now.events = hb_branch_compare(&t->here, &t->there, t->there.unstable);
  now.good = !sharp && !now.events.unclear && now.distance > 0;
  return now;
}

/* The end of a branch. */
static hb_status tell_end(hb_tracer *t, int bifurcation, int side, bool failed, const char *reason,
                          hb_error *err) {
  hb_trace_end end = {t->branch, bifurcation, side, t->index, failed, reason};
  return t->sink->end(t->sink->context, &end, err);
}

/* Here becomes there. */
static void go_on(hb_tracer *t) {
  hb_branch_point swapped = t->here;
  t->here = t->there;
  t->there = swapped;
}

/* Why a branch is given up. */
static void say_why(const hb_tracer *t, const attempt *now, char *text, size_t size) {
  const char *what = t->unlocated          ? "a fold or bifurcation could not be located"
                     : now->events.unclear ? "folds and bifurcations could not be told apart"
                                           : "no equilibrium was found next to the last one";
  const char *more = t->b.trouble.status ? t->b.trouble.text : "";
  snprintf(text, size, "%s beyond the parameter %.9g%s%.300s", what, t->here.p, more[0] ? ": " : "", more);
}

/* Until the range of the parameter ends, or the points allowed, or the branch cannot be followed. */
hb_status hb_tracer_walk(hb_tracer *t, int bifurcation, int side, bool fresh, hb_error *err) {
  double step = FIRST * t->options->step;
  char reason[HB_TRACE_SENTENCE];
  t->met = -1;
  t->clear = t->here.unstable;
  t->usual = t->here.neutral;
  t->blurred = 0;
  while (t->index < t->options->max_points) {
    hb_status status = HB_OK;
    step = fmin(step, longest_step(t));
    t->b.trouble = (hb_error){HB_OK, ""};
    attempt now = try_step(t, step, fresh);
    t->unlocated = false;
    if (now.good) status = tell_events(t, &now, err);
    if (status) return status;
    if (!now.good || t->unlocated) {
      step *= 0.5;
      status = t->b.trouble.status;
      if (status == HB_ERR_INPUT || status == HB_ERR_MEMORY)
        return hb_fail(err, status, "%s", t->b.trouble.text);
      if (step > LEAST * t->options->step) continue;
      say_why(t, &now, reason, sizeof reason);
      return tell_end(t, bifurcation, side, true, reason, err);
    }
    status = hb_tracer_tell(t, &t->there, now.landed ? HB_TRACE_LIMIT : HB_TRACE_REGULAR, -1, 0, err);
    if (status) return status;
    if (now.landed) return tell_end(t, bifurcation, side, false, "the range of the parameter ends", err);
    step *= t->there.iterations <= FEW ? 1.5 : t->there.iterations >= MANY ? 0.6 : 1;
    if (t->met >= 0) return tell_end(t, bifurcation, side, false, "it has come back to a bifurcation", err);
    remember(t, fresh);
    go_on(t);
    fresh = false;
  }
  return tell_end(t, bifurcation, side, false, "it has as many points as are allowed", err);
}
