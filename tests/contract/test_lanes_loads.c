/* Loads of rods in lanes are those of the rod's own functions: each kind alone, all together, on some rods of
 * a bundle and not on others, beside loads that lanes know nothing of (docs/theory, 10.7). */
#include "support/lanes.h"

#include "hebra/plug.h"
#include "sim/sim.h"

#include <float.h>

/* What acts. */
enum {
  GRAVITY = 1,
  DAMPING = 2,
  WIND = 4,
  PER_LENGTH = 8,
  PER_VERTEX = 16,
  ALL_UNIFORM = 31,
  PLACES = 32, /* formulas of place, a point, a second wind: not for lanes */
  SOME = 64,   /* loads on the first and the last rod only, wind on the last only, damping on odd ones */
  SUBSETS = 128
};

/* As in test_lanes.c: what one step may differ by. */
static const trio_gap one_step = {1e-14, 1e-14, 1e-12, 1e-13, 1e-10};

/* The rods that it acts on: all, or one of the ends of the list. */
static void aim(hb_force_def *f, int rods, int what, bool last) {
  if (what & SOME) f->rod = last ? rods - 1 : 0;
}

/* Drag of every kind. */
static void add_wind(hb_scene_def *def, int what) {
  hb_force_def *wind =
      scene_force(def, HB_FORCE_WIND, "0.4*sin(7*t)", "0.8*cos(t)", "if(t > 0.01, -0.5, 0.2)");
  for (int c = 0; c < 2; c++) {
    wind->linear[c] = c ? 0.1 : 0.3;
    wind->quadratic[c] = c ? 0.05 : 0.4;
    wind->per_radius[c] = c ? 0.5 : 3;
  }
  aim(wind, def->rod_count, what, true);
}

/* The loads of a subset. */
static void add_loads(hb_scene_def *def, int what) {
  int rods = def->rod_count;
  for (int n = 0; n < rods; n++) {
    bool damped = (what & DAMPING) && (!(what & SOME) || n % 2);
    def->rods[n].mass_damping = damped ? 0.5 + 0.3 * n : 0;
    def->rods[n].radius = 0.01 * (n + 1);
  }
  if (what & GRAVITY) {
    aim(scene_force(def, HB_FORCE_GRAVITY, "0.3", NULL, "-1.5*cos(9*t)"), rods, what, false);
    aim(scene_force(def, HB_FORCE_GRAVITY, "0", "0.2", "0.1"), rods, what, true);
  }
  if (what & WIND) add_wind(def, what);
  if (what & PER_LENGTH) aim(scene_force(def, HB_FORCE_DISTRIBUTED, "0.1", "0.3*t", "0.2"), rods, what, true);
  if (what & PER_VERTEX)
    for (int n = 0; n < rods; n++) {
      hb_force_def *f = scene_force(def, HB_FORCE_PER_VERTEX, "0.01*sin(20*t)", NULL, "0.02");
      f->rod = n;
      if (what & SOME) n = rods;
    }
  if (!(what & PLACES)) return;
  hb_force_def *point = scene_force(def, HB_FORCE_POINT, "0.1", "0.2*sin(3*t)", "0.1*x");
  point->rod = rods / 2;
  point->vertex = -2;
  hb_force_def *wind = scene_force(def, HB_FORCE_WIND, "0.1*z", "0.3", "0");
  wind->linear[0] = wind->linear[1] = 0.2;
  wind->rod = rods / 3;
}

/* Random rods, the loads, all ways started. */
static void start(trio *t, rng *r, const char *integrator, int rods, const int *nv, int what) {
  *t = (trio){0};
  *r = rng_start((uint64_t)(1000 * nv[0] + 10 * rods + what));
  scene_begin(&t->def, integrator, 1e-3);
  t->def.method.duration = 1;
  for (int n = 0; n < rods; n++) {
    bool euler = strcmp(integrator, "symplectic-euler") == 0; /* which leads supports another way */
    lanes_add_rod(&t->def, r, nv[n], (lane_ends)rng_int(r, 0, euler ? LANE_INNER : LANE_CARRIED));
    if (rng_int(r, 0, 1)) t->def.rods[n].B[0] *= 1.5; /* general */
  }
  add_loads(&t->def, what);
}

/* Which way do the loads go? */
static void check_way(const trio *t, int what) {
  const hb_stepper *s = &t->sim[WAY_BEST]->stepper;
  bool any = false;
  for (int r = 0; r < t->model->rod_count; r++) {
    if (!(what & PLACES)) assert_int_equal(s->uniform[r], s->active[r]);
    any = any || (s->active[r] & ~s->uniform[r]);
  }
  assert_int_equal(any, (what & PLACES) != 0);
}

/* The loads of two ways, by the largest one. */
static double load_gap(const trio *t, int a, int b) {
  const double *p = hb_sim_const_state(t->sim[a])->load, *q = hb_sim_const_state(t->sim[b])->load;
  double largest = 1e-300;
  for (int k = 0; k < 3 * t->model->nv; k++) largest = fmax(largest, fabs(p[k]));
  return largest_difference(p, q, 3 * (size_t)t->model->nv) / largest;
}

/* Newton on the turns of a general rod ends at 16 roundings of what its rows are made of: bending moments, up
 * to 1.5/0.3 times the twisting modulus. Its softest mode makes about nv^2 times as much of that. */
static trio_gap with_turns(trio_gap allowed, int nv) {
  allowed.twist += 16 * DBL_EPSILON * 5 * nv * nv;
  return allowed;
}

/* The work of loads is a sum of load . way, and ways have the round-off of places up to 2 long: four times
 * what independent roundings come to. The first step of a rod at rest has ways of 1e-10. After trio_compare.
 */
static double work_roundoff(const trio *t) {
  const double *load = hb_sim_const_state(t->sim[WAY_PLAIN])->load;
  const hb_frame *f = t->frame[0];
  double sum = 0, all = f->kinetic + f->bending + f->twisting + fabs(f->work_loads) + 1e-30;
  for (int k = 0; k < 3 * t->model->nv; k++) sum += load[k] * load[k];
  return 4 * 2 * DBL_EPSILON * sqrt(sum) / all;
}

/* Lengths that miss the tolerance by some roundings, or meet it, are corrected once more by one way and not
 * by the other: both are right to the tolerance, but no better. Seldom: lengths must lie within 1e-4 of it.
 */
static trio_gap with_parting(trio_gap allowed, const trio *t, int *partings) {
  if (!t->parted) return allowed;
  double tolerance = t->def.method.length_tolerance;
  *partings += 1;
  assert_true(*partings <= 4);
  return (trio_gap){allowed.x + tolerance, allowed.v + tolerance, allowed.force + tolerance,
                    allowed.twist + tolerance, allowed.energy + tolerance};
}

/* One step, then some, all ways the same; loads by the velocities that they are made of. */
static void try_loads(const char *integrator, int rods, const int *nv, int what, long steps, int *partings) {
  trio t;
  rng r;
  char text[100];
  snprintf(text, sizeof text, "%s, %d rods of %d, loads %d", integrator, rods, nv[0], what);
  start(&t, &r, integrator, rods, nv, what);
  trio_start(&t, 2e-3);
  assert_true(trio_all_in_lanes(&t));
  check_way(&t, what);
  trio_push(&t, &r, 1e-14);
  trio_run(&t, 1, NULL);
  trio_gap one = trio_compare(&t, WAY_PLAIN, WAY_BEST);
  double load = load_gap(&t, WAY_PLAIN, WAY_BEST), roundoff = work_roundoff(&t);
  trio_run(&t, steps, NULL);
  trio_gap many = trio_compare(&t, WAY_PLAIN, WAY_BEST), pushed = trio_compare(&t, WAY_PLAIN, WAY_PUSHED);
  say("%s: loads %.1e\n", text, load);
  trio_say("one step", one);
  trio_say("all steps", many);
  trio_gap first = with_turns(one_step, nv[0]);
  first.energy += roundoff;
  trio_check(one, first, text);
  trio_check(many, with_parting(with_turns(trio_bound(pushed), nv[0]), &t, partings), text);
  /* forces that read no velocity are right to the last digits; velocities are 2/h times a way with the
   * round-off of places up to 2 long, against a wind of speed 0.3 or more */
  double allowed = what & (WIND | PLACES) ? 8 * DBL_EPSILON * 2 * 2 / t.def.method.time_step / 0.3 : 0;
  if (load > 1e-14 + allowed) fail_msg("%s: loads differ by %.3g", text, load);
  if (what & (GRAVITY | PER_LENGTH)) assert_true(hb_sim_const_state(t.sim[1])->scalar[HB_S_WORK_LOADS] != 0);
  trio_end(&t);
}

/* Every subset on one rod in pieces: lanes that end early, lanes with one vertex or none, several strips. */
static void test_pieces(void **state) {
  (void)state;
  static const int nv[] = {17, 18, 20, 22, 33, 1027, 2050};
  int partings = 0;
  for (int k = 0; hb_integrators[k] && !hb_integrators[k]->implicit; k++)
    for (size_t n = 0; n < sizeof nv / sizeof nv[0]; n++)
      for (int what = 1; what < SOME; what++) {
        if ((SHORTER > 1 || nv[n] > 100) && what % 7 != (int)n % 7 && what != (ALL_UNIFORM | PLACES))
          continue;
        try_loads(hb_integrators[k]->name, 1, &nv[n], what, nv[n] > 100 ? 3 : 20, &partings);
      }
}

/* Every subset on bundles: full ones, idle lanes, rods of different lengths. */
static void test_bundles(void **state) {
  (void)state;
  static const int nv[][6] = {{12, 12, 12}, {20, 19, 18, 17}, {9, 9, 8, 8, 8, 9}, {3, 3, 3, 3, 3}};
  static const int rods[] = {3, 4, 6, 5};
  int partings = 0;
  for (int k = 0; hb_integrators[k] && !hb_integrators[k]->implicit; k++)
    for (int n = 0; n < 4; n++)
      for (int what = 1; what < SUBSETS; what++) {
        if (what == SOME || what == (SOME | DAMPING) || (SHORTER > 1 && what % 7 != n)) continue;
        try_loads(hb_integrators[k]->name, rods[n], nv[n], what, 20, &partings);
      }
}

/* In float, to the digits that positions leave to velocities. */
static void test_single(void **state) {
  (void)state;
  static const int nv[2][5] = {{40}, {12, 12, 11, 12, 12}};
  for (int k = 0; hb_integrators[k] && !hb_integrators[k]->implicit; k++)
    for (int many = 0; many < 2; many++)
      for (int what = 1; what <= ALL_UNIFORM; what++) {
        trio t;
        rng r;
        start(&t, &r, hb_integrators[k]->name, many ? 5 : 1, nv[many], what);
        t.def.method.precision = HB_PRECISION_SINGLE;
        t.def.method.length_tolerance = 1e-5;
        trio_start(&t, 2e-3);
        trio_run(&t, 5, NULL);
        double gap = load_gap(&t, WAY_PLAIN, WAY_BEST);
        say("single, %s, loads %d: %.1e\n", hb_integrators[k]->name, what, gap);
        assert_true(gap < (what & WIND ? 1e-2 : 1e-6));
        trio_end(&t);
      }
}

/* One edge folded back exactly onto another has no direction: drag is that of a vertex without tangent, in
 * lanes as elsewhere, and rods beside it notice nothing. */
static void test_no_tangent(void **state) {
  (void)state;
  for (int many = 0; many < 2; many++) {
    static const int nv[2][3] = {{20}, {9, 9, 9}};
    trio t;
    rng r;
    start(&t, &r, "symplectic-euler", many ? 3 : 1, nv[many], WIND | DAMPING);
    trio_start(&t, 1e-6);
    trio_run(&t, 1, NULL);
    for (int w = 0; w < WAY_COUNT; w++) {
      double *x = hb_sim_state(t.sim[w])->x;
      memcpy(x + 15, x + 9, 3 * sizeof *x); /* vertex 5 on vertex 3 */
    }
    hb_error err = {HB_OK, ""};
    hb_status status = trio_run(&t, 1, &err);
    say("%d rods: %d %s\n", t.def.rod_count, (int)status, err.text);
    for (int k = 0; !status && k < 3 * t.model->nv; k++)
      assert_true(isfinite(hb_sim_const_state(t.sim[WAY_BEST])->load[k]));
    trio_end(&t);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_pieces),
      cmocka_unit_test(test_bundles),
      cmocka_unit_test(test_single),
      cmocka_unit_test(test_no_tangent),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
