/* Quantities of a moment by name. */
#include "cli/probe.h"

#include "base/memory.h"
#include "rod/writhe.h"

#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { FIELD, TOTAL, FORCE, NET_FORCE, WRITHE, OMEGA, UNSTABLE, NEUTRAL, ESCAPES, ITERATIONS, THRESHOLD };

/* Numbers of a frame that belong to no vertex. */
static const struct {
  const char *name;
  size_t offset;
  int components;
} totals[] = {{"time", offsetof(hb_frame, time), 1},
              {"kinetic", offsetof(hb_frame, kinetic), 1},
              {"bending", offsetof(hb_frame, bending), 1},
              {"twisting", offsetof(hb_frame, twisting), 1},
              {"stretching", offsetof(hb_frame, stretching), 1},
              {"gravity", offsetof(hb_frame, gravity), 1},
              {"work_loads", offsetof(hb_frame, work_loads), 1},
              {"work_supports", offsetof(hb_frame, work_supports), 1},
              {"dissipated", offsetof(hb_frame, dissipated), 1},
              {"balance", offsetof(hb_frame, balance), 1},
              {"momentum", offsetof(hb_frame, momentum), 3},
              {"angular_momentum", offsetof(hb_frame, angular_momentum), 3},
              {"length_error", offsetof(hb_frame, length_error), 1},
              {"worst_length_error", offsetof(hb_frame, worst_length_error), 1}};
/* What is computed here, or found by the search for an equilibrium. */
static const struct {
  const char *name;
  int kind, components; /* of one vertex; 0: of the whole */
} others[] = {{"force", FORCE, 3},      {"net_force", NET_FORCE, 3},   {"writhe", WRITHE, 1},
              {"mode_omega", OMEGA, 1}, {"unstable", UNSTABLE, 0},     {"neutral", NEUTRAL, 0},
              {"escapes", ESCAPES, 0},  {"iterations", ITERATIONS, 0}, {"threshold", THRESHOLD, 0}};
enum { MOST_MODES = 1000 };
enum { TOTALS = sizeof totals / sizeof totals[0], OTHERS = sizeof others / sizeof others[0] };

/* The text in pieces. */
typedef struct pieces {
  char rod[64], name[40], component[8], from[128], to[128];
  bool indexed, ranged;
} pieces;

/* Copies length characters; false if there is no room. */
static bool take(char *out, size_t room, const char *from, size_t length) {
  if (length >= room) return false;
  memcpy(out, from, length);
  out[length] = 0;
  return true;
}

/* Takes the text apart; false if it cannot be. */
static bool split(const char *text, cli_reduce *reduce, pieces *out) {
  static const char *const words[] = {"sum ", "least ", "most ", "size "};
  *out = (pieces){.indexed = false};
  *reduce = CLI_ONE;
  while (*text == ' ') text++;
  for (int k = 0; k < 4; k++)
    if (strncmp(text, words[k], strlen(words[k])) == 0) {
      *reduce = (cli_reduce)(CLI_SUM + k);
      text += strlen(words[k]);
      break;
    }
  while (*text == ' ') text++;
  size_t head = strcspn(text, "[");
  const char *colon = memchr(text, ':', head);
  if (colon) {
    if (!take(out->rod, sizeof out->rod, text, (size_t)(colon - text))) return false;
    head -= (size_t)(colon + 1 - text);
    text = colon + 1;
  }
  const char *dot = memchr(text, '.', head);
  size_t name = dot ? (size_t)(dot - text) : head;
  if (!take(out->name, sizeof out->name, text, name)) return false;
  if (dot && !take(out->component, sizeof out->component, dot + 1, head - name - 1)) return false;
  text += head;
  if (!*text) return true;
  const char *end = strrchr(text, ']');
  if (!end || end[1] || end == text + 1) return false;
  out->indexed = true;
  const char *middle = memchr(text, ':', (size_t)(end - text));
  if (!middle) return take(out->from, sizeof out->from, text + 1, (size_t)(end - text - 1));
  out->ranged = true;
  return take(out->from, sizeof out->from, text + 1, (size_t)(middle - text - 1)) &&
         take(out->to, sizeof out->to, middle + 1, (size_t)(end - middle - 1));
}

/* Index of a vertex or edge from a formula; an empty text gives the default. */
static hb_status read_index(const char *text, const cli_moment *m, int count, int fallback, int *out,
                            hb_error *err) {
  hb_formula *formula = NULL;
  const double vars[HB_VAR_COUNT] = {0};
  *out = fallback;
  if (!text[strspn(text, " ")]) return HB_OK;
  hb_status status =
      hb_formula_parse(text, 0, m->model->def->parameters, m->model->def->parameter_count, &formula, err);
  if (status) return status;
  double value = hb_formula_eval(formula, vars);
  hb_formula_free(formula);
  double index = value < 0 ? value + count : value;
  if (!(index >= 0 && index <= count - 1) || index != floor(index))
    return hb_fail(err, HB_ERR_INPUT, "[%s] gives %g; a whole number from %d to %d is expected", text, value,
                   -count, count - 1);
  *out = (int)index;
  return HB_OK;
}

/* Which quantity; entries: how many there are on the rod (0: one of the whole). */
static hb_status find_name(const pieces *p, int nv, cli_probe *out, int *entries, hb_error *err) {
  for (int k = 0; k < hb_frame_field_count; k++) {
    const hb_frame_field *field = &hb_frame_fields[k];
    if (strcmp(field->name, p->name) != 0) continue;
    *out = (cli_probe){.kind = FIELD, .offset = field->offset, .components = field->components};
    *entries = field->location == HB_ON_EDGE ? nv - 1 : nv;
    return HB_OK;
  }
  for (int k = 0; k < TOTALS; k++) {
    if (strcmp(totals[k].name, p->name) != 0) continue;
    *out = (cli_probe){.kind = TOTAL, .offset = totals[k].offset, .components = totals[k].components};
    *entries = 0;
    return HB_OK;
  }
  for (int k = 0; k < OTHERS; k++) {
    if (strcmp(others[k].name, p->name) != 0) continue;
    *out = (cli_probe){.kind = others[k].kind, .components = others[k].components ? others[k].components : 1};
    *entries = others[k].kind == OMEGA ? MOST_MODES : others[k].components ? nv : 0;
    return HB_OK;
  }
  return hb_fail(err, HB_ERR_INPUT,
                 "\"%s\" is no quantity; fields of trajectories, totals such as bending or "
                 "momentum, force, net_force, writhe, unstable, neutral, escapes, iterations, mode_omega "
                 "and threshold are",
                 p->name);
}

/* One component, or the length of all. */
static hb_status find_component(const pieces *p, cli_probe *out, hb_error *err) {
  out->component = out->components > 1 ? -1 : 0;
  if (!p->component[0]) return HB_OK;
  const char *letters = "xyz0123", *at = p->component[1] ? NULL : strchr(letters, p->component[0]);
  int component = at ? (int)(at - letters) % 3 : 0;
  if (at && isdigit((unsigned char)*at)) component = *at - '0';
  if (!at || component >= out->components || out->components == 1)
    return hb_fail(err, HB_ERR_INPUT, "\"%s\" has %d component%s, none is called \"%s\"", p->name,
                   out->components, out->components > 1 ? "s" : "", p->component);
  out->component = component;
  return HB_OK;
}

/* The rod of a name; the first if none is given. */
static hb_status find_rod(const pieces *p, const hb_model *m, const hb_rod **out, hb_error *err) {
  for (int r = 0; r < m->rod_count; r++)
    if (!p->rod[0] || strcmp(m->rods[r].name, p->rod) == 0) {
      *out = &m->rods[r];
      return HB_OK;
    }
  return hb_fail(err, HB_ERR_INPUT, "the scene has no rod called \"%s\"", p->rod);
}

/* Text to probe. */
hb_status cli_probe_parse(const char *text, const cli_moment *m, cli_probe *out, hb_error *err) {
  pieces p;
  const hb_rod *rod = NULL;
  cli_reduce reduce;
  int entries = 0;
  if (!split(text, &reduce, &p))
    return hb_fail(err, HB_ERR_INPUT,
                   "this is no quantity; something like position.z[-1] or sum reaction.x[0:1] is "
                   "expected");
  hb_status status = find_rod(&p, m->model, &rod, err);
  if (!status) status = find_name(&p, rod->nv, out, &entries, err);
  if (!status) status = find_component(&p, out, err);
  if (status) return status;
  out->reduce = reduce;
  bool whole = entries == 0, writhe = out->kind == WRITHE;
  if (out->kind == OMEGA && (p.ranged || !p.indexed || strchr(p.from, '-')))
    return hb_fail(err, HB_ERR_INPUT, "modes are counted from the lowest: mode_omega[0], mode_omega[1], ...");
  if (whole && p.indexed)
    return hb_fail(err, HB_ERR_INPUT, "\"%s\" belongs to no vertex and takes no [ ]", p.name);
  if (!whole && !p.indexed && !writhe)
    return hb_fail(err, HB_ERR_INPUT,
                   "\"%s\" has a value on each of %d places; say which: %s[0], or sum %s[0:%d]", p.name,
                   entries, p.name, p.name, entries - 1);
  if (writhe && (reduce != CLI_ONE || (p.indexed && !p.ranged)))
    return hb_fail(err, HB_ERR_INPUT,
                   "writhe belongs to a whole curve: writhe, or writhe[FROM:TO] of a closed part");
  if (!writhe && p.ranged != (reduce != CLI_ONE))
    return hb_fail(err, HB_ERR_INPUT, "%s",
                   p.ranged ? "a range needs one of the words sum, least, most, size in front"
                            : "sum, least, most and size need a range such as [0:3]");
  if (whole) return HB_OK;
  if (out->kind == OMEGA) return read_index(p.from, m, entries, 0, &out->from, err);
  status = read_index(p.from, m, entries, 0, &out->from, err);
  if (!status) status = p.ranged || writhe ? read_index(p.to, m, entries, entries - 1, &out->to, err) : HB_OK;
  if (status) return status;
  if (!p.ranged && !writhe) out->to = out->from;
  if (out->to < out->from)
    return hb_fail(err, HB_ERR_INPUT, "the range [%s:%s] runs backwards", p.from, p.to);
  if (writhe) out->reduce = p.indexed ? CLI_SUM : CLI_ONE; /* closed, open */
  out->from += rod->first;
  out->to += rod->first;
  return HB_OK;
}

/* Force with what the edges add: mass times acceleration of a free vertex. */
static void net_force(const cli_moment *m, int k, double out[3]) {
  const hb_frame *f = m->frame;
  int rod = m->model->rod_of[k], first = m->model->rods[rod].first, last = first + m->model->rods[rod].nv - 1;
  for (int c = 0; c < 3; c++) {
    out[c] = m->force[3 * k + c];
    if (k < last) out[c] += f->tension[k] * f->tangent[3 * k + c];
    if (k > first) out[c] -= f->tension[k - 1] * f->tangent[3 * k - 3 + c];
  }
}

/* One component or the length of the entry of a slot. */
static double entry(const cli_probe *p, const cli_moment *m, int slot) {
  double own[3];
  const double *values;
  if (p->kind == NET_FORCE) {
    net_force(m, slot, own);
    values = own;
  } else if (p->kind == FORCE)
    values = m->force + 3 * slot;
  else if (p->kind == TOTAL)
    values = (const double *)(const void *)((const char *)m->frame + p->offset);
  else
    values = *(double *const *)(const void *)((const char *)m->frame + p->offset) +
             (size_t)p->components * (size_t)slot;
  if (p->component >= 0) return values[p->component];
  double sum = 0;
  for (int c = 0; c < p->components; c++) sum += values[c] * values[c];
  return sqrt(sum);
}

/* The number. */
double cli_probe_read(const cli_probe *p, const cli_moment *m) {
  switch (p->kind) {
  case WRITHE:
    return hb_rod_writhe(m->frame->position + 3 * p->from, p->to - p->from + 1, p->reduce == CLI_SUM);
  case UNSTABLE: return m->found ? (double)m->found->unstable : (double)NAN;
  case NEUTRAL: return m->found ? (double)m->found->neutral : (double)NAN;
  case ESCAPES: return m->found ? (double)m->found->escapes : (double)NAN;
  case ITERATIONS: return m->found ? (double)m->found->iterations : (double)NAN;
  case OMEGA:
    return m->modes && p->from < m->modes->count ? hb_mode_omega(&m->modes->mode[p->from]) : (double)NAN;
  case THRESHOLD: return m->threshold;
  default: break;
  }
  double result = p->reduce == CLI_LEAST_OF ? HUGE_VAL : p->reduce == CLI_MOST_OF ? -HUGE_VAL : 0;
  for (int k = p->from; k <= p->to; k++) {
    double value = entry(p, m, k);
    switch (p->reduce) {
    case CLI_ONE:
    case CLI_SUM: result += value; break;
    case CLI_LEAST_OF: result = fmin(result, value); break;
    case CLI_MOST_OF: result = fmax(result, value); break;
    case CLI_SIZE_OF: result += value * value; break;
    }
  }
  return p->reduce == CLI_SIZE_OF ? sqrt(result) : result;
}
