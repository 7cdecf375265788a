/* Rods that differ in the value of one parameter (docs/theory, 16.1). */
#include "sim/trace.h"

#include "base/memory.h"
#include "model/compile.h"

#include <math.h>
#include <string.h>

/* Frees one. */
static void drop(hb_members *m, hb_member *member) {
  hb_sim_free(member->sim);
  hb_free(member->held);
  if (member->model) m->family->drop(m->family->context, member->model);
  memset(member, 0, sizeof *member);
}

/* Frees all. */
void hb_members_free(hb_members *m) {
  for (int k = 0; k < HB_FAMILY_KEPT; k++) drop(m, &m->kept[k]);
  drop(m, &m->first);
}

/* Does a prescribed frame count from the director that the initial state has there? */
static bool needs_start(const hb_model *model) {
  for (int k = 0; k < model->frame_count; k++)
    if (model->frames[k].def->kind != HB_SUPPORT_DIRECTOR) return true;
  return false;
}

/* The initial state costs more than the model, and is made only where it is asked for. Held directors are
 * kept: measuring overwrites the state. */
hb_status hb_member_start(hb_member *member, hb_error *err) {
  if (member->sim) return HB_OK;
  hb_status status = hb_sim_create(member->model, &member->sim, err);
  if (status) return status;
  member->held = hb_alloc(6 * (size_t)member->model->frame_count, sizeof *member->held);
  if (!member->held) return hb_fail_memory(err, "frames of a rod");
  const hb_state *state = hb_sim_state(member->sim);
  for (int k = 0; k < member->model->frame_count; k++) {
    memcpy(member->held + 6 * k, state->frame_m1 + 3 * k, 3 * sizeof(double));
    memcpy(member->held + 6 * k + 3, state->frame_tangent + 3 * k, 3 * sizeof(double));
  }
  return HB_OK;
}

/* Scene, model, and the initial state if supports depend on it. */
static hb_status make(hb_members *m, double p, hb_member *out, hb_error *err) {
  hb_status status = m->family->at(m->family->context, p, &out->model, &out->t, err);
  if (status) {
    out->model = NULL;
    return status;
  }
  out->p = p;
  m->made++;
  return needs_start(out->model) ? hb_member_start(out, err) : HB_OK;
}

/* Do two models have the same tables of supports? */
static bool same_supports(const hb_model *a, const hb_model *b) {
  if (a->position_count != b->position_count || a->frame_count != b->frame_count) return false;
  for (int k = 0; k < a->position_count; k++) {
    const hb_position_support *x = &a->positions[k], *y = &b->positions[k];
    if (x->slot != y->slot || x->tangent != y->tangent || memcmp(x->fixed, y->fixed, sizeof x->fixed) != 0)
      return false;
  }
  for (int k = 0; k < a->frame_count; k++)
    if (a->frames[k].slot != b->frames[k].slot || a->frames[k].def->kind != b->frames[k].def->kind)
      return false;
  return true;
}

/* The state of one must be one of the other. */
static hb_status compare(const hb_member *first, const hb_member *other, hb_error *err) {
  const hb_model *a = first->model, *b = other->model;
  if (b->rod_count != 1 || a->nv != b->nv)
    return hb_fail(err, HB_ERR_INPUT,
                   "the parameter changes the number of vertices: %d at %.9g, %d at %.9g; a branch needs the "
                   "same rod everywhere",
                   a->nv, first->p, b->nv, other->p);
  if (!same_supports(a, b))
    return hb_fail(err, HB_ERR_INPUT,
                   "the parameter changes which vertices and frames are held: not the same at %.9g and %.9g",
                   first->p, other->p);
  if (a->rods[0].closed_form != b->rods[0].closed_form || a->rods[0].extensible != b->rods[0].extensible ||
      a->panel_count != b->panel_count || a->any_viscosity != b->any_viscosity)
    return hb_fail(
        err, HB_ERR_INPUT,
        "the parameter changes the kind of the rod (isotropic and straight at rest, or not) between "
        "%.9g and %.9g; a range that leaves out such a value is needed",
        first->p, other->p);
  return HB_OK;
}

/* The one that was not asked for longest makes room. */
hb_status hb_members_find(hb_members *m, double p, hb_member **out, hb_error *err) {
  hb_member *oldest = &m->kept[0];
  m->asked++;
  for (int k = 0; k < HB_FAMILY_KEPT; k++) {
    hb_member *member = &m->kept[k];
    if (member->model && member->p == p) {
      member->used = m->asked;
      *out = member;
      return HB_OK;
    }
    if (member->used < oldest->used) oldest = member;
  }
  drop(m, oldest);
  hb_status status = make(m, p, oldest, err);
  if (!status) status = compare(&m->first, oldest, err);
  if (status) {
    drop(m, oldest);
    return status;
  }
  oldest->used = m->asked;
  *out = oldest;
  return HB_OK;
}

/* Could the edge of a held frame turn? Then the torque of its support would have no potential. */
static bool may_turn(const hb_model *m, const double *x, int slot) {
  for (int end = 0; end < 2; end++)
    for (int c = 0; c < 3; c++) {
      double along = x[3 * slot + 3 + c] - x[3 * slot + c];
      bool free = m->inv_mass[3 * (slot + end) + c] != 0;
      if (free && fabs(along) < (1 - 1e-9) * m->rest_length[slot]) return true;
    }
  return false;
}

/* What holds for the first holds for all. */
hb_status hb_members_begin(hb_members *m, const hb_trace_family *family, double p, hb_error *err) {
  m->family = family;
  hb_status status = make(m, p, &m->first, err);
  if (!status) status = hb_member_start(&m->first, err);
  if (status) return status;
  const hb_model *model = m->first.model;
  if (model->rod_count != 1)
    return hb_fail(err, HB_ERR_INPUT, "the scene has %d rods; branches are those of one rod",
                   model->rod_count);
  const hb_rod_def *rod = &model->def->rods[0];
  if (model->rods[0].closed)
    return hb_compile_fail(
        model->def, rod->line, rod->column, err,
        "rod \"%s\" is closed; branches are those of a rod with two ends (hebra solve finds "
        "single equilibria of closed ones)",
        model->rods[0].name);
  const double *x = hb_sim_const_state(m->first.sim)->x;
  for (int k = 0; k < model->frame_count; k++)
    if (may_turn(model, x, model->frames[k].slot))
      return hb_compile_fail(
          model->def, model->frames[k].def->line, model->frames[k].def->column, err,
          "the material frame of edge %d is held, but the edge may turn: the torque of such "
          "a support has no potential, and branches need one (clamp: true holds both)",
          model->frames[k].slot);
  return HB_OK;
}

/* Supports of the member's time. Prescribed angles count from the director that the member's own initial
 * state has; directors in space follow from formulas. Frames are turned, and windings counted, when the state
 * is evaluated. */
hb_status hb_members_enter(void *context, double p, hb_state *state, const hb_model **model, double *t,
                           hb_error *err) {
  hb_members *m = context;
  hb_member *member;
  hb_status status = hb_members_find(m, p, &member, err);
  if (status) return status;
  for (int k = 0; k < member->model->position_count; k++) {
    const hb_position_support *s = &member->model->positions[k];
    double *x = state->x + 3 * s->slot, still[3] = {0, 0, 0}, rate[3];
    hb_support_at(member->model, s, member->t, s->tangent ? state->x + 3 * s->base : x, still, x, rate);
  }
  for (int k = 0; k < member->model->frame_count; k++) {
    if (member->model->frames[k].def->kind == HB_SUPPORT_DIRECTOR) continue;
    memcpy(state->frame_m1 + 3 * k, member->held + 6 * k, 3 * sizeof(double));
    memcpy(state->frame_tangent + 3 * k, member->held + 6 * k + 3, 3 * sizeof(double));
  }
  *model = member->model;
  *t = member->t;
  return HB_OK;
}
