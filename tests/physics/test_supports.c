/* Boundary conditions (A7 of the mission): every combination at both ends, in the middle, moving, turning, winding. What is
 * prescribed is met, what is free feels no support, and the energy balance closes with the supports' work in it. */
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
    for (int c = 0; c < 3; c++) snprintf(d[c], sizeof d[c], "%.17g + %g*t", (end ? x[c] - y[c] : y[c] - x[c]) / EDGE, 0.1 * c);
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
  if (frame == DIRECTOR) { /* m1 turned back by the extra angle lies in the plane of the tangent and what is asked for */
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

/* Balance at the end of one combination; everything checked on the way. kind: straight and isotropic, or neither. */
static double run_combination(const int place[2], const int frame[2], bool general, const char *integrator, double h) {
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

/* 20 ways to support each end, straight and curved rods, both schemes: 1600 runs, each at two steps. */
static void test_every_combination(void **state) {
  (void)state;
  double worst[2] = {0, 0}, ratio_low = 100, ratio_high = 0;
  for (int k = 0; k < PLACES * PLACES * FRAMES * FRAMES * 4; k++) {
    int place[2] = {k % PLACES, k / PLACES % PLACES}, rest = k / (PLACES * PLACES);
    int frame[2] = {rest % FRAMES, rest / FRAMES % FRAMES}, kind = rest / (FRAMES * FRAMES), order = kind & 2 ? 1 : 2;
    const char *scheme = kind & 2 ? "symplectic-euler" : "verlet";
    double b[2];
    for (int n = 0; n < 2; n++) b[n] = run_combination(place, frame, kind & 1, scheme, 2e-3 / (1 << n));
    worst[order - 1] = fmax(worst[order - 1], fabs(b[1]));
    double ratio = b[0] / b[1];
    if (order == 2 && fabs(b[1]) > 1e-9) {
      ratio_low = fmin(ratio_low, ratio);
      ratio_high = fmax(ratio_high, ratio);
    }
    if (fabs(b[1]) > (order == 2 ? 2e-7 : 2e-4))
      print_message("places %d %d frames %d %d kind %d: balance %.2e %.2e\n", place[0], place[1], frame[0], frame[1], kind,
                    b[0], b[1]);
  }
  say("largest balance: symplectic Euler %.2e, verlet %.2e, halving the step divides it by %.2f .. %.2f\n", worst[0],
      worst[1], ratio_low, ratio_high);
  assert_at_most(worst[0], 2e-4);
  assert_at_most(worst[1], 2e-7);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_every_combination),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
