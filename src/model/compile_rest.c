/* The rest shape of one rod as numbers: lengths, stiffness per vertex, rest curvature and twist (docs/theory,
 * 2). */
#include "model/compile.h"

#include "math/rotation.h"

#include <float.h>

/* Rest curvatures below this are the round-off of a straight line: of its direction, and of coordinates that
 * are big against the edges. */
static double straight_limit(const hb_rod_def *def) {
  double biggest = 0, shortest = HUGE_VAL;
  for (int k = 0; k < 3 * def->nv; k++) biggest = fmax(biggest, fabs(def->rest[k]));
  for (int j = 0; j + 1 < def->nv; j++)
    shortest = fmin(shortest,
                    hb_v3_norm(hb_v3_sub(hb_v3_load(def->rest + 3 * j + 3), hb_v3_load(def->rest + 3 * j))));
  return 1e-12 + 8 * DBL_EPSILON * biggest / shortest;
}

/* Unit tangent of edge j of a polyline. */
static hb_v3 tangent_of(const double *x, int j) {
  return hb_v3_unit(hb_v3_sub(hb_v3_load(x + 3 * j + 3), hb_v3_load(x + 3 * j)));
}

/* Is the rod clamped at its first, its last vertex? Such a vertex's whole edge belongs to its neighbour's
 * cell (docs/theory, 2.7). */
static void find_walls(const hb_rod_def *def, bool walls[2]) {
  walls[0] = walls[1] = false;
  for (int k = 0; k < def->support_count; k++)
    if (def->supports[k].kind == HB_SUPPORT_TANGENT && def->supports[k].wall)
      walls[def->supports[k].base_is_end] = true;
}

/* The vertex where a closed rod's ends meet: half of it in the first slot, half in the last, to the same
 * bits; its joint is that of the last slot. */
static void share_seam(hb_model *m, const hb_rod_def *def, const hb_rod *rod) {
  int a = rod->first, b = rod->first + rod->nv - 1;
  m->weight[a] = m->weight[b] = 0.25 * m->voronoi[b];
  m->mass[a] = m->mass[b] = 0.5 * (def->mass[0] + def->mass[rod->nv - 1]);
  for (int c = 0; c < 3; c++) m->inv_mass[3 * a + c] = m->inv_mass[3 * b + c] = 1 / m->mass[a];
  m->beta[b] = 0.5 * (def->beta[0] + def->beta[rod->nv - 1]);
  m->twist_gain[b] = 2 * m->beta[b] / m->voronoi[b];
}

/* Lengths, arc length, Voronoi lengths and masses. */
static void compile_lengths(hb_model *m, const hb_rod_def *def, hb_rod *rod) {
  const double *shape = def->lengths_from_initial ? def->initial : def->rest;
  int first = rod->first, nv = rod->nv;
  bool walls[2];
  find_walls(def, walls);
  for (int j = 0; j + 1 < nv; j++) {
    double l = hb_v3_norm(hb_v3_sub(hb_v3_load(shape + 3 * j + 3), hb_v3_load(shape + 3 * j)));
    m->rest_length[first + j] = l;
    m->inv_rest_length[first + j] = 1 / l;
    m->arc[first + j + 1] = m->arc[first + j] + l;
  }
  rod->length = m->arc[first + nv - 1];
  for (int i = 0; i < nv; i++) {
    int k = first + i;
    double before = i > 0 ? m->rest_length[k - 1] : 0, after = i + 1 < nv ? m->rest_length[k] : 0;
    bool interior = i > 0 && i <= rod->last_joint;
    if (rod->closed && i + 1 == nv) after = m->rest_length[first];
    m->voronoi[k] = interior ? before + after : 0;
    if (interior && i == 1 && walls[0]) m->voronoi[k] += before;
    if (interior && i == nv - 2 && walls[1]) m->voronoi[k] += after;
    m->weight[k] = 0.5 * (before + after);
    m->mass[k] = def->mass[i];
    for (int c = 0; c < 3; c++) m->inv_mass[3 * k + c] = 1 / def->mass[i];
    m->beta[k] = interior ? def->beta[i] : 0;
    m->twist_gain[k] = interior ? 2 * def->beta[i] / m->voronoi[k] : 0;
  }
  if (rod->closed) share_seam(m, def, rod);
}

/* The first director of the rest shape. */
static hb_v3 first_rest_director(const hb_rod_def *def, hb_v3 t) {
  hb_v3 given = hb_v3_load(def->first_director);
  if (def->rest_m1) return hb_project_normal(hb_v3_load(def->rest_m1), t);
  return hb_v3_norm(given) > 0 ? hb_project_normal(given, t) : hb_any_normal(t);
}

/* omega = (kb . m2, -kb . m1) in the frame (t, m1). */
static void material_curvature(hb_v3 kb, hb_v3 t, hb_v3 m1, double omega[2]) {
  omega[0] = hb_v3_dot(kb, hb_v3_cross(t, m1));
  omega[1] = -hb_v3_dot(kb, m1);
}

/* Natural twist per length at vertex i. */
static double twist_rate(const hb_rod_def *def, const hb_rod *rod, int i) {
  if (!def->natural_twist) return 0;
  return rod->closed && i + 1 == rod->nv ? 0.5 * (def->natural_twist[0] + def->natural_twist[i])
                                         : def->natural_twist[i];
}

/* The joint of a closed rod that is not closed at rest: what its neighbours have per length, the mean of it.
 */
static void mean_joint(hb_model *m, const hb_rod *rod) {
  int k = rod->first + rod->nv - 1, before = k - 1, behind = rod->first + 1;
  double a = m->voronoi[k] / m->voronoi[before], b = m->voronoi[k] / m->voronoi[behind];
  m->rest_twist[k] = 0.5 * (a * m->rest_twist[before] + b * m->rest_twist[behind]);
  for (int c = 0; c < 2; c++) {
    m->rest_omega[4 * k + c] = a * m->rest_omega[4 * before + 2 + c];
    m->rest_omega[4 * k + 2 + c] = b * m->rest_omega[4 * behind + c];
  }
}

/* Rest curvature and twist, from the rest shape and its directors, up to vertex `last`. extra: twist per
 * length beyond what the definition says. *missing: where the last vertex is the first, the angle from the
 * material frame that was carried once around to where it began. Returns the largest rest curvature. */
static double compile_curvature(hb_model *m, const hb_rod_def *def, const hb_rod *rod, int last, double extra,
                                double *missing) {
  double largest = 0;
  hb_v3 t = tangent_of(def->rest, 0);
  hb_v3 m1 = first_rest_director(def, t);
  *missing = 0;
  for (int i = 1; i <= last; i++) {
    int k = rod->first + i, j = i + 1 < rod->nv ? i : 0;
    hb_v3 t_next = tangent_of(def->rest, j), carried = hb_transport(m1, t, t_next), m1_next;
    /* between given directors lies what they say and no more */
    double cell = def->rest_m1 ? m->rest_length[k - 1] + m->rest_length[rod->first + j] : m->voronoi[k];
    double twist = (twist_rate(def, rod, i) + extra) * 0.5 * cell;
    if (def->rest_m1) {
      m1_next = hb_project_normal(hb_v3_load(def->rest_m1 + 3 * j), t_next);
      twist += hb_angle_about(carried, m1_next, t_next);
    } else {
      m1_next = hb_turn(carried, t_next, twist);
    }
    m->rest_twist[k] = twist;
    if (!def->straight_rest) {
      hb_v3 kb = hb_v3_scale(2 / (1 + hb_v3_dot(t, t_next)), hb_v3_cross(t, t_next));
      largest = fmax(largest, hb_v3_norm(kb));
      material_curvature(kb, t, m1, &m->rest_omega[4 * k]);
      material_curvature(kb, t_next, m1_next, &m->rest_omega[4 * k + 2]);
    }
    t = t_next;
    m1 = m1_next;
  }
  if (last + 1 == rod->nv) *missing = hb_angle_about(m1, first_rest_director(def, t), t);
  return largest;
}

/* The same for rods of either kind. A frame that is not given, but has to meet itself at rest, gets what it
 * lacks evenly. */
static double compile_turns(hb_model *m, const hb_rod_def *def, const hb_rod *rod) {
  bool around = rod->closed && !def->straight_rest && hb_compile_is_closed(def->rest, rod->nv);
  int last = around ? rod->nv - 1 : rod->nv - 2;
  double missing, largest = compile_curvature(m, def, rod, last, 0, &missing);
  if (around && !def->rest_m1) {
    double length = rod->length;
    largest = compile_curvature(m, def, rod, last, missing / length, &missing);
  }
  if (rod->closed && !around) mean_joint(m, rod);
  return largest;
}

/* Stiffnesses: B per edge, the scalar bending modulus per vertex, B times rest curvature. */
static void compile_stiffness(hb_model *m, const hb_rod_def *def, const hb_rod *rod) {
  for (int j = 0; j + 1 < rod->nv; j++) {
    int k = rod->first + j;
    for (int c = 0; c < 3; c++) m->B[3 * k + c] = def->B[3 * j + c];
    if (def->viscosity) m->viscosity[k] = def->viscosity[j];
    if (def->stretching) m->stretching[k] = def->stretching[j];
  }
  if (rod->closed) { /* behind the last edge comes the first */
    int first = rod->first, behind = rod->first + rod->nv - 1;
    for (int c = 0; c < 3; c++) m->B[3 * behind + c] = m->B[3 * first + c];
    m->viscosity[behind] = m->viscosity[first];
  }
  for (int i = 1; i <= rod->last_joint; i++) {
    int k = rod->first + i;
    m->alpha[k] = 0.5 * (m->B[3 * k - 3] + m->B[3 * k]);
    m->bend_gain[k] = 8 * m->alpha[k] / m->voronoi[k];
    for (int side = 0; side < 2; side++) {
      const double *B = &m->B[3 * (k - 1 + side)], *w = &m->rest_omega[4 * k + 2 * side];
      m->rest_pull[4 * k + 2 * side] = B[0] * w[0] + B[1] * w[1];
      m->rest_pull[4 * k + 2 * side + 1] = B[1] * w[0] + B[2] * w[1];
    }
  }
}

/* Is B a multiple of the identity on every edge? */
static bool isotropic(const hb_rod_def *def) {
  for (int j = 0; j + 1 < def->nv; j++)
    if (def->B[3 * j + 1] != 0 || def->B[3 * j] != def->B[3 * j + 2]) return false;
  return true;
}

/* Is the material frame of some edge prescribed? */
static bool holds_frames(const hb_rod_def *def) {
  for (int k = 0; k < def->support_count; k++)
    if (def->supports[k].kind == HB_SUPPORT_ANGLE || def->supports[k].kind == HB_SUPPORT_DIRECTOR)
      return true;
  return false;
}

/* One rod's rows of the tables. */
void hb_compile_rest(hb_model *m, int r) {
  const hb_rod_def *def = &m->def->rods[r];
  hb_rod *rod = &m->rods[r];
  compile_lengths(m, def, rod);
  bool straight = compile_turns(m, def, rod) < straight_limit(def);
  if (straight)
    for (int k = 4 * rod->first; k < 4 * (rod->first + rod->nv); k++) m->rest_omega[k] = 0;
  compile_stiffness(m, def, rod);
  rod->closed_form = isotropic(def) && straight && !def->viscosity;
  if (rod->closed && holds_frames(def)) rod->closed_form = false; /* its spans would lead over the joint */
  hb_v3 t_rest = tangent_of(def->rest, 0), t0 = tangent_of(def->initial, 0),
        given = hb_v3_load(def->first_director);
  hb_v3 u0 = hb_v3_norm(given) > 0 ? hb_project_normal(given, t0)
                                   : hb_transport(first_rest_director(def, t_rest), t_rest, t0);
  hb_v3_store(&m->start_m1[3 * r], u0);
}
