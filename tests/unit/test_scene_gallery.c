/* The scenes that come with the program: all can be read and compiled, their steps are small enough, and
 * those of the thesis hold its parameters. */
#include "hebra/scene.h"
#include "math/rotation.h"
#include "support/near.h"

#include <dirent.h>
#include <stdio.h>
#include <string.h>

/* Reads and compiles a scene of the gallery. */
static hb_model *open_scene(const char *name, hb_scene_def *def) {
  char path[500];
  hb_model *model = NULL;
  hb_error err = {.status = HB_OK};
  snprintf(path, sizeof path, "%s/scenes/%s", HEBRA_SOURCE_DIR, name);
  if (hb_scene_read(path, NULL, 0, def, &err)) fail_msg("%s", err.text);
  if (hb_model_create(def, &model, &err)) fail_msg("%s", err.text);
  return model;
}

/* Largest step over the limit l^2/2 sqrt(rho A/B) of bending waves on the grid. */
static double step_share(const hb_model *m) {
  double most = 0;
  for (int r = 0; r < m->rod_count; r++)
    for (int k = m->rods[r].first + 1; k < m->rods[r].first + m->rods[r].nv - 1; k++) {
      double l = 0.5 * m->voronoi[k], B = fmax(m->B[3 * k], m->B[3 * k + 2]);
      most = fmax(most, m->def->method.time_step / (0.5 * l * l * sqrt(m->mass[k] / m->weight[k] / B)));
    }
  return most;
}

/* Every file of the gallery. */
static void every_scene_compiles(void **state) {
  (void)state;
  int scenes = 0;
  DIR *directory = opendir(HEBRA_SOURCE_DIR "/scenes");
  assert_non_null(directory);
  for (struct dirent *entry; (entry = readdir(directory));) {
    const char *dot = strrchr(entry->d_name, '.');
    if (!dot || strcmp(dot, ".yaml") != 0) continue;
    hb_scene_def def;
    hb_model *m = open_scene(entry->d_name, &def);
    assert_non_null(def.title);
    assert_at_most(step_share(m), 0.75);
    bool printed = strstr(entry->d_name, "as-printed") != NULL;
    assert_int_equal(m->note_count, printed ? 1 : 0); /* its constraints leave no room, and it says so */
    if (printed) assert_non_null(strstr(m->notes[0], "leave no room"));
    hb_model_free(m);
    hb_scene_def_free(&def);
    scenes++;
  }
  closedir(directory);
  assert_true(scenes >= 10);
}

/* A prescribed angle at time 0. */
static double angle_of(const hb_rod_def *rod, int index) {
  const double vars[HB_VAR_COUNT] = {0};
  for (int k = 0; k < rod->support_count; k++)
    if (rod->supports[k].kind == HB_SUPPORT_ANGLE && rod->supports[k].index == index)
      return hb_formula_eval(rod->supports[k].angle, vars);
  fail_msg("no angle at edge %d", index);
  return 0;
}

/* Example 1, both ways. */
static void first_example(void **state) {
  (void)state;
  static const char *const names[] = {"thesis-1-twisted.yaml", "thesis-1-as-printed.yaml"};
  for (int k = 0; k < 2; k++) {
    hb_scene_def def;
    hb_model *m = open_scene(names[k], &def);
    const hb_rod_def *rod = &def.rods[0];
    assert_int_equal(rod->nv, 25);
    assert_same(rod->rest[72], 1);
    assert_same(rod->rest[73], 1);
    assert_near(rod->initial[5], 0.05, 0);
    assert_near(rod->initial[3], 1.0 / 24, 1e-15);
    assert_same(m->alpha[7], 0.1);
    assert_same(m->beta[7], 10);
    assert_same(m->mass[0], 50);
    assert_same(m->mass[7], 50);
    assert_near_rel(angle_of(rod, 0), 3 * HB_PI, 1e-15);
    assert_same(angle_of(rod, -1), 0);
    assert_string_equal(def.method.integrator, k == 0 ? "verlet" : "symplectic-euler");
    assert_same(def.method.time_step, 3e-3);
    assert_same(def.method.duration, 0.5);
    assert_true(m->rods[0].closed_form);
    if (k == 0)
      assert_near_rel(m->rods[0].length, sqrt(2) + 2 * (sqrt(2.0 / 576 + 0.0025) - sqrt(2) / 24), 1e-14);
    else
      assert_near_rel(m->rest_length[3], sqrt(2) / 24, 1e-14);
    assert_int_equal(def.method.length_tolerance_kind,
                     k == 0 ? HB_TOLERANCE_RELATIVE : HB_TOLERANCE_ABSOLUTE);
    assert_same(def.method.length_tolerance, k == 0 ? 1e-10 : 1e-2);
    hb_model_free(m);
    hb_scene_def_free(&def);
  }
}

/* Example 2: the stated curve and its symmetry. */
static void second_example(void **state) {
  (void)state;
  hb_scene_def def;
  hb_model *m = open_scene("thesis-2-catenary.yaml", &def);
  const hb_rod_def *rod = &def.rods[0];
  assert_int_equal(rod->nv, 25);
  for (int i = 0; i < 25; i++) {
    double x = i / 24.0;
    assert_near(rod->rest[3 * i], x, 1e-15);
    assert_near(rod->rest[3 * i + 1], x, 1e-15);
    assert_near(rod->rest[3 * i + 2], cosh(4.35464 * x - 2.17732) / 4.35464 - 1.02602, 1e-14);
  }
  assert_near_rel(angle_of(rod, 0), HB_PI, 1e-15);
  assert_near_rel(angle_of(rod, -1), -HB_PI, 1e-15);
  assert_false(m->rods[0].closed_form);
  assert_near(m->rods[0].length, 2.2754, 2e-3);
  assert_same(def.method.duration, 2);
  hb_model_free(m);
  hb_scene_def_free(&def);
}

/* Example 3: the lowest two vertices held, the rest free. */
static void third_example(void **state) {
  (void)state;
  hb_scene_def def;
  hb_model *m = open_scene("thesis-3-tree.yaml", &def);
  const double vars[HB_VAR_COUNT] = {0};
  assert_int_equal(m->nv, 25);
  assert_near(m->rods[0].length, 1, 1e-15);
  assert_same(m->alpha[5], 100);
  assert_same(m->beta[5], 100);
  assert_same(m->mass[5], 50);
  for (int k = 0; k < 25; k++) assert_int_equal(m->inv_mass[3 * k] == 0, k < 2);
  assert_int_equal(def.force_count, 1);
  assert_int_equal(def.forces[0].kind, HB_FORCE_PER_VERTEX);
  assert_same(hb_formula_eval(def.forces[0].value[0], vars), 5);
  assert_same(def.method.time_step, 1e-3);
  assert_same(def.method.duration, 8);
  assert_true(m->rods[0].twist_free);
  hb_model_free(m);
  hb_scene_def_free(&def);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(every_scene_compiles),
      cmocka_unit_test(first_example),
      cmocka_unit_test(second_example),
      cmocka_unit_test(third_example),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
