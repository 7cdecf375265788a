#include "support/rods.h"

#include "base/memory.h"
#include "math/rotation.h"
#include "support/near.h"

#include <stdio.h>
#include <string.h>

/* Ends the test with the library's sentence. */
static void must(hb_status status, const hb_error *err) {
  if (!status) return;
  print_error("%s\n", err->text);
  fail();
}

/* Zeroed doubles. */
double *rod_array(int count) {
  double *a = hb_alloc((size_t)count, sizeof *a);
  assert_non_null(a);
  return a;
}

/* Same form on every edge. */
void rod_set_bending(hb_rod_def *def, double b11, double b12, double b22) {
  for (int j = 0; j + 1 < def->nv; j++) {
    def->B[3 * j] = b11;
    def->B[3 * j + 1] = b12;
    def->B[3 * j + 2] = b22;
  }
}

/* Plain straight rod. */
void rod_case_straight(rod_case *c, int nv, double h, double alpha, double beta) {
  memset(c, 0, sizeof *c);
  hb_scene_def_init(&c->def);
  c->def.rods = hb_alloc(1, sizeof *c->def.rods);
  assert_non_null(c->def.rods);
  c->def.rod_count = 1;
  hb_rod_def *def = &c->def.rods[0];
  hb_rod_def_init(def);
  def->name = hb_strdup("test");
  def->nv = nv;
  def->rest = rod_array(3 * nv);
  def->initial = rod_array(3 * nv);
  def->mass = rod_array(nv);
  def->B = rod_array(3 * (nv - 1));
  def->beta = rod_array(nv);
  def->first_director[1] = 1;
  for (int i = 0; i < nv; i++) {
    def->rest[3 * i] = def->initial[3 * i] = h * i;
    def->mass[i] = 1;
    def->beta[i] = beta;
  }
  rod_set_bending(def, alpha, 0, alpha);
}

/* Frees what was made so far. */
void rod_case_free(rod_case *c) {
  if (c->work_made) hb_rod_work_free(&c->work);
  hb_state_free(c->state);
  hb_model_free(c->model);
  hb_scene_def_free(&c->def);
  memset(c, 0, sizeof *c);
}

/* One more entry in the list. */
hb_support_def *rod_add_support(hb_rod_def *def, hb_support_kind kind, int index) {
  def->supports = hb_realloc(def->supports, (size_t)def->support_count + 1, sizeof *def->supports);
  assert_non_null(def->supports);
  hb_support_def *s = &def->supports[def->support_count++];
  hb_support_def_init(s);
  s->kind = kind;
  s->index = index;
  return s;
}

/* An angle as a formula of t. */
void rod_hold_angle(hb_rod_def *def, int edge, const char *angle) {
  hb_error err;
  hb_support_def *s = rod_add_support(def, HB_SUPPORT_ANGLE, edge);
  must(hb_formula_parse(angle, HB_VARS_TIME, NULL, 0, &s->angle, &err), &err);
}

/* A constant director and an extra angle. */
void rod_hold_director(hb_rod_def *def, int edge, const double director[3], double angle) {
  hb_error err;
  hb_support_def *s = rod_add_support(def, HB_SUPPORT_DIRECTOR, edge);
  for (int k = 0; k < 3; k++) must(hb_formula_constant(director[k], &s->value[k], &err), &err);
  must(hb_formula_constant(angle, &s->angle, &err), &err);
}

/* A vertex held where it is. */
void rod_hold_vertex(hb_rod_def *def, int vertex) {
  rod_add_support(def, HB_SUPPORT_POSITION, vertex)->held = true;
}

/* Tangents from two smooth angles, turned at random; then edge after edge. */
void rod_random_shape(rng *r, int nv, const double *lengths, double bend, double *x) {
  double rotation[9], wave[2][3][3];
  rod_random_rotation(r, rotation);
  for (int a = 0; a < 2; a++)
    for (int k = 0; k < 3; k++) {
      wave[a][k][0] = rng_uniform(r, -1, 1);
      wave[a][k][1] = rng_uniform(r, 0.2, 1.2);
      wave[a][k][2] = rng_uniform(r, -HB_PI, HB_PI);
    }
  for (int k = 0; k < 3; k++) x[k] = rng_uniform(r, -1, 1);
  for (int j = 0; j + 1 < nv; j++) {
    double angle[2] = {0, 0};
    for (int a = 0; a < 2; a++)
      for (int k = 0; k < 3; k++)
        angle[a] += bend * wave[a][k][0] * sin(wave[a][k][1] * j + wave[a][k][2]) / wave[a][k][1];
    double b = 1.2 * tanh(angle[1]);
    double t[3] = {cos(angle[0]) * cos(b), sin(angle[0]) * cos(b), sin(b)}, turned[3];
    rod_move(rotation, NULL, t, 1, turned);
    for (int k = 0; k < 3; k++) x[3 * j + 3 + k] = x[3 * j + k] + lengths[j] * turned[k];
  }
}

/* From a random unit quaternion. */
void rod_random_rotation(rng *r, double rotation[9]) {
  double q[4], n = 0;
  for (int k = 0; k < 4; k++) q[k] = rng_normal(r);
  for (int k = 0; k < 4; k++) n += q[k] * q[k];
  hb_quat quat = {q[0] / sqrt(n), {q[1] / sqrt(n), q[2] / sqrt(n), q[3] / sqrt(n)}};
  for (int c = 0; c < 3; c++) {
    hb_v3 column = hb_quat_rotate(quat, (hb_v3){c == 0, c == 1, c == 2});
    rotation[c] = column.x;
    rotation[3 + c] = column.y;
    rotation[6 + c] = column.z;
  }
}

/* Rotation and shift, one vector after the other. */
void rod_move(const double rotation[9], const double *shift, const double *a, int count, double *out) {
  for (int i = 0; i < count; i++) {
    double p[3] = {a[3 * i], a[3 * i + 1], a[3 * i + 2]};
    for (int k = 0; k < 3; k++)
      out[3 * i + k] = rotation[3 * k] * p[0] + rotation[3 * k + 1] * p[1] + rotation[3 * k + 2] * p[2] +
                       (shift ? shift[k] : 0);
  }
}

/* Not-a-number counts as largest. */
double rod_largest(const double *a, int count) {
  double most = 0;
  for (int k = 0; k < count; k++)
    if (!(fabs(a[k]) <= most)) most = fabs(a[k]);
  return most;
}

/* Not-a-number counts as largest. */
double rod_difference(const double *a, const double *b, int count) {
  double most = 0;
  for (int k = 0; k < count; k++)
    if (!(fabs(a[k] - b[k]) <= most)) most = fabs(a[k] - b[k]);
  return most;
}

/* Stiffnesses of a family: sizes between 0.02 and 0.5, forms turned off their axes. */
static void random_stiffness(hb_rod_def *def, rng *r, rod_family family) {
  bool varying = family == ROD_VARYING;
  bool isotropic = family == ROD_ISOTROPIC || (family != ROD_ANISOTROPIC && rng_int(r, 0, 2) == 0);
  double a = rng_uniform(r, 0.05, 0.5), b = isotropic ? a : rng_uniform(r, 0.02, 0.5),
         axis = rng_uniform(r, 0, HB_PI);
  double beta = rng_uniform(r, 0.02, 0.3), phase = rng_uniform(r, 0, 6);
  for (int j = 0; j + 1 < def->nv; j++) {
    double swell = varying ? 1 + 0.6 * sin(phase + 0.7 * j) : 1, turn = varying ? axis + 0.3 * j : axis;
    double p = swell * a, q = isotropic ? p : b * (varying ? 1 + 0.5 * cos(phase - 0.4 * j) : 1);
    double s = sin(turn), co = cos(turn);
    def->B[3 * j] = isotropic ? p : p * co * co + q * s * s;
    def->B[3 * j + 1] = isotropic ? 0 : (p - q) * co * s;
    def->B[3 * j + 2] = isotropic ? p : p * s * s + q * co * co;
  }
  for (int i = 0; i < def->nv; i++) def->beta[i] = beta * (varying ? 1 + 0.5 * sin(2 * phase + 0.9 * i) : 1);
}

/* A curved rest shape with its own directors, or with natural twist about its Bishop frame. */
static void random_rest(hb_rod_def *def, rng *r, const double *lengths) {
  int nv = def->nv;
  rod_random_shape(r, nv, lengths, 0.35, def->rest);
  if (rng_int(r, 0, 1)) {
    double d[3], turn[3];
    def->rest_m1 = rod_array(3 * (nv - 1));
    rng_direction(r, d);
    rng_direction(r, turn);
    for (int j = 0; j + 1 < nv; j++)
      for (int k = 0; k < 3; k++) def->rest_m1[3 * j + k] = d[k] + 0.15 * j * turn[k];
  } else {
    def->natural_twist = rod_array(nv);
    for (int i = 0; i < nv; i++) def->natural_twist[i] = rng_uniform(r, -2, 2);
  }
}

/* Prescribes edge j: an angle of up to so many turns, or a director in space with the same. */
static void random_hold(hb_rod_def *def, rng *r, int j, double turns) {
  char text[64];
  double angle = 2 * HB_PI * rng_uniform(r, -turns, turns), d[3];
  rng_direction(r, d);
  snprintf(text, sizeof text, "%.17g", angle);
  if (rng_int(r, 0, 1))
    rod_hold_angle(def, j, text);
  else
    rod_hold_director(def, j, d, angle);
}

/* The frames of a kind of ends. */
static void random_ends(hb_rod_def *def, rng *r, rod_ends ends, double turns) {
  int last = def->nv - 2;
  int inner = ends == ROD_CLAMPED_INNER ? rng_int(r, 1, last - 1) : -1, which = rng_int(r, 0, 2);
  bool first_held = ends == ROD_CLAMPED_FREE || ends == ROD_CLAMPED_CLAMPED || (inner > 0 && which != 1);
  bool last_held = ends == ROD_CLAMPED_CLAMPED || (inner > 0 && which != 0);
  if (last_held) random_hold(def, r, -1, turns);
  if (inner > 0) random_hold(def, r, inner, turns);
  if (first_held) random_hold(def, r, 0, 0.5);
}

/* Rest lengths even or not, rest shape straight or curved, smooth initial shape of the same lengths. */
void rod_case_random(rod_case *c, rng *r, rod_family family, rod_ends ends, double turns) {
  int nv = rng_int(r, 5, 14);
  double h = rng_uniform(r, 0.05, 0.2), uneven = rng_int(r, 0, 1) ? 0.3 : 0;
  rod_case_straight(c, nv, h, 1, 1);
  hb_rod_def *def = &c->def.rods[0];
  double *lengths = rod_array(nv);
  for (int j = 0; j + 1 < nv; j++) {
    lengths[j] = h * (1 + uneven * sin(1.3 * j + h));
    for (int k = 0; k < 3; k++) def->rest[3 * j + 3 + k] = def->rest[3 * j + k] + (k == 0 ? lengths[j] : 0);
  }
  rng_direction(r, def->first_director);
  random_stiffness(def, r, family);
  if (family == ROD_CURVED || (family == ROD_VARYING && rng_int(r, 0, 1))) random_rest(def, r, lengths);
  rod_random_shape(r, nv, lengths, 0.5, def->initial);
  random_ends(def, r, ends, turns);
  hb_free(lengths);
}

/* The edges become springs. */
void rod_make_extensible(rod_case *c, rng *r) {
  hb_rod_def *def = &c->def.rods[0];
  double scale = pow(10, rng_uniform(r, -1, 3));
  def->stretching = rod_array(def->nv);
  for (int j = 0; j + 1 < def->nv; j++) def->stretching[j] = scale * rng_uniform(r, 0.5, 2);
}

/* Model, state and workspace. */
void rod_case_compile(rod_case *c) {
  hb_error err;
  must(hb_model_create(&c->def, &c->model, &err), &err);
  c->rod = &c->model->rods[0];
  must(hb_state_create(c->model, &c->state, &err), &err);
  must(hb_rod_work_create(c->model, &c->work, &err), &err);
  c->work_made = true;
}

/* As at the start of a run, but whatever the lengths are. */
void rod_case_start(rod_case *c, const double *x) {
  hb_error err;
  memcpy(c->state->x, x ? x : c->model->initial, 3 * (size_t)c->rod->nv * sizeof(double));
  assert_true(hb_rod_geometry(c->rod, c->state->x, &c->work));
  hb_frames_start(c->model, c->rod, c->state, &c->work);
  if (!c->rod->closed_form) {
    if (c->rod->frame_count == 0) hb_twist_scan(c->model, c->rod, c->state, &c->work);
    must(hb_twist_relax(c->model, c->rod, c->state, &c->work, &err), &err);
  }
  rod_case_evaluate(c, NULL, 0);
}

/* As a step does it. */
void rod_case_evaluate(rod_case *c, const double *x, double t) {
  hb_error err;
  if (x) memcpy(c->state->x, x, 3 * (size_t)c->rod->nv * sizeof(double));
  must(hb_rod_settle(c->model, c->rod, c->state, &c->work, t, 0, &err), &err);
  hb_rod_force(c->model, c->rod, c->state, &c->work);
}

/* From the state, or made for closed forms. */
void rod_case_directors(rod_case *c, double *m1) {
  if (c->rod->closed_form) hb_frames_closed(c->model, c->rod, c->state, &c->work);
  memcpy(m1, c->rod->closed_form ? c->work.m1 : c->state->m1, 3 * (size_t)(c->rod->nv - 1) * sizeof(double));
}

/* The first from its director, the others by adding up twists. */
void rod_case_angles(rod_case *c, double *theta) {
  double m1[3 * 4096];
  assert_true(c->rod->nv <= 4096);
  rod_case_directors(c, m1);
  theta[0] = hb_angle_about(hb_v3_load(c->state->anchor_m1), hb_v3_load(m1), hb_v3_load(c->work.tangent));
  int span = 0;
  for (int i = 1; i + 1 < c->rod->nv; i++) {
    while (i > c->model->spans[span].last_edge) span++;
    double gain = c->model->twist_gain[i];
    double closed = c->model->rest_twist[i] + (gain > 0 ? c->state->moment[span] / gain : 0);
    theta[i] = theta[i - 1] + (c->rod->closed_form ? closed : c->state->twist[i]);
  }
}

/* As the state has it. */
const double *rod_case_force(const rod_case *c) { return c->state->force; }
