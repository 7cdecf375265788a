/* Supports: start, end, and any vertex or edge between. */
#include "scene/read.h"

#include "base/memory.h"

#include <string.h>

/* Where the supports of one mapping act. */
typedef struct site {
  int vertex, edge;        /* negative: from the end */
  bool has_edge, has_wall; /* has_wall: a clamp sits at the vertex, else at the middle of the edge */
  bool base_is_end;
} site;

/* Adds an empty support to the rod. */
static hb_status add(hb_scene_reader *r, const hb_node *node, hb_rod_def *rod, hb_support_kind kind,
                     int index, hb_support_def **out) {
  size_t count = (size_t)rod->support_count;
  if ((count & (count - 1)) == 0) { /* room for twice as many */
    hb_support_def *grown = hb_realloc(rod->supports, count ? 2 * count : 1, sizeof *grown);
    if (!grown) return hb_fail_memory(r->err, "supports");
    rod->supports = grown;
  }
  *out = &rod->supports[rod->support_count++];
  hb_support_def_init(*out);
  (*out)->kind = kind;
  (*out)->index = index;
  hb_scene_place(node, &(*out)->line, &(*out)->column);
  return HB_OK;
}

/* Is the value the word? */
static bool is_word(const hb_node *node, const char *word) {
  return node && node->kind == HB_NODE_SCALAR && strcmp(node->text, word) == 0;
}

/* position: fixed | free | [formula | fixed | free, ...] */
static hb_status read_position(hb_scene_reader *r, const hb_node *node, const site *at, hb_rod_def *rod) {
  hb_support_def *s = NULL;
  if (is_word(node, "free")) return HB_OK;
  if (!is_word(node, "fixed") && node->kind != HB_NODE_LIST)
    return hb_scene_expected(r, node, "fixed, free, or a list [x, y, z] of formulas of t, fixed or free");
  hb_status status = add(r, node, rod, HB_SUPPORT_POSITION, at->vertex, &s);
  if (status) return status;
  s->held = true; /* where no formula says otherwise */
  if (node->kind == HB_NODE_SCALAR) return HB_OK;
  status = hb_scene_list(r, node, 3, "a list [x, y, z] of formulas of t, fixed or free");
  for (int c = 0; !status && c < 3; c++) {
    const hb_node *axis = node->children[c];
    s->axis_free[c] = is_word(axis, "free");
    if (!s->axis_free[c] && !is_word(axis, "fixed"))
      status = hb_scene_formula(r, axis, HB_VARS_TIME | HB_VARS_PLACE, &s->value[c]);
  }
  return status;
}

/* tangent: fixed | free | [x, y, z] formulas of t */
static hb_status read_tangent(hb_scene_reader *r, const hb_node *node, const site *at, hb_rod_def *rod) {
  hb_support_def *s = NULL;
  if (is_word(node, "free")) return HB_OK;
  if (!is_word(node, "fixed") && node->kind != HB_NODE_LIST)
    return hb_scene_expected(r, node, "fixed, free, or a list [x, y, z] of formulas of t");
  hb_status status = add(r, node, rod, HB_SUPPORT_TANGENT, at->edge, &s);
  if (status) return status;
  s->base_is_end = at->base_is_end;
  s->held = node->kind == HB_NODE_SCALAR;
  if (node->kind == HB_NODE_LIST) status = hb_scene_formulas(r, node, HB_VARS_TIME | HB_VARS_PLACE, s->value);
  return status;
}

/* Frame: material, material_angle, or material_frame with material_turn. held: what clamp asks for. */
static hb_status read_frame(hb_scene_reader *r, const hb_node *node, const site *at, bool held,
                            hb_rod_def *rod) {
  const hb_node *word = hb_node_find(node, "material"), *angle = hb_node_find(node, "material_angle");
  const hb_node *frame = hb_node_find(node, "material_frame"), *turn = hb_node_find(node, "material_turn");
  static const char *const words[] = {"free", "fixed", NULL};
  const hb_node *second = angle && frame ? frame : word && angle ? angle : word && frame ? frame : NULL;
  hb_support_def *s = NULL;
  int choice = held;
  if (second)
    return hb_scene_fail_key(
        r, second, "\"%s\" is given already; one of material, material_angle, material_frame is expected",
        word ? "material" : "material_angle");
  if (turn && !frame)
    return hb_scene_fail_key(r, turn,
                             "needs material_frame, from which it turns; an angle alone is material_angle");
  hb_status status = hb_scene_choice(r, word, words, &choice);
  if (status || (!choice && !angle && !frame)) return status;
  const hb_node *place = frame ? frame : angle ? angle : word ? word : node;
  status = add(r, place, rod, frame ? HB_SUPPORT_DIRECTOR : HB_SUPPORT_ANGLE, at->edge, &s);
  if (status) return status;
  s->held = !frame && !angle;
  if (angle) return hb_scene_formula(r, angle, HB_VARS_TIME, &s->angle);
  status = hb_scene_formulas(r, frame, HB_VARS_TIME, s->value);
  if (!status) status = hb_scene_formula(r, turn, HB_VARS_TIME, &s->angle);
  return status;
}

/* What a site's clamp says. */
enum { NO_CLAMP, CLAMP, CLAMPED_EDGE };

/* clamp: false | true | edge */
static hb_status read_clamp(hb_scene_reader *r, const hb_node *node, int *clamp) {
  static const char *const words[] = {"false", "true", "edge", NULL};
  return hb_scene_choice(r, hb_node_find(node, "clamp"), words, clamp);
}

/* Only the words matter here; what is wrong with them is said when the supports are read. */
bool hb_scene_has_wall(const hb_node *node) {
  return node && node->kind == HB_NODE_MAP && is_word(hb_node_find(node, "clamp"), "true") &&
         !is_word(hb_node_find(node, "tangent"), "free") && !is_word(hb_node_find(node, "position"), "free");
}

/* All supports of one mapping whose keys have been checked. */
static hb_status read_site(hb_scene_reader *r, const hb_node *node, const site *at, hb_rod_def *rod) {
  const hb_node *position = hb_node_find(node, "position"), *tangent = hb_node_find(node, "tangent");
  int clamp = NO_CLAMP;
  hb_support_def *s = NULL;
  hb_status status = read_clamp(r, node, &clamp);
  bool base = clamp || (position && !is_word(position, "free"));
  if (!status && tangent && !is_word(tangent, "free") && (!base || is_word(position, "free")))
    status = hb_scene_fail_key(r, tangent, "a prescribed tangent needs a prescribed position beside it");
  bool turns = at->has_edge && (tangent ? !is_word(tangent, "free") : clamp && !is_word(position, "free"));
  for (int c = 0; !status && turns && position && position->kind == HB_NODE_LIST && c < position->count; c++)
    if (is_word(position->children[c], "free"))
      status = hb_scene_fail(r, position->children[c],
                             "\"free\" is not allowed beside a prescribed tangent, which needs x, y "
                             "and z of its base (tangent: free releases it)");
  if (!status && position) status = read_position(r, position, at, rod);
  if (!status && clamp && !position) {
    status = add(r, node, rod, HB_SUPPORT_POSITION, at->vertex, &s);
    if (!status) s->held = true;
  }
  if (!status && tangent) status = read_tangent(r, tangent, at, rod);
  if (!status && clamp && !tangent && at->has_edge && !is_word(position, "free")) {
    status = add(r, node, rod, HB_SUPPORT_TANGENT, at->edge, &s);
    if (!status) {
      s->held = true;
      s->base_is_end = at->base_is_end;
    }
  }
  for (int k = 0; !status && at->has_wall && clamp == CLAMP && k < rod->support_count; k++)
    if (rod->supports[k].kind == HB_SUPPORT_TANGENT && rod->supports[k].index == at->edge)
      rod->supports[k].wall = true;
  if (!status && at->has_edge) status = read_frame(r, node, at, clamp != NO_CLAMP, rod);
  return status;
}

/* One entry of supports: a vertex (position only) or an edge (its first vertex is the base). */
static hb_status read_entry(hb_scene_reader *r, const hb_node *node, hb_rod_def *rod) {
  static const char *const keys[] = {
      "vertex",         "edge",           "position",      "tangent", "material",
      "material_angle", "material_frame", "material_turn", "clamp",   NULL};
  static const char *const of_edges[] = {"tangent",        "material",      "material_angle",
                                         "material_frame", "material_turn", "clamp"};
  site at = {0};
  hb_status status = hb_scene_check_keys(r, node, keys);
  if (status) return status;
  const hb_node *vertex = hb_node_find(node, "vertex"), *edge = hb_node_find(node, "edge");
  if (vertex && edge)
    return hb_scene_fail_key(r, edge, "\"vertex\" is given already; one of vertex and edge is expected");
  if (!vertex && !edge)
    return hb_scene_fail_key(r, node, "the place is missing; one of vertex and edge is expected");
  for (size_t k = 0; vertex && k < sizeof of_edges / sizeof of_edges[0]; k++) {
    const hb_node *child = hb_node_find(node, of_edges[k]);
    if (child) return hb_scene_fail_key(r, child, "belongs to an edge; give \"edge\" instead of \"vertex\"");
  }
  at.has_edge = edge != NULL;
  status = hb_scene_whole(r, vertex, -rod->nv, rod->nv - 1, &at.vertex);
  if (!status) status = hb_scene_whole(r, edge, -(rod->nv - 1), rod->nv - 2, &at.edge);
  if (status) return status;
  if (edge) at.vertex = at.edge >= 0 ? at.edge : at.edge + rod->nv - 1;
  if (node->count < 2)
    return hb_scene_fail_key(r, node, "nothing is prescribed; position%s is expected",
                             edge ? ", tangent, material, material_angle, material_frame or clamp" : "");
  return read_site(r, node, &at, rod);
}

/* start, end and supports. */
hb_status hb_scene_read_supports(hb_scene_reader *r, const hb_node *node, hb_rod_def *rod) {
  static const char *const keys[] = {"position",       "tangent",       "material", "material_angle",
                                     "material_frame", "material_turn", "clamp",    NULL};
  const hb_node *start = hb_node_find(node, "start"), *end = hb_node_find(node, "end");
  const hb_node *list = hb_node_find(node, "supports");
  const site first = {.vertex = 0, .edge = 0, .has_edge = true, .has_wall = true};
  const site last = {.vertex = -1, .edge = -1, .has_edge = true, .has_wall = true, .base_is_end = true};
  hb_status status = start ? hb_scene_check_keys(r, start, keys) : HB_OK;
  if (!status && start) status = read_site(r, start, &first, rod);
  if (!status && end) status = hb_scene_check_keys(r, end, keys);
  if (!status && end) status = read_site(r, end, &last, rod);
  if (!status && list && list->kind != HB_NODE_LIST)
    status = hb_scene_expected(r, list, "a list of mappings with vertex or edge");
  for (int k = 0; !status && list && k < list->count; k++) status = read_entry(r, list->children[k], rod);
  return status;
}
