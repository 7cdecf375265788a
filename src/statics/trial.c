/* Moving a rod tentatively: what is kept, what is tried, what it costs. */
#include "statics/equilibrium.h"

#include "base/memory.h"
#include "math/rotation.h"
#include "rod/hessian.h"
#include "rod/inextensible.h"

#include <float.h>
#include <string.h>

/* Corrections of the lengths per trial. */
#define CORRECTIONS 16
/* What may be left of the lengths, relative, as a part of the square of the largest turn, which is what a
 * step breaks of them. */
#define LENGTH_LEFT 1e-2
/* Steps with smaller turns than this break the lengths by less than the next step mends. */
#define SMALL_TURN 1e-3

/* Arrays for the longest rod, or for all slots where they are shared with the house. */
hb_status hb_statics_create(hb_statics *s, const hb_model *model, hb_state *state,
                            const hb_force_term *const *terms, hb_place place, void *context, hb_error *err) {
  int longest = 0;
  size_t n = (size_t)model->nv;
  memset(s, 0, sizeof *s);
  s->model = model;
  s->state = state;
  s->terms = terms;
  s->place = place;
  s->context = context;
  bool any_closed = false;
  for (int r = 0; r < model->rod_count; r++) {
    if (model->rods[r].nv > longest) longest = model->rods[r].nv;
    any_closed = any_closed || model->rods[r].closed;
  }
  hb_status status = hb_rod_work_create(model, &s->rod_work, err);
  if (!status) status = hb_project_work_create(model, &s->project_work, err);
  if (!status) status = hb_kkt_create(longest, &s->kkt, err);
  if (!status && any_closed) status = hb_kkt_add_border(&s->kkt, err);
  if (!status) status = hb_state_create(model, &s->kept, err);
  if (status) return status;
  s->multiplier = hb_alloc(n, sizeof *s->multiplier);
  s->none = hb_alloc(3 * n, sizeof *s->none);
  s->scratch = hb_alloc(3 * n, sizeof *s->scratch);
  s->moved = hb_alloc(3 * (size_t)longest, sizeof *s->moved);
  s->direction = hb_alloc((size_t)(HB_KKT_STRIDE * longest + HB_KKT_HALF), sizeof *s->direction);
  if (!s->multiplier || !s->none || !s->scratch || !s->moved || !s->direction)
    return hb_fail_memory(err, "workspace of the equilibrium");
  return HB_OK;
}

/* Frees it; also after a failed create. */
void hb_statics_free(hb_statics *s) {
  hb_rod_work_free(&s->rod_work);
  hb_project_work_free(&s->project_work);
  hb_kkt_free(&s->kkt);
  hb_state_free(s->kept);
  hb_free(s->multiplier);
  hb_free(s->none);
  hb_free(s->scratch);
  hb_free(s->moved);
  hb_free(s->direction);
}

/* State to kept. */
void hb_statics_keep(hb_statics *s, const hb_rod *rod) {
  hb_state_copy_rod(s->model, rod, s->kept, s->state);
}

/* And back. */
void hb_statics_undo(hb_statics *s, const hb_rod *rod) {
  hb_state_copy_rod(s->model, rod, s->state, s->kept);
}

/* What a step evaluates, at rest and without viscosity. */
hb_status hb_statics_evaluate(hb_statics *s, const hb_rod *rod, double t, hb_error *err) {
  hb_state *state = s->state;
  hb_status status = hb_rod_settle(s->model, rod, state, &s->rod_work, t, 0, err);
  if (status) return status;
  hb_rod_force(s->model, rod, state, &s->rod_work);
  s->energy = hb_rod_energy(s->model, rod, state, &s->rod_work);
  size_t from = 3 * (size_t)rod->first, to = from + 3 * (size_t)rod->nv;
  memset(state->load + from, 0, (to - from) * sizeof(double));
  for (int k = 0; s->terms[k]; k++)
    if (!s->terms[k]->dissipative && s->terms[k]->active(s->model, rod))
      s->terms[k]->add(s->model, rod, t, state->x, s->none, NULL, state->load);
  hb_rod_share_seam(rod, state->load);
  double sum = 0;
  for (size_t k = from; k < to; k++) {
    state->force[k] += state->load[k];
    sum += state->load[k];
  }
  if (!isfinite(sum)) return hb_fail(err, HB_ERR_NUMERIC, "rod %s: a load is not finite", rod->name);
  if (!(s->rod_work.lowest_chi > HB_FOLD_LIMIT))
    return hb_fail(err, HB_ERR_NUMERIC, "rod %s: the rod folds back onto itself at vertex %d", rod->name,
                   hb_rod_find_fold(rod, &s->rod_work));
  return HB_OK;
}

/* The turn of an edge is the change of its vector over its length. */
double hb_statics_turn(const hb_statics *s, const hb_rod *rod, double *displacement) {
  double turn = 0, longest = 0;
  for (int i = 0; i < rod->nv; i++) {
    const double *d = s->direction + HB_KKT_STRIDE * i;
    longest = fmax(longest, hb_v3_norm(hb_v3_load(d)));
    if (i + 1 == rod->nv) break;
    hb_v3 change = hb_v3_sub(hb_v3_load(d + HB_KKT_STRIDE), hb_v3_load(d));
    turn = fmax(turn, hb_v3_norm(change) * s->model->inv_rest_length[rod->first + i]);
    turn = fmax(turn, fabs(d[HB_KKT_TURN]));
  }
  *displacement = longest;
  return turn;
}

/* Work of the loads by the trapezoid: exact for dead loads, and of third order for others. */
static double work_of_loads(hb_statics *s, const hb_rod *rod) {
  double work = 0, size = 0;
  for (int k = 3 * rod->first; k < 3 * (rod->first + rod->nv); k++) {
    double moved = s->state->x[k] - s->kept->x[k];
    double part = 0.5 * (s->state->load[k] + s->kept->load[k]) * moved;
    work += part;
    size += fabs(part);
  }
  s->magnitude = fmax(s->magnitude, size);
  return work;
}

/* Values of the lengths' constraints into kkt->length, their work on the multipliers; returns the largest,
 * relative to its edge. */
static double look_at_lengths(hb_statics *s, const hb_rod *rod, double *work) {
  const hb_model *m = s->model;
  double worst = 0;
  *work = 0;
  for (int j = 0; !rod->extensible && j + 1 < rod->nv; j++) {
    int k = rod->first + j;
    hb_v3 gradient;
    double C = hb_inextensible_edge(s->state->x + 3 * k, m->rest_length[k], m->inv_rest_length[k], &gradient);
    s->kkt.length[j] = C;
    *work += s->multiplier[k] * C;
    worst = fmax(worst, fabs(C) * m->inv_rest_length[k]);
  }
  return worst;
}

/* Brings the lengths right to the allowed part of an edge, with as little energy as possible: Newton with the
 * gradients and the stiffness of the factors, which belong to where the rod is kept. A projection that looks
 * at masses only would put kinks beside clamps. */
static bool restore_lengths(hb_statics *s, const hb_rod *rod, double allowed, double *work) {
  hb_kkt *kkt = &s->kkt;
  double worst = look_at_lengths(s, rod, work);
  for (int round = 0; worst > allowed; round++) {
    double before = worst;
    memset(kkt->right, 0, (size_t)kkt->matrix.n * sizeof *kkt->right);
    for (int j = 0; j + 1 < rod->nv; j++)
      kkt->right[HB_KKT_STRIDE * (j + 1) + HB_KKT_MULTIPLIER] = -kkt->length[j];
    hb_kkt_solve(kkt);
    for (int i = 0; i < rod->nv; i++)
      hb_v3_accumulate(s->state->x + 3 * (rod->first + i), hb_v3_load(kkt->right + HB_KKT_STRIDE * i));
    worst = look_at_lengths(s, rod, work);
    if (!(worst < 0.7 * before) || round == CORRECTIONS) return worst <= allowed;
  }
  return worst <= allowed;
}

/* General rods get the turns of their frames as a first guess. What is left of the lengths counts with its
 * multipliers; the next Newton step takes it away. */
bool hb_statics_try(hb_statics *s, const hb_rod *rod, double t, double part, double *change) {
  hb_state *state = s->state;
  double before = s->energy, longest, work_before, work_after;
  double turn = part * hb_statics_turn(s, rod, &longest);
  (void)look_at_lengths(s, rod, &work_before);
  for (int i = 0; i < rod->nv; i++) {
    const double *d = s->direction + HB_KKT_STRIDE * i;
    double *x = state->x + 3 * (rod->first + i);
    for (int c = 0; c < 3; c++) x[c] += part * d[c];
    if (!rod->closed_form && i + 1 < rod->nv) state->spin[rod->first + i] = part * d[HB_KKT_TURN];
  }
  hb_status status = HB_OK;
  if (turn > SMALL_TURN ? !restore_lengths(s, rod, LENGTH_LEFT * turn * turn, &work_after)
                        : !isfinite(look_at_lengths(s, rod, &work_after)))
    status = HB_ERR_NUMERIC;
  if (!status) status = hb_statics_evaluate(s, rod, t, NULL);
  double now = s->energy;
  s->energy = before;
  if (status) return false;
  s->magnitude = fmax(s->magnitude, fabs(now));
  *change = now - before - work_of_loads(s, rod) + work_after - work_before;
  s->energy = now;
  return isfinite(*change);
}
