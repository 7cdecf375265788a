/* Every allocation of the scene reader may fail: a sentence, nothing left behind. */
#include "hebra/scene.h"
#include "support/failing_alloc.h"
#include "support/near.h"

#include <string.h>

/* A scene that goes through every section reader. */
static const char scene[] =
    "title: everything\n"
    "description: text\n"
    "units: SI\n"
    "parameters: {n: 5, m: 2*n}\n"
    "method: {integrator: symplectic-euler, time_step: 1e-3, duration: 1, length_tolerance: {absolute: "
    "1e-2}}\n"
    "gravity: [0, 0, -9.81]\n"
    "rods:\n"
    "  - &first\n"
    "    name: a\n"
    "    rest: {helix: {radius: 1, pitch: 0.3, turns: 1, vertices: n}, scale: 2, rotate: {axis: [1, 0, 0], "
    "angle: 1}, move: "
    "[1, 2, 3]}\n"
    "    initial: {displace: [0.1*sin(u), 0, 0.01*z], perturb: {vertex: 2, by: [0, 0, 0.1]}}\n"
    "    velocity: [1, sin(s), x*y]\n"
    "    bending: {B: [1 + u, 0.1, 2], angle: s}\n"
    "    twisting: 1 + i/L\n"
    "    linear_density: 1 + u\n"
    "    natural_twist: 0.3\n"
    "    rest_director: [0, 0, 1]\n"
    "    damping: {mass: 0.1, bending: 0.01*u}\n"
    "    start: {position: [x, 'y + 0.1*t', fixed], tangent: [0, 1, t], material_frame: [0, 0, 1], "
    "material_turn: t}\n"
    "    supports: [{vertex: 3, position: fixed}, {edge: -1, material_angle: sin(t)}]\n"
    "  - {rest: {arc: {radius: 1, angle: pi, vertices: 5}}, section: {rectangle: {width: 0.1, height: 0.2}, "
    "angle: u}, E: 1e9,\n"
    "     G: 1e8, density: 1e3, natural_curvature: [1, 0.5*u], natural_twist: 3}\n"
    "  - {rest: {spline: {points: [[0, 0, 5], [1, 1, 5], [2, 0, 5]], vertices: 4}}, bending: 1, twisting: 1, "
    "vertex_mass: 1,\n"
    "     rest_directors: [[0, 0, 1], [0, 0, 1], [0, 0, 1]]}\n"
    "  - {rest: {catenary: {to: [1, 0, 0], length: 2, vertices: 4}, resample: 5}, lengths: initial, bending: "
    "1, twisting: 0,\n"
    "     vertex_mass: 1}\n"
    "  - {initial: {vertices: [[0, 0, 0], [1, 0, 0], [0, 1, 0]], perturb: {vertex: 0, by: [0, 0, 1]}}, "
    "closed: {turns: "
    "1}, bending: 1,\n"
    "     twisting: 1, vertex_mass: 1, rest_director: [0, 0, 1]}\n"
    "  - {rest: {formula: {x: s, y: 0, z: s^2, vertices: 3}}, bending: 1, twisting: 0, vertex_mass: 1}\n"
    "  - {name: c, copies: 2, rest: {line: {to: [0, 1 + k, 'noise(k, K)'], vertices: 3}}, bending: 1, "
    "twisting: 0, "
    "vertex_mass: 1}\n"
    "forces:\n"
    "  - {point: [0, 0, t], rod: a, vertex: -1, follower: true}\n"
    "  - {wind: {velocity: [1, 0, 0], drag: {density: 1.2}}, rod: c}\n"
    "output: {every: 5}\n";

static const char *const overrides[] = {"rods.a.radius=0.2", "rods[*].damping.mass=0.3",
                                        "forces[2]={per_vertex: [0, 0, 1]}"};

/* Reads and frees. */
static hb_status trial(void *context, hb_error *err) {
  int count = *(int *)context;
  hb_scene_def def;
  hb_status status = hb_scene_parse(scene, strlen(scene), "scene.yaml", ".", overrides, count, &def, err);
  if (!status) hb_scene_def_free(&def);
  return status;
}

/* The text alone. */
static void reading_survives(void **state) {
  (void)state;
  int count = 0;
  failing_alloc_loop(trial, &count, 1);
}

/* With overrides and the text made anew. */
static void overriding_survives(void **state) {
  (void)state;
  int count = 3;
  failing_alloc_loop(trial, &count, 1);
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(reading_survives),
                                     cmocka_unit_test(overriding_survives)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
