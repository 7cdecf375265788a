/* The search for equilibria: balances, loads that depend on place, supports that move, starts, refusals. */
#include "hebra/scene.h"
#include "hebra/sim.h"
#include "hebra/statics.h"
#include "support/near.h"
#include "support/rods.h"

#include "base/memory.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct bench {
  hb_scene_def def;
  hb_model *model;
  hb_sim *sim;
  hb_frame *frame;
  hb_equilibrium found;
} bench;

/* Scene text to simulation. */
static void make(bench *b, const char *scene) {
  hb_error err = {HB_OK, ""};
  memset(b, 0, sizeof *b);
  if (hb_scene_parse(scene, strlen(scene), "scene.yaml", ".", NULL, 0, &b->def, &err))
    fail_msg("%s", err.text);
  if (hb_model_create(&b->def, &b->model, &err)) fail_msg("%s", err.text);
  if (hb_sim_create(b->model, &b->sim, &err)) fail_msg("%s", err.text);
  if (hb_frame_create(b->model, &b->frame, &err)) fail_msg("%s", err.text);
}

/* To the equilibrium at the end of the scene. */
static void find(bench *b, int load_steps) {
  hb_error err = {HB_OK, ""};
  hb_equilibrium_options options = hb_equilibrium_defaults(b->def.method.duration);
  options.load_steps = load_steps;
  hb_equilibrium_free(&b->found);
  if (hb_sim_find_equilibrium(b->sim, &options, &b->found, &err)) fail_msg("%s", err.text);
  hb_sim_measure_equilibrium(b->sim, &b->found, b->frame);
}

/* Frees it. */
static void unmake(bench *b) {
  hb_equilibrium_free(&b->found);
  hb_frame_free(b->frame);
  hb_sim_free(b->sim);
  hb_model_free(b->model);
  hb_scene_def_free(&b->def);
}

/* The first edge is held in place: the discrete clamp acts at its middle. */
#define CLAMPED "    start: {position: fixed, tangent: fixed, material: fixed}\n"

#define BEAM                                                                                                 \
  "method: {time_step: 1e-4, duration: 1}\n"                                                                 \
  "rods:\n"                                                                                                  \
  "  - name: beam\n"                                                                                         \
  "    rest: {line: {to: [1, 0, 0], vertices: 41}}\n"                                                        \
  "    bending: 1\n"                                                                                         \
  "    twisting: 1\n"                                                                                        \
  "    linear_density: 1\n"

/* A spring at the tip of a beam: P/(k + 3/c), c the compliance factor of the discrete beam, with clamp at its
 * middle: L^3 (1 - h^2/(4 L^2)), L = 1 - h/2. */
static void spring_at_tip(void **state) {
  (void)state;
  bench b;
  make(&b, BEAM CLAMPED "forces: [{point: [0, 0, 1e-5 - 7*z], vertex: -1}]\n");
  find(&b, 1);
  double h = 1.0 / 40, L = 1 - 0.5 * h, c = L * L * L * (1 - 0.25 * h * h / (L * L));
  assert_near_rel(b.frame->position[3 * 40 + 2], 1e-5 / (7 + 3 / c), 1e-8);
  assert_true(b.found.iterations <= 4); /* the spring is in the matrix */
  unmake(&b);
}

/* A spring that pushes away: stiffer than the beam, so that the straight beam is unstable and there is no way
 * back. A weaker one is stable. */
static void repelling_load(void **state) {
  (void)state;
  for (int strong = 0; strong < 2; strong++) {
    bench b;
    hb_error err = {HB_OK, ""};
    char scene[600];
    snprintf(scene, sizeof scene, BEAM CLAMPED "forces: [{point: [0, %g*y, %g*z], vertex: -1}]\n",
             strong ? 3.5 : 2.5, 1.0);
    make(&b, scene);
    hb_equilibrium_options options = hb_equilibrium_defaults(1);
    options.any = true;
    if (hb_sim_find_equilibrium(b.sim, &options, &b.found, &err)) fail_msg("%s", err.text);
    assert_int_equal(b.found.unstable, strong);
    unmake(&b);
  }
}

/* Supports, loads and lengths balance: forces and moments of the whole beam, tension by statics. */
static void balances(void **state) {
  (void)state;
  bench b;
  make(&b, BEAM CLAMPED "forces: [{point: [1, 2, -3], vertex: -1}, {distributed: [0, 1, 0]}]\n");
  find(&b, 1);
  double sum[3] = {0}, moment[3] = {0};
  const double *load = hb_sim_state(b.sim)->load;
  for (int k = 0; k < 41; k++) {
    const double *x = b.frame->position + 3 * k;
    double f[3];
    for (int c = 0; c < 3; c++) sum[c] += f[c] = b.frame->reaction[3 * k + c] + load[3 * k + c];
    for (int c = 0; c < 3; c++)
      moment[c] += x[(c + 1) % 3] * f[(c + 2) % 3] - x[(c + 2) % 3] * f[(c + 1) % 3];
  }
  for (int c = 0; c < 3; c++) {
    assert_near(sum[c], 0, 1e-9);
    assert_near(moment[c], 0, 1e-9);
  }
  const double *t =
      b.frame->tangent + 3 * 39; /* the last edge carries the point load and half an edge's share */
  assert_near_rel(b.frame->tension[39], t[0] * 1 + t[1] * (2 + 0.5 / 40) - t[2] * 3, 1e-9);
  assert_same(b.frame->kinetic, 0);
  unmake(&b);
}

#define MOVED                                                                                                \
  BEAM "    initial: {displace: [0, 0.02*sin(pi*u)^2, 0]}\n"                                                 \
       "    lengths: initial\n" CLAMPED                                                                      \
       "    end: {tangent: fixed, position: ['x - 0.4*t', fixed, fixed], material_angle: 0}\n"

/* Supports that move far: the same arch in one load step and in five, and from the shape of the first. */
static void supports_move(void **state) {
  (void)state;
  bench one, five;
  hb_error err = {HB_OK, ""};
  make(&one, MOVED);
  make(&five, MOVED);
  find(&one, 1);
  find(&five, 5);
  assert_near(one.frame->position[3 * 40], 0.6, 1e-15);
  assert_near_rel(one.frame->bending, five.frame->bending, 1e-9);
  assert_int_equal(one.found.unstable, 0);
  if (hb_sim_resume(five.sim, one.frame, &err)) fail_msg("%s", err.text);
  find(&five, 1);
  assert_true(five.found.iterations <= 1);
  assert_near_array(five.frame->position, one.frame->position, 3 * 41, 1e-9);
  unmake(&one);
  unmake(&five);
}

/* A twisted and curved general rod: windings come through a measured moment, closed-form rods' too. */
static void windings_resumed(void **state) {
  (void)state;
  static const char *const bending[] = {"1", "[1, 3]"};
  for (int general = 0; general < 2; general++) {
    bench b, again;
    hb_error err = {HB_OK, ""};
    char scene[600];
    snprintf(scene, sizeof scene,
             "method: {time_step: 1e-4, duration: 1}\n"
             "rods:\n"
             "  - rest: {line: {to: [1, 0, 0], vertices: 151}}\n"
             "    initial: {displace: [0, 0.02*sin(pi*u)^2, 0]}\n"
             "    lengths: initial\n"
             "    bending: %s\n"
             "    twisting: 0.02\n"
             "    linear_density: 1\n"
             "    start: {position: fixed, tangent: fixed, material_angle: 0}\n"
             "    end: {position: fixed, tangent: fixed, material_angle: 50*t}\n",
             bending[general]);
    make(&b, scene);
    make(&again, scene);
    find(&b, 4);
    assert_near_rel(b.frame->twisting_moment[75], 50 * 0.02 / (149.0 / 150), 0.02);
    if (hb_sim_resume(again.sim, b.frame, &err)) fail_msg("%s", err.text);
    find(&again, 1);
    double twist[2] = {0, 0};
    for (int k = 1; k < 150; k++) {
      twist[0] += b.frame->twist[k];
      twist[1] += again.frame->twist[k];
    }
    assert_near(twist[0], 50, 0.01); /* a little goes into writhe */
    assert_near(twist[1], twist[0], 1e-9);
    assert_near_rel(again.frame->twisting, b.frame->twisting, 1e-9);
    unmake(&b);
    unmake(&again);
  }
}

/* The smallest rod, and rods that supports leave little or nothing to do. */
static void nothing_to_do(void **state) {
  (void)state;
  static const char *const supports[] = {
      "start: {position: fixed, tangent: fixed, material: fixed}",
      "start: {position: fixed}\n    end: {position: fixed}",
      ("supports: [{vertex: 0, position: fixed}, {vertex: 1, position: fixed}, "
       "{vertex: 2, position: fixed}]")};
  for (int k = 0; k < 3; k++) {
    bench b;
    char scene[600];
    snprintf(scene, sizeof scene,
             "method: {time_step: 1e-4, duration: 0}\n"
             "gravity: [0, 0, -10]\n"
             "rods:\n"
             "  - rest: {vertices: [[0, 0, 0], [0.5, 0, -0.1], [1, 0, 0]]}\n"
             "    bending: 0.2\n"
             "    twisting: 1\n"
             "    linear_density: 1\n"
             "    %s\n",
             supports[k]);
    make(&b, scene);
    find(&b, 1);
    assert_int_equal(b.found.unstable, 0);
    double sum = 0, length = hypot(0.5, 0.1);
    for (int i = 0; i < 3; i++) sum += b.frame->reaction[3 * i + 2];
    assert_near_rel(sum, 10 * 2 * length, 1e-9);
    unmake(&b);
  }
}

/* Two rods in one scene are solved as each would be alone. */
static void several_rods(void **state) {
  (void)state;
  static const char *const rods[] = {"  - name: first\n"
                                     "    rest: {line: {to: [1, 0, 0], vertices: 21}}\n"
                                     "    bending: 1\n"
                                     "    twisting: 1\n"
                                     "    linear_density: 1\n" CLAMPED,
                                     "  - name: second\n"
                                     "    rest: {helix: {radius: 0.1, pitch: 0.1, turns: 2, vertices: 41}}\n"
                                     "    bending: [0.1, 0.2]\n"
                                     "    twisting: 0.1\n"
                                     "    linear_density: 1\n" CLAMPED};
  bench together, alone;
  char scene[1200];
  static const char head[] = "method: {time_step: 1e-4, duration: 1}\ngravity: [0, 0, -3]\nrods:\n";
  snprintf(scene, sizeof scene, "%s%s%s", head, rods[0], rods[1]);
  make(&together, scene);
  find(&together, 1);
  double elastic = 0;
  for (int k = 0; k < 2; k++) {
    snprintf(scene, sizeof scene, "%s%s", head, rods[k]);
    make(&alone, scene);
    find(&alone, 1);
    int first = together.model->rods[k].first, nv = together.model->rods[k].nv;
    assert_near_array(together.frame->position + 3 * first, alone.frame->position, 3 * nv, 1e-12);
    assert_near_array(together.frame->tension + first, alone.frame->tension, nv, 1e-9);
    elastic += alone.found.elastic;
    unmake(&alone);
  }
  assert_near_rel(together.found.elastic, elastic, 1e-12);
  assert_near_rel(together.found.elastic, together.frame->bending + together.frame->twisting, 1e-12);
  unmake(&together);
}

/* A random rod of any kind, far from rest, its first edge clamped, under a load at its tip that bends it by a
 * radian or so. */
static void random_cantilever(rng *r, int trial, rod_case *c) {
  hb_error err = {HB_OK, ""};
  rod_case_random(c, r, (rod_family)(trial % ROD_FAMILY_COUNT), ROD_FREE_FREE, 0);
  hb_rod_def *rod = &c->def.rods[0];
  rod_hold_vertex(rod, 0);
  rod_hold_vertex(rod, 1);
  rod_hold_angle(rod, 0, "0");
  c->def.method.time_step = 1e-3;
  c->def.method.duration = 1;
  c->def.forces = hb_alloc(1, sizeof *c->def.forces);
  assert_non_null(c->def.forces);
  c->def.force_count = 1;
  hb_force_def_init(c->def.forces);
  c->def.forces[0].kind = HB_FORCE_POINT;
  c->def.forces[0].vertex = -1;
  double d[3], length = 0;
  for (int k = 3; k < 3 * rod->nv; k += 3)
    length += hypot(hypot(rod->rest[k] - rod->rest[k - 3], rod->rest[k + 1] - rod->rest[k - 2]),
                    rod->rest[k + 2] - rod->rest[k - 1]);
  double size = rng_uniform(r, 0, 4) * rod->B[0] / (length * length);
  rng_direction(r, d);
  for (int k = 0; k < 3; k++)
    if (hb_formula_constant(size * d[k], &c->def.forces[0].value[k], &err)) fail_msg("%s", err.text);
}

/* Every random rod comes to a stable rest. */
static void random_rods(void **state) {
  (void)state;
  rng r = rng_start(7);
  int iterations = 0;
  for (int trial = 0; trial < 200; trial++) {
    rod_case c;
    bench b;
    hb_error err = {HB_OK, ""};
    memset(&b, 0, sizeof b);
    random_cantilever(&r, trial, &c);
    if (hb_model_create(&c.def, &b.model, &err) || hb_sim_create(b.model, &b.sim, &err))
      fail_msg("%s", err.text);
    hb_equilibrium_options options = hb_equilibrium_defaults(1);
    if (hb_sim_find_equilibrium(b.sim, &options, &b.found, &err)) fail_msg("trial %d: %s", trial, err.text);
    assert_int_equal(b.found.unstable, 0);
    assert_at_most(b.found.residual, 1e-9 * b.found.force_scale);
    iterations += b.found.iterations;
    hb_equilibrium_free(&b.found);
    hb_sim_free(b.sim);
    hb_model_free(b.model);
    rod_case_free(&c);
  }
  if (getenv("HEBRA_TEST_VERBOSE")) printf("%.1f iterations per rod\n", iterations / 200.0);
}

/* What statics cannot do, it says. */
static void refusals(void **state) {
  (void)state;
  static const struct {
    const char *scene, *sentence;
    hb_status status;
  } cases[] = {{BEAM CLAMPED "forces:\n  - {point: [0, 0, 1], vertex: -1, follower: true}\n",
                ":10:5: a load that turns with the rod (follower) has no potential", HB_ERR_INPUT},
               {BEAM CLAMPED "forces:\n  - wind: {velocity: [0, 0, 1], linear: {normal: 1, "
                             "tangential: 1}}\n",
                ": wind has no potential", HB_ERR_INPUT},
               {BEAM "forces:\n  - {point: [0, 0, 1], vertex: -1}\n",
                "rod beam: no support holds a vertex against the loads", HB_ERR_INPUT},
               {BEAM CLAMPED "forces:\n  - {point: [0, 0, log(-t)], vertex: -1}\n",
                "rod beam: a load is not finite", HB_ERR_NUMERIC},
               {BEAM "    start: {position: fixed}\nforces:\n  - {point: [0, 1 + y, 0], vertex: -1}\n",
                "rod beam: no equilibrium", HB_ERR_NUMERIC}};
  for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
    bench b;
    hb_error err = {HB_OK, ""};
    make(&b, cases[k].scene);
    hb_equilibrium_options options = hb_equilibrium_defaults(0);
    options.max_iterations = k == 4 ? 3 : 100;
    assert_int_equal(hb_sim_find_equilibrium(b.sim, &options, &b.found, &err), cases[k].status);
    if (!strstr(err.text, cases[k].sentence))
      fail_msg("\"%s\" does not say \"%s\"", err.text, cases[k].sentence);
    unmake(&b);
  }
}

/* Options out of range. */
static void wrong_options(void **state) {
  (void)state;
  bench b;
  make(&b, BEAM CLAMPED);
  for (int k = 0; k < 4; k++) {
    hb_error err = {HB_OK, ""};
    hb_equilibrium_options options = hb_equilibrium_defaults(k == 0 ? -1 : 0);
    if (k == 1) options.load_steps = 0;
    if (k == 2) options.max_iterations = 0;
    if (k == 3) options.tolerance = 0;
    assert_int_equal(hb_sim_find_equilibrium(b.sim, &options, &b.found, &err), HB_ERR_INPUT);
    assert_true(strlen(err.text) > 20);
  }
  unmake(&b);
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(spring_at_tip),    cmocka_unit_test(repelling_load),
                                     cmocka_unit_test(balances),         cmocka_unit_test(supports_move),
                                     cmocka_unit_test(windings_resumed), cmocka_unit_test(nothing_to_do),
                                     cmocka_unit_test(several_rods),     cmocka_unit_test(random_rods),
                                     cmocka_unit_test(refusals),         cmocka_unit_test(wrong_options)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
