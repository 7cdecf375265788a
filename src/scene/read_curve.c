/* Curves: one generator, then changes in a fixed order: resample, scale, rotate, move, displace, perturb. */
#include "scene/read.h"

#include "base/memory.h"
#include "hebra/curve.h"
#include "math/rotation.h"

#include <stdio.h>
#include <string.h>

/* A polyline on its way from a generator to a rod. */
typedef struct polyline {
  double *xyz;
  int count;
  int wanted;         /* vertices when the generator does not say; 0: it must */
  const bool *halves; /* first, last edge half as long as the others; may be NULL */
  int fine;           /* vertices of the division into halves that xyz holds; 0: none */
  bool meets;         /* the last vertex is the first, and stays it */
} polyline;

/* One generator: reads its node and fills xyz and count. */
typedef struct generator {
  const char *key;
  hb_status (*make)(hb_scene_reader *r, const hb_node *node, polyline *line);
} generator;

/* Ends further apart than this part of the shortest edge do not meet. */
#define MEETING 1e-9

/* How far the last vertex is from the first, as a part of the shortest edge; last is put onto first if that
 * is round-off. */
static double join_ends(polyline *line) {
  double shortest = HUGE_VAL;
  double *last = line->xyz + 3 * (size_t)(line->count - 1);
  for (int j = 0; j + 2 < line->count; j++)
    shortest = fmin(shortest,
                    hb_v3_norm(hb_v3_sub(hb_v3_load(line->xyz + 3 * j + 3), hb_v3_load(line->xyz + 3 * j))));
  double gap = hb_v3_norm(hb_v3_sub(hb_v3_load(last), hb_v3_load(line->xyz)));
  if (!(gap <= MEETING * shortest)) return gap / shortest;
  memcpy(last, line->xyz, 3 * sizeof *last);
  line->meets = true;
  return 0;
}

/* One more edge, back to the first vertex. */
static hb_status close_line(hb_scene_reader *r, const hb_node *node, polyline *line) {
  if (line->count >= r->limits.vertices - r->vertices)
    return hb_scene_fail(r, node, "the scene would hold more than %ld vertices, which is not allowed",
                         r->limits.vertices);
  double *grown = hb_realloc(line->xyz, 3 * ((size_t)line->count + 1), sizeof *grown);
  if (!grown) return hb_fail_memory(r->err, "vertices");
  r->vertices++;
  line->xyz = grown;
  memcpy(grown + 3 * (size_t)line->count, grown, 3 * sizeof *grown);
  line->count++;
  line->meets = true;
  return HB_OK;
}

/* What the ends of a new curve do. */
static hb_status settle_ends(hb_scene_reader *r, const hb_node *node, hb_scene_ends ends, polyline *line) {
  if (ends == HB_ENDS_OPEN || line->count < 3) return HB_OK;
  if (join_ends(line) == 0 || ends == HB_ENDS_MAY_MEET) return HB_OK;
  return close_line(r, node, line);
}

/* Allocates count vertices within the scene's limit. */
static hb_status make_room(hb_scene_reader *r, const hb_node *node, int count, polyline *line) {
  if (count > r->limits.vertices - r->vertices)
    return hb_scene_fail(r, node, "the scene would hold more than %ld vertices, which is not allowed",
                         r->limits.vertices);
  r->vertices += count;
  line->xyz = hb_alloc(3 * (size_t)count, sizeof *line->xyz);
  line->count = count;
  return line->xyz ? HB_OK : hb_fail_memory(r->err, "vertices");
}

/* With half edges at an end a curve is divided into edges half as long first: room for that. */
static hb_status refine(hb_scene_reader *r, polyline *line) {
  if (!line->halves || !(line->halves[0] || line->halves[1])) return HB_OK;
  hb_free(line->xyz);
  line->fine = 2 * (line->count - 1) - line->halves[0] - line->halves[1] + 1;
  line->xyz = hb_alloc(3 * (size_t)line->fine, sizeof *line->xyz);
  line->count = line->fine;
  return line->xyz ? HB_OK : hb_fail_memory(r->err, "vertices");
}

/* Leaves every second vertex of that, and both ends. */
static void thin_out(polyline *line) {
  if (!line->fine) return;
  int count = 0;
  for (int i = 0; i < line->fine; i++) {
    bool kept = i == 0 || i == line->fine - 1 || i % 2 == (line->halves[0] ? 1 : 0);
    if (!kept) continue;
    for (int c = 0; c < 3; c++) line->xyz[3 * count + c] = line->xyz[3 * i + c];
    count++;
  }
  line->count = count;
  line->fine = 0;
}

/* Reads `vertices: n` of a generator and allocates. */
static hb_status take_count(hb_scene_reader *r, const hb_node *node, polyline *line) {
  const hb_node *vertices = hb_node_find(node, "vertices");
  int count = line->wanted;
  if (!vertices && !count)
    return hb_scene_fail_key(r, node, "the key \"vertices\" is missing; a whole number >= 3 is expected");
  hb_status status = hb_scene_whole(r, vertices, 3, r->limits.vertices, &count);
  if (status != HB_OK) return status;
  if (line->wanted && count != line->wanted)
    return hb_scene_fail(
        r, vertices,
        "%d vertices are not allowed; the rest shape has %d, and the initial shape must have as many", count,
        line->wanted);
  status = make_room(r, vertices ? vertices : node, count, line);
  return status ? status : refine(r, line);
}

/* Passes on a generator's sentence. */
static hb_status finish(const hb_scene_reader *r, const hb_node *node, hb_status status,
                        const hb_error *inner) {
  return status == HB_OK ? HB_OK : hb_scene_pass(r, node, inner);
}

/* line: {from, to, vertices} */
static hb_status make_line(hb_scene_reader *r, const hb_node *node, polyline *line) {
  static const char *const keys[] = {"from", "to", "vertices", NULL};
  double a[3] = {0, 0, 0}, b[3] = {0, 0, 0};
  const hb_node *to;
  hb_error inner;
  hb_status status = hb_scene_check_keys(r, node, keys);
  if (!status) status = hb_scene_vector(r, hb_node_find(node, "from"), a);
  if (!status) status = hb_scene_need(r, node, "to", "a list [x, y, z]", &to);
  if (!status) status = hb_scene_vector(r, to, b);
  if (!status) status = take_count(r, node, line);
  if (status) return status;
  return finish(r, node, hb_curve_line(a, b, line->count, line->xyz, &inner), &inner);
}

/* arc: {center, normal, start, radius, angle, vertices}, and ring, which is a whole turn. */
static hb_status make_arc_of(hb_scene_reader *r, const hb_node *node, bool ring, polyline *line) {
  static const char *const arc_keys[] = {"center", "normal", "start", "radius", "angle", "vertices", NULL};
  static const char *const ring_keys[] = {"center", "normal", "start", "radius", "vertices", NULL};
  double center[3] = {0, 0, 0}, normal[3] = {0, 0, 1}, start[3] = {1, 0, 0}, radius = 1, angle = 2 * HB_PI;
  const hb_node *child;
  hb_error inner;
  hb_status status = hb_scene_check_keys(r, node, ring ? ring_keys : arc_keys);
  if (!status) status = hb_scene_vector(r, hb_node_find(node, "center"), center);
  if (!status) status = hb_scene_direction(r, hb_node_find(node, "normal"), normal);
  if (!status) status = hb_scene_direction(r, hb_node_find(node, "start"), start);
  if (!status) status = hb_scene_need(r, node, "radius", "a number or formula > 0", &child);
  if (!status) status = hb_scene_number(r, child, HB_RULE_POSITIVE, &radius);
  if (!status && !ring)
    status = hb_scene_need(r, node, "angle", "an angle in radians, not 0, at most 2*pi,", &child);
  if (!status && !ring) status = hb_scene_number(r, child, HB_RULE_ANY, &angle);
  if (!status) status = take_count(r, node, line);
  if (status) return status;
  return finish(r, node, hb_curve_arc(center, normal, start, radius, angle, line->count, line->xyz, &inner),
                &inner);
}

/* arc */
static hb_status make_arc(hb_scene_reader *r, const hb_node *node, polyline *line) {
  return make_arc_of(r, node, false, line);
}

/* ring: an open polyline whose ends touch. */
static hb_status make_ring(hb_scene_reader *r, const hb_node *node, polyline *line) {
  return make_arc_of(r, node, true, line);
}

/* helix: {center, axis, start, radius, pitch, turns, vertices} */
static hb_status make_helix(hb_scene_reader *r, const hb_node *node, polyline *line) {
  static const char *const keys[] = {"center", "axis", "start", "radius", "pitch", "turns", "vertices", NULL};
  double center[3] = {0, 0, 0}, axis[3] = {0, 0, 1}, start[3] = {1, 0, 0}, radius = 1, pitch = 0, turns = 1;
  const hb_node *child;
  hb_error inner;
  hb_status status = hb_scene_check_keys(r, node, keys);
  if (!status) status = hb_scene_vector(r, hb_node_find(node, "center"), center);
  if (!status) status = hb_scene_direction(r, hb_node_find(node, "axis"), axis);
  if (!status) status = hb_scene_direction(r, hb_node_find(node, "start"), start);
  if (!status) status = hb_scene_need(r, node, "radius", "a number or formula > 0", &child);
  if (!status) status = hb_scene_number(r, child, HB_RULE_POSITIVE, &radius);
  if (!status) status = hb_scene_need(r, node, "pitch", "the advance per turn", &child);
  if (!status) status = hb_scene_number(r, child, HB_RULE_ANY, &pitch);
  if (!status)
    status = hb_scene_need(r, node, "turns", "the number of turns, < 0 for a left-handed helix,", &child);
  if (!status) status = hb_scene_number(r, child, HB_RULE_ANY, &turns);
  if (!status) status = take_count(r, node, line);
  if (status) return status;
  status = hb_curve_helix(center, axis, start, radius, pitch, turns, line->count, line->xyz, &inner);
  return finish(r, node, status, &inner);
}

/* catenary: {from, to, down, length, vertices} */
static hb_status make_catenary(hb_scene_reader *r, const hb_node *node, polyline *line) {
  static const char *const keys[] = {"from", "to", "down", "length", "vertices", NULL};
  double a[3] = {0, 0, 0}, b[3] = {0, 0, 0}, down[3] = {0, 0, -1}, length = 0;
  const hb_node *child;
  hb_error inner;
  hb_status status = hb_scene_check_keys(r, node, keys);
  if (!status) status = hb_scene_vector(r, hb_node_find(node, "from"), a);
  if (!status) status = hb_scene_need(r, node, "to", "a list [x, y, z]", &child);
  if (!status) status = hb_scene_vector(r, child, b);
  if (!status) status = hb_scene_direction(r, hb_node_find(node, "down"), down);
  if (!status) status = hb_scene_need(r, node, "length", "a number or formula > 0", &child);
  if (!status) status = hb_scene_number(r, child, HB_RULE_POSITIVE, &length);
  if (!status) status = take_count(r, node, line);
  if (status) return status;
  return finish(r, node, hb_curve_catenary(a, b, down, length, line->count, line->xyz, &inner), &inner);
}

/* A list of at least `least` points into a new array. */
static hb_status take_points(hb_scene_reader *r, const hb_node *node, int least, polyline *line) {
  if (node->kind != HB_NODE_LIST) return hb_scene_expected(r, node, "a list of points [[x, y, z], ...]");
  if (node->count < least)
    return hb_scene_fail(r, node, "a list of %d point%s is not allowed; at least %d are expected",
                         node->count, node->count == 1 ? "" : "s", least);
  hb_status status = make_room(r, node, node->count, line);
  for (int i = 0; !status && i < node->count; i++)
    status = hb_scene_vector(r, node->children[i], line->xyz + 3 * i);
  return status;
}

/* spline: {points, closed, vertices} */
static hb_status make_spline(hb_scene_reader *r, const hb_node *node, polyline *line) {
  static const char *const keys[] = {"points", "closed", "vertices", NULL};
  bool closed = false;
  const hb_node *child;
  hb_error inner;
  polyline points = {0};
  hb_status status = hb_scene_check_keys(r, node, keys);
  if (!status) status = hb_scene_flag(r, hb_node_find(node, "closed"), &closed);
  if (!status) status = hb_scene_need(r, node, "points", "a list of points [[x, y, z], ...]", &child);
  if (!status) status = take_points(r, child, 2, &points);
  if (!status) status = take_count(r, node, line);
  if (!status) {
    status = hb_curve_spline(points.xyz, points.count, closed, line->count, line->xyz, &inner);
    status = finish(r, node, status, &inner);
  }
  hb_free(points.xyz);
  return status;
}

/* knot: {center, major, minor, p, q, start, part, vertices} */
static hb_status make_knot(hb_scene_reader *r, const hb_node *node, polyline *line) {
  static const char *const keys[] = {"center", "major", "minor", "p", "q", "start", "part", "vertices", NULL};
  double center[3] = {0, 0, 0}, major = 1, minor = 1, start = 0, part = 1;
  int p = 2, q = 3;
  const hb_node *child;
  hb_error inner;
  hb_status status = hb_scene_check_keys(r, node, keys);
  if (!status) status = hb_scene_vector(r, hb_node_find(node, "center"), center);
  if (!status) status = hb_scene_need(r, node, "major", "the torus's large radius > 0", &child);
  if (!status) status = hb_scene_number(r, child, HB_RULE_POSITIVE, &major);
  if (!status) status = hb_scene_need(r, node, "minor", "the torus's small radius > 0", &child);
  if (!status) status = hb_scene_number(r, child, HB_RULE_POSITIVE, &minor);
  if (!status) status = hb_scene_whole(r, hb_node_find(node, "p"), 1, 1000, &p);
  if (!status) status = hb_scene_whole(r, hb_node_find(node, "q"), 1, 1000, &q);
  if (!status) status = hb_scene_number(r, hb_node_find(node, "start"), HB_RULE_ANY, &start);
  if (!status) status = hb_scene_number(r, hb_node_find(node, "part"), HB_RULE_POSITIVE, &part);
  if (!status && part > 1)
    status = hb_scene_expected(r, hb_node_find(node, "part"), "a number or formula > 0 and <= 1");
  if (!status) status = take_count(r, node, line);
  if (status) return status;
  status = hb_curve_torus_knot(center, major, minor, p, q, start, part, line->count, line->xyz, &inner);
  return finish(r, node, status, &inner);
}

/* formula: {x, y, z, from, to, vertices}; the parameter is s. */
static hb_status make_formula(hb_scene_reader *r, const hb_node *node, polyline *line) {
  static const char *const keys[] = {"x", "y", "z", "from", "to", "vertices", NULL};
  double from = 0, to = 1;
  hb_formula *f[3] = {NULL, NULL, NULL};
  hb_error inner;
  hb_status status = hb_scene_check_keys(r, node, keys);
  for (int c = 0; !status && c < 3; c++) {
    const hb_node *child;
    status = hb_scene_need(r, node, keys[c], "a formula of s, which runs from \"from\" to \"to\",", &child);
    if (!status) status = hb_scene_formula(r, child, HB_VAR_BIT(HB_VAR_S), &f[c]);
  }
  if (!status) status = hb_scene_number(r, hb_node_find(node, "from"), HB_RULE_ANY, &from);
  if (!status) status = hb_scene_number(r, hb_node_find(node, "to"), HB_RULE_ANY, &to);
  if (!status) status = take_count(r, node, line);
  if (!status) {
    status = hb_curve_formula(f, from, to, line->count, line->xyz, &inner);
    status = finish(r, node, status, &inner);
  }
  for (int c = 0; c < 3; c++) hb_formula_free(f[c]);
  return status;
}

/* vertices: [[x, y, z], ...] */
static hb_status make_vertices(hb_scene_reader *r, const hb_node *node, polyline *line) {
  if (node->kind == HB_NODE_SCALAR)
    return hb_scene_expected(
        r, node, "a list of points [[x, y, z], ...] (a number of vertices goes inside the generator)");
  return take_points(r, node, 2, line);
}

/* file: name, relative to the scene's directory */
static hb_status make_file(hb_scene_reader *r, const hb_node *node, polyline *line) {
  char path[4096];
  double *xyz = NULL;
  int count = 0;
  hb_error inner;
  if (node->kind != HB_NODE_SCALAR || !node->text[0])
    return hb_scene_expected(r, node, "the name of a CSV or OBJ file");
  bool absolute = node->text[0] == '/' || !r->base_dir || !r->base_dir[0];
  int n = snprintf(path, sizeof path, "%s%s%s", absolute ? "" : r->base_dir, absolute ? "" : "/", node->text);
  if (n < 0 || (size_t)n >= sizeof path) return hb_scene_fail(r, node, "the file name is too long");
  hb_status status = hb_curve_read(path, &xyz, &count, &inner);
  if (status) {
    if (inner.status == HB_ERR_IO) inner.status = HB_ERR_INPUT; /* a wrong name is the scene's mistake */
    return hb_scene_pass(r, node, &inner);
  }
  status = make_room(r, node, count, line);
  if (!status) memcpy(line->xyz, xyz, 3 * (size_t)count * sizeof *xyz);
  hb_curve_free(xyz);
  return status;
}

static const generator generators[] = {
    {"line", make_line},         {"arc", make_arc},       {"ring", make_ring}, {"helix", make_helix},
    {"catenary", make_catenary}, {"spline", make_spline}, {"knot", make_knot}, {"formula", make_formula},
    {"vertices", make_vertices}, {"file", make_file},     {NULL, NULL}};

/* resample: true | n */
static hb_status resample(hb_scene_reader *r, const hb_node *node, polyline *line) {
  bool same = false;
  int count = line->count;
  hb_error inner;
  if (node->kind == HB_NODE_SCALAR && (!strcmp(node->text, "true") || !strcmp(node->text, "false"))) {
    hb_status status = hb_scene_flag(r, node, &same);
    if (status || !same) return status;
  } else {
    if (node->kind != HB_NODE_SCALAR || !strcmp(node->text, "yes") || !strcmp(node->text, "no"))
      return hb_scene_expected(r, node, "true, false, or a whole number >= 3");
    hb_status status = hb_scene_whole(r, node, 3, r->limits.vertices, &count);
    if (status) return status;
  }
  polyline even = {.halves = line->halves};
  hb_status status = make_room(r, node, count, &even);
  if (!status) status = refine(r, &even);
  if (!status) {
    status = hb_curve_resample(line->xyz, line->count, even.count, even.xyz, &inner);
    status = finish(r, node, status, &inner);
  }
  if (status) {
    hb_free(even.xyz);
    return status;
  }
  thin_out(&even);
  hb_free(line->xyz);
  line->xyz = even.xyz;
  line->count = even.count;
  return HB_OK;
}

/* scale: number | [sx, sy, sz] */
static hb_status scale(hb_scene_reader *r, const hb_node *node, polyline *line) {
  double s[3] = {1, 1, 1};
  hb_status status;
  if (node->kind == HB_NODE_LIST) {
    status = hb_scene_vector(r, node, s);
  } else {
    status = hb_scene_number(r, node, HB_RULE_ANY, &s[0]);
    s[1] = s[2] = s[0];
  }
  if (!status && (s[0] == 0 || s[1] == 0 || s[2] == 0))
    return hb_scene_fail(r, node, "a factor 0 is not allowed; numbers other than 0 are expected");
  for (int i = 0; !status && i < 3 * line->count; i++) line->xyz[i] *= s[i % 3];
  return status;
}

/* rotate: {axis, angle, about}, or a list of them */
static hb_status rotate(hb_scene_reader *r, const hb_node *node, polyline *line) {
  static const char *const keys[] = {"axis", "angle", "about", NULL};
  double axis[3] = {0, 0, 1}, about[3] = {0, 0, 0}, angle = 0;
  const hb_node *child;
  if (node->kind == HB_NODE_LIST) {
    for (int k = 0; k < node->count; k++) {
      if (node->children[k]->kind == HB_NODE_LIST)
        return hb_scene_expected(r, node->children[k], "a mapping with the keys axis, angle, about");
      hb_status status = rotate(r, node->children[k], line);
      if (status) return status;
    }
    return HB_OK;
  }
  hb_status status = hb_scene_check_keys(r, node, keys);
  if (!status) status = hb_scene_need(r, node, "axis", "a direction [x, y, z]", &child);
  if (!status) status = hb_scene_direction(r, child, axis);
  if (!status) status = hb_scene_need(r, node, "angle", "an angle in radians", &child);
  if (!status) status = hb_scene_number(r, child, HB_RULE_ANY, &angle);
  if (!status) status = hb_scene_vector(r, hb_node_find(node, "about"), about);
  if (status) return status;
  hb_v3 unit = hb_v3_unit(hb_v3_load(axis)), from = hb_v3_load(about);
  hb_quat q = {cos(0.5 * angle), hb_v3_scale(sin(0.5 * angle), unit)};
  for (int i = 0; i < line->count; i++) {
    double *x = line->xyz + 3 * i;
    hb_v3_store(x, hb_v3_add(from, hb_quat_rotate(q, hb_v3_sub(hb_v3_load(x), from))));
  }
  return HB_OK;
}

/* move: [x, y, z] */
static hb_status move(hb_scene_reader *r, const hb_node *node, polyline *line) {
  double by[3];
  hb_status status = hb_scene_vector(r, node, by);
  for (int i = 0; !status && i < 3 * line->count; i++) line->xyz[i] += by[i % 3];
  return status;
}

/* displace: [fx, fy, fz], formulas of s, u, i, L, x, y, z of the shape so far */
static hb_status displace(hb_scene_reader *r, const hb_node *node, polyline *line) {
  double *s = hb_alloc((size_t)line->count, sizeof *s), *by = hb_alloc(3 * (size_t)line->count, sizeof *by);
  hb_status status = s && by ? HB_OK : hb_fail_memory(r->err, "displacements");
  if (!status) {
    hb_scene_arc_lengths(line->xyz, line->count, s);
    hb_scene_arc arc = {.nv = line->count, .s = s, .place = line->xyz};
    status = hb_scene_along_vector(r, node, &arc, by);
  }
  for (int i = 0; !status && i < 3 * line->count; i++) line->xyz[i] += by[i];
  hb_free(s);
  hb_free(by);
  return status;
}

/* perturb: {vertex, by}, or a list of them */
static hb_status perturb(hb_scene_reader *r, const hb_node *node, polyline *line) {
  static const char *const keys[] = {"vertex", "by", NULL};
  double by[3] = {0, 0, 0};
  int vertex = 0;
  const hb_node *child;
  if (node->kind == HB_NODE_LIST) {
    for (int k = 0; k < node->count; k++) {
      if (node->children[k]->kind == HB_NODE_LIST)
        return hb_scene_expected(r, node->children[k], "a mapping with the keys vertex, by");
      hb_status status = perturb(r, node->children[k], line);
      if (status) return status;
    }
    return HB_OK;
  }
  hb_status status = hb_scene_check_keys(r, node, keys);
  if (!status) status = hb_scene_need(r, node, "vertex", "the index of a vertex, from 0", &child);
  if (!status) status = hb_scene_whole(r, child, -line->count, line->count - 1, &vertex);
  if (!status) status = hb_scene_need(r, node, "by", "a list [x, y, z]", &child);
  if (!status) status = hb_scene_vector(r, child, by);
  if (status) return status;
  if (vertex < 0) vertex += line->count;
  bool end = line->meets && (vertex == 0 || vertex == line->count - 1);
  for (int c = 0; c < 3; c++) line->xyz[3 * vertex + c] += by[c];
  if (end)
    memcpy(line->xyz + (vertex == 0 ? 3 * (size_t)(line->count - 1) : 0), line->xyz + 3 * vertex,
           3 * sizeof(double));
  return HB_OK;
}

/* Makes the polyline: the one generator that is named, or a copy of the base. */
static hb_status generate(hb_scene_reader *r, const hb_node *node, const double *base, polyline *line) {
  const hb_node *used = NULL;
  const generator *chosen = NULL;
  for (const generator *g = generators; g->key; g++) {
    const hb_node *child = hb_node_find(node, g->key);
    if (!child) continue;
    if (used && !strcmp(g->key, "vertices") && child->kind == HB_NODE_SCALAR)
      return hb_scene_fail_key(r, child, "the number of vertices belongs inside \"%s\"", used->key);
    if (used)
      return hb_scene_fail_key(
          r, child,
          "\"%s\" is given already; a curve has one of line, arc, ring, helix, catenary, "
          "spline, knot, formula, vertices, file",
          used->key);
    used = child;
    chosen = g;
  }
  if (used) {
    hb_status status = chosen->make(r, used, line);
    if (!status) thin_out(line);
    return status;
  }
  if (!base)
    return hb_scene_fail_key(
        r, node,
        "no curve is given; one of line, arc, ring, helix, catenary, spline, knot, formula, "
        "vertices, file is expected");
  hb_status status = make_room(r, node, line->wanted, line);
  if (!status) memcpy(line->xyz, base, 3 * (size_t)line->count * sizeof *base);
  return status;
}

/* All changes in their order. */
static hb_status change(hb_scene_reader *r, const hb_node *node, polyline *line) {
  static const generator changes[] = {
      {"resample", resample}, {"scale", scale},     {"rotate", rotate}, {"move", move},
      {"displace", displace}, {"perturb", perturb}, {NULL, NULL}};
  for (const generator *g = changes; g->key; g++) {
    const hb_node *child = hb_node_find(node, g->key);
    hb_status status = child ? g->make(r, child, line) : HB_OK;
    if (status) return status;
  }
  return HB_OK;
}

/* Points that are listed or in a file stay where they are, unless they are resampled. */
bool hb_scene_curve_divides(const hb_node *node) {
  if (!node || node->kind != HB_NODE_MAP) return true;
  const hb_node *again = hb_node_find(node, "resample");
  if (again && again->kind == HB_NODE_SCALAR && strcmp(again->text, "false") != 0) return true;
  return !hb_node_find(node, "vertices") && !hb_node_find(node, "file");
}

/* Any key of the list. */
bool hb_scene_curve_generates(const hb_node *node) {
  for (const generator *g = generators; node && g->key; g++)
    if (hb_node_find(node, g->key)) return true;
  return false;
}

/* Reads a curve. */
hb_status hb_scene_read_curve(hb_scene_reader *r, const hb_node *node, const double *base, int base_count,
                              const bool halves[2], hb_scene_ends ends, double **xyz, int *count) {
  static const char *const keys[] = {"line",   "arc",     "ring",     "helix",   "catenary", "spline",
                                     "knot",   "formula", "vertices", "file",    "resample", "scale",
                                     "rotate", "move",    "displace", "perturb", NULL};
  polyline line = {.wanted = base_count, .halves = halves};
  hb_status status = hb_scene_check_keys(r, node, keys);
  if (!status) status = generate(r, node, base, &line);
  if (!status) status = settle_ends(r, node, ends, &line);
  if (!status) status = change(r, node, &line);
  if (!status && line.meets && line.count >= 3) {
    double gap = join_ends(&line);
    if (gap > 0)
      status =
          hb_scene_fail(r, node,
                        "the changes of this closed curve tear it open: its last vertex is %.3g edges away "
                        "from its first; what they do at u = 1 must be what they do at u = 0",
                        gap);
  }
  if (!status && line.count < 3)
    status = hb_scene_fail(r, node, "%d vertices are not allowed; at least 3 are expected", line.count);
  if (!status && base_count && line.count != base_count)
    status = hb_scene_fail(
        r, node,
        "%d vertices are not allowed; the rest shape has %d, and the initial shape must have as many "
        "(use resample: %d)",
        line.count, base_count, base_count);
  if (status) {
    hb_free(line.xyz);
    return status;
  }
  *xyz = line.xyz;
  *count = line.count;
  return HB_OK;
}
