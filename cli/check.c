/* hebra check: reads a scene, says what it would do and cost; never runs. */
#include "cli/cli.h"

#include "base/memory.h"

#include <getopt.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

/* Cost of one vertex and step, seconds, on a usual core: measured orders of magnitude, not promises. */
#define EULER_SECONDS 65e-9
#define VERLET_SECONDS 90e-9
#define IMPLICIT_SECONDS 2e-6
#define GENERAL_SECONDS 400e-9
/* Most rods and notes that are told one by one. */
enum { TOLD_RODS = 20, TOLD_FIRST = 2, TOLD_NOTES = 20 };

/* Smallest and largest of something. */
typedef struct range {
  double lo, hi;
} range;

/* What check finds out about one rod. */
typedef struct rod_summary {
  double mass;
  range bending, twisting, stretching;
} rod_summary;

/* What check finds out about the whole. */
typedef struct summary {
  double steps, frames, bytes, seconds, stable_step;
  double length_mismatch; /* largest relative difference of an initial edge from its rest length */
  int stiffest;           /* rod that limits the step */
  rod_summary *rods;
} summary;

/* Widens a range. */
static void widen(range *r, double value) {
  r->lo = fmin(r->lo, value);
  r->hi = fmax(r->hi, value);
}

/* Larger principal value of the bending form of an edge. */
static double stiff_side(const double *B) { return 0.5 * (B[0] + B[2]) + hypot(0.5 * (B[0] - B[2]), B[1]); }

/* Smaller principal value. */
static double soft_side(const double *B) { return 0.5 * (B[0] + B[2]) - hypot(0.5 * (B[0] - B[2]), B[1]); }

/* Everything about one rod. */
static rod_summary summarise_rod(const hb_model *m, const hb_rod *rod) {
  rod_summary s = {.bending = {HUGE_VAL, -HUGE_VAL},
                   .twisting = {HUGE_VAL, -HUGE_VAL},
                   .stretching = {HUGE_VAL, -HUGE_VAL}};
  int last = rod->first + rod->nv - 1;
  for (int k = rod->first; k <= last; k++) s.mass += m->mass[k];
  for (int k = rod->first; k < last; k++) {
    widen(&s.bending, fmax(soft_side(&m->B[3 * k]), 0));
    widen(&s.bending, stiff_side(&m->B[3 * k]));
    widen(&s.stretching, m->stretching[k]);
  }
  for (int p = rod->first_span; p < rod->first_span + rod->span_count; p++) {
    const hb_span *span = &m->spans[p];
    for (int k = span->first_edge + 1; k <= span->last_edge; k++) {
      widen(&s.twisting, m->beta[k]);
    }
  }
  return s;
}

/* Largest relative difference of an initial edge from its rest length. */
static double length_mismatch(const hb_model *m, const hb_rod *rod) {
  double most = 0;
  for (int k = rod->first; !rod->extensible && k < rod->first + rod->nv - 1; k++) {
    const double *x = &m->initial[3 * k];
    double l = hypot(hypot(x[3] - x[0], x[4] - x[1]), x[5] - x[2]);
    most = fmax(most, fabs(l / m->rest_length[k] - 1));
  }
  return most;
}

/* Cost of one vertex and step of a rod. */
static double vertex_seconds(const hb_scene_def *def, const hb_rod *rod) {
  const char *integrator = def->method.integrator;
  if (hb_method_is_implicit(&def->method)) return rod->twist_free ? IMPLICIT_SECONDS : 2 * IMPLICIT_SECONDS;
  if (!rod->closed_form) return GENERAL_SECONDS;
  return integrator && strcmp(integrator, "symplectic-euler") == 0 ? EULER_SECONDS : VERLET_SECONDS;
}

/* Bytes of a frame per vertex, of the fields that a run writes. */
static double frame_bytes(const hb_output_def *output) {
  uint64_t fields = output->fields ? output->fields : hb_field_groups[1].fields;
  double numbers = 0;
  for (int k = 0; k < hb_frame_field_count; k++)
    if (fields >> k & 1) numbers += hb_frame_fields[k].components;
  return numbers * (output->single ? 4 : 8);
}

/* Everything about the scene; rods is to be freed by the caller. */
static hb_status summarise(const hb_model *m, summary *s, hb_error *err) {
  const hb_scene_def *def = m->def;
  *s = (summary){.rods = hb_alloc((size_t)m->rod_count, sizeof *s->rods)};
  if (!s->rods) return hb_fail_memory(err, "summary");
  s->steps = fmax(ceil(def->method.duration / def->method.time_step - 1e-9), 0);
  s->frames = 1 + ceil(s->steps / def->output.every);
  s->bytes = s->frames * frame_bytes(&def->output) * m->nv;
  for (int r = 0; r < m->rod_count; r++) {
    const hb_rod *rod = &m->rods[r];
    s->rods[r] = summarise_rod(m, rod);
    s->length_mismatch = fmax(s->length_mismatch, length_mismatch(m, rod));
    s->seconds += s->steps * rod->nv * vertex_seconds(def, rod);
  }
  s->stable_step = hb_model_stable_step(m, &s->stiffest);
  return HB_OK;
}

/* ---- for a person
 * ---------------------------------------------------------------------------------------------- */

/* "3.2 MB" and the like. */
static const char *in_bytes(double bytes, char buffer[32]) {
  static const char *const units[] = {"B", "kB", "MB", "GB", "TB"};
  int k = 0;
  for (; bytes >= 1000 && k < 4; k++) bytes /= 1000;
  snprintf(buffer, 32, "%.3g %s", bytes, units[k]);
  return buffer;
}

/* "0.42 s", "12 min". */
static const char *in_time(double seconds, char buffer[32]) {
  if (seconds < 120)
    snprintf(buffer, 32, "%.2g s", seconds);
  else if (seconds < 7200)
    snprintf(buffer, 32, "%.0f min", seconds / 60);
  else
    snprintf(buffer, 32, "%.1f h", seconds / 3600);
  return buffer;
}

/* One number, or lo .. hi. */
static const char *in_range(range r, char buffer[64]) {
  if (r.hi - r.lo <= 1e-12 * fabs(r.hi))
    snprintf(buffer, 64, "%g", r.hi);
  else
    snprintf(buffer, 64, "%g .. %g", r.lo, r.hi);
  return buffer;
}

/* What kind of rod it is, in words. */
static const char *kind_of(const hb_rod *rod) {
  if (!rod->closed_form) return "general: twist by Newton";
  return rod->twist_free ? "isotropic, straight at rest, carries no twist"
                         : "isotropic, straight at rest: twist in closed form";
}

/* "[a, b, c]" of a support's or load's formulas. */
static void print_formulas(hb_formula *const value[3], const bool *axis_free) {
  for (int c = 0; c < 3; c++) {
    const char *text = value[c] ? hb_formula_text(value[c]) : axis_free && axis_free[c] ? "free" : "fixed";
    printf("%s%s", c ? ", " : "[", text);
  }
  printf("]");
}

/* One support in words. */
static void print_support(const hb_support_def *s) {
  static const char *const what[] = {"position", "tangent", "material angle", "material frame"};
  printf("  support  %s %d: %s ", s->kind == HB_SUPPORT_POSITION ? "vertex" : "edge", s->index,
         what[s->kind]);
  bool formulas = s->value[0] || s->value[1] || s->value[2];
  bool some_free = s->axis_free[0] || s->axis_free[1] || s->axis_free[2];
  if (s->kind == HB_SUPPORT_ANGLE)
    printf("%s", s->angle ? hb_formula_text(s->angle) : "as at the start");
  else if (formulas || some_free)
    print_formulas(s->value, s->axis_free);
  else
    printf("fixed");
  if (s->wall) printf(", clamped where the rod %s", s->base_is_end ? "ends" : "begins");
  if (s->kind == HB_SUPPORT_DIRECTOR && s->angle) printf(", turned by %s", hb_formula_text(s->angle));
  printf("\n");
}

/* One load in words. */
static void print_force(const hb_model *m, const hb_force_def *f) {
  static const char *const what[] = {"gravity", "force", "force per length", "force on every vertex",
                                     "wind of velocity"};
  printf("force      %s ", what[f->kind]);
  print_formulas(f->value, NULL);
  if (f->kind == HB_FORCE_POINT) printf(" on vertex %d", f->vertex);
  if (f->rod >= 0) printf(" of rod %s", m->rods[f->rod].name);
  if (f->rods > 1) printf(" to %s", m->rods[f->rod + f->rods - 1].name);
  if (f->follower) printf(", turning with the material frame (t, m1, m2)");
  if (f->kind == HB_FORCE_WIND)
    printf(", resistance linear %g and %g, quadratic %g and %g (normal and tangential)", f->linear[0],
           f->linear[1], f->quadratic[0], f->quadratic[1]);
  if (f->per_radius[0] > 0 || f->per_radius[1] > 0)
    printf(" plus %g and %g times the radius", f->per_radius[0], f->per_radius[1]);
  printf("\n");
}

/* One rod in words. */
static void print_rod(const hb_model *m, const hb_rod *rod, const rod_summary *s) {
  const hb_rod_def *def = &m->def->rods[rod->index];
  char a[64], b[64];
  printf("rod        %s: %d vertices, length %g, mass %g\n", rod->name, rod->nv, rod->length, s->mass);
  printf("  kind     %s\n", kind_of(rod));
  static const char *const ways[] = {"", "turns beyond what makes the frame meet itself", "radians of twist",
                                     "linking number"};
  if (rod->closed)
    printf("  closed   %d edges, the last vertex is the first; %s: %.9g\n", rod->nv - 1, ways[def->closing],
           def->closing_value);
  printf("  moduli   bending %s, twisting %s", in_range(s->bending, a), in_range(s->twisting, b));
  if (rod->extensible) printf(", stretching %s", in_range(s->stretching, a));
  printf("%s\n", def->viscosity ? ", with bending viscosity" : "");
  for (int k = 0; k < def->support_count; k++) print_support(&def->supports[k]);
  if (def->support_count == 0) printf("  support  none: the rod is free\n");
}

/* All rods; of very many only the first ones, and the ranges of all. */
static void print_rods(const hb_model *m, const summary *s) {
  int told = m->rod_count <= TOLD_RODS ? m->rod_count : TOLD_FIRST, general = 0, supports = 0;
  range bending = s->rods[0].bending, twisting = s->rods[0].twisting, length = {HUGE_VAL, -HUGE_VAL};
  double mass = 0;
  char a[64], b[64], c[64];
  for (int r = 0; r < told; r++) print_rod(m, &m->rods[r], &s->rods[r]);
  if (told == m->rod_count) return;
  for (int r = 0; r < m->rod_count; r++) {
    bending = (range){fmin(bending.lo, s->rods[r].bending.lo), fmax(bending.hi, s->rods[r].bending.hi)};
    twisting = (range){fmin(twisting.lo, s->rods[r].twisting.lo), fmax(twisting.hi, s->rods[r].twisting.hi)};
    widen(&length, m->rods[r].length);
    mass += s->rods[r].mass;
    general += !m->rods[r].closed_form;
    supports += m->def->rods[r].support_count;
  }
  printf(
      "rods       %d in all, up to %s: %d vertices, length %s, mass %g together (--json lists every rod)\n",
      m->rod_count, m->rods[m->rod_count - 1].name, m->nv, in_range(length, c), mass);
  printf("  kind     %d isotropic and straight at rest, %d general\n", m->rod_count - general, general);
  printf("  moduli   bending %s, twisting %s\n", in_range(bending, a), in_range(twisting, b));
  printf("  support  %d prescribed vertices and frames\n", supports);
}

/* The step against its limit. */
static void print_step_limit(const hb_model *m, const summary *s) {
  double step = m->def->method.time_step;
  if (hb_method_is_implicit(&m->def->method)) {
    printf("stability  an implicit scheme: any step is stable, accuracy alone limits it\n");
    return;
  }
  if (!isfinite(s->stable_step)) {
    printf("stability  no estimate: no bending, damping, load or motion from which to take one\n");
    return;
  }
  printf("stability  an explicit scheme bears steps up to about %.3g (rod %s)\n", s->stable_step,
         m->rods[s->stiffest].name);
  if (step > s->stable_step)
    printf(
        "warning    the step %g is above that: the run fails or, worse, survives with a wrong answer; take "
        "at most %.2g, or fewer vertices\n",
        step, 0.8 * s->stable_step);
}

/* The whole answer. */
static void print_text(const hb_model *m, const summary *s) {
  const hb_scene_def *def = m->def;
  const hb_method_def *method = &def->method;
  char a[32], b[32];
  if (def->title) printf("title      %s\n", def->title);
  print_rods(m, s);
  for (int k = 0; k < def->force_count; k++) print_force(m, &def->forces[k]);
  printf("method     %s, step %g, duration %g: %.0f steps; lengths kept to %g %s%s\n",
         method->integrator ? method->integrator : "verlet", method->time_step, method->duration, s->steps,
         method->length_tolerance,
         method->length_tolerance_kind == HB_TOLERANCE_RELATIVE ? "relative" : "absolute",
         method->precision == HB_PRECISION_SINGLE ? "; single precision" : "");
  print_step_limit(m, s);
  printf("output     every %d steps: %.0f frames, about %s\n", def->output.every, s->frames,
         in_bytes(s->bytes, a));
  printf("run time   about %s on one core, in order of magnitude\n", in_time(s->seconds, b));
  if (s->length_mismatch > 1e-9)
    printf("note       edges of the initial shape differ from their rest lengths by up to %.3g %%; the run "
           "begins by moving the "
           "vertices to where the lengths are right\n",
           100 * s->length_mismatch);
  for (int k = 0; k < m->note_count && k < TOLD_NOTES; k++) printf("note       %s\n", m->notes[k]);
  if (m->note_count > TOLD_NOTES)
    printf("note       %d notes more (--json lists all)\n", m->note_count - TOLD_NOTES);
}

/* ---- for a program
 * --------------------------------------------------------------------------------------------- */

/* A JSON string. */
static void json_text(const char *text) {
  putchar('"');
  for (; text && *text; text++) {
    unsigned char c = (unsigned char)*text;
    if (c == '"' || c == '\\')
      printf("\\%c", c);
    else if (c < 32)
      printf("\\u%04x", c);
    else
      putchar(c);
  }
  putchar('"');
}

/* A JSON number; null where it is not finite. */
static void json_number(const char *key, double value, const char *after) {
  if (isfinite(value))
    printf("\"%s\": %.17g%s", key, value, after);
  else
    printf("\"%s\": null%s", key, after);
}

/* One rod as an object. */
static void json_rod(const hb_model *m, const hb_rod *rod, const rod_summary *s) {
  printf("    {\"name\": ");
  json_text(rod->name);
  printf(", \"vertices\": %d, ", rod->nv);
  json_number("length", rod->length, ", ");
  json_number("mass", s->mass, ", ");
  printf("\"kind\": \"%s\", \"twist_free\": %s, ", rod->closed_form ? "isotropic" : "general",
         rod->twist_free ? "true" : "false");
  json_number("bending_min", s->bending.lo, ", ");
  json_number("bending_max", s->bending.hi, ", ");
  json_number("twisting_min", s->twisting.lo, ", ");
  json_number("twisting_max", s->twisting.hi, ", ");
  if (rod->extensible) {
    json_number("stretching_min", s->stretching.lo, ", ");
    json_number("stretching_max", s->stretching.hi, ", ");
  }
  printf("\"supports\": %d}", m->def->rods[rod->index].support_count);
}

/* The whole answer. */
static void print_json(const hb_model *m, const summary *s) {
  const hb_method_def *method = &m->def->method;
  printf("{\n  \"title\": ");
  json_text(m->def->title ? m->def->title : "");
  printf(",\n  \"rods\": [\n");
  for (int r = 0; r < m->rod_count; r++) {
    json_rod(m, &m->rods[r], &s->rods[r]);
    printf("%s\n", r + 1 < m->rod_count ? "," : "");
  }
  printf("  ],\n  \"forces\": %d,\n  \"integrator\": ", m->def->force_count);
  json_text(method->integrator ? method->integrator : "verlet");
  printf(",\n  ");
  json_number("time_step", method->time_step, ", ");
  json_number("duration", method->duration, ", ");
  json_number("length_tolerance", method->length_tolerance, ", ");
  printf("\"precision\": \"%s\",\n  ", method->precision == HB_PRECISION_SINGLE ? "single" : "double");
  json_number("steps", s->steps, ", ");
  json_number("frames", s->frames, ", ");
  json_number("bytes", s->bytes, ", ");
  json_number("seconds", s->seconds, ",\n  ");
  json_number("stable_step", s->stable_step, ", ");
  printf("\"step_too_large\": %s,\n  ", method->time_step > s->stable_step ? "true" : "false");
  json_number("length_mismatch", s->length_mismatch, ",\n  ");
  printf("\"notes\": [");
  for (int k = 0; k < m->note_count; k++) {
    printf("%s", k ? ", " : "");
    json_text(m->notes[k]);
  }
  printf("]\n}\n");
}

/* ---- the verb
 * -------------------------------------------------------------------------------------------------- */

/* Reads, compiles, prints. */
static int check(const char *path, const char *const *overrides, int override_count, bool json) {
  hb_scene_def def;
  hb_model *model = NULL;
  summary s = {0};
  hb_error err = {.status = HB_OK};
  hb_status status = hb_scene_read(path, overrides, override_count, &def, &err);
  if (status) return cli_fail("check", &err);
  status = hb_model_create(&def, &model, &err);
  if (!status) status = summarise(model, &s, &err);
  if (!status && json) print_json(model, &s);
  if (!status && !json) print_text(model, &s);
  hb_free(s.rods);
  hb_model_free(model);
  hb_scene_def_free(&def);
  return status ? cli_fail("check", &err) : CLI_DONE;
}

/* hebra check SCENE [--set KEY=VALUE]... [--json] */
static int run(int argc, char **argv) {
  static const struct option options[] = {
      {"set", required_argument, NULL, 's'}, {"json", no_argument, NULL, 'j'}, {NULL, 0, NULL, 0}};
  const char **overrides = hb_alloc((size_t)argc, sizeof *overrides);
  int count = 0, option, status;
  bool json = false, bad = false;
  hb_error err = {.status = HB_OK};
  if (!overrides) {
    hb_fail_memory(&err, "arguments");
    return cli_fail("check", &err);
  }
  optind = 1;
  opterr = 0;
  while (!bad && (option = getopt_long(argc, argv, "s:j", options, NULL)) != -1) {
    if (option == 's')
      overrides[count++] = optarg;
    else if (option == 'j')
      json = true;
    else
      bad = true;
  }
  if (bad)
    status = cli_usage(&cli_verb_check, "\"%s\" is not understood or lacks its value", argv[optind - 1]);
  else if (optind + 1 != argc)
    status = cli_usage(&cli_verb_check, "%s",
                       optind == argc ? "the scene file is missing" : "one scene file at a time");
  else
    status = check(argv[optind], overrides, count, json);
  hb_free(overrides);
  return status;
}

const cli_verb cli_verb_check = {
    .name = "check",
    .summary = "read a scene, say what it would do and cost; never run",
    .help =
        "usage: hebra check SCENE [--set KEY=VALUE]... [--json]\n\n"
        "Reads SCENE, checks every rule, and says what `hebra run` would do: rods with their kind, moduli "
        "and supports,\n"
        "forces, steps, the largest step that the method bears, frames, size of the output, run time. "
        "Nothing is run and\n"
        "nothing is written. Exit status 2 and one sentence with the place if something is wrong.\n\n"
        "  --set KEY=VALUE   change or add a key of the scene; may be repeated. Rods are addressed by index "
        "(rods[0].bending),\n"
        "                    by name (rods.tree.bending) or all at once (rods.*.bending)\n"
        "  --json            the answer as one JSON object\n\n"
        "Example:\n"
        "  hebra check scenes/thesis-3-tree.yaml --set rods.tree.bending=50 --set method.time_step=5e-4\n",
    .run = run,
};
