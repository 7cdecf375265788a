#include "solve/project_parts.h"

#include "base/memory.h"
#include "rod/inextensible.h"

#include <string.h>

/* Each use of these has constants in its arguments; only inlined is it compiled for them (10 % of a step). */
#define INLINED static inline __attribute__((always_inline))

/* Along fixed directions the lengths may have no solution at all; Newton that has not converged by then never
 * will. */
#define SHAKE_ITERATIONS 16

/* Arrays for the longest rod. */
hb_status hb_project_work_create(const hb_model *model, hb_project_work *w, hb_error *err) {
  size_t n = 0;
  for (int r = 0; r < model->rod_count; r++)
    if ((size_t)model->rods[r].nv > n) n = (size_t)model->rods[r].nv;
  size_t count = 10 * n + 3 * (size_t)model->position_count;
  w->block = hb_alloc(count, sizeof *w->block);
  if (!w->block) return hb_fail_memory(err, "workspace of the projection");
  w->gradient = w->block;
  w->direction = w->block + 3 * n;
  w->pivot = w->block + 6 * n;
  w->link = w->block + 7 * n;
  w->right = w->block + 8 * n;
  w->corner = w->block + 9 * n;
  w->support_pull = w->block + 10 * n;
  w->bytes = count * sizeof *w->block;
  return HB_OK;
}

/* Frees the arrays. */
void hb_project_work_free(hb_project_work *w) {
  hb_free(w->block);
  w->block = NULL;
}

/* One elimination: from either end towards the middle, so that two chains of divisions run side by side. */
typedef struct chain {
  hb_v3 g, d;        /* gradient and direction of the row before */
  double inv, right; /* its 1/pivot and right-hand side */
} chain;

/* Row j: gradient, diagonal, elimination of the row before it (j-1 if forwards, else j+1). The link to that
 * row is kept: the entry by which the row before needs this row's unknown in the back substitution. */
INLINED void eliminate(const hb_length_system *s, int j, bool forwards, chain *c, hb_length_finding *found) {
  int k = s->rod->first + j;
  const double *mass = s->m->inv_mass + 3 * k, *shared = forwards ? mass : mass + 3;
  double inv_rest = s->m->inv_rest_length[k], right;
  hb_v3 g;
  double C = hb_inextensible_edge(s->x + 3 * k, s->m->rest_length[k], inv_rest, &g);
  hb_v3 d = s->along ? hb_v3_load(s->w->direction + 3 * j) : g;
  if (s->kind == HB_RIGHT_LENGTHS) {
    double size = fabs(C) * (s->relative ? inv_rest : 1);
    right = C;
    if (!(size <= found->worst)) { /* also true for not-a-number */
      found->worst = size;
      found->edge = k;
    }
  } else if (s->kind == HB_RIGHT_RATES) {
    right = hb_v3_dot(g, hb_v3_sub(hb_v3_load(s->v + 3 * k + 3), hb_v3_load(s->v + 3 * k)));
  } else {
    right = s->w->right[j];
  }
  double diagonal = hb_weighted(g, mass, d) + hb_weighted(g, mass + 3, d);
  double to_before = -hb_weighted(g, shared, c->d);                          /* entry (this, before) */
  double from_before = s->along ? -hb_weighted(c->g, shared, d) : to_before; /* entry (before, this) */
  double ratio = to_before * c->inv;
  double pivot = diagonal - ratio * from_before;
  right -= ratio * c->right;
  bool sound = fabs(pivot) > HB_LENGTH_SINGULAR * fabs(diagonal);
  double inv = sound ? 1 / pivot : 0;
  found->full = found->full && sound;
  hb_v3_store(s->w->gradient + 3 * j, g);
  s->w->pivot[j] = inv;
  s->w->link[j] = from_before;
  s->w->right[j] = right;
  *c = (chain){g, d, inv, right};
}

/* Eliminates from both ends and solves the two rows that meet in the middle. The right-hand sides of those
 * two become their unknowns; all others wait for spread(). */
INLINED hb_length_finding meet(const hb_length_system *s) {
  int ne = s->rod->nv - 1, half = ne / 2;
  chain a = {{0, 0, 0}, {0, 0, 0}, 0, 0}, b = a;
  hb_length_finding found = {-1, s->rod->first, true};
  for (int j = 0; j < half; j++) {
    eliminate(s, j, true, &a, &found);
    eliminate(s, ne - 1 - j, false, &b, &found);
  }
  if (2 * half < ne)
    eliminate(s, half, false, &b, &found); /* the row that is left over goes to the right half */
  const double *shared = s->m->inv_mass + 3 * (s->rod->first + half);
  double up = -hb_weighted(a.g, shared, b.d),
         low = -hb_weighted(b.g, shared, a.d); /* entries (half-1, half), (half, half-1) */
  double ratio = low * a.inv, pivot = (b.inv != 0 ? 1 / b.inv : 0) - ratio * up;
  bool sound = b.inv != 0 && fabs(pivot) > HB_LENGTH_SINGULAR * fabs(1 / b.inv);
  double unknown = sound ? (b.right - ratio * a.right) / pivot : 0;
  found.full = found.full && sound;
  s->w->right[half] = unknown;
  s->w->right[half - 1] = (a.right - up * unknown) * a.inv;
  return found;
}

/* Moves vertex slot k by -w (pull of the edge before it - pull of the edge after it). */
static inline hb_v3 move(const hb_model *m, const hb_length_effect *e, int k, hb_v3 before, hb_v3 after) {
  const double *mass = m->inv_mass + 3 * k;
  hb_v3 moved = {-mass[0] * (before.x - after.x), -mass[1] * (before.y - after.y),
                 -mass[2] * (before.z - after.z)};
  if (e->x) hb_v3_accumulate(e->x + 3 * k, hb_v3_scale(e->x_part, moved));
  hb_v3_accumulate(e->v + 3 * k, hb_v3_scale(e->v_part, moved));
  return moved;
}

/* Back substitution on its way from the middle to one end. */
typedef struct wave {
  double unknown;    /* of the edge just done */
  hb_v3 pull, moved; /* what that edge pulls with; how its inner vertex moved */
} wave;

/* What is left of |C| of an edge whose ends moved: |delta e|^2/|e-bar|. */
INLINED double left_of(const hb_model *m, const hb_length_effect *e, int slot, hb_v3 a, hb_v3 b) {
  if (!e->judged) return 0;
  hb_v3 change = hb_v3_sub(a, b);
  double inv_rest = m->inv_rest_length[slot];
  return hb_v3_dot(change, change) * inv_rest * (e->relative ? inv_rest : 1);
}

/* Edge j, whose neighbour towards the middle, inner, is done: its unknown, and the vertex between the two.
 * outwards: +1 to the last edge, -1 to the first. Returns what is left of |C| of the inner edge. */
INLINED double advance(const hb_model *m, const hb_rod *rod, hb_project_work *w, const hb_length_effect *e,
                       int j, int outwards, wave *now) {
  int inner = j - outwards, o = rod->first;
  double unknown = (w->right[j] - w->link[inner] * now->unknown) * w->pivot[j];
  hb_v3 pull = hb_v3_scale(unknown, hb_v3_load(e->direction + 3 * j)), before = now->moved;
  hb_v3 moved = outwards > 0 ? move(m, e, o + j, now->pull, pull) : move(m, e, o + inner, pull, now->pull);
  if (e->lambda) e->lambda[j] += unknown;
  w->right[j] = unknown;
  *now = (wave){unknown, pull, moved};
  return left_of(m, e, o + inner, moved, before);
}

/* The vertex at the end: nothing pulls beyond it. */
INLINED double arrive(const hb_model *m, const hb_rod *rod, const hb_length_effect *e, int outwards,
                      const wave *now) {
  int edge = outwards > 0 ? rod->nv - 2 : 0, vertex = outwards > 0 ? rod->nv - 1 : 0, o = rod->first;
  hb_v3 none = {0, 0, 0};
  hb_v3 moved =
      outwards > 0 ? move(m, e, o + vertex, now->pull, none) : move(m, e, o + vertex, none, now->pull);
  return left_of(m, e, o + edge, moved, now->moved);
}

/* Back substitution from the middle to both ends, corrections on the way. Returns the largest |C_j| that is
 * left if the corrections were lengths': the constraint is quadratic, its linear part is solved, so |delta
 * e|^2/|e-bar| remains. */
INLINED double spread(const hb_model *m, const hb_rod *rod, hb_project_work *w, const hb_length_effect *e) {
  int ne = rod->nv - 1, o = rod->first, half = ne / 2;
  double after = 0, a = w->right[half - 1], b = w->right[half];
  wave left = {a, hb_v3_scale(a, hb_v3_load(e->direction + 3 * (half - 1))), {0, 0, 0}};
  wave right = {b, hb_v3_scale(b, hb_v3_load(e->direction + 3 * half)), {0, 0, 0}};
  left.moved = right.moved = move(m, e, o + half, left.pull, right.pull);
  if (e->lambda) {
    e->lambda[half - 1] += a;
    e->lambda[half] += b;
  }
  for (int i = 1; i < half; i++) {
    double here = advance(m, rod, w, e, half - 1 - i, -1, &left);
    double there = advance(m, rod, w, e, half + i, 1, &right);
    here = here > there ? here : there;
    after = here > after ? here : after;
  }
  if (2 * half < ne) after = fmax(after, advance(m, rod, w, e, ne - 1, 1, &right));
  return fmax(after, fmax(arrive(m, rod, e, -1, &left), arrive(m, rod, e, 1, &right)));
}

/* Directions of all corrections: the gradients at x_old. With multipliers of the last step, the first guess:
 * its corrections once more. */
static void set_directions(const hb_model *m, const hb_rod *rod, const double *x_old, double *x, double *v,
                           double inv_h, const double *lambda, hb_project_work *w) {
  const hb_length_effect guess = {x, v, 1, inv_h, w->direction, NULL, false, false};
  const bool ring = rod->closed;
  hb_v3 before = {0, 0, 0};
  for (int j = 0, k = rod->first; j + 1 < rod->nv; j++, k++) {
    hb_v3 d;
    (void)hb_inextensible_edge(x_old + 3 * k, m->rest_length[k], m->inv_rest_length[k], &d);
    hb_v3_store(w->direction + 3 * j, d);
    if (!lambda || ring) continue;
    hb_v3 pull = hb_v3_scale(lambda[k], d);
    (void)move(m, &guess, k, before, pull);
    before = pull;
  }
  if (lambda && ring)
    (void)hb_ring_apply(m, rod, lambda + rod->first, &guess);
  else if (lambda)
    (void)move(m, &guess, rod->first + rod->nv - 1, before, (hb_v3){0, 0, 0});
}

/* The pull of the multipliers (by edge of the rod) along the fixed directions on the rod's prescribed
 * vertices. */
static void keep_support_pulls(const hb_model *m, const hb_rod *rod, hb_project_work *w,
                               const double *multipliers) {
  const double *directions = w->direction;
  for (int n = rod->first_position; n < rod->first_position + rod->position_count; n++) {
    int i = m->positions[n].slot - rod->first;
    for (int c = 0; c < 3; c++) {
      double before = i > 0 ? multipliers[i - 1] * directions[3 * (i - 1) + c] : 0;
      double after = i + 1 < rod->nv ? multipliers[i] * directions[3 * i + c] : 0;
      w->support_pull[3 * n + c] = after - before;
    }
  }
}

/* The three eliminations, each compiled for its own case. */
static hb_length_finding meet_along(const hb_length_system *s) {
  hb_length_system fixed = *s;
  fixed.along = true;
  fixed.kind = HB_RIGHT_LENGTHS;
  return s->rod->closed ? hb_ring_solve(&fixed) : meet(&fixed);
}

/* Along the gradient itself: symmetric. */
static hb_length_finding meet_gradient(const hb_length_system *s) {
  hb_length_system fixed = *s;
  fixed.along = false;
  fixed.kind = HB_RIGHT_LENGTHS;
  return s->rod->closed ? hb_ring_solve(&fixed) : meet(&fixed);
}

/* For velocities. */
static hb_length_finding meet_rates(const hb_length_system *s) {
  hb_length_system fixed = *s;
  fixed.along = false;
  fixed.kind = HB_RIGHT_RATES;
  return s->rod->closed ? hb_ring_solve(&fixed) : meet(&fixed);
}

/* Is the rod pulled straight between neighbouring vertices that are wholly prescribed? */
static bool is_taut(const hb_model *m, const hb_rod *rod, const double *x) {
  int last = -1;
  for (int k = rod->first; k < rod->first + rod->nv; k++) {
    const double *mass = m->inv_mass + 3 * k;
    if (mass[0] != 0 || mass[1] != 0 || mass[2] != 0) continue;
    if (last >= 0 && k > last + 1) {
      double distance = hb_v3_norm(hb_v3_sub(hb_v3_load(x + 3 * k), hb_v3_load(x + 3 * last)));
      if (distance > (1 - 1e-4) * (m->arc[k] - m->arc[last])) return true;
    }
    last = k;
  }
  return false;
}

/* The sentence for a projection that did not end. */
static hb_status not_converged(const hb_model *m, const hb_rod *rod, const double *x, const hb_projection *p,
                               hb_error *err) {
  int j = p->edge - rod->first;
  if (!(p->error >= 0 && p->error < HUGE_VAL))
    return hb_fail(err, HB_ERR_NUMERIC, "rod %s: edge %d has a length that is not finite", rod->name, j);
  return hb_fail(err, HB_ERR_NUMERIC,
                 "rod %s: inextensibility did not converge in %d iterations: edge %d is still off by %.3g "
                 "(allowed: %.3g %s)%s",
                 rod->name, p->iterations, j, p->error, m->def->method.length_tolerance,
                 m->def->method.length_tolerance_kind == HB_TOLERANCE_RELATIVE ? "of its length" : "absolute",
                 p->singular && is_taut(m, rod, x)
                     ? "; the rod is straight and taut between its supports, so nothing says to which "
                       "side it should give: let the initial shape bend a little (initial: displace "
                       "or perturb) and the supports start softly"
                     : "");
}

/* Newton on the lengths, from where the first guess is. */
static hb_status iterate(const hb_model *model, const hb_rod *rod, double *x, double *v, double h, bool along,
                         double *lambda, hb_project_work *w, hb_projection *result, hb_error *err) {
  const hb_method_def *method = &model->def->method;
  bool relative = method->length_tolerance_kind == HB_TOLERANCE_RELATIVE;
  const hb_length_system lengths = {model, rod, x, v, w, along, relative, HB_RIGHT_LENGTHS};
  int limit =
      along && method->max_projections > SHAKE_ITERATIONS ? SHAKE_ITERATIONS : method->max_projections;
  const hb_length_effect correction = {
      x,        v,   1, 1 / h, along ? w->direction : w->gradient, lambda ? lambda + rod->first : NULL,
      relative, true};
  for (;;) {
    hb_length_finding found = along ? meet_along(&lengths) : meet_gradient(&lengths);
    result->error = found.worst;
    result->edge = found.edge;
    result->singular = !found.full;
    if (found.worst <= method->length_tolerance) return HB_OK;
    if (!(found.worst < HUGE_VAL) || result->iterations >= limit)
      return not_converged(model, rod, x, result, err);
    double left =
        rod->closed ? hb_ring_apply(model, rod, w->right, &correction) : spread(model, rod, w, &correction);
    result->iterations++;
    /* Nothing but round-off beyond what is left by the quadratic term: no need to look again. */
    if (found.full && left <= 0.25 * method->length_tolerance && found.worst < 1e-2 &&
        method->length_tolerance >= 1e-12) {
      result->error = left;
      return HB_OK;
    }
  }
}

/* No edge of an extensible rod is kept by a constraint: no multipliers, no pull. */
static void free_lengths(const hb_rod *rod, double *lambda, hb_project_work *w) {
  memset(w->right, 0, (size_t)rod->nv * sizeof *w->right);
  memset(w->support_pull + 3 * rod->first_position, 0, 3 * (size_t)rod->position_count * sizeof(double));
  if (lambda) memset(lambda + rod->first, 0, (size_t)rod->nv * sizeof *lambda);
}

/* First guess, iteration, and what it pulled the supports by. */
hb_status hb_project_positions(const hb_model *model, const hb_rod *rod, double *x, double *v, double h,
                               const double *x_old, double *lambda, hb_project_work *w, hb_projection *result,
                               hb_error *err) {
  *result = (hb_projection){0, 0, rod->first, false};
  if (rod->extensible) {
    free_lengths(rod, lambda, w);
    return HB_OK;
  }
  if (x_old && lambda)
    for (int k = rod->first; k + 1 < rod->first + rod->nv; k++) lambda[k] *= 0.5 * model->rest_length[k];
  if (x_old) {
    set_directions(model, rod, x_old, x, v, 1 / h, lambda, w);
  } else if (lambda) {
    memset(lambda + rod->first, 0, (size_t)rod->nv * sizeof *lambda);
  }
  hb_status status = iterate(model, rod, x, v, h, x_old != NULL, lambda, w, result, err);
  if (!x_old || !lambda) return status;
  keep_support_pulls(model, rod, w, lambda + rod->first);
  for (int k = rod->first; k + 1 < rod->first + rod->nv; k++) lambda[k] *= 2 * model->inv_rest_length[k];
  return status;
}

/* One linear solve G M^-1 G^T mu = G v. */
void hb_project_velocities(const hb_model *m, const hb_rod *rod, const double *x, double *v,
                           hb_project_work *w) {
  if (rod->extensible) {
    memset(w->right, 0, (size_t)rod->nv * sizeof *w->right);
    return;
  }
  const hb_length_system rates = {m, rod, x, v, w, false, true, HB_RIGHT_RATES};
  const hb_length_effect correction = {NULL, v, 0, 1, w->gradient, NULL, true, false};
  (void)meet_rates(&rates);
  if (rod->closed)
    (void)hb_ring_apply(m, rod, w->right, &correction);
  else
    (void)spread(m, rod, w, &correction);
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
void hb_project_tension(const hb_model *m, const hb_rod *rod, const double *x, const double *v,
                        const double *f, const double *a, double *lambda, hb_project_work *w) {
  if (rod->extensible) {
    memset(lambda, 0, (size_t)(rod->nv - 1) * sizeof *lambda);
    return;
  }
  const hb_length_system given = {m, rod, x, v, w, false, true, HB_RIGHT_GIVEN};
  int ne = rod->nv - 1, half = ne / 2;
  for (int j = 0; j < ne; j++) {
    int k = rod->first + j;
    hb_v3 rate = hb_v3_sub(hb_v3_load(v + 3 * k + 3), hb_v3_load(v + 3 * k)), g;
    hb_v3 acceleration = hb_v3_sub(free_acceleration(m, k + 1, f, a), free_acceleration(m, k, f, a));
    (void)hb_inextensible_edge(x + 3 * k, m->rest_length[k], m->inv_rest_length[k], &g);
    w->right[j] = hb_v3_dot(g, acceleration) + 2 * m->inv_rest_length[k] * hb_v3_dot(rate, rate);
  }
  if (rod->closed) {
    (void)hb_ring_solve(&given);
    memcpy(lambda, w->right, (size_t)ne * sizeof *lambda);
    return;
  }
  (void)meet(&given);
  lambda[half - 1] = w->right[half - 1];
  lambda[half] = w->right[half];
  for (int j = half - 2; j >= 0; j--)
    lambda[j] = (w->right[j] - w->link[j + 1] * lambda[j + 1]) * w->pivot[j];
  for (int j = half + 1; j < ne; j++)
    lambda[j] = (w->right[j] - w->link[j - 1] * lambda[j - 1]) * w->pivot[j];
}

/* ||e|/|e-bar| - 1|. */
double hb_project_length_error(const hb_model *m, const hb_rod *rod, const double *x) {
  double worst = 0;
  for (int k = rod->first; !rod->extensible && k + 1 < rod->first + rod->nv; k++) {
    hb_v3 e = hb_v3_sub(hb_v3_load(x + 3 * k + 3), hb_v3_load(x + 3 * k));
    worst = fmax(worst, fabs(hb_v3_norm(e) * m->inv_rest_length[k] - 1));
  }
  return worst;
}
