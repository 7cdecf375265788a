/* What the scene reader makes of a sound scene: defaults, shapes, moduli, directors, supports, loads,
 * overrides. */
#include "hebra/curve.h"
#include "hebra/scene.h"
#include "math/rotation.h"
#include "support/near.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define METHOD "method: {time_step: 1e-3, duration: 1}\n"
#define LINE "{line: {to: [0, 0, 1], vertices: 5}}"
#define STIFF "bending: 1, twisting: 1, vertex_mass: 1"

/* Reads text with overrides; it must be sound. */
static void read_set(const char *text, const char *const *overrides, int count, hb_scene_def *def) {
  hb_error err = {.status = HB_OK};
  if (hb_scene_parse(text, strlen(text), "t.yaml", ".", overrides, count, def, &err))
    fail_msg("%s", err.text);
}

/* Reads text; it must be sound. */
static void read_text(const char *text, hb_scene_def *def) { read_set(text, NULL, 0, def); }

/* Reads a scene of one rod with these keys. */
static void read_rod(const char *keys, hb_scene_def *def) {
  char text[2000];
  snprintf(text, sizeof text, METHOD "rods: [{%s}]\n", keys);
  read_text(text, def);
  assert_int_equal(def->rod_count, 1);
}

/* What a short scene leaves out. */
static void defaults(void **state) {
  (void)state;
  static const char text[] = "# short\n" METHOD "rods:\n  - {rest: " LINE ", " STIFF "}\n";
  hb_scene_def def;
  read_text(text, &def);
  const hb_rod_def *rod = &def.rods[0];
  assert_null(def.title);
  assert_string_equal(def.source, text);
  assert_string_equal(def.method.integrator, "verlet");
  assert_same(def.method.time_step, 1e-3);
  assert_same(def.method.length_tolerance, 1e-10);
  assert_int_equal(def.method.length_tolerance_kind, HB_TOLERANCE_RELATIVE);
  assert_int_equal(def.method.line, 2);
  assert_string_equal(rod->name, "rod0");
  assert_int_equal(rod->nv, 5);
  assert_int_equal(rod->line, 4);
  assert_int_equal(rod->column, 5);
  assert_near_array(rod->initial, rod->rest, 15, 0);
  assert_near(rod->radius, 0.01, 1e-15);
  assert_null(rod->velocity);
  assert_null(rod->rest_m1);
  assert_null(rod->natural_twist);
  assert_null(rod->viscosity);
  assert_false(rod->straight_rest || rod->lengths_from_initial);
  assert_int_equal(rod->support_count + def.force_count, 0);
  for (int j = 0; j < 4; j++) {
    assert_same(rod->B[3 * j], 1);
    assert_same(rod->B[3 * j + 1], 0);
    assert_same(rod->B[3 * j + 2], 1);
  }
  hb_scene_def_free(&def);
}

/* Words and numbers of the head. */
static void head(void **state) {
  (void)state;
  hb_scene_def def;
  read_text("title: 'a: b'\ndescription: |\n  two\n  lines\nparameters: {h: 1e-4, n: 3, T: h*10^n}\n"
            "method: {integrator: symplectic-euler, time_step: h/2, duration: T, length_tolerance: "
            "{absolute: 1e-2},\n"
            "  max_projections: 7, max_twist_iterations: n}\n"
            "rods: [{rest: " LINE ", " STIFF "}]\noutput: {every: n^2, checkpoint: 0}\n",
            &def);
  assert_string_equal(def.title, "a: b");
  assert_string_equal(def.description, "two\nlines\n");
  assert_int_equal(def.parameter_count, 3);
  assert_near_rel(def.parameters[2].value, 0.1, 1e-15);
  assert_string_equal(def.method.integrator, "symplectic-euler");
  assert_same(def.method.time_step, 0.5e-4);
  assert_near_rel(def.method.duration, 0.1, 1e-15);
  assert_same(def.method.length_tolerance, 1e-2);
  assert_int_equal(def.method.length_tolerance_kind, HB_TOLERANCE_ABSOLUTE);
  assert_int_equal(def.method.max_projections, 7);
  assert_int_equal(def.method.max_twist_iterations, 3);
  assert_int_equal(def.output.every, 9);
  assert_same(def.output.checkpoint_seconds, 0);
  hb_scene_def_free(&def);
}

/* Each generator gives the curve of the library function, and the changes act in their fixed order. */
static void shapes(void **state) {
  (void)state;
  static const double zero[3] = {0, 0, 0}, z[3] = {0, 0, 1}, x[3] = {1, 0, 0}, y[3] = {0, 1, 0},
                      c[3] = {1, 2, 3};
  double e[21];
  hb_scene_def def;
  read_rod("rest: {arc: {center: [1, 2, 3], normal: [1, 0, 0], start: [0, 1, 0], radius: 2, angle: pi/2, "
           "vertices: 7}}, " STIFF,
           &def);
  assert_int_equal(hb_curve_arc(c, x, y, 2, HB_PI / 2, 7, e, NULL), HB_OK);
  assert_near_array(def.rods[0].rest, e, 21, 0);
  hb_scene_def_free(&def);
  read_rod("rest: {ring: {radius: 2, vertices: 7}}, " STIFF, &def);
  assert_int_equal(hb_curve_arc(zero, z, x, 2, 2 * HB_PI, 7, e, NULL), HB_OK);
  assert_near_array(def.rods[0].rest, e, 21, 0);
  hb_scene_def_free(&def);
  read_rod("rest: {helix: {radius: 2, pitch: 0.5, turns: -1.5, vertices: 7}}, " STIFF, &def);
  assert_int_equal(hb_curve_helix(zero, z, x, 2, 0.5, -1.5, 7, e, NULL), HB_OK);
  assert_near_array(def.rods[0].rest, e, 21, 0);
  hb_scene_def_free(&def);
  read_rod(
      "rest: {knot: {center: [1, 2, 3], major: 2, minor: 0.5, start: 0.1, part: 0.9, vertices: 7}}, " STIFF,
      &def);
  assert_int_equal(hb_curve_torus_knot(c, 2, 0.5, 2, 3, 0.1, 0.9, 7, e, NULL), HB_OK);
  assert_near_array(def.rods[0].rest, e, 21, 0);
  hb_scene_def_free(&def);
  read_rod("rest: {formula: {x: s^2, y: 0, z: 2*s, from: -1, to: 1, vertices: 5}, scale: [1, 1, 0.5], "
           "rotate: {axis: [0, 0, 2], "
           "angle: pi/2, about: [1, 0, 0]}, move: [0, 0, 1], displace: [0, 0, i], perturb: [{vertex: -1, by: "
           "[5, 0, 0]}]}, " STIFF,
           &def);
  for (int i = 0; i < 5; i++) { /* (s^2, 0, s) turned about (1, 0, .): (1, s^2 - 1, s) */
    double s = -1 + 0.5 * i;
    assert_near(def.rods[0].rest[3 * i], 1 + (i == 4 ? 5 : 0), 1e-15);
    assert_near(def.rods[0].rest[3 * i + 1], s * s - 1, 1e-15);
    assert_near(def.rods[0].rest[3 * i + 2], s + 1 + i, 1e-15);
  }
  hb_scene_def_free(&def);
}

/* Rest and initial shape stand for one another; a resampled curve has equal edges. */
static void rest_and_initial(void **state) {
  (void)state;
  hb_scene_def def;
  read_rod("initial: {vertices: [[0, 0, 0], [1, 0, 0], [1, 1, 0]], resample: 5, perturb: {vertex: 1, by: [0, "
           "0, 1]}}, "
           "lengths: initial, straight_rest: true, " STIFF,
           &def);
  assert_int_equal(def.rods[0].nv, 5);
  assert_near_array(def.rods[0].initial, def.rods[0].rest, 15, 0);
  assert_near(def.rods[0].initial[5], 1, 0);
  assert_true(def.rods[0].straight_rest && def.rods[0].lengths_from_initial);
  hb_scene_def_free(&def);
  read_rod("rest: " LINE ", initial: {move: [1, 0, 0]}, velocity: [u, 2*x, L + i], " STIFF, &def);
  for (int i = 0; i < 5; i++) {
    assert_same(def.rods[0].initial[3 * i], 1);
    assert_near(def.rods[0].velocity[3 * i], 0.25 * i, 1e-15);
    assert_same(def.rods[0].velocity[3 * i + 1], 2);
    assert_near(def.rods[0].velocity[3 * i + 2], 1 + i, 1e-15);
  }
  hb_scene_def_free(&def);
}

/* A curve from a file, found beside the scene. */
static void curve_from_file(void **state) {
  (void)state;
  const char *scratch = getenv("HEBRA_SCRATCH");
  char csv[500], yaml[500];
  hb_scene_def def;
  hb_error err = {.status = HB_OK};
  snprintf(csv, sizeof csv, "%s/curve.csv", scratch ? scratch : ".");
  snprintf(yaml, sizeof yaml, "%s/file.yaml", scratch ? scratch : ".");
  FILE *file = fopen(csv, "w");
  assert_non_null(file);
  fputs("x,y,z\n0,0,0\n1,0,0\n1,2,0\n", file);
  fclose(file);
  file = fopen(yaml, "w");
  assert_non_null(file);
  fputs(METHOD "rods: [{rest: {file: curve.csv}, " STIFF "}]\n", file);
  fclose(file);
  if (hb_scene_read(yaml, NULL, 0, &def, &err)) fail_msg("%s", err.text);
  assert_string_equal(def.path, yaml);
  assert_int_equal(def.rods[0].nv, 3);
  assert_same(def.rods[0].rest[7], 2);
  hb_scene_def_free(&def);
  remove(csv);
  assert_int_equal(hb_scene_read(yaml, NULL, 0, &def, &err), HB_ERR_INPUT);
  remove(yaml);
  assert_int_equal(hb_scene_read(yaml, NULL, 0, &def, &err), HB_ERR_INPUT);
  assert_non_null(strstr(err.text, "the scene file cannot be opened"));
}

/* Moduli vary: B at the middle of edges, beta and mass at vertices; half an edge belongs to an end. */
static void moduli(void **state) {
  (void)state;
  hb_scene_def def;
  read_rod("rest: {line: {to: [0, 0, 2], vertices: 5}}, bending: 1 + s, twisting: u, linear_density: 3 + i",
           &def);
  for (int i = 0; i < 5; i++) {
    if (i < 4) assert_near(def.rods[0].B[3 * i + 2], 1.25 + 0.5 * i, 1e-15);
    assert_near(def.rods[0].beta[i], 0.25 * i, 1e-15);
    assert_near(def.rods[0].mass[i], (3 + i) * (i % 4 ? 0.5 : 0.25), 1e-15);
  }
  hb_scene_def_free(&def);
  read_rod("rest: " LINE ", bending: {B: [3, 1], angle: i*pi/4}, twisting: 1, vertex_mass: 1", &def);
  const double expected[12] = {3, 0, 1, 2, 1, 2, 1, 0, 3, 2, -1, 2};
  assert_near_array(def.rods[0].B, expected, 12, 1e-15);
  hb_scene_def_free(&def);
  read_rod("rest: " LINE ", bending: {B: [2, 1, 2], angle: pi/4}, twisting: 1, vertex_mass: 1", &def);
  const double turned[3] = {
      1, 0, 3}; /* ((2, 1), (1, 2)) has 3 along the diagonal, which a further pi/4 takes to m2 */
  assert_near_array(def.rods[0].B, turned, 3, 1e-15);
  hb_scene_def_free(&def);
}

/* The turned form belongs to turned directors: energy of a curvature is that of the same curvature seen from
 * them. */
static void turned_form_is_that_of_turned_directors(void **state) {
  (void)state;
  hb_scene_def def;
  const double a = 0.7, D[2] = {5, 2}, kb[3] = {0.3, -0.4, 0};
  read_rod("rest: " LINE ", bending: {B: [5, 2], angle: 0.7}, twisting: 1, vertex_mass: 1", &def);
  const double *B = def.rods[0].B;
  hb_v3 t = {0, 0, 1}, m1 = {1, 0, 0}, n1 = hb_turn(m1, t, a), k = hb_v3_load(kb);
  double w1 = hb_v3_dot(k, hb_v3_cross(t, m1)), w2 = -hb_v3_dot(k, m1);
  double v1 = hb_v3_dot(k, hb_v3_cross(t, n1)), v2 = -hb_v3_dot(k, n1);
  assert_near(B[0] * w1 * w1 + 2 * B[1] * w1 * w2 + B[2] * w2 * w2, D[0] * v1 * v1 + D[1] * v2 * v2, 1e-14);
  hb_scene_def_free(&def);
}

/* Sections: circle by hand, others by the library's own function; all may vary. */
static void sections(void **state) {
  (void)state;
  hb_scene_def def;
  read_rod("rest: " LINE ", section: {circle: {radius: 0.1*(1 + u)}}, E: 10, nu: 0.25, density: 2", &def);
  for (int i = 0; i < 5; i++) {
    double r = 0.1 * (1 + 0.25 * i), re = 0.1 * (1.125 + 0.25 * i);
    if (i < 4) assert_near_rel(def.rods[0].B[3 * i], 10 * HB_PI / 4 * re * re * re * re, 1e-14);
    assert_near_rel(def.rods[0].beta[i], 4 * HB_PI / 2 * r * r * r * r, 1e-14);
    assert_near_rel(def.rods[0].mass[i], 2 * HB_PI * r * r * (i % 4 ? 0.25 : 0.125), 1e-14);
  }
  assert_near(def.rods[0].radius, 0.2, 1e-15);
  hb_scene_def_free(&def);
  hb_section section = {HB_SECTION_RECTANGLE, 0.3, 0.1};
  hb_section_moduli m;
  assert_int_equal(hb_section_compute(&section, 10, 3, 2, &m, NULL), HB_OK);
  read_rod("rest: " LINE ", section: {rectangle: {width: 0.3, height: 0.1}, angle: pi/2}, E: 10, G: 3, "
           "vertex_mass: 7, radius: 1",
           &def);
  assert_near_rel(def.rods[0].B[0], m.B22, 1e-14);
  assert_near_rel(def.rods[0].B[2], m.B11, 1e-14);
  assert_near_rel(def.rods[0].beta[2], m.beta, 1e-14);
  assert_same(def.rods[0].mass[0], 7);
  assert_same(def.rods[0].radius, 1);
  hb_scene_def_free(&def);
}

/* Compiles a scene of one rod. */
static hb_model *compile(const char *keys, hb_scene_def *def) {
  hb_model *model = NULL;
  hb_error err = {.status = HB_OK};
  read_rod(keys, def);
  if (hb_model_create(def, &model, &err)) fail_msg("%s", err.text);
  return model;
}

/* The rest shape that natural_curvature builds has just this curvature, and this twist, windings and all. */
static void natural_curvature(void **state) {
  (void)state;
  hb_scene_def def;
  hb_model *m = compile("initial: {line: {to: [2, 0, 1], vertices: 9}}, natural_curvature: [3*s, -0.5], "
                        "director: [0, 1, 0], " STIFF,
                        &def);
  for (int i = 1; i < 8; i++) {
    double l = 0.5 * m->voronoi[i], k1 = 3 * m->arc[i] * l, k2 = -0.5 * l;
    for (int side = 0; side < 2; side++) {
      assert_near(m->rest_omega[4 * i + 2 * side], k1, 1e-13);
      assert_near(m->rest_omega[4 * i + 2 * side + 1], k2, 1e-13);
    }
    assert_near(m->rest_twist[i], 0, 1e-13);
  }
  assert_near_rel(m->rods[0].length, sqrt(5), 1e-14);
  hb_model_free(m);
  hb_scene_def_free(&def);
  for (int k = 0; k < 2; k++) { /* 0.5 and 14 radians per vertex */
    double rate = k ? 56 : 2;
    char keys[300];
    snprintf(
        keys, sizeof keys,
        "rest: {line: {to: [2, 0, 0], vertices: 9}}, natural_curvature: [2, 0], natural_twist: %g, " STIFF,
        rate);
    m = compile(keys, &def);
    for (int i = 1; i < 8; i++) {
      double half = 0.5 * rate * 0.25,
             kl = 2 * 0.25; /* the edges see the curvature half a twist to either side */
      assert_near(m->rest_omega[4 * i], kl * cos(half), 1e-13);
      assert_near(m->rest_omega[4 * i + 1], kl * sin(half), 1e-13);
      assert_near(m->rest_omega[4 * i + 2], kl * cos(half), 1e-13);
      assert_near(m->rest_omega[4 * i + 3], -kl * sin(half), 1e-13);
      assert_near(m->rest_twist[i], rate * 0.25, 1e-12);
    }
    assert_near_array(def.rods[0].initial, def.rods[0].rest, 27, 0);
    hb_model_free(m);
    hb_scene_def_free(&def);
  }
}

/* rest_director with a natural twist, and rest_directors one by one. */
static void directors(void **state) {
  (void)state;
  hb_scene_def def;
  hb_model *m = compile("rest: {arc: {radius: 1, angle: pi/2, vertices: 6}}, rest_director: [1, 0, 0.5], "
                        "natural_twist: 30*u, " STIFF,
                        &def);
  for (int i = 1; i < 5; i++)
    assert_near(m->rest_twist[i], 30 * m->arc[i] / m->rods[0].length * 0.5 * m->voronoi[i], 1e-12);
  assert_near(def.rods[0].rest_m1[1] * cos(HB_PI / 20), def.rods[0].rest_m1[0] * sin(HB_PI / 20), 1e-14);
  hb_model_free(m);
  hb_scene_def_free(&def);
  m = compile("rest: " LINE
              ", rest_directors: [[1, 0, 0], [1, 1, 5], [0, 3, 0], [0, 1, 0]], director: [0, 2, 0], " STIFF,
              &def);
  assert_near(m->rest_twist[1], HB_PI / 4, 1e-14);
  assert_near(m->rest_twist[2], HB_PI / 4, 1e-14);
  assert_near(m->rest_twist[3], 0, 1e-14);
  assert_same(def.rods[0].first_director[1], 2);
  hb_model_free(m);
  hb_scene_def_free(&def);
}

/* Every way to hold something. */
static void supports(void **state) {
  (void)state;
  hb_scene_def def;
  read_rod("rest: " LINE ", start: {position: [x + t, free, fixed], material_angle: 2*pi*t}, end: {clamp: "
           "true, material_angle: 1},"
           " supports: [{vertex: -2, position: fixed}, {edge: -3, clamp: true}, {edge: 2, position: fixed, "
           "tangent: [0, 0, 1],"
           " material_frame: [1, t, 0], material_turn: t}, {edge: 1, material: fixed}, {edge: 1, material: "
           "free}], " STIFF,
           &def);
  static const struct {
    hb_support_kind kind;
    int index;
    bool held, base_is_end;
  } expected[] = {{HB_SUPPORT_POSITION, 0, true, false},  {HB_SUPPORT_ANGLE, 0, false, false},
                  {HB_SUPPORT_POSITION, -1, true, false}, {HB_SUPPORT_TANGENT, -1, true, true},
                  {HB_SUPPORT_ANGLE, -1, false, false},   {HB_SUPPORT_POSITION, -2, true, false},
                  {HB_SUPPORT_POSITION, 1, true, false},  {HB_SUPPORT_TANGENT, -3, true, false},
                  {HB_SUPPORT_ANGLE, -3, true, false},    {HB_SUPPORT_POSITION, 2, true, false},
                  {HB_SUPPORT_TANGENT, 2, false, false},  {HB_SUPPORT_DIRECTOR, 2, false, false},
                  {HB_SUPPORT_ANGLE, 1, true, false}};
  const hb_support_def *s = def.rods[0].supports;
  assert_int_equal(def.rods[0].support_count, 13);
  for (int k = 0; k < 13; k++) {
    assert_int_equal(s[k].kind, expected[k].kind);
    assert_int_equal(s[k].index, expected[k].index);
    assert_int_equal(s[k].held, expected[k].held);
    assert_int_equal(s[k].base_is_end, expected[k].base_is_end);
    assert_int_equal(s[k].line, 2);
  }
  double vars[HB_VAR_COUNT] = {0};
  vars[HB_VAR_T] = 0.5;
  vars[HB_VAR_X] = 7;
  assert_same(hb_formula_eval(s[0].value[0], vars), 7.5);
  assert_true(s[0].axis_free[1] && !s[0].axis_free[0] && !s[0].axis_free[2]);
  assert_true(!s[0].value[1] && !s[0].value[2]);
  assert_near(hb_formula_eval(s[1].angle, vars), HB_PI, 1e-15);
  assert_null(s[8].angle);
  assert_same(hb_formula_eval(s[11].value[1], vars), 0.5);
  assert_same(hb_formula_eval(s[11].angle, vars), 0.5);
  hb_scene_def_free(&def);
}

/* Every load, rods by name and by index, drag per rod. */
static void forces(void **state) {
  (void)state;
  hb_scene_def def;
  read_text(METHOD
            "gravity: [0, 0, -10]\n"
            "rods:\n  - {name: a, radius: 0.1, rest: " LINE ", " STIFF
            "}\n  - {name: b, radius: 0.2, rest: " LINE ", " STIFF "}\n"
            "forces:\n"
            "  - {point: [t, 0, 0], rod: b, vertex: -1, follower: true}\n"
            "  - {distributed: [0, z, 0], rod: 0}\n"
            "  - {per_vertex: [0, 0, s], rod: all}\n"
            "  - {wind: {velocity: [1, 0, 0], linear: {normal: 2, tangential: 1}, quadratic: {normal: 3}}}\n"
            "  - {wind: {velocity: [y, 0, 0], drag: {density: 4, normal_coefficient: 1.5, "
            "tangential_coefficient: 0.5}}}\n",
            &def);
  const hb_force_def *f = def.forces;
  static const hb_force_kind kinds[] = {HB_FORCE_GRAVITY,    HB_FORCE_POINT, HB_FORCE_DISTRIBUTED,
                                        HB_FORCE_PER_VERTEX, HB_FORCE_WIND,  HB_FORCE_WIND};
  static const int rods[] = {-1, 1, 0, -1, -1, -1};
  assert_int_equal(def.force_count, 6);
  for (int k = 0; k < 6; k++) {
    assert_int_equal(f[k].kind, kinds[k]);
    assert_int_equal(f[k].rod, rods[k]);
    assert_int_equal(f[k].follower, k == 1);
    assert_non_null(f[k].value[0]);
  }
  assert_int_equal(f[1].vertex, -1);
  assert_same(f[4].linear[0], 2);
  assert_same(f[4].linear[1], 1);
  assert_same(f[4].quadratic[0], 3);
  assert_same(f[4].quadratic[1], 0);
  for (int k = 0; k < 2; k++) { /* density/2 * coefficient * 2 r, and * 2 pi r along the rod */
    double r = 0.1 * (k + 1);
    assert_near_rel(hb_force_def_quadratic(&f[5], &def.rods[k], 0), 0.5 * 4 * 1.5 * 2 * r, 1e-15);
    assert_near_rel(hb_force_def_quadratic(&f[5], &def.rods[k], 1), 0.5 * 4 * 0.5 * 2 * HB_PI * r, 1e-15);
  }
  hb_scene_def_free(&def);
}

/* Precision, and the length tolerance that goes with it; threads are no matter of the scene. */
static void precision(void **state) {
  (void)state;
  static const struct {
    const char *method;
    hb_precision precision;
    double tolerance;
  } cases[] = {{"precision: double", HB_PRECISION_DOUBLE, 1e-10},
               {"precision: single", HB_PRECISION_SINGLE, 1e-5},
               {"precision: single, length_tolerance: 1e-6", HB_PRECISION_SINGLE, 1e-6},
               {"precision: single, length_tolerance: {absolute: 2.5e-7}", HB_PRECISION_SINGLE, 2.5e-7},
               {"length_tolerance: 1e-3, precision: single", HB_PRECISION_SINGLE, 1e-3}};
  for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
    char text[300];
    hb_scene_def def;
    hb_model *model;
    hb_error err;
    snprintf(text, sizeof text,
             "method: {time_step: 1e-3, duration: 1, %s}\nrods: [{rest: " LINE ", " STIFF "}]\n",
             cases[k].method);
    read_text(text, &def);
    assert_int_equal(def.method.precision, cases[k].precision);
    assert_same(def.method.length_tolerance, cases[k].tolerance);
    assert_int_equal(def.method.threads, 0);
    assert_int_equal(hb_model_create(&def, &model, &err), HB_OK);
    hb_model_free(model);
    def.method.threads = -1;
    assert_int_equal(hb_model_create(&def, &model, &err), HB_ERR_INPUT);
    assert_string_equal(
        err.text, "-1 threads are not possible; at least 1, or 0 to let the program choose, is expected");
    hb_scene_def_free(&def);
  }
}

/* Damping. */
static void damping(void **state) {
  (void)state;
  hb_scene_def def;
  read_rod("rest: " LINE ", damping: {mass: 0.5, bending: 1 - s}, " STIFF, &def);
  assert_same(def.rods[0].mass_damping, 0.5);
  for (int j = 0; j < 4; j++) assert_near(def.rods[0].viscosity[j], 0.875 - 0.25 * j, 1e-15);
  hb_scene_def_free(&def);
}

/* Overrides act, and the text that is kept gives the overridden scene without them. */
static void overrides_are_kept(void **state) {
  (void)state;
  static const char *const list[] = {
      "parameters.n=6",     "rods.a.bending=2*n",
      "rods[*].twisting=3", "rods.b.start={position: [\"max(x, t)\", fixed, free]}",
      "title=two: words",   "title=\"two: words\""};
  hb_scene_def def, again;
  read_set("parameters: {n: 5}\n" METHOD
           "rods:\n  - {name: a, rest: {line: {to: [0, 0, 1], vertices: n}}, " STIFF "}\n"
           "  - {name: b, rest: " LINE ", " STIFF "}\n",
           list, 6, &def);
  assert_int_equal(def.rods[0].nv, 6);
  assert_same(def.rods[0].B[0], 12);
  assert_same(def.rods[1].beta[1], 3);
  assert_int_equal(def.rods[1].supports[0].line, 0); /* not from the file */
  read_text(def.source, &again);
  assert_string_equal(again.title, "two: words");
  assert_int_equal(again.rods[0].nv, 6);
  assert_near_array(again.rods[0].B, def.rods[0].B, 15, 0);
  assert_near_array(again.rods[0].rest, def.rods[0].rest, 18, 0);
  assert_string_equal(hb_formula_text(again.rods[1].supports[0].value[0]), "max(x, t)");
  hb_scene_def_free(&again);
  hb_scene_def_free(&def);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(defaults),
      cmocka_unit_test(head),
      cmocka_unit_test(shapes),
      cmocka_unit_test(rest_and_initial),
      cmocka_unit_test(curve_from_file),
      cmocka_unit_test(moduli),
      cmocka_unit_test(turned_form_is_that_of_turned_directors),
      cmocka_unit_test(sections),
      cmocka_unit_test(natural_curvature),
      cmocka_unit_test(directors),
      cmocka_unit_test(supports),
      cmocka_unit_test(forces),
      cmocka_unit_test(damping),
      cmocka_unit_test(precision),
      cmocka_unit_test(overrides_are_kept),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
