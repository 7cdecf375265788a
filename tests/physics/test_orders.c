/* Order of convergence of the integrators: positions, velocities and the energy balance of smooth runs at one time, with
 * the step halved again and again. The differences between neighbouring steps shrink by 2 for order one, by 4 for two. */
#include "support/near.h"

#include "support/scenes.h"

#define NV 9
#define EDGE 0.125
#define MASS 0.125
#define LEVELS 5

/* Free rod: bent and moving. */
static void free_rod(hb_scene_def *def) {
  double xyz[3 * NV], line[3 * NV], v[3 * NV];
  shape_line(NV, 1, 0, 0, line);
  shape_bent(NV, EDGE, (double[]){0.5, 0.3, 0.2, 0.1}, xyz);
  hb_rod_def *rod = scene_rod(def, NV, line, 0.05, 0.05, MASS);
  scene_initial(rod, xyz);
  for (int i = 0; i < NV; i++) {
    double s = (double)i / (NV - 1);
    v[3 * i] = 0.1;
    v[3 * i + 1] = 0.3 * s * s;
    v[3 * i + 2] = 0.4 * s - 0.1;
  }
  scene_velocity(rod, v);
}

/* Cantilever under gravity. */
static void cantilever(hb_scene_def *def) {
  double line[3 * NV];
  shape_line(NV, 1, 0, 0, line);
  hb_rod_def *rod = scene_rod(def, NV, line, 0.05, 0.05, MASS);
  scene_clamp_start(rod);
  scene_force(def, HB_FORCE_GRAVITY, "0", "0.1", "-0.5");
}

/* Both ends clamped, the far end turning in time. */
static void twisted(hb_scene_def *def) {
  double xyz[3 * NV], line[3 * NV];
  shape_line(NV, 1, 0, 0, line);
  shape_bent(NV, EDGE, (double[]){0.6, -0.4, 0.3, 0}, xyz);
  hb_rod_def *rod = scene_rod(def, NV, line, 0.05, 0.03, MASS);
  scene_initial(rod, xyz);
  scene_clamp_start(rod);
  scene_hold(rod, NV - 1);
  scene_hold(rod, NV - 2);
  scene_angle(rod, -1, "4*t^2 + 1");
}

/* Curved at rest, anisotropic, clamped, gravity. */
static void anisotropic(hb_scene_def *def) {
  double xyz[3 * NV];
  shape_bent(NV, EDGE, (double[]){0.5, 0.8, 0.4, 0.3}, xyz);
  hb_rod_def *rod = scene_rod(def, NV, xyz, 0.05, 0.03, MASS);
  scene_form(rod, 0.06, 0.01, 0.02);
  scene_clamp_start(rod);
  scene_angle(rod, -1, "0.5*sin(2*t)");
  scene_force(def, HB_FORCE_GRAVITY, "0", "0.2", "-0.4");
}

/* Wind, linear and quadratic, and mass damping; moving from the start. */
static void windy(hb_scene_def *def) {
  cantilever(def);
  def->rods[0].mass_damping = 0.7;
  hb_force_def *wind = scene_force(def, HB_FORCE_WIND, "0.1", "0.8*cos(t)", "0.2*x");
  wind->linear[0] = 0.3;
  wind->linear[1] = 0.1;
  wind->quadratic[0] = 0.4;
  wind->quadratic[1] = 0.05;
}

/* Bending viscosity, from rest. */
static void viscous(hb_scene_def *def) {
  cantilever(def);
  scene_viscosity(&def->rods[0], 0.002);
}

/* Bending viscosity on an anisotropic free rod that moves from the start. */
static void viscous_moving(hb_scene_def *def) {
  free_rod(def);
  scene_form(&def->rods[0], 0.06, 0, 0.03);
  scene_viscosity(&def->rods[0], 0.005);
}

/* A clamp that is carried along and turned. */
static void moving_clamp(hb_scene_def *def) {
  double line[3 * NV];
  shape_line(NV, 1, 0, 0, line);
  hb_rod_def *rod = scene_rod(def, NV, line, 0.05, 0.03, MASS);
  scene_path(rod, 0, "0.1*sin(2*t)", "0.2*t^2", NULL);
  scene_tangent(rod, 0, "cos(0.6*t)", "sin(0.6*t)", "0.2*t", false);
  scene_angle(rod, 0, "2*t");
}

/* Both edges guided, the far one by its end vertex, twisted by directors that turn in space. */
static void guided_ends(hb_scene_def *def) {
  double xyz[3 * NV], line[3 * NV];
  shape_line(NV, 1, 0, 0, line);
  shape_bent(NV, EDGE, (double[]){0.6, -0.3, 0.2, 0.1}, xyz);
  hb_rod_def *rod = scene_rod(def, NV, line, 0.05, 0.03, MASS);
  scene_initial(rod, xyz);
  scene_path(rod, -1, NULL, NULL, "z + 0.1*sin(t)");
  scene_tangent(rod, -1, "0.98640", "0.3*t - 0.16344", "0.2*sin(t) + 0.01721", true); /* as it starts */
  scene_hold(rod, 0);
  scene_director(rod, 0, "0", "cos(0.5*t)", "sin(0.5*t)", "0.2*t");
  scene_director(rod, -1, "0", "cos(0.8*t)", "-sin(0.8*t)", NULL);
}

/* Loads of every kind, with place and time, dead and following. */
static void loaded(hb_scene_def *def) {
  cantilever(def);
  scene_force(def, HB_FORCE_POINT, "0", "0.2*sin(3*t)", "0.1")->vertex = -1;
  scene_force(def, HB_FORCE_DISTRIBUTED, "0.1", "0.3*s*x", "0.1*cos(t) + z");
  scene_force(def, HB_FORCE_PER_VERTEX, "0", "0.05", "0.02*u")->follower = true;
}

/* State of a run at the end, and the energy balance there. */
typedef struct finish {
  double x[3 * NV], v[3 * NV], balance, length_error;
} finish;

static finish run_to(scene_builder build, const char *integrator, double time, long steps) {
  trial t = {0};
  finish out;
  trial_build(&t, build, integrator, time / (double)steps);
  trial_run(&t, steps);
  const hb_frame *frame = trial_measure(&t);
  memcpy(out.x, frame->position, sizeof out.x);
  memcpy(out.v, frame->velocity, sizeof out.v);
  out.balance = frame->balance;
  out.length_error = frame->worst_length_error;
  trial_end(&t);
  return out;
}

/* Orders of positions, velocities and balance on the finest steps, against what is claimed. Returns the end of the
 * finest run with what is left of the leading error taken out of the positions. */
static finish check_order(scene_builder build, const char *name, const char *integrator, double claimed, long steps) {
  finish runs[LEVELS];
  for (int k = 0; k < LEVELS; k++) {
    runs[k] = run_to(build, integrator, 1.0, steps << k);
    assert_at_most(runs[k].length_error, 1e-10);
  }
  double dx[LEVELS], dv[LEVELS], db[LEVELS];
  for (int k = 1; k < LEVELS; k++) {
    dx[k] = largest_difference(runs[k - 1].x, runs[k].x, 3 * NV);
    dv[k] = largest_difference(runs[k - 1].v, runs[k].v, 3 * NV);
    db[k] = fabs(runs[k].balance);
  }
  double x = log2(dx[LEVELS - 2] / dx[LEVELS - 1]), v = log2(dv[LEVELS - 2] / dv[LEVELS - 1]),
         b = log2(db[LEVELS - 2] / db[LEVELS - 1]);
  say("%-15s %-17s x %.3f (%.1e) v %.3f (%.1e) balance %.3f (%.1e)\n", name, integrator, x, dx[LEVELS - 1], v,
      dv[LEVELS - 1], b, db[LEVELS - 1]);
  assert_near(x, claimed, 0.1);
  assert_near(v, claimed, 0.1);
  assert_near(b, claimed, 0.15);
  finish end = runs[LEVELS - 1];
  for (int k = 0; k < 3 * NV; k++) end.x[k] += (end.x[k] - runs[LEVELS - 2].x[k]) / (exp2(claimed) - 1);
  return end;
}

/* Both schemes, from so many steps on; they must come to the same end. */
static void check_both(scene_builder build, const char *name, long steps) {
  finish euler = check_order(build, name, "symplectic-euler", 1, steps);
  finish verlet = check_order(build, name, "verlet", 2, steps);
  assert_near_array(euler.x, verlet.x, 3 * NV, 2e-6);
  say("  limits agree to %.1e\n", largest_difference(euler.x, verlet.x, 3 * NV));
}

#define CASE(name, steps)                                                                                     \
  static void test_##name(void **state) {                                                                     \
    (void)state;                                                                                              \
    check_both(name, #name, steps);                                                                           \
  }
CASE(free_rod, 400)
CASE(cantilever, 400)
CASE(twisted, 400)
CASE(anisotropic, 400)
CASE(windy, 400)
CASE(viscous, 400)
CASE(viscous_moving, 400)
CASE(moving_clamp, 800)
CASE(guided_ends, 800)
CASE(loaded, 400)

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_free_rod),        cmocka_unit_test(test_cantilever),  cmocka_unit_test(test_twisted),
      cmocka_unit_test(test_anisotropic),     cmocka_unit_test(test_windy),       cmocka_unit_test(test_viscous),
      cmocka_unit_test(test_viscous_moving),  cmocka_unit_test(test_moving_clamp), cmocka_unit_test(test_guided_ends),
      cmocka_unit_test(test_loaded),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
