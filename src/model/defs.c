/* Definitions: defaults and freeing. */
#include "hebra/model.h"

#include "base/memory.h"

#include <string.h>

/* Defaults of a support: everything held where its kind says so, nothing prescribed. */
void hb_support_def_init(hb_support_def *def) {
  memset(def, 0, sizeof *def);
  def->kind = HB_SUPPORT_POSITION;
}

/* Defaults of a rod: no vertices yet, straight or not as its rest shape is. */
void hb_rod_def_init(hb_rod_def *def) {
  memset(def, 0, sizeof *def);
  def->radius = 0.01;
}

/* Defaults of a load: on every rod. */
void hb_force_def_init(hb_force_def *def) {
  memset(def, 0, sizeof *def);
  def->rod = -1;
}

/* Defaults of a scene. */
void hb_scene_def_init(hb_scene_def *def) {
  memset(def, 0, sizeof *def);
  def->method.time_step = 1e-3;
  def->method.duration = 1;
  def->method.length_tolerance = 1e-10;
  def->method.max_projections = 100;
  def->method.max_twist_iterations = 100;
  def->output.every = 10;
  def->output.checkpoint_seconds = 2;
  def->trace.step = 0.02;
  def->trace.points = 1000;
  def->trace.branches = 5;
}

/* By their names; the list of schemes (src/sim/builtin.c) says the same. */
bool hb_method_is_implicit(const hb_method_def *method) {
  const char *name = method->integrator;
  return name && (strcmp(name, "implicit") == 0 || strcmp(name, "backward-euler") == 0);
}

/* Frees one support's formulas. */
static void free_support(hb_support_def *def) {
  for (int c = 0; c < 3; c++) hb_formula_free(def->value[c]);
  hb_formula_free(def->angle);
}

/* Frees one rod's arrays. */
static void free_rod(hb_rod_def *def) {
  for (int k = 0; k < def->support_count; k++) free_support(&def->supports[k]);
  hb_free(def->supports);
  hb_free(def->name);
  hb_free(def->rest);
  hb_free(def->rest_m1);
  hb_free(def->natural_twist);
  hb_free(def->initial);
  hb_free(def->velocity);
  hb_free(def->mass);
  hb_free(def->B);
  hb_free(def->beta);
  hb_free(def->stretching);
  hb_free(def->viscosity);
}

/* Frees everything inside a scene and leaves it empty. */
void hb_scene_def_free(hb_scene_def *def) {
  if (!def) return;
  for (int k = 0; k < def->rod_count; k++) free_rod(&def->rods[k]);
  for (int k = 0; k < def->force_count; k++)
    for (int c = 0; c < 3; c++) hb_formula_free(def->forces[k].value[c]);
  for (int k = 0; k < def->parameter_count; k++) hb_free(def->parameters[k].name);
  hb_free(def->rods);
  hb_free(def->forces);
  hb_free(def->parameters);
  hb_free(def->trace.parameter);
  hb_free(def->title);
  hb_free(def->description);
  hb_free(def->path);
  hb_free(def->source);
  hb_free(def->method.integrator);
  hb_scene_def_init(def);
}
