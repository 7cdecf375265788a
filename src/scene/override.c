/* `--set rods[0].bending=2`: walks the tree along the path and puts the value there. */
#include "scene/tree.h"

#include "base/memory.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* One override on its way through the tree. */
typedef struct setter {
  const char *text;     /* the whole override */
  const hb_node *value; /* parsed */
  long nodes;           /* copies of it made so far */
  long limit;
  hb_error *err;
} setter;

/* One step of a path. */
typedef struct segment {
  char name[128]; /* key, entry's name, or "*" */
  long index;
  bool is_index;
  bool last;
} segment;

/* "--set TEXT: " and a sentence. */
static hb_status fail(const setter *s, const char *sentence, const char *detail) {
  return hb_fail(s->err, HB_ERR_INPUT, "--set %.300s: %s%s", s->text, sentence, detail);
}

/* Name of a node, also of the root. */
static const char *name_of(const hb_node *node, char *buffer, size_t size) {
  hb_node_path(node, buffer, size);
  return buffer[0] ? buffer : "the scene";
}

/* Reads `[3]` or `[*]`. */
static hb_status read_index(const setter *s, const char **at, segment *out) {
  const char *p = *at + 1;
  out->is_index = true;
  if (p[0] == '*' && p[1] == ']') {
    out->is_index = false;
    snprintf(out->name, sizeof out->name, "*");
    *at = p + 2;
    return HB_OK;
  }
  char *end = NULL;
  bool digits = *p == '-' ? (p[1] >= '0' && p[1] <= '9') : (*p >= '0' && *p <= '9');
  out->index = digits ? strtol(p, &end, 10) : 0;
  if (!digits || *end != ']') return fail(s, "a whole number or * is expected in [ ]", "");
  *at = end + 1;
  return HB_OK;
}

/* Reads the next step of the path; *at moves past it. */
static hb_status read_segment(const setter *s, const char **at, segment *out) {
  *out = (segment){.index = 0};
  if (**at == '[') {
    hb_status status = read_index(s, at, out);
    if (status != HB_OK) return status;
  } else {
    size_t n = strcspn(*at, ".[]=");
    if (n == 0) return fail(s, "a key is missing in the path before =", "");
    if (n >= sizeof out->name) return fail(s, "a key in the path is longer than 127 characters", "");
    memcpy(out->name, *at, n);
    *at += n;
  }
  out->last = **at == '=';
  if (out->last || **at == '[') return HB_OK;
  if (**at != '.') return fail(s, "the path before = is not of the form a.b[0].c", "");
  ++*at;
  return HB_OK;
}

/* Marks a copied value as made by the override. */
static void mark(hb_node *node, const char *origin) {
  node->origin = origin;
  for (int i = 0; i < node->count; i++) mark(node->children[i], origin);
}

/* A fresh copy of the value. */
static hb_node *copy_value(setter *s) {
  hb_node *copy = hb_node_copy(s->value, &s->nodes, s->limit);
  if (copy) mark(copy, s->text);
  return copy;
}

static hb_status apply(setter *s, hb_node *node, const char *at);

/* Goes on with a child, or replaces it where the path ends. */
static hb_status enter(setter *s, hb_node *child, const segment *step, const char *at) {
  if (!step->last) return apply(s, child, at);
  hb_node *copy = copy_value(s);
  if (!copy) return hb_fail_memory(s->err, "--set value");
  hb_node_replace(child, copy);
  return HB_OK;
}

/* Adds a child that was not there: the value, or a mapping (a list before an index) to go on with. */
static hb_status add(setter *s, hb_node *node, const char *key, const segment *step, const char *at) {
  hb_node_kind kind = *at == '[' ? HB_NODE_LIST : HB_NODE_MAP;
  hb_node *child = step->last ? copy_value(s) : hb_node_create(kind, 1, 1);
  if (child) child->origin = s->text;
  if (!child || !hb_node_append(node, child, key)) {
    hb_node_free(child);
    return hb_fail_memory(s->err, "--set value");
  }
  return step->last ? HB_OK : apply(s, child, at);
}

/* Lists the names of a list's entries for a message. */
static void names_in(const hb_node *list, char *buffer, size_t size) {
  buffer[0] = 0;
  for (int i = 0; i < list->count; i++) {
    const hb_node *name = hb_node_find(list->children[i], "name");
    size_t used = strlen(buffer);
    if (name && name->text && used + 80 < size)
      snprintf(buffer + used, size - used, "%s%.60s", used ? ", " : "", name->text);
  }
}

/* A step into a list: by index, by the entry's name, or into all of them. */
static hb_status enter_list(setter *s, hb_node *node, const segment *step, const char *at) {
  char path[256], detail[960], names[400];
  if (step->is_index) {
    long index = step->index < 0 ? step->index + node->count : step->index;
    if (index == node->count && step->index >= 0) return add(s, node, NULL, step, at);
    if (index >= 0 && index < node->count) return enter(s, node->children[index], step, at);
    snprintf(detail, sizeof detail, "%s has %d entries, so there is no [%ld]",
             name_of(node, path, sizeof path), node->count, step->index);
    return fail(s, detail, "");
  }
  if (strcmp(step->name, "*") == 0) {
    for (int i = 0; i < node->count; i++) {
      hb_status status = enter(s, node->children[i], step, at);
      if (status != HB_OK) return status;
    }
    return HB_OK;
  }
  for (int i = 0; i < node->count; i++) {
    const hb_node *name = hb_node_find(node->children[i], "name");
    if (name && name->text && strcmp(name->text, step->name) == 0)
      return enter(s, node->children[i], step, at);
  }
  names_in(node, names, sizeof names);
  snprintf(detail, sizeof detail, "no entry of %s has the name \"%s\"; %s%s",
           name_of(node, path, sizeof path), step->name,
           names[0] ? "the names there are " : "give its index in [ ], from 0", names);
  return fail(s, detail, "");
}

/* Walks on from node. at points to the next step of the path. */
static hb_status apply(setter *s, hb_node *node, const char *at) {
  segment step;
  char path[256], detail[512];
  hb_status status = read_segment(s, &at, &step);
  if (status != HB_OK) return status;
  if (node->kind == HB_NODE_LIST) return enter_list(s, node, &step, at);
  if (node->kind == HB_NODE_SCALAR || step.is_index) {
    snprintf(detail, sizeof detail, "%s is a %s, so the path cannot go on with %s",
             name_of(node, path, sizeof path), node->kind == HB_NODE_SCALAR ? "single value" : "mapping",
             step.is_index ? "an index" : step.name);
    return fail(s, detail, "");
  }
  hb_node *child = hb_node_find(node, step.name);
  if (child) return enter(s, child, &step, at);
  return add(s, node, step.name, &step, at);
}

/* Number of steps of a path, to keep created mappings within the depth limit. */
static int path_depth(const char *text) {
  int depth = 1;
  for (; *text && *text != '='; text++) depth += *text == '.' || *text == '[';
  return depth;
}

/* Applies one override. */
hb_status hb_scene_override(hb_node *root, const char *override, const hb_scene_limits *limits,
                            hb_error *err) {
  setter s = {.text = override, .limit = limits->nodes, .err = err};
  const char *equals = strchr(override, '=');
  char name[360];
  if (!equals) return fail(&s, "KEY=VALUE is expected, for example --set method.time_step=1e-4", "");
  if (equals[1] == 0) return fail(&s, "a value is missing after =", "");
  if (path_depth(override) > limits->depth) return fail(&s, "the path before = is too long", "");
  snprintf(name, sizeof name, "--set %.300s: value", override);
  hb_node *value = NULL;
  hb_status status = hb_scene_yaml_parse(equals + 1, strlen(equals + 1), name, limits, &value, err);
  if (status != HB_OK) return status;
  s.value = value;
  status = apply(&s, root, override);
  hb_node_free(value);
  return status;
}
