/* A scene with copies, read from text, against what every rod is promised: each copy moves as the same rod
 * written for itself, to the bit; loads on the name of the copies are loads on each of them; the same bits
 * after a restart; lengths to the tolerance. */
#include "support/near.h"

#include "hebra/plug.h"
#include "hebra/scene.h"
#include "support/scenes.h"

enum { COPIES = 7 };

/* A scene: integrator, name of the loads' rods, keys between name and shape, numbers of the copy. */
static const char text[] =
    "method: {integrator: %s, time_step: 5e-4, duration: 1}\n"
    "gravity: [0, 0, -9.81]\n"
    "rods:\n"
    "  - name: hair\n"
    "    %s\n"
    "    rest: {line: {from: [0.1*%d, 0, 0], to: [0.1*%d, 0.3, 0.02*%d], vertices: 9 + %d}}\n"
    "    natural_curvature: ['%d*(1 + 0.3*noise(%d))', 0.5]\n"
    "    natural_twist: 3*noise(%d, 1)\n"
    "    director: [1, 0, 0]\n"
    "    bending: [1e-5*(1 + %d), 2e-5]\n"
    "    twisting: 1e-5\n"
    "    linear_density: 0.01\n"
    "    radius: 0.001*(1 + %d)\n"
    "    damping: {mass: 0.1*%d}\n"
    "    start: {clamp: true, material_angle: 0.5*%d*t}\n"
    "forces:\n"
    "  - {wind: {velocity: [sin(9*t), 0.2*x, 0], linear: {normal: 2e-3}, drag: {density: 1.2}}, rod: hair}\n"
    "  - {point: [0, 1e-4*t, 0], rod: hair, vertex: -1, follower: true}\n";

/* The scene with the number of the copy as a word of the formula language, or written in. */
static void put(char *out, size_t size, const char *integrator, const char *keys, int k, bool words) {
  char format[sizeof text];
  memcpy(format, text, sizeof text);
  for (char *at = format; words && (at = strstr(at, "%d")); at++) memcpy(at, "k ", 2);
  if (words)
    snprintf(out, size, "%s", format);
  else
    snprintf(out, size, text, integrator, keys, k, k, k, k, k, k, k, k, k, k, k);
  if (!words) return;
  char copy[2 * sizeof text];
  char *first = strstr(format, "%s"), *second = strstr(first + 2, "%s");
  snprintf(copy, sizeof copy, "%.*s%s%.*s%s%s", (int)(first - format), format, integrator,
           (int)(second - first - 2), first + 2, keys, second + 2);
  snprintf(out, size, "%s", copy);
}

/* A run of a text. */
static void begin(trial *t, const char *scene) {
  hb_error err = {HB_OK, ""};
  if (hb_scene_parse(scene, strlen(scene), "t.yaml", ".", NULL, 0, &t->def, &err)) fail_msg("%s", err.text);
  trial_start(t);
}

/* Every copy as the rod alone. */
static void test_as_if_alone(void **state) {
  (void)state;
  char scene[4000];
  for (int n = 0; hb_integrators[n]; n++) {
    trial all = {0};
    put(scene, sizeof scene, hb_integrators[n]->name, "copies: 7", 0, true);
    begin(&all, scene);
    assert_int_equal(all.model->rod_count, COPIES);
    trial_run(&all, 200);
    for (int k = 0; k < COPIES; k++) {
      trial one = {0};
      const hb_rod *rod = &all.model->rods[k];
      put(scene, sizeof scene, hb_integrators[n]->name, "", k, false);
      begin(&one, scene);
      trial_run(&one, 200);
      assert_int_equal(rod->nv, 9 + k);
      assert_int_equal(one.model->nv, rod->nv);
      size_t size = 3 * (size_t)rod->nv * sizeof(double);
      assert_memory_equal(hb_sim_const_state(all.sim)->x + 3 * rod->first, hb_sim_const_state(one.sim)->x,
                          size);
      assert_memory_equal(hb_sim_const_state(all.sim)->v + 3 * rod->first, hb_sim_const_state(one.sim)->v,
                          size);
      trial_end(&one);
    }
    trial_end(&all);
  }
}

/* Each load of the list adds to a copy what it adds to the rod alone; on a rod outside the range, nothing. */
static void test_loads(void **state) {
  (void)state;
  char scene[4000];
  trial all = {0};
  put(scene, sizeof scene, "verlet", "copies: 7", 0, true);
  begin(&all, scene);
  trial_run(&all, 50);
  size_t count = 3 * (size_t)all.model->nv;
  const hb_state *s = hb_sim_const_state(all.sim);
  double *f = scene_fill(0, count), *g = scene_fill(0, count);
  hb_force_def *wind = &all.def.forces[1], *point = &all.def.forces[2];
  assert_int_equal(wind->kind, HB_FORCE_WIND);
  assert_int_equal(wind->rods, COPIES);
  wind->rod = point->rod = 2; /* rods 2, 3, 4 only */
  wind->rods = point->rods = 3;
  for (int n = 0; hb_force_terms[n]; n++)
    for (int k = 0; k < COPIES; k++) {
      const hb_rod *rod = &all.model->rods[k];
      bool inside = k >= 2 && k < 5, active = hb_force_terms[n]->active(all.model, rod);
      if (hb_force_terms[n]->energy) assert_true(active); /* gravity */
      if (!strcmp(hb_force_terms[n]->name, "wind") || !strcmp(hb_force_terms[n]->name, "load"))
        assert_int_equal(active, inside);
      if (!active) continue;
      memset(f, 0, count * sizeof *f);
      memset(g, 0, count * sizeof *g);
      hb_force_terms[n]->add(all.model, rod, 0.3, s->x, s->v, s->m1, f);
      hb_force_def keep[2] = {*wind, *point};
      wind->rod = point->rod = k; /* this one alone */
      wind->rods = point->rods = 0;
      hb_force_terms[n]->add(all.model, rod, 0.3, s->x, s->v, s->m1, g);
      *wind = keep[0];
      *point = keep[1];
      assert_memory_equal(f, g, count * sizeof *f);
      double largest = 0;
      for (size_t i = 0; i < count; i++) largest = fmax(largest, fabs(f[i]));
      assert_true(largest > 0 || !strcmp(hb_force_terms[n]->name, "damping"));
    }
  hb_free(f);
  hb_free(g);
  trial_end(&all);
}

/* The gallery's hair, forty of them: lengths at every step, the same bits after a restart, figures that are
 * finite. */
static void test_hair(void **state) {
  (void)state;
  static const char *const few[] = {"parameters.count=40"};
  for (int n = 0; hb_integrators[n]; n++) {
    trial a = {0}, b = {0};
    hb_error err = {HB_OK, ""};
    trial *both[2] = {&a, &b};
    for (int k = 0; k < 2; k++) {
      if (hb_scene_read(HEBRA_SOURCE_DIR "/scenes/hair.yaml", few, 1, &both[k]->def, &err))
        fail_msg("%s", err.text);
      hb_free(both[k]->def.method.integrator);
      both[k]->def.method.integrator = hb_strdup(hb_integrators[n]->name);
      trial_start(both[k]);
    }
    assert_int_equal(a.model->rod_count, 40);
    for (int step = 0; step < 60 / SHORTER; step++) {
      trial_run(&a, 1);
      const double *x = hb_sim_const_state(a.sim)->x;
      for (int r = 0; r < 40; r++)
        for (int k = a.model->rods[r].first; k < a.model->rods[r].first + a.model->rods[r].nv - 1; k++) {
          double l = a.model->rest_length[k], e2 = 0;
          for (int c = 0; c < 3; c++)
            e2 += (x[3 * k + 3 + c] - x[3 * k + c]) * (x[3 * k + 3 + c] - x[3 * k + c]);
          assert_at_most(fabs(e2 / (l * l) - 1), a.def.method.length_tolerance * (1 + 1e-9));
        }
    }
    const hb_frame *frame = trial_measure(&a);
    assert_true(isfinite(frame->kinetic) && frame->kinetic > 0 && isfinite(frame->bending));
    size_t count = hb_sim_const_state(a.sim)->count;
    double *saved = scene_copy(hb_sim_const_state(a.sim)->block, count);
    trial_run(&a, 20);
    assert_int_equal(hb_sim_restore(b.sim, saved, count, &err), HB_OK);
    trial_run(&b, 20);
    assert_memory_equal(hb_sim_const_state(a.sim)->block, hb_sim_const_state(b.sim)->block,
                        count * sizeof(double));
    hb_free(saved);
    trial_end(&a);
    trial_end(&b);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_as_if_alone), cmocka_unit_test(test_loads),
                                     cmocka_unit_test(test_hair)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
