/* Check files of `hebra validate`: YAML to a case, every mistake with its place. */
#include "cli/validate.h"

#include "base/memory.h"
#include "scene/read.h"

#include <errno.h>
#include <string.h>

const char *const cli_deed_words[] = {"not_yet",   "start", "solve", "run",
                                      "threshold", "trace", "modes", NULL};
const char *const cli_over_words[] = {"last",   "at",        "most",    "least", "drift",
                                      "period", "frequency", "reaches", NULL};
const char *const cli_kind_words[] = {"exact", "smooth", "rough", NULL};

/* A text file as a whole; NULL and a sentence if not. */
static char *read_text(const char *path, size_t *length, hb_error *err) {
  enum { MOST = 1 << 20 };
  FILE *file = fopen(path, "rb");
  if (!file) {
    hb_fail(err, HB_ERR_INPUT, "%s: the check file cannot be opened: %s", path, strerror(errno));
    return NULL;
  }
  char *text = hb_alloc(MOST, 1);
  *length = text ? fread(text, 1, MOST, file) : 0;
  int problem = ferror(file) ? errno : 0;
  fclose(file);
  if (!text)
    hb_fail_memory(err, "a check file");
  else if (problem || *length == MOST) {
    hb_fail(err, HB_ERR_INPUT, "%s: the check file cannot be read: %s", path,
            problem ? strerror(problem) : "it has more than a megabyte");
    hb_free(text);
    text = NULL;
  }
  return text;
}

/* A text that stays in the tree. */
static hb_status borrow(const hb_scene_reader *r, const hb_node *root, const char *key, const char **out) {
  const hb_node *node = hb_node_find(root, key);
  if (!node) return HB_OK;
  if (node->kind != HB_NODE_SCALAR || !node->text[0]) return hb_scene_expected(r, node, "a text");
  *out = node->text;
  return HB_OK;
}

/* Which of the deeds is given. */
static hb_status read_deed(const hb_scene_reader *r, const hb_node *root, cli_case *c) {
  const hb_node *found = NULL;
  for (int k = 0; k < CLI_DEED_COUNT; k++) {
    const hb_node *node = hb_node_find(root, cli_deed_words[k]);
    if (node && found)
      return hb_scene_fail_key(r, node, "\"%s\" is given as well; one of them is expected", found->key);
    if (!node) continue;
    found = node;
    c->deed = (cli_deed)k;
  }
  if (!found)
    return hb_scene_fail_key(r, root,
                             "it is not said what to do; one of the keys start, solve, run, threshold, "
                             "trace, modes or not_yet is expected");
  if (c->deed == CLI_NOT_YET) return borrow(r, root, "not_yet", &c->not_yet);
  c->options = found;
  static const char *const start[] = {NULL};
  static const char *const solve[] = {"any", "load_steps", "time", "tolerance", NULL};
  static const char *const run[] = {"every", NULL};
  static const char *const threshold[] = {"of", "from", "to", "resolution", "time", "load_steps", NULL};
  static const char *const trace[] = {"of", "from", "to", "step", "any", "time", NULL};
  static const char *const modes[] = {"count", "any", "load_steps", "time", "tolerance", NULL};
  static const char *const *const keys[] = {start, start, solve, run, threshold, trace, modes};
  if (found->kind == HB_NODE_SCALAR && !found->text[0] && !found->quoted) return HB_OK; /* `solve:` alone */
  return hb_scene_check_keys(r, found, keys[c->deed]);
}

/* A mapping of settings. lists: every value is a list, all of the same length, which becomes *count. */
static hb_status read_settings(const hb_scene_reader *r, const hb_node *node, bool lists, int *count) {
  if (!node) return HB_OK;
  if (node->kind != HB_NODE_MAP || node->count == 0)
    return hb_scene_expected(
        r, node, lists ? "a mapping of names to lists of values" : "a mapping of names to values");
  if (node->count > CLI_CASE_SETTINGS)
    return hb_scene_fail(r, node, "%d settings are too many; at most %d are allowed", node->count,
                         CLI_CASE_SETTINGS);
  for (int k = 0; k < node->count; k++) {
    const hb_node *child = node->children[k];
    if (lists && (child->kind != HB_NODE_LIST || child->count == 0))
      return hb_scene_expected(r, child, "a list of values");
    if (lists && k > 0 && child->count != *count)
      return hb_scene_fail(r, child, "a list of %d entries is not allowed; %d are expected, as in \"%s\"",
                           child->count, *count, node->children[0]->key);
    if (lists) *count = child->count;
    for (int i = 0; i < (lists ? child->count : 1); i++) {
      const hb_node *value = lists ? child->children[i] : child;
      if (value->kind != HB_NODE_SCALAR || !value->text[0])
        return hb_scene_expected(r, value, "a number, formula or word");
    }
  }
  return HB_OK;
}

/* One entry of `read`: a text, or {REDUCTION: text, with: value}. */
static hb_status read_read(const hb_scene_reader *r, const hb_node *node, cli_deed deed, cli_read *out) {
  *out = (cli_read){.name = node->key, .over = CLI_LAST, .node = node};
  if (node->kind == HB_NODE_SCALAR && node->text[0]) return HB_OK;
  static const char *const keys[] = {"last",      "at",      "most", "least", "drift", "period",
                                     "frequency", "reaches", "of",   "near",  "level", NULL};
  if (node->kind != HB_NODE_MAP) return hb_scene_expected(r, node, "a quantity such as position.z[-1]");
  hb_status status = hb_scene_check_keys(r, node, keys);
  const hb_node *found = NULL;
  for (int k = 0; !status && cli_over_words[k]; k++) {
    const hb_node *given = hb_node_find(node, cli_over_words[k]);
    if (given && found)
      return hb_scene_fail_key(r, given, "\"%s\" is given as well; one of them is expected", found->key);
    if (!given) continue;
    found = given;
    out->over = (cli_over)k;
  }
  if (status) return status;
  if (!found)
    return hb_scene_fail_key(r, node,
                             "it is not said how; one of last, at, most, least, drift, period, "
                             "frequency, reaches is expected");
  if (deed != CLI_RUN && out->over != CLI_LAST)
    return hb_scene_fail_key(r, found, "nothing moves here; only a run has quantities over time");
  bool timed = out->over == CLI_AT || out->over == CLI_REACHES;
  const hb_node *of = hb_node_find(node, "of"), *near = hb_node_find(node, "near"),
                *level = hb_node_find(node, "level");
  if (timed && !of) return hb_scene_fail_key(r, node, "the key \"of\" is missing; a quantity is expected");
  if (!timed && of) return hb_scene_fail_key(r, of, "the quantity stands behind \"%s\" already", found->key);
  if (near && out->over != CLI_FREQUENCY)
    return hb_scene_fail_key(r, near, "only a frequency is looked for near a value");
  if (level && out->over != CLI_PERIOD) return hb_scene_fail_key(r, level, "only a period has a level");
  out->node = timed ? of : found;
  out->value = timed ? found : near ? near : level;
  if (out->node->kind != HB_NODE_SCALAR || !out->node->text[0])
    return hb_scene_expected(r, out->node, "a quantity such as position.z[-1]");
  return HB_OK;
}

/* The numbers that are read. */
static hb_status read_reads(const hb_scene_reader *r, const hb_node *node, cli_case *c) {
  if (!node) return HB_OK;
  if (node->kind != HB_NODE_MAP) return hb_scene_expected(r, node, "a mapping of names to quantities");
  if (node->count > CLI_CASE_READS)
    return hb_scene_fail(r, node, "%d quantities are too many; at most %d are allowed", node->count,
                         CLI_CASE_READS);
  for (int k = 0; k < node->count; k++) {
    static const char letters[] = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ_0123456789";
    const hb_node *child = node->children[k];
    size_t n = strlen(child->key);
    if (n == 0 || n > 60 || strspn(child->key, letters) != n || strchr("0123456789", child->key[0]))
      return hb_scene_fail_key(r, child,
                               "a name of letters, digits and _ is expected (at most 60, no digit first)");
    hb_formula *taken = NULL;
    hb_status parsed = hb_formula_parse(child->key, HB_VARS_ALL, NULL, 0, &taken, NULL);
    bool reserved = parsed == HB_OK;
    hb_formula_free(taken);
    if (parsed == HB_ERR_MEMORY) return hb_fail_memory(r->err, "a name");
    if (reserved)
      return hb_scene_fail_key(r, child,
                               "the name belongs to the formula language; another name is expected");
    hb_status status = read_read(r, child, c->deed, &c->reads[c->read_count++]);
    if (status) return status;
  }
  return HB_OK;
}

/* Is the list of known values as long as there are columns and meshes? */
static hb_status check_shape(const hb_scene_reader *r, const hb_node *is, const cli_case *c) {
  if (is->kind == HB_NODE_SCALAR && is->text[0]) return HB_OK;
  if (is->kind != HB_NODE_LIST)
    return hb_scene_expected(r, is, "a number, a formula, a list of them, or same");
  bool by_variant = c->vary != NULL;
  int expected = by_variant ? c->variants : c->mesh_count;
  if (is->count != expected)
    return hb_scene_fail(r, is, "a list of %d values is not allowed; %d are expected, one for each %s",
                         is->count, expected, by_variant ? "entry of the lists in \"vary\"" : "mesh");
  for (int k = 0; k < is->count; k++) {
    const hb_node *child = is->children[k];
    if (child->kind == HB_NODE_SCALAR && child->text[0]) continue;
    if (!by_variant || child->kind != HB_NODE_LIST) return hb_scene_expected(r, child, "a number or formula");
    if (child->count != c->mesh_count)
      return hb_scene_fail(r, child, "a list of %d values is not allowed; %d are expected, one for each mesh",
                           child->count, c->mesh_count);
    for (int i = 0; i < child->count; i++)
      if (child->children[i]->kind != HB_NODE_SCALAR)
        return hb_scene_expected(r, child->children[i], "a number or formula");
  }
  return HB_OK;
}

/* Tolerances and order of an expectation. */
static hb_status read_tolerances(const hb_scene_reader *r, const hb_node *node, const cli_case *c,
                                 cli_expect *e) {
  const hb_node *order = hb_node_find(node, "order"), *within = hb_node_find(node, "within"),
                *absolute = hb_node_find(node, "absolute"), *limit = hb_node_find(node, "limit"),
                *kind = hb_node_find(node, "kind");
  int word = order ? CLI_SMOOTH : CLI_EXACT;
  hb_status status = hb_scene_choice(r, kind, cli_kind_words, &word);
  if (!status) status = hb_scene_number(r, within, HB_RULE_POSITIVE, &e->within);
  if (!status) status = hb_scene_number(r, absolute, HB_RULE_POSITIVE, &e->absolute);
  if (!status) status = hb_scene_number(r, limit, HB_RULE_POSITIVE, &e->limit);
  if (!status) status = hb_scene_number(r, order, HB_RULE_POSITIVE, &e->order);
  e->order_within = 0.1;
  if (!status)
    status = hb_scene_number(r, hb_node_find(node, "order_within"), HB_RULE_POSITIVE, &e->order_within);
  if (status) return status;
  e->kind = (cli_kind)word;
  if (!within == !absolute)
    return hb_scene_fail_key(r, node, "%s; one of within (relative) and absolute is expected",
                             within ? "two tolerances are given" : "no tolerance is given");
  if (order && (c->mesh_count < 3 || !c->size))
    return hb_scene_fail_key(r, order,
                             "an order needs \"meshes\" with at least three values and their \"size\"");
  if (order && e->kind == CLI_EXACT)
    return hb_scene_fail_key(r, order, "what is exact on every mesh has no order");
  if (limit && !order)
    return hb_scene_fail_key(r, limit, "a limit is extrapolated by the \"order\", which is missing");
  return HB_OK;
}

/* One known number. */
static hb_status read_expect(const hb_scene_reader *r, const hb_node *node, const cli_case *c,
                             cli_expect *e) {
  static const char *const keys[] = {"name",     "find",  "is",    "kind",         "within",
                                     "absolute", "order", "limit", "order_within", NULL};
  hb_status status = hb_scene_check_keys(r, node, keys);
  *e = (cli_expect){.name = NULL};
  if (!status) status = hb_scene_need(r, node, "find", "a formula of what is read", &e->find);
  if (!status) status = hb_scene_need(r, node, "is", "the known value", &e->is);
  if (!status && (e->find->kind != HB_NODE_SCALAR || !e->find->text[0]))
    status = hb_scene_expected(r, e->find, "a formula of what is read");
  if (!status) status = borrow(r, node, "name", &e->name);
  if (status) return status;
  if (!e->name) e->name = e->find->text;
  e->same = e->is->kind == HB_NODE_SCALAR && strcmp(e->is->text, "same") == 0;
  if (e->same && c->variants * c->mesh_count < 2)
    return hb_scene_fail(r, e->is, "there is only one point, with nothing to be the same as");
  status = check_shape(r, e->is, c);
  return status ? status : read_tolerances(r, node, c, e);
}

/* All known numbers. */
static hb_status read_expects(const hb_scene_reader *r, const hb_node *root, cli_case *c) {
  const hb_node *node = NULL;
  hb_status status = hb_scene_need(r, root, "expect", "a list of what is known", &node);
  if (status) return status;
  if (node->kind != HB_NODE_LIST || node->count == 0)
    return hb_scene_expected(r, node, "a list of what is known");
  if (node->count > CLI_CASE_EXPECTS)
    return hb_scene_fail(r, node, "%d entries are too many; at most %d are allowed", node->count,
                         CLI_CASE_EXPECTS);
  for (int k = 0; !status && k < node->count; k++)
    status = read_expect(r, node->children[k], c, &c->expects[c->expect_count++]);
  return status;
}

/* Path of the scene, relative to the check file; the file of the same name if none is given. */
static hb_status read_scene(const hb_scene_reader *r, const hb_node *root, cli_case *c) {
  const char *given = NULL, *slash = strrchr(c->path, '/');
  hb_status status = borrow(r, root, "scene", &given);
  if (status || c->deed == CLI_NOT_YET) return status;
  size_t folder = slash ? (size_t)(slash - c->path) + 1 : 0,
         room = strlen(c->path) + (given ? strlen(given) : 0) + 8;
  c->scene = hb_alloc(room, 1);
  if (!c->scene) return hb_fail_memory(r->err, "path of a scene");
  if (given && given[0] == '/')
    snprintf(c->scene, room, "%s", given);
  else if (given)
    snprintf(c->scene, room, "%.*s%s", (int)folder, c->path, given);
  else
    snprintf(c->scene, room, "%.*s%s.yaml", (int)folder, c->path, c->name);
  return HB_OK;
}

/* Everything in the file. */
static hb_status read_root(const hb_scene_reader *r, cli_case *c) {
  static const char *const keys[] = {"title", "id",     "source", "note",      "fast",   "scene", "not_yet",
                                     "start", "solve",  "run",    "threshold", "trace",  "modes", "set",
                                     "vary",  "meshes", "size",   "read",      "expect", NULL};
  const hb_node *root = c->root;
  hb_status status = hb_scene_check_keys(r, root, keys);
  if (!status && !hb_node_find(root, "title"))
    status = hb_scene_fail_key(r, root, "the key \"title\" is missing; a text is expected");
  if (!status) status = borrow(r, root, "title", &c->title);
  if (!status) status = borrow(r, root, "id", &c->id);
  if (!status) status = borrow(r, root, "source", &c->source);
  if (!status) status = borrow(r, root, "note", &c->note);
  if (!status) status = hb_scene_flag(r, hb_node_find(root, "fast"), &c->fast);
  if (!status) status = read_deed(r, root, c);
  if (!status) status = read_scene(r, root, c);
  if (status || c->deed == CLI_NOT_YET) return status;
  c->set = hb_node_find(root, "set");
  c->vary = hb_node_find(root, "vary");
  c->meshes = hb_node_find(root, "meshes");
  c->size = hb_node_find(root, "size");
  if (!status) status = read_settings(r, c->set, false, NULL);
  if (!status) status = read_settings(r, c->vary, true, &c->variants);
  if (!status) status = read_settings(r, c->meshes, true, &c->mesh_count);
  if (!status && c->variants * c->mesh_count > CLI_CASE_POINTS)
    status =
        hb_scene_fail_key(r, c->vary ? c->vary : c->meshes, "%d points are too many; at most %d are allowed",
                          c->variants * c->mesh_count, CLI_CASE_POINTS);
  if (!status) status = read_reads(r, hb_node_find(root, "read"), c);
  return status ? status : read_expects(r, root, c);
}

/* Name of the case: that of the file without ".check.yaml" or ".yaml". */
static void name_case(cli_case *c) {
  static const char *const ends[] = {".check.yaml", ".yaml", ".yml"};
  const char *slash = strrchr(c->path, '/'), *name = slash ? slash + 1 : c->path;
  size_t length = strlen(name);
  for (size_t k = 0; k < sizeof ends / sizeof ends[0]; k++) {
    size_t n = strlen(ends[k]);
    if (length > n && strcmp(name + length - n, ends[k]) == 0) {
      length -= n;
      break;
    }
  }
  snprintf(c->name, sizeof c->name, "%.*s", (int)(length < sizeof c->name ? length : sizeof c->name - 1),
           name);
}

/* File to case. */
hb_status cli_case_read(const char *path, cli_case **out, hb_error *err) {
  size_t length = 0;
  hb_scene_def none;
  hb_scene_def_init(&none);
  hb_scene_reader r = {.name = path, .limits = hb_scene_default_limits(), .def = &none, .err = err};
  *out = NULL;
  cli_case *c = hb_alloc(1, sizeof *c);
  char *text = c ? read_text(path, &length, err) : NULL;
  if (c) c->path = hb_strdup(path);
  if (c) c->variants = c->mesh_count = 1;
  if (!c || (text && !c->path)) hb_fail_memory(err, "a check file");
  hb_status status = text && c->path ? HB_OK : err->status;
  if (!status) name_case(c);
  if (!status) status = hb_scene_yaml_parse(text, length, path, &r.limits, &c->root, err);
  if (!status) status = read_root(&r, c);
  hb_free(text);
  if (status) {
    cli_case_free(c);
    return status;
  }
  *out = c;
  return HB_OK;
}

/* Frees a case. */
void cli_case_free(cli_case *c) {
  if (!c) return;
  hb_node_free(c->root);
  hb_free(c->path);
  hb_free(c->scene);
  hb_free(c);
}
