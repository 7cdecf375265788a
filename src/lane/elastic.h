/* Geometry, holonomy and elastic forces of isotropic rods in lanes (docs/theory, 2, 3.2, 5 and 10). */
#ifndef HB_LANE_ELASTIC_H
#define HB_LANE_ELASTIC_H

#include "lane/seam.h"
#include "math/rotation.h"

/* t and 1/|e| of an edge vector. */
typedef struct direction {
  v3 t;
  lanes inv;
} direction;

/* Unless exact, the length is the rest length to within 5e-9: one Newton step from 1/|e-bar| gives 1/|e| to
 * round-off, 3/8 (1e-8)^2 at worst, without root and division. */
INLINED direction direct(v3 e, lanes inv_rest, bool exact) {
  lanes square = v3_dot(e, e), inv;
  if (exact)
    inv = R(1) / root(square);
  else
    inv = inv_rest * less_fused(all(R(1.5)), square, R(0.5) * (inv_rest * inv_rest));
  return (direction){v3_scale(inv, e), inv};
}

/* 1/|e-bar| of the edge in row r. */
INLINED lanes inv_rest_of(const hb_strip *s, int r) { return ((const lanes *)s->inv_rest)[r + 1]; }

/* Direction of the edge in row r; phantoms have some direction. */
INLINED direction direct_row(const hb_strip *s, int r, bool exact, bool tail) {
  v3 e = edge_of(s->x, r);
  if (tail) e = v3_choose(real_edges(s, r), e, some_direction());
  return direct(e, inv_rest_of(s, r), exact);
}

/* Directions beyond the ends of a piece. */
INLINED direction direct_before(const hb_strip *s, bool exact) {
  v3 e = edge_before(s, s->x, s->before ? s->before->x : NULL, some_direction());
  return direct(e, inv_rest_of(s, -1), exact);
}

/* And of the edge behind it. */
INLINED direction direct_behind(const hb_strip *s, bool exact) {
  v3 e = edge_behind(s, s->x, s->after ? s->after->x : NULL, some_direction());
  return direct(e, inv_rest_of(s, s->rows), exact);
}

/* A sum that is no number if one of the three is none. */
INLINED lanes sum_of(v3 a) { return (a.x + a.y) + a.z; }

/* Quaternion in lanes. */
typedef struct quat {
  lanes w;
  v3 v;
} quat;

/* a b. */
INLINED quat quat_mul(quat a, quat b) {
  lanes w = less_fused(a.w * b.w, a.v.x, b.v.x);
  w = less_fused(less_fused(w, a.v.y, b.v.y), a.v.z, b.v.z);
  return (quat){w, v3_axpy(v3_axpy(v3_cross(a.v, b.v), b.w, a.v), a.w, b.v)};
}

/* The factor of a vertex: transport from t to n; nothing where there is no bend. */
INLINED quat transport_step(v3 t, v3 n, lane_mask bends, bool all_bend) {
  quat q = {R(1) + v3_dot(t, n), v3_cross(t, n)};
  if (!all_bend) q = (quat){choose(bends, q.w, all(1)), v3_only(bends, q.v)};
  return q;
}

/* Products of transports over the vertices from cut to cut. */
INLINED void transport_rows(hb_strip *s, bool pieces, bool exact) {
  const quat one = {all(1), v3_zero()};
  quat q = one;
  lanes lowest = all(2);
  int cut = 0, first = 1;
  lanes *out = s->turns;
  direction t = direct_row(s, 0, exact, s->full_rows < 1);
  if (pieces) {
    lane_mask bends = all(1) > none();
    if (!s->before) bends[0] = 0; /* the rod's first vertex */
    v3 before = direct_before(s, exact).t;
    q = transport_step(before, t.t, bends, false);
    lowest = choose(bends, smaller(q.w, lowest), lowest);
    first = 0;
  }
  for (int r = pieces ? 0 : 1; r < s->rows; r++) {
    if (r >= 1) {
      bool tail = r >= s->full_rows;
      direction n = direct_row(s, r, exact, tail);
      quat step = transport_step(t.t, n.t, real_edges(s, r), !tail);
      lowest = smaller(step.w, lowest); /* phantoms have 1 */
      q = r == first ? step : quat_mul(step, q);
      t = n;
    }
    if (r == s->cuts[cut]) {
      out[0] = q.w;
      v3_store(out + 1, q.v);
      out += 4;
      cut++;
      first = r + 1;
      q = one;
    }
  }
  *(lanes *)s->lowest_chi = lowest;
}

/* Isotropic and straight at rest. With c = t.t', chi = 1 + c: E = alpha |kb|^2/l = 4 alpha (1-c)/(l chi),
 * hence -dE/de = 8 alpha/(l chi^2) (t' - c t)/|e| and the same with the edges exchanged; d psi/de = -(t x
 * t')/(chi |e|). q0, q1: the force on the edge before the vertex and on the one behind it. */
INLINED void bend(const hb_strip *s, int r, direction t, direction n, const lanes *moment, lanes *lowest,
                  v3 *q0, v3 *q1) {
  lanes c = v3_dot(t.t, n.t), chi = R(1) + c;
  *lowest = smaller(chi, *lowest);
  chi = larger(chi, all(R(HB_FOLD_LIMIT)));
  lanes inv = R(1) / chi, k = ((const lanes *)s->bend_gain)[r] * (inv * inv);
  lanes k0 = k * t.inv, k1 = k * n.inv;
  *q0 = v3_scale(k0, v3_less(n.t, c, t.t));
  *q1 = v3_scale(k1, v3_less(t.t, c, n.t));
  if (!moment) return;
  lanes g = *moment * inv;
  v3 x = v3_cross(t.t, n.t);
  *q0 = v3_less(*q0, g * t.inv, x);
  *q1 = v3_less(*q1, g * n.inv, x);
}

/* Twisting moment where a piece meets the next, or the rod ends: there is none at the end. */
INLINED lanes moment_at_seam(const hb_strip *s, int r) {
  lane_mask inside = all(1) > none();
  if (r == 0 && !s->before) inside[0] = 0;
  if (r > 0 && !s->after) inside[HB_LANES - 1] = 0;
  return only(inside, ((const lanes *)s->moment)[r]);
}

/* Force on all vertices; where strips meet join_elastic completes it. */
INLINED void elastic_rows(hb_strip *s, bool pieces, bool twisted, bool exact) {
  int top = s->rows - 1;
  lanes *f = s->f, lowest = all(2), sum = none(), moment = none(), *M = twisted ? &moment : NULL;
  v3 carry = v3_zero(), before = v3_zero(), q0, q1;
  direction t = direct_row(s, 0, exact, s->full_rows < 1);
  if (pieces) {
    if (twisted) moment = moment_at_seam(s, 0);
    bend(s, 0, direct_before(s, exact), t, M, &lowest, &q0, &carry);
    if (!s->before) lowest[0] = 2; /* the rod's first vertex */
  }
  for (int r = 1; r <= top; r++) {
    direction n;
    if (twisted) moment = ((const lanes *)s->moment)[r];
    if (r < s->full_rows) {
      n = direct_row(s, r, exact, false);
      bend(s, r, t, n, M, &lowest, &q0, &q1);
    } else {
      lanes here = all(2);
      n = direct_row(s, r, exact, true);
      moment = only(real_edges(s, r), moment);
      bend(s, r, t, n, M, &here, &q0, &q1);
      lowest = choose(real_edges(s, r), smaller(lowest, here), lowest);
    }
    v3 stress = v3_add(carry, q0);
    v3_store(f + 3 * (r - 1), v3_sub(before, stress));
    if (pieces && r == 1) v3_store(s->first_stress, stress);
    sum += sum_of(stress);
    before = stress;
    carry = q1;
    t = n;
  }
  v3 stress = carry;
  if (pieces) {
    lanes unused = all(2);
    if (twisted) moment = moment_at_seam(s, s->rows);
    bend(s, s->rows, t, direct_behind(s, exact), M, &unused, &q0, &q1);
    stress = v3_add(carry, q0);
  }
  v3_store(f + 3 * top, v3_sub(before, stress));
  v3_store(f + 3 * s->rows, stress);
  v3_store(s->last_stress, stress);
  *(lanes *)s->lowest_chi = lowest;
  *(lanes *)s->finite = sum + sum_of(stress);
}

/* A vertex as its edges feel it: with x = t x t', g = x/chi, and the bending moment 8 alpha/l x/chi^2, which
 * is `stiff` g. */
typedef struct joint {
  v3 g;
  lanes stiff;
} joint;

/* Vertex r; cross: t x t'. */
INLINED joint joint_of(const hb_strip *s, int r, v3 cross, lanes chi) {
  lanes inv = R(1) / larger(chi, all(R(HB_FOLD_LIMIT)));
  return (joint){v3_scale(inv, cross), ((const lanes *)s->bend_gain)[r] * inv};
}

/* Edge r between two vertices: with t' - (t.t') t = x x t, bending pulls with t x (moment behind it - moment
 * before it)/|e|, one unit of twisting moment with -(g + g')/|e|. */
INLINED v3 stress_edge(hb_strip *s, int r, direction t, joint a, joint b) {
  v3 turn = {fused_less(a.stiff, a.g.x, b.stiff * b.g.x), fused_less(a.stiff, a.g.y, b.stiff * b.g.y),
             fused_less(a.stiff, a.g.z, b.stiff * b.g.z)};
  v3 bending = v3_scale(t.inv, v3_cross(t.t, turn)), twisting = v3_scale(t.inv, v3_add(a.g, b.g));
  v3_store((lanes *)s->f + 3 * r, bending);
  v3_store((lanes *)s->f_twist + 3 * r, twisting);
  return bending;
}

/* Transport, bending force and force per twisting moment in one pass, where each rod has one moment from end
 * to end, which is known when all transport is. They are left as forces on edges: whole_stress. */
INLINED void flex_rows(hb_strip *s, bool pieces, bool exact) {
  const quat one = {all(1), v3_zero()};
  lanes *out = s->turns, lowest = all(2), sum = none();
  quat q = one;
  int cut = 0, first = 1;
  joint at = {v3_zero(), none()};
  direction t = direct_row(s, 0, exact, s->full_rows < 1);
  if (pieces) {
    lane_mask inside = all(1) > none();
    if (!s->before) inside[0] = 0; /* the rod's first vertex */
    v3 b = direct_before(s, exact).t;
    lanes chi = choose(inside, R(1) + v3_dot(b, t.t), all(1));
    q = (quat){chi, v3_only(inside, v3_cross(b, t.t))};
    lowest = choose(inside, smaller(chi, lowest), lowest);
    at = joint_of(s, 0, q.v, chi);
    first = 0;
  }
  for (int r = pieces ? 0 : 1; r < s->rows; r++) {
    if (r >= 1) {
      const bool tail = r >= s->full_rows;
      direction n = direct_row(s, r, exact, tail);
      quat step = {R(1) + v3_dot(t.t, n.t), v3_cross(t.t, n.t)};
      if (tail) {
        lane_mask real = real_edges(s, r);
        lowest = choose(real, smaller(step.w, lowest), lowest);
        step = (quat){choose(real, step.w, all(1)), v3_only(real, step.v)};
      } else {
        lowest = smaller(step.w, lowest);
      }
      joint next = joint_of(s, r, step.v, step.w);
      sum += sum_of(stress_edge(s, r - 1, t, at, next));
      q = r == first ? step : quat_mul(step, q);
      at = next;
      t = n;
    }
    if (r == s->cuts[cut]) {
      out[0] = q.w;
      v3_store(out + 1, q.v);
      out += 4;
      cut++;
      first = r + 1;
      q = one;
    }
  }
  joint end = {v3_zero(), none()};
  if (pieces) {
    lane_mask inside = all(1) > none();
    if (!s->after) inside[HB_LANES - 1] = 0;
    v3 n = direct_behind(s, exact).t;
    end = joint_of(s, s->rows, v3_only(inside, v3_cross(t.t, n)),
                   choose(inside, R(1) + v3_dot(t.t, n), all(1)));
  }
  sum += sum_of(stress_edge(s, s->rows - 1, t, at, end));
  *(lanes *)s->lowest_chi = lowest;
  *(lanes *)s->finite = sum;
  if (!pieces) return;
  v3_store(s->first_stress, v3_load(s->f));
  v3_store(s->first_twist, v3_load(s->f_twist));
  v3_store(s->last_stress, v3_load((const lanes *)s->f + 3 * (s->rows - 1)));
  v3_store(s->last_twist, v3_load((const lanes *)s->f_twist + 3 * (s->rows - 1)));
}

/* Forces on the vertices that pieces share: from the last edge of one and the first of the next. */
static void join_elastic(hb_strip *s) {
  if (!s->pieces || s->split) return;
  const int w = HB_LANES - 1;
  lanes *f = s->f, *end = f + 3 * s->rows;
  const lanes *first = s->first_stress, *last = s->last_stress;
  for (int c = 0; c < 3; c++) {
    hb_real before = s->before ? ((const lanes *)s->before->last_stress)[c][w] : 0;
    hb_real behind = s->after ? ((const lanes *)s->after->first_stress)[c][0] : 0;
    f[c] = up(last[c], before) - first[c];
    end[c] = last[c] - down(first[c], behind);
  }
}

/* ---- the passes, each compiled for its cases ---- */

/* Bending and transport at once. */
static void flex(hb_strip *s, bool exact) {
  s->split = true;
  if (s->pieces && exact)
    flex_rows(s, true, true);
  else if (s->pieces)
    flex_rows(s, true, false);
  else if (exact)
    flex_rows(s, false, true);
  else
    flex_rows(s, false, false);
}

/* Transport. */
static void transport(hb_strip *s, bool exact) {
  if (s->pieces && exact)
    transport_rows(s, true, true);
  else if (s->pieces)
    transport_rows(s, true, false);
  else if (exact)
    transport_rows(s, false, true);
  else
    transport_rows(s, false, false);
}

/* Elastic forces; of rods with one twisting moment each by flex. */
static void elastic(hb_strip *s, bool exact) {
  int kind = (s->pieces ? 2 : 0) + (s->twisted ? 1 : 0);
  s->split = false;
  if (exact) { /* rare: compiled once for all */
    elastic_rows(s, s->pieces, s->twisted, true);
    return;
  }
  switch (kind) {
  case 0: elastic_rows(s, false, false, false); break;
  case 1: elastic_rows(s, false, true, false); break;
  case 2: elastic_rows(s, true, false, false); break;
  case 3: elastic_rows(s, true, true, false); break;
  }
}

#endif
