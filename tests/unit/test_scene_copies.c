/* Rods that stand for many: numbers of each copy, names, loads on all copies, sentences about one copy. */
#include "hebra/scene.h"
#include "math/rotation.h"
#include "support/near.h"

#include <stdio.h>
#include <string.h>

#define METHOD "method: {time_step: 1e-3, duration: 1}\n"
#define STIFF "bending: 1, twisting: 1, vertex_mass: 1"
#define LINE "{line: {to: [0, 0, 1], vertices: 5}}"

/* Reads text with overrides; it must be sound and compile. */
static hb_model *read_set(const char *text, const char *const *overrides, int count, hb_scene_def *def) {
  hb_model *model = NULL;
  hb_error err = {.status = HB_OK};
  if (hb_scene_parse(text, strlen(text), "t.yaml", ".", overrides, count, def, &err))
    fail_msg("%s", err.text);
  if (hb_model_create(def, &model, &err)) fail_msg("%s", err.text);
  return model;
}

/* A scene that must be refused with exactly this sentence. */
static void refuse(const char *text, const char *sentence) {
  hb_scene_def def;
  hb_error err = {.status = HB_OK};
  hb_model *model = NULL;
  hb_status status = hb_scene_parse(text, strlen(text), "t.yaml", ".", NULL, 0, &def, &err);
  if (!status) {
    status = hb_model_create(&def, &model, &err);
    hb_model_free(model);
    hb_scene_def_free(&def);
  }
  assert_int_equal(status, HB_ERR_INPUT);
  assert_string_equal(err.text, sentence);
}

/* Every formula of a rod sees the number of the copy and how many there are. */
static void every_formula_sees_its_copy(void **state) {
  (void)state;
  hb_scene_def def;
  hb_model *model =
      read_set("parameters: {n: 4}\n" METHOD "rods:\n"
               "  - name: hair\n"
               "    copies: 10*n\n"
               "    rest: {line: {from: [k, 0, 0], to: [k, 0, 1 + k/K], vertices: '5 + mod(k, 2)'}}\n"
               "    initial: {displace: [0, 0.01*k*u, 0], perturb: {vertex: 1, by: [0, 0, 0.001*k]}}\n"
               "    lengths: initial\n"
               "    velocity: [k*s, 0, K]\n"
               "    radius: 0.1 + 0.01*k\n"
               "    bending: {B: [2 + k, 1], angle: 0.1*k}\n"
               "    twisting: 1 + k\n"
               "    linear_density: (1 + k)*(1 + u)\n"
               "    natural_twist: 0.1*k\n"
               "    director: [1, k, 0]\n"
               "    damping: {mass: k/K, bending: 0.5*k}\n"
               "    start: {position: [k + t, 0, k*t], material_angle: k*t}\n"
               "    supports: [{vertex: '2 + mod(k, 2)', position: [free, 'y + k*t', free]}]\n",
               NULL, 0, &def);
  const double vars[HB_VAR_COUNT] = {[HB_VAR_T] = 2, [HB_VAR_Y] = 7};
  assert_int_equal(def.rod_count, 40);
  assert_int_equal(def.parameter_count, 1);
  for (int k = 0; k < 40; k++) {
    const hb_rod_def *rod = &def.rods[k];
    char name[24];
    double length = 0;
    snprintf(name, sizeof name, "hair-%d", k);
    assert_string_equal(rod->name, name);
    assert_int_equal(rod->nv, 5 + k % 2);
    assert_int_equal(rod->line, 4);
    for (int i = 0; i < rod->nv; i++) {
      double u = (double)i / (rod->nv - 1), z = u * (1 + k / 40.0);
      assert_near(rod->rest[3 * i], k, 1e-14);
      assert_near(rod->rest[3 * i + 2], z, 1e-14);
      assert_near(rod->initial[3 * i + 1], 0.01 * k * u, 1e-14);
      assert_near(rod->initial[3 * i + 2], z + (i == 1 ? 0.001 * k : 0), 1e-14);
      assert_near(rod->velocity[3 * i], k * length, 1e-12);
      assert_same(rod->velocity[3 * i + 2], 40);
      double e[3];
      for (int c = 0; c < 3; c++)
        e[c] = i + 1 < rod->nv ? rod->initial[3 * i + 3 + c] - rod->initial[3 * i + c] : 0;
      length += sqrt(e[0] * e[0] + e[1] * e[1] + e[2] * e[2]);
    }
    assert_near(rod->radius, 0.1 + 0.01 * k, 1e-15);
    double c = cos(0.1 * k), s = sin(0.1 * k);
    assert_near(rod->B[0], (2 + k) * c * c + s * s, 1e-12);
    assert_same(rod->beta[1], 1 + k);
    assert_near(rod->mass[0], (1 + k) * 0.5 * hypot(hypot(0, rod->initial[4]), rod->initial[5]), 1e-12);
    assert_near(rod->natural_twist[2], 0.1 * k, 1e-15);
    assert_same(rod->first_director[1], k);
    assert_near(rod->mass_damping, k / 40.0, 1e-15);
    assert_near(rod->viscosity[3], 0.5 * k, 1e-15);
    assert_same(hb_formula_eval(rod->supports[0].value[0], vars), k + 2);
    assert_same(hb_formula_eval(rod->supports[1].angle, vars), 2 * k);
    assert_int_equal(rod->supports[2].index, 2 + k % 2);
    assert_same(hb_formula_eval(rod->supports[2].value[1], vars), 7 + 2 * k);
  }
  hb_model_free(model);
  hb_scene_def_free(&def);
}

/* A section, its material and a natural curvature by noise: each copy as the same rod written for itself. */
static void a_copy_is_the_rod_written_out(void **state) {
  (void)state;
  static const char format[] = METHOD
      "rods:\n  - {name: hair, %srest: {helix: {radius: 1, pitch: 0.2 + 0.01*%s, turns: 1, vertices: 7}}, "
      "section: {ellipse: {a: 0.1, b: '0.05*(1 + 0.5*noise(%s, u))'}}, E: 1e6*(1 + %s), nu: 0.01*%s, "
      "density: 1e3, natural_curvature: ['3*(1 + 0.2*noise(%s))', 0.1*%s]}\n";
  char text[1200], number[16];
  hb_scene_def many, one;
  snprintf(text, sizeof text, format, "copies: {count: 9}, ", "k", "k", "k", "k", "k", "k");
  hb_model *model = read_set(text, NULL, 0, &many), *single;
  for (int k = 0; k < 9; k++) {
    snprintf(number, sizeof number, "%d", k);
    snprintf(text, sizeof text, format, "", number, number, number, number, number, number);
    single = read_set(text, NULL, 0, &one);
    const hb_rod_def *a = &many.rods[k], *b = &one.rods[0];
    assert_same(a->radius, b->radius);
    assert_near_array(a->rest, b->rest, 21, 0);
    assert_near_array(a->initial, b->initial, 21, 0);
    assert_near_array(a->rest_m1, b->rest_m1, 18, 0);
    assert_near_array(a->B, b->B, 18, 0);
    assert_near_array(a->beta, b->beta, 7, 0);
    assert_near_array(a->mass, b->mass, 7, 0);
    hb_model_free(single);
    hb_scene_def_free(&one);
  }
  assert_true(many.rods[1].rest[15] != many.rods[2].rest[15]);
  hb_model_free(model);
  hb_scene_def_free(&many);
}

/* Names by entry, loads by the name of an entry, of one copy, by number; the count by --set; the kept text.
 */
static void loads_find_their_copies(void **state) {
  (void)state;
  static const char text[] =
      METHOD "rods:\n"
             "  - {rest: " LINE ", " STIFF "}\n"
             "  - {name: hair, copies: 4, radius: 0.1*(1 + k), rest: {move: [k, 0, 0], line: {to: [0, 0, 1], "
             "vertices: 5}}, " STIFF "}\n"
             "  - {copies: 2, rest: " LINE ", " STIFF "}\n"
             "forces:\n"
             "  - {point: [0, 0, 1], rod: hair, vertex: -1}\n"
             "  - {per_vertex: [0, 0, 1], rod: hair-2}\n"
             "  - {wind: {velocity: [1, 0, 0], drag: {density: 2, normal_coefficient: 1.5}}, rod: hair}\n"
             "  - {per_vertex: [0, 0, 1], rod: rod2-1}\n"
             "  - {per_vertex: [0, 0, 1], rod: 1}\n";
  static const char *const names[] = {"rod0", "hair-0", "hair-1", "hair-2", "hair-3", "rod2-0", "rod2-1"};
  static const int first[] = {1, 3, 1, 6, 1}, last[] = {4, 3, 4, 6, 1};
  static const char *const more[] = {"rods.hair.copies=300"};
  hb_scene_def def, again;
  hb_model *model = read_set(text, NULL, 0, &def);
  assert_int_equal(def.rod_count, 7);
  for (int r = 0; r < 7; r++) {
    assert_string_equal(def.rods[r].name, names[r]);
    for (int k = 0; k < 5; k++)
      assert_int_equal(hb_force_def_acts_on(&def.forces[k], r), r >= first[k] && r <= last[k]);
  }
  /* density/2 * coefficient * 2 r */
  assert_near(hb_force_def_quadratic(&def.forces[2], &def.rods[3], 0), 0.5 * 2 * 1.5 * 2 * 0.3, 1e-15);
  hb_model_free(model);
  hb_scene_def_free(&def);
  model = read_set(text, more, 1, &def);
  assert_int_equal(def.rod_count, 303);
  assert_int_equal(def.forces[0].rods, 300);
  assert_string_equal(def.rods[300].name, "hair-299");
  assert_same(def.rods[300].rest[0], 299);
  hb_model_free(model);
  model = read_set(def.source, NULL, 0, &again);
  assert_int_equal(again.rod_count, 303);
  assert_near_array(again.rods[300].rest, def.rods[300].rest, 15, 0);
  hb_model_free(model);
  hb_scene_def_free(&again);
  hb_scene_def_free(&def);
}

/* One copy is a copy too. */
static void a_single_copy_has_a_number(void **state) {
  (void)state;
  hb_scene_def def;
  hb_model *model =
      read_set(METHOD "rods:\n  - {name: a, copies: 1, radius: K + k, rest: " LINE ", " STIFF "}\n"
                      "  - {name: k, rest: " LINE ", " STIFF "}\n",
               NULL, 0, &def);
  assert_string_equal(def.rods[0].name, "a-0");
  assert_same(def.rods[0].radius, 1);
  hb_model_free(model);
  hb_scene_def_free(&def);
}

/* What is wrong in one copy only says which; what the model finds names the rod. (More in tests/broken.) */
static void sentences_say_the_copy(void **state) {
  (void)state;
  refuse(METHOD "rods:\n  - {name: a, copies: 100, radius: 37 - k, rest: " LINE ", " STIFF "}\n",
         "t.yaml:3:36: rods[0].radius: \"37 - k\" gives 0, which is not allowed; a number or formula > 0 is "
         "expected (copy 37 of 100)");
  refuse(
      METHOD "rods:\n  - {name: a, copies: 100, radius: k, rest: " LINE ", " STIFF "}\n",
      "t.yaml:3:36: rods[0].radius: \"k\" gives 0, which is not allowed; a number or formula > 0 is expected "
      "(copy 0 of 100)");
  refuse(METHOD "rods:\n  - {name: a, copies: 100, rest: {line: {to: [0, 0, k - 3], vertices: 5}}, " STIFF
                "}\n",
         "t.yaml:3:41: rods[0].rest.line: the line starts and ends at (0, 0, 0), allowed are two different "
         "points "
         "(copy 3 of 100)");
  refuse(
      METHOD "rods:\n  - {name: a, copies: 100, rest: " LINE
             ", bending: 5 - k, twisting: 1, vertex_mass: 1}\n",
      "t.yaml:3:81: rods[0].bending: \"5 - k\" gives -1, which is not allowed; a number or formula >= 0 is "
      "expected (copy 6 of 100)");
  refuse(METHOD "rods:\n  - {name: a, copies: 9, rest: " LINE ", " STIFF ", start: {position: fixed}, "
                "end: {position: [0, 0, 1 + 0.1*k]}}\n",
         "scene:3:5: rod a-1: vertices 0 and 4 are prescribed 1.1 apart, but the rod between them is only 1 "
         "long");
  refuse(
      METHOD "rods:\n  - {name: a, copies: 9, radius: kk, rest: " LINE ", " STIFF "}\n",
      "t.yaml:3:34: rods[0].radius: not a number or formula that is allowed here: column 1 of 'kk': unknown "
      "name 'kk', did you mean 'k'? available here are pi, e and the parameters k, K");
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(every_formula_sees_its_copy), cmocka_unit_test(a_copy_is_the_rod_written_out),
      cmocka_unit_test(loads_find_their_copies),     cmocka_unit_test(a_single_copy_has_a_number),
      cmocka_unit_test(sentences_say_the_copy),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
