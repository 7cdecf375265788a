/* One rod: shapes first, then what varies along them. */
#include "scene/read.h"

#include "base/memory.h"
#include "hebra/curve.h"
#include "math/rotation.h"

#include <stdio.h>
#include <string.h>

/* Copies an array of 3 n doubles. */
static hb_status copy_shape(const hb_scene_reader *r, const double *from, int n, double **to) {
  *to = hb_alloc(3 * (size_t)n, sizeof **to);
  if (!*to) return hb_fail_memory(r->err, "shape");
  memcpy(*to, from, 3 * (size_t)n * sizeof **to);
  return HB_OK;
}

/* closed: false | true | {turns: number} | {twist: radians} | {link: number} */
static hb_status read_closing(hb_scene_reader *r, const hb_node *node, hb_rod_def *rod) {
  static const char *const keys[] = {"turns", "twist", "link", NULL};
  static const hb_closing kinds[] = {HB_CLOSING_TURNS, HB_CLOSING_TWIST, HB_CLOSING_LINK};
  const hb_node *closed = hb_node_find(node, "closed"), *used = NULL;
  bool flag = false;
  if (!closed) return HB_OK;
  if (closed->kind == HB_NODE_SCALAR) {
    if (strcmp(closed->text, "true") != 0 && strcmp(closed->text, "false") != 0)
      return hb_scene_expected(r, closed, "true, false, or a mapping with one of turns, twist, link");
    hb_status status = hb_scene_flag(r, closed, &flag);
    if (!status && flag) rod->closing = HB_CLOSING_TURNS;
    return status;
  }
  hb_status status = hb_scene_check_keys(r, closed, keys);
  for (int k = 0; !status && k < 3; k++) {
    const hb_node *child = hb_node_find(closed, keys[k]);
    if (!child) continue;
    if (used)
      return hb_scene_fail_key(r, child, "\"%s\" is given already; one of turns, twist, link is expected",
                               used->key);
    used = child;
    rod->closing = kinds[k];
    status = hb_scene_number(r, child, HB_RULE_ANY, &rod->closing_value);
  }
  if (!status && !used)
    return hb_scene_fail_key(r, closed, "nothing is given; one of turns, twist, link is expected (or true)");
  return status;
}

/* start and end belong to open rods. */
static hb_status check_ends(hb_scene_reader *r, const hb_node *node, const hb_rod_def *rod) {
  static const char *const ends[] = {"start", "end"};
  for (int k = 0; rod->closing != HB_CLOSING_NONE && k < 2; k++) {
    const hb_node *child = hb_node_find(node, ends[k]);
    if (child)
      return hb_scene_fail_key(
          r, child, "a closed rod has no %s; vertices and edges of it are held by \"supports\"", ends[k]);
  }
  return HB_OK;
}

/* rest and initial; either may be missing and is then like the other. */
static hb_status read_shapes(hb_scene_reader *r, const hb_node *node, hb_rod_def *rod) {
  const hb_node *rest = hb_node_find(node, "rest"), *initial = hb_node_find(node, "initial");
  /* both shapes alike, so that edges keep their lengths from one to the other */
  bool divides = hb_scene_curve_divides(rest) && hb_scene_curve_divides(initial);
  const bool halves[2] = {divides && hb_scene_has_wall(hb_node_find(node, "start")),
                          divides && hb_scene_has_wall(hb_node_find(node, "end"))};
  int count = 0;
  if (!rest && !initial)
    return hb_scene_fail_key(r, node, "the shape is missing; \"rest\", \"initial\" or both are expected");
  /* a closed rod may be open at rest, like a straight one that was bent into a ring */
  bool closed = rod->closing != HB_CLOSING_NONE;
  hb_scene_ends now = closed ? HB_ENDS_CLOSED : HB_ENDS_OPEN,
                before = closed && hb_scene_curve_generates(initial) ? HB_ENDS_MAY_MEET : now;
  hb_status status = HB_OK;
  if (rest) status = hb_scene_read_curve(r, rest, NULL, 0, halves, before, &rod->rest, &rod->nv);
  if (!status && initial)
    status = hb_scene_read_curve(r, initial, rod->rest, rod->nv, halves, now, &rod->initial, &count);
  if (!status && !rest) {
    rod->nv = count;
    status = copy_shape(r, rod->initial, count, &rod->rest);
  }
  if (!status && !initial) status = copy_shape(r, rod->rest, rod->nv, &rod->initial);
  return status;
}

/* straight_rest, lengths */
static hb_status read_flags(hb_scene_reader *r, const hb_node *node, hb_rod_def *rod) {
  static const char *const words[] = {"rest", "initial", NULL};
  int lengths = 0;
  hb_status status = hb_scene_flag(r, hb_node_find(node, "straight_rest"), &rod->straight_rest);
  if (!status) status = hb_scene_choice(r, hb_node_find(node, "lengths"), words, &lengths);
  rod->lengths_from_initial = lengths == 1;
  const hb_node *curvature = hb_node_find(node, "natural_curvature");
  const hb_node *directors = hb_node_find(node, "rest_directors");
  if (!directors) directors = hb_node_find(node, "rest_director");
  if (!status && curvature && rod->straight_rest)
    return hb_scene_fail_key(r, curvature,
                             "straight_rest: true is given already; a rod is straight at rest or has a "
                             "natural curvature");
  if (!status && curvature && directors)
    return hb_scene_fail_key(r, directors,
                             "natural_curvature is given already and makes the rest shape; use \"director\"");
  return status;
}

/* natural_twist at the vertices. */
static hb_status read_natural_twist(hb_scene_reader *r, const hb_node *node, const hb_scene_arc *arc,
                                    hb_rod_def *rod) {
  const hb_node *twist = hb_node_find(node, "natural_twist");
  if (!twist) return HB_OK;
  rod->natural_twist = hb_alloc((size_t)arc->nv, sizeof *rod->natural_twist);
  if (!rod->natural_twist) return hb_fail_memory(r->err, "natural twist");
  return hb_scene_along(r, twist, arc, false, HB_RULE_ANY, rod->natural_twist, 1);
}

/* Unit tangent of edge j. */
static hb_v3 tangent_of(const double *x, int j) {
  return hb_v3_unit(hb_v3_sub(hb_v3_load(x + 3 * j + 3), hb_v3_load(x + 3 * j)));
}

/* What a director in rest_m1 cannot say about the twist of vertex i: whole turns. They stay in natural_twist.
 */
static void keep_turns(const hb_scene_arc *arc, hb_rod_def *rod, int i) {
  if (!rod->natural_twist) return;
  double l = 0.5 * (arc->s[i + 1] - arc->s[i - 1]), twist = rod->natural_twist[i] * l;
  double seen = hb_nearest_angle(twist, 0);
  rod->natural_twist[i] = l > 0 ? (twist - seen) / l : 0;
}

/* Directors of a rest shape that is closed, made to meet themselves: what they lack after one way around,
 * evenly. */
static void join_directors(const hb_scene_arc *arc, hb_rod_def *rod) {
  int n = rod->nv - 1;
  hb_v3 first = tangent_of(rod->rest, 0), last = tangent_of(rod->rest, n - 1);
  hb_v3 around = hb_transport(hb_v3_load(rod->rest_m1 + 3 * (n - 1)), last, first);
  double missing = hb_angle_about(around, hb_v3_load(rod->rest_m1), first), turned = 0;
  for (int j = 1; j < n; j++) {
    turned += missing * 0.5 * (arc->s[j + 1] - arc->s[j - 1]) / arc->s[n];
    hb_v3_store(rod->rest_m1 + 3 * j,
                hb_turn(hb_v3_load(rod->rest_m1 + 3 * j), tangent_of(rod->rest, j), turned));
  }
}

/* Directors on the rest shape: parallel transport of the first, turned by the natural twist. */
static void spread_directors(const hb_scene_arc *arc, hb_v3 first, hb_rod_def *rod) {
  hb_v3 t = tangent_of(rod->rest, 0), m1 = hb_project_normal(first, t);
  hb_v3_store(rod->rest_m1, m1);
  for (int i = 1; i + 1 < rod->nv; i++) {
    hb_v3 next = tangent_of(rod->rest, i);
    double twist = rod->natural_twist ? rod->natural_twist[i] * 0.5 * (arc->s[i + 1] - arc->s[i - 1]) : 0;
    m1 = hb_turn(hb_transport(m1, t, next), next, twist);
    hb_v3_store(rod->rest_m1 + 3 * i, m1);
    keep_turns(arc, rod, i);
    t = next;
  }
}

/* A director must not lie along its edge. */
static hb_status check_director(const hb_scene_reader *r, const hb_node *node, const double *d, hb_v3 t) {
  hb_v3 v = hb_v3_load(d);
  hb_v3 across = hb_v3_axpy(v, -hb_v3_dot(v, t), t);
  if (hb_v3_norm(across) > 1e-6 * hb_v3_norm(v)) return HB_OK;
  return hb_scene_fail(r, node, "[%g, %g, %g] lies along the edge; a direction across it is expected", d[0],
                       d[1], d[2]);
}

/* director, rest_director, rest_directors */
static hb_status read_directors(hb_scene_reader *r, const hb_node *node, const hb_scene_arc *arc,
                                hb_rod_def *rod) {
  const hb_node *now = hb_node_find(node, "director"), *one = hb_node_find(node, "rest_director");
  const hb_node *all = hb_node_find(node, "rest_directors"), *second = hb_node_find(node, "natural_twist");
  double d[3];
  char what[80];
  hb_status status = hb_scene_direction(r, now, rod->first_director);
  if (!status && now) status = check_director(r, now, rod->first_director, tangent_of(rod->initial, 0));
  if (status || (!one && !all)) return status;
  if (!second || !all) second = one && all ? one : NULL;
  if (second)
    return hb_scene_fail_key(r, second,
                             "\"rest_directors\" is given already, which says all about the twist at rest");
  rod->rest_m1 = hb_alloc(3 * (size_t)(rod->nv - 1), sizeof *rod->rest_m1);
  if (!rod->rest_m1) return hb_fail_memory(r->err, "rest directors");
  if (one) {
    status = hb_scene_direction(r, one, d);
    if (!status) status = check_director(r, one, d, tangent_of(rod->rest, 0));
    if (!status) spread_directors(arc, hb_v3_load(d), rod);
    const double *end = rod->rest + 3 * (size_t)(rod->nv - 1);
    bool meets = hb_v3_norm(hb_v3_sub(hb_v3_load(end), hb_v3_load(rod->rest))) == 0;
    if (!status && rod->closing != HB_CLOSING_NONE && meets) join_directors(arc, rod);
    return status;
  }
  snprintf(what, sizeof what, "a list of %d directions [x, y, z], one per edge,", rod->nv - 1);
  status = hb_scene_list(r, all, rod->nv - 1, what);
  for (int j = 0; !status && j + 1 < rod->nv; j++) {
    status = hb_scene_direction(r, all->children[j], rod->rest_m1 + 3 * j);
    if (!status) status = check_director(r, all->children[j], rod->rest_m1 + 3 * j, tangent_of(rod->rest, j));
  }
  return status;
}

/* Builds the rest shape from its curvature: at each vertex the material curvature (k1, k2) times the length
 * that belongs to the vertex is kb = k1 m2 - k2 m1, and |kb| = 2 tan(phi/2) is the turn of the tangent about
 * kb. The material frame takes half of the vertex's twist before the turn and half after it. */
static void build_rest(const hb_scene_arc *arc, const double *k1, const double *k2, hb_v3 m1,
                       hb_rod_def *rod) {
  hb_v3 t = tangent_of(rod->initial, 0), x = hb_v3_load(rod->initial);
  m1 = hb_project_normal(m1, t);
  for (int j = 0; j + 1 < rod->nv; j++) {
    hb_v3_store(rod->rest_m1 + 3 * j, m1);
    hb_v3_store(rod->rest + 3 * j, x);
    x = hb_v3_axpy(x, arc->s[j + 1] - arc->s[j], t);
    hb_v3_store(rod->rest + 3 * j + 3, x);
    if (j + 2 == rod->nv) break;
    double l = 0.5 * (arc->s[j + 2] - arc->s[j]),
           twist = rod->natural_twist ? rod->natural_twist[j + 1] * l : 0;
    hb_v3 half = hb_turn(m1, t, 0.5 * twist), m2 = hb_v3_cross(t, half);
    hb_v3 kb = hb_v3_axpy(hb_v3_scale(k1[j + 1] * l, m2), -k2[j + 1] * l, half);
    hb_quat turn = {1, hb_v3_scale(0.5, kb)};
    t = hb_v3_unit(hb_quat_rotate(turn, t));
    m1 = hb_project_normal(hb_turn(hb_quat_rotate(turn, half), t, 0.5 * twist), t);
    keep_turns(arc, rod, j + 1);
  }
}

/* natural_curvature: [k1, k2], formulas of s in the material frame */
static hb_status read_curvature(hb_scene_reader *r, const hb_node *node, const hb_scene_arc *arc,
                                hb_rod_def *rod) {
  const hb_node *list = hb_node_find(node, "natural_curvature");
  if (!list) return HB_OK;
  hb_status status = hb_scene_list(r, list, 2, "a list [k1, k2] of two numbers or formulas");
  if (status) return status;
  size_t n = (size_t)rod->nv;
  double *k1 = hb_alloc(n, sizeof *k1), *k2 = hb_alloc(n, sizeof *k2);
  rod->rest_m1 = hb_alloc(3 * (n - 1), sizeof *rod->rest_m1);
  status = k1 && k2 && rod->rest_m1 ? HB_OK : hb_fail_memory(r->err, "natural curvature");
  if (!status) status = hb_scene_along(r, list->children[0], arc, false, HB_RULE_ANY, k1, 1);
  if (!status) status = hb_scene_along(r, list->children[1], arc, false, HB_RULE_ANY, k2, 1);
  hb_v3 given = hb_v3_load(rod->first_director);
  if (!status)
    build_rest(arc, k1, k2, hb_v3_norm(given) > 0 ? given : hb_any_normal(tangent_of(rod->initial, 0)), rod);
  bool built = !hb_node_find(node, "initial") && rod->closing == HB_CLOSING_NONE;
  if (!status && built) memcpy(rod->initial, rod->rest, 3 * n * sizeof *rod->rest);
  hb_free(k1);
  hb_free(k2);
  return status;
}

/* velocity, damping, radius */
static hb_status read_motion(hb_scene_reader *r, const hb_node *node, const hb_scene_arc *arc,
                             hb_rod_def *rod) {
  static const char *const keys[] = {"mass", "bending", NULL};
  const hb_node *velocity = hb_node_find(node, "velocity"), *damping = hb_node_find(node, "damping");
  hb_scene_arc placed = *arc;
  placed.place = rod->initial;
  hb_status status = HB_OK;
  if (velocity) {
    rod->velocity = hb_alloc(3 * (size_t)rod->nv, sizeof *rod->velocity);
    if (!rod->velocity) return hb_fail_memory(r->err, "velocity");
    status = hb_scene_along_vector(r, velocity, &placed, rod->velocity);
  }
  if (!status && damping) status = hb_scene_check_keys(r, damping, keys);
  if (!status)
    status = hb_scene_number(r, hb_node_find(damping, "mass"), HB_RULE_NOT_NEGATIVE, &rod->mass_damping);
  const hb_node *viscosity = hb_node_find(damping, "bending");
  if (!status && viscosity) {
    rod->viscosity = hb_alloc((size_t)rod->nv, sizeof *rod->viscosity);
    if (!rod->viscosity) return hb_fail_memory(r->err, "viscosity");
    status = hb_scene_along(r, viscosity, arc, true, HB_RULE_NOT_NEGATIVE, rod->viscosity, 1);
  }
  return status ? status : hb_scene_number(r, hb_node_find(node, "radius"), HB_RULE_POSITIVE, &rod->radius);
}

/* Everything that varies along the rod. */
static hb_status read_along(hb_scene_reader *r, const hb_node *node, hb_rod_def *rod) {
  double *s = hb_alloc((size_t)rod->nv, sizeof *s);
  if (!s) return hb_fail_memory(r->err, "arc length");
  hb_scene_arc_lengths(rod->lengths_from_initial ? rod->initial : rod->rest, rod->nv, s);
  hb_scene_arc arc = {.nv = rod->nv, .s = s};
  rod->radius = s[rod->nv - 1] / 100;
  hb_status status = hb_scene_read_moduli(r, node, &arc, rod);
  if (!status) status = read_natural_twist(r, node, &arc, rod);
  if (!status) status = read_directors(r, node, &arc, rod);
  if (!status) status = read_curvature(r, node, &arc, rod);
  if (!status) status = read_motion(r, node, &arc, rod);
  hb_free(s);
  return status;
}

/* One rod, or one copy of it. */
hb_status hb_scene_read_rod(hb_scene_reader *r, const hb_node *node, hb_rod_def *rod) {
  hb_scene_place(node, &rod->line, &rod->column);
  hb_status status = read_closing(r, node, rod);
  if (!status) status = check_ends(r, node, rod);
  if (!status) status = read_shapes(r, node, rod);
  if (!status) status = read_flags(r, node, rod);
  if (!status) status = read_along(r, node, rod);
  if (!status) status = hb_scene_read_supports(r, node, rod);
  return status;
}
