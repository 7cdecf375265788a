#include "model/formula_names.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

/* Longest name for which a nearest one is looked for. */
#define NEAR_MAX 32
/* Parameters listed in a sentence before it says "and so on". */
#define LISTED_MAX 12

static const hb_function functions[] = {
    {"sin", HB_OP_SIN, 1, 1},     {"cos", HB_OP_COS, 1, 1},     {"tan", HB_OP_TAN, 1, 1},
    {"asin", HB_OP_ASIN, 1, 1},   {"acos", HB_OP_ACOS, 1, 1},   {"atan", HB_OP_ATAN, 1, 1},
    {"atan2", HB_OP_ATAN2, 2, 2}, {"sinh", HB_OP_SINH, 1, 1},   {"cosh", HB_OP_COSH, 1, 1},
    {"tanh", HB_OP_TANH, 1, 1},   {"exp", HB_OP_EXP, 1, 1},     {"log", HB_OP_LOG, 1, 1},
    {"log10", HB_OP_LOG10, 1, 1}, {"sqrt", HB_OP_SQRT, 1, 1},   {"abs", HB_OP_ABS, 1, 1},
    {"floor", HB_OP_FLOOR, 1, 1}, {"ceil", HB_OP_CEIL, 1, 1},   {"min", HB_OP_MIN, 2, -1},
    {"max", HB_OP_MAX, 2, -1},    {"mod", HB_OP_MOD, 2, 2},     {"sign", HB_OP_SIGN, 1, 1},
    {"step", HB_OP_STEP, 1, 2},   {"clamp", HB_OP_CLAMP, 3, 3}, {"smoothstep", HB_OP_SMOOTHSTEP, 3, 3},
    {"pow", HB_OP_POWER, 2, 2},   {"hypot", HB_OP_HYPOT, 2, 2}, {"if", HB_OP_IF, 3, 3},
    {"noise", HB_OP_NOISE, 1, 2},
};
#define FUNCTION_COUNT (sizeof functions / sizeof functions[0])

static const struct {
  const char *name, *meaning;
} variables[HB_VAR_COUNT] = {
    {"t", "time"},
    {"s", "arc length"},
    {"u", "relative arc length"},
    {"x", "position"},
    {"y", "position"},
    {"z", "position"},
    {"i", "index"},
    {"L", "rest length of the rod"},
};

static const struct {
  const char *name;
  double value;
} constants[] = {{"pi", 3.14159265358979323846}, {"e", 2.71828182845904523536}};
#define CONSTANT_COUNT (sizeof constants / sizeof constants[0])

/* Appends formatted text. */
void hb_phrase_add(hb_phrase *phrase, const char *format, ...) {
  size_t room = sizeof phrase->text - phrase->length;
  va_list args;
  va_start(args, format);
  int n = vsnprintf(phrase->text + phrase->length, room, format, args);
  va_end(args);
  if (n > 0) phrase->length += (size_t)n < room ? (size_t)n : room - 1;
}

/* True if the name, of at least one character, is exactly text. */
static bool is(hb_name name, const char *text) {
  return text[0] == name.at[0] && strlen(text) == name.length && memcmp(name.at, text, name.length) == 0;
}

/* Exact name. */
const hb_function *hb_function_find(hb_name name) {
  for (size_t k = 0; k < FUNCTION_COUNT; k++)
    if (is(name, functions[k].name)) return &functions[k];
  return NULL;
}

/* Exact name. */
bool hb_variable_find(hb_name name, hb_variable *out) {
  for (int k = 0; k < HB_VAR_COUNT; k++) {
    if (!is(name, variables[k].name)) continue;
    *out = (hb_variable)k;
    return true;
  }
  return false;
}

/* Exact name. */
bool hb_builtin_constant(hb_name name, double *value) {
  for (size_t k = 0; k < CONSTANT_COUNT; k++) {
    if (!is(name, constants[k].name)) continue;
    *value = constants[k].value;
    return true;
  }
  return false;
}

/* Exact name; the first of several. */
const hb_parameter *hb_parameter_find(hb_name name, const hb_parameter *parameters, int count) {
  for (int k = 0; k < count; k++)
    if (parameters[k].name && is(name, parameters[k].name)) return &parameters[k];
  return NULL;
}

/* Variables and constants; functions are told apart by their parenthesis. */
bool hb_formula_reserves(const char *text) {
  hb_name name = {text, strlen(text)};
  hb_variable variable;
  double value;
  return hb_variable_find(name, &variable) || hb_builtin_constant(name, &value);
}

/* Lower case of an ASCII letter. */
static char lower(char c) { return c >= 'A' && c <= 'Z' ? (char)(c - 'A' + 'a') : c; }

/* Edits (insert, delete, replace, swap neighbours) between two names, not counting upper and lower case. */
static int distance(hb_name a, const char *b) {
  int row[3][NEAR_MAX + 1];
  int n = (int)strlen(b), m = (int)a.length;
  if (n > NEAR_MAX || m > NEAR_MAX) return NEAR_MAX;
  for (int j = 0; j <= n; j++) row[0][j] = j;
  for (int i = 1; i <= m; i++) {
    int *now = row[i % 3], *last = row[(i + 2) % 3], *before = row[(i + 1) % 3];
    char c = lower(a.at[i - 1]);
    now[0] = i;
    for (int j = 1; j <= n; j++) {
      char d = lower(b[j - 1]);
      int best = last[j - 1] + (c != d);
      if (last[j] + 1 < best) best = last[j] + 1;
      if (now[j - 1] + 1 < best) best = now[j - 1] + 1;
      bool swapped = i > 1 && j > 1 && c == lower(b[j - 2]) && d == lower(a.at[i - 2]);
      if (swapped && before[j - 2] + 1 < best) best = before[j - 2] + 1;
      now[j] = best;
    }
  }
  return row[m % 3][n];
}

typedef struct nearest {
  const char *name;
  int edits;
} nearest;

/* Keeps candidate if it is nearer than what was found so far. */
static void consider(nearest *found, hb_name name, const char *candidate) {
  int edits = distance(name, candidate);
  if (edits < found->edits) *found = (nearest){candidate, edits};
}

/* Edits that still count as a slip of the pen: the longer the name, the more. */
static nearest nothing_near(hb_name name) {
  int edits = name.length < 2 ? 0 : name.length < 4 ? 1 : name.length < 7 ? 2 : 3;
  return (nearest){NULL, edits + 1};
}

/* "t, s, pi, e and the parameters a, b" */
static void list_available(unsigned allowed, const hb_parameter *parameters, int count, hb_phrase *out) {
  hb_phrase_add(out, "available here are ");
  for (int k = 0; k < HB_VAR_COUNT; k++)
    if (allowed & HB_VAR_BIT((unsigned)k)) hb_phrase_add(out, "%s, ", variables[k].name);
  hb_phrase_add(out, "%s, %s", constants[0].name, constants[1].name);
  for (int k = 0; k < count && k < LISTED_MAX; k++) {
    const char *lead = k > 0 ? ", " : count > 1 ? " and the parameters " : " and the parameter ";
    hb_phrase_add(out, "%s%.40s", lead, parameters[k].name ? parameters[k].name : "");
  }
  if (count > LISTED_MAX) hb_phrase_add(out, " and %d more", count - LISTED_MAX);
}

/* A variable in the wrong place, a function without arguments, or a slip of the pen. */
void hb_name_unknown(hb_name name, unsigned allowed, const hb_parameter *parameters, int count,
                     hb_phrase *out) {
  hb_variable variable;
  int shown = name.length > 40 ? 40 : (int)name.length;
  if (hb_function_find(name)) {
    hb_phrase_add(out, "'%.*s' is a function; write its arguments in parentheses, as in %.*s(...)", shown,
                  name.at, shown, name.at);
    return;
  }
  if (hb_variable_find(name, &variable)) {
    hb_phrase_add(out, "'%s' (%s) cannot be used here; ", variables[variable].name,
                  variables[variable].meaning);
    list_available(allowed, parameters, count, out);
    return;
  }
  if (is(name, "k") || is(name, "K")) {
    hb_phrase_add(out, "'%c' (%s) can be used in a rod with copies only; ", name.at[0],
                  name.at[0] == 'k' ? "number of the copy" : "number of copies");
    list_available(allowed, parameters, count, out);
    return;
  }
  nearest found = nothing_near(name);
  for (int k = 0; k < HB_VAR_COUNT; k++)
    if (allowed & HB_VAR_BIT((unsigned)k)) consider(&found, name, variables[k].name);
  for (size_t k = 0; k < CONSTANT_COUNT; k++) consider(&found, name, constants[k].name);
  for (int k = 0; k < count; k++)
    if (parameters[k].name) consider(&found, name, parameters[k].name);
  hb_phrase_add(out, "unknown name '%.*s'", shown, name.at);
  if (found.name) hb_phrase_add(out, ", did you mean '%.40s'?", found.name);
  hb_phrase_add(out, "%s ", found.name ? "" : ";");
  list_available(allowed, parameters, count, out);
}

/* A value that is called like a function, or a slip of the pen. */
void hb_function_unknown(hb_name name, const hb_parameter *parameters, int count, hb_phrase *out) {
  hb_variable variable;
  double value;
  int shown = name.length > 40 ? 40 : (int)name.length;
  if (hb_variable_find(name, &variable) || hb_builtin_constant(name, &value) ||
      hb_parameter_find(name, parameters, count)) {
    hb_phrase_add(out, "'%.*s' is not a function; write %.*s*(...) to multiply", shown, name.at, shown,
                  name.at);
    return;
  }
  nearest found = nothing_near(name);
  for (size_t k = 0; k < FUNCTION_COUNT; k++) consider(&found, name, functions[k].name);
  hb_phrase_add(out, "unknown function '%.*s'", shown, name.at);
  if (found.name) hb_phrase_add(out, ", did you mean '%s'?", found.name);
  hb_phrase_add(out, "%s functions are ", found.name ? "" : ";");
  for (size_t k = 0; k < FUNCTION_COUNT; k++) hb_phrase_add(out, k ? ", %s" : "%s", functions[k].name);
}
