/* V50.4 to V50.8 in motion: a scene that is turned, moved, mirrored, reversed, rescaled or described with
 * other frames moves in the same way. */
#include "support/near.h"

#include "support/rng.h"
#include "support/scenes.h"

#define NV 10
#define EDGE 0.125
#define STEPS 1000

/* What is done to the scene. The identity: see plain. */
typedef struct change {
  double turn[9], shift[3];  /* x -> turn x + shift */
  bool mirrored;             /* turn has determinant -1: angles and twists change their sign */
  bool reversed;             /* vertices counted from the other end */
  bool rod_general;          /* the general twist solver for a rod that has a closed form */
  double frame;              /* the whole material is described by directors turned by this much */
  double length, mass, time; /* units */
} change;

static const change plain = {.turn = {1, 0, 0, 0, 1, 0, 0, 0, 1}, .length = 1, .mass = 1, .time = 1};

/* One vector, or one point. */
static void apply(const change *c, const double *a, bool point, double *out) {
  for (int k = 0; k < 3; k++) {
    out[k] = c->turn[3 * k] * a[0] + c->turn[3 * k + 1] * a[1] + c->turn[3 * k + 2] * a[2];
    if (point) out[k] = c->length * (out[k] + c->shift[k]);
  }
}

/* Points (or directions) of a whole rod. */
static void apply_all(const change *c, const double *a, bool points, double *out) {
  for (int i = 0; i < NV; i++) apply(c, a + 3 * i, points, out + 3 * (c->reversed ? NV - 1 - i : i));
}

/* Adds a load with a changed vector. */
static hb_force_def *force(hb_scene_def *def, hb_force_kind kind, const change *c, const double *value,
                           double unit) {
  char text[3][40];
  double v[3];
  apply(c, value, false, v);
  for (int k = 0; k < 3; k++) snprintf(text[k], sizeof text[k], "%.17g", unit * v[k]);
  return scene_force(def, kind, text[0], text[1], text[2]);
}

/* Which scene: bits. */
enum { CURVED = 1, CLAMPED = 2, LOADED = 4 };

/* Bending forms by edge: anisotropic where curved. B11 is the stiffness along (kb . m2), so turning the
 * directors by an angle turns the form. */
static void set_forms(hb_rod_def *rod, const change *c, bool curved) {
  double unit = c->mass * c->length * c->length * c->length / (c->time * c->time);
  double a = curved ? 0.06 : 0.05, b = curved ? 0.03 : 0.05;
  double cs = cos(c->frame), sn = sin(c->frame);
  for (int j = 0; j + 1 < NV; j++) {
    rod->B[3 * j] = unit * (a * cs * cs + b * sn * sn);
    rod->B[3 * j + 1] = unit * (b - a) * cs * sn;
    rod->B[3 * j + 2] = unit * (a * sn * sn + b * cs * cs);
  }
  for (int i = 0; i < NV; i++) rod->beta[i] = unit * 0.04;
}

/* The scene, changed. Forms are given in directors carried along the rest shape from the first edge. */
static void build(trial *t, int which, const change *c, const char *integrator) {
  double rest[3 * NV], xyz[3 * NV], v[3 * NV], out[3 * NV], line[3 * NV], u[3], w[3];
  const double tilt[4] = {0.5, 0.6, 0.4, 0.3};
  shape_line(NV, EDGE * (NV - 1), 0, 0, line);
  shape_bent(NV, EDGE, tilt, rest);
  /* the first edges of both shapes are parallel, so that a director of one is a director of the other */
  double at = 0.5 / (NV - 1), sine = sin(3.14159265358979323846 * at) / at,
         sine2 = sin(2 * 3.14159265358979323846 * at) / at;
  shape_bent(NV, EDGE, (double[]){0.6, 0.6 - 0.1 * sine, 0.3, 0.3 + 0.1 * sine2}, xyz);
  for (int i = 0; i < NV; i++)
    for (int k = 0; k < 3; k++) v[3 * i + k] = which & CLAMPED ? 0 : 0.1 * (k + 1) * sin(0.4 * i + k);
  scene_begin(&t->def, integrator, 1e-3 * c->time);
  apply_all(c, which & CURVED ? rest : line, true, out);
  double unit_v = c->length / c->time;
  hb_rod_def *rod = scene_rod(&t->def, NV, out, 1, 1, 1);
  apply_all(c, xyz, true, out);
  scene_initial(rod, out);
  apply_all(c, v, false, out);
  for (int k = 0; k < 3 * NV; k++) out[k] *= unit_v;
  scene_velocity(rod, out);
  for (int i = 0; i < NV; i++) rod->mass[c->reversed ? NV - 1 - i : i] = c->mass * (0.1 + 0.01 * i);
  set_forms(rod, c, which & CURVED);
  if (c->rod_general) scene_make_general(rod);
  /* first director: any normal of the first rest edge, turned by c->frame about it */
  const double *s = which & CURVED ? rest : line;
  double tangent[3], n = 0;
  for (int k = 0; k < 3; k++) tangent[k] = (s[3 + k] - s[k]) / EDGE;
  const double normal[3] = {-tangent[1], tangent[0], 0};
  for (int k = 0; k < 3; k++) n += normal[k] * normal[k];
  for (int k = 0; k < 3; k++) {
    double cross = tangent[(k + 1) % 3] * normal[(k + 2) % 3] - tangent[(k + 2) % 3] * normal[(k + 1) % 3];
    u[k] = (cos(c->frame) * normal[k] + sin(c->frame) * cross) / sqrt(n);
  }
  apply(c, u, false, w);
  if (!c->reversed) memcpy(rod->first_director, w, sizeof w);
  if (which & CLAMPED) {
    double sign = c->mirrored ? -1 : 1;
    char angle[80];
    int first = c->reversed ? NV - 1 : 0, next = c->reversed ? NV - 2 : 1, edge = c->reversed ? NV - 2 : 0;
    scene_hold(rod, first);
    scene_hold(rod, next);
    snprintf(angle, sizeof angle, "%.17g", c->reversed ? 0.0 : sign * 0.7);
    scene_angle(rod, edge, angle);
    snprintf(angle, sizeof angle, "%.17g + %.17g*t", c->reversed ? sign * 1.6 : sign * -0.9,
             (c->reversed ? -1 : 1) * sign / c->time);
    scene_angle(rod, NV - 2 - edge, angle);
  }
  if (which & LOADED) {
    double unit = c->length / (c->time * c->time);
    force(&t->def, HB_FORCE_GRAVITY, c, (double[]){0.1, -0.3, 0.2}, unit);
    hb_force_def *wind = force(&t->def, HB_FORCE_WIND, c, (double[]){-0.2, 0.5, 0.4}, unit_v);
    wind->linear[0] = 0.2 * c->mass / c->length / c->time;
    wind->quadratic[0] = 0.3 * c->mass / c->length / c->length;
    wind->quadratic[1] = 0.05 * c->mass / c->length / c->length;
    rod->mass_damping = 0.2 / c->time;
  }
  trial_start(t);
}

/* Largest difference of positions and velocities to the changed run of the plain scene, in plain units. */
static double compare(int which, const change *c, const char *integrator) {
  trial a = {0}, b = {0};
  double x[3 * NV], v[3 * NV];
  build(&a, which, &plain, integrator);
  build(&b, which, c, integrator);
  trial_run(&a, STEPS);
  trial_run(&b, STEPS);
  const hb_frame *f = trial_measure(&a), *g = trial_measure(&b);
  apply_all(c, f->position, true, x);
  apply_all(c, f->velocity, false, v);
  for (int k = 0; k < 3 * NV; k++) v[k] *= c->length / c->time;
  double worst = largest_difference(x, g->position, 3 * NV) / c->length;
  worst = fmax(worst, largest_difference(v, g->velocity, 3 * NV) * c->time / c->length);
  double unit = c->mass * c->length * c->length / (c->time * c->time);
  worst = fmax(worst, fabs(g->bending / unit - f->bending));
  worst = fmax(worst, fabs(g->twisting / unit - f->twisting));
  worst = fmax(worst, fabs(g->kinetic / unit - f->kinetic));
  trial_end(&a);
  trial_end(&b);
  return worst;
}

/* All scenes and schemes under one change. */
static void check(const char *name, const change *c, int scenes, double tolerance) {
  static const char *const schemes[2] = {"verlet", "symplectic-euler"};
  for (int which = 0; which < 8; which++)
    for (int k = 0; k < 2; k++) {
      if (!(scenes & (1 << which))) continue;
      double worst = compare(which, c, schemes[k]);
      say("%-10s scene %d %-17s %.1e\n", name, which, schemes[k], worst);
      assert_at_most(worst, tolerance);
    }
}

/* The same move happens somewhere else in another direction. */
static void test_rigid_motion(void **state) {
  (void)state;
  for (int n = 0; n < 3; n++) {
    change c = plain;
    rng r = rng_start((uint64_t)n);
    double q[4], s = 0;
    for (int k = 0; k < 4; k++) {
      q[k] = rng_normal(&r);
      s += q[k] * q[k];
    }
    s = 2 / s;
    const double turn[9] = {1 - s * (q[2] * q[2] + q[3] * q[3]), s * (q[1] * q[2] - q[0] * q[3]),
                            s * (q[1] * q[3] + q[0] * q[2]),     s * (q[1] * q[2] + q[0] * q[3]),
                            1 - s * (q[1] * q[1] + q[3] * q[3]), s * (q[2] * q[3] - q[0] * q[1]),
                            s * (q[1] * q[3] - q[0] * q[2]),     s * (q[2] * q[3] + q[0] * q[1]),
                            1 - s * (q[1] * q[1] + q[2] * q[2])};
    memcpy(c.turn, turn, sizeof turn);
    for (int k = 0; k < 3; k++) c.shift[k] = rng_uniform(&r, -3, 3);
    check("turned", &c, 0xff, 1e-9);
  }
}

/* Left and right exchanged; what was twisted to the right is twisted to the left. */
static void test_mirror(void **state) {
  (void)state;
  change c = plain;
  c.turn[8] = -1;
  c.mirrored = true;
  check("mirrored", &c, 0xff, 1e-9);
}

/* Counted from the other end: rods without directors of their own. */
static void test_reversal(void **state) {
  (void)state;
  change c = plain;
  c.reversed = true;
  check("reversed", &c, 1 | 1 << CLAMPED | 1 << LOADED | 1 << (CLAMPED | LOADED), 1e-9);
}

/* The same material in directors that are turned by an angle. */
static void test_frame_choice(void **state) {
  (void)state;
  change c = plain;
  c.frame = 0.83;
  check("frames", &c, 0xff, 1e-9);
}

/* Closed form and Newton for the twist. */
static void test_two_solvers(void **state) {
  (void)state;
  change c = plain;
  c.rod_general = true;
  check("solvers", &c, 1 | 1 << CLAMPED | 1 << LOADED | 1 << (CLAMPED | LOADED), 1e-9);
}

/* Other units: no number in the program has one. Powers of two change no bit. */
static void test_units(void **state) {
  (void)state;
  static const double units[5][3] = {
      {1e-3, 1, 1}, {1, 1e-6, 1}, {1, 1e6, 1}, {1e-9, 1e-18, 1e-4}, {1000, 1e9, 1e3}};
  for (int k = 0; k < 5; k++) {
    change c = plain;
    c.length = units[k][0];
    c.mass = units[k][1];
    c.time = units[k][2];
    check("units", &c, 0xff, 1e-9);
  }
  change c = plain;
  c.length = 0x1p-20;
  c.mass = 0x1p-33;
  c.time = 0x1p7;
  check("powers", &c, 0xff, 0);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_rigid_motion), cmocka_unit_test(test_mirror),
      cmocka_unit_test(test_reversal),     cmocka_unit_test(test_frame_choice),
      cmocka_unit_test(test_two_solvers),  cmocka_unit_test(test_units),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
