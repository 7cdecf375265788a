/* Inextensibility in lanes (docs/theory, 6 and 10).
 *
 * With d^j the direction of a correction (the edge itself, or the edge at the start of the step) and mu_j its
 * multiplier, vertex i moves by -w_i (mu_{i-1} d^{i-1} - mu_i d^i); the row of edge j asks that
 * e^j . delta e^j = -(|e^j|^2 - |e-bar^j|^2)/2, which is tridiagonal in mu. In pieces every lane eliminates
 * its own rows and keeps the last one; these last rows are a small tridiagonal system of their own. */
#ifndef HB_LANE_PROJECT_H
#define HB_LANE_PROJECT_H

#include "lane/seam.h"

#include <math.h>

/* Rows whose pivot falls below this part of its diagonal hang on the others: no room to move. Turns with a
 * softer pivot than HB_SOFT_PIVOT of the diagonal are left to the rod's own functions. */
#ifdef HB_LANE_SINGLE
#define SINGULAR R(1e-5)
#define HB_SOFT_PIVOT 1e-4
#else
#define SINGULAR R(1e-13)
#define HB_SOFT_PIVOT 1e-9
#endif

/* The elimination on its way through the rows. */
typedef struct chain {
  v3 e, d;                /* edge and direction of the row before */
  lanes inv, right, m_up; /* its 1/pivot and right-hand side; entry of the row in front by it, over pivot */
  lanes fill, up;         /* its entries with the unknown in front of the piece */
  lanes schur_d, schur_r; /* what the piece takes from the row in front of it */
  lanes worst, sound;
  lanes sum; /* of length errors: not a number if one of them is none */
} chain;

/* What the rows are. */
typedef struct rows_of {
  hb_strip *s;
  bool pieces, along, rates;
} rows_of;

/* What makes (|e|^2 - |e-bar|^2)/2 of row r the length error that the tolerance speaks of: 2/|e-bar|^2 or
 * 2/|e-bar|. */
INLINED lanes judge_of(const hb_strip *s, int r) {
  lanes inv = ((const lanes *)s->inv_rest)[r + 1];
  const hb_real part = s->relative ? 1 : 0; /* no question per row */
  return inv * fused(all(2 * part), inv, all(2 - 2 * part));
}

/* Right-hand side of row r: what the length, or its rate, is off by. */
INLINED lanes wanted(const rows_of *q, int r, v3 e, bool tail, chain *c) {
  const hb_strip *s = q->s;
  if (q->rates) {
    lanes rate = v3_dot(e, edge_of(s->v, r));
    return tail ? only(real_edges(s, r), rate) : rate;
  }
  lanes off = fused_less(all(R(0.5)), v3_dot(e, e), ((const lanes *)s->half_rest2)[r]);
  if (tail) off = only(real_edges(s, r), off);
  lanes size = size_of(off) * judge_of(s, r);
  c->worst = larger(size, c->worst);
  c->sum += size;
  return off;
}

/* Before the first row. */
INLINED chain new_chain(void) {
  return (chain){.e = v3_zero(),
                 .d = v3_zero(),
                 .inv = none(),
                 .right = none(),
                 .m_up = none(),
                 .fill = none(),
                 .up = none(),
                 .schur_d = none(),
                 .schur_r = none(),
                 .worst = none(),
                 .sound = all(1),
                 .sum = none()};
}

/* Row r of a tridiagonal system (low: its entry with the row before, link: the other way round; both with
 * their signs turned); that row is taken out of it. The last row of a piece is only prepared. definite:
 * pivots are to be positive. */
INLINED void take_out(hb_strip *s, bool pieces, int r, lanes diagonal, lanes low, lanes link, lanes right,
                      bool last, bool definite, chain *c) {
  lanes ratio = low * c->inv, pivot = less_fused(diagonal, ratio, link);
  right = fused(ratio, c->right, right);
  if (pieces) {
    bool first = r == 0;
    lanes fill = first ? -low : ratio * c->fill;
    lanes above = first ? -link : c->m_up * link;
    c->schur_d = fused(c->m_up, c->fill, c->schur_d);
    c->schur_r = fused(c->m_up, c->right, c->schur_r);
    c->fill = fill;
    c->up = above;
    ((lanes *)s->fill)[r] = fill;
  }
  ((lanes *)s->link)[r] = link;
  ((lanes *)s->right)[r] = right;
  c->right = right;
  if (last) {
    *(lanes *)s->sep_pivot = pivot;
    *(lanes *)s->sep_diagonal = diagonal;
    return;
  }
  lane_mask sound =
      definite ? pivot > R(HB_SOFT_PIVOT) * diagonal : size_of(pivot) > SINGULAR * size_of(diagonal);
  lanes inv = only(sound, R(1) / pivot);
  c->sound = only(definite ? sound : sound | (diagonal == none()), c->sound);
  c->inv = inv;
  if (pieces) c->m_up = c->up * inv;
  ((lanes *)s->inv_pivot)[r] = inv;
}

/* After the last row: what the pieces leave for each other, or the last unknown. */
INLINED void finish_chain(hb_strip *s, bool pieces, const chain *c) {
  if (pieces) {
    *(lanes *)s->sep_right = c->right;
    *(lanes *)s->sep_low = c->fill;
    *(lanes *)s->sep_up = c->up;
    *(lanes *)s->schur_diagonal = c->schur_d;
    *(lanes *)s->schur_right = c->schur_r;
  } else {
    *(lanes *)s->sep = c->right * c->inv;
  }
  *(lanes *)s->full = c->sound;
}

/* Row r of the length constraints. */
INLINED void eliminate_row(const rows_of *q, int r, bool tail, bool last, chain *c) {
  hb_strip *s = q->s;
  const lanes *w = (const lanes *)s->mobility + r;
  v3 e = edge_of(s->x, r), d = q->along ? edge_of(s->x_old, r) : e;
  if (tail) {
    lane_mask real = real_edges(s, r);
    e = v3_only(real, e);
    d = v3_only(real, d);
  }
  lanes right = wanted(q, r, e, tail, c);
  lanes diagonal = (w[0] + w[1]) * v3_dot(e, d);
  lanes low = w[0] * v3_dot(e, c->d), link = q->along ? w[0] * v3_dot(c->e, d) : low;
  take_out(s, q->pieces, r, diagonal, low, link, right, last, false, c);
  c->e = e;
  c->d = d;
}

/* All rows, forwards. */
INLINED void eliminate_rows(const rows_of *q) {
  hb_strip *s = q->s;
  chain c = new_chain();
  int last = q->pieces ? s->rows - 1 : s->rows, full = s->full_rows < last ? s->full_rows : last;
  if (q->pieces) {
    c.e = edge_before(s, s->x, s->before ? s->before->x : NULL, v3_zero());
    c.d = q->along ? edge_before(s, s->x_old, s->before ? s->before->x_old : NULL, v3_zero()) : c.e;
  }
  for (int r = 0; r < full; r++) eliminate_row(q, r, false, false, &c);
  for (int r = full; r < last; r++) eliminate_row(q, r, true, false, &c);
  if (q->pieces) {
    eliminate_row(q, last, true, true, &c);
    v3_store(s->last_pull, c.d);
  }
  finish_chain(s, q->pieces, &c);
  if (!q->rates) *(lanes *)s->worst = choose(c.sum == c.sum, c.worst, c.sum);
}

/* What corrections do. */
typedef struct effect {
  hb_strip *s;
  bool pieces, along, rates;
  hb_real inv_h; /* != 0: velocities follow */
} effect;

/* Vertex r moves by -w (before - after); returns how. */
INLINED v3 move_vertex(const effect *q, int r, v3 before, v3 after) {
  hb_strip *s = q->s;
  lanes w = ((const lanes *)s->mobility)[r];
  v3 moved = v3_scale(w, v3_sub(after, before));
  lanes *v = (lanes *)s->v + 3 * r;
  if (q->rates) {
    v3_store(v, v3_add(v3_load(v), moved));
    return moved;
  }
  lanes *x = (lanes *)s->x + 3 * r;
  v3_store(x, v3_add(v3_load(x), moved));
  if (!q->along) v3_store(v, v3_axpy(v3_load(v), all(q->inv_h), moved));
  return moved;
}

/* What is left of the length of edge r after its ends have moved: |delta e|^2/2, the rest was linear. */
INLINED lanes left_of(const hb_strip *s, int r, v3 near, v3 far) {
  v3 change = v3_sub(far, near);
  lanes left = R(0.5) * v3_dot(change, change) * judge_of(s, r);
  return r < s->full_rows ? left : only(real_edges(s, r), left);
}

/* Back substitution from the last row to the first, each vertex moved when both its edges are known. */
INLINED void spread_rows(const effect *q) {
  hb_strip *s = q->s;
  int top = s->rows - 1;
  const lanes *way = q->along ? s->x_old : s->x;
  /* rods of a bundle whose lengths were found good wait for the others: they are not corrected any more */
  const bool some_wait = !q->pieces && !q->rates;
  const lane_mask moves = *(const lanes *)s->active > none();
  lanes u = *(const lanes *)s->sep, ahead = q->pieces ? *(const lanes *)s->sep_before : none();
  if (some_wait) u = only(moves, u);
  lanes left = none();
  v3 far = v3_load(way + 3 * top + 3), near = v3_load(way + 3 * top), top_pull, pull, moved;
  if (q->pieces) {
    top_pull = v3_scale(u, v3_load(s->last_pull));
  } else {
    v3 d = v3_sub(far, near);
    top_pull = v3_scale(u, top >= s->full_rows ? v3_only(real_edges(s, top), d) : d);
  }
  pull = top_pull;
  moved = v3_zero();
  if (!q->pieces) moved = move_vertex(q, s->rows, pull, v3_zero());
  if (q->along) ((lanes *)s->lambda)[top] += u;
  if (q->rates) ((lanes *)s->right)[top] = u;
  for (int r = top - 1; r >= 0; r--) {
    far = near;
    near = v3_load(way + 3 * r);
    u = fused(((const lanes *)s->link)[r + 1], u, ((const lanes *)s->right)[r]);
    if (q->pieces) u = less_fused(u, ((const lanes *)s->fill)[r], ahead);
    u *= ((const lanes *)s->inv_pivot)[r];
    if (some_wait) u = only(moves, u);
    v3 next = v3_scale(u, v3_sub(far, near)), was = moved;
    moved = move_vertex(q, r + 1, next, pull);
    if (!q->rates && (r + 1 < top || !q->pieces)) left = larger(left, left_of(s, r + 1, moved, was));
    if (q->pieces && r + 1 == top) v3_store(s->last_moved, moved);
    pull = next;
    if (q->along) ((lanes *)s->lambda)[r] += u;
    if (q->rates) ((lanes *)s->right)[r] = u; /* for the work of supports */
  }
  v3 was = moved;
  if (q->pieces) {
    v3 before = v3_load(s->last_pull);
    hb_real in[3] = {0, 0, 0};
    if (s->before)
      for (int c = 0; c < 3; c++) in[c] = ((const lanes *)s->before->last_pull)[c][HB_LANES - 1];
    before = (v3){up(before.x, in[0]), up(before.y, in[1]), up(before.z, in[2])};
    moved = move_vertex(q, 0, v3_scale(ahead, before), pull);
    v3 after = {down(pull.x, 0), down(pull.y, 0), down(pull.z, 0)};
    v3 end = move_vertex(q, s->rows, top_pull, after);
    v3_store(s->first_moved, moved);
    lanes there = left_of(s, top, v3_load(s->last_moved), end);
    if (s->after) there[HB_LANES - 1] = 0; /* join_spread knows how that end moves */
    if (!q->rates) left = larger(left, there);
  } else {
    moved = move_vertex(q, 0, v3_zero(), pull);
  }
  if (!q->rates) *(lanes *)s->left = larger(left, left_of(s, 0, moved, was));
}

/* Force along an edge, bending and twisting put together; twisting: of one unit of moment. */
INLINED v3 whole_stress(const hb_strip *s, const lanes *bending, const lanes *twisting) {
  return v3_less(v3_load(bending), *(const lanes *)s->rod_moment, v3_load(twisting));
}

/* The same on the edge before row 0 of each lane, and behind its last row: none beyond the ends of the rod.
 */
INLINED v3 stress_before(const hb_strip *s) {
  v3 own = whole_stress(s, s->last_stress, s->last_twist), in = v3_zero();
  const int w = HB_LANES - 1;
  if (s->before) in = whole_stress(s->before, s->before->last_stress, s->before->last_twist);
  return (v3){up(own.x, in.x[w]), up(own.y, in.y[w]), up(own.z, in.z[w])};
}

/* And on the edge behind the last row. */
INLINED v3 stress_behind(const hb_strip *s) {
  v3 own = whole_stress(s, s->first_stress, s->first_twist), in = v3_zero();
  if (s->after) in = whole_stress(s->after, s->after->first_stress, s->after->first_twist);
  return (v3){down(own.x, in.x[0]), down(own.y, in.y[0]), down(own.z, in.z[0])};
}

/* The force on the vertices in row r. split: from the forces on edges, written over them row by row; *before
 * is that on the edge before. */
INLINED v3 whole_force(hb_strip *s, int r, bool split, v3 *before) {
  lanes *at = (lanes *)s->f + 3 * r;
  if (!split) return v3_load(at);
  v3 here = v3_zero();
  if (r < s->rows)
    here = whole_stress(s, at, (const lanes *)s->f_twist + 3 * r);
  else if (s->pieces)
    here = stress_behind(s);
  v3 f = v3_sub(*before, here);
  v3_store(at, f);
  *before = here;
  return f;
}

/* v = v_old + kick M^-1 f; x = x_old + drift v, and where wanted the pull of the last multipliers once more.
 */
INLINED void advance_rows(hb_strip *s, hb_real kick, hb_real drift, bool guess, bool split) {
  const lanes *xo = s->x_old, *vo = s->v_old, *w = s->mobility, *mu = s->lambda_old;
  lanes *x = s->x, *v = s->v, *sum = s->lambda;
  v3 before = v3_zero(), stress = split && s->pieces ? stress_before(s) : v3_zero();
  hb_real in = 0;
  if (guess && s->pieces) {
    if (s->before) in = ((const lanes *)s->before->lambda_old)[s->before->rows - 1][HB_LANES - 1];
    before =
        v3_scale(up(mu[s->rows - 1], in), edge_before(s, xo, s->before ? s->before->x_old : NULL, v3_zero()));
  }
  for (int r = 0; r <= s->rows; r++) {
    v3 now = v3_load(vo + 3 * r), from = v3_load(xo + 3 * r);
    now = v3_axpy(now, kick * w[r], whole_force(s, r, split, &stress));
    v3 to = v3_axpy(from, all(drift), now);
    v3_store(v + 3 * r, now);
    if (guess) {
      v3 after = v3_zero();
      if (r < s->rows) {
        after = v3_scale(mu[r], edge_of(xo, r));
        sum[r] = mu[r];
      } else if (s->pieces) {
        in = s->after ? ((const lanes *)s->after->lambda_old)[0][0] : 0;
        after = v3_scale(down(mu[0], in), edge_behind(s, xo, s->after ? s->after->x_old : NULL, v3_zero()));
      }
      to = v3_axpy(to, w[r], v3_sub(after, before));
      before = after;
    }
    v3_store(x + 3 * r, to);
  }
}

/* Velocities at the end of a second-order step: what the multipliers pulled over the step, and the second
 * kick. */
INLINED void finish_velocities(hb_strip *s, hb_real kick, hb_real inv_h, bool split) {
  const lanes *xo = s->x_old, *w = s->mobility, *mu = s->lambda;
  lanes *v = s->v, sum = none();
  v3 before = v3_zero(), stress = split && s->pieces ? stress_before(s) : v3_zero();
  hb_real in = 0;
  if (s->pieces) {
    if (s->before) in = ((const lanes *)s->before->lambda)[s->before->rows - 1][HB_LANES - 1];
    before =
        v3_scale(up(mu[s->rows - 1], in), edge_before(s, xo, s->before ? s->before->x_old : NULL, v3_zero()));
  }
  for (int r = 0; r <= s->rows; r++) {
    v3 after = v3_zero();
    if (r < s->rows) {
      after = v3_scale(mu[r], edge_of(xo, r));
    } else if (s->pieces) {
      in = s->after ? ((const lanes *)s->after->lambda)[0][0] : 0;
      after = v3_scale(down(mu[0], in), edge_behind(s, xo, s->after ? s->after->x_old : NULL, v3_zero()));
    }
    v3 pull = v3_scale(all(inv_h), v3_sub(after, before));
    v3 push = v3_axpy(pull, all(kick), whole_force(s, r, split, &stress));
    v3 now = v3_axpy(v3_load(v + 3 * r), w[r], push);
    v3_store(v + 3 * r, now);
    sum += (now.x + now.y) + now.z;
    before = after;
  }
  *(lanes *)s->finite = sum;
}

/* ---- the passes, each compiled for its cases ---- */

/* Kick and drift. */
static void advance(hb_strip *s, double kick, double drift, bool guess) {
  if (guess) /* of the scheme that puts forces together when it finishes velocities */
    advance_rows(s, (hb_real)kick, (hb_real)drift, true, false);
  else if (s->split)
    advance_rows(s, (hb_real)kick, (hb_real)drift, false, true);
  else
    advance_rows(s, (hb_real)kick, (hb_real)drift, false, false);
  s->split = false;
}

/* Forces on vertices, where there are forces on edges. */
static void assemble(hb_strip *s) {
  if (!s->split) return;
  v3 stress = s->pieces ? stress_before(s) : v3_zero();
  for (int r = 0; r <= s->rows; r++) (void)whole_force(s, r, true, &stress);
  s->split = false;
}

/* Lengths. */
static void eliminate(hb_strip *s, bool along) {
  if (s->pieces && along)
    eliminate_rows(&(rows_of){s, true, true, false});
  else if (s->pieces)
    eliminate_rows(&(rows_of){s, true, false, false});
  else if (along)
    eliminate_rows(&(rows_of){s, false, true, false});
  else
    eliminate_rows(&(rows_of){s, false, false, false});
}

/* Corrections of lengths. */
static void spread(hb_strip *s, bool along, double inv_h) {
  if (s->pieces && along)
    spread_rows(&(effect){s, true, true, false, 0});
  else if (s->pieces)
    spread_rows(&(effect){s, true, false, false, (hb_real)inv_h});
  else if (along)
    spread_rows(&(effect){s, false, true, false, 0});
  else
    spread_rows(&(effect){s, false, false, false, (hb_real)inv_h});
}

/* Rates of lengths. */
static void eliminate_rates(hb_strip *s, double kick, double inv_h) {
  if (s->split)
    finish_velocities(s, (hb_real)kick, (hb_real)inv_h, true);
  else
    finish_velocities(s, (hb_real)kick, (hb_real)inv_h, false);
  s->split = false;
  if (s->pieces)
    eliminate_rows(&(rows_of){s, true, false, true});
  else
    eliminate_rows(&(rows_of){s, false, false, true});
}

/* Corrections of velocities. */
static void spread_rates(hb_strip *s) {
  if (s->pieces)
    spread_rows(&(effect){s, true, false, true, 0});
  else
    spread_rows(&(effect){s, false, false, true, 0});
}

/* A sum over all velocities and forces. */
static void sum_up(hb_strip *s) {
  const lanes *v = s->v, *f = s->f;
  lanes sum = none();
  for (int k = 0; k < 3 * (s->rows + 1); k++) sum += v[k] + f[k];
  *(lanes *)s->finite = sum;
}

/* The last rows of all pieces are tridiagonal, each coupled to those beside it. system, per lane: 1/pivot
 * (entry 1), link from the row before (2), right-hand side, then unknown (3). */
static bool close_rows(hb_strip *strips, int count, bool definite, double *system) {
  bool sound = true;
  int n = 0, total = count * HB_LANES;
  double inv = 0, right = 0;
  for (int g = 0; g < count; g++) {
    const hb_strip *s = &strips[g];
    for (int l = 0; l < HB_LANES; l++, n++) {
      const hb_strip *next = l + 1 < HB_LANES ? s : n + 1 < total ? s + 1 : NULL;
      int nl = l + 1 < HB_LANES ? l + 1 : 0;
      double pivot = (double)(*(const lanes *)s->sep_pivot)[l];
      double whole = (double)(*(const lanes *)s->sep_diagonal)[l];
      double low = (double)(*(const lanes *)s->sep_low)[l], link = (double)(*(const lanes *)s->sep_up)[l];
      double here = (double)(*(const lanes *)s->sep_right)[l];
      if (next) {
        pivot -= (double)(*(const lanes *)next->schur_diagonal)[nl];
        here -= (double)(*(const lanes *)next->schur_right)[nl];
      }
      double ratio = low * inv;
      pivot -= ratio * link;
      right = here - ratio * right;
      bool good = definite ? pivot > HB_SOFT_PIVOT * whole : fabs(pivot) > (double)SINGULAR * fabs(whole);
      inv = good ? 1 / pivot : 0;
      sound = sound && (good || (!definite && whole == 0));
      system[4 * n + 1] = inv;
      system[4 * n + 2] = link;
      system[4 * n + 3] = right;
    }
  }
  for (double ahead = 0; n-- > 0;) {
    double from = n + 1 < total ? system[4 * (n + 1) + 2] : 0;
    ahead = (system[4 * n + 3] - from * ahead) * system[4 * n + 1];
    system[4 * n + 3] = ahead;
    hb_strip *s = &strips[n / HB_LANES];
    (*(lanes *)s->sep)[n % HB_LANES] = (hb_real)ahead;
    if (n + 1 < total) (*(lanes *)strips[(n + 1) / HB_LANES].sep_before)[(n + 1) % HB_LANES] = (hb_real)ahead;
  }
  (*(lanes *)strips->sep_before)[0] = 0;
  return sound;
}

/* The vertex that two strips share: the last lane's end takes over what the next strip's start did. */
static void join_spread(hb_strip *s, bool along) {
  const hb_strip *n = s->after;
  if (!n) return;
  const int w = HB_LANES - 1, top = s->rows - 1;
  lanes *x = (lanes *)s->x + 3 * s->rows, *v = (lanes *)s->v + 3 * s->rows;
  const lanes *xn = n->x, *vn = n->v, *moved = n->first_moved;
  hb_real sum = 0;
  for (int c = 0; c < 3; c++) {
    hb_real change = moved[c][0] - ((const lanes *)s->last_moved)[c][w];
    x[c][w] = xn[c][0];
    if (!along) v[c][w] = vn[c][0];
    sum += change * change;
  }
  lanes *left = s->left;
  hb_real here = R(0.5) * sum * judge_of(s, top)[w];
  if (!((*left)[w] >= here)) (*left)[w] = here;
}

#endif
