/* Hessian of bending and twisting, vertex by vertex (docs/theory, 11.1 to 11.3).
 *
 * The energy W of a vertex depends on its two edges only through their tangents a, b and on the turns of
 * their frames. Each tangent moves in the plane normal to it, of which two unit vectors p are the basis: four
 * directions in all, a1 a2 b1 b2. In them the second derivatives are short; edges, then vertices, come last.
 */
#include "rod/hessian.h"

#include "math/rotation.h"

#include <string.h>

/* One vertex as its energy sees it. Index k: 0, 1 in the plane of a, 2, 3 in that of b. */
typedef struct joint {
  hb_v3 t[2], p[4];
  double inv_length[2];
  hb_v3 kb;
  double inv_chi;
  hb_v3 slope[4];                /* of kb in each direction: D_k */
  double chi_slope[4], along[4]; /* of chi; kb . p_k */
  double gradient[4];            /* dW/dk */
  double second[4][4];           /* d2W/dk dl, also the lower half */
  double mixed[2][4];            /* d2W/d(turn of side) dk */
  double turn[2], turns;         /* d2W/d(turn)^2 of both sides; d2W of one by the other */
} joint;

/* kb and its first derivatives (4.2) in the four directions. */
static void look(joint *v) {
  hb_v3 a = v->t[0], b = v->t[1];
  for (int k = 0; k < 4; k++) {
    hb_v3 other = k < 2 ? b : a, p = v->p[k];
    hb_v3 turned = k < 2 ? hb_v3_cross(p, b) : hb_v3_cross(a, p);
    double c = hb_v3_dot(p, other);
    v->chi_slope[k] = c;
    v->along[k] = hb_v3_dot(v->kb, p);
    v->slope[k] =
        (hb_v3){v->inv_chi * (2 * turned.x - c * v->kb.x), v->inv_chi * (2 * turned.y - c * v->kb.y),
                v->inv_chi * (2 * turned.z - c * v->kb.z)};
  }
}

/* Second derivatives of f = g . kb at fixed g (11.2), and its first. */
static void add_curvature(joint *v, hb_v3 g) {
  double inv = v->inv_chi, f = hb_v3_dot(g, v->kb), first[4];
  for (int k = 0; k < 4; k++) {
    first[k] = hb_v3_dot(g, v->slope[k]);
    v->gradient[k] += first[k];
  }
  for (int k = 0; k < 4; k++)
    for (int l = k; l < 4; l++)
      v->second[k][l] -= inv * (first[k] * v->chi_slope[l] + first[l] * v->chi_slope[k]);
  for (int k = 0; k < 4; k++) v->second[k][k] -= inv * f;
  for (int k = 0; k < 2; k++) {
    hb_v3 turned = hb_v3_cross(g, v->p[k]);
    for (int l = 2; l < 4; l++)
      v->second[k][l] += inv * (2 * hb_v3_dot(turned, v->p[l]) - f * hb_v3_dot(v->p[k], v->p[l]));
  }
}

/* alpha |kb|^2/l. */
static void bend_isotropic(joint *v, double stiffness) {
  for (int k = 0; k < 4; k++)
    for (int l = k; l < 4; l++) v->second[k][l] += stiffness * hb_v3_dot(v->slope[k], v->slope[l]);
  add_curvature(v, hb_v3_scale(stiffness, v->kb));
}

/* (omega - rest)^T B (omega - rest)/(2 l) of one side, whose frame is p[2 side], p[2 side + 1]. Returns its
 * part of g. */
static hb_v3 bend_side(joint *v, int side, double inv_l, const double *B, const double *omega,
                       const double *stress) {
  hb_v3 m1 = v->p[2 * side], m2 = v->p[2 * side + 1];
  double o1 = omega[0], o2 = omega[1], b1 = inv_l * stress[0], b2 = inv_l * stress[1];
  double B11 = inv_l * B[0], B12 = inv_l * B[1], B22 = inv_l * B[2];
  double u[4], w[4]; /* slopes of omega_1, omega_2 */
  for (int k = 0; k < 4; k++) {
    u[k] = hb_v3_dot(m2, v->slope[k]);
    w[k] = -hb_v3_dot(m1, v->slope[k]);
  }
  for (int k = 0; k < 4; k++) {
    double su = B11 * u[k] + B12 * w[k], sw = B12 * u[k] + B22 * w[k];
    for (int l = k; l < 4; l++) v->second[k][l] += su * u[l] + sw * w[l];
  }
  /* a turn changes omega by (o2, -o1), and the stress by B of that */
  double r1 = B11 * o2 - B12 * o1, r2 = B12 * o2 - B22 * o1;
  for (int k = 0; k < 4; k++) v->mixed[side][k] += (r1 - b2) * u[k] + (r2 + b1) * w[k];
  v->turn[side] += o2 * r1 - o1 * r2 - o1 * b1 - o2 * b2;
  /* the frame tilts with its tangent: second order of time-parallel transport */
  double G[2] = {-b2, b1}; /* g of this side along m1, m2 */
  const double *along = v->along + 2 * side;
  for (int k = 0; k < 2; k++)
    for (int l = k; l < 2; l++)
      v->second[2 * side + k][2 * side + l] += 0.5 * (G[k] * along[l] + G[l] * along[k]);
  return hb_v3_axpy(hb_v3_scale(b1, m2), -b2, m1);
}

/* beta (m - rest)^2/l: gain = 2 beta/l, M = gain (m - rest); dm/dk = kb . p_k/2 (11.3). */
static void add_twist(joint *v, double gain, double M) {
  double quarter = 0.25 * M * v->inv_chi, half = 0.5 * M * v->inv_chi;
  hb_v3 sum = hb_v3_add(v->t[0], v->t[1]);
  for (int k = 0; k < 4; k++) {
    for (int l = k; l < 4; l++)
      v->second[k][l] += 0.25 * gain * v->along[k] * v->along[l] -
                         quarter * (v->along[k] * v->chi_slope[l] + v->along[l] * v->chi_slope[k]);
    v->gradient[k] += 0.5 * M * v->along[k];
    v->mixed[0][k] -= 0.5 * gain * v->along[k];
    v->mixed[1][k] += 0.5 * gain * v->along[k];
  }
  for (int k = 0; k < 2; k++) {
    hb_v3 turned = hb_v3_cross(v->p[k], sum);
    for (int l = 2; l < 4; l++) v->second[k][l] += half * hb_v3_dot(turned, v->p[l]);
  }
  v->turn[0] += gain;
  v->turn[1] += gain;
  v->turns -= gain;
}

/* Block between edge vectors of sides s <= r, row by row. A tangent also bends back towards its edge: -2
 * (t.de)(gradient.de)/|e|^2. */
static void edge_block(const joint *v, int s, int r, double E[9]) {
  double scale = v->inv_length[s] * v->inv_length[r];
  hb_v3 row[2], back = {0, 0, 0};
  for (int k = 0; k < 2; k++) {
    int n = 2 * s + k, m = 2 * r;
    double first = n <= m ? v->second[n][m] : v->second[m][n], last = v->second[n][m + 1];
    row[k] = hb_v3_axpy(hb_v3_scale(first, v->p[m]), last, v->p[m + 1]);
    if (s != r) continue;
    row[k] = hb_v3_axpy(row[k], -v->gradient[n], v->t[s]);
    back = hb_v3_axpy(back, -v->gradient[n], v->p[n]);
  }
  const double *p = &v->p[2 * s].x, *q = &v->p[2 * s + 1].x, *t = &v->t[s].x;
  for (int c = 0; c < 3; c++)
    hb_v3_store(E + 3 * c, hb_v3_scale(scale, hb_v3_axpy(hb_v3_axpy(hb_v3_scale(p[c], row[0]), q[c], row[1]),
                                                         t[c], back)));
}

/* Adds block (row by row) or its transpose at (row, column) of K; on the diagonal only the lower half. */
static inline void add_block(hb_band *K, int row, int column, const double *block) {
  double *at = K->a + (size_t)(K->half + 1) * (size_t)column + (size_t)(row - column);
  for (int c = 0; c < 3; c++, at += K->half)
    for (int r = row == column ? c : 0; r < 3; r++) at[r] += block[3 * c + r];
}

/* From edges to vertices: e^{i-1} = x_i - x_{i-1}, e^i = x_{i+1} - x_i. at: number of x_{i-1}; blocks between
 * the edges, row by row. */
static void scatter_edges(const double aa[9], const double ab[9], const double bb[9], int at, int stride,
                          hb_band *K) {
  double block[9];
  int x[3] = {at, at + stride, at + 2 * stride};
  add_block(K, x[0], x[0], aa);
  add_block(K, x[2], x[2], bb);
  for (int k = 0; k < 9; k++) block[k] = ab[k] - aa[k];
  add_block(K, x[1], x[0], block);
  for (int k = 0; k < 9; k++) block[k] = -ab[k];
  add_block(K, x[2], x[0], block);
  for (int k = 0; k < 9; k++) block[k] = ab[k] - bb[k];
  add_block(K, x[2], x[1], block);
  for (int c = 0; c < 3; c++)
    for (int r = 0; r < 3; r++)
      block[3 * c + r] = aa[3 * c + r] - ab[3 * c + r] - ab[3 * r + c] + bb[3 * c + r];
  add_block(K, x[1], x[1], block);
}

/* The blocks of a joint, and where they go. */
static void scatter(const joint *v, int at, int stride, hb_band *K) {
  double aa[9], ab[9], bb[9];
  edge_block(v, 0, 0, aa);
  edge_block(v, 0, 1, ab);
  edge_block(v, 1, 1, bb);
  scatter_edges(aa, ab, bb, at, stride, K);
}

/* An isotropic straight joint without twist needs no basis: W = 4 alpha (1 - c)/(l chi) depends on c = a . b
 * alone. With p = b - c a, q = a - c b the derivatives of c by the edge vectors are p/|e|, q/|e'|, and the
 * second ones -(p a^T + a p^T
 * + c (I - a a^T))/|e|^2, (I - a a^T)(I - b b^T)/(|e||e'|). gain: 8 alpha/l. */
static void add_plain(const hb_rod_work *w, int i, double gain, int at, int stride, hb_band *K) {
  const double *a = w->tangent + 3 * i - 3, *b = a + 3;
  double c = a[0] * b[0] + a[1] * b[1] + a[2] * b[2], inv = 1 / fmax(1 + c, HB_FOLD_LIMIT);
  double first = -gain * inv * inv, second = -2 * first * inv;
  double near = w->inv_length[i - 1], far = w->inv_length[i], both = near * far;
  double aa[9], ab[9], bb[9], p[3], q[3];
  for (int k = 0; k < 3; k++) {
    p[k] = b[k] - c * a[k];
    q[k] = a[k] - c * b[k];
  }
  for (int r = 0; r < 3; r++)
    for (int k = 0; k < 3; k++) {
      double one = r == k ? 1 : 0;
      aa[3 * r + k] = near * near *
                      (second * p[r] * p[k] - first * (p[r] * a[k] + a[r] * p[k] + c * (one - a[r] * a[k])));
      bb[3 * r + k] =
          far * far * (second * q[r] * q[k] - first * (q[r] * b[k] + b[r] * q[k] + c * (one - b[r] * b[k])));
      ab[3 * r + k] =
          both * (second * p[r] * q[k] + first * (one - a[r] * a[k] - b[r] * b[k] + c * a[r] * b[k]));
    }
  scatter_edges(aa, ab, bb, at, stride, K);
}

/* Rows and columns of the two turns. */
static void scatter_turns(const joint *v, int at, int stride, hb_band *K) {
  int x[3] = {at, at + stride, at + 2 * stride}, turn[2] = {at + stride - 1, at + 2 * stride - 1};
  for (int j = 0; j < 2; j++) {
    const double *mixed = v->mixed[j];
    hb_v3 a = hb_v3_axpy(hb_v3_scale(mixed[0], v->p[0]), mixed[1], v->p[1]);
    hb_v3 b = hb_v3_axpy(hb_v3_scale(mixed[2], v->p[2]), mixed[3], v->p[3]);
    a = hb_v3_scale(v->inv_length[0], a);
    b = hb_v3_scale(v->inv_length[1], b);
    hb_v3 by[3] = {hb_v3_scale(-1, a), hb_v3_sub(a, b), b};
    for (int n = 0; n < 3; n++) {
      const double *value = &by[n].x;
      for (int c = 0; c < 3; c++) {
        int k = x[n] + c;
        hb_band_add(K, k > turn[j] ? k : turn[j], k > turn[j] ? turn[j] : k, value[c]);
      }
    }
    hb_band_add(K, turn[j], turn[j], v->turn[j]);
  }
  hb_band_add(K, turn[1], turn[0], v->turns);
}

/* The basis of one side: the material frame of general rods, any normals of the others. */
static inline void set_side(joint *v, int side, const hb_rod *rod, const hb_state *state,
                            const hb_rod_work *w, int j) {
  hb_v3 t = hb_v3_load(w->tangent + 3 * j);
  hb_v3 d = rod->closed_form ? hb_any_normal(t) : hb_v3_load(state->m1 + 3 * (rod->first + j));
  v->t[side] = t;
  v->p[2 * side] = d;
  v->p[2 * side + 1] = hb_v3_cross(t, d);
  v->inv_length[side] = w->inv_length[j];
}

/* Vertex after vertex. */
void hb_rod_hessian(const hb_model *model, const hb_rod *rod, const hb_state *state, const hb_rod_work *work,
                    int stride, hb_band *K) {
  int span = rod->first_span;
  joint v;
  if (rod->twist_free) {
    for (int i = 1; i <= rod->last_joint; i++)
      add_plain(work, i, model->bend_gain[rod->first + i], stride * (i - 1), stride, K);
    hb_stretch_hessian(model, rod, work, stride, K);
    return;
  }
  set_side(&v, 1, rod, state, work, 0);
  for (int i = 1; i <= rod->last_joint; i++) {
    int k = rod->first + i;
    v.t[0] = v.t[1];
    v.p[0] = v.p[2];
    v.p[1] = v.p[3];
    v.inv_length[0] = v.inv_length[1];
    set_side(&v, 1, rod, state, work, i);
    v.inv_chi = 1 / fmax(1 + hb_v3_dot(v.t[0], v.t[1]), HB_FOLD_LIMIT);
    v.kb = hb_v3_scale(2 * v.inv_chi, hb_v3_cross(v.t[0], v.t[1]));
    memset(v.gradient, 0, sizeof v.gradient);
    memset(v.second, 0, sizeof v.second);
    memset(v.mixed, 0, sizeof v.mixed);
    v.turn[0] = v.turn[1] = v.turns = 0;
    look(&v);
    bool twists = !rod->closed_form;
    double moment = twists ? work->moment[i] : 0;
    if (rod->closed_form) {
      while (k > model->spans[span].last_edge) span++;
      twists = model->spans[span].panel_count > 0;
      moment = twists ? state->moment[span] : 0;
      bend_isotropic(&v, 0.25 * model->bend_gain[k]);
    } else {
      hb_v3 g = {0, 0, 0};
      for (int side = 0; side < 2; side++)
        g = hb_v3_add(g, bend_side(&v, side, 1 / model->voronoi[k], work->B_now + 3 * (i - 1 + side),
                                   work->omega + 4 * i + 2 * side, work->stress + 4 * i + 2 * side));
      add_curvature(&v, g);
    }
    if (twists) add_twist(&v, model->twist_gain[k], moment);
    scatter(&v, stride * (i - 1), stride, K);
    if (twists) scatter_turns(&v, stride * (i - 1), stride, K);
  }
  hb_stretch_hessian(model, rod, work, stride, K);
}

/* Held frames are none; in closed form only the inside of spans between two of them. */
void hb_rod_free_angles(const hb_model *model, const hb_rod *rod, bool *unknown) {
  int o = rod->first;
  for (int j = 0; j + 1 < rod->nv; j++) unknown[j] = !rod->closed_form && model->frame_of[o + j] < 0;
  if (!rod->closed_form) return;
  for (int s = rod->first_span; s < rod->first_span + rod->span_count; s++)
    for (int k = model->spans[s].first_edge + 1; k < model->spans[s].last_edge; k++)
      unknown[k - o] = model->spans[s].panel_count > 0;
}

/* Twist of all spans in closed form; else what the last look of the twist solver left. */
double hb_rod_energy(const hb_model *m, const hb_rod *rod, const hb_state *state, const hb_rod_work *w) {
  double sum = 0;
  for (int i = 1; i <= rod->last_joint; i++) {
    int k = rod->first + i;
    if (rod->closed_form) {
      double c = hb_v3_dot(hb_v3_load(w->tangent + 3 * i - 3), hb_v3_load(w->tangent + 3 * i));
      hb_v3 turn = hb_v3_sub(hb_v3_load(w->tangent + 3 * i), hb_v3_load(w->tangent + 3 * i - 3));
      /* 1 - c = |b - a|^2/2, without cancellation */
      sum += 0.25 * m->bend_gain[k] * hb_v3_dot(turn, turn) / fmax(1 + c, HB_FOLD_LIMIT);
      continue;
    }
    for (int side = 0; side < 2; side++) {
      const double *omega = w->omega + 4 * i + 2 * side, *rest = m->rest_omega + 4 * k + 2 * side,
                   *stress = w->stress + 4 * i + 2 * side;
      double a = omega[0] - rest[0], b = omega[1] - rest[1];
      sum += 0.5 * (a * stress[0] + b * stress[1]) / m->voronoi[k];
    }
    if (m->twist_gain[k] > 0) sum += 0.5 * w->moment[i] * w->moment[i] / m->twist_gain[k];
  }
  for (int s = rod->first_span; rod->closed_form && s < rod->first_span + rod->span_count; s++)
    sum += 0.5 * state->moment[s] * state->moment[s] * m->spans[s].compliance;
  return sum + hb_stretch_energy(m, rod, w);
}
