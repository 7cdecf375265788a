#include "solve/kkt_ring.h"

#include "base/memory.h"
#include "force/force.h"
#include "rod/hessian.h"
#include "rod/inextensible.h"

#include <float.h>
#include <string.h>

/* A pivot below this part of what it is the sum of is round-off. */
#define ROUND_OFF (32 * DBL_EPSILON)
/* A turn of all frames weighs as much as a displacement by this part of the rod's length. */
#define TURN_ARM 0.1

/* One block for all. */
hb_status hb_kkt_create(int nv, hb_kkt *k, hb_error *err) {
  size_t n = (size_t)HB_KKT_STRIDE * (size_t)nv, band = hb_band_size((int)n, HB_KKT_HALF),
         room = n + HB_KKT_HALF;
  size_t total = 2 * band + 4 * room + 14 * (size_t)nv;
  memset(k, 0, sizeof *k);
  k->block = hb_alloc(total, sizeof *k->block);
  k->unknown = hb_alloc((size_t)nv, sizeof *k->unknown);
  if (!k->block || !k->unknown) {
    hb_kkt_free(k);
    return hb_fail_memory(err, "matrix of the equilibrium");
  }
  k->capacity = nv;
  k->matrix.a = k->block;
  k->factors.a = k->block + band;
  k->weight = k->block + 2 * band;
  k->right = k->weight + room;
  k->pull = k->right + room;
  k->scratch = k->pull + room;
  k->length = k->scratch + room;
  k->load = k->length + nv;
  k->along = k->load + 9 * (size_t)nv;
  k->gradient = k->along + nv;
  k->matrix.half = k->factors.half = HB_KKT_HALF;
  k->augment = 2;
  k->bytes = total * sizeof(double) + (size_t)nv;
  return HB_OK;
}

/* Frees the arrays. */
void hb_kkt_free(hb_kkt *k) {
  hb_free(k->block);
  hb_free(k->unknown);
  hb_free(k->border_block);
  k->block = k->border_block = k->border = NULL;
  k->unknown = NULL;
}

/* Lengths for places, length times the square of an arm for turns. */
void hb_kkt_begin(hb_kkt *k, const hb_model *m, const hb_rod *rod) {
  int o = rod->first;
  double arm = TURN_ARM * rod->length;
  bool slim = k->slim && rod->twist_free && !rod->closed;
  k->closed = rod->closed;
  k->stride = slim ? HB_KKT_SLIM_STRIDE : HB_KKT_STRIDE;
  k->matrix.half = k->factors.half = slim ? HB_KKT_SLIM_HALF : HB_KKT_HALF;
  k->matrix.n = k->factors.n = k->stride * rod->nv;
  hb_rod_free_angles(m, rod, k->unknown);
  k->constraints = 0;
  for (int i = 0; i < rod->nv; i++) {
    double *w = k->weight + k->stride * i;
    const double *free = m->inv_mass + 3 * (o + i);
    bool turns = i + 1 < rod->nv && k->unknown[i], any = false;
    for (int c = 0; c < 3; c++) w[c] = free[c] != 0 ? m->weight[o + i] : 0;
    w[HB_KKT_MULTIPLIER] = 0;
    if (!slim) w[HB_KKT_TURN] = turns ? m->rest_length[o + i] * arm * arm : 0;
    for (int c = -3; i > 0 && c < 3; c++) any = any || free[c] != 0;
    k->constraints += any && !rod->extensible;
  }
  for (int p = 0; k->closed && p < HB_KKT_BORDER; p++)
    k->border_unknown[p] = k->weight[p] != 0 || (p == HB_KKT_STRIDE + HB_KKT_MULTIPLIER && !rod->extensible);
}

/* How stiff an edge is across its direction, from all that acts there: what is added along it is a multiple
 * of this. */
static double natural_stiffness(const hb_model *m, const hb_rod *rod, const hb_state *state,
                                const hb_rod_work *w, int j, double lambda) {
  int k = rod->first + j;
  double inv = m->inv_rest_length[k], stiffness = 2 * fabs(lambda) * inv;
  for (int end = j; end <= j + 1; end++) {
    int i = end == 0 && rod->closed ? rod->nv - 1 : end;
    if (i == 0 || i > rod->last_joint) continue;
    double alpha = m->alpha[rod->first + i], moment = rod->closed_form ? 0 : fabs(w->moment[i]);
    stiffness += inv * inv * (3 * alpha * inv + moment);
  }
  for (int s = rod->first_span; rod->closed_form && s < rod->first_span + rod->span_count; s++)
    if (k >= m->spans[s].first_edge && k <= m->spans[s].last_edge)
      stiffness += 2 * fabs(state->moment[s]) * inv * inv;
  return stiffness;
}

/* Gradients of the lengths, their second derivatives, and what keeps leading blocks definite (11.4). */
static void add_lengths(hb_kkt *kkt, const hb_model *m, const hb_rod *rod, const hb_state *state,
                        const hb_rod_work *work, const double *lambda) {
  hb_band *K = &kkt->matrix;
  for (int j = 0; j + 1 < rod->nv; j++) {
    int k = rod->first + j, a = kkt->stride * j, b = a + kkt->stride, row = b + HB_KKT_MULTIPLIER;
    hb_v3 gradient;
    kkt->length[j] =
        hb_inextensible_edge(state->x + 3 * k, m->rest_length[k], m->inv_rest_length[k], &gradient);
    const double *g = &gradient.x;
    /* the gradient has the size 2 */
    double along = 0.25 * kkt->augment * natural_stiffness(m, rod, state, work, j, lambda[j]);
    double across = 2 * lambda[j] * m->inv_rest_length[k];
    kkt->along[j] = along;
    hb_v3_store(kkt->gradient + 3 * j, gradient);
    for (int c = 0; c < 3; c++) {
      hb_band_add(K, row, a + c, -g[c]);
      hb_band_add(K, row, b + c, g[c]);
      for (int r = 0; r < 3; r++) {
        double value = along * g[c] * g[r] + (c == r ? across : 0);
        hb_band_add(K, b + r, a + c, -value);
        if (r < c) continue;
        hb_band_add(K, a + r, a + c, value);
        hb_band_add(K, b + r, b + c, value);
      }
    }
    double *pull = kkt->right + a; /* along * gradient * C: the multiple of the constraint itself */
    for (int c = 0; c < 3; c++) {
      pull[c] += along * kkt->length[j] * g[c];
      pull[kkt->stride + c] -= along * kkt->length[j] * g[c];
    }
    kkt->right[row] = -kkt->length[j];
  }
}

/* An extensible rod has none to keep. */
static void forget_lengths(hb_kkt *kkt, const hb_rod *rod) {
  memset(kkt->length, 0, (size_t)rod->nv * sizeof *kkt->length);
  memset(kkt->along, 0, (size_t)rod->nv * sizeof *kkt->along);
  memset(kkt->gradient, 0, 3 * (size_t)rod->nv * sizeof *kkt->gradient);
}

/* The symmetric part: loads with a potential have no other. */
static void add_loads(hb_kkt *kkt, const hb_rod *rod) {
  for (int i = 0; i < rod->nv; i++)
    for (int c = 0; c < 3; c++)
      for (int r = c; r < 3; r++)
        hb_band_add(&kkt->matrix, kkt->stride * i + r, kkt->stride * i + c,
                    0.5 * (kkt->load[9 * i + 3 * r + c] + kkt->load[9 * i + 3 * c + r]));
}

/* Row and column become those of the identity. */
static void isolate(hb_band *K, int at) {
  double *column = K->a + (size_t)(K->half + 1) * (size_t)at;
  column[0] = 1;
  for (int k = 1; k <= K->half; k++) {
    column[k] = 0;
    if (k <= at) column[k - (ptrdiff_t)(K->half + 1) * k] = 0;
  }
}

/* K times the displacements of the supports. */
static void find_pull(hb_kkt *kkt, const hb_rod *rod, const double *moved) {
  double *v = kkt->scratch;
  memset(v, 0, (size_t)kkt->matrix.n * sizeof *v);
  for (int i = 0; i < rod->nv; i++) memcpy(v + kkt->stride * i, moved + 3 * i, 3 * sizeof *v);
  hb_kkt_multiply(kkt, v, kkt->pull);
}

/* Open or closed. */
void hb_kkt_multiply(const hb_kkt *kkt, const double *v, double *out) {
  if (kkt->closed)
    hb_kkt_ring_multiply(kkt, v, out);
  else
    hb_band_multiply(&kkt->matrix, v, out);
}

/* Leaves in kkt->right what the constraints put there: -C, and the pull of the added stiffness. */
void hb_kkt_assemble(hb_kkt *kkt, const hb_model *model, const hb_rod *rod, const hb_state *state,
                     const hb_rod_work *work, double t, const double *lambda, const double *moved) {
  hb_band_clear(&kkt->matrix);
  memset(kkt->right, 0, (size_t)kkt->matrix.n * sizeof *kkt->right);
  hb_rod_hessian(model, rod, state, work, kkt->stride, &kkt->matrix);
  if (hb_load_stiffness(model, rod, t, state->x, kkt->load)) add_loads(kkt, rod);
  if (rod->extensible)
    forget_lengths(kkt, rod);
  else
    add_lengths(kkt, model, rod, state, work, lambda);
  if (moved) find_pull(kkt, rod, moved);
  int last = kkt->matrix.n - (kkt->closed ? kkt->stride : 0); /* the last slot of a closed rod is the first */
  for (int k = 0; k < last; k++) {
    bool multiplier = k % kkt->stride == HB_KKT_MULTIPLIER && k >= kkt->stride && !rod->extensible;
    if (multiplier || kkt->weight[k] != 0) continue;
    isolate(&kkt->matrix, k);
    kkt->right[k] = 0;
  }
  if (kkt->closed && rod->extensible) isolate(&kkt->matrix, last + HB_KKT_MULTIPLIER);
}

/* Rows of the identity stay such. */
void hb_kkt_add_motion(hb_kkt *kkt, const hb_model *model, const hb_rod *rod, double inertia,
                       const double *drag, double rate) {
  for (int i = 0; i < rod->nv; i++) {
    int at = kkt->stride * i;
    for (int c = 0; c < 3; c++) {
      if (kkt->weight[at + c] == 0) continue;
      hb_band_add(&kkt->matrix, at + c, at + c, inertia * model->mass[rod->first + i]);
      for (int r = c; drag && r < 3; r++)
        if (kkt->weight[at + r] != 0)
          hb_band_add(&kkt->matrix, at + r, at + c, rate * drag[9 * i + 3 * r + c]);
    }
  }
}

/* Pivots of edges between prescribed vertices are 0 and count as dropped; they are no constraints. */
int hb_kkt_factor(hb_kkt *k, double shift) {
  if (k->closed) return hb_kkt_ring_factor(k, shift) - k->constraints;
  size_t width = (size_t)k->matrix.half + 1;
  memcpy(k->factors.a, k->matrix.a, hb_band_size(k->matrix.n, k->matrix.half) * sizeof(double));
  for (int j = 0; j < k->matrix.n; j++) k->factors.a[width * (size_t)j] += shift * k->weight[j];
  hb_inertia found = hb_band_factor(&k->factors, ROUND_OFF, k->scratch);
  return found.negative - k->constraints;
}

/* Forwards and backwards. */
void hb_kkt_solve(hb_kkt *k) {
  if (k->closed)
    hb_kkt_ring_solve(k);
  else
    hb_band_solve(&k->factors, k->right);
}
