/* The section `trace`: which parameter a branch of equilibria is followed over. And the scene again, with
 * another value of that parameter. */
#include "scene/read.h"

#include "base/memory.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* parameter: the name of a parameter of the scene, or t */
static hb_status read_parameter(hb_scene_reader *r, const hb_node *node, char **out) {
  char list[400] = "t";
  hb_status status = hb_scene_text(r, node, out);
  if (status) return status;
  if (strcmp(*out, "t") == 0) return HB_OK;
  for (int k = 0; k < r->def->parameter_count; k++) {
    const char *name = r->def->parameters[k].name;
    if (strcmp(*out, name) == 0) return HB_OK;
    size_t used = strlen(list);
    if (used + strlen(name) + 3 < sizeof list) snprintf(list + used, sizeof list - used, ", %s", name);
  }
  return hb_scene_fail(r, node, "\"%s\" is not a parameter of the scene; allowed are %s", *out, list);
}

/* trace: {parameter, from, to, step, points, branches} */
hb_status hb_scene_read_trace(hb_scene_reader *r, const hb_node *node) {
  static const char *const keys[] = {"parameter", "from", "to", "step", "points", "branches", NULL};
  hb_trace_def *trace = &r->def->trace;
  const hb_node *parameter, *from, *to;
  if (!node) return HB_OK;
  hb_scene_place(node, &trace->line, &trace->column);
  hb_status status = hb_scene_check_keys(r, node, keys);
  if (!status) status = hb_scene_need(r, node, "parameter", "the name of a parameter, or t", &parameter);
  if (!status) status = read_parameter(r, parameter, &trace->parameter);
  if (!status) status = hb_scene_need(r, node, "from", "a number or formula", &from);
  if (!status) status = hb_scene_number(r, from, HB_RULE_ANY, &trace->from);
  if (!status) status = hb_scene_need(r, node, "to", "a number or formula", &to);
  if (!status) status = hb_scene_number(r, to, HB_RULE_ANY, &trace->to);
  if (status) return status;
  if (trace->from == trace->to)
    return hb_scene_fail(r, to, "%.9g is where the branch starts; another number is expected", trace->to);
  bool time = strcmp(trace->parameter, "t") == 0;
  if (time && (trace->from < 0 || trace->to < 0))
    return hb_scene_fail(r, trace->from < 0 ? from : to, "%.9g is not allowed; times are numbers >= 0",
                         trace->from < 0 ? trace->from : trace->to);
  const hb_node *step = hb_node_find(node, "step");
  status = hb_scene_number(r, step, HB_RULE_POSITIVE, &trace->step);
  if (!status && trace->step > 1)
    return hb_scene_fail(r, step, "%.9g is not allowed; a number above 0, at most 1, is expected",
                         trace->step);
  if (!status) status = hb_scene_whole(r, hb_node_find(node, "points"), 2, 1000000, &trace->points);
  if (!status) status = hb_scene_whole(r, hb_node_find(node, "branches"), 1, 1000, &trace->branches);
  return status;
}

/* From the text that the scene was read from. */
hb_status hb_scene_vary(const hb_scene_def *def, const char *parameter, double value, hb_scene_def *out,
                        hb_error *err) {
  char override[128];
  const char *overrides[] = {override}, *name = def->path ? def->path : "scene",
             *slash = def->path ? strrchr(def->path, '/') : NULL;
  hb_scene_def_init(out);
  if (!def->source)
    return hb_fail(err, HB_ERR_INPUT,
                   "the scene was not read from a text, so no parameter of it can be changed");
  char *base_dir =
      slash ? hb_strndup(def->path, slash == def->path ? 1 : (size_t)(slash - def->path)) : hb_strdup(".");
  if (!base_dir) return hb_fail_memory(err, "path");
  bool time = strcmp(parameter, "t") == 0;
  snprintf(override, sizeof override, "parameters.%.60s=%.17g", parameter, value);
  hb_status status =
      hb_scene_parse(def->source, strlen(def->source), name, base_dir, overrides, time ? 0 : 1, out, err);
  hb_free(base_dir);
  if (status) return status;
  out->method.lanes = HB_LANES_OFF;
  out->path = hb_strdup(name);
  if (out->path) return HB_OK;
  hb_scene_def_free(out);
  return hb_fail_memory(err, "path");
}

/* One scene of a family with the definition that it needs. */
static hb_status at(void *context, double value, const hb_model **model, double *time, hb_error *err) {
  const hb_scene_range *range = context;
  hb_scene_def *def = hb_alloc(1, sizeof *def);
  hb_model *compiled = NULL;
  if (!def) return hb_fail_memory(err, "scene");
  hb_status status = hb_scene_vary(range->def, range->parameter, value, def, err);
  if (!status) {
    status = hb_model_create(def, &compiled, err);
    if (status) hb_scene_def_free(def);
  }
  if (status) hb_free(def);
  *model = compiled;
  *time = strcmp(range->parameter, "t") == 0 ? fmax(value, 0) : range->time;
  return status;
}

/* And back. */
static void drop(void *context, const hb_model *model) {
  (void)context;
  hb_model *mine = (hb_model *)(uintptr_t)model; /* made by `at` */
  hb_scene_def *def = (hb_scene_def *)(uintptr_t)model->def;
  hb_model_free(mine);
  hb_scene_def_free(def);
  hb_free(def);
}

/* What a trace asks for scenes. */
hb_trace_family hb_scene_family(hb_scene_range *range) { return (hb_trace_family){at, drop, range}; }
