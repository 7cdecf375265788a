/* Stiffness and mass of a rod: given directly, or by a cross-section and a material. */
#include "scene/read.h"

#include "base/memory.h"
#include "hebra/curve.h"

#include <math.h>
#include <string.h>

/* Writes D turned by angle into (B11, B12, B22): B = R D R^T. */
static void turn_form(const double D[3], double angle, double B[3]) {
  double c = cos(angle), s = sin(angle);
  B[0] = D[0] * c * c - 2 * D[1] * c * s + D[2] * s * s;
  B[1] = (D[0] - D[2]) * c * s + D[1] * (c * c - s * s);
  B[2] = D[0] * s * s + 2 * D[1] * c * s + D[2] * c * c;
}

/* Turns the form of every edge by a formula of s. A form that is isotropic stays as it is, to the bit. */
static hb_status turn_forms(hb_scene_reader *r, const hb_node *angle, const hb_scene_arc *arc,
                            hb_rod_def *rod) {
  if (!angle) return HB_OK;
  double *turn = hb_alloc((size_t)arc->nv, sizeof *turn);
  if (!turn) return hb_fail_memory(r->err, "bending directions");
  hb_status status = hb_scene_along(r, angle, arc, true, HB_RULE_ANY, turn, 1);
  for (int j = 0; !status && j + 1 < arc->nv; j++) {
    double *B = rod->B + 3 * j, D[3] = {B[0], B[1], B[2]};
    if (D[1] != 0 || D[0] != D[2]) turn_form(D, turn[j], B);
  }
  hb_free(turn);
  return status;
}

/* [B11, B22] or [B11, B12, B22]. */
static hb_status read_form(hb_scene_reader *r, const hb_node *node, const hb_scene_arc *arc,
                           hb_rod_def *rod) {
  bool full = node->count == 3;
  hb_status status = hb_scene_list(r, node, full ? 3 : 2, "[B11, B22] or [B11, B12, B22]");
  if (!status) status = hb_scene_along(r, node->children[0], arc, true, HB_RULE_NOT_NEGATIVE, rod->B, 3);
  if (!status && full) status = hb_scene_along(r, node->children[1], arc, true, HB_RULE_ANY, rod->B + 1, 3);
  if (!status)
    status = hb_scene_along(r, node->children[full ? 2 : 1], arc, true, HB_RULE_NOT_NEGATIVE, rod->B + 2, 3);
  for (int j = 0; !status && j + 1 < arc->nv; j++) {
    const double *B = rod->B + 3 * j;
    if (B[1] * B[1] > B[0] * B[2] * (1 + 1e-12))
      status = hb_scene_fail(r, node,
                             "the form ((%g, %g), (%g, %g)) at edge %d is not positive definite; "
                             "B12^2 <= B11 * B22 is expected",
                             B[0], B[1], B[1], B[2], j);
  }
  return status;
}

/* bending: formula | [B11, B22] | [B11, B12, B22] | {B: list, angle: formula} */
static hb_status read_bending(hb_scene_reader *r, const hb_node *node, const hb_scene_arc *arc,
                              hb_rod_def *rod) {
  static const char *const keys[] = {"B", "angle", NULL};
  if (node->kind == HB_NODE_LIST) return read_form(r, node, arc, rod);
  if (node->kind == HB_NODE_SCALAR) {
    hb_status status = hb_scene_along(r, node, arc, true, HB_RULE_NOT_NEGATIVE, rod->B, 3);
    for (int j = 0; !status && j + 1 < arc->nv; j++) rod->B[3 * j + 2] = rod->B[3 * j];
    return status;
  }
  const hb_node *form = NULL;
  hb_status status = hb_scene_check_keys(r, node, keys);
  if (!status) status = hb_scene_need(r, node, "B", "[B11, B22] or [B11, B12, B22]", &form);
  if (!status && form->kind != HB_NODE_LIST)
    status = hb_scene_expected(r, form, "[B11, B22] or [B11, B12, B22]");
  if (!status) status = read_form(r, form, arc, rod);
  if (!status) status = turn_forms(r, hb_node_find(node, "angle"), arc, rod);
  return status;
}

/* Everything that a section with its material needs, at the vertices and at the edges. */
enum { COLUMN_A, COLUMN_B, COLUMN_E, COLUMN_G, COLUMN_RHO, COLUMNS };

/* One kind of section with the keys of its two sizes. */
typedef struct shape {
  const char *key;
  hb_section_kind kind;
  const char *sizes[3];
} shape;

static const shape shapes[] = {{"circle", HB_SECTION_CIRCLE, {"radius", NULL, NULL}},
                               {"tube", HB_SECTION_TUBE, {"outer", "inner", NULL}},
                               {"ellipse", HB_SECTION_ELLIPSE, {"a", "b", NULL}},
                               {"rectangle", HB_SECTION_RECTANGLE, {"width", "height", NULL}}};

/* Finds the one shape of a section. */
static hb_status find_shape(hb_scene_reader *r, const hb_node *node, const shape **out,
                            const hb_node **sizes) {
  static const char *const keys[] = {"circle", "tube", "ellipse", "rectangle", "angle", NULL};
  hb_status status = hb_scene_check_keys(r, node, keys);
  *out = NULL;
  for (size_t k = 0; !status && k < sizeof shapes / sizeof shapes[0]; k++) {
    const hb_node *child = hb_node_find(node, shapes[k].key);
    if (child && *out)
      return hb_scene_fail_key(
          r, child, "\"%s\" is given already; a section has one of circle, tube, ellipse, rectangle",
          (*out)->key);
    if (child) {
      *out = &shapes[k];
      *sizes = child;
    }
  }
  if (!status && !*out)
    return hb_scene_fail_key(r, node,
                             "no shape is given; one of circle, tube, ellipse, rectangle is expected");
  return status ? status : hb_scene_check_keys(r, *sizes, (*out)->sizes);
}

/* The columns a, b, E, G (nu turned into G), rho at the vertices or at the edges. */
static hb_status read_columns(hb_scene_reader *r, const hb_node *node, const shape *kind,
                              const hb_node *sizes, const hb_scene_arc *arc, bool on_edges, double *table) {
  const hb_node *E = NULL, *nu = hb_node_find(node, "nu"), *G = hb_node_find(node, "G"), *size = NULL;
  const hb_node *rho = hb_node_find(node, "density");
  size_t n = (size_t)arc->nv;
  hb_status status = hb_scene_need(r, sizes, kind->sizes[0], "a number or formula > 0", &size);
  if (!status) status = hb_scene_along(r, size, arc, on_edges, HB_RULE_POSITIVE, table, 1);
  if (!status && kind->sizes[1])
    status = hb_scene_need(r, sizes, kind->sizes[1], "a number or formula > 0", &size);
  if (!status && kind->sizes[1])
    status = hb_scene_along(r, size, arc, on_edges, HB_RULE_POSITIVE, table + n, 1);
  if (!status) status = hb_scene_need(r, node, "E", "Young's modulus, a number or formula > 0,", &E);
  if (!status) status = hb_scene_along(r, E, arc, on_edges, HB_RULE_POSITIVE, table + COLUMN_E * n, 1);
  if (!status && nu && G)
    status = hb_scene_fail_key(r, G, "\"nu\" is given already; one of nu and G is expected");
  if (!status && !nu && !G)
    status =
        hb_scene_fail_key(r, node,
                          "Poisson's ratio \"nu\" or the shear modulus \"G\" is missing; the section needs "
                          "one of them for its twisting modulus");
  double *shear = table + COLUMN_G * n;
  if (!status && G) status = hb_scene_along(r, G, arc, on_edges, HB_RULE_POSITIVE, shear, 1);
  if (!status && nu) status = hb_scene_along(r, nu, arc, on_edges, HB_RULE_ANY, shear, 1);
  for (size_t k = 0; !status && nu && k < n - on_edges; k++) {
    if (!(shear[k] > -1 && shear[k] <= 0.5))
      return hb_scene_expected(r, nu, "a number or formula > -1 and <= 0.5");
    shear[k] = table[COLUMN_E * n + k] / (2 * (1 + shear[k]));
  }
  for (size_t k = 0; k < n; k++) table[COLUMN_RHO * n + k] = 1;
  if (!status && rho)
    status = hb_scene_along(r, rho, arc, on_edges, HB_RULE_POSITIVE, table + COLUMN_RHO * n, 1);
  return status;
}

/* Moduli at entry k; the last result is taken again where nothing has changed, since a rectangle is a series.
 */
static hb_status compute(hb_scene_reader *r, const hb_node *node, hb_section_kind kind, const double *table,
                         size_t n, size_t k, hb_section_moduli *out) {
  hb_error inner;
  bool same = k > 0;
  for (size_t c = 0; c < COLUMNS; c++) same = same && table[c * n + k] == table[c * n + k - 1];
  if (same) return HB_OK;
  hb_section section = {.kind = kind, .a = table[k], .b = table[n + k]};
  hb_status status = hb_section_compute(&section, table[COLUMN_E * n + k], table[COLUMN_G * n + k],
                                        table[COLUMN_RHO * n + k], out, &inner);
  return status ? hb_scene_pass(r, node, &inner) : HB_OK;
}

/* B, and E A where it is asked for, on the edges; beta, mass per length (into per_length) on the vertices. */
static hb_status read_section(hb_scene_reader *r, const hb_node *node, const hb_scene_arc *arc,
                              hb_rod_def *rod, double *per_length) {
  const hb_node *section = hb_node_find(node, "section"), *sizes = NULL;
  const shape *kind = NULL;
  size_t n = (size_t)arc->nv;
  hb_section_moduli m = {0};
  hb_status status = find_shape(r, section, &kind, &sizes);
  if (status) return status;
  double *table = hb_alloc(n * COLUMNS, sizeof *table);
  if (!table) return hb_fail_memory(r->err, "section");
  status = read_columns(r, node, kind, sizes, arc, true, table);
  for (size_t j = 0; !status && j + 1 < n; j++) {
    status = compute(r, sizes, kind->kind, table, n, j, &m);
    rod->B[3 * j] = m.B11;
    rod->B[3 * j + 2] = m.B22;
    if (rod->stretching && !hb_node_find(node, "stretching")) rod->stretching[j] = m.EA;
  }
  if (!status) status = turn_forms(r, hb_node_find(section, "angle"), arc, rod);
  if (!status) status = read_columns(r, node, kind, sizes, arc, false, table);
  for (size_t i = 0; !status && i < n; i++) {
    status = compute(r, sizes, kind->kind, table, n, i, &m);
    rod->beta[i] = m.beta;
    per_length[i] = m.mass_per_length;
    double radius = kind->kind == HB_SECTION_RECTANGLE ? 0.5 * fmax(table[i], table[n + i])
                                                       : fmax(table[i], table[n + i]);
    if (i == 0 || radius > rod->radius) rod->radius = radius;
  }
  hb_free(table);
  return status;
}

/* Mass per length to mass of the vertices: half of the neighbouring edges belongs to each. */
static void lump(const hb_scene_arc *arc, const double *per_length, double *mass) {
  for (int i = 0; i < arc->nv; i++) {
    double before = i > 0 ? arc->s[i] - arc->s[i - 1] : 0,
           after = i + 1 < arc->nv ? arc->s[i + 1] - arc->s[i] : 0;
    mass[i] = per_length[i] * 0.5 * (before + after);
  }
}

/* Exactly one of vertex_mass, linear_density, density. */
static hb_status read_mass(hb_scene_reader *r, const hb_node *node, const hb_scene_arc *arc, hb_rod_def *rod,
                           double *per_length) {
  static const char *const ways[] = {"vertex_mass", "linear_density", "density"};
  const hb_node *used = NULL;
  for (int k = 0; k < 3; k++) {
    const hb_node *child = hb_node_find(node, ways[k]);
    if (child && used)
      return hb_scene_fail_key(
          r, child, "\"%s\" is given already; one of vertex_mass, linear_density, density is expected",
          used->key);
    if (child) used = child;
  }
  if (!used)
    return hb_scene_fail_key(
        r, node,
        "the mass is missing; one of vertex_mass, linear_density, or density with a section "
        "is expected");
  if (!strcmp(used->key, "vertex_mass")) {
    hb_status status = hb_scene_along(r, used, arc, false, HB_RULE_POSITIVE, rod->mass, 1);
    if (rod->closing != HB_CLOSING_NONE) { /* halves of one vertex */
      rod->mass[0] *= 0.5;
      rod->mass[arc->nv - 1] *= 0.5;
    }
    return status;
  }
  if (!strcmp(used->key, "density") && !hb_node_find(node, "section"))
    return hb_scene_fail_key(r, used,
                             "a density needs a section; without one give linear_density or vertex_mass");
  hb_status status = HB_OK;
  if (!strcmp(used->key, "linear_density"))
    status = hb_scene_along(r, used, arc, false, HB_RULE_POSITIVE, per_length, 1);
  if (!status) lump(arc, per_length, rod->mass);
  return status;
}

/* Either bending and twisting, or a section with its material. */
static hb_status check_ways(hb_scene_reader *r, const hb_node *node) {
  static const char *const direct[] = {"bending", "twisting"}, *const material[] = {"E", "nu", "G"};
  const hb_node *section = hb_node_find(node, "section");
  for (int k = 0; k < 2; k++) {
    const hb_node *child = hb_node_find(node, direct[k]);
    if (child && section)
      return hb_scene_fail_key(r, child,
                               "\"section\" is given already; the stiffness comes either from bending and "
                               "twisting, or from section, E and nu (or G)");
  }
  for (int k = 0; k < 3; k++) {
    const hb_node *child = hb_node_find(node, material[k]);
    if (child && !section)
      return hb_scene_fail_key(r, child, "needs a section; without one give bending and twisting");
  }
  if (section) return HB_OK;
  const hb_node *bending = hb_node_find(node, "bending"), *twisting = hb_node_find(node, "twisting");
  if (!bending && !twisting)
    return hb_scene_fail_key(
        r, node,
        "the stiffness is missing; bending and twisting, or section with E and nu (or G), "
        "are expected");
  if (!bending)
    return hb_scene_need(r, node, "bending", "a number or formula >= 0, or [B11, B22],", &bending);
  return hb_scene_need(r, node, "twisting", "a number or formula >= 0", &twisting);
}

/* stretching, inextensible: makes room for E A where the rod stretches, and fills it if it is given directly.
 */
static hb_status read_stretching(hb_scene_reader *r, const hb_node *node, const hb_scene_arc *arc,
                                 hb_rod_def *rod) {
  const hb_node *given = hb_node_find(node, "stretching"), *flag = hb_node_find(node, "inextensible");
  bool inextensible = !given;
  hb_status status = hb_scene_flag(r, flag, &inextensible);
  if (status) return status;
  if (given && inextensible)
    return hb_scene_fail_key(r, given,
                             "inextensible: true is given already; a rod keeps its lengths, or stretches");
  if (inextensible) return HB_OK;
  if (!given && !hb_node_find(node, "section"))
    return hb_scene_fail_key(
        r, flag,
        "the stretching stiffness is missing; \"stretching\" (E A), or a section with E, "
        "is expected");
  rod->stretching = hb_alloc((size_t)arc->nv, sizeof *rod->stretching);
  if (!rod->stretching) return hb_fail_memory(r->err, "stretching stiffness");
  return given ? hb_scene_along(r, given, arc, true, HB_RULE_POSITIVE, rod->stretching, 1) : HB_OK;
}

/* B, beta, E A, mass. */
hb_status hb_scene_read_moduli(hb_scene_reader *r, const hb_node *node, const hb_scene_arc *arc,
                               hb_rod_def *rod) {
  size_t n = (size_t)arc->nv;
  hb_status status = check_ways(r, node);
  if (status) return status;
  rod->B = hb_alloc(3 * n, sizeof *rod->B);
  rod->beta = hb_alloc(n, sizeof *rod->beta);
  rod->mass = hb_alloc(n, sizeof *rod->mass);
  double *per_length = hb_alloc(n, sizeof *per_length);
  if (!rod->B || !rod->beta || !rod->mass || !per_length) {
    hb_free(per_length);
    return hb_fail_memory(r->err, "moduli");
  }
  status = read_stretching(r, node, arc, rod);
  if (status) {
    hb_free(per_length);
    return status;
  }
  if (hb_node_find(node, "section")) {
    status = read_section(r, node, arc, rod, per_length);
  } else {
    status = read_bending(r, hb_node_find(node, "bending"), arc, rod);
    if (!status)
      status =
          hb_scene_along(r, hb_node_find(node, "twisting"), arc, false, HB_RULE_NOT_NEGATIVE, rod->beta, 1);
  }
  if (!status) status = read_mass(r, node, arc, rod, per_length);
  hb_free(per_length);
  return status;
}
