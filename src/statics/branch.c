/* Points of a branch: predicted along the tangent, corrected by Newton's method (docs/theory, 16.3 and 16.4).
 */
#include "statics/branch.h"

#include "base/memory.h"
#include "math/vec3.h"

#include <float.h>
#include <math.h>
#include <string.h>

/* Iterations before a step is called too long; after so many the parameter's derivative is taken anew. */
#define ITERATIONS 14
#define RENEWAL 4
/* An answer is taken if the next step would turn no edge by more. */
#define SMALL_TURN 1e-5
/* Unbalanced forces that round-off may leave, relative. */
#define LEFT_OVER 1e-6
/* No edge turns further in one correction. */
#define LONGEST_TURN 0.5

/* Arrays of doubles, one block each. */
static hb_status make_arrays(hb_branch *b, const hb_model *model, hb_error *err) {
  size_t room = (size_t)b->room;
  double **const arrays[] = {&b->rate,   &b->column, &b->row,  &b->left, &b->right,
                             &b->answer, &b->wanted, &b->rest, &b->held};
  for (size_t k = 0; k < sizeof arrays / sizeof arrays[0]; k++) {
    *arrays[k] = hb_alloc(room, sizeof **arrays[k]);
    if (!*arrays[k]) return hb_fail_memory(err, "workspace of the branches");
  }
  b->turns = hb_alloc((size_t)model->nv, sizeof *b->turns);
  b->mode = hb_alloc(HB_BRANCH_MODES * room, sizeof *b->mode);
  b->rigid = hb_alloc(HB_BRANCH_RIGID * room, sizeof *b->rigid);
  if (!b->turns || !b->mode || !b->rigid) return hb_fail_memory(err, "workspace of the branches");
  return HB_OK;
}

/* The statics room's workspace and more of the same size. */
hb_status hb_branch_create(hb_branch *b, const hb_model *model, const hb_force_term *const *terms,
                           const hb_family *family, double lower, double upper, hb_error *err) {
  hb_state *state = NULL;
  memset(b, 0, sizeof *b);
  b->family = *family;
  b->lower = lower;
  b->upper = upper;
  b->range = upper - lower;
  b->tolerance = 1e-10;
  b->room = HB_KKT_STRIDE * model->nv + HB_KKT_HALF;
  hb_status status = hb_state_create(model, &state, err);
  if (!status) status = hb_statics_create(&b->s, model, state, terms, NULL, NULL, err);
  b->s.state = state; /* this one is the branch's own */
  if (!status) status = hb_state_create(model, &b->center, err);
  return status ? status : make_arrays(b, model, err);
}

/* Frees it; also after a failed create. */
void hb_branch_free(hb_branch *b) {
  hb_state_free(b->s.state);
  hb_statics_free(&b->s);
  hb_state_free(b->center);
  double *const arrays[] = {b->rate,   b->column, b->row,  b->left,  b->right, b->answer,
                            b->wanted, b->rest,   b->held, b->turns, b->mode,  b->rigid};
  for (size_t k = 0; k < sizeof arrays / sizeof arrays[0]; k++) hb_free(arrays[k]);
}

/* State, multipliers, tangent. */
hb_status hb_branch_point_create(const hb_branch *b, const hb_model *model, hb_branch_point *point,
                                 hb_error *err) {
  memset(point, 0, sizeof *point);
  hb_status status = hb_state_create(model, &point->state, err);
  if (status) return status;
  point->multiplier = hb_alloc((size_t)model->nv, sizeof *point->multiplier);
  point->tangent = hb_alloc((size_t)b->room, sizeof *point->tangent);
  point->rate = hb_alloc((size_t)b->room, sizeof *point->rate);
  point->turns = hb_alloc((size_t)model->nv, sizeof *point->turns);
  if (!point->multiplier || !point->tangent || !point->rate || !point->turns)
    return hb_fail_memory(err, "point of a branch");
  return HB_OK;
}

/* Frees it; also one that is all 0. */
void hb_branch_point_free(hb_branch_point *point) {
  hb_state_free(point->state);
  hb_free(point->multiplier);
  hb_free(point->tangent);
  hb_free(point->rate);
  hb_free(point->turns);
  memset(point, 0, sizeof *point);
}

/* The numbers; each keeps its own arrays. */
void hb_branch_point_copy(const hb_branch *b, hb_branch_point *to, const hb_branch_point *from) {
  hb_branch_point arrays = *to;
  *to = *from;
  to->state = arrays.state;
  to->multiplier = arrays.multiplier;
  to->tangent = arrays.tangent;
  to->rate = arrays.rate;
  to->turns = arrays.turns;
  hb_state_copy(to->state, from->state);
  memcpy(to->multiplier, from->multiplier, (size_t)b->s.model->nv * sizeof *to->multiplier);
  memcpy(to->tangent, from->tangent, (size_t)b->room * sizeof *to->tangent);
  memcpy(to->rate, from->rate, (size_t)b->room * sizeof *to->rate);
  memcpy(to->turns, from->turns, (size_t)b->s.model->nv * sizeof *to->turns);
}

/* Into the family at p, then what a step evaluates. */
static hb_status evaluate(hb_branch *b, double p, const double *turn, hb_error *err) {
  hb_statics *s = &b->s;
  hb_status status = b->family.enter(b->family.context, p, s->state, &s->model, &b->t, err);
  if (status) return status;
  b->rod = &s->model->rods[0];
  b->p = p;
  b->metric = 1 / (b->rod->length * b->rod->length * b->rod->length);
  hb_kkt_begin(&s->kkt, s->model, b->rod);
  for (int j = 0; !b->rod->closed_form && j + 1 < b->rod->nv; j++)
    s->state->spin[b->rod->first + j] = turn ? turn[j] : 0;
  status = hb_statics_evaluate(s, b->rod, b->t, err);
  if (!status) hb_statics_find_scales(s, b->rod);
  return status;
}

/* What goes wrong is kept for the end of the branch. */
hb_status hb_branch_evaluate(hb_branch *b, double p, const double *turn, hb_error *err) {
  hb_error inner = {HB_OK, ""};
  hb_status status = evaluate(b, p, turn, &inner);
  if (!status) return HB_OK;
  b->trouble = inner;
  if (err) *err = inner;
  return status;
}

/* Positions, frames, multipliers of the point. */
hb_status hb_branch_return(hb_branch *b, const hb_branch_point *from, hb_error *err) {
  hb_state_copy(b->s.state, from->state);
  memcpy(b->s.multiplier, from->multiplier, (size_t)b->s.model->nv * sizeof *from->multiplier);
  memcpy(b->rate, from->rate, (size_t)b->room * sizeof *from->rate);
  memcpy(b->turns, from->turns, (size_t)b->s.model->nv * sizeof *from->turns);
  return hb_branch_evaluate(b, from->p, NULL, err);
}

/* Moves the workspace by `part` of b->answer, the parameter to p. */
static hb_status move(hb_branch *b, const double *step, double part, double p) {
  hb_statics *s = &b->s;
  const hb_rod *rod = b->rod;
  for (int i = 0; i < rod->nv; i++) {
    const double *d = step + HB_KKT_STRIDE * i;
    for (int c = 0; c < 3; c++) s->state->x[3 * (rod->first + i) + c] += part * d[c];
    if (i > 0) s->multiplier[rod->first + i - 1] += part * d[HB_KKT_MULTIPLIER];
    s->scratch[i] = part * d[HB_KKT_TURN] + (p - b->p) * b->turns[i];
  }
  return hb_branch_evaluate(b, p, s->scratch, NULL);
}

/* Newton's step with the border as it is: into b->answer, returns that of the parameter. */
static double newton_step(hb_branch *b, double gap) {
  hb_statics *s = &b->s;
  const hb_rod *rod = b->rod;
  double dp, *f = b->answer;
  memcpy(f, s->kkt.right, (size_t)s->kkt.matrix.n * sizeof *f);
  hb_v3 before = {0, 0, 0};
  for (int i = 0; i < rod->nv; i++) {
    int k = rod->first + i;
    hb_v3 pull = {0, 0, 0};
    if (i + 1 < rod->nv)
      pull = hb_v3_scale(2 * s->multiplier[k] * s->model->inv_rest_length[k],
                         hb_v3_sub(hb_v3_load(s->state->x + 3 * k + 3), hb_v3_load(s->state->x + 3 * k)));
    hb_v3 rest = hb_v3_add(hb_v3_load(s->state->force + 3 * k), hb_v3_sub(pull, before));
    for (int c = 0; c < 3; c++)
      if (s->kkt.weight[HB_KKT_STRIDE * i + c] != 0) f[HB_KKT_STRIDE * i + c] += (&rest.x)[c];
    before = pull;
  }
  hb_branch_border(b);
  hb_branch_solve(b, f, gap, &dp);
  return dp;
}

/* Largest turn of an edge in a step. */
static double turn_of(hb_branch *b, const double *step, double *longest) {
  memcpy(b->s.direction, step, (size_t)b->s.kkt.matrix.n * sizeof *step);
  return hb_statics_turn(&b->s, b->rod, longest);
}

/* Newton's method; where round-off decides it is content with what it has. */
bool hb_branch_correct(hb_branch *b, double gap, double longest_turn, int *iterations, double *last_step) {
  double previous = HUGE_VAL, travelled = 0;
  for (int k = 0; k < ITERATIONS; k++) {
    if (k == RENEWAL && hb_branch_differentiate(b, NULL)) return false;
    if (!hb_branch_factor(b)) return false;
    double residual = hb_statics_unbalanced(&b->s, b->rod, b->s.multiplier + b->rod->first);
    double scale =
        fmax(b->s.unit, hb_statics_largest_tension(&b->s, b->rod, b->s.multiplier + b->rod->first));
    double dp = newton_step(b, gap), turn = turn_of(b, b->answer, last_step);
    if (!isfinite(dp) || !isfinite(turn)) return false;
    double small = fabs(dp) / b->range, part = fmin(1, fmin(LONGEST_TURN / turn, 0.5 / small));
    travelled += part * turn;
    if (travelled > longest_turn) return false;
    if (move(b, b->answer, part, b->p + part * dp)) return false;
    gap *= 1 - part;
    b->iterations++;
    *iterations = k + 1;
    bool near = turn <= SMALL_TURN && small <= SMALL_TURN;
    if (near && residual <= b->tolerance * scale) return true;
    if (near && residual <= LEFT_OVER * scale && residual >= 0.25 * previous) return true;
    previous = residual;
  }
  return false;
}

/* Tangent: where the unknowns go if the row moves by 1; scaled to 1 in the metric. */
static void find_tangent(hb_branch *b, hb_branch_point *out) {
  double *t = out->tangent, size = 0;
  memset(t, 0, (size_t)b->room * sizeof *t);
  hb_branch_border(b);
  hb_branch_solve(b, t, 1, &out->tangent_p);
  for (int k = 0; k < b->s.kkt.matrix.n; k++) {
    size += k % HB_KKT_STRIDE < 3 ? b->metric * b->s.kkt.weight[k] * t[k] * t[k] : 0;
  }
  size = sqrt(size + out->tangent_p * out->tangent_p / (b->range * b->range));
  for (int k = 0; k < b->s.kkt.matrix.n; k++) t[k] /= size;
  out->tangent_p /= size;
}

/* Everything that a point tells. */
hb_status hb_branch_finish(hb_branch *b, hb_branch_point *out, hb_error *err) {
  hb_statics *s = &b->s;
  hb_status status = hb_branch_differentiate(b, err);
  if (status) return status;
  if (!hb_branch_factor(b))
    return hb_fail(err, HB_ERR_NUMERIC, "rod %s: the lengths cannot be kept: its supports leave it no room",
                   b->rod->name);
  find_tangent(b, out);
  out->p = b->p;
  out->residual = hb_statics_unbalanced(s, b->rod, s->multiplier + b->rod->first);
  out->scale = fmax(s->unit, hb_statics_largest_tension(s, b->rod, s->multiplier + b->rod->first));
  out->elastic = s->energy;
  hb_statics_count_modes(s, b->rod, out->residual, &b->counted, &out->unstable, &out->neutral);
  out->resolution = s->resolution;
  hb_state_copy(out->state, s->state);
  memcpy(out->multiplier, s->multiplier, (size_t)s->model->nv * sizeof *out->multiplier);
  memcpy(out->rate, b->rate, (size_t)b->room * sizeof *out->rate);
  memcpy(out->turns, b->turns, (size_t)s->model->nv * sizeof *out->turns);
  return HB_OK;
}

/* Along the tangent, in the metric. */
void hb_branch_along(hb_branch *b, const hb_branch_point *point) {
  memset(b->row, 0, (size_t)b->room * sizeof *b->row);
  for (int k = 0; k < b->s.kkt.matrix.n; k++)
    if (k % HB_KKT_STRIDE < 3) b->row[k] = b->metric * b->s.kkt.weight[k] * point->tangent[k];
  b->corner = point->tangent_p / (b->range * b->range);
}

/* The parameter itself. */
void hb_branch_hold(hb_branch *b, double sign) {
  memset(b->row, 0, (size_t)b->room * sizeof *b->row);
  b->corner = sign / b->range;
}

/* The derivative by the parameter is that of the last point until it is renewed. */
bool hb_branch_step(hb_branch *b, const hb_branch_point *from, double step, hb_branch_point *out) {
  int iterations = 0;
  double longest = 0, last;
  if (hb_branch_return(b, from, NULL)) return false;
  double turn = fabs(step) * turn_of(b, from->tangent, &longest);
  double p = from->p + step * from->tangent_p;
  if (move(b, from->tangent, step, p)) return false;
  hb_branch_along(b, from);
  if (!hb_branch_correct(b, 0, 0.02 + turn, &iterations, &last)) return false;
  hb_branch_along(b, from);
  if (hb_branch_finish(b, out, NULL)) return false;
  out->arc = from->arc + step;
  out->iterations = iterations;
  out->last_step = last;
  return true;
}

/* With the parameter held. */
bool hb_branch_land(hb_branch *b, const hb_branch_point *from, double step, double p, hb_branch_point *out) {
  int iterations = 0;
  double longest, last;
  if (hb_branch_return(b, from, NULL)) return false;
  double turn = fabs(step) * turn_of(b, from->tangent, &longest);
  if (move(b, from->tangent, step, p)) return false;
  hb_branch_hold(b, 1);
  if (!hb_branch_correct(b, 0, 0.02 + turn, &iterations, &last)) return false;
  hb_branch_along(b, from);
  if (hb_branch_finish(b, out, NULL)) return false;
  out->p = p; /* to the last bit */
  out->arc = from->arc + step;
  out->iterations = iterations;
  out->last_step = last;
  return true;
}

/* The mode instead of the tangent; the parameter starts from where it is at the bifurcation.
 */
bool hb_branch_leave(hb_branch *b, const hb_branch_point *from, const double *mode, double amount,
                     hb_branch_point *out) {
  int iterations = 0;
  double longest, last;
  if (hb_branch_return(b, from, NULL)) return false;
  double turn = fabs(amount) * turn_of(b, mode, &longest);
  if (move(b, mode, amount, from->p)) return false;
  if (hb_branch_differentiate(b, NULL))
    return false; /* on a straight rod the parameter may do nothing at all */
  memset(b->row, 0, (size_t)b->room * sizeof *b->row);
  for (int k = 0; k < b->s.kkt.matrix.n; k++)
    if (k % HB_KKT_STRIDE < 3) b->row[k] = (amount < 0 ? -1 : 1) * b->metric * b->s.kkt.weight[k] * mode[k];
  b->corner = 0;
  if (!hb_branch_correct(b, 0, 0.02 + turn, &iterations, &last)) return false;
  if (hb_branch_finish(b, out, NULL)) return false;
  out->arc = fabs(amount);
  out->iterations = iterations;
  out->last_step = last;
  return true;
}

/* Positions and parameter count, multipliers and turns follow from them. */
double hb_branch_product(const hb_branch *b, const hb_branch_point *x, const hb_branch_point *y) {
  double sum = x->tangent_p * y->tangent_p / (b->range * b->range);
  for (int k = 0; k < b->s.kkt.matrix.n; k++)
    if (k % HB_KKT_STRIDE < 3) sum += b->metric * b->s.kkt.weight[k] * x->tangent[k] * y->tangent[k];
  return sum;
}

/* Likewise. */
double hb_branch_distance(const hb_branch *b, const hb_branch_point *from, const hb_branch_point *to) {
  double sum = from->tangent_p * (to->p - from->p) / (b->range * b->range);
  for (int k = 0; k < b->s.kkt.matrix.n; k++) {
    int slot = 3 * (k / HB_KKT_STRIDE) + k % HB_KKT_STRIDE;
    if (k % HB_KKT_STRIDE < 3)
      sum += b->metric * b->s.kkt.weight[k] * from->tangent[k] * (to->state->x[slot] - from->state->x[slot]);
  }
  return sum;
}
