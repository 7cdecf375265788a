/* A scene file that says the same in other words gives the same motion: moved and turned, counted from the
 * other end, with another first frame, in other units (V50.4 to V50.8 of the catalogue, through the public
 * reader). Every integrator, closed-form and general rods, clamps that move and twist, loads, followers,
 * wind, damping. */
#include "support/near.h"

#include "hebra/plug.h"
#include "hebra/scene.h"
#include "math/rotation.h"
#include "support/rods.h"
#include "support/scenes.h"

#define NV 13
#define EDGE 0.1
#define STEPS 300
#define TEXT 32768

/* How the scene is told. Points become length (turn x + shift). */
typedef struct telling {
  double turn[9], shift[3];
  bool reversed;             /* vertices counted from the other end */
  double frame;              /* the directors of the whole material turned about the tangents */
  double length, mass, time; /* one unit of the plain scene in the new ones */
} telling;

static const telling plain = {.turn = {1, 0, 0, 0, 1, 0, 0, 0, 1}, .length = 1, .mass = 1, .time = 1};

/* A scene text in the making. */
typedef struct page {
  char text[TEXT];
  size_t used;
  const telling *how;
} page;

/* Adds text. */
HB_PRINTF(2, 3) static void add(page *p, const char *format, ...) {
  va_list args;
  va_start(args, format);
  int n = vsnprintf(p->text + p->used, TEXT - p->used, format, args);
  va_end(args);
  assert_true(n >= 0 && p->used + (size_t)n < TEXT);
  p->used += (size_t)n;
}

/* turn a */
static hb_v3 turned(const telling *how, hb_v3 a) {
  const double *R = how->turn;
  return (hb_v3){R[0] * a.x + R[1] * a.y + R[2] * a.z, R[3] * a.x + R[4] * a.y + R[5] * a.z,
                 R[6] * a.x + R[7] * a.y + R[8] * a.z};
}

/* Adds [x, y, z], turned, times a unit. */
static void add_vector(page *p, hb_v3 a, double unit) {
  a = hb_v3_scale(unit, turned(p->how, a));
  add(p, "[%.17g, %.17g, %.17g]", a.x, a.y, a.z);
}

/* Adds the points of a shape, in the order told. */
static void add_points(page *p, const double *xyz) {
  add(p, "[");
  for (int i = 0; i < NV; i++) {
    hb_v3 x = hb_v3_load(xyz + 3 * (p->how->reversed ? NV - 1 - i : i));
    x = hb_v3_scale(p->how->length, hb_v3_add(turned(p->how, x), hb_v3_load(p->how->shift)));
    add(p, "%s[%.17g, %.17g, %.17g]", i ? ", " : "", x.x, x.y, x.z);
  }
  add(p, "]");
}

/* Tangent of edge j of the plain shape. */
static hb_v3 tangent_of(const double *xyz, int j) {
  return hb_v3_unit(hb_v3_sub(hb_v3_load(xyz + 3 * j + 3), hb_v3_load(xyz + 3 * j)));
}

/* The director as it is told: turned about the tangent, which points the other way when the rod is reversed.
 */
static hb_v3 told_director(const telling *how, hb_v3 m1, hb_v3 t) {
  return hb_turn(hb_project_normal(m1, t), t, how->reversed ? -how->frame : how->frame);
}

/* The bending form of the plain frames ((a, b), (b, c)) in the frames told. m2 changes sign with t, and b
 * with it. */
static void add_form(page *p, double a, double b, double c) {
  const telling *how = p->how;
  double unit = how->mass * pow(how->length, 3) / (how->time * how->time), co = cos(how->frame),
         si = sin(how->frame), sign = how->reversed ? -1 : 1;
  b *= sign;
  add(p, "    bending: [%.17g, %.17g, %.17g]\n", unit * (a * co * co + 2 * b * co * si + c * si * si),
      unit * (b * (co * co - si * si) + (c - a) * co * si),
      unit * (a * si * si - 2 * b * co * si + c * co * co));
  add(p, "    twisting: %.17g\n", unit * 0.04);
}

/* A clamp at the plain rod's start or end: moves with the plain velocity, turns by the plain rate. */
static void add_clamp(page *p, const double *xyz, bool end, hb_v3 velocity, double rate) {
  const telling *how = p->how;
  hb_v3 t = tangent_of(xyz, end ? NV - 2 : 0);
  hb_v3 v = hb_v3_scale(how->length / how->time, turned(how, velocity));
  add(p, "    %s:\n      clamp: true\n", end == how->reversed ? "start" : "end");
  add(p, "      position: [x + %.17g*t, y + %.17g*t, z + %.17g*t]\n", v.x, v.y, v.z);
  add(p, "      material_frame: ");
  add_vector(p, told_director(how, (hb_v3){0.3, 0.5, 0.8}, t), 1);
  add(p, "\n      material_turn: %.17g*t\n", (how->reversed ? -rate : rate) / how->time);
}

/* Loads of every kind. */
static void add_loads(page *p, bool follower) {
  const telling *how = p->how;
  double force = how->mass * how->length / (how->time * how->time);
  add(p, "gravity: ");
  add_vector(p, (hb_v3){0.2, -0.4, -0.6}, how->length / (how->time * how->time));
  add(p, "\nforces:\n  - {vertex: %d, point: ", how->reversed ? NV - 8 : 7);
  add_vector(p, (hb_v3){0.02, 0.05, -0.03}, force);
  add(p, "}\n");
  if (follower) { /* along t, m1, m2 */
    double co = cos(how->frame), si = sin(how->frame), sign = how->reversed ? -1 : 1,
           unit = force / how->length;
    double f[3] = {0.02 * sign, 0.06, -0.05 * sign};
    add(p, "  - {follower: true, distributed: [%.17g, %.17g, %.17g]}\n", unit * f[0],
        unit * (co * f[1] + si * f[2]), unit * (co * f[2] - si * f[1]));
  }
  add(p, "  - wind:\n      velocity: ");
  add_vector(p, (hb_v3){-0.5, 0.7, 0.2}, how->length / how->time);
  add(p, "\n      linear: {normal: %.17g, tangential: %.17g}\n", 0.1 * how->mass / (how->length * how->time),
      0.04 * how->mass / (how->length * how->time));
  add(p, "      quadratic: {normal: %.17g, tangential: %.17g}\n",
      0.2 * how->mass / (how->length * how->length), 0.01 * how->mass / (how->length * how->length));
}

/* Which scene. */
enum { GENERAL = 1, ENDS = 2, LOADED = 4, KINDS = 8 };

/* Adds the rod's shapes and stiffness. */
static void add_rod(page *p, int kind, const double *rest, const double *xyz) {
  const telling *how = p->how;
  add(p, "rods:\n  - name: rod\n    rest: {vertices: ");
  add_points(p, rest);
  add(p, "}\n    initial: {vertices: ");
  add_points(p, xyz);
  add(p, "}\n    linear_density: %.17g\n", 1.2 * how->mass / how->length);
  if (kind & GENERAL)
    add_form(p, 0.06, 0.012, 0.025);
  else
    add_form(p, 0.05, 0, 0.05);
  int first = how->reversed ? NV - 2 : 0;
  if (kind & GENERAL) {
    hb_v3 m1 = hb_project_normal((hb_v3){0.1, 0.2, 1}, tangent_of(rest, 0));
    hb_v3 all[NV];
    for (int j = 0; j + 1 < NV; j++) {
      if (j > 0)
        m1 =
            hb_turn(hb_transport(m1, tangent_of(rest, j - 1), tangent_of(rest, j)), tangent_of(rest, j), 0.1);
      all[j] = told_director(how, m1, tangent_of(rest, j));
    }
    add(p, "    rest_directors: [");
    for (int j = 0; j + 1 < NV; j++) {
      add(p, "%s", j ? ", " : "");
      add_vector(p, all[how->reversed ? NV - 2 - j : j], 1);
    }
    add(p, "]\n");
  }
  add(p, "    director: ");
  add_vector(p, told_director(how, (hb_v3){0.2, 0.4, 0.9}, tangent_of(xyz, first)), 1);
  add(p, "\n    velocity: [");
  hb_v3 v = hb_v3_scale(how->length / how->time, turned(how, (hb_v3){0.1, 0.2, -0.1}));
  hb_v3 w = hb_v3_scale(1 / how->time, turned(how, (hb_v3){0.1, -0.3, 0.4}));
  const double a[3] = {v.x, v.y, v.z}, b[3] = {w.x, w.y, w.z};
  for (int c = 0; c < 3; c++)
    add(p, "%s%.17g + %.17g*%s", c ? ", " : "", kind & ENDS ? 0 : a[c], kind & ENDS ? 0 : b[c],
        how->reversed ? "(L - s)" : "s");
  add(p, "]\n");
  if (kind & LOADED) add(p, "    damping: {mass: %.17g%s", 0.2 / how->time, kind & GENERAL ? "" : "}\n");
  if ((kind & LOADED) && (kind & GENERAL))
    add(p, ", bending: %.17g}\n", 1e-3 * how->mass * pow(how->length, 3) / how->time);
}

/* The whole scene. */
static void write_scene(page *p, int kind, const telling *how, const char *integrator) {
  double line[3 * NV], bent[3 * NV], xyz[3 * NV];
  shape_line(NV, EDGE * (NV - 1), 0, 0, line);
  shape_bent(NV, EDGE, (double[]){0.5, 0.6, 0.4, 0.3}, bent);
  shape_bent(NV, EDGE, (double[]){0.7, -0.4, 0.3, 0.4}, xyz);
  p->used = 0;
  p->how = how;
  add(p, "method: {integrator: %s, time_step: %.17g, duration: %.17g}\n", integrator, 1e-3 * how->time,
      how->time);
  add_rod(p, kind, kind & GENERAL ? bent : line, xyz);
  if (kind & ENDS) {
    add_clamp(p, xyz, false, (hb_v3){0.02, 0.05, 0}, 3);
    add_clamp(p, xyz, true, (hb_v3){-0.1, 0.03, 0.02}, -4);
  }
  if (kind & LOADED) add_loads(p, kind & GENERAL);
}

/* Reads, runs and measures a scene. */
static void run_scene(trial *t, int kind, const telling *how, const char *integrator) {
  hb_error err = {HB_OK, ""};
  page *p = hb_alloc(1, sizeof *p);
  assert_non_null(p);
  write_scene(p, kind, how, integrator);
  if (hb_scene_parse(p->text, p->used, "told", ".", NULL, 0, &t->def, &err))
    fail_msg("%s\n%s", err.text, p->text);
  hb_free(p);
  trial_start(t);
  trial_run(t, STEPS);
  (void)trial_measure(t);
}

/* Largest difference of a vector field of the plain run, told anew, to that of the other run, over the
 * largest vector. sign: under reversal. */
static double vector_difference(const telling *how, const double *a, const double *b, int count, double unit,
                                double sign, bool points) {
  double worst = 0, most = 0;
  for (int i = 0; i < count; i++) {
    hb_v3 u = turned(how, hb_v3_load(a + 3 * i));
    if (points) u = hb_v3_add(u, hb_v3_load(how->shift));
    u = hb_v3_scale(unit * (how->reversed ? sign : 1), u);
    hb_v3 v = hb_v3_load(b + 3 * (how->reversed ? count - 1 - i : i));
    worst = fmax(worst, hb_v3_norm(hb_v3_sub(u, v)));
    most = fmax(most, hb_v3_norm(u));
  }
  return most > 0 ? worst / most : worst;
}

/* The same for numbers. */
static double number_difference(const telling *how, const double *a, const double *b, int count, double unit,
                                double sign) {
  double worst = 0, most = 0;
  for (int i = 0; i < count; i++) {
    double u = unit * (how->reversed ? sign : 1) * a[i];
    worst = fmax(worst, fabs(u - b[how->reversed ? count - 1 - i : i]));
    most = fmax(most, fabs(u));
  }
  return most > 0 ? worst / most : worst;
}

/* Largest relative difference of everything that is measured. */
static double compare(int kind, const telling *how, const char *integrator) {
  trial a = {0}, b = {0};
  run_scene(&a, kind, &plain, integrator);
  run_scene(&b, kind, how, integrator);
  const hb_frame *f = a.frame, *g = b.frame;
  double speed = how->length / how->time, force = how->mass * speed / how->time, energy = force * how->length,
         d = 0;
  double director[3 * NV] = {0};
  for (int j = 0; j + 1 < NV; j++) {
    hb_v3 m1 = hb_v3_load(f->m1 + 3 * j);
    hb_v3_store(director + 3 * j, told_director(how, m1, hb_v3_load(f->tangent + 3 * j)));
  }
  d = fmax(d, vector_difference(how, f->position, g->position, NV, how->length, 1, true));
  d = fmax(d, vector_difference(how, f->velocity, g->velocity, NV, speed, 1, false));
  d = fmax(d, vector_difference(how, f->tangent, g->tangent, NV - 1, 1, -1, false));
  /* no energy tells how a rod without held frames that is isotropic stands about its axis: it follows its
   * first edge */
  if (!how->reversed || (kind & (GENERAL | ENDS)))
    d = fmax(d, vector_difference(how, director, g->m1, NV - 1, 1, 1, false));
  d = fmax(d, vector_difference(how, f->curvature_binormal, g->curvature_binormal, NV, 1, -1, false));
  d = fmax(d, vector_difference(how, f->reaction, g->reaction, NV, force, 1, false));
  d = fmax(d, number_difference(how, f->tension, g->tension, NV - 1, force, 1));
  d = fmax(d, number_difference(how, f->torque, g->torque, NV - 1, energy, -1));
  d = fmax(d, number_difference(how, f->energy_bending, g->energy_bending, NV, energy, 1));
  d = fmax(d, number_difference(how, f->energy_kinetic, g->energy_kinetic, NV, energy, 1));
  if (f->twisting > 1e-20) { /* where there is any */
    d = fmax(d, number_difference(how, f->twist, g->twist, NV, 1, 1));
    d = fmax(d, number_difference(how, f->twisting_moment, g->twisting_moment, NV, energy, 1));
    d = fmax(d, number_difference(how, f->energy_twisting, g->energy_twisting, NV, energy, 1));
  }
  double total = f->kinetic + f->bending + f->twisting;
  d = fmax(d, fabs(g->work_loads / energy - f->work_loads) / total);
  d = fmax(d, fabs(g->work_supports / energy - f->work_supports) / total);
  d = fmax(d, fabs(g->dissipated / energy - f->dissipated) / total);
  trial_end(&a);
  trial_end(&b);
  return d;
}

/* All kinds of scenes and all integrators, told in one other way. */
static void check(const char *name, const telling *how, double tolerance) {
  for (int k = 0; hb_integrators[k]; k++) {
    double worst = 0;
    for (int kind = 0; kind < KINDS; kind++) {
      double d = compare(kind, how, hb_integrators[k]->name);
      if (!(d <= tolerance))
        fail_msg("%s, %s, scene %d: off by %.2e", name, hb_integrators[k]->name, kind, d);
      worst = fmax(worst, d);
    }
    say("%-18s %-18s %.1e\n", name, hb_integrators[k]->name, worst);
  }
}

/* Elsewhere, in another direction. */
static void test_moved(void **state) {
  (void)state;
  for (int n = 0; n < 3; n++) {
    telling how = plain;
    rng r = rng_start((uint64_t)n + 1);
    rod_random_rotation(&r, how.turn);
    for (int c = 0; c < 3; c++) how.shift[c] = rng_uniform(&r, -3, 3);
    check("moved", &how, 1e-10);
  }
}

/* Counted from the other end: general rods too, with their directors. */
static void test_reversed(void **state) {
  (void)state;
  telling how = plain;
  how.reversed = true;
  check("reversed", &how, 1e-10);
}

/* Another first Bishop frame, and with it all directors of the material. */
static void test_first_frame(void **state) {
  (void)state;
  for (int n = 0; n < 3; n++) {
    telling how = plain;
    how.frame = 0.7 + 1.9 * n;
    check("first frame", &how, 1e-10);
  }
}

/* Millimetres and grams, kilometres and milliseconds, minutes, all at once: no number in the program has a
 * unit. */
static void test_units(void **state) {
  (void)state;
  static const double units[4][3] = {{1e3, 1e3, 1}, {1e-3, 1, 1e3}, {1, 1, 1.0 / 60}, {1e9, 1e24, 1e6}};
  for (int k = 0; k < 4; k++) {
    telling how = plain;
    how.length = units[k][0];
    how.mass = units[k][1];
    how.time = units[k][2];
    check(k ? "other units" : "mm-g-s", &how, 1e-10);
  }
}

/* Everything together. */
static void test_all(void **state) {
  (void)state;
  telling how = plain;
  rng r = rng_start(9);
  rod_random_rotation(&r, how.turn);
  how.shift[1] = 2;
  how.reversed = true;
  how.frame = -2.2;
  how.length = how.mass = 1e3;
  check("all", &how, 1e-10);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_moved), cmocka_unit_test(test_reversed), cmocka_unit_test(test_first_frame),
      cmocka_unit_test(test_units), cmocka_unit_test(test_all),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
