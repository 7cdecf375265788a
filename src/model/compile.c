/* Definitions to constant tables. */
#include "model/compile.h"

#include "base/memory.h"

#include <limits.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

/* Sentence with the place in the scene file in front, where it is known. */
hb_status hb_compile_fail(const hb_scene_def *def, int line, int column, hb_error *err, const char *format,
                          ...) {
  char text[768];
  va_list args;
  va_start(args, format);
  vsnprintf(text, sizeof text, format, args);
  va_end(args);
  if (line > 0)
    return hb_fail(err, HB_ERR_INPUT, "%s:%d:%d: %s", def->path ? def->path : "scene", line, column, text);
  return hb_fail(err, HB_ERR_INPUT, "%s", text);
}

/* One more note. */
hb_status hb_compile_note(hb_model *model, hb_error *err, const char *format, ...) {
  char text[512];
  va_list args;
  va_start(args, format);
  vsnprintf(text, sizeof text, format, args);
  va_end(args);
  char **notes = hb_realloc(model->notes, (size_t)model->note_count + 1, sizeof *notes);
  if (!notes) return hb_fail_memory(err, "notes on the scene");
  model->notes = notes;
  notes[model->note_count] = hb_strdup(text);
  if (!notes[model->note_count]) return hb_fail_memory(err, "notes on the scene");
  model->note_count++;
  return HB_OK;
}

/* The tables with so many doubles per slot. */
static hb_status allocate_tables(hb_model *m, hb_error *err) {
  struct {
    double **table;
    int components;
  } tables[] = {{&m->rest_length, 1}, {&m->inv_rest_length, 1}, {&m->arc, 1},
                {&m->voronoi, 1},     {&m->weight, 1},          {&m->mass, 1},
                {&m->inv_mass, 3},    {&m->alpha, 1},           {&m->bend_gain, 1},
                {&m->B, 3},           {&m->viscosity, 1},       {&m->stretching, 1},
                {&m->beta, 1},        {&m->twist_gain, 1},      {&m->rest_twist, 1},
                {&m->rest_omega, 4},  {&m->rest_pull, 4},       {&m->initial, 3}};
  for (size_t k = 0; k < sizeof tables / sizeof tables[0]; k++) {
    *tables[k].table = hb_alloc((size_t)m->nv * (size_t)tables[k].components, sizeof(double));
    if (!*tables[k].table) return hb_fail_memory(err, "tables of the model");
  }
  m->rod_of = hb_alloc((size_t)m->nv, sizeof *m->rod_of);
  m->frame_of = hb_alloc((size_t)m->nv, sizeof *m->frame_of);
  m->start_m1 = hb_alloc(3 * (size_t)m->rod_count, sizeof *m->start_m1);
  if (!m->rod_of || !m->frame_of || !m->start_m1) return hb_fail_memory(err, "tables of the model");
  return HB_OK;
}

/* Rods one behind the other. */
static hb_status number_slots(hb_model *m, hb_error *err) {
  const hb_scene_def *def = m->def;
  m->rods = hb_alloc((size_t)def->rod_count, sizeof *m->rods);
  if (!m->rods) return hb_fail_memory(err, "rods");
  m->rod_count = def->rod_count;
  long long slots = 0;
  for (int r = 0; r < def->rod_count; r++) {
    m->rods[r] = (hb_rod){.name = def->rods[r].name ? def->rods[r].name : "rod",
                          .index = r,
                          .first = (int)slots,
                          .nv = def->rods[r].nv,
                          .extensible = def->rods[r].stretching != NULL,
                          .closed = def->rods[r].closing != HB_CLOSING_NONE};
    m->rods[r].last_joint = m->rods[r].nv - (m->rods[r].closed ? 1 : 2);
    slots += def->rods[r].nv;
    if (slots > 100000000)
      return hb_fail(err, HB_ERR_INPUT, "%lld vertices are too many; at most 100 million are possible",
                     slots);
  }
  m->nv = (int)slots;
  return HB_OK;
}

/* Does any load turn with a material frame? */
static bool has_follower(const hb_scene_def *def) {
  for (int k = 0; k < def->force_count; k++)
    if (def->forces[k].follower) return true;
  return false;
}

/* An absolute tolerance asks most of the longest edge; in single precision it must be possible there too. */
static hb_status check_absolute(const hb_model *m, hb_error *err) {
  const hb_method_def *method = &m->def->method;
  int longest = 0;
  if (method->precision != HB_PRECISION_SINGLE || method->length_tolerance_kind != HB_TOLERANCE_ABSOLUTE)
    return HB_OK;
  for (int k = 1; k < m->nv; k++)
    if (m->rest_length[k] > m->rest_length[longest]) longest = k;
  double least = hb_compile_least_tolerance(method) * m->rest_length[longest];
  if (method->length_tolerance >= least) return HB_OK;
  return hb_compile_fail(m->def, method->line, method->column, err,
                         "method.length_tolerance: %g is below what single precision can hold on the longest "
                         "edge (%g, rod %s); at least %g is needed, or precision: double",
                         method->length_tolerance, m->rest_length[longest], m->rods[m->rod_of[longest]].name,
                         least);
}

/* Which of the scene's forces act on which rod. */
static hb_status list_forces(hb_model *m, hb_error *err) {
  const hb_scene_def *def = m->def;
  size_t count = 0;
  for (int pass = 0; pass < 2; pass++) {
    for (int r = 0; r < m->rod_count; r++) m->rods[r].force_count = 0;
    for (int k = 0; k < def->force_count; k++) {
      const hb_force_def *force = &def->forces[k];
      int first = force->rod < 0 ? 0 : force->rod, many = force->rods > 1 ? force->rods : 1;
      int end = force->rod < 0 ? m->rod_count : first + many;
      for (int r = first; r < end && r < m->rod_count; r++) {
        hb_rod *rod = &m->rods[r];
        if (pass) m->rod_forces[rod->first_force + rod->force_count] = k;
        rod->force_count++;
      }
    }
    for (int r = 0; pass == 0 && r < m->rod_count; r++) {
      m->rods[r].first_force = (int)count;
      count += (size_t)m->rods[r].force_count;
    }
    if (count > INT_MAX) return hb_fail(err, HB_ERR_INPUT, "%zu loads on rods are too many", count);
    if (pass == 0) m->rod_forces = hb_alloc(count, sizeof *m->rod_forces);
    if (!m->rod_forces) return hb_fail_memory(err, "loads");
  }
  return HB_OK;
}

/* All stages in order. */
static hb_status compile(hb_model *m, hb_error *err) {
  const hb_scene_def *def = m->def;
  hb_status status = hb_compile_check_scene(def, err);
  for (int r = 0; !status && r < def->rod_count; r++) status = hb_compile_check_rod(def, r, err);
  if (!status) status = number_slots(m, err);
  if (!status) status = allocate_tables(m, err);
  for (int r = 0; !status && r < m->rod_count; r++) {
    hb_rod *rod = &m->rods[r];
    for (int i = 0; i < rod->nv; i++) m->rod_of[rod->first + i] = r;
    memcpy(&m->initial[3 * rod->first], def->rods[r].initial, 3 * (size_t)rod->nv * sizeof(double));
    hb_compile_rest(m, r);
    m->any_general = m->any_general || !rod->closed_form;
    m->any_viscosity = m->any_viscosity || def->rods[r].viscosity != NULL;
  }
  m->any_follower = has_follower(def);
  if (!status) status = check_absolute(m, err);
  if (!status) status = list_forces(m, err);
  if (!status) status = hb_compile_supports(m, err);
  return status;
}

/* Checks and compiles. */
hb_status hb_model_create(const hb_scene_def *def, hb_model **out, hb_error *err) {
  *out = NULL;
  hb_model *m = hb_alloc(1, sizeof *m);
  if (!m) return hb_fail_memory(err, "model");
  m->def = def;
  hb_status status = compile(m, err);
  if (status) {
    hb_model_free(m);
    return status;
  }
  *out = m;
  return HB_OK;
}

/* Frees every table. */
void hb_model_free(hb_model *m) {
  if (!m) return;
  for (int k = 0; k < m->note_count; k++) hb_free(m->notes[k]);
  void *tables[] = {m->notes,   m->rods,       m->rod_of,     m->rest_length, m->inv_rest_length,
                    m->arc,     m->voronoi,    m->weight,     m->mass,        m->inv_mass,
                    m->alpha,   m->bend_gain,  m->B,          m->viscosity,   m->stretching,
                    m->beta,    m->twist_gain, m->rest_twist, m->rest_omega,  m->rest_pull,
                    m->spans,   m->panels,     m->positions,  m->frames,      m->frame_of,
                    m->initial, m->start_m1,   m->rod_forces};
  for (size_t k = 0; k < sizeof tables / sizeof tables[0]; k++) hb_free(tables[k]);
  hb_free(m);
}
