/* Internal forces and moments, torsion: against the statics of what lies beyond a cut, and against helices
 * and the elastica. */
#include "support/solved.h"

#include "math/rotation.h"

#include <stdio.h>
#include <stdlib.h>

/* Prints if the tests are asked to be talkative. */
#define say(...)                                                                                             \
  do {                                                                                                       \
    if (getenv("HEBRA_TEST_VERBOSE")) print_message(__VA_ARGS__);                                            \
  } while (0)

/* Solves a scene given as text at time 1. */
static void solve_text(solved *s, const char *text) {
  hb_error err = {HB_OK, ""};
  memset(s, 0, sizeof *s);
  if (hb_scene_parse(text, strlen(text), "scene", ".", NULL, 0, &s->def, &err) ||
      hb_model_create(&s->def, &s->model, &err) || hb_sim_create(s->model, &s->sim, &err) ||
      hb_frame_create(s->model, &s->frame, &err))
    fail_msg("%s", err.text);
  hb_equilibrium_options options = hb_equilibrium_defaults(1);
  options.load_steps = 4;
  if (hb_sim_find_equilibrium(s->sim, &options, &s->found, &err)) fail_msg("%s", err.text);
  hb_sim_measure_equilibrium(s->sim, &s->found, s->frame);
}

/* Cut between two vertices, or at a vertex: what the loads and supports beyond do is what the rod bears. */
static void check_cuts(const solved *s, double tolerance) {
  int nv = s->model->nv;
  const double *load = hb_sim_const_state(s->sim)->load, *x = s->frame->position;
  double scale = 0, moment_scale = 0, worst = 0, worst_moment = 0;
  hb_v3 force = {0, 0, 0}, about_origin = {0, 0, 0};
  for (int k = nv - 1; k > 0; k--) {
    hb_v3 f = hb_v3_add(hb_v3_load(load + 3 * k), hb_v3_load(s->frame->reaction + 3 * k));
    hb_v3 at = hb_v3_load(x + 3 * k), t = hb_v3_load(s->frame->tangent + 3 * k - 3);
    if (k < nv - 1) { /* the moment at this vertex, of what lies beyond it; that of its own force is none */
      hb_v3 expected = hb_v3_sub(about_origin, hb_v3_cross(at, force));
      hb_v3 off = hb_v3_sub(expected, hb_v3_load(s->frame->internal_moment + 3 * k));
      worst_moment = fmax(worst_moment, hb_v3_norm(off));
      moment_scale = fmax(moment_scale, hb_v3_norm(expected));
    }
    force = hb_v3_add(force, f);
    about_origin = hb_v3_add(about_origin, hb_v3_cross(at, f));
    /* the couple of a held frame acts on the edge before this vertex */
    about_origin = hb_v3_axpy(about_origin, s->frame->torque[k - 1], t);
    worst = fmax(worst, hb_v3_norm(hb_v3_sub(force, hb_v3_load(s->frame->internal_force + 3 * k - 3))));
    scale = fmax(scale, hb_v3_norm(force));
  }
  say("cuts: forces to %.1e of %.3g, moments to %.1e of %.3g\n", worst, scale, worst_moment, moment_scale);
  assert_true(scale > 1 && moment_scale > 0.1);
  assert_at_most(worst, tolerance * scale);
  assert_at_most(worst_moment, tolerance * moment_scale);
}

#define HEAD "method: {time_step: 1e-3, duration: 1}\n"
#define LOADS "forces: [{point: [1, 2, -3], vertex: -1}, {distributed: [0, 1, 0.5]}]\n"

/* Isotropic, straight at rest and loaded at its tip; twisted between clamps; anisotropic and curved at rest,
 * with one clamp and with two. */
static void cuts(void **state) {
  (void)state;
  static const char *const scenes[] = {
      HEAD "rods:\n  - rest: {line: {to: [1, 0, 0], vertices: 31}}\n    bending: 1\n    twisting: 0.7\n"
           "    linear_density: 1\n    start: {clamp: true}\n" LOADS,
      HEAD "rods:\n  - rest: {line: {to: [1, 0, 0], vertices: 31}}\n    bending: 1\n    twisting: 0.7\n"
           "    initial: {displace: [0, 0.1*sin(pi*u)^2, 0]}\n    lengths: initial\n"
           "    linear_density: 1\n    start: {clamp: true}\n"
           "    end: {position: fixed, tangent: fixed, material_angle: 2*t}\n" LOADS,
      HEAD
      "rods:\n  - rest: {helix: {radius: 0.2, pitch: 0.3, turns: 1.3, vertices: 41}}\n"
      "    bending: [1, 2.5]\n    twisting: 0.7\n    linear_density: 1\n    start: {clamp: true}\n" LOADS,
      HEAD "rods:\n  - rest: {helix: {radius: 0.2, pitch: 0.3, turns: 1.3, vertices: 41}}\n"
           "    bending: [1, 2.5]\n    twisting: 0.7\n    linear_density: 1\n    start: {clamp: true}\n"
           "    stretching: 200\n    inextensible: false\n" LOADS,
      HEAD "rods:\n  - rest: {helix: {radius: 0.2, pitch: 0.3, turns: 1.3, vertices: 41}}\n"
           "    bending: [1, 2.5]\n    twisting: 0.7\n    linear_density: 1\n    start: {clamp: true}\n"
           "    end: {position: fixed, tangent: fixed, material_angle: 0.8*t}\n" LOADS};
  for (size_t k = 0; k < sizeof scenes / sizeof scenes[0]; k++) {
    solved s;
    solve_text(&s, scenes[k]);
    check_cuts(&s, 1e-8);
    solved_end(&s);
  }
}

/* Curvature r/(r^2+c^2) and torsion c/(r^2+c^2) of a helix of pitch 2 pi c, right- and left-handed; the
 * errors fall with the square of the edges. */
static void helices(void **state) {
  (void)state;
  for (int left = 0; left < 2; left++) {
    double error[2][2], r = 0.3, pitch = left ? -0.8 : 0.8, c = pitch / (2 * HB_PI), below = r * r + c * c;
    for (int fine = 0; fine < 2; fine++) {
      char text[500];
      hb_error err = {HB_OK, ""};
      solved s;
      memset(&s, 0, sizeof s);
      snprintf(text, sizeof text,
               HEAD "rods:\n  - rest: {helix: {radius: %g, pitch: %g, turns: 2, vertices: %d}}\n"
                    "    bending: 1\n    twisting: 1\n    linear_density: 1\n",
               r, pitch, fine ? 161 : 81);
      if (hb_scene_parse(text, strlen(text), "scene", ".", NULL, 0, &s.def, &err) ||
          hb_model_create(&s.def, &s.model, &err) || hb_sim_create(s.model, &s.sim, &err) ||
          hb_frame_create(s.model, &s.frame, &err))
        fail_msg("%s", err.text);
      hb_sim_measure(s.sim, s.frame);
      error[fine][0] = s.frame->curvature[30] * below / r - 1;
      error[fine][1] = s.frame->torsion[30] * below / c - 1;
      assert_near_rel(s.frame->torsion[31], s.frame->torsion[30], 1e-9); /* the same everywhere */
      assert_near(s.frame->torsion[0], 0, 0);                            /* no binormal at the ends */
      assert_near(s.frame->internal_moment[90], 0, 1e-12);               /* at rest */
      solved_end(&s);
    }
    for (int k = 0; k < 2; k++) {
      say("helix: errors %.2e, %.2e\n", error[0][k], error[1][k]);
      assert_at_most(fabs(error[1][k]), 1e-3);
      assert_near_rel(error[0][k] / error[1][k], 4, 0.02);
    }
  }
}

/* The buckled strut: its clamp bears the load times the amplitude. */
static void elastica(void **state) {
  (void)state;
  double expected = 1.151719620469 * 2.4674011002723 * 2 * 0.2966038230824, error[2];
  for (int fine = 0; fine < 2; fine++) {
    solved s;
    char a[80];
    solved_begin(&s, "strut", false, solved_set(a, "parameters.n", fine ? 201 : 101), NULL);
    /* half an edge from the clamp, where the moment has hardly changed: it is even there */
    error[fine] = s.frame->bending_moment[1] / expected - 1;
    hb_v3 force = hb_v3_load(s.frame->internal_force + 150);
    say("strut: moment at the clamp off by %.2e\n", error[fine]);
    assert_near_rel(hb_v3_norm(force), 1.151719620469 * 2.4674011002723, 1e-9); /* everywhere the load */
    solved_end(&s);
  }
  assert_at_most(fabs(error[1]), 5e-5);
  assert_near_rel(error[0] / error[1], (199.5 / 99.5) * (199.5 / 99.5), 0.02);
}

/* All of it. */
int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(cuts), cmocka_unit_test(helices),
                                     cmocka_unit_test(elastica)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
