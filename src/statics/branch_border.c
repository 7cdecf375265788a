/* One more unknown, the parameter, and one more equation, which picks a point of the branch
 * (docs/theory, 16.2 and 16.3). */
#include "statics/branch.h"

#include "math/vec3.h"
#include "rod/inextensible.h"

#include <math.h>
#include <string.h>

/* Differences by the parameter are taken over this part of its range. */
#define DIFFERENCE 1e-3
/* Other multiples of the constraints that are tried where a leading block is singular. */
#define ATTEMPTS 5
#define GROWTH 1.6

/* A rod with modes that cost nothing has a singular matrix: a stiffness that round-off cannot tell from 0 is
 * added. */
bool hb_branch_factor(hb_branch *b) {
  hb_statics *s = &b->s;
  double augment = s->kkt.augment;
  int wrong = -1;
  b->shift = s->softest;
  for (int k = 0; wrong < 0 && k < ATTEMPTS; k++) {
    hb_kkt_assemble(&s->kkt, s->model, b->rod, s->state, &s->rod_work, b->t, s->multiplier, NULL);
    wrong = hb_kkt_factor(&s->kkt, b->shift);
    b->factorisations++;
    s->kkt.augment *= GROWTH;
  }
  s->kkt.augment = augment;
  return wrong >= 0;
}

/* Product of vectors of unknowns. */
static double dot(const hb_branch *b, const double *x, const double *y) {
  double sum = 0;
  for (int k = 0; k < b->s.kkt.matrix.n; k++) sum += x[k] * y[k];
  return sum;
}

/* Solves with the factors in place. */
static void solve(const hb_branch *b, double *x) { hb_band_solve(&b->s.kkt.factors, x); }

/* The stiffness that is added along the edges sees the change of the lengths too; rows of what is prescribed
 * are those of the identity. */
static void complete_column(hb_branch *b) {
  const hb_kkt *kkt = &b->s.kkt;
  const hb_model *m = b->s.model;
  double *column = b->column;
  memcpy(column, b->rate, (size_t)kkt->matrix.n * sizeof *column);
  for (int j = 0; !b->rod->extensible && j + 1 < b->rod->nv; j++) {
    int k = b->rod->first + j;
    hb_v3 gradient;
    double change = column[HB_KKT_STRIDE * (j + 1) + HB_KKT_MULTIPLIER];
    (void)hb_inextensible_edge(b->s.state->x + 3 * k, m->rest_length[k], m->inv_rest_length[k], &gradient);
    for (int c = 0; c < 3; c++) {
      column[HB_KKT_STRIDE * j + c] -= kkt->along[j] * change * (&gradient.x)[c];
      column[HB_KKT_STRIDE * (j + 1) + c] += kkt->along[j] * change * (&gradient.x)[c];
    }
  }
  for (int k = 0; k < kkt->matrix.n; k++) {
    bool multiplier = k % HB_KKT_STRIDE == HB_KKT_MULTIPLIER && k >= HB_KKT_STRIDE;
    if (!multiplier && (kkt->weight[k] == 0 || k % HB_KKT_STRIDE == HB_KKT_TURN)) column[k] = 0;
  }
}

/* What every solution with the same border needs. */
void hb_branch_border(hb_branch *b) {
  size_t size = (size_t)b->s.kkt.matrix.n * sizeof *b->row;
  complete_column(b);
  memcpy(b->left, b->row, size);
  memcpy(b->right, b->column, size);
  solve(b, b->left);
  solve(b, b->right);
  b->delta_left = b->corner - dot(b, b->left, b->column);
  b->delta_right = b->corner - dot(b, b->row, b->right);
}

/* Mixed block elimination: right to round-off also where the band itself is singular, which is so at folds
 * (Govaerts and Pryce 1993). x: f, then the answer. */
static void eliminate(const hb_branch *b, double *x, double g, double *dp) {
  int n = b->s.kkt.matrix.n;
  double first = (g - dot(b, b->left, x)) / b->delta_left;
  for (int k = 0; k < n; k++) x[k] -= b->column[k] * first;
  solve(b, x);
  double second = (g - b->corner * first - dot(b, b->row, x)) / b->delta_right;
  for (int k = 0; k < n; k++) x[k] -= b->right[k] * second;
  *dp = first + second;
}

/* With one step of iterative refinement: factors without exchange of rows may have lost digits. */
void hb_branch_solve(hb_branch *b, double *f, double g, double *dp) {
  const hb_kkt *kkt = &b->s.kkt;
  int n = kkt->matrix.n;
  double more, *rest = b->rest, *product = b->held;
  memcpy(rest, f, (size_t)n * sizeof *rest);
  eliminate(b, f, g, dp);
  hb_band_multiply(&kkt->matrix, f, product);
  for (int k = 0; k < n; k++) rest[k] -= product[k] + b->shift * kkt->weight[k] * f[k] + b->column[k] * *dp;
  double left = g - dot(b, b->row, f) - b->corner * *dp;
  eliminate(b, rest, left, &more);
  if (!isfinite(more)) return;
  for (int k = 0; k < n; k++) f[k] += rest[k];
  *dp += more;
}

/* Adds `part` times the equations at the workspace's state and multipliers: forces that nothing balances,
 * with the sign of a derivative of the energy, and the lengths. */
static void add_equations(const hb_branch *b, double part, double *out) {
  const hb_statics *s = &b->s;
  const hb_rod *rod = b->rod;
  const double *x = s->state->x + 3 * (size_t)rod->first;
  hb_v3 before = {0, 0, 0};
  for (int i = 0; i < rod->nv; i++) {
    int k = rod->first + i;
    hb_v3 pull = {0, 0, 0};
    if (i + 1 < rod->nv) {
      double C =
          hb_inextensible_edge(x + 3 * i, s->model->rest_length[k], s->model->inv_rest_length[k], &pull);
      pull = hb_v3_scale(s->multiplier[k], pull);
      if (!rod->extensible) out[HB_KKT_STRIDE * (i + 1) + HB_KKT_MULTIPLIER] += part * C;
    }
    hb_v3 rest = hb_v3_add(hb_v3_load(s->state->force + 3 * k), hb_v3_sub(pull, before));
    double *to = out + HB_KKT_STRIDE * i;
    to[0] -= part * rest.x;
    to[1] -= part * rest.y;
    to[2] -= part * rest.z;
    before = pull;
  }
}

/* Weights of a first derivative by five points, of which number `at` is where it is taken; in units of the
 * distance. */
static void weights(int at, double w[5]) {
  static const double table[3][5] = {{-25.0 / 12, 4, -3, 4.0 / 3, -1.0 / 4},
                                     {-1.0 / 4, -5.0 / 6, 3.0 / 2, -1.0 / 2, 1.0 / 12},
                                     {1.0 / 12, -2.0 / 3, 0, 2.0 / 3, -1.0 / 12}};
  for (int k = 0; k < 5; k++) w[k] = at <= 2 ? table[at][k] : -table[4 - at][4 - k];
}

/* Angles follow the positions (they are in equilibrium at every point that is looked at), so the derivative
 * is a total one in them, and their own rows are 0. */
hb_status hb_branch_differentiate(hb_branch *b, hb_error *err) {
  hb_statics *s = &b->s;
  double p = b->p, h = DIFFERENCE * b->range, w[5];
  int at = 2;
  while (at > 0 && p - at * h < b->lower) at--;
  while (at < 4 && p + (4 - at) * h > b->upper) at++;
  weights(at, w);
  hb_status status = HB_OK;
  hb_state_copy(b->center, s->state);
  memset(b->rate, 0, (size_t)s->kkt.matrix.n * sizeof *b->rate);
  memset(b->turns, 0, (size_t)b->rod->nv * sizeof *b->turns);
  for (int k = 0; !status && k < 5; k++) {
    if (w[k] == 0) continue;
    hb_state_copy(s->state, b->center);
    status = hb_branch_evaluate(b, p + (k - at) * h, NULL, err);
    if (status) break;
    add_equations(b, w[k] / h, b->rate);
    for (int j = 0; !b->rod->closed_form && j + 1 < b->rod->nv; j++)
      b->turns[j] += w[k] / h * s->state->spin[b->rod->first + j];
  }
  hb_state_copy(s->state, b->center);
  hb_status back = hb_branch_evaluate(b, p, NULL, status ? NULL : err);
  return status ? status : back;
}
