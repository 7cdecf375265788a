/* The whole scene: text, tree, overrides, sections in the order in which they need one another. */
#include "scene/read.h"

#include "base/memory.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>

/* Is the word taken by the formula language? Then a parameter of that name could not be told from it. */
static hb_status find_reserved(const char *name, bool *reserved, hb_error *err) {
  static const char *const calls[] = {"", "(1)", "(1,1)", "(1,1,1)"};
  char text[80];
  *reserved = false;
  for (int k = 0; k < 4 && !*reserved; k++) {
    hb_formula *formula = NULL;
    snprintf(text, sizeof text, "%s%s", name, calls[k]);
    hb_status status = hb_formula_parse(text, HB_VARS_ALL, NULL, 0, &formula, err);
    hb_formula_free(formula);
    if (status == HB_ERR_MEMORY) return status;
    *reserved = status == HB_OK;
  }
  return HB_OK;
}

/* parameters: {name: formula of the earlier ones} */
static hb_status read_parameters(hb_scene_reader *r, const hb_node *node) {
  static const char letters[] = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ_0123456789";
  if (node && node->kind != HB_NODE_MAP)
    return hb_scene_expected(r, node, "a mapping of names to numbers or formulas");
  size_t count = (node ? (size_t)node->count : 0) + HB_SCENE_COPY_NAMES;
  r->def->parameters = hb_alloc(count, sizeof *r->def->parameters);
  if (!r->def->parameters) return hb_fail_memory(r->err, "parameters");
  if (!node) return HB_OK;
  for (int k = 0; k < node->count; k++) {
    const hb_node *child = node->children[k];
    size_t n = strlen(child->key);
    double value = 0;
    if (n == 0 || n > 60 || strspn(child->key, letters) != n || strchr("0123456789", child->key[0]))
      return hb_scene_fail_key(r, child,
                               "a name of letters, digits and _ is expected (at most 60, no digit first)");
    bool reserved;
    hb_status status = find_reserved(child->key, &reserved, r->err);
    if (!status && reserved)
      return hb_scene_fail_key(r, child,
                               "the name belongs to the formula language; another name is expected");
    if (!status) status = hb_scene_number(r, child, HB_RULE_ANY, &value);
    if (status) return status;
    char *name = hb_strdup(child->key);
    if (!name) return hb_fail_memory(r->err, "parameters");
    r->def->parameters[r->def->parameter_count++] = (hb_parameter){name, value};
  }
  return HB_OK;
}

/* length_tolerance: number | {relative: number} | {absolute: number} */
static hb_status read_tolerance(hb_scene_reader *r, const hb_node *node, hb_method_def *m) {
  static const char *const keys[] = {"relative", "absolute", NULL};
  if (!node) return HB_OK;
  if (node->kind != HB_NODE_MAP) return hb_scene_number(r, node, HB_RULE_POSITIVE, &m->length_tolerance);
  hb_status status = hb_scene_check_keys(r, node, keys);
  if (status) return status;
  const hb_node *relative = hb_node_find(node, "relative"), *absolute = hb_node_find(node, "absolute");
  if (!relative == !absolute)
    return hb_scene_fail_key(r, node, "%s; one of relative and absolute is expected",
                             relative ? "both are given" : "the mapping is empty");
  if (absolute) m->length_tolerance_kind = HB_TOLERANCE_ABSOLUTE;
  return hb_scene_number(r, relative ? relative : absolute, HB_RULE_POSITIVE, &m->length_tolerance);
}

/* method */
static hb_status read_method(hb_scene_reader *r, const hb_node *node) {
  static const char *const keys[] = {"integrator",       "time_step",       "duration",
                                     "length_tolerance", "max_projections", "max_twist_iterations",
                                     "precision",        "error_tolerance", NULL};
  static const char *const precisions[] = {"double", "single", NULL};
  static const char *const integrators[] = {"symplectic-euler", "verlet", "implicit", "backward-euler", NULL};
  hb_method_def *m = &r->def->method;
  const hb_node *step, *duration;
  int choice = 1, precision = 0;
  hb_scene_place(node, &m->line, &m->column);
  hb_status status = hb_scene_check_keys(r, node, keys);
  if (!status) status = hb_scene_choice(r, hb_node_find(node, "integrator"), integrators, &choice);
  if (!status) status = hb_scene_need(r, node, "time_step", "a number or formula > 0", &step);
  if (!status) status = hb_scene_number(r, step, HB_RULE_POSITIVE, &m->time_step);
  if (!status) status = hb_scene_need(r, node, "duration", "a number or formula >= 0", &duration);
  if (!status) status = hb_scene_number(r, duration, HB_RULE_NOT_NEGATIVE, &m->duration);
  if (!status) status = hb_scene_choice(r, hb_node_find(node, "precision"), precisions, &precision);
  m->precision = precision == 1 ? HB_PRECISION_SINGLE : HB_PRECISION_DOUBLE;
  if (m->precision == HB_PRECISION_SINGLE) m->length_tolerance = 1e-5;
  if (!status) status = read_tolerance(r, hb_node_find(node, "length_tolerance"), m);
  if (!status)
    status = hb_scene_number(r, hb_node_find(node, "error_tolerance"), HB_RULE_POSITIVE, &m->error_tolerance);
  if (!status)
    status = hb_scene_whole(r, hb_node_find(node, "max_projections"), 1, 1000000, &m->max_projections);
  if (!status)
    status =
        hb_scene_whole(r, hb_node_find(node, "max_twist_iterations"), 1, 1000000, &m->max_twist_iterations);
  if (status) return status;
  m->integrator = hb_strdup(integrators[choice]);
  return m->integrator ? HB_OK : hb_fail_memory(r->err, "integrator");
}

/* A field or a group of fields. */
static hb_status read_field(const hb_scene_reader *r, const hb_node *node, uint64_t *fields) {
  const char *words[HB_FIELD_COUNT + 16] = {NULL};
  int count = 0;
  if (node->kind != HB_NODE_SCALAR) return hb_scene_expected(r, node, "the name of a field");
  for (int k = 0; k < hb_field_group_count; k++) {
    words[count++] = hb_field_groups[k].name;
    if (strcmp(node->text, hb_field_groups[k].name) == 0) *fields |= hb_field_groups[k].fields;
  }
  for (int k = 0; k < hb_frame_field_count; k++) {
    words[count++] = hb_frame_fields[k].name;
    if (strcmp(node->text, hb_frame_fields[k].name) == 0) *fields |= (uint64_t)1 << k;
  }
  for (int k = 0; k < count; k++)
    if (strcmp(node->text, words[k]) == 0) return HB_OK;
  const char *near = hb_scene_nearest(node->text, words);
  char list[1024] = "";
  for (int k = 0; !near && k < count; k++) {
    size_t used = strlen(list);
    snprintf(list + used, sizeof list - used, "%s%s", k ? ", " : "", words[k]);
  }
  return near ? hb_scene_fail(r, node, "\"%s\" is no field; the nearest name is \"%s\"", node->text, near)
              : hb_scene_fail(r, node, "\"%s\" is no field; there are %s", node->text, list);
}

/* A name, or a list of them; positions are always there. */
static hb_status read_fields(hb_scene_reader *r, const hb_node *node) {
  uint64_t fields = HB_FIELD_BIT(position);
  hb_status status = HB_OK;
  if (!node) return HB_OK;
  if (node->kind == HB_NODE_MAP) return hb_scene_expected(r, node, "a list of names of fields");
  if (node->kind == HB_NODE_SCALAR) status = read_field(r, node, &fields);
  for (int k = 0; !status && node->kind == HB_NODE_LIST && k < node->count; k++)
    status = read_field(r, node->children[k], &fields);
  if (!status) r->def->output.fields = fields;
  return status;
}

/* output */
static hb_status read_output(hb_scene_reader *r, const hb_node *node) {
  static const char *const keys[] = {"every", "checkpoint", "fields", "precision", "link", NULL};
  static const char *const precisions[] = {"double", "single", NULL};
  int precision = 0;
  if (!node) return HB_OK;
  hb_status status = hb_scene_check_keys(r, node, keys);
  if (!status) status = hb_scene_whole(r, hb_node_find(node, "every"), 1, 1000000000, &r->def->output.every);
  const hb_node *checkpoint = hb_node_find(node, "checkpoint");
  if (!status) status = read_fields(r, hb_node_find(node, "fields"));
  if (!status) status = hb_scene_choice(r, hb_node_find(node, "precision"), precisions, &precision);
  r->def->output.single = precision == 1;
  if (!status) status = hb_scene_flag(r, hb_node_find(node, "link"), &r->def->output.link);
  if (!status)
    status = hb_scene_number(r, checkpoint, HB_RULE_NOT_NEGATIVE, &r->def->output.checkpoint_seconds);
  return status;
}

/* All sections. */
static hb_status read_root(hb_scene_reader *r, const hb_node *root) {
  static const char *const keys[] = {"title", "description", "units",  "parameters", "method", "gravity",
                                     "rods",  "forces",      "output", "trace",      NULL};
  const hb_node *method, *rods, *units = hb_node_find(root, "units");
  hb_status status = hb_scene_check_keys(r, root, keys);
  if (!status) status = hb_scene_text(r, hb_node_find(root, "title"), &r->def->title);
  if (!status) status = hb_scene_text(r, hb_node_find(root, "description"), &r->def->description);
  if (!status && units && units->kind != HB_NODE_SCALAR) status = hb_scene_expected(r, units, "a text");
  if (!status) status = read_parameters(r, hb_node_find(root, "parameters"));
  if (!status) status = hb_scene_need(r, root, "method", "a mapping with time_step and duration", &method);
  if (!status) status = read_method(r, method);
  if (!status) status = hb_scene_need(r, root, "rods", "a list of rods", &rods);
  if (!status) status = hb_scene_read_rods(r, rods);
  if (!status) status = hb_scene_read_forces(r, root);
  if (!status) status = read_output(r, hb_node_find(root, "output"));
  if (!status) status = hb_scene_read_trace(r, hb_node_find(root, "trace"));
  return status;
}

/* Keeps the text that would give this scene again. */
static hb_status keep_source(hb_scene_reader *r, const hb_node *root, const char *text, size_t length,
                             bool changed) {
  if (changed) return hb_scene_emit(root, &r->def->source, r->err);
  r->def->source = hb_strndup(text, length);
  return r->def->source ? HB_OK : hb_fail_memory(r->err, "scene text");
}

/* Text to definition with chosen limits. */
hb_status hb_scene_parse_limited(const char *text, size_t length, const hb_scene_reader *settings,
                                 const char *const *overrides, int override_count) {
  hb_scene_reader r = *settings;
  hb_node *root = NULL;
  if (length >= 3 &&
      memcmp(text, "\xEF\xBB\xBF", 3) == 0) { /* the mark that some editors put in front of UTF-8 */
    text += 3;
    length -= 3;
  }
  hb_scene_def_init(r.def);
  hb_status status = hb_scene_yaml_parse(text, length, r.name, &r.limits, &root, r.err);
  for (int k = 0; !status && k < override_count; k++)
    status = hb_scene_override(root, overrides[k], &r.limits, r.err);
  if (!status) status = read_root(&r, root);
  if (!status) status = keep_source(&r, root, text, length, override_count > 0);
  hb_node_free(root);
  hb_free(r.entries);
  hb_free(r.names);
  if (status) hb_scene_def_free(r.def);
  return status;
}

/* Text to definition. */
hb_status hb_scene_parse(const char *text, size_t length, const char *name, const char *base_dir,
                         const char *const *overrides, int override_count, hb_scene_def *def, hb_error *err) {
  hb_scene_reader settings = {
      .name = name, .base_dir = base_dir, .limits = hb_scene_default_limits(), .def = def, .err = err};
  return hb_scene_parse_limited(text, length, &settings, overrides, override_count);
}

/* The whole file as text. */
static hb_status read_file(const char *path, size_t limit, char **out, size_t *length, hb_error *err) {
  FILE *file = fopen(path, "rb");
  size_t size = 0, used = 0;
  char *text = NULL;
  if (!file)
    return hb_fail(err, HB_ERR_INPUT, "%s: the scene file cannot be opened: %s", path, strerror(errno));
  for (;;) {
    if (used == size) {
      size = size ? 2 * size : 16384;
      char *grown = hb_realloc(text, size, 1);
      if (!grown) {
        hb_free(text);
        fclose(file);
        return hb_fail_memory(err, "scene file");
      }
      text = grown;
    }
    size_t n = fread(text + used, 1, size - used, file);
    used += n;
    if (n == 0 || used > limit) break;
  }
  int problem = ferror(file) ? errno : 0;
  fclose(file);
  if (problem) {
    hb_free(text);
    return hb_fail(err, HB_ERR_INPUT, "%s: the scene file cannot be read: %s", path, strerror(problem));
  }
  *out = text;
  *length = used;
  return HB_OK;
}

/* File to definition. */
hb_status hb_scene_read(const char *path, const char *const *overrides, int override_count, hb_scene_def *def,
                        hb_error *err) {
  char *text = NULL;
  size_t length = 0;
  const char *slash = strrchr(path, '/');
  hb_scene_def_init(def);
  hb_status status = read_file(path, hb_scene_default_limits().bytes, &text, &length, err);
  if (status) return status;
  char *base_dir = slash ? hb_strndup(path, slash == path ? 1 : (size_t)(slash - path)) : hb_strdup(".");
  status = base_dir ? hb_scene_parse(text, length, path, base_dir, overrides, override_count, def, err)
                    : hb_fail_memory(err, "path");
  hb_free(text);
  hb_free(base_dir);
  if (status) return status;
  def->path = hb_strdup(path);
  if (def->path) return HB_OK;
  hb_scene_def_free(def);
  return hb_fail_memory(err, "path");
}
