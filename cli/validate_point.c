/* One point of a case: the scene with its settings, the deed, what is read, what is known. */
#include "base/clock.h"
#include "base/memory.h"
#include "cli/cli.h"
#include "cli/probe.h"
#include "cli/validate.h"
#include "scene/read.h"

#include <math.h>
#include <string.h>

enum { KEPT_VERTICES = 20000, SETTINGS = 3 * CLI_CASE_SETTINGS + 1 };

/* All that a point needs while it is computed. */
typedef struct work {
  const cli_case *c;
  cli_point *point;
  hb_error *err;
  char *settings[SETTINGS]; /* texts of --set */
  int setting_count;
  hb_scene_def def;
  hb_model *model;
  hb_sim *sim;
  hb_frame *frame;
  hb_equilibrium found;
  bool solved;
  double threshold;
  hb_modes modes;
  bool listed; /* modes were found */
  cli_probe probes[CLI_CASE_READS];
  double *times, *series[CLI_CASE_READS]; /* of a run */
  long samples;
  double values[CLI_CASE_READS];
  hb_parameter *names;   /* parameters of the scene, then what is read */
  hb_scene_def formulas; /* only its parameters are used */
  hb_scene_reader reader;
} work;

/* "key=value" of a setting; a bare name is a parameter of the scene. */
static hb_status add_setting(work *w, const char *key, const char *value) {
  const char *prefix = strpbrk(key, ".[") ? "" : "parameters.";
  size_t room = strlen(prefix) + strlen(key) + strlen(value) + 2;
  char *text = hb_alloc(room, 1);
  if (!text) return hb_fail_memory(w->err, "settings of a scene");
  snprintf(text, room, "%s%s=%s", prefix, key, value);
  w->settings[w->setting_count++] = text;
  return HB_OK;
}

/* All settings of the point. */
static hb_status add_settings(work *w) {
  const cli_case *c = w->c;
  hb_status status = HB_OK;
  for (int k = 0; !status && c->set && k < c->set->count; k++)
    status = add_setting(w, c->set->children[k]->key, c->set->children[k]->text);
  for (int k = 0; !status && c->vary && k < c->vary->count; k++)
    status =
        add_setting(w, c->vary->children[k]->key, c->vary->children[k]->children[w->point->variant]->text);
  for (int k = 0; !status && c->meshes && k < c->meshes->count; k++)
    status =
        add_setting(w, c->meshes->children[k]->key, c->meshes->children[k]->children[w->point->mesh]->text);
  return status;
}

/* Closes what open_scene made. */
static void close_scene(work *w) {
  hb_modes_free(&w->modes);
  w->modes = (hb_modes){.count = 0};
  hb_equilibrium_free(&w->found);
  w->found = (hb_equilibrium){.unstable = 0};
  hb_frame_free(w->frame);
  hb_sim_free(w->sim);
  hb_model_free(w->model);
  hb_scene_def_free(&w->def);
  hb_scene_def_init(&w->def);
  w->frame = NULL;
  w->sim = NULL;
  w->model = NULL;
}

/* The scene with the settings, ready to be computed by this thread alone. */
static hb_status open_scene(work *w) {
  hb_status status =
      hb_scene_read(w->c->scene, (const char *const *)w->settings, w->setting_count, &w->def, w->err);
  w->def.method.threads = 1;
  w->def.method.lanes = cli_lanes();
  if (!status) status = hb_model_create(&w->def, &w->model, w->err);
  if (!status) status = hb_sim_create(w->model, &w->sim, w->err);
  if (!status) status = hb_frame_create(w->model, &w->frame, w->err);
  return status;
}

/* A number among the options of the deed; *out stays where it is not given. */
static hb_status option(work *w, const char *key, hb_scene_rule rule, double *out) {
  return hb_scene_number(&w->reader, hb_node_find(w->c->options, key), rule, out);
}

/* How the equilibrium is looked for. */
static hb_status solve_options(work *w, hb_equilibrium_options *how) {
  double time = w->def.method.duration;
  hb_status status = option(w, "time", HB_RULE_NOT_NEGATIVE, &time);
  *how = hb_equilibrium_defaults(time);
  if (!status) status = option(w, "tolerance", HB_RULE_POSITIVE, &how->tolerance);
  if (!status)
    status =
        hb_scene_whole(&w->reader, hb_node_find(w->c->options, "load_steps"), 1, 1000000, &how->load_steps);
  if (!status) status = hb_scene_flag(&w->reader, hb_node_find(w->c->options, "any"), &how->any);
  return status;
}

/* The moment as it is now. */
static cli_moment moment(const work *w) {
  return (cli_moment){.model = w->model,
                      .frame = w->frame,
                      .force = w->sim ? hb_sim_const_state(w->sim)->force : NULL,
                      .found = w->solved ? &w->found : NULL,
                      .threshold = w->threshold,
                      .modes = w->listed ? &w->modes : NULL};
}

/* All quantities, for the model at hand. */
static hb_status parse_probes(work *w) {
  hb_status status = HB_OK;
  for (int k = 0; !status && k < w->c->read_count; k++) {
    hb_error inner = {HB_OK, ""};
    cli_moment now = moment(w);
    status = cli_probe_parse(w->c->reads[k].node->text, &now, &w->probes[k], &inner);
    if (status) status = hb_scene_pass(&w->reader, w->c->reads[k].node, &inner);
  }
  return status;
}

/* Nothing is done: the initial state. */
static hb_status do_start(work *w) {
  hb_sim_measure(w->sim, w->frame);
  return HB_OK;
}

/* The equilibrium. */
static hb_status do_solve(work *w) {
  hb_equilibrium_options how;
  hb_status status = solve_options(w, &how);
  if (!status) status = hb_sim_find_equilibrium(w->sim, &how, &w->found, w->err);
  w->solved = !status;
  if (!status) hb_sim_measure_equilibrium(w->sim, &w->found, w->frame);
  return status;
}

/* One sample of all quantities. */
static void sample(work *w) {
  hb_sim_measure(w->sim, w->frame);
  cli_moment now = moment(w);
  w->times[w->samples] = w->frame->time;
  for (int k = 0; k < w->c->read_count; k++) w->series[k][w->samples] = cli_probe_read(&w->probes[k], &now);
  w->samples++;
}

/* The whole run, sampled every so many steps and at the end. */
static hb_status do_run(work *w) {
  int every = w->def.output.every;
  long total = hb_sim_total_steps(w->sim);
  hb_status status = hb_scene_whole(&w->reader, hb_node_find(w->c->options, "every"), 1, 1000000000, &every);
  if (status) return status;
  size_t room = (size_t)(total / every) + 2;
  w->times = hb_alloc(room, sizeof(double));
  bool enough = w->times != NULL;
  for (int k = 0; k < w->c->read_count; k++) {
    w->series[k] = hb_alloc(room, sizeof(double));
    enough = enough && w->series[k];
  }
  if (!enough) return hb_fail_memory(w->err, "samples of a run");
  sample(w);
  while (!status && hb_sim_steps(w->sim) < total) {
    long left = total - hb_sim_steps(w->sim);
    status = hb_sim_advance(w->sim, left < every ? left : every, w->err);
    if (!status) sample(w);
  }
  return status;
}

/* Unstable modes of the equilibrium next to the start, with the setting at a value. */
static hb_status modes_at(work *w, const char *key, double value, int *out) {
  char text[40];
  hb_equilibrium_options how;
  close_scene(w);
  snprintf(text, sizeof text, "%.17g", value);
  hb_status status = add_setting(w, key, text);
  if (!status) status = open_scene(w);
  hb_free(w->settings[--w->setting_count]);
  w->settings[w->setting_count] = NULL;
  if (!status) status = solve_options(w, &how);
  how.any = true;
  if (!status) status = hb_sim_find_equilibrium(w->sim, &how, &w->found, w->err);
  w->solved = !status;
  *out = w->found.unstable;
  return status;
}

/* Halving between two values until the number of unstable modes is known to change within the resolution. */
static hb_status do_threshold(work *w) {
  const hb_node *of = hb_node_find(w->c->options, "of");
  double from = 0, to = 0, resolution = 1e-9;
  int at_from, at_to, at_middle;
  hb_status status = option(w, "from", HB_RULE_ANY, &from);
  if (!status) status = option(w, "to", HB_RULE_ANY, &to);
  if (!status) status = option(w, "resolution", HB_RULE_POSITIVE, &resolution);
  if (!status) status = modes_at(w, of->text, from, &at_from);
  if (!status) status = modes_at(w, of->text, to, &at_to);
  if (status) return status;
  if (at_from >= at_to)
    return hb_fail(w->err, HB_ERR_NUMERIC,
                   "no threshold between %s = %g with %d unstable modes and %g with %d", of->text, from,
                   at_from, to, at_to);
  while (!status && fabs(to - from) > resolution * (fabs(to) + fabs(from))) {
    double middle = 0.5 * (from + to);
    status = modes_at(w, of->text, middle, &at_middle);
    *(at_middle > at_from ? &to : &from) = middle;
  }
  w->threshold = 0.5 * (from + to);
  if (!status) hb_sim_measure_equilibrium(w->sim, &w->found, w->frame);
  return status;
}

/* Points of the first branch, until another one crosses it; the rods are measured there. */
static hb_status take_point(void *context, const hb_trace_point *point, hb_error *err) {
  work *w = context;
  if (point->branch > 0 || point->kind != HB_TRACE_BIFURCATION) return HB_OK;
  w->threshold = point->parameter;
  hb_sim_measure_equilibrium(point->sim, &point->found, w->frame);
  return hb_fail(err, HB_ERR_INTERRUPTED, "found"); /* nothing else is asked for */
}

/* Why the first branch ended without a crossing. */
static hb_status take_end(void *context, const hb_trace_end *end, hb_error *err) {
  const work *w = context;
  return hb_fail(err, HB_ERR_NUMERIC, "no other branch crosses that which begins at %s = %s: %s",
                 hb_node_find(w->c->options, "of")->text, hb_node_find(w->c->options, "from")->text,
                 end->reason);
}

/* The first crossing on the branch of equilibria from a value of a parameter on. */
static hb_status do_trace(work *w) {
  const char *of = hb_node_find(w->c->options, "of")->text;
  double from = 0, to = 0, time = w->def.method.duration;
  hb_trace_costs costs;
  hb_status status = option(w, "from", HB_RULE_ANY, &from);
  if (!status) status = option(w, "to", HB_RULE_ANY, &to);
  if (!status) status = option(w, "time", HB_RULE_NOT_NEGATIVE, &time);
  hb_trace_options how = hb_trace_defaults(from, to);
  if (!status) status = option(w, "step", HB_RULE_POSITIVE, &how.step);
  if (!status) status = hb_scene_flag(&w->reader, hb_node_find(w->c->options, "any"), &how.any);
  if (status) return status;
  how.max_branches = 1;
  hb_scene_range range = {&w->def, of, time};
  hb_trace_family family = hb_scene_family(&range);
  hb_trace_sink sink = {take_point, take_end, w};
  status = hb_trace(&family, &how, &sink, &costs, w->err);
  return status == HB_ERR_INTERRUPTED ? HB_OK : status;
}

/* The lowest modes about the equilibrium. */
static hb_status do_modes(work *w) {
  int count = 6;
  hb_status status = do_solve(w);
  if (!status) status = hb_scene_whole(&w->reader, hb_node_find(w->c->options, "count"), 1, 1000, &count);
  if (!status) status = hb_sim_find_modes(w->sim, &w->found, count, &w->modes, w->err);
  w->listed = !status;
  return status;
}

/* The deeds, in the order of cli_deed. */
static hb_status (*const deeds[])(work *w) = {do_start,     do_start, do_solve, do_run,
                                              do_threshold, do_trace, do_modes};

/* Number of one quantity after the deed. */
static hb_status reduce(work *w, int k) {
  const cli_read *read = &w->c->reads[k];
  cli_series s = {w->times, w->series[k], w->samples};
  cli_moment now = moment(w);
  double value = 0, *out = &w->values[k];
  bool given = read->value != NULL;
  hb_status status = hb_scene_number(&w->reader, read->value, HB_RULE_ANY, &value);
  if (status) return status;
  switch (read->over) {
  case CLI_AT: *out = cli_series_at(&s, value); break;
  case CLI_MOST:
  case CLI_LEAST:
    *out = s.values[0];
    for (long i = 1; i < s.count; i++)
      *out = read->over == CLI_MOST ? fmax(*out, s.values[i]) : fmin(*out, s.values[i]);
    break;
  case CLI_DRIFT: *out = cli_series_drift(&s); break;
  case CLI_PERIOD: *out = cli_series_period(&s, value); break;
  case CLI_FREQUENCY: *out = cli_series_frequency(&s, given ? value : (double)NAN); break;
  case CLI_REACHES: *out = cli_series_reaches(&s, value); break;
  default: *out = cli_probe_read(&w->probes[k], &now); break;
  }
  if (isfinite(*out)) return HB_OK;
  return hb_scene_fail(&w->reader, read->node, "\"%s\" has no value there (%s)", read->node->text,
                       cli_over_words[read->over]);
}

/* A number; only looked at, not worked out, where the names have no values yet. */
static hb_status number(work *w, const hb_node *node, hb_scene_rule rule, bool rehearse, double *out) {
  if (!rehearse) return hb_scene_number(&w->reader, node, rule, out);
  hb_formula *formula = NULL;
  hb_status status = hb_scene_formula(&w->reader, node, HB_VARS_NONE, &formula);
  hb_formula_free(formula);
  return status;
}

/* The node of the known value for this point. */
static const hb_node *known(const cli_case *c, const cli_expect *e, int variant, int mesh) {
  const hb_node *is = e->is;
  if (is->kind == HB_NODE_SCALAR) return is;
  is = is->children[c->vary ? variant : mesh];
  return is->kind == HB_NODE_SCALAR ? is : is->children[mesh];
}

/* Names that formulas may use: parameters of the scene, then what was read. */
static hb_status name_all(work *w) {
  int own = w->def.parameter_count;
  hb_free(w->names);
  w->names = hb_alloc((size_t)(own + w->c->read_count) + HB_SCENE_COPY_NAMES, sizeof *w->names);
  if (!w->names) return hb_fail_memory(w->err, "names of a case");
  memcpy(w->names, w->def.parameters, (size_t)own * sizeof *w->names);
  w->formulas.parameters = w->names;
  w->formulas.parameter_count = own;
  return HB_OK;
}

/* Reads all quantities; from then on formulas know them. */
static hb_status read_all(work *w, bool rehearse) {
  hb_status status = HB_OK;
  for (int k = 0; !status && k < w->c->read_count; k++) {
    const cli_read *read = &w->c->reads[k];
    const hb_node *named = strcmp(read->node->key, read->name) == 0 ? read->node : read->node->parent;
    for (int i = 0; i < w->def.parameter_count; i++)
      if (strcmp(w->def.parameters[i].name, read->name) == 0)
        return hb_scene_fail_key(&w->reader, named,
                                 "the scene has a parameter of that name; another name is expected");
    status = rehearse ? number(w, read->value, HB_RULE_ANY, true, NULL) : reduce(w, k);
    w->names[w->formulas.parameter_count++] = (hb_parameter){(char *)(uintptr_t)read->name, w->values[k]};
  }
  return status;
}

/* Found and expected numbers, or whether their formulas can be read. */
static hb_status judge_all(work *w, bool rehearse) {
  const cli_case *c = w->c;
  cli_point *p = w->point;
  hb_status status = number(w, c->size, HB_RULE_POSITIVE, rehearse, &p->size);
  for (int k = 0; !status && k < c->expect_count; k++) {
    const cli_expect *e = &c->expects[k];
    status = number(w, e->find, HB_RULE_ANY, rehearse, &p->found[k]);
    if (!status && !e->same)
      status = number(w, known(c, e, p->variant, p->mesh), HB_RULE_ANY, rehearse, &p->expected[k]);
  }
  return status;
}

/* Where the rods are, for the plot. */
static hb_status keep_shape(work *w) {
  const hb_model *m = w->model;
  if (m->nv > KEPT_VERTICES) return HB_OK;
  w->point->shape = hb_alloc(3 * (size_t)m->nv, sizeof(double));
  w->point->rods = hb_alloc((size_t)m->rod_count + 1, sizeof(int));
  if (!w->point->shape || !w->point->rods) return hb_fail_memory(w->err, "shape for a plot");
  memcpy(w->point->shape, w->frame->position, 3 * (size_t)m->nv * sizeof(double));
  for (int r = 0; r < m->rod_count; r++) w->point->rods[r] = m->rods[r].nv;
  return HB_OK;
}

/* Ready to open the scene. */
static void begin(work *w, const cli_case *c, cli_point *point) {
  *w = (work){.c = c, .point = point, .err = &point->err, .threshold = (double)NAN};
  hb_scene_def_init(&w->def);
  hb_scene_def_init(&w->formulas);
  w->reader = (hb_scene_reader){
      .name = c->path, .limits = hb_scene_default_limits(), .def = &w->formulas, .err = &point->err};
}

/* Everything but the point. */
static void end(work *w) {
  close_scene(w);
  for (int k = 0; k < w->setting_count; k++) hb_free(w->settings[k]);
  for (int k = 0; k < CLI_CASE_READS; k++) hb_free(w->series[k]);
  hb_free(w->times);
  hb_free(w->names);
}

/* The point. */
void cli_point_compute(cli_point *point, bool keep) {
  work w;
  const cli_case *c = point->of;
  double started = hb_clock_now();
  begin(&w, c, point);
  hb_status status = add_settings(&w);
  if (!status) status = open_scene(&w);
  if (!status) status = name_all(&w);
  if (!status) status = parse_probes(&w);
  if (!status) status = deeds[c->deed](&w);
  if (!status && c->deed == CLI_THRESHOLD) status = name_all(&w); /* of the scene that is open now */
  if (!status) status = read_all(&w, false);
  if (!status) status = judge_all(&w, false);
  if (!status && keep) status = keep_shape(&w);
  point->err.status = status;
  end(&w);
  point->seconds = hb_clock_now() - started;
}

/* Are bare names of settings parameters of the scene as it is written? */
static hb_status check_settings(work *w, const hb_node *settings) {
  for (int k = 0; settings && k < settings->count; k++) {
    const hb_node *child = settings->children[k];
    bool known_name = strpbrk(child->key, ".[") != NULL;
    for (int i = 0; !known_name && i < w->def.parameter_count; i++)
      known_name = strcmp(w->def.parameters[i].name, child->key) == 0;
    if (!known_name)
      return hb_scene_fail_key(
          &w->reader, child,
          "%s has no parameter of that name; other settings are written with their path, such "
          "as method.time_step",
          w->c->scene);
  }
  return HB_OK;
}

/* Is everything there that a threshold or a branch needs? */
static hb_status check_threshold(work *w) {
  static const char *const keys[] = {"of", "from", "to"};
  if (w->c->deed != CLI_THRESHOLD && w->c->deed != CLI_TRACE) return HB_OK;
  for (int k = 0; k < 3; k++) {
    const hb_node *node;
    hb_status status = hb_scene_need(&w->reader, w->c->options, keys[k],
                                     k ? "a number or formula" : "the name of a setting", &node);
    if (status) return status;
    if (node->kind != HB_NODE_SCALAR || !node->text[0])
      return hb_scene_expected(&w->reader, node, k ? "a number or formula" : "the name of a setting");
  }
  return HB_OK;
}

/* The scene as it is written, then that of the first point; formulas with made-up numbers. */
hb_status cli_case_rehearse(const cli_case *c, hb_error *err) {
  if (c->deed == CLI_NOT_YET) return HB_OK;
  cli_point point = {.of = c};
  work w;
  begin(&w, c, &point);
  hb_status status = hb_scene_read(c->scene, NULL, 0, &w.def, w.err);
  if (!status) status = check_settings(&w, c->set);
  if (!status) status = check_settings(&w, c->vary);
  if (!status) status = check_settings(&w, c->meshes);
  if (!status) status = check_threshold(&w);
  close_scene(&w);
  if (!status) status = add_settings(&w);
  if (!status)
    status = hb_scene_read(c->scene, (const char *const *)w.settings, w.setting_count, &w.def, w.err);
  if (!status) status = hb_model_create(&w.def, &w.model, w.err);
  if (!status) status = name_all(&w);
  if (!status) status = parse_probes(&w);
  if (!status) status = read_all(&w, true);
  if (!status) status = judge_all(&w, true);
  end(&w);
  if (status) *err = point.err;
  return status;
}

/* What the point owns. */
void cli_point_free(cli_point *point) {
  hb_free(point->shape);
  hb_free(point->rods);
}
