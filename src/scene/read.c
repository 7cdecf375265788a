#include "scene/read.h"

#include "base/memory.h"
#include "math/vec3.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Writes "name:line:column: key: " or "--set text: key: ". */
static void put_place(const hb_scene_reader *r, const hb_node *node, bool at_key, char *buffer, size_t size) {
  char path[300];
  hb_node_path(node, path, sizeof path);
  int line = at_key && node->key ? node->key_line : node->line;
  int column = at_key && node->key ? node->key_column : node->column;
  const char *colon = path[0] ? ": " : "";
  if (node->origin)
    snprintf(buffer, size, "--set %.200s: %s%s", node->origin, path, colon);
  else
    snprintf(buffer, size, "%.300s:%d:%d: %s%s", r->name, line, column, path, colon);
}

/* " (copy 37 of 100)" behind a sentence that is about one copy of a rod. What is wrong with the first copy is
 * wrong with the entry, if nothing else is known. */
static const char *put_copy(const hb_scene_reader *r, bool of_this, char buffer[64]) {
  buffer[0] = 0;
  if (r->copies && (of_this || r->copy > 0)) snprintf(buffer, 64, " (copy %d of %d)", r->copy, r->copies);
  return buffer;
}

/* Fails at the value. */
hb_status hb_scene_fail(const hb_scene_reader *r, const hb_node *node, const char *format, ...) {
  char place[700], sentence[700];
  va_list args;
  char copy[64];
  put_place(r, node, false, place, sizeof place);
  va_start(args, format);
  vsnprintf(sentence, sizeof sentence, format, args);
  va_end(args);
  return hb_fail(r->err, HB_ERR_INPUT, "%s%s%s", place, sentence, put_copy(r, false, copy));
}

/* Fails at the key. */
hb_status hb_scene_fail_key(const hb_scene_reader *r, const hb_node *node, const char *format, ...) {
  char place[700], sentence[700];
  va_list args;
  char copy[64];
  put_place(r, node, true, place, sizeof place);
  va_start(args, format);
  vsnprintf(sentence, sizeof sentence, format, args);
  va_end(args);
  return hb_fail(r->err, HB_ERR_INPUT, "%s%s%s", place, sentence, put_copy(r, false, copy));
}

/* A value for a message: short, on one line. */
static const char *shown(const char *text, char buffer[72]) {
  size_t n = 0;
  for (; text[n] && n < 60; n++) buffer[n] = (unsigned char)text[n] < 32 ? ' ' : text[n];
  while (text[n] && n > 0 && ((unsigned char)text[n] & 0xC0) == 0x80)
    n--; /* not in the middle of a character */
  snprintf(buffer + n, 72 - n, "%s", text[n] ? "..." : "");
  return buffer;
}

/* Says what was found and what is allowed. */
hb_status hb_scene_expected(const hb_scene_reader *r, const hb_node *node, const char *what) {
  char buffer[72];
  if (node->kind == HB_NODE_LIST)
    return hb_scene_fail(r, node, "a list is not allowed here; %s is expected", what);
  if (node->kind == HB_NODE_MAP)
    return hb_scene_fail(r, node, "a mapping is not allowed here; %s is expected", what);
  if (!node->text[0]) return hb_scene_fail_key(r, node, "the value is empty; %s is expected", what);
  return hb_scene_fail(r, node, "\"%s\" is not allowed; %s is expected", shown(node->text, buffer), what);
}

/* Passes on an inner sentence. */
hb_status hb_scene_pass(const hb_scene_reader *r, const hb_node *node, const hb_error *inner) {
  if (inner->status != HB_ERR_INPUT) return hb_fail(r->err, inner->status, "%s", inner->text);
  return hb_scene_fail(r, node, "%s", inner->text);
}

/* Place for a definition. */
void hb_scene_place(const hb_node *node, int *line, int *column) {
  *line = node->origin ? 0 : node->line;
  *column = node->origin ? 0 : node->column;
}

/* Number of single-character changes (and swaps of neighbours) from a to b; lengths up to 63. */
static int distance(const char *a, const char *b) {
  int n = (int)strlen(a), m = (int)strlen(b), d[64][64];
  if (n > 63 || m > 63) return 1000;
  for (int i = 0; i <= n; i++) d[i][0] = i;
  for (int j = 0; j <= m; j++) d[0][j] = j;
  for (int i = 1; i <= n; i++)
    for (int j = 1; j <= m; j++) {
      int best = d[i - 1][j - 1] + (a[i - 1] != b[j - 1]);
      if (d[i - 1][j] + 1 < best) best = d[i - 1][j] + 1;
      if (d[i][j - 1] + 1 < best) best = d[i][j - 1] + 1;
      bool swap = i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1];
      if (swap && d[i - 2][j - 2] + 1 < best) best = d[i - 2][j - 2] + 1;
      d[i][j] = best;
    }
  return d[n][m];
}

/* The nearest word, if at most about half of it would have to change. */
const char *hb_scene_nearest(const char *text, const char *const *words) {
  const char *best = NULL;
  int least = 1000;
  for (; *words; words++) {
    int d = distance(text, *words);
    if (d < least) {
      least = d;
      best = *words;
    }
  }
  return best && 2 * least <= (int)strlen(best) + 1 ? best : NULL;
}

/* Joins words by commas. */
static void join(const char *const *words, char *buffer, size_t size) {
  buffer[0] = 0;
  for (size_t used = 0; *words && used < size; words++, used = strlen(buffer))
    snprintf(buffer + used, size - used, "%s%s", used ? ", " : "", *words);
}

/* In [ ] and { } a comma ends a value, also one inside a formula: `[max(z, 0), 0, 0]` has four entries. A
 * value with an open parenthesis gives that away. */
static bool is_torn(const char *text) {
  int open = 0;
  for (; *text; text++) open += (*text == '(') - (*text == ')');
  return open != 0;
}

/* A list with so many entries. */
hb_status hb_scene_list(const hb_scene_reader *r, const hb_node *node, int count, const char *what) {
  bool torn = false;
  if (node->kind != HB_NODE_LIST) return hb_scene_expected(r, node, what);
  if (node->count == count) return HB_OK;
  for (int i = 0; i < node->count && !torn; i++)
    torn = node->children[i]->kind == HB_NODE_SCALAR && is_torn(node->children[i]->text);
  return hb_scene_fail(r, node, "a list of %d entr%s is not allowed; %s is expected%s", node->count,
                       node->count == 1 ? "y" : "ies", what,
                       torn ? " (a formula with a comma must stand in quotes here)" : "");
}

/* Only known keys. */
hb_status hb_scene_check_keys(const hb_scene_reader *r, const hb_node *node, const char *const *keys) {
  char list[400];
  if (node->kind != HB_NODE_MAP) {
    char what[460];
    join(keys, list, sizeof list);
    snprintf(what, sizeof what, "a mapping with the keys %s", list);
    return hb_scene_expected(r, node, what);
  }
  for (int i = 0; i < node->count; i++) {
    const hb_node *child = node->children[i];
    bool known = false;
    for (int k = 0; keys[k] && !known; k++) known = strcmp(keys[k], child->key) == 0;
    if (known) continue;
    if (is_torn(child->key))
      return hb_scene_fail_key(r, child,
                               "unknown key; a formula with a comma must stand in quotes inside { }");
    const char *near = hb_scene_nearest(child->key, keys);
    if (near) return hb_scene_fail_key(r, child, "unknown key; the nearest known key here is \"%s\"", near);
    join(keys, list, sizeof list);
    return hb_scene_fail_key(r, child, "unknown key; the known keys here are %s", list);
  }
  return HB_OK;
}

/* A key that must be there. */
hb_status hb_scene_need(const hb_scene_reader *r, const hb_node *node, const char *key, const char *hint,
                        const hb_node **out) {
  *out = hb_node_find(node, key);
  if (*out) return HB_OK;
  return hb_scene_fail_key(r, node, "the key \"%s\" is missing; %s is expected", key, hint);
}

/* What a rule allows, in words. */
static const char *rule_words(hb_scene_rule rule) {
  return rule == HB_RULE_ANY        ? "a number or formula"
         : rule == HB_RULE_POSITIVE ? "a number or formula > 0"
                                    : "a number or formula >= 0";
}

/* Does the value keep the rule? */
static bool keeps(double value, hb_scene_rule rule) {
  return isfinite(value) && (rule == HB_RULE_ANY || (rule == HB_RULE_POSITIVE ? value > 0 : value >= 0));
}

/* Complains about a formula's value; where names the place on the rod or is "". */
static hb_status fail_value(const hb_scene_reader *r, const hb_node *node, double value, const char *where,
                            const char *what) {
  char *end, buffer[72], copy[64];
  strtod(node->text, &end);
  if (!*end && !where[0]) return hb_scene_expected(r, node, what);
  if (isnan(value)) value = fabs(value); /* its sign is not the same everywhere */
  return hb_scene_fail(r, node, "\"%s\" gives %g%s, which is not allowed; %s is expected%s",
                       shown(node->text, buffer), value, where, what,
                       r->copy == 0 ? put_copy(r, true, copy) : "");
}

/* A compiled formula. */
hb_status hb_scene_formula(const hb_scene_reader *r, const hb_node *node, unsigned allowed,
                           hb_formula **out) {
  hb_error inner = {.status = HB_OK};
  if (!node) return HB_OK;
  *out = NULL;
  if (node->kind != HB_NODE_SCALAR || !node->text[0])
    return hb_scene_expected(r, node, "a number or formula");
  int parameters = r->def->parameter_count + (r->copies ? HB_SCENE_COPY_NAMES : 0);
  hb_status status = hb_formula_parse(node->text, allowed, r->def->parameters, parameters, out, &inner);
  if (status == HB_ERR_INPUT)
    return hb_scene_fail(r, node, "not a number or formula that is allowed here: %s", inner.text);
  if (status != HB_OK) return hb_scene_pass(r, node, &inner);
  const double vars[HB_VAR_COUNT] = {0};
  /* What may depend on time is not evaluated before the run; the rest is checked where its value is used. */
  bool check = (allowed & HB_VARS_TIME) && hb_formula_is_constant(*out);
  double value = check ? hb_formula_eval(*out, vars) : 0;
  if (isfinite(value)) return HB_OK;
  hb_formula_free(*out);
  *out = NULL;
  return fail_value(r, node, value, "", "a number or formula with a finite value");
}

/* A constant number. */
hb_status hb_scene_number(const hb_scene_reader *r, const hb_node *node, hb_scene_rule rule, double *out) {
  hb_formula *formula = NULL;
  const double vars[HB_VAR_COUNT] = {0};
  if (!node) return HB_OK;
  if (node->kind != HB_NODE_SCALAR || !node->text[0]) return hb_scene_expected(r, node, rule_words(rule));
  hb_status status = hb_scene_formula(r, node, HB_VARS_NONE, &formula);
  if (status != HB_OK) return status;
  double value = hb_formula_eval(formula, vars);
  hb_formula_free(formula);
  if (!keeps(value, rule)) return fail_value(r, node, value, "", rule_words(rule));
  *out = value;
  return HB_OK;
}

/* A whole number lo .. hi. */
hb_status hb_scene_whole(const hb_scene_reader *r, const hb_node *node, long lo, long hi, int *out) {
  char what[96];
  double value = 0;
  if (!node) return HB_OK;
  snprintf(what, sizeof what, "a whole number from %ld to %ld", lo, hi);
  if (node->kind != HB_NODE_SCALAR || !node->text[0]) return hb_scene_expected(r, node, what);
  hb_status status = hb_scene_number(r, node, HB_RULE_ANY, &value);
  if (status != HB_OK) return status;
  if (value != floor(value) || value < (double)lo || value > (double)hi)
    return fail_value(r, node, value, "", what);
  *out = (int)value;
  return HB_OK;
}

/* true or false. */
hb_status hb_scene_flag(const hb_scene_reader *r, const hb_node *node, bool *out) {
  static const char *const words[] = {"false", "true", NULL};
  int choice = 0;
  if (!node) return HB_OK;
  if (node->kind != HB_NODE_SCALAR || (strcmp(node->text, "true") && strcmp(node->text, "false")))
    return hb_scene_expected(r, node, "true or false");
  hb_status status = hb_scene_choice(r, node, words, &choice);
  *out = choice == 1;
  return status;
}

/* One of some words. */
hb_status hb_scene_choice(const hb_scene_reader *r, const hb_node *node, const char *const *words, int *out) {
  char what[300] = "one of ";
  if (!node) return HB_OK;
  for (int k = 0; node->kind == HB_NODE_SCALAR && words[k]; k++)
    if (strcmp(words[k], node->text) == 0) {
      *out = k;
      return HB_OK;
    }
  join(words, what + strlen(what), sizeof what - strlen(what));
  return hb_scene_expected(r, node, what);
}

/* A text. */
hb_status hb_scene_text(const hb_scene_reader *r, const hb_node *node, char **out) {
  if (!node) return HB_OK;
  if (node->kind != HB_NODE_SCALAR) return hb_scene_expected(r, node, "a text");
  char *copy = hb_strdup(node->text);
  if (!copy) return hb_fail_memory(r->err, "text");
  hb_free(*out);
  *out = copy;
  return HB_OK;
}

/* Three numbers. */
hb_status hb_scene_vector(const hb_scene_reader *r, const hb_node *node, double out[3]) {
  if (!node) return HB_OK;
  hb_status status = hb_scene_list(r, node, 3, "a list [x, y, z] of three numbers or formulas");
  if (status != HB_OK) return status;
  for (int c = 0; c < 3; c++) {
    status = hb_scene_number(r, node->children[c], HB_RULE_ANY, &out[c]);
    if (status != HB_OK) return status;
  }
  return HB_OK;
}

/* Three numbers, not all zero. */
hb_status hb_scene_direction(const hb_scene_reader *r, const hb_node *node, double out[3]) {
  hb_status status = hb_scene_vector(r, node, out);
  if (status != HB_OK || !node) return status;
  if (out[0] == 0 && out[1] == 0 && out[2] == 0)
    return hb_scene_fail(r, node, "[0, 0, 0] is not allowed; a direction, not zero, is expected");
  return HB_OK;
}

/* Three formulas. */
hb_status hb_scene_formulas(const hb_scene_reader *r, const hb_node *node, unsigned allowed,
                            hb_formula *out[3]) {
  if (!node) return HB_OK;
  hb_status status = hb_scene_list(r, node, 3, "a list [x, y, z] of three numbers or formulas");
  if (status != HB_OK) return status;
  for (int c = 0; c < 3; c++) {
    status = hb_scene_formula(r, node->children[c], allowed, &out[c]);
    if (status == HB_OK) continue;
    for (int d = 0; d < c; d++) {
      hb_formula_free(out[d]);
      out[d] = NULL;
    }
    return status;
  }
  return HB_OK;
}

/* Variables at a vertex or at the middle of an edge. */
void hb_scene_vars(const hb_scene_arc *arc, bool on_edges, int k, double vars[HB_VAR_COUNT]) {
  double length = arc->s[arc->nv - 1], s = on_edges ? 0.5 * (arc->s[k] + arc->s[k + 1]) : arc->s[k];
  memset(vars, 0, HB_VAR_COUNT * sizeof *vars);
  vars[HB_VAR_S] = s;
  vars[HB_VAR_U] = length > 0 ? s / length : 0;
  vars[HB_VAR_I] = k;
  vars[HB_VAR_L] = length;
  for (int c = 0; arc->place && c < 3; c++) vars[HB_VAR_X + c] = arc->place[3 * k + c];
}

/* A formula at all vertices or edges. */
hb_status hb_scene_along(const hb_scene_reader *r, const hb_node *node, const hb_scene_arc *arc,
                         bool on_edges, hb_scene_rule rule, double *out, int stride) {
  hb_formula *formula = NULL;
  double vars[HB_VAR_COUNT];
  if (node->kind != HB_NODE_SCALAR) return hb_scene_expected(r, node, rule_words(rule));
  hb_status status = hb_scene_formula(r, node, HB_VARS_ARC, &formula);
  if (status != HB_OK) return status;
  bool constant = hb_formula_is_constant(formula);
  for (int k = 0; status == HB_OK && k < arc->nv - on_edges; k++) {
    if (!constant || k == 0) hb_scene_vars(arc, on_edges, k, vars);
    double value = constant && k > 0 ? out[0] : hb_formula_eval(formula, vars);
    out[(size_t)k * (size_t)stride] = value;
    if (keeps(value, rule)) continue;
    char where[40] = "";
    if (!constant) snprintf(where, sizeof where, " at %s %d", on_edges ? "edge" : "vertex", k);
    status = fail_value(r, node, value, where, rule_words(rule));
  }
  hb_formula_free(formula);
  return status;
}

/* Three formulas at all vertices. */
hb_status hb_scene_along_vector(const hb_scene_reader *r, const hb_node *node, const hb_scene_arc *arc,
                                double *out) {
  hb_formula *formulas[3] = {NULL, NULL, NULL};
  double vars[HB_VAR_COUNT];
  unsigned allowed = HB_VARS_ARC | (arc->place ? HB_VARS_PLACE : 0u);
  hb_status status = hb_scene_formulas(r, node, allowed, formulas);
  for (int k = 0; status == HB_OK && k < arc->nv; k++) {
    hb_scene_vars(arc, false, k, vars);
    for (int c = 0; status == HB_OK && c < 3; c++) {
      char where[40];
      double value = hb_formula_eval(formulas[c], vars);
      out[3 * k + c] = value;
      if (isfinite(value)) continue;
      snprintf(where, sizeof where, " at vertex %d", k);
      status = fail_value(r, node->children[c], value, where, "a finite number");
    }
  }
  for (int c = 0; c < 3; c++) hb_formula_free(formulas[c]);
  return status;
}

/* Arc lengths. */
void hb_scene_arc_lengths(const double *xyz, int count, double *s) {
  s[0] = 0;
  for (int i = 1; i < count; i++)
    s[i] = s[i - 1] + hb_v3_norm(hb_v3_sub(hb_v3_load(xyz + 3 * i), hb_v3_load(xyz + 3 * i - 3)));
}
