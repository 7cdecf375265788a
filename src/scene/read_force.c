/* Loads: gravity, point, distributed, per vertex, wind. */
#include "scene/read.h"

#include "base/memory.h"
#include "math/rotation.h"

#include <string.h>

/* Adds an empty load; *out is valid until the next is added. */
static hb_status add(hb_scene_reader *r, const hb_node *node, hb_force_kind kind, hb_force_def **out) {
  size_t count = (size_t)r->def->force_count;
  if ((count & (count - 1)) == 0) {
    hb_force_def *grown = hb_realloc(r->def->forces, count ? 2 * count : 1, sizeof *grown);
    if (!grown) return hb_fail_memory(r->err, "forces");
    r->def->forces = grown;
  }
  *out = &r->def->forces[r->def->force_count++];
  hb_force_def_init(*out);
  (*out)->kind = kind;
  hb_scene_place(node, &(*out)->line, &(*out)->column);
  return HB_OK;
}

/* The rod, or the entry with copies, of a name that is nearest to text, for the message. */
static const char *nearest_rod(const hb_scene_reader *r, const char *text) {
  const char *best = NULL;
  for (int k = 0; k < r->entry_count; k++) {
    const char *const pair[] = {r->entries[k].name, best ? best : r->entries[k].name, NULL};
    const char *near = hb_scene_nearest(text, pair);
    if (near) best = near;
  }
  return best;
}

/* rod: name | index | all; the name of an entry with copies means all of them */
static hb_status read_rod(hb_scene_reader *r, const hb_node *node, int *rod, int *rods) {
  *rod = -1;
  *rods = 0;
  if (!node) return HB_OK;
  if (node->kind != HB_NODE_SCALAR || !node->text[0])
    return hb_scene_expected(r, node, "the name of a rod, its index, or all");
  if (!strcmp(node->text, "all")) return HB_OK;
  if (hb_scene_find_rods(r, node->text, rod, rods)) return HB_OK;
  if (strspn(node->text, "0123456789") == strlen(node->text))
    return hb_scene_whole(r, node, 0, r->def->rod_count - 1, rod);
  const char *near = nearest_rod(r, node->text);
  if (near)
    return hb_scene_fail(r, node, "no rod has the name \"%.60s\"; the nearest name is \"%s\"", node->text,
                         near);
  return hb_scene_expected(r, node, "the name of a rod, its index, or all");
}

/* {normal, tangential}, both >= 0, default 0 */
static hb_status read_pair(hb_scene_reader *r, const hb_node *node, double out[2]) {
  static const char *const keys[] = {"normal", "tangential", NULL};
  if (!node) return HB_OK;
  hb_status status = hb_scene_check_keys(r, node, keys);
  if (!status) status = hb_scene_number(r, hb_node_find(node, "normal"), HB_RULE_NOT_NEGATIVE, &out[0]);
  if (!status) status = hb_scene_number(r, hb_node_find(node, "tangential"), HB_RULE_NOT_NEGATIVE, &out[1]);
  return status;
}

/* drag: {density, normal_coefficient, tangential_coefficient}: coefficients per radius. The pressure
 * density/2 w^2 acts on the breadth 2 radius across the rod, and on the girth 2 pi radius along it. */
static hb_status read_drag(hb_scene_reader *r, const hb_node *node, double per_radius[2]) {
  static const char *const keys[] = {"density", "normal_coefficient", "tangential_coefficient", NULL};
  double density = 0, c[2] = {1.2, 0.01};
  const hb_node *child;
  hb_status status = hb_scene_check_keys(r, node, keys);
  if (!status)
    status = hb_scene_need(r, node, "density", "the density of the medium, a number or formula > 0,", &child);
  if (!status) status = hb_scene_number(r, child, HB_RULE_POSITIVE, &density);
  if (!status) status = hb_scene_number(r, hb_node_find(node, keys[1]), HB_RULE_NOT_NEGATIVE, &c[0]);
  if (!status) status = hb_scene_number(r, hb_node_find(node, keys[2]), HB_RULE_NOT_NEGATIVE, &c[1]);
  per_radius[0] = 0.5 * density * c[0] * 2;
  per_radius[1] = 0.5 * density * c[1] * 2 * HB_PI;
  return status;
}

/* wind: {velocity, linear, quadratic | drag}. */
static hb_status read_wind(hb_scene_reader *r, const hb_node *node, int rod, int rods) {
  static const char *const keys[] = {"velocity", "linear", "quadratic", "drag", NULL};
  const hb_node *velocity, *drag = hb_node_find(node, "drag"), *quadratic = hb_node_find(node, "quadratic");
  double linear[2] = {0, 0}, square[2] = {0, 0}, per_radius[2] = {0, 0};
  hb_force_def *f;
  hb_status status = hb_scene_check_keys(r, node, keys);
  if (!status)
    status = hb_scene_need(r, node, "velocity", "a list [x, y, z] of three numbers or formulas", &velocity);
  if (!status && drag && quadratic)
    status =
        hb_scene_fail_key(r, drag, "\"quadratic\" is given already; one of quadratic and drag is expected");
  if (!status && !drag && !quadratic && !hb_node_find(node, "linear"))
    status = hb_scene_fail_key(r, node, "the resistance is missing; linear, quadratic or drag is expected");
  if (!status) status = read_pair(r, hb_node_find(node, "linear"), linear);
  if (!status) status = read_pair(r, quadratic, square);
  if (!status && drag) status = read_drag(r, drag, per_radius);
  if (!status) status = add(r, node, HB_FORCE_WIND, &f);
  if (status) return status;
  f->rod = rod;
  f->rods = rods;
  for (int c = 0; c < 2; c++) {
    f->linear[c] = linear[c];
    f->quadratic[c] = square[c];
    f->per_radius[c] = per_radius[c];
  }
  return hb_scene_formulas(r, velocity, HB_VARS_ALL, f->value);
}

/* The one kind of a load. */
static hb_status find_kind(hb_scene_reader *r, const hb_node *node, hb_force_kind *kind,
                           const hb_node **value) {
  static const struct {
    const char *key;
    hb_force_kind kind;
  } kinds[] = {{"gravity", HB_FORCE_GRAVITY},
               {"point", HB_FORCE_POINT},
               {"distributed", HB_FORCE_DISTRIBUTED},
               {"per_vertex", HB_FORCE_PER_VERTEX},
               {"wind", HB_FORCE_WIND}};
  *value = NULL;
  for (size_t k = 0; k < sizeof kinds / sizeof kinds[0]; k++) {
    const hb_node *child = hb_node_find(node, kinds[k].key);
    if (child && *value)
      return hb_scene_fail_key(r, child,
                               "\"%s\" is given already; an entry has one of gravity, point, distributed, "
                               "per_vertex, wind",
                               (*value)->key);
    if (child) {
      *value = child;
      *kind = kinds[k].kind;
    }
  }
  if (*value) return HB_OK;
  return hb_scene_fail_key(
      r, node, "no force is given; one of gravity, point, distributed, per_vertex, wind is expected");
}

/* Vertex of a point load: on every rod where it acts. */
static hb_status read_vertex(hb_scene_reader *r, const hb_node *node, int rod, int rods, int *vertex) {
  const hb_force_def at = {.rod = rod, .rods = rods};
  int least = 0;
  if (!node) return HB_OK;
  for (int k = 0; k < r->def->rod_count; k++)
    if (hb_force_def_acts_on(&at, k) && (least == 0 || r->def->rods[k].nv < least))
      least = r->def->rods[k].nv;
  return hb_scene_whole(r, node, -least, least - 1, vertex);
}

/* One entry of forces. */
static hb_status read_force(hb_scene_reader *r, const hb_node *node) {
  static const char *const keys[] = {"gravity", "point",  "distributed", "per_vertex", "wind",
                                     "rod",     "vertex", "follower",    NULL};
  const hb_node *value = NULL, *vertex = hb_node_find(node, "vertex"),
                *turning = hb_node_find(node, "follower");
  hb_force_kind kind = HB_FORCE_GRAVITY;
  hb_force_def *f;
  int rod = -1, rods = 0, index = 0;
  bool follower = false;
  hb_status status = hb_scene_check_keys(r, node, keys);
  if (!status) status = find_kind(r, node, &kind, &value);
  if (!status) status = read_rod(r, hb_node_find(node, "rod"), &rod, &rods);
  if (!status && vertex && kind != HB_FORCE_POINT)
    status = hb_scene_fail_key(r, vertex, "belongs to a point force, not to %s", value->key);
  if (!status && !vertex && kind == HB_FORCE_POINT)
    status = hb_scene_need(r, node, "vertex", "the index of a vertex, from 0 (-1 is the last),", &vertex);
  if (!status) status = read_vertex(r, vertex, rod, rods, &index);
  if (!status && turning && (kind == HB_FORCE_GRAVITY || kind == HB_FORCE_WIND))
    status = hb_scene_fail_key(r, turning, "belongs to point, distributed and per_vertex forces, not to %s",
                               value->key);
  if (!status) status = hb_scene_flag(r, turning, &follower);
  if (status) return status;
  if (kind == HB_FORCE_WIND) return read_wind(r, value, rod, rods);
  status = add(r, node, kind, &f);
  if (status) return status;
  f->rod = rod;
  f->rods = rods;
  f->vertex = index;
  f->follower = follower;
  return hb_scene_formulas(r, value, HB_VARS_ALL, f->value);
}

/* gravity and forces. */
hb_status hb_scene_read_forces(hb_scene_reader *r, const hb_node *root) {
  const hb_node *gravity = hb_node_find(root, "gravity"), *list = hb_node_find(root, "forces");
  hb_force_def *f;
  hb_status status = HB_OK;
  if (gravity) {
    status = add(r, gravity, HB_FORCE_GRAVITY, &f);
    if (!status) status = hb_scene_formulas(r, gravity, HB_VARS_ALL, f->value);
  }
  if (!status && list && list->kind != HB_NODE_LIST)
    return hb_scene_expected(r, list, "a list of forces, each beginning with -");
  for (int k = 0; !status && list && k < list->count; k++) status = read_force(r, list->children[k]);
  return status;
}
