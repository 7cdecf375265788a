/* General rods in lanes: frames, quasi-static twist by Newton, forces (docs/theory, 3.3, 5 and 10.6). */
#ifndef HB_LANE_GENERAL_H
#define HB_LANE_GENERAL_H

#include "lane/elastic.h"
#include "lane/project.h"

/* Component c of the row before row 0 of each lane; before: the same array of the strip before. */
INLINED lanes row_before(const hb_strip *s, const lanes *a, const lanes *before, int numbers, int c) {
  hb_real in = s->before ? before[numbers * (s->before->rows - 1) + c][HB_LANES - 1] : 0;
  return up(a[numbers * (s->rows - 1) + c], in);
}

/* And of the row behind the last one. */
INLINED lanes row_behind(const hb_strip *s, const lanes *a, const lanes *after, int c) {
  return down(a[c], s->after ? after[c][0] : 0);
}

/* A vector of the edge before row 0. */
INLINED v3 v3_before(const hb_strip *s, const lanes *a, const lanes *before) {
  return (v3){row_before(s, a, before, 3, 0), row_before(s, a, before, 3, 1), row_before(s, a, before, 3, 2)};
}

/* Of the edge behind the last row. */
INLINED v3 v3_behind(const hb_strip *s, const lanes *a, const lanes *after) {
  return (v3){row_behind(s, a, after, 0), row_behind(s, a, after, 1), row_behind(s, a, after, 2)};
}

/* Sine and cosine by their series, |a| <= 1; short ones where all lanes are small. */
INLINED void turn_parts(lanes a, lanes *sine, lanes *cosine) {
  static const double short_sine[3] = {-1.0 / 5040, 1.0 / 120, -1.0 / 6};
  static const double short_cosine[3] = {-1.0 / 720, 1.0 / 24, -0.5};
  static const double long_sine[8] = {
      1.0 / 355687428096000.0, -1.0 / 1307674368000.0, 1.0 / 6227020800.0, -1.0 / 39916800.0,
      1.0 / 362880.0,          -1.0 / 5040.0,          1.0 / 120.0,        -1.0 / 6.0};
  static const double long_cosine[9] = {-1.0 / 6402373705728000.0,
                                        1.0 / 20922789888000.0,
                                        -1.0 / 87178291200.0,
                                        1.0 / 479001600.0,
                                        -1.0 / 3628800.0,
                                        1.0 / 40320.0,
                                        -1.0 / 720.0,
                                        1.0 / 24.0,
                                        -0.5};
  lanes q = a * a, p, r;
  if (!any(q > all(R(4e-4)))) {
    p = polynomial(short_sine, 3, q);
    r = polynomial(short_cosine, 3, q);
  } else {
    p = polynomial(long_sine, 8, q);
    r = polynomial(long_cosine, 9, q);
  }
  *sine = fused(a, q * p, a);
  *cosine = fused(q, r, all(1));
}

/* The director d, normal to t, turned about t by a. */
INLINED v3 turn(v3 d, v3 t, lanes a) {
  lanes s, c;
  turn_parts(a, &s, &c);
  v3 n = v3_cross(t, d);
  return v3_axpy(v3_scale(c, d), s, n);
}

/* The angle of the unit vector (x, y): h = tan(a/2) and a polynomial, atan(h)/h is one of degree 12 in h^2 on
 * [0, tan^2(pi/8)] to 5e-20 (Chebyshev fit); larger angles are halved once more. */
INLINED lanes angle_of(lanes x, lanes y) {
  static const double fit[13] = {0.015113765096600924669,
                                 -0.033387824501211951519,
                                 0.044995007289840320092,
                                 -0.052173125740615910016,
                                 0.058768340046141606641,
                                 -0.066662052599765261879,
                                 0.076922810999377432501,
                                 -0.090909080590311910269,
                                 0.11111111085322108759,
                                 -0.14285714285329708164,
                                 0.19999999999997013892,
                                 -0.33333333333333324206,
                                 1};
  lanes z = y / (R(1) + size_of(x)), parts = all(2);
  lane_mask large = size_of(z) > all(R(0.4142));
  if (any(large)) {
    z = choose(large, z / (R(1) + root(fused(z, z, all(1)))), z);
    parts = choose(large, all(4), parts);
  }
  lanes a = parts * (z * polynomial(fit, 13, z * z));
  lanes turned = choose(y < none(), all(R(-HB_PI)), all(R(HB_PI)));
  return choose(x < none(), turned - a, a);
}

/* The value equal to angle modulo 2 pi that is nearest to target. */
INLINED lanes nearest_angle(lanes angle, lanes target) {
  const hb_real round = sizeof(hb_real) == 8 ? R(6755399441055744.0) : R(12582912.0); /* 1.5 * 2^52, 2^23 */
  lanes turns = fused(target - angle, all(R(1 / (2 * HB_PI))), all(round)) - round;
  return fused(all(R(2 * HB_PI)), turns, angle);
}

/* d, normal to the unit vector a, carried to b by parallel transport. */
INLINED v3 transported(v3 d, v3 a, v3 b) {
  lanes chi = larger(R(1) + v3_dot(a, b), all(R(HB_FOLD_LIMIT)));
  return v3_less(d, v3_dot(d, b) / chi, v3_add(a, b));
}

/* The same with the round-off taken out; d itself where the edge turned back. */
INLINED v3 carried(v3 d, v3 a, v3 b) {
  lane_mask turned_back = R(1) + v3_dot(a, b) <= all(R(HB_FOLD_LIMIT));
  v3 r = transported(d, a, b);
  r = v3_choose(turned_back, d, r);
  r = v3_less(r, v3_dot(r, b), b);
  return v3_scale(less_fused(all(R(1.5)), all(R(0.5)), v3_dot(r, r)), r);
}

/* Directors to the new tangents, turned on by what they turned in the last step. known: t is that of x_old.
 */
INLINED void carry_rows(hb_strip *s, bool exact, bool known) {
  lanes *t = s->t, *inv = s->inv_length, *m1 = s->m1, *spin = s->spin, keep = *(const lanes *)s->keep;
  for (int r = 0; r < s->rows; r++) {
    bool tail = r >= s->full_rows;
    v3 from = v3_load(t + 3 * r);
    if (!known) {
      v3 old = edge_of(s->x_old, r);
      if (tail) old = v3_choose(real_edges(s, r), old, some_direction());
      from = direct(old, inv_rest_of(s, r), exact).t;
    }
    direction now = direct_row(s, r, exact, tail);
    lanes on = only(size_of(spin[r]) < all(R(0.5)), keep * spin[r]);
    v3 d = turn(carried(v3_load(m1 + 3 * r), from, now.t), now.t, on);
    v3_store(m1 + 3 * r, d);
    v3_store(t + 3 * r, now.t);
    inv[r] = now.inv;
    spin[r] = on;
  }
  s->known_t = true; /* x is the next x_old */
}

/* One side of a vertex. */
typedef struct side {
  lanes gradient, diagonal; /* of the edge, by turning it */
  lanes scale;
} side;

/* omega and B omega - pull of the edge with tangent t and director d at a vertex, and what its turning does
 * to the bending energy. */
INLINED side look_side(lanes inv_l, v3 kb, v3 t, v3 d, const lanes *B, const lanes *pull, lanes *stress,
                       bool scaled) {
  lanes o1 = v3_dot(kb, v3_cross(t, d)), o2 = -v3_dot(kb, d);
  lanes s1 = fused(B[0], o1, B[1] * o2), s2 = fused(B[1], o1, B[2] * o2);
  lanes b1 = s1 - pull[0], b2 = s2 - pull[1];
  stress[0] = b1;
  stress[1] = b2;
  lanes turned = less_fused(o2 * fused_less(B[0], o2, B[1] * o1), o1, fused_less(B[1], o2, B[2] * o1));
  side out = {inv_l * fused_less(o2, b1, o1 * b2), inv_l * less_fused(less_fused(turned, o1, b1), o2, b2),
              none()};
  if (scaled)
    out.scale = inv_l * ((size_of(o1) + size_of(o2)) *
                         (size_of(s1) + size_of(s2) + size_of(pull[0]) + size_of(pull[1])));
  return out;
}

/* What a look at the energy finds on its way. */
typedef struct glance {
  lanes residual, scale, floor, lowest;
  chain c;
} glance;

/* Curvature binormal and twist of vertex r between two edges, first look of a step. */
INLINED void measure_vertex(hb_strip *s, int r, v3 t, v3 n, v3 d, v3 e, lanes spun, glance *g) {
  lanes c = v3_dot(t, n), chi = R(1) + c, inv_l = ((const lanes *)s->inv_l)[r];
  g->lowest = choose(inv_l > none(), smaller(chi, g->lowest), g->lowest);
  lane_mask folded = chi <= all(R(HB_FOLD_LIMIT));
  chi = larger(chi, all(R(HB_FOLD_LIMIT)));
  lanes inv = R(1) / chi;
  v3_store((lanes *)s->kb + 3 * r, v3_scale(R(2) * inv, v3_cross(t, n)));
  v3 u = v3_less(d, v3_dot(d, n) * inv, v3_add(t, n));
  lanes *twist = (lanes *)s->twist + r, expected = *twist + spun;
  lanes angle = nearest_angle(angle_of(v3_dot(u, e), v3_dot(v3_cross(u, e), n)), expected);
  *twist = choose(folded, expected, angle);
}

/* Twisting moment of vertex r. */
INLINED lanes vertex_moment(hb_strip *s, int r, bool first, glance *g) {
  lanes gain = ((const lanes *)s->twist_gain)[r], rest = ((const lanes *)s->rest_twist)[r];
  lanes twist = ((const lanes *)s->twist)[r], moment = gain * (twist - rest);
  ((lanes *)s->moment)[r] = moment;
  if (first) {
    g->floor = larger(g->floor, gain);
    g->scale = larger(g->scale, gain * (size_of(twist) + size_of(rest)));
  }
  return moment;
}

/* Takes row r, now whole, out of the system of turns. */
INLINED void close_turn(hb_strip *s, bool pieces, int r, lanes gradient, lanes diagonal, bool last,
                        glance *g) {
  lane_mask frees = ((const lanes *)s->free)[r] > none();
  lanes link = ((const lanes *)s->twist_link)[r];
  lanes right = only(frees, -gradient);
  ((lanes *)s->turn_gradient)[r] = gradient;
  g->residual = larger(size_of(only(frees, gradient)), g->residual);
  diagonal = choose(frees, diagonal, all(1));
  take_out(s, pieces, r, diagonal, -link, -link, right, last, true, &g->c);
}

/* Curvature binormals and twists of all vertices. Rows know nothing of each other here, so that a processor
 * can work on several at once; in look_rows each waits for the one before. */
INLINED void measure_rows(hb_strip *s, bool pieces, glance *g) {
  const lanes *t = s->t, *m1 = s->m1, *spin = s->spin;
  const int K = s->rows;
  v3 ta = v3_load(t), da = v3_load(m1);
  if (pieces) {
    const hb_strip *b = s->before;
    v3 tb = v3_before(s, t, b ? b->t : NULL), db = v3_before(s, m1, b ? b->m1 : NULL);
    measure_vertex(s, 0, tb, ta, db, da, spin[0] - row_before(s, spin, b ? b->spin : NULL, 1, 0), g);
  }
  for (int r = 1; r < K; r++) {
    v3 tn = v3_load(t + 3 * r), dn = v3_load(m1 + 3 * r);
    measure_vertex(s, r, ta, tn, da, dn, spin[r] - spin[r - 1], g);
    ta = tn;
    da = dn;
  }
  if (pieces) {
    const hb_strip *a = s->after;
    v3 tn = v3_behind(s, t, a ? a->t : NULL), dn = v3_behind(s, m1, a ? a->m1 : NULL);
    measure_vertex(s, K, ta, tn, da, dn, row_behind(s, spin, a ? a->spin : NULL, 0) - spin[K - 1], g);
  }
}

/* Energy gradient and Hessian by turning the edges, and elimination on the way. first: new tangents. */
INLINED void look_rows(hb_strip *s, bool pieces, bool first) {
  const lanes *t = s->t, *m1 = s->m1, *inv_l = s->inv_l, *kb = s->kb, *gain = s->twist_gain;
  lanes *stress = s->stress;
  glance g = {.residual = none(), .scale = none(), .floor = none(), .lowest = all(2), .c = new_chain()};
  int K = s->rows;
  if (first) measure_rows(s, pieces, &g);
  v3 ta = v3_load(t), da = v3_load(m1);
  lanes gradient = none(), diagonal = none();
  if (pieces) {
    const hb_strip *b = s->before;
    v3 tb = v3_before(s, t, b ? b->t : NULL), db = v3_before(s, m1, b ? b->m1 : NULL);
    lanes M = vertex_moment(s, 0, first, &g);
    lanes Bb[3];
    for (int c = 0; c < 3; c++) Bb[c] = row_before(s, s->B, b ? b->B : NULL, 3, c);
    (void)look_side(inv_l[0], v3_load(kb), tb, db, Bb, s->pull, stress,
                    false); /* its stress is wanted here, too */
    side far = look_side(inv_l[0], v3_load(kb), ta, da, s->B, (const lanes *)s->pull + 2, stress + 2, first);
    gradient = M + far.gradient;
    diagonal = gain[0] + far.diagonal;
    g.scale = larger(g.scale, far.scale);
  }
  for (int r = 1; r < K; r++) {
    v3 tn = v3_load(t + 3 * r), dn = v3_load(m1 + 3 * r);
    lanes M = vertex_moment(s, r, first, &g);
    v3 k = v3_load(kb + 3 * r);
    const lanes *pull = (const lanes *)s->pull + 4 * r, *B = (const lanes *)s->B + 3 * r;
    side near = look_side(inv_l[r], k, ta, da, B - 3, pull, stress + 4 * r, first);
    side far = look_side(inv_l[r], k, tn, dn, B, pull + 2, stress + 4 * r + 2, first);
    if (first) g.scale = larger(g.scale, larger(near.scale, far.scale));
    close_turn(s, pieces, r - 1, gradient + (near.gradient - M), diagonal + (near.diagonal + gain[r]), false,
               &g);
    gradient = M + far.gradient;
    diagonal = gain[r] + far.diagonal;
    ta = tn;
    da = dn;
  }
  if (pieces) {
    const hb_strip *a = s->after;
    v3 tn = v3_behind(s, t, a ? a->t : NULL), dn = v3_behind(s, m1, a ? a->m1 : NULL);
    lanes M = vertex_moment(s, K, first, &g);
    lanes Bn[3];
    for (int c = 0; c < 3; c++) Bn[c] = row_behind(s, s->B, a ? a->B : NULL, c);
    (void)look_side(inv_l[K], v3_load(kb + 3 * K), tn, dn, Bn, (const lanes *)s->pull + 4 * K + 2,
                    stress + 4 * K + 2, false);
    side near = look_side(inv_l[K], v3_load(kb + 3 * K), ta, da, (const lanes *)s->B + 3 * (K - 1),
                          (const lanes *)s->pull + 4 * K, stress + 4 * K, first);
    gradient += near.gradient - M;
    diagonal += near.diagonal + gain[K];
  }
  close_turn(s, pieces, K - 1, gradient, diagonal, pieces, &g);
  finish_chain(s, pieces, &g.c);
  *(lanes *)s->worst = g.residual;
  if (!first) return;
  *(lanes *)s->scale = g.scale;
  *(lanes *)s->floor = g.floor;
  *(lanes *)s->lowest_chi = g.lowest;
}

/* Back substitution of the turns; the longest one is left in `left`. Rods of a bundle that are in equilibrium
 * wait for the others: they are not turned any more. */
INLINED void find_turns(hb_strip *s, bool pieces) {
  lanes *right = s->right, u = *(const lanes *)s->sep, ahead = *(const lanes *)s->sep_before;
  const lane_mask turns = *(const lanes *)s->active > none();
  if (!pieces) u = only(turns, u);
  lanes longest = size_of(u);
  right[s->rows - 1] = u;
  for (int r = s->rows - 2; r >= 0; r--) {
    u = fused(((const lanes *)s->link)[r + 1], u, right[r]);
    if (pieces) u = less_fused(u, ((const lanes *)s->fill)[r], ahead);
    u *= ((const lanes *)s->inv_pivot)[r];
    if (!pieces) u = only(turns, u);
    right[r] = u;
    longest = larger(size_of(u), longest);
  }
  *(lanes *)s->left = longest;
}

/* Turns the directors by what find_turns found. */
INLINED void turn_rows(hb_strip *s, bool pieces) {
  lanes *m1 = s->m1, *spin = s->spin, *twist = s->twist;
  const lanes *t = s->t, *a = s->right;
  lanes before = pieces ? *(const lanes *)s->sep_before : a[0];
  for (int r = 0; r < s->rows; r++) {
    v3_store(m1 + 3 * r, turn(v3_load(m1 + 3 * r), v3_load(t + 3 * r), a[r]));
    spin[r] += a[r];
    twist[r] += a[r] - before;
    before = a[r];
  }
  if (pieces) twist[s->rows] += row_behind(s, a, s->after ? s->after->right : NULL, 0) - before;
}

/* g = dE/d(kb) at fixed material angle, then the gradient of kb = 2 t x t'/chi by the edges; q0, q1: force on
 * the edge before vertex r and on the one behind it. */
INLINED void bend_general(const hb_strip *s, int r, direction t, direction n, v3 d, v3 e, v3 *q0, v3 *q1) {
  v3 kb = v3_load((const lanes *)s->kb + 3 * r);
  const lanes *b = (const lanes *)s->stress + 4 * r;
  lanes inv_l = ((const lanes *)s->inv_l)[r], chi = R(1) + v3_dot(t.t, n.t);
  lanes inv = R(1) / larger(chi, all(R(HB_FOLD_LIMIT)));
  v3 g = v3_less(v3_scale(b[0], v3_cross(t.t, d)), b[1], d);
  g = v3_less(v3_axpy(g, b[2], v3_cross(n.t, e)), b[3], e);
  g = v3_scale(inv_l, g);
  lanes half_moment = R(0.5) * ((const lanes *)s->moment)[r], twice = R(2) * inv;
  v3 sum = v3_scale(v3_dot(g, kb) * inv, v3_add(t.t, n.t));
  v3 base = v3_less(sum, half_moment, kb);
  *q0 = v3_scale(t.inv, v3_less(base, twice, v3_cross(n.t, g)));
  *q1 = v3_scale(n.inv, v3_axpy(base, twice, v3_cross(t.t, g)));
}

/* Force on all vertices; where strips meet join_elastic completes it. */
INLINED void general_rows(hb_strip *s, bool pieces) {
  int top = s->rows - 1;
  lanes *f = s->f;
  const lanes *ts = s->t, *m1 = s->m1, *inv = s->inv_length;
  lanes sum = none();
  v3 carry = v3_zero(), before = v3_zero(), q0, q1, d = v3_load(m1);
  direction t = {v3_load(ts), inv[0]};
  if (pieces) {
    const hb_strip *b = s->before;
    direction p = {v3_before(s, ts, b ? b->t : NULL), row_before(s, inv, b ? b->inv_length : NULL, 1, 0)};
    bend_general(s, 0, p, t, v3_before(s, m1, b ? b->m1 : NULL), d, &q0, &carry);
  }
  for (int r = 1; r <= top; r++) {
    direction n = {v3_load(ts + 3 * r), inv[r]};
    v3 e = v3_load(m1 + 3 * r);
    bend_general(s, r, t, n, d, e, &q0, &q1);
    v3 stress = v3_add(carry, q0);
    v3_store(f + 3 * (r - 1), v3_sub(before, stress));
    if (pieces && r == 1) v3_store(s->first_stress, stress);
    sum += sum_of(stress);
    before = stress;
    carry = q1;
    t = n;
    d = e;
  }
  v3 stress = carry;
  if (pieces) {
    const hb_strip *a = s->after;
    direction n = {v3_behind(s, ts, a ? a->t : NULL), row_behind(s, inv, a ? a->inv_length : NULL, 0)};
    bend_general(s, s->rows, t, n, d, v3_behind(s, m1, a ? a->m1 : NULL), &q0, &q1);
    stress = v3_add(carry, q0);
  }
  v3_store(f + 3 * top, v3_sub(before, stress));
  v3_store(f + 3 * s->rows, stress);
  v3_store(s->last_stress, stress);
  *(lanes *)s->finite = sum + sum_of(stress);
}

/* ---- the passes, each compiled for its cases ---- */

/* Frames carried. */
static void carry(hb_strip *s, bool exact) {
  if (exact)
    carry_rows(s, true, false);
  else if (s->known_t)
    carry_rows(s, false, true);
  else
    carry_rows(s, false, false);
}

/* A look at the energy of turns. */
static void look(hb_strip *s, bool first) {
  if (s->pieces && first)
    look_rows(s, true, true);
  else if (s->pieces)
    look_rows(s, true, false);
  else if (first)
    look_rows(s, false, true);
  else
    look_rows(s, false, false);
}

/* Turns found. */
static void solve_turns(hb_strip *s) {
  if (s->pieces)
    find_turns(s, true);
  else
    find_turns(s, false);
}

/* Turns forgotten. */
static void drop_turns(hb_strip *s, int lane) {
  lanes *right = s->right, *ahead = s->sep_before;
  for (int l = lane < 0 ? 0 : lane; l < (lane < 0 ? HB_LANES : lane + 1); l++) {
    for (int r = 0; r < s->rows; r++) right[r][l] = 0;
    (*ahead)[l] = 0;
  }
}

/* Turns made. */
static void turn_all(hb_strip *s) {
  if (s->pieces)
    turn_rows(s, true);
  else
    turn_rows(s, false);
}

/* Forces. */
static void general(hb_strip *s) {
  if (s->pieces)
    general_rows(s, true);
  else
    general_rows(s, false);
}

#endif
