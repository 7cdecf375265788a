#include "solve/project.h"

#include "base/memory.h"
#include "rod/inextensible.h"

#include <string.h>

/* Rows whose pivot falls below this part of its diagonal hang on the others: no room to move. */
#define SINGULAR 1e-13

/* Arrays for the longest rod. */
hb_status hb_project_work_create(const hb_model *model, hb_project_work *w, hb_error *err) {
  size_t n = 0;
  for (int r = 0; r < model->rod_count; r++)
    if ((size_t)model->rods[r].nv > n) n = (size_t)model->rods[r].nv;
  w->block = hb_alloc(9 * n, sizeof *w->block);
  if (!w->block) return hb_fail_memory(err, "workspace of the projection");
  w->gradient = w->block;
  w->direction = w->block + 3 * n;
  w->pivot = w->block + 6 * n;
  w->upper = w->block + 7 * n;
  w->right = w->block + 8 * n;
  w->bytes = 9 * n * sizeof *w->block;
  return HB_OK;
}

void hb_project_work_free(hb_project_work *w) {
  hb_free(w->block);
  w->block = NULL;
}

/* sum over coordinates of a_c w_c b_c. */
static inline double weighted(hb_v3 a, const double *w, hb_v3 b) {
  return a.x * w[0] * b.x + a.y * w[1] * b.y + a.z * w[2] * b.z;
}

/* Assembles and eliminates row by row, from the first edge: J lambda = C. along: directions differ from gradients.
 * Returns the largest |C_j| times scale_j (relative: 1/length) and where. *full: every row has a sound pivot. */
static inline double forward(const hb_model *m, const hb_rod *rod, const double *x, hb_project_work *w, bool along,
                             bool relative, int *edge, bool *full) {
  double worst = -1, inv_before = 0, right_before = 0;
  hb_v3 g_before = {0, 0, 0}, d_before = {0, 0, 0};
  *full = true;
  for (int j = 0, k = rod->first; j + 1 < rod->nv; j++, k++) {
    const double *mass = m->inv_mass + 3 * k;
    double inv_rest = m->inv_rest_length[k];
    hb_v3 g;
    double C = hb_inextensible_edge(x + 3 * k, m->rest_length[k], inv_rest, &g);
    hb_v3 d = along ? hb_v3_load(w->direction + 3 * j) : g;
    double size = fabs(C) * (relative ? inv_rest : 1);
    if (!(size <= worst)) { /* also true for not-a-number */
      worst = size;
      *edge = k;
    }
    double diagonal = weighted(g, mass, d) + weighted(g, mass + 3, d);
    double lower = -weighted(g, mass, d_before);
    double upper = along ? -weighted(g_before, mass, d) : lower; /* entry (j-1, j) */
    double ratio = lower * inv_before;
    double pivot = diagonal - ratio * upper, right = C - ratio * right_before;
    bool sound = fabs(pivot) > SINGULAR * fabs(diagonal) && diagonal != 0;
    double inv = sound ? 1 / pivot : 0;
    *full = *full && sound;
    hb_v3_store(w->gradient + 3 * j, g);
    w->pivot[j] = inv;
    w->upper[j] = upper;
    w->right[j] = right;
    inv_before = inv;
    right_before = right;
    g_before = g;
    d_before = d;
  }
  return worst;
}

/* Back substitution and correction: x and v move by -w D^T lambda. Returns what is left of |C_j| after that: the
 * constraint is quadratic, its linear part is solved, so exactly |delta e|^2/|e-bar| remains. */
static inline double backward(const hb_model *m, const hb_rod *rod, double *x, double *v, double inv_h,
                              const double *direction, hb_project_work *w, double *lambda, bool relative) {
  int ne = rod->nv - 1, o = rod->first;
  double after = 0, next = 0, left = 0;
  hb_v3 pull_next = {0, 0, 0}, moved_next = {0, 0, 0};
  for (int j = ne - 1; j >= -1; j--) {
    double own = 0;
    hb_v3 pull = {0, 0, 0};
    if (j >= 0) {
      own = (w->right[j] - (j + 1 < ne ? w->upper[j + 1] * next : 0)) * w->pivot[j];
      pull = hb_v3_scale(own, hb_v3_load(direction + 3 * j));
      if (lambda) lambda[o + j] += own;
    }
    int k = 3 * (o + j + 1); /* vertex j+1 feels edge j and edge j+1 */
    const double *mass = m->inv_mass + k;
    hb_v3 moved = {-mass[0] * (pull.x - pull_next.x), -mass[1] * (pull.y - pull_next.y),
                   -mass[2] * (pull.z - pull_next.z)};
    hb_v3_accumulate(x + k, moved);
    hb_v3_accumulate(v + k, hb_v3_scale(inv_h, moved));
    if (j + 1 < ne) {
      hb_v3 change = hb_v3_sub(moved_next, moved);
      double inv_rest = m->inv_rest_length[o + j + 1];
      left = hb_v3_dot(change, change) * inv_rest * (relative ? inv_rest : 1);
      after = left > after ? left : after;
    }
    moved_next = moved;
    pull_next = pull;
    next = own;
  }
  return after;
}

/* First guess: the corrections of the last step once more. */
static void warm_start(const hb_model *m, const hb_rod *rod, double *x, double *v, double inv_h, const double *lambda,
                       const hb_project_work *w) {
  hb_v3 before = {0, 0, 0};
  for (int j = 0; j < rod->nv; j++) {
    int k = rod->first + j;
    hb_v3 pull = {0, 0, 0};
    if (j + 1 < rod->nv) pull = hb_v3_scale(lambda[k], hb_v3_load(w->direction + 3 * j));
    const double *mass = m->inv_mass + 3 * k;
    hb_v3 moved = {-mass[0] * (before.x - pull.x), -mass[1] * (before.y - pull.y), -mass[2] * (before.z - pull.z)};
    hb_v3_accumulate(x + 3 * k, moved);
    hb_v3_accumulate(v + 3 * k, hb_v3_scale(inv_h, moved));
    before = pull;
  }
}

/* The sentence for a projection that did not end. */
static hb_status not_converged(const hb_model *m, const hb_rod *rod, const hb_projection *p, hb_error *err) {
  int j = p->edge - rod->first;
  if (!(p->error >= 0 && p->error < HUGE_VAL))
    return hb_fail(err, HB_ERR_NUMERIC, "rod %s: edge %d has a length that is not finite", rod->name, j);
  return hb_fail(err, HB_ERR_NUMERIC,
                 "rod %s: inextensibility did not converge in %d iterations: edge %d is still off by %.3g (allowed: %.3g %s)",
                 rod->name, p->iterations, j, p->error, m->def->method.length_tolerance,
                 m->def->method.length_tolerance_kind == HB_TOLERANCE_RELATIVE ? "of its length" : "absolute");
}

/* Newton on the lengths. */
hb_status hb_project_positions(const hb_model *model, const hb_rod *rod, double *x, double *v, double h,
                               const double *x_old, double *lambda, hb_project_work *w, hb_projection *result,
                               hb_error *err) {
  const hb_method_def *method = &model->def->method;
  bool relative = method->length_tolerance_kind == HB_TOLERANCE_RELATIVE;
  double inv_h = 1 / h, left = HUGE_VAL;
  *result = (hb_projection){0, 0, rod->first};
  if (x_old) {
    for (int j = 0, k = rod->first; j + 1 < rod->nv; j++, k++) {
      hb_v3 d;
      (void)hb_inextensible_edge(x_old + 3 * k, model->rest_length[k], model->inv_rest_length[k], &d);
      hb_v3_store(w->direction + 3 * j, d);
    }
    if (lambda) warm_start(model, rod, x, v, inv_h, lambda, w);
  } else if (lambda) {
    memset(lambda + rod->first, 0, (size_t)rod->nv * sizeof *lambda);
  }
  for (;;) {
    bool full = true;
    double error = x_old ? forward(model, rod, x, w, true, relative, &result->edge, &full)
                         : forward(model, rod, x, w, false, relative, &result->edge, &full);
    result->error = error;
    if (error <= method->length_tolerance) return HB_OK;
    if (!(error < HUGE_VAL) || result->iterations >= method->max_projections)
      return not_converged(model, rod, result, err);
    left = backward(model, rod, x, v, inv_h, x_old ? w->direction : w->gradient, w, lambda, relative);
    result->iterations++;
    /* Nothing but round-off beyond what is left by the quadratic term: no need to look again. */
    if (full && left <= 0.25 * method->length_tolerance && error < 1e-2 && method->length_tolerance >= 1e-12) {
      result->error = left;
      return HB_OK;
    }
  }
}

/* One linear solve G M^-1 G^T mu = G v. */
void hb_project_velocities(const hb_model *m, const hb_rod *rod, const double *x, double *v, hb_project_work *w) {
  int ne = rod->nv - 1, edge;
  bool full;
  (void)forward(m, rod, x, w, false, true, &edge, &full);
  double before = 0;
  for (int j = 0; j < ne; j++) { /* the elimination once more, for the velocities' right-hand side */
    int k = 3 * (rod->first + j);
    hb_v3 rate = hb_v3_sub(hb_v3_load(v + k + 3), hb_v3_load(v + k));
    double ratio = j > 0 ? w->upper[j] * w->pivot[j - 1] : 0;
    before = hb_v3_dot(hb_v3_load(w->gradient + 3 * j), rate) - ratio * before;
    w->right[j] = before;
  }
  double next = 0;
  hb_v3 pull_next = {0, 0, 0};
  for (int j = ne - 1; j >= -1; j--) {
    double own = j >= 0 ? (w->right[j] - (j + 1 < ne ? w->upper[j + 1] * next : 0)) * w->pivot[j] : 0;
    hb_v3 pull = j >= 0 ? hb_v3_scale(own, hb_v3_load(w->gradient + 3 * j)) : (hb_v3){0, 0, 0};
    int k = 3 * (rod->first + j + 1);
    const double *mass = m->inv_mass + k;
    v[k] -= mass[0] * (pull.x - pull_next.x);
    v[k + 1] -= mass[1] * (pull.y - pull_next.y);
    v[k + 2] -= mass[2] * (pull.z - pull_next.z);
    if (j >= 0) w->right[j] = own;
    pull_next = pull;
    next = own;
  }
}

/* Acceleration of one vertex without constraints: prescribed where the inverse mass is 0. */
static hb_v3 free_acceleration(const hb_model *m, int slot, const double *f, const double *a) {
  double out[3];
  for (int c = 0; c < 3; c++) {
    int k = 3 * slot + c;
    out[c] = m->inv_mass[k] == 0 ? a[k] : m->inv_mass[k] * f[k];
  }
  return hb_v3_load(out);
}

/* G M^-1 G^T lambda = G a + 2 |de/dt|^2/|e-bar|. */
void hb_project_tension(const hb_model *m, const hb_rod *rod, const double *x, const double *v, const double *f,
                        const double *a, double *lambda, hb_project_work *w) {
  int ne = rod->nv - 1, edge;
  bool full;
  (void)forward(m, rod, x, w, false, true, &edge, &full);
  double before = 0;
  for (int j = 0; j < ne; j++) {
    int k = rod->first + j;
    hb_v3 rate = hb_v3_sub(hb_v3_load(v + 3 * k + 3), hb_v3_load(v + 3 * k));
    hb_v3 acceleration = hb_v3_sub(free_acceleration(m, k + 1, f, a), free_acceleration(m, k, f, a));
    double right = hb_v3_dot(hb_v3_load(w->gradient + 3 * j), acceleration) +
                   2 * m->inv_rest_length[k] * hb_v3_dot(rate, rate);
    double ratio = j > 0 ? w->upper[j] * w->pivot[j - 1] : 0;
    before = right - ratio * before;
    w->right[j] = before;
  }
  double next = 0;
  for (int j = ne - 1; j >= 0; j--) {
    next = (w->right[j] - (j + 1 < ne ? w->upper[j + 1] * next : 0)) * w->pivot[j];
    lambda[j] = next;
  }
}

/* ||e|/|e-bar| - 1|. */
double hb_project_length_error(const hb_model *m, const hb_rod *rod, const double *x) {
  double worst = 0;
  for (int k = rod->first; k + 1 < rod->first + rod->nv; k++) {
    hb_v3 e = hb_v3_sub(hb_v3_load(x + 3 * k + 3), hb_v3_load(x + 3 * k));
    worst = fmax(worst, fabs(hb_v3_norm(e) * m->inv_rest_length[k] - 1));
  }
  return worst;
}
