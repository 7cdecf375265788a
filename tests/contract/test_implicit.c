/* What implicit steps promise beyond every integrator's contract: order with every kind of force and support,
 * velocities along the lengths, energy that never comes from nowhere at any step, error control, the same
 * bits after a restart and with any number of threads, and a plain sentence where there is no solution. */
#include "support/near.h"

#include "hebra/plug.h"
#include "support/moving.h"

/* Largest speed of a vertex. */
static double rod_speed(const double *v) {
  double speed = 0;
  for (int i = 0; i < NV; i++) speed = fmax(speed, hypot(hypot(v[3 * i], v[3 * i + 1]), v[3 * i + 2]));
  return speed;
}

/* A closed ring, straight at rest, joined with a turn and a half, that is thrown and folds. */
static void ring(hb_scene_def *def) {
  double xyz[3 * NV], v[3 * NV], radius = 0.5 * EDGE / sin(acos(-1) / (NV - 1));
  for (int i = 0; i < NV; i++) {
    double a = 2 * acos(-1) * (i % (NV - 1)) / (NV - 1);
    xyz[3 * i] = radius * cos(a);
    xyz[3 * i + 1] = radius * sin(a);
    xyz[3 * i + 2] = 0;
    v[3 * i] = 0.3 * cos(a);
    v[3 * i + 1] = -0.3 * sin(a);
    v[3 * i + 2] = 0.4 * cos(2 * a) + 0.1;
  }
  hb_rod_def *rod = scene_rod(def, NV, xyz, 0.02, 0.02, MASS);
  rod->straight_rest = true;
  rod->closing = HB_CLOSING_TURNS;
  rod->closing_value = 1.5;
  scene_velocity(rod, v);
}

/* The same of a flat section, curved at rest, with viscosity, hanging from its joint. */
static void hanging_ring(hb_scene_def *def) {
  ring(def);
  hb_rod_def *rod = &def->rods[0];
  rod->straight_rest = false;
  rod->closing_value = 0;
  scene_form(rod, 0.03, 0, 0.02);
  scene_viscosity(rod, 0.001);
  scene_hold(rod, 0);
  memset(rod->velocity, 0, 3 * sizeof *rod->velocity);
  memset(rod->velocity + 3 * (NV - 1), 0, 3 * sizeof *rod->velocity);
  scene_force(def, HB_FORCE_GRAVITY, "0.2", "0", "-1");
}

/* A rod whose edges are springs. */
static void spring(hb_scene_def *def) {
  moving_cantilever(def);
  def->rods[0].stretching = scene_fill(4, NV - 1);
  scene_force(def, HB_FORCE_POINT, "0.4*sin(4*t)", "0", "0")->vertex = -1;
}

/* A run to some time; what it ends with. */
typedef struct finish {
  double x[3 * NV], v[3 * NV], balance, stretch;
} finish;

/* Rates of edge lengths: largest |e . (v_{j+1} - v_j)| over |e| and the largest speed. */
static double stretch_rate(const trial *t) {
  const double *x = hb_sim_const_state(t->sim)->x, *v = hb_sim_const_state(t->sim)->v;
  double speed = rod_speed(v), worst = 0;
  for (int j = 0; j + 1 < NV; j++) {
    double rate = 0;
    for (int c = 0; c < 3; c++) rate += (x[3 * j + 3 + c] - x[3 * j + c]) * (v[3 * j + 3 + c] - v[3 * j + c]);
    worst = fmax(worst, fabs(rate) / (t->model->rest_length[j] * speed));
  }
  return worst;
}

/* Runs one of the moving scenes. */
static finish run_to(const moving_scene *scene, const char *integrator, double time, long steps) {
  trial t = {0};
  finish out;
  trial_build(&t, scene->build, integrator, time / (double)steps);
  trial_run(&t, steps);
  memcpy(out.x, hb_sim_const_state(t.sim)->x, sizeof out.x);
  memcpy(out.v, hb_sim_const_state(t.sim)->v, sizeof out.v);
  out.balance = trial_measure(&t)->balance;
  out.stretch = stretch_rate(&t);
  trial_end(&t);
  return out;
}

/* Positions, velocities and the energy balance of every scene converge as claimed, and positions to where
 * Verlet's do. */
static void test_orders(void **state) {
  (void)state;
  static const moving_scene more[] = {
      {"ring", ring, 400}, {"hanging ring", hanging_ring, 400}, {"spring", spring, 400}};
  const int count = MOVING_COUNT + (int)(sizeof more / sizeof more[0]);
  static const struct {
    const char *name;
    double time, order;
    long steps;
  } schemes[2] = {{"implicit", 0.5, 2, 100}, {"backward-euler", 0.0625, 1, 200}};
  for (int n = 0; n < 2; n++)
    for (int k = 0; k < count; k++) {
      const moving_scene *scene = k < MOVING_COUNT ? &moving_scenes[k] : &more[k - MOVING_COUNT];
      bool stretches = scene->build == spring;
      finish runs[3];
      for (int q = 0; q < 3; q++)
        runs[q] = run_to(scene, schemes[n].name, schemes[n].time, schemes[n].steps << q);
      double dx[2], dv[2];
      for (int q = 0; q < 2; q++) {
        dx[q] = largest_difference(runs[q].x, runs[q + 1].x, 3 * NV);
        dv[q] = largest_difference(runs[q].v, runs[q + 1].v, 3 * NV);
      }
      double x = log2(dx[0] / dx[1]), v = log2(dv[0] / dv[1]),
             b = log2(fabs(runs[1].balance / runs[2].balance));
      say("%-14s %-16s x %.3f (%.1e) v %.3f (%.1e) balance %.3f (%.1e)\n", schemes[n].name, scene->name, x,
          dx[1], v, dv[1], b, runs[2].balance);
      assert_true(x > schemes[n].order - 0.15);
      assert_true(v > schemes[n].order - 0.2);
      /* where its leading error all but cancels, it has no order, but is small */
      assert_true(b > schemes[n].order - 0.3 || fabs(runs[2].balance) < 5e-7);
      if (!stretches) assert_at_most(runs[2].stretch, 1e-11);
      if (n > 0) continue;
      finish verlet = run_to(scene, "verlet", schemes[n].time, 1600);
      double limit[3 * NV];
      for (int c = 0; c < 3 * NV; c++) limit[c] = runs[2].x[c] + (runs[2].x[c] - runs[1].x[c]) / 3;
      assert_at_most(largest_difference(limit, verlet.x, 3 * NV), 0.2 * dx[1] + 1e-6);
    }
}

/* Kinetic, bending and twisting energy. */
static double energy_of(trial *t) {
  const hb_frame *f = trial_measure(t);
  return f->kinetic + f->bending + f->twisting;
}

/* A free rod that bends and flies: its energy does not grow, whatever the step; at steps that resolve the
 * motion the second-order scheme keeps it, and the angular momentum, to the square of the step or better. */
static void test_energy(void **state) {
  (void)state;
  static const double steps[5] = {2e-3, 4e-3, 0.02, 0.2, 2};
  for (int n = 0; n < 2; n++) {
    double lost[5], turned[5];
    for (int q = 0; q < 5; q++) {
      trial t = {0};
      trial_build(&t, moving_free_rod, n ? "backward-euler" : "implicit", steps[q]);
      double start = energy_of(&t), before = start, most = 0, spin[3], moment = 0, off = 0;
      memcpy(spin, t.frame->angular_momentum, sizeof spin);
      for (int k = 0; k < (q < 2 ? 1.0 / steps[q] : 50); k++) {
        trial_run(&t, 1);
        double now = energy_of(&t);
        most = fmax(most, (now - (n ? before : start)) / start);
        before = now;
      }
      for (int c = 0; c < 3; c++) {
        moment += spin[c] * spin[c];
        off += pow(t.frame->angular_momentum[c] - spin[c], 2);
      }
      lost[q] = 1 - before / start;
      turned[q] = sqrt(off / moment);
      say("%s, step %g: loses %.1e of its energy, is above %s by %.1e, angular momentum off by %.1e\n",
          n ? "backward-euler" : "implicit", steps[q], lost[q], n ? "the step before" : "the start", most,
          turned[q]);
      assert_at_most(most, n ? 1e-12 : 1e-3);
      trial_end(&t);
    }
    if (n) {
      assert_true(lost[0] > 0.05);
    } else {
      assert_at_most(lost[0], 2e-3);
      assert_true(lost[1] / lost[0] > 6);
      assert_true(turned[1] / turned[0] > 3.5);
    }
  }
}

/* Curved at rest, anisotropic, clamped, gravity. */
static void steady(hb_scene_def *def) {
  double xyz[3 * NV];
  shape_bent(NV, EDGE, (double[]){0.5, 0.8, 0.4, 0.3}, xyz);
  hb_rod_def *rod = scene_rod(def, NV, xyz, 0.05, 0.03, MASS);
  scene_form(rod, 0.06, 0.01, 0.02);
  scene_clamp_start(rod);
  scene_force(def, HB_FORCE_GRAVITY, "0", "0.2", "-0.4");
}

/* Steps that are longer than anything that happens: both schemes come to rest where the rod hangs. */
static void test_huge_steps(void **state) {
  (void)state;
  double x[2][3 * NV];
  for (int n = 0; n < 2; n++) {
    trial t = {0};
    trial_build(&t, steady, n ? "backward-euler" : "implicit", 1e3);
    trial_run(&t, 30);
    memcpy(x[n], hb_sim_const_state(t.sim)->x, sizeof x[n]);
    double speed = rod_speed(hb_sim_const_state(t.sim)->v);
    say("%s: speed %.1e after 30 steps of 1000\n", n ? "backward-euler" : "implicit", speed);
    assert_at_most(speed, 1e-9);
    trial_end(&t);
  }
  assert_near_array(x[0], x[1], 3 * NV, 1e-8);
}

/* Three rods of different kinds; from: which of the first. */
static void three_rods(hb_scene_def *def) {
  moving_free_rod(def);
  moving_anisotropic(def);
  moving_windy(def);
}

/* Error control: what each piece is allowed bounds what they come to together, and tighter is better. */
static void test_error_control(void **state) {
  (void)state;
  double error[3], pieces[3];
  finish truth = run_to(&moving_scenes[1], "verlet", 2, 8000);
  for (int k = 0; k < 3; k++) {
    trial t = {0};
    scene_begin(&t.def, "implicit", 0.5);
    moving_cantilever(&t.def);
    t.def.method.error_tolerance = k == 0 ? 1e-3 : k == 1 ? 1e-4 : 1e-5;
    trial_start(&t);
    trial_run(&t, 4);
    error[k] = largest_difference(hb_sim_const_state(t.sim)->x, truth.x, 3 * NV);
    pieces[k] = hb_sim_const_state(t.sim)->scalar[HB_S_PIECES];
    say("error_tolerance %g: %.1e off, %g pieces, %g rejected\n", t.def.method.error_tolerance, error[k],
        pieces[k], hb_sim_const_state(t.sim)->scalar[HB_S_REJECTED]);
    assert_at_most(error[k], pieces[k] * t.def.method.error_tolerance);
    trial_end(&t);
  }
  assert_true(pieces[0] > 4 && pieces[1] > 1.5 * pieces[0] && pieces[2] > 1.5 * pieces[1]);
  assert_true(error[1] < 0.5 * error[0] && error[2] < 0.5 * error[1]);
}

/* A piece that is not taken is not booked: the books close as well as without pieces. */
static void test_books(void **state) {
  (void)state;
  double balance[2], rejected[2];
  for (int k = 0; k < 2; k++) {
    trial t = {0};
    scene_begin(&t.def, "implicit", 0.02);
    moving_cantilever(&t.def);
    t.def.method.error_tolerance = k ? 1e-6 : 0;
    trial_start(&t);
    trial_run(&t, 50);
    const hb_frame *now = trial_measure(&t);
    balance[k] = fabs(now->balance) / (now->kinetic + now->bending + fabs(now->work_loads));
    rejected[k] = hb_sim_const_state(t.sim)->scalar[HB_S_REJECTED];
    say("balance %.2e of the energies, %g pieces not taken\n", balance[k], rejected[k]);
    trial_end(&t);
  }
  assert_true(rejected[1] > 0);
  assert_at_most(balance[1], fmax(0.2 * balance[0], 1e-4));
}

/* With error control too a restart has the same bits, and so has any number of threads. */
static void test_bits(void **state) {
  (void)state;
  trial a = {0}, b = {0};
  trial *both[2] = {&a, &b};
  for (int k = 0; k < 2; k++) {
    scene_begin(&both[k]->def, "implicit", 0.05);
    for (int copy = 0; copy < 8; copy++) three_rods(&both[k]->def);
    both[k]->def.method.error_tolerance = 1e-5;
    both[k]->def.method.threads = k ? 3 : 1;
    trial_start(both[k]);
  }
  trial_run(&a, 3);
  size_t count = hb_sim_const_state(a.sim)->count;
  double *saved = scene_copy(hb_sim_const_state(a.sim)->block, count);
  assert_true(hb_sim_const_state(a.sim)->piece[0] > 0 && hb_sim_const_state(a.sim)->piece[0] < 0.05);
  trial_run(&a, 4);
  trial_run(&b, 1);
  assert_int_equal(hb_sim_restore(b.sim, saved, count, NULL), HB_OK);
  trial_run(&b, 4);
  assert_memory_equal(hb_sim_const_state(a.sim)->block, hb_sim_const_state(b.sim)->block,
                      count * sizeof(double));
  hb_free(saved);
  trial_end(&a);
  trial_end(&b);
}

/* The sentence with which a run ends. */
static void ends_with(scene_builder build, const char *const *words) {
  trial t = {0};
  hb_error err = {HB_OK, ""};
  trial_build(&t, build, "implicit", 0.05);
  hb_status status = HB_OK;
  for (int k = 0; k < 100 && !status; k++) status = hb_sim_step(t.sim, &err);
  say("%s\n", err.text);
  assert_int_equal(status, HB_ERR_NUMERIC);
  for (; *words; words++)
    if (!strstr(err.text, *words)) fail_msg("\"%s\" does not say \"%s\"", err.text, *words);
  trial_end(&t);
}

/* Ends drawn further apart than the rod is long. */
static void torn(hb_scene_def *def) {
  moving_free_rod(def);
  scene_path(&def->rods[0], 0, NULL, NULL, NULL);
  scene_path(&def->rods[0], -1, "x + t", NULL, NULL);
}

/* A load without a value from t = 0.3 on. */
static void no_load(hb_scene_def *def) {
  moving_free_rod(def);
  scene_force(def, HB_FORCE_POINT, "sqrt(0.3 - t)", "0", "0")->vertex = 4;
}

/* An angle without a value. */
static void no_angle(hb_scene_def *def) {
  moving_cantilever(def);
  scene_angle(&def->rods[0], -1, "log(0.3 - t)");
}

/* Each says which rod, which step, and what is wrong. */
static void test_trouble(void **state) {
  (void)state;
  ends_with(torn, (const char *[]){"rod rod", "step ", "unbalanced force", "at vertex", NULL});
  ends_with(no_load, (const char *[]){"rod rod", "step ", "the load of vertex 4 is not finite", NULL});
  ends_with(no_angle, (const char *[]){"rod rod", "step ", "prescribed angle of edge 7 is not finite", NULL});
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_orders),        cmocka_unit_test(test_energy), cmocka_unit_test(test_huge_steps),
      cmocka_unit_test(test_error_control), cmocka_unit_test(test_books),  cmocka_unit_test(test_bits),
      cmocka_unit_test(test_trouble),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
