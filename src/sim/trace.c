/* Branches of equilibria: the first one, then those that cross it (docs/theory, 16). */
#include "sim/trace.h"

#include "base/memory.h"
#include "force/force.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* Attempts to leave a bifurcation, each half as far as the one before; the first by this part of a step. */
#define ATTEMPTS 12
#define LEAVE 0.5

/* What a user means who says nothing. */
hb_trace_options hb_trace_defaults(double from, double to) {
  return (hb_trace_options){.from = from, .to = to, .step = 0.02, .max_points = 1000, .max_branches = 5};
}

/* Words for files. */
const char *hb_trace_kind_name(hb_trace_kind kind) {
  static const char *const names[] = {"start", "regular", "fold", "bifurcation", "limit"};
  return names[kind];
}

/* The options, one rule after the other. */
static hb_status check_options(const hb_trace_options *o, hb_error *err) {
  if (!isfinite(o->from) || !isfinite(o->to) || o->from == o->to)
    return hb_fail(err, HB_ERR_INPUT, "the parameter goes from %g to %g; two different numbers are needed",
                   o->from, o->to);
  if (!(o->step > 0 && o->step <= 1))
    return hb_fail(err, HB_ERR_INPUT, "a longest step of %g; it must be above 0, at most 1", o->step);
  if (o->max_points < 2)
    return hb_fail(err, HB_ERR_INPUT, "%d points of a branch; at least 2 are needed", o->max_points);
  if (o->max_branches < 1)
    return hb_fail(err, HB_ERR_INPUT, "%d branches; at least 1 is needed", o->max_branches);
  return HB_OK;
}

/* Workspace, points. */
static hb_status prepare(hb_tracer *t, const hb_trace_family *family, hb_error *err) {
  const hb_trace_options *o = t->options;
  const hb_family inner = {hb_members_enter, &t->members};
  hb_status status = hb_members_begin(&t->members, family, o->from, err);
  if (status) return status;
  const hb_model *model = t->members.first.model;
  status =
      hb_branch_create(&t->b, model, hb_force_terms, &inner, fmin(o->from, o->to), fmax(o->from, o->to), err);
  if (!status) status = hb_branch_point_create(&t->b, model, &t->here, err);
  if (!status) status = hb_branch_point_create(&t->b, model, &t->there, err);
  if (!status) status = hb_branch_point_create(&t->b, model, &t->special, err);
  if (status) return status;
  t->crossings = hb_alloc((size_t)o->max_branches, sizeof *t->crossings);
  return t->crossings ? HB_OK : hb_fail_memory(err, "bifurcations");
}

/* The first equilibrium, as `hebra solve` finds it, then with the parameter held. */
static hb_status find_start(hb_tracer *t, hb_error *err) {
  hb_member *first = &t->members.first;
  hb_branch *b = &t->b;
  hb_equilibrium found;
  hb_equilibrium_options how = hb_equilibrium_defaults(first->t);
  how.any = t->options->any;
  hb_status status = hb_sim_find_equilibrium(first->sim, &how, &found, err);
  if (!status) {
    hb_state_copy(b->s.state, hb_sim_state(first->sim));
    memcpy(b->s.multiplier, found.multiplier, (size_t)first->model->nv * sizeof(double));
    status = hb_branch_evaluate(b, t->options->from, NULL, err);
  }
  hb_equilibrium_free(&found);
  if (!status) status = hb_branch_differentiate(b, err);
  if (status) return status;
  hb_branch_hold(b, t->options->to > t->options->from ? 1 : -1);
  if (!hb_branch_correct(b, 0, 0.5, &t->here.iterations, &t->here.last_step))
    return hb_fail(err, HB_ERR_NUMERIC, "rod %s: the equilibrium at the parameter %.9g cannot be continued",
                   b->rod->name, t->options->from);
  t->here.arc = 0;
  return hb_branch_finish(b, &t->here, err);
}

/* The first branch. */
static hb_status first_branch(hb_tracer *t, hb_error *err) {
  hb_status status = find_start(t, err);
  if (!status) status = hb_tracer_tell(t, &t->here, HB_TRACE_START, -1, 0, err);
  return status ? status : hb_tracer_walk(t, -1, 0, false, err);
}

/* One side of one crossing branch: the bifurcation, a first point beside it, and on. */
static hb_status cross(hb_tracer *t, const hb_crossing *c, int side, hb_error *err) {
  double amount = LEAVE * t->options->step;
  bool found = false;
  t->branch++;
  t->b.trouble = (hb_error){HB_OK, ""};
  t->index = 0;
  for (int k = 0; !found && c->multiplicity > 0 && k < ATTEMPTS; k++) {
    found = hb_branch_leave(&t->b, &c->at, c->mode, side * amount, &t->here);
    if (found) found = t->here.p >= t->b.lower && t->here.p <= t->b.upper;
    amount *= 0.5;
    hb_status trouble = t->b.trouble.status;
    if (!found && (trouble == HB_ERR_INPUT || trouble == HB_ERR_MEMORY))
      return hb_fail(err, trouble, "%s", t->b.trouble.text);
  }
  if (!found) {
    hb_trace_end end = {t->branch, c->number, side,
                        0,         true,      "no equilibrium was found beside the bifurcation"};
    return t->sink->end(t->sink->context, &end, err);
  }
  hb_branch_point_copy(&t->b, &t->special, &c->at);
  t->special.arc = 0;
  hb_status status = hb_tracer_tell(t, &t->special, HB_TRACE_START, c->number, 0, err);
  if (!status) status = hb_tracer_tell(t, &t->here, HB_TRACE_REGULAR, -1, 0, err);
  return status ? status : hb_tracer_walk(t, c->number, side, true, err);
}

/* In the order in which they were found, both sides of each. */
hb_status hb_trace(const hb_trace_family *family, const hb_trace_options *options, const hb_trace_sink *sink,
                   hb_trace_costs *costs, hb_error *err) {
  hb_tracer *t = NULL;
  hb_status status = check_options(options, err);
  if (status) return status;
  t = hb_alloc(1, sizeof *t);
  if (!t) return hb_fail_memory(err, "workspace of the branches");
  t->options = options;
  t->sink = sink;
  status = prepare(t, family, err);
  if (!status) status = first_branch(t, err);
  for (int k = 0; !status && k < t->crossing_count; k++)
    for (int side = 1; !status && side >= -1 && t->branch + 1 < options->max_branches; side -= 2)
      status = cross(t, &t->crossings[k], side, err);
  if (costs) {
    t->costs.iterations = t->b.iterations;
    t->costs.factorisations = t->b.factorisations + t->b.counted.factorisations;
    t->costs.scenes = t->members.made;
    *costs = t->costs;
  }
  for (int k = 0; k < t->crossing_count; k++) {
    hb_branch_point_free(&t->crossings[k].at);
    hb_free(t->crossings[k].mode);
  }
  hb_free(t->crossings);
  hb_branch_point_free(&t->here);
  hb_branch_point_free(&t->there);
  hb_branch_point_free(&t->special);
  hb_branch_free(&t->b);
  hb_members_free(&t->members);
  hb_free(t);
  return status;
}
