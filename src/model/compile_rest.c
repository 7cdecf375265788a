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
    bool interior = i > 0 && i + 1 < nv;
    m->voronoi[k] = interior ? before + after : 0;
    if (interior && i == 1 && walls[0]) m->voronoi[k] += before;
    if (interior && i == nv - 2 && walls[1]) m->voronoi[k] += after;
    m->weight[k] = 0.5 * (before + after);
    m->mass[k] = def->mass[i];
    for (int c = 0; c < 3; c++) m->inv_mass[3 * k + c] = 1 / def->mass[i];
    m->beta[k] = interior ? def->beta[i] : 0;
    m->twist_gain[k] = interior ? 2 * def->beta[i] / m->voronoi[k] : 0;
  }
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

/* Rest curvature and twist, from the rest shape and its directors. Returns the largest rest curvature. */
static double compile_curvature(hb_model *m, const hb_rod_def *def, const hb_rod *rod) {
  double largest = 0;
  hb_v3 t = tangent_of(def->rest, 0);
  hb_v3 m1 = first_rest_director(def, t);
  for (int i = 1; i + 1 < rod->nv; i++) {
    int k = rod->first + i;
    hb_v3 t_next = tangent_of(def->rest, i), carried = hb_transport(m1, t, t_next), m1_next;
    /* between given directors lies what they say and no more */
    double cell = def->rest_m1 ? m->rest_length[k - 1] + m->rest_length[k] : m->voronoi[k];
    double twist = def->natural_twist ? def->natural_twist[i] * 0.5 * cell : 0;
    if (def->rest_m1) {
      m1_next = hb_project_normal(hb_v3_load(def->rest_m1 + 3 * i), t_next);
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
  return largest;
}

/* Stiffnesses: B per edge, the scalar bending modulus per vertex, B times rest curvature. */
static void compile_stiffness(hb_model *m, const hb_rod_def *def, const hb_rod *rod) {
  for (int j = 0; j + 1 < rod->nv; j++) {
    int k = rod->first + j;
    for (int c = 0; c < 3; c++) m->B[3 * k + c] = def->B[3 * j + c];
    if (def->viscosity) m->viscosity[k] = def->viscosity[j];
  }
  for (int i = 1; i + 1 < rod->nv; i++) {
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

/* One rod's rows of the tables. */
void hb_compile_rest(hb_model *m, int r) {
  const hb_rod_def *def = &m->def->rods[r];
  hb_rod *rod = &m->rods[r];
  compile_lengths(m, def, rod);
  bool straight = compile_curvature(m, def, rod) < straight_limit(def);
  if (straight)
    for (int k = 4 * rod->first; k < 4 * (rod->first + rod->nv); k++) m->rest_omega[k] = 0;
  compile_stiffness(m, def, rod);
  rod->closed_form = isotropic(def) && straight && !def->viscosity;
  hb_v3 t_rest = tangent_of(def->rest, 0), t0 = tangent_of(def->initial, 0),
        given = hb_v3_load(def->first_director);
  hb_v3 u0 = hb_v3_norm(given) > 0 ? hb_project_normal(given, t0)
                                   : hb_transport(first_rest_director(def, t_rest), t_rest, t0);
  hb_v3_store(&m->start_m1[3 * r], u0);
}
