/* Boundary conditions (A7 of the mission): every combination at both ends, in the middle, moving, turning,
 * winding. What is prescribed is met, what is free feels no support, and the energy balance closes with the
 * supports' work in it. */
#include "support/near.h"

#include "support/scenes.h"

#define NV 9
#define EDGE 0.125
#define PI 3.14159265358979323846

/* What can be asked of the place of an end, and of its frame. */
enum { FREE, AXIS, POINT, CLAMP, MOVING, PLACES };
enum { NO_FRAME, KEPT, ANGLE, DIRECTOR, FRAMES };

/* One end of the rod. */
static void support_end(hb_rod_def *rod, bool end, int place, int frame) {
  int vertex = end ? -1 : 0, edge = end ? -1 : 0;
  const double *x = rod->initial + (end ? 3 * (rod->nv - 1) : 0), *y = end ? x - 3 : x + 3;
  char d[3][64];
  if (place == AXIS) scene_path(rod, vertex, "free", NULL, "free");
  if (place == POINT || place == CLAMP) scene_hold(rod, vertex);
  if (place == CLAMP) scene_tangent(rod, edge, NULL, NULL, NULL, end);
  if (place == MOVING) {
    scene_path(rod, vertex, end ? "x - 0.03*t^2" : "x + 0.02*sin(t)", NULL, "z + 0.02*t^2");
    for (int c = 0; c < 3; c++)
      snprintf(d[c], sizeof d[c], "%.17g + %g*t", (end ? x[c] - y[c] : y[c] - x[c]) / EDGE, 0.1 * c);
    scene_tangent(rod, edge, d[0], d[1], d[2], end);
  }
  if (frame == KEPT) scene_angle(rod, edge, NULL);
  if (frame == ANGLE) scene_angle(rod, edge, end ? "0.4 - 0.5*t" : "0.6*t");
  if (frame == DIRECTOR) scene_director(rod, edge, "0.3*t", "0.2", "1", end ? "0.3*t" : NULL);
}

/* What the end should look like now, and that nothing else is supported. */
static void check_end(const trial *t, bool end, int place, int frame, double time, const hb_frame *start) {
  const hb_frame *f = t->frame;
  int v = end ? NV - 1 : 0, carried = end ? NV - 2 : 1, e = end ? NV - 2 : 0;
  const double *x = f->position + 3 * v, *x0 = t->model->initial + 3 * v, *r = f->reaction + 3 * v;
  if (place == FREE)
    for (int c = 0; c < 3; c++) assert_same(r[c], 0);
  if (place == AXIS) {
    assert_same(x[1], x0[1]);
    assert_same(r[0], 0);
    assert_same(r[2], 0);
  }
  if (place == POINT || place == CLAMP)
    for (int c = 0; c < 3; c++) assert_same(x[c], x0[c]);
  if (place == CLAMP)
    for (int c = 0; c < 3; c++) assert_near(f->tangent[3 * e + c], start->tangent[3 * e + c], 1e-14);
  if (place < CLAMP)
    for (int c = 0; c < 3; c++) assert_same(f->reaction[3 * carried + c], 0);
  if (place == MOVING) {
    assert_near(x[0], x0[0] + (end ? -0.03 * time * time : 0.02 * sin(time)), 1e-15);
    assert_near(x[2], x0[2] + 0.02 * time * time, 1e-15);
    double d[3], n = 0;
    for (int c = 0; c < 3; c++) {
      d[c] = start->tangent[3 * e + c] + 0.1 * c * time;
      n += d[c] * d[c];
    }
    for (int c = 0; c < 3; c++) assert_near(f->tangent[3 * e + c], d[c] / sqrt(n), 1e-12);
  }
  if (frame == NO_FRAME) assert_same(f->torque[e], 0);
  if (frame == DIRECTOR) { /* m1 turned back by the extra angle lies in the plane of the tangent and what is
                              asked for */
    const double want[3] = {0.3 * time, 0.2, 1}, *m1 = f->m1 + 3 * e, *m2 = f->m2 + 3 * e;
    double a = end ? 0.3 * time : 0, along = 0, across = 0;
    for (int c = 0; c < 3; c++) {
      along += want[c] * (cos(a) * m1[c] - sin(a) * m2[c]);
      across += want[c] * (sin(a) * m1[c] + cos(a) * m2[c]);
    }
    assert_near(across, 0, 1e-12);
    assert_true(along > 0);
  }
}

/* Balance at the end of one combination; everything checked on the way. kind: straight and isotropic, or
 * neither. */
static double run_combination(const int place[2], const int frame[2], bool general, const char *integrator,
                              double h) {
  trial t = {0};
  double xyz[3 * NV], line[3 * NV], time = 0.2;
  shape_line(NV, EDGE * (NV - 1), 0, 0, line);
  shape_bent(NV, EDGE, (double[]){0.6, -0.3, 0.2, 0.1}, xyz);
  scene_begin(&t.def, integrator, h);
  hb_rod_def *rod = scene_rod(&t.def, NV, general ? xyz : line, 0.05, 0.03, 0.125);
  if (general) scene_form(rod, 0.05, 0.01, 0.03);
  scene_initial(rod, xyz);
  scene_force(&t.def, HB_FORCE_GRAVITY, "0", "0.1", "-0.4");
  support_end(rod, false, place[0], frame[0]);
  support_end(rod, true, place[1], frame[1]);
  trial_start(&t);
  hb_frame *start = NULL;
  assert_int_equal(hb_frame_create(t.model, &start, NULL), HB_OK);
  hb_sim_measure(t.sim, start);
  trial_run(&t, lrint(time / h));
  const hb_frame *f = trial_measure(&t);
  for (int end = 0; end < 2; end++) check_end(&t, end, place[end], frame[end], time, start);
  assert_at_most(f->worst_length_error, 1e-10);
  double balance = f->balance;
  hb_frame_free(start);
  trial_end(&t);
  return balance;
}

/* 20 ways to support each end, straight and curved rods, both schemes: 1600 cases. The energy balance, with
 * the work of the supports in it, closes at the order of the scheme. */
static void test_every_combination(void **state) {
  (void)state;
  double worst[2] = {0, 0}, low[2] = {100, 100}, high[2] = {0, 0};
  for (int k = 0; k < PLACES * PLACES * FRAMES * FRAMES * 4; k++) {
    int place[2] = {k % PLACES, k / PLACES % PLACES}, rest = k / (PLACES * PLACES);
    int frame[2] = {rest % FRAMES, rest / FRAMES % FRAMES}, kind = rest / (FRAMES * FRAMES), euler = kind / 2;
    double b[2];
    for (int n = 0; n < 2; n++)
      b[n] = run_combination(place, frame, kind & 1, euler ? "symplectic-euler" : "verlet", 2e-3 / (1 << n));
    worst[euler] = fmax(worst[euler], fabs(b[1]));
    if (fabs(b[1]) < (euler ? 2e-5 : 1e-9)) continue;
    low[euler] = fmin(low[euler], b[0] / b[1]);
    high[euler] = fmax(high[euler], b[0] / b[1]);
  }
  say("largest balance: verlet %.2e, symplectic Euler %.2e; halving the step divides it by %.2f .. %.2f and "
      "%.2f .. %.2f\n",
      worst[0], worst[1], low[0], high[0], low[1], high[1]);
  assert_at_most(worst[0], 5e-6);
  assert_at_most(worst[1], 5e-4);
  assert_near(low[0], 4, 0.2);
  assert_near(high[0], 4, 0.2);
  assert_near(low[1], 2, 0.2);
  assert_near(high[1], 2, 0.2);
}

/* Frames prescribed at edges in the middle: each span between them has its own moment, twist over the sum of
 * l/(2 beta); the supports hold the differences. A straight rod, for which this is all. */
static void test_spans(void **state) {
  (void)state;
  for (int general = 0; general < 2; general++) {
    trial t = {0};
    double line[3 * NV];
    shape_line(NV, EDGE * (NV - 1), 0, 0, line);
    scene_begin(&t.def, "verlet", 1e-3);
    hb_rod_def *rod = scene_rod(&t.def, NV, line, 0.05, 1, 0.125);
    for (int i = 0; i < NV; i++) rod->beta[i] = 0.02 + 0.01 * i;
    if (general) scene_make_general(rod);
    scene_hold(rod, 0);
    scene_angle(rod, 6, "t - 1");
    scene_angle(rod, 1, "0.5");
    scene_angle(rod, 4, "3 + 2*t");
    trial_start(&t);
    trial_run(&t, 100);
    const hb_frame *f = trial_measure(&t);
    double first = 0, second = 0; /* compliances */
    for (int i = 2; i <= 4; i++) first += 2 * EDGE / (2 * (0.02 + 0.01 * i));
    for (int i = 5; i <= 6; i++) second += 2 * EDGE / (2 * (0.02 + 0.01 * i));
    double M1 = (3.2 - 0.5) / first, M2 = (-0.9 - 3.2) / second;
    const double expected[NV] = {0, 0, M1, M1, M1, M2, M2, 0, 0};
    assert_near_array(f->twisting_moment, expected, NV, 1e-12);
    const double torque[NV] = {0, -M1, 0, 0, M1 - M2, 0, M2, 0, 0};
    assert_near_array(f->torque, torque, NV, 1e-12);
    assert_near(f->twisting, 0.5 * M1 * M1 * first + 0.5 * M2 * M2 * second, 1e-12);
    for (int j = 0; j < 2; j++) assert_near(f->theta[j], 0.5, 1e-13);
    assert_near(f->theta[4], 3.2, 1e-13);
    for (int j = 6; j < NV - 1; j++) assert_near(f->theta[j], -0.9, 1e-13);
    trial_end(&t);
  }
}

/* Vertices held and guided in the middle. */
static void test_middle_vertices(void **state) {
  (void)state;
  trial t = {0};
  double xyz[3 * NV];
  shape_bent(NV, EDGE, (double[]){0.6, -0.3, 0.2, 0.1}, xyz);
  scene_begin(&t.def, "verlet", 1e-3);
  hb_rod_def *rod = scene_rod(&t.def, NV, xyz, 0.05, 0.03, 0.125);
  scene_force(&t.def, HB_FORCE_GRAVITY, "0", "0", "-1");
  scene_path(rod, 4, "x + 0.1*t", "y - 0.2*t^2", NULL);
  scene_path(rod, 6, "free", "free", "z - 0.05*t");
  trial_start(&t);
  trial_run(&t, 300);
  const hb_frame *f = trial_measure(&t);
  const double *x = f->position, *x0 = t.model->initial;
  assert_near(x[12], x0[12] + 0.03, 1e-15);
  assert_near(x[13], x0[13] - 0.2 * 0.09, 1e-15);
  assert_same(x[14], x0[14]);
  assert_near(x[20], x0[20] - 0.015, 1e-15);
  assert_at_most(f->worst_length_error, 1e-10);
  for (int i = 0; i < NV; i++)
    for (int c = 0; c < 3; c++)
      if (i != 4 && !(i == 6 && c == 2)) assert_same(f->reaction[3 * i + c], 0);
  trial_end(&t);
}

/* Ten turns and back again: twist and moment count every winding, on a straight rod exactly, for both twist
 * solvers. */
static void test_windings(void **state) {
  (void)state;
  for (int general = 0; general < 2; general++) {
    trial t = {0};
    double line[3 * NV];
    shape_line(NV, EDGE * (NV - 1), 0, 0, line);
    scene_begin(&t.def, "verlet", 1e-3);
    hb_rod_def *rod = scene_rod(&t.def, NV, line, 0.05, 0.03, 0.125);
    if (general) scene_make_general(rod);
    scene_hold(rod, 0);
    scene_angle(rod, 0, "0");
    scene_angle(rod, -1, "20*pi*sin(pi*t)"); /* up to 0.2 rad in a step */
    trial_start(&t);
    for (int k = 1; k <= 20; k++) {
      trial_run(&t, 100);
      double angle = 20 * PI * sin(PI * 0.1 * k);
      const hb_frame *f = trial_measure(&t);
      assert_near(f->theta[NV - 2], angle, 1e-11);
      assert_near(f->twisting_moment[4], 0.03 * angle / (EDGE * (NV - 2)), 1e-11);
      assert_near(f->torque[NV - 2], 0.03 * angle / (EDGE * (NV - 2)), 1e-11);
      assert_near(f->work_supports, 0.5 * 0.03 * angle * angle / (EDGE * (NV - 2)), 1e-9);
    }
    trial_end(&t);
  }
}

/* Five turns into a rod that is bent between its clamps: it writhes and rolls, and both twist solvers see the
 * same, turn for turn. */
static void test_windings_of_bent_rod(void **state) {
  (void)state;
  trial t[2] = {0};
  for (int general = 0; general < 2; general++) {
    double line[3 * NV], xyz[3 * NV];
    shape_line(NV, EDGE * (NV - 1), 0, 0, line);
    shape_bent(NV, EDGE, (double[]){0.6, -0.3, 0.2, 0.1}, xyz);
    scene_begin(&t[general].def, "verlet", 1e-3);
    hb_rod_def *rod = scene_rod(&t[general].def, NV, line, 0.05, 0.002, 0.125);
    scene_initial(rod, xyz);
    rod->mass_damping = 2;
    if (general) scene_make_general(rod);
    scene_clamp_start(rod);
    scene_hold(rod, -1);
    scene_hold(rod, -2);
    scene_angle(rod, -1, "5*pi*t");
    trial_start(&t[general]);
  }
  double theta = 0;
  for (int k = 0; k < 100; k++) {
    trial_run(&t[0], 20);
    trial_run(&t[1], 20);
    const hb_frame *f = trial_measure(&t[0]), *g = trial_measure(&t[1]);
    assert_near_array(f->position, g->position, 3 * NV, 1e-9);
    assert_near_array(f->theta, g->theta, NV, 1e-8);
    assert_near(f->theta[NV - 2], theta, 1.0); /* no jump of a turn */
    theta = f->theta[NV - 2];
  }
  assert_near(theta, 10 * PI, 2.0); /* but for what the centre line itself turns */
  trial_end(&t[0]);
  trial_end(&t[1]);
}

/* A clamped edge that goes once round a cone comes back with its frame turned by the solid angle, 2 pi (1 -
 * cos a): "held" means carried along with the tangent. */
static void test_holonomy_of_moving_clamp(void **state) {
  (void)state;
  double error[2];
  for (int n = 0; n < 2; n++) {
    trial t = {0};
    double line[3 * NV], a = 0.5, before[3];
    long steps = 1000L << n;
    for (int i = 0; i < NV; i++) {
      line[3 * i] = EDGE * i * sin(a);
      line[3 * i + 1] = 0;
      line[3 * i + 2] = EDGE * i * cos(a);
    }
    scene_begin(&t.def, "verlet", 2 * PI / (double)steps);
    hb_rod_def *rod = scene_rod(&t.def, NV, line, 0.5, 0.03, 0.125);
    scene_hold(rod, 0);
    scene_tangent(rod, 0, "sin(0.5)*cos(t)", "sin(0.5)*sin(t)", "cos(0.5)", false);
    scene_angle(rod, 0, "0");
    rod->mass_damping = 0.5;
    trial_start(&t);
    memcpy(before, trial_measure(&t)->m1, sizeof before);
    trial_run(&t, steps);
    const double *m1 = trial_measure(&t)->m1, *m2 = t.frame->m2, solid = 2 * PI * (1 - cos(a));
    double c = 0, s = 0;
    for (int k = 0; k < 3; k++) {
      c += m1[k] * before[k];
      s -= m2[k] * before[k];
    }
    error[n] = fmin(fabs(fabs(atan2(s, c)) - solid), fabs(fabs(atan2(s, c)) - (2 * PI - solid)));
    trial_end(&t);
  }
  say("holonomy of a cone: off by %.2e, %.2e\n", error[0], error[1]);
  assert_at_most(error[1], 1e-5);
  assert_near(error[0] / error[1], 4, 0.1);
}

/* A clamp that falls as fast as everything else: nothing in the rod feels anything. */
static void test_falling_clamp(void **state) {
  (void)state;
  trial t = {0};
  double line[3 * NV];
  shape_line(NV, 1, 0, 0, line);
  scene_begin(&t.def, "verlet", 1e-3);
  hb_rod_def *rod = scene_rod(&t.def, NV, line, 0.05, 0.03, 0.125);
  scene_path(rod, 0, NULL, NULL, "-0.5*9.81*t^2");
  scene_tangent(rod, 0, NULL, NULL, NULL, false);
  scene_angle(rod, 0, "0");
  scene_force(&t.def, HB_FORCE_GRAVITY, "0", "0", "-9.81");
  trial_start(&t);
  trial_run(&t, 1000);
  const hb_frame *f = trial_measure(&t);
  for (int i = 0; i < NV; i++) {
    assert_near(f->position[3 * i + 2], -0.5 * 9.81, 1e-11);
    assert_near(f->velocity[3 * i + 2], -9.81, 1e-11);
    for (int c = 0; c < 3; c++) assert_near(f->reaction[3 * i + c], 0, 1e-9);
  }
  assert_near(f->bending, 0, 1e-20);
  trial_end(&t);
}

/* At rest, the two held vertices of a clamp carry the weight and its moment about the clamp. */
static void test_reactions_at_rest(void **state) {
  (void)state;
  trial t = {0};
  double line[3 * NV];
  shape_line(NV, 1, 0, 0, line);
  scene_begin(&t.def, "verlet", 2e-3);
  hb_rod_def *rod = scene_rod(&t.def, NV, line, 0.05, 0.03, 0.125);
  scene_clamp_start(rod);
  rod->mass_damping = 1.5;
  t.def.method.length_tolerance = 1e-13;
  scene_force(&t.def, HB_FORCE_GRAVITY, "0", "0", "-0.4");
  trial_start(&t);
  trial_run(&t, 40000);
  const hb_frame *f = trial_measure(&t);
  double moment = 0;
  for (int i = 0; i < NV; i++) moment += 0.125 * 0.4 * f->position[3 * i];
  assert_near(f->reaction[0] + f->reaction[3], 0, 1e-11);
  assert_near(f->reaction[2] + f->reaction[5], 0.4 * 0.125 * NV, 1e-11);
  assert_near(f->reaction[5] * EDGE, moment, 1e-11);
  trial_end(&t);
}

/* A taut straight rod whose clamps come closer: at the first step its edges have no part across the rod, so
 * the lengths cannot be met along them; Verlet follows the moving edges there, then goes on as ever, and the
 * balance closes. */
static void test_taut_rod_let_loose(void **state) {
  (void)state;
  for (int n = 0; n < 6; n++) {
    trial t = {0};
    double line[3 * NV];
    shape_line(NV, EDGE * (NV - 1), 0, 0, line);
    scene_begin(&t.def, n < 3 ? "verlet" : "symplectic-euler", 1e-3 / (1 << n % 3));
    hb_rod_def *rod = scene_rod(&t.def, NV, line, 0.05, 0.03, 0.125);
    scene_clamp_start(rod);
    scene_path(rod, -1, "x - 0.05*t^2", NULL, NULL);
    scene_tangent(rod, -1, NULL, NULL, NULL, true);
    scene_angle(rod, -1, "0");
    scene_force(&t.def, HB_FORCE_GRAVITY, "0", "0", "-1");
    trial_start(&t);
    trial_run(&t, 1000L << n % 3);
    const hb_frame *f = trial_measure(&t);
    double fallbacks = hb_sim_const_state(t.sim)->scalar[HB_S_FALLBACKS];
    say("taut rod let loose: %g steps along moving edges, balance %.2e, lowest %.5f\n", fallbacks, f->balance,
        f->position[3 * (NV / 2) + 2]);
    assert_at_most(fallbacks, 3);
    assert_at_most(f->worst_length_error, 1e-10);
    assert_true(f->position[3 * (NV / 2) + 2] < -0.05);
    assert_at_most(fabs(f->balance), 1e-4);
    trial_end(&t);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_every_combination),    cmocka_unit_test(test_spans),
      cmocka_unit_test(test_middle_vertices),      cmocka_unit_test(test_windings),
      cmocka_unit_test(test_windings_of_bent_rod), cmocka_unit_test(test_holonomy_of_moving_clamp),
      cmocka_unit_test(test_falling_clamp),        cmocka_unit_test(test_reactions_at_rest),
      cmocka_unit_test(test_taut_rod_let_loose),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
