/* A clamp sits where the scene says (docs/theory, 2.7): second order for ends and inner clamps, for rods that
 * are straight or curved at rest, and for rods that are bent from the start. Known answers: catalogue V01,
 * V02, V06, V09, and rods in closed form. Statics by damped motion. Lengths 1, bending modulus 1, mass 1 per
 * length. */
#include "support/near.h"

#include "hebra/scene.h"
#include "math/rotation.h"
#include "support/scenes.h"

/* Reads a scene of one rod with n edges of which `keys` says the rest, and forces; runs it until it is at
 * rest. */
static void come_to_rest(trial *t, int n, double time, const char *keys, const char *forces) {
  char text[4096];
  hb_error err = {HB_OK, ""};
  int length =
      snprintf(text, sizeof text,
               "parameters: {n: %d}\nmethod: {time_step: 0.4/n^2, duration: %g}\nrods:\n  - name: rod\n"
               "    bending: 1\n    twisting: 0.7\n    linear_density: 1\n    damping: {mass: 7}\n%s%s",
               n, time, keys, forces);
  assert_true(length > 0 && (size_t)length < sizeof text);
  if (hb_scene_parse(text, (size_t)length, "text", ".", NULL, 0, &t->def, &err))
    fail_msg("%s\n%s", err.text, text);
  trial_start(t);
  trial_run(t, hb_sim_total_steps(t->sim));
  double energy = trial_measure(t)->bending;
  assert_at_most(t->frame->kinetic, 1e-12 * (energy + 1e-6));
}

/* What to look at when the rod is at rest. */
typedef double (*look)(const trial *t);

/* One thing to look at, its exact value, what it is called. */
typedef struct aim {
  const char *name;
  look at;
  double exact;
} aim;

/* Relative errors with three numbers of edges; their order. Returns the error with the second number. */
static double converge(const aim *aims, int count, double order, const int edges[3], double time,
                       const char *keys, const char *forces) {
  double error[2][3], worst = 0;
  assert_true(count <= 2);
  for (int k = 0; k < 3; k++) {
    trial t = {0};
    come_to_rest(&t, edges[k], time, keys, forces);
    for (int a = 0; a < count; a++) error[a][k] = aims[a].at(&t) / aims[a].exact - 1;
    trial_end(&t);
  }
  for (int a = 0; a < count; a++) {
    double found = log2(fabs(error[a][1] / error[a][2]));
    say("%-34s %9.2e %9.2e %9.2e order %.2f\n", aims[a].name, error[a][0], error[a][1], error[a][2], found);
    assert_near(found, order, 0.2);
    worst = fmax(worst, fabs(error[a][1]));
  }
  return worst;
}

static const int usual[3] = {10, 20, 40};

/* Height of the last vertex. */
static double tip_height(const trial *t) { return t->frame->position[3 * (t->model->nv - 1) + 2]; }
/* How far the last vertex reaches along x. */
static double tip_reach(const trial *t) { return t->frame->position[3 * (t->model->nv - 1)]; }
/* Height of the first vertex. */
static double start_height(const trial *t) { return t->frame->position[2]; }
/* Where the first vertex is along x. */
static double start_reach(const trial *t) { return t->frame->position[0]; }
/* Height of the vertex in the middle. */
static double middle_height(const trial *t) { return t->frame->position[3 * (t->model->nv / 2) + 2]; }
/* Bending energy. */
static double bending_energy(const trial *t) { return t->frame->bending; }

#define LINE "    rest: {line: {from: [0, 0, 0], to: [1, 0, 0], vertices: n + 1}}\n"
#define TIP "forces: [{vertex: -1, point: [0, 0, 1]}]\n"

/* V02 with P L^2 = alpha, V01 with a small load: at either end, the error with 20 edges is below 0.15 %. A
 * held edge acts at its middle: first order. */
static void test_cantilever(void **state) {
  (void)state;
  const aim tip = {"cantilever", tip_height, 0.3017207737998};
  const aim small = {"cantilever, small load", tip_height, 0.0020832961321942 / 0.5};
  const aim far = {"cantilever, far end", start_height, 0.3017207737998};
  const aim held = {"cantilever, held edge", tip_height, 0.3017207737998};
  const char *start = LINE "    start: {clamp: true}\n",
             *weak = "forces: [{vertex: -1, point: [0, 0, 0.0125]}]\n";
  assert_at_most(converge(&tip, 1, 2, usual, 6, start, TIP), 1.5e-3);
  assert_at_most(converge(&small, 1, 2, usual, 6, start, weak), 1.5e-3);
  assert_at_most(converge(&far, 1, 2, usual, 6, LINE "    end: {clamp: true}\n",
                          "forces: [{vertex: 0, point: [0, 0, 1]}]\n"),
                 1.5e-3);
  assert_true(converge(&held, 1, 1, usual, 6, LINE "    start: {clamp: edge}\n", TIP) > 0.05);
}

/* Equal edges, as a list of vertices has them: the held edge counts whole, second order still. */
static void test_given_vertices(void **state) {
  (void)state;
  double error[3];
  for (int k = 0; k < 3; k++) {
    trial t = {0};
    char keys[4096] = "    rest: {vertices: [";
    for (int i = 0; i <= usual[k]; i++) {
      size_t used = strlen(keys);
      snprintf(keys + used, sizeof keys - used, "%s[%.17g, 0, 0]", i ? ", " : "", (double)i / usual[k]);
    }
    strcat(keys, "]}\n    start: {clamp: true}\n");
    come_to_rest(&t, usual[k], 6, keys, TIP);
    error[k] = tip_height(&t) / 0.3017207737998 - 1;
    assert_near_rel(t.model->rest_length[0], t.model->rest_length[1], 1e-12);
    trial_end(&t);
  }
  say("%-34s %9.2e %9.2e %9.2e order %.2f\n", "cantilever, given vertices", error[0], error[1], error[2],
      log2(error[1] / error[2]));
  assert_at_most(fabs(error[1]), 1e-2);
  assert_near(log2(error[1] / error[2]), 2, 0.2);
}

/* An inner clamp sits at the middle of its edge: two cantilevers of half the length, each with half the load.
 */
static void test_inner(void **state) {
  (void)state;
  static const int odd[3] = {21, 41, 81};
  const aim sides[2] = {{"inner clamp, right side", tip_height, 0.3017207737998 / 2},
                        {"inner clamp, left side", start_height, 0.3017207737998 / 2}};
  const char *keys = LINE "    supports: [{edge: (n - 1)/2, clamp: true}]\n";
  const char *forces = "forces: [{vertex: -1, point: [0, 0, 4]}, {vertex: 0, point: [0, 0, 4]}]\n";
  assert_at_most(converge(sides, 2, 2, odd, 6, keys, forces), 1.5e-3);
}

/* V06: between two clamps that are 0.7 apart. */
static void test_buckled(void **state) {
  (void)state;
  const aim middle = {"between two clamps", middle_height, 0.3143126129561};
  const char *keys =
      LINE "    initial: {catenary: {from: [0, 0, 0], to: [0.7, 0, 0], length: 1, down: [0, 0, 1], vertices: "
           "n + 1}}\n"
           "    start: {clamp: true, tangent: [1, 0, 0]}\n    end: {clamp: true, tangent: [1, 0, 0]}\n";
  assert_at_most(converge(&middle, 1, 2, usual, 6, keys, ""), 1e-2);
}

/* A straight rod bent to a half circle between two clamps: the circle is in equilibrium, its energy is
 * pi^2/2. The edges are held as the circle begins, half an edge before their middles. */
static void test_bent_from_the_start(void **state) {
  (void)state;
  const aim energy = {"half circle, energy", bending_energy, 0.5 * HB_PI * HB_PI};
  const char *keys = LINE "    initial: {arc: {radius: 1/pi, angle: pi, vertices: n + 1}}\n"
                          "    start: {clamp: true}\n    end: {clamp: true}\n";
  (void)converge(&energy, 1, 2, usual, 6, keys, "");
}

/* V09: curved upwards at rest, weight 10. */
static void test_curved(void **state) {
  (void)state;
  const aim aims[2] = {{"curved at rest, reach", tip_reach, 0.954720763102},
                       {"curved at rest, drop", tip_height, -0.177858797525}};
  const char *keys = "    rest: {arc: {center: [0, 0, 0.5], normal: [0, -1, 0], start: [0, 0, -1], radius: "
                     "0.5, angle: 2, vertices: n + "
                     "1}}\n    start: {clamp: true}\n";
  (void)converge(aims, 2, 2, usual, 8, keys, "gravity: [0, 0, -10]\n");
}

#define STRAIGHT "    initial: {line: {from: [0, 0, 0], to: [1, 0, 0], vertices: n + 1}}\n"

/* A rod with a natural curvature that is held straight at first and then let go: an arc that begins along x
 * at the clamp. Its first edge has to stand as the arc does half an edge behind the clamp. At either end. */
static void test_released(void **state) {
  (void)state;
  const aim start[2] = {{"natural curvature, height", tip_height, (1 - cos(2)) / 2},
                        {"natural curvature, reach", tip_reach, sin(2) / 2}};
  const aim end[2] = {{"the same from the end, height", start_height, (1 - cos(2)) / 2},
                      {"the same from the end, reach", start_reach, 1 - sin(2) / 2}};
  const char *keys = STRAIGHT "    natural_curvature: [2, 0]\n    director: [0, 0, 1]\n";
  char text[512];
  snprintf(text, sizeof text, "%s    start: {clamp: true, material_angle: 0}\n", keys);
  assert_at_most(converge(start, 2, 2, usual, 8, text, ""), 5e-3);
  snprintf(text, sizeof text, "%s    end: {clamp: true, material_angle: 0}\n", keys);
  assert_at_most(converge(end, 2, 2, usual, 8, text, ""), 5e-3);
}

/* The same rod, its frame told in other ways. */
static void test_frames_in_the_wall(void **state) {
  (void)state;
  static const char *const ways[] = {
      STRAIGHT
      "    natural_curvature: [2, 0]\n    director: [0, 0, 1]\n    start: {clamp: true, material_angle: 0}\n",
      STRAIGHT "    natural_curvature: [0, 2]\n    director: [0, 0, 1]\n    start: {clamp: true, "
               "material_angle: -pi/2}\n",
      STRAIGHT "    natural_curvature: [2, 0]\n    director: [0, 1, 0]\n    start: {clamp: true, "
               "material_frame: [0, 0, 1]}\n",
      STRAIGHT "    natural_curvature: [2, 0]\n    director: [0, 1, 0]\n"
               "    start: {clamp: true, material_frame: [0, 1, 0], material_turn: pi/2}\n"};
  double first = 0;
  for (int k = 0; k < 4; k++) {
    trial t = {0};
    come_to_rest(&t, 8, 8, ways[k], "");
    if (k == 0) first = tip_reach(&t);
    assert_near(tip_reach(&t), first, 1e-10);
    trial_end(&t);
  }
}

/* The twisted length is that between the clamps, exactly; natural twist counts over all of it. */
static void test_twist(void **state) {
  (void)state;
  trial t = {0};
  come_to_rest(
      &t, 10, 0.01,
      LINE "    start: {clamp: true, material_angle: 0}\n    end: {clamp: true, material_angle: 1.5}\n", "");
  assert_near_rel(t.frame->torque[9], 0.7 * 1.5, 1e-13);
  trial_end(&t);
  come_to_rest(&t, 10, 0.01,
               LINE "    natural_twist: 0.5\n    start: {clamp: true, material_angle: 0}\n"
                    "    end: {clamp: true, material_angle: 1.5}\n",
               "");
  assert_near_rel(t.frame->torque[9], 0.7 * (1.5 - 0.5), 1e-13);
  trial_end(&t);
}

/* Turns that a support adds at the start are counted, at whichever end they are asked for. */
static void test_windings(void **state) {
  (void)state;
  static const char *const turns[][2] = {
      {"material_frame: [0, 1, 0], material_turn: 6*pi", "material_frame: [0, 1, 0]"},
      {"material_angle: 6*pi", "material_frame: [0, 1, 0]"},
      {"material_frame: [0, 1, 0]", "material_frame: [0, 1, 0], material_turn: -6*pi"},
      {"material_frame: [0, 1, 0]", "material_angle: -6*pi"}};
  for (int k = 0; k < 8; k++) { /* closed form and Newton */
    char keys[512];
    trial t = {0};
    snprintf(keys, sizeof keys,
             LINE "    director: [0, 1, 0]\n    start: {clamp: true, %s}\n    end: {clamp: true, %s}\n%s",
             turns[k % 4][0], turns[k % 4][1], k < 4 ? "" : "    natural_curvature: [1e-9, 0]\n");
    come_to_rest(&t, 10, 0.001, keys, "");
    assert_near_rel(t.frame->torque[9], -0.7 * 6 * HB_PI, 1e-8);
    trial_end(&t);
  }
}

/* The first and the last edge are half as long as the others, whatever divides the curve; where no end is
 * clamped, or only its edge, they are not. */
static void test_division(void **state) {
  (void)state;
  static const char *const curves[] = {"{line: {to: [1, 0, 0], vertices: 8}}",
                                       "{arc: {radius: 1, angle: 2, vertices: 8}}",
                                       "{spline: {points: [[0, 0, 0], [1, 1, 0], [2, 0, 1]], vertices: 8}}",
                                       "{line: {to: [1, 0, 0], vertices: 30}, resample: 8}"};
  static const char *const clamps[] = {"start: {clamp: true}",
                                       "end: {clamp: true}",
                                       "start: {clamp: true}, end: {clamp: true}",
                                       "start: {clamp: edge}",
                                       "start: {clamp: true, tangent: free}",
                                       "end: {position: fixed}"};
  static const bool halves[][2] = {{true, false},  {false, true},  {true, true},
                                   {false, false}, {false, false}, {false, false}};
  for (size_t c = 0; c < sizeof curves / sizeof curves[0]; c++)
    for (size_t k = 0; k < sizeof clamps / sizeof clamps[0]; k++) {
      char text[1024];
      trial t = {0};
      hb_error err = {HB_OK, ""};
      int length = snprintf(
          text, sizeof text,
          "method: {time_step: 1, duration: 1}\nrods: [{rest: %s, bending: 1, twisting: 1, vertex_mass: "
          "1, %s}]\n",
          curves[c], clamps[k]);
      if (hb_scene_parse(text, (size_t)length, "text", ".", NULL, 0, &t.def, &err)) fail_msg("%s", err.text);
      trial_start(&t);
      assert_int_equal(t.model->nv, 8);
      const double *l = t.model->rest_length;
      assert_near_rel(l[0] / l[3], halves[k][0] ? 0.5 : 1, 0.06); /* chords of curves are a little shorter */
      assert_near_rel(l[6] / l[3], halves[k][1] ? 0.5 : 1, 0.06);
      assert_near_rel(t.model->voronoi[1], (halves[k][0] ? 2 : 1) * l[0] + l[1], 1e-14);
      assert_near_rel(t.model->voronoi[6], l[5] + (halves[k][1] ? 2 : 1) * l[6], 1e-14);
      trial_end(&t);
    }
}

/* Where one shape lists its vertices, both have equal edges; resampled ones are divided like all others. */
static void test_division_of_both(void **state) {
  (void)state;
  static const char *const shapes[] = {
      "rest: {line: {to: [4, 0, 0], vertices: 5}}, initial: {vertices: [[0, 0, 0], [1, 0, 0], [2, 0, 0], [3, "
      "0, 0], [4, 0, "
      "0]]}",
      "initial: {line: {to: [4, 0, 0], vertices: 5}}, rest: {vertices: [[0, 0, 0], [1, 0, 0], [2, 0, 0], [3, "
      "0, 0], [4, 0, "
      "0]]}",
      ("rest: {line: {to: [4, 0, 0], vertices: 5}}, initial: {vertices: [[0, 0, 0], [1, 0, 0], [4, 0, 0]], "
       "resample: 5}"),
      "rest: {line: {to: [4, 0, 0], vertices: 5}}, initial: {displace: [0, 0, 0]}"};
  for (int k = 0; k < 4; k++) {
    char text[1024];
    hb_scene_def def;
    hb_error err = {HB_OK, ""};
    int length =
        snprintf(text, sizeof text,
                 "method: {time_step: 1, duration: 1}\nrods: [{%s, bending: 1, twisting: 1, vertex_mass: 1, "
                 "start: {clamp: true}}]\n",
                 shapes[k]);
    if (hb_scene_parse(text, (size_t)length, "text", ".", NULL, 0, &def, &err)) fail_msg("%s", err.text);
    assert_near(def.rods[0].rest[3], k < 2 ? 1 : 4 / 7.0, 1e-12);
    assert_near_array(def.rods[0].initial, def.rods[0].rest, 15, 1e-12);
    hb_scene_def_free(&def);
  }
}

/* A definition cannot put a wall at an edge inside, nor at the wrong end. */
static void test_misplaced(void **state) {
  (void)state;
  for (int k = 0; k < 3; k++) {
    static const int edges[3] = {2, -1, 0};
    double line[15];
    hb_scene_def def;
    hb_model *model = NULL;
    hb_error err = {HB_OK, ""};
    scene_begin(&def, "verlet", 1e-3);
    shape_line(5, 1, 0, 0, line);
    hb_rod_def *rod = scene_rod(&def, 5, line, 1, 1, 1);
    scene_hold(rod, edges[k] + (k == 2));
    scene_tangent(rod, edges[k], NULL, NULL, NULL, k == 2);
    rod->supports[0].index = k == 1 ? 3 : rod->supports[0].index;
    rod->supports[1].wall = true;
    assert_int_equal(hb_model_create(&def, &model, &err), HB_ERR_INPUT);
    assert_string_equal(strstr(err.text, "only"),
                        "only the first and the last edge can be clamped at their outer vertex");
    hb_model_free(model);
    hb_scene_def_free(&def);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_cantilever),
      cmocka_unit_test(test_given_vertices),
      cmocka_unit_test(test_inner),
      cmocka_unit_test(test_buckled),
      cmocka_unit_test(test_bent_from_the_start),
      cmocka_unit_test(test_curved),
      cmocka_unit_test(test_released),
      cmocka_unit_test(test_frames_in_the_wall),
      cmocka_unit_test(test_twist),
      cmocka_unit_test(test_windings),
      cmocka_unit_test(test_division),
      cmocka_unit_test(test_division_of_both),
      cmocka_unit_test(test_misplaced),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
