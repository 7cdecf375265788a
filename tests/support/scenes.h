/* Scenes built in C for tests of the dynamics, and a run of one: definition, model, simulation, frame.
 *
 * A rod that was added stays where it is only until the next one is added: finish one rod before the next. */
#ifndef HB_TEST_SCENES_H
#define HB_TEST_SCENES_H

#include "support/near.h"

#include "base/memory.h"
#include "hebra/curve.h"
#include "hebra/sim.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- definitions ------------------------------------------------------------------------------------------
 */

/* Empty scene with integrator and time step; never ends by itself. */
static inline void scene_begin(hb_scene_def *def, const char *integrator, double time_step) {
  hb_scene_def_init(def);
  def->method.integrator = hb_strdup(integrator);
  def->method.time_step = time_step;
  def->method.duration = 1e9 * time_step;
}

/* Copy of count doubles, owned by the definition. */
static inline double *scene_copy(const double *values, size_t count) {
  double *copy = hb_alloc(count, sizeof *copy);
  assert_non_null(copy);
  memcpy(copy, values, count * sizeof *copy);
  return copy;
}

/* count equal doubles. */
static inline double *scene_fill(double value, size_t count) {
  double *array = hb_alloc(count, sizeof *array);
  assert_non_null(array);
  for (size_t k = 0; k < count; k++) array[k] = value;
  return array;
}

/* A rod of nv vertices with the rest shape xyz, which is the initial shape too; isotropic bending alpha,
 * twisting beta, the same mass on every vertex. */
static inline hb_rod_def *scene_rod(hb_scene_def *def, int nv, const double *xyz, double alpha, double beta,
                                    double mass) {
  hb_rod_def *rods = hb_realloc(def->rods, (size_t)def->rod_count + 1, sizeof *rods);
  assert_non_null(rods);
  def->rods = rods;
  hb_rod_def *rod = &rods[def->rod_count++];
  size_t n = (size_t)nv;
  hb_rod_def_init(rod);
  rod->nv = nv;
  rod->name = hb_strdup("rod");
  rod->rest = scene_copy(xyz, 3 * n);
  rod->initial = scene_copy(xyz, 3 * n);
  rod->mass = scene_fill(mass, n);
  rod->beta = scene_fill(beta, n);
  rod->B = scene_fill(0, 3 * (n - 1));
  for (int j = 0; j + 1 < nv; j++) rod->B[3 * j] = rod->B[3 * j + 2] = alpha;
  return rod;
}

/* Bending form ((b11, b12), (b12, b22)) on every edge. */
static inline void scene_form(hb_rod_def *rod, double b11, double b12, double b22) {
  for (int j = 0; j + 1 < rod->nv; j++) {
    rod->B[3 * j] = b11;
    rod->B[3 * j + 1] = b12;
    rod->B[3 * j + 2] = b22;
  }
}

/* Another initial shape than the rest shape. */
static inline void scene_initial(hb_rod_def *rod, const double *xyz) {
  memcpy(rod->initial, xyz, 3 * (size_t)rod->nv * sizeof *xyz);
}

/* Initial velocities. */
static inline void scene_velocity(hb_rod_def *rod, const double *v) {
  rod->velocity = scene_copy(v, 3 * (size_t)rod->nv);
}

/* Takes the general path (Newton for the twist) even if the rod is isotropic and straight: a viscosity of
 * zero. */
static inline void scene_make_general(hb_rod_def *rod) {
  rod->viscosity = scene_fill(0, (size_t)rod->nv - 1);
}

/* Bending-rate viscosity on every edge. */
static inline void scene_viscosity(hb_rod_def *rod, double viscosity) {
  rod->viscosity = scene_fill(viscosity, (size_t)rod->nv - 1);
}

/* Formula of time, place and arc length; NULL gives NULL. */
static inline hb_formula *scene_formula(const char *text) {
  hb_formula *formula = NULL;
  hb_error err = {HB_OK, ""};
  if (!text) return NULL;
  if (hb_formula_parse(text, HB_VARS_ALL, NULL, 0, &formula, &err)) fail_msg("%s", err.text);
  return formula;
}

/* One more support. */
static inline hb_support_def *scene_support(hb_rod_def *rod, hb_support_kind kind, int index) {
  hb_support_def *supports = hb_realloc(rod->supports, (size_t)rod->support_count + 1, sizeof *supports);
  assert_non_null(supports);
  rod->supports = supports;
  hb_support_def *s = &supports[rod->support_count++];
  hb_support_def_init(s);
  s->kind = kind;
  s->index = index;
  return s;
}

/* Vertex held where it is. */
static inline void scene_hold(hb_rod_def *rod, int vertex) {
  scene_support(rod, HB_SUPPORT_POSITION, vertex)->held = true;
}

/* Vertex on formulas of t; "free" leaves a coordinate free, NULL holds it. */
static inline void scene_path(hb_rod_def *rod, int vertex, const char *x, const char *y, const char *z) {
  hb_support_def *s = scene_support(rod, HB_SUPPORT_POSITION, vertex);
  const char *text[3] = {x, y, z};
  s->held = true;
  for (int c = 0; c < 3; c++) {
    s->axis_free[c] = text[c] && text[c][0] == 'f';
    if (!s->axis_free[c]) s->value[c] = scene_formula(text[c]);
  }
}

/* Material angle of an edge, formula of t; NULL: held as the relaxed start has it. */
static inline void scene_angle(hb_rod_def *rod, int edge, const char *angle) {
  hb_support_def *s = scene_support(rod, HB_SUPPORT_ANGLE, edge);
  s->held = !angle;
  s->angle = scene_formula(angle);
}

/* Director of an edge in space, formulas of t, and an extra turn (may be NULL). */
static inline void scene_director(hb_rod_def *rod, int edge, const char *x, const char *y, const char *z,
                                  const char *turn) {
  hb_support_def *s = scene_support(rod, HB_SUPPORT_DIRECTOR, edge);
  const char *text[3] = {x, y, z};
  for (int c = 0; c < 3; c++) s->value[c] = scene_formula(text[c]);
  s->angle = scene_formula(turn);
}

/* Tangent of an edge along formulas of t; x NULL: held. from_end: the far vertex is the base. */
static inline void scene_tangent(hb_rod_def *rod, int edge, const char *x, const char *y, const char *z,
                                 bool from_end) {
  hb_support_def *s = scene_support(rod, HB_SUPPORT_TANGENT, edge);
  const char *text[3] = {x, y, z};
  s->held = !x;
  s->base_is_end = from_end;
  for (int c = 0; c < 3; c++) s->value[c] = scene_formula(text[c]);
}

/* Clamps the first edge: both vertices and the frame, as they are. */
static inline void scene_clamp_start(hb_rod_def *rod) {
  scene_hold(rod, 0);
  scene_hold(rod, 1);
  scene_angle(rod, 0, "0");
}

/* A load on every rod. */
static inline hb_force_def *scene_force(hb_scene_def *def, hb_force_kind kind, const char *x, const char *y,
                                        const char *z) {
  hb_force_def *forces = hb_realloc(def->forces, (size_t)def->force_count + 1, sizeof *forces);
  assert_non_null(forces);
  def->forces = forces;
  hb_force_def *f = &forces[def->force_count++];
  const char *text[3] = {x, y, z};
  hb_force_def_init(f);
  f->kind = kind;
  for (int c = 0; c < 3; c++) f->value[c] = scene_formula(text[c]);
  return f;
}

/* ---- shapes -----------------------------------------------------------------------------------------------
 */

/* Straight from the origin to (x, y, z). */
static inline void shape_line(int nv, double x, double y, double z, double *xyz) {
  for (int i = 0; i < nv; i++) {
    double s = (double)i / (nv - 1);
    xyz[3 * i] = s * x;
    xyz[3 * i + 1] = s * y;
    xyz[3 * i + 2] = s * z;
  }
}

/* Equal edges of the given length from the origin, near +x, whose direction at arc fraction s is tilted by
 * a sin(pi s) + b s towards y and by c sin(2 pi s) + d s towards z. */
static inline void shape_bent(int nv, double edge, const double tilt[4], double *xyz) {
  xyz[0] = xyz[1] = xyz[2] = 0;
  for (int j = 0; j + 1 < nv; j++) {
    double s = (j + 0.5) / (nv - 1), pi = 3.14159265358979323846;
    double u = tilt[0] * sin(pi * s) + tilt[1] * s, w = tilt[2] * sin(2 * pi * s) + tilt[3] * s;
    double t[3] = {cos(u) * cos(w), sin(u) * cos(w), sin(w)};
    for (int c = 0; c < 3; c++) xyz[3 * j + 3 + c] = xyz[3 * j + c] + edge * t[c];
  }
}

/* ---- a run ------------------------------------------------------------------------------------------------
 */

typedef struct trial {
  hb_scene_def def;
  hb_model *model;
  hb_sim *sim;
  hb_frame *frame;
} trial;

/* Model, simulation and frame of t->def, which must be complete. Ends the test with the sentence if that
 * fails. */
static inline void trial_start(trial *t) {
  hb_error err = {HB_OK, ""};
  if (hb_model_create(&t->def, &t->model, &err)) fail_msg("model: %s", err.text);
  if (hb_sim_create(t->model, &t->sim, &err)) fail_msg("simulation: %s", err.text);
  if (hb_frame_create(t->model, &t->frame, &err)) fail_msg("frame: %s", err.text);
}

/* Takes steps; ends the test with the sentence if one fails. */
static inline void trial_run(trial *t, long steps) {
  hb_error err = {HB_OK, ""};
  for (long k = 0; k < steps; k++)
    if (hb_sim_step(t->sim, &err)) fail_msg("%s", err.text);
}

/* Measures now. */
static inline const hb_frame *trial_measure(trial *t) {
  hb_sim_measure(t->sim, t->frame);
  return t->frame;
}

/* Frees everything of the run, the definition too. */
static inline void trial_end(trial *t) {
  hb_frame_free(t->frame);
  hb_sim_free(t->sim);
  hb_model_free(t->model);
  hb_scene_def_free(&t->def);
}

/* Fills in everything of a scene but integrator and time step. */
typedef void (*scene_builder)(hb_scene_def *def);

/* A run of a built scene. */
static inline void trial_build(trial *t, scene_builder build, const char *integrator, double time_step) {
  scene_begin(&t->def, integrator, time_step);
  build(&t->def);
  trial_start(t);
}

/* Largest |a[k] - b[k]|. */
static inline double largest_difference(const double *a, const double *b, size_t count) {
  double largest = 0;
  for (size_t k = 0; k < count; k++) {
    double d = fabs(a[k] - b[k]);
    if (!(d <= largest)) largest = d;
  }
  return largest;
}

/* Long runs are this many times shorter where sanitizers slow every step down; release builds do them in
 * full. */
#if defined(__SANITIZE_ADDRESS__)
#define SHORTER 10
#elif defined(__has_feature)
#if __has_feature(address_sanitizer)
#define SHORTER 10
#endif
#endif
#ifndef SHORTER
#define SHORTER 1
#endif

/* Tests that say what they measured print it only when HEBRA_TEST_VERBOSE is set. */
#define say(...)                                                                                             \
  do {                                                                                                       \
    if (getenv("HEBRA_TEST_VERBOSE")) printf(__VA_ARGS__);                                                   \
  } while (0)

#endif
