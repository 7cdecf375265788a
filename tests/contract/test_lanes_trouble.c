/* Rods in lanes where something is out of the ordinary: they say and do what they do vertex by vertex. */
#include "support/lanes.h"

#include "hebra/plug.h"
#include "math/rotation.h"
#include "sim/sim.h"

/* Some tens of steps of smooth motion. */
static const trio_gap close_by = {1e-12, 1e-12, 1e-11, 1e-10, 1e-10};

/* Rods along x, one behind the other, lengths 1. */
static void straight_rods(trio *t, const char *integrator, double step, int rods, int nv) {
  double *x = hb_alloc(3 * (size_t)nv, sizeof *x);
  *t = (trio){0};
  scene_begin(&t->def, integrator, step);
  shape_line(nv, 1, 0, 0, x);
  for (int n = 0; n < rods; n++) {
    hb_rod_def *rod = scene_rod(&t->def, nv, x, 1e-3, 1e-3, 1.0 / nv);
    rod->name[2] = (char)('a' + n); /* roa, rob, ... */
  }
  hb_free(x);
}

/* Loads that stop being numbers end the run in the same step with the same sentence. */
static void test_loads_that_fail(void **state) {
  (void)state;
  static const int counts[3][2] = {{1, 10}, {1, 40}, {5, 12}};
  for (int k = 0; hb_integrators[k] && !hb_integrators[k]->implicit; k++)
    for (int n = 0; n < 3; n++) {
      trio t;
      hb_error err = {HB_OK, ""};
      straight_rods(&t, hb_integrators[k]->name, 1e-3, counts[n][0], counts[n][1]);
      scene_clamp_start(&t.def.rods[0]);
      hb_force_def *f = scene_force(&t.def, HB_FORCE_POINT, "0", "0", "0.1*sqrt(0.05-t)");
      f->rod = 0;
      f->vertex = 7;
      trio_start(&t, 0);
      assert_int_equal(trio_run(&t, 100, &err), HB_ERR_NUMERIC);
      assert_non_null(strstr(err.text, "step 51"));
      assert_non_null(strstr(err.text, "the load of vertex 7 is not finite any more"));
      trio_end(&t);
    }
}

/* An edge whose two vertices are led apart, by less than any correction could be blamed for. */
static void test_edge_led_apart(void **state) {
  (void)state;
  for (int nv = 10; nv <= 40; nv += 30) {
    trio t;
    hb_error err = {HB_OK, ""};
    straight_rods(&t, "verlet", 1e-3, 1, nv);
    scene_path(&t.def.rods[0], 0, "x + 0.1*t^2", NULL, NULL);
    scene_path(&t.def.rods[0], 1, "x + 0.1*t^2 + 0.01*max(0, t - 0.02)^2", NULL, NULL);
    trio_start(&t, 0);
    assert_int_equal(trio_run(&t, 100, &err), HB_ERR_NUMERIC);
    assert_non_null(strstr(err.text, "edge 0 is still off by"));
    trio_end(&t);
  }
}

/* As many projections as the scene allows. */
static void test_few_projections(void **state) {
  (void)state;
  for (int k = 0; hb_integrators[k] && !hb_integrators[k]->implicit; k++)
    for (int most = 1; most <= 8; most++)
      for (int nv = 10; nv <= 40; nv += 30) {
        trio t;
        rng r = rng_start((uint64_t)most);
        hb_error err = {HB_OK, ""};
        t = (trio){0};
        scene_begin(&t.def, hb_integrators[k]->name, 1e-2);
        lanes_add_rod(&t.def, &r, nv, LANE_CLAMPED);
        scene_force(&t.def, HB_FORCE_GRAVITY, "0", "0", "-9.81");
        t.def.method.max_projections = most;
        trio_start(&t, 0);
        trio_push(&t, &r, 1e-14);
        hb_status status = trio_run(&t, 60, &err);
        say("%s, %d projections, %d vertices: %s\n", hb_integrators[k]->name, most, nv, err.text);
        if (most == 1) assert_int_equal(status, HB_ERR_NUMERIC);
        if (!status) {
          trio_gap pushed = trio_compare(&t, WAY_PLAIN, WAY_PUSHED);
          trio_check(trio_compare(&t, WAY_PLAIN, WAY_BEST), trio_bound(pushed), "few projections");
        }
        trio_end(&t);
      }
}

/* Pulled straight, then its ends come closer: lengths along the old edges have no solution in some steps. */
static void test_taut(void **state) {
  (void)state;
  for (int nv = 12; nv <= 42; nv += 30)
    for (int rods = 1; rods <= 5; rods += 4) {
      trio t;
      straight_rods(&t, "verlet", 1e-3, rods, nv);
      hb_rod_def *rod = &t.def.rods[0];
      for (int i = 0; i < nv; i++) rod->initial[3 * i + 1] = 1e-3 * sin(3.14159265358979 * i / (nv - 1));
      rod->lengths_from_initial = true;
      scene_hold(rod, 0);
      scene_path(rod, -1, "x - 0.3*max(0, t - 0.003)", NULL, NULL);
      scene_force(&t.def, HB_FORCE_GRAVITY, "0", "0.5", "-1");
      trio_start(&t, 0);
      assert_true(trio_all_in_lanes(&t));
      rng r = rng_start(1);
      trio_push(&t, &r, 1e-14);
      trio_run(&t, 60, NULL);
      double plain = hb_sim_const_state(t.sim[WAY_PLAIN])->scalar[HB_S_FALLBACKS];
      double best = hb_sim_const_state(t.sim[WAY_BEST])->scalar[HB_S_FALLBACKS];
      trio_gap g = trio_compare(&t, WAY_PLAIN, WAY_BEST);
      say("taut, %d rods of %d vertices: %g fallbacks, %g\n", rods, nv, plain, best);
      trio_say("all steps", g);
      assert_true(plain > 0);
      assert_same(best, plain);
      trio_check(g, trio_bound(trio_compare(&t, WAY_PLAIN, WAY_PUSHED)), "taut");
      trio_end(&t);
    }
}

/* Folded flat along a line, where bending cannot say to which side: counted, at the same vertex. */
static void test_folds(void **state) {
  (void)state;
  for (int k = 0; hb_integrators[k] && !hb_integrators[k]->implicit; k++)
    for (int nv = 12; nv <= 42; nv += 30)
      for (int rods = 1; rods <= 5; rods += 4)
        for (int kind = 0; kind < 3; kind++) { /* 0: not twisted, 1: twisted, 2: general */
          trio t;
          straight_rods(&t, hb_integrators[k]->name, 1e-3, rods, nv);
          hb_rod_def *rod = &t.def.rods[rods - 1];
          if (kind == 1) {
            scene_angle(rod, 0, "0");
            scene_angle(rod, -1, "1");
          }
          if (kind == 2) scene_form(rod, 1e-3, 0, 2e-3);
          scene_force(&t.def, HB_FORCE_DISTRIBUTED, "0.1", "0", "0");
          trio_start(&t, 0);
          assert_true(trio_all_in_lanes(&t));
          trio_run(&t, 3, NULL);
          for (int w = 0; w < WAY_COUNT; w++) {
            const hb_rod *last = &t.model->rods[rods - 1];
            hb_state *s = hb_sim_state(t.sim[w]);
            for (int i = nv / 3 + 1; i < nv; i++) /* back again from vertex nv/3 on */
              s->x[3 * (last->first + i)] =
                  2 * s->x[3 * (last->first + nv / 3)] - s->x[3 * (last->first + i)];
          }
          trio_run(&t, 2, NULL); /* the force of a fold is round-off times a large number */
          const double *plain = hb_sim_const_state(t.sim[WAY_PLAIN])->scalar;
          const double *best = hb_sim_const_state(t.sim[WAY_BEST])->scalar;
          trio_gap g = trio_compare(&t, WAY_PLAIN, WAY_BEST);
          say("%s, %d rods of %d vertices, kind %d: %g folds at %g\n", hb_integrators[k]->name, rods, nv,
              kind, plain[HB_S_FOLDS], plain[HB_S_FOLD_SLOT]);
          trio_say("all steps", g);
          assert_true(plain[HB_S_FOLDS] >= 1);
          assert_same(best[HB_S_FOLDS], plain[HB_S_FOLDS]);
          assert_same(best[HB_S_FOLD_SLOT], plain[HB_S_FOLD_SLOT]);
          trio_check(g, close_by, "folded");
          trio_end(&t);
        }
}

/* A clamp that jumps by three turns: Newton in lanes gives up, the rod's own search goes on from there. */
static void test_far_turns(void **state) {
  (void)state;
  for (int k = 0; hb_integrators[k] && !hb_integrators[k]->implicit; k++)
    for (int nv = 12; nv <= 42; nv += 30)
      for (int rods = 1; rods <= 5; rods += 4)
        for (int general = 0; general < 2; general++) {
          trio t;
          rng r = rng_start(5);
          straight_rods(&t, hb_integrators[k]->name, 1e-4, rods, nv);
          for (int n = 0; n < rods; n++) {
            hb_rod_def *rod = &t.def.rods[n];
            scene_clamp_start(rod);
            scene_angle(rod, -1, n == 0 ? "6*pi*step(t - 0.00045)" : "t");
            if (general) scene_form(rod, 1e-3, 2e-4, 3e-3);
          }
          scene_force(&t.def, HB_FORCE_GRAVITY, "0", "0.5", "-1");
          trio_start(&t, 0);
          assert_true(trio_all_in_lanes(&t));
          trio_push(&t, &r, 1e-14);
          trio_run(&t, 10, NULL);
          trio_gap g = trio_compare(&t, WAY_PLAIN, WAY_BEST);
          double turns = hb_sim_const_state(t.sim[WAY_BEST])->frame_angle[1] / (2 * HB_PI);
          say("%s, %d %s rods of %d vertices\n", hb_integrators[k]->name, rods,
              general ? "general" : "isotropic", nv);
          trio_say("all steps", g);
          assert_near(turns, 3, 1e-12);
          trio_check(g, trio_bound(trio_compare(&t, WAY_PLAIN, WAY_PUSHED)), "far turn");
          trio_end(&t);
        }
}

/* Many steps at once are the same steps, to the last bit of state and totals, where some need the plain way,
 * too; and a load that fails is told of at the same step. */
static void test_many_steps_at_once(void **state) {
  (void)state;
  for (int fails = 0; fails < 2; fails++) {
    trio t;
    hb_error one = {HB_OK, ""}, many = {HB_OK, ""};
    straight_rods(&t, "verlet", 1e-3, 5, 42);
    hb_rod_def *rod = &t.def.rods[0];
    for (int i = 0; i < 42; i++) rod->initial[3 * i + 1] = 1e-3 * sin(HB_PI * i / 41);
    rod->lengths_from_initial = true;
    scene_hold(rod, 0);
    scene_path(rod, -1, "x - 0.3*max(0, t - 0.003)", NULL, NULL);
    scene_force(&t.def, HB_FORCE_DISTRIBUTED, "0", fails ? "sqrt(0.037-t)" : "0.5", "-1");
    trio_start(&t, 0);
    hb_status status = HB_OK;
    for (int k = 0; k < 61 && !status; k++) status = hb_sim_step(t.sim[WAY_PORTABLE], &one);
    assert_int_equal(hb_sim_advance(t.sim[WAY_BEST], 61, &many), status);
    assert_int_equal(status, fails ? HB_ERR_NUMERIC : HB_OK);
    assert_string_equal(many.text, one.text);
    const hb_state *a = hb_sim_const_state(t.sim[WAY_PORTABLE]), *b = hb_sim_const_state(t.sim[WAY_BEST]);
    assert_true(a->scalar[HB_S_FALLBACKS] > 0);
    if (!fails) assert_memory_equal(a->block, b->block, a->count * sizeof *a->block);
    trio_end(&t);
  }
}

/* A rod that begins in whatever direction is not taken for folded. */
static void test_directions_without_folds(void **state) {
  (void)state;
  for (int way = 0; way < 6; way++)
    for (int twisted = 0; twisted < 2; twisted++) {
      trio t = {0};
      double x[3 * 40], end[3] = {0, 0, 0};
      end[way / 2] = way % 2 ? -1 : 1;
      scene_begin(&t.def, "verlet", 1e-3);
      shape_line(40, end[0], end[1], end[2], x);
      hb_rod_def *rod = scene_rod(&t.def, 40, x, 1e-3, 1e-3, 0.025);
      if (twisted) {
        scene_angle(rod, 0, "0");
        scene_angle(rod, -1, "1");
      }
      trio_start(&t, 0);
      trio_run(&t, 2, NULL);
      const hb_strip *s = t.sim[WAY_BEST]->stepper.plan->units[0].strips;
      for (int l = 0; l < s->lanes; l++) assert_true(hb_strip_get(s, s->lowest_chi, 0, l) > 1.9);
      trio_end(&t);
    }
}

/* Pushes and moves everything, held vertices, too; free rods are laid another way, x to y to z to x. */
static void write_state(hb_state *s, int nv, bool lay) {
  for (int i = 0; i < nv; i++) {
    double *x = s->x + 3 * i, old[3] = {x[0], x[1], x[2]};
    for (int c = 0; lay && c < 3; c++) x[c] = old[(c + 2) % 3];
    s->v[3 * i] += 0.3;
    s->v[3 * i + 1] -= 0.2;
    x[2] += 0.01;
  }
}

/* What is written to the state takes effect, and held vertices come back to their places. */
static void try_written(const char *integrator, int nv, int rods, lane_ends ends, bool general) {
  trio t = {0};
  rng r = rng_start((uint64_t)(nv + rods + (int)ends));
  scene_begin(&t.def, integrator, 1e-3);
  t.def.method.duration = 1;
  for (int n = 0; n < rods; n++) {
    lanes_add_rod(&t.def, &r, nv, ends);
    if (general) lanes_make_general(&t.def, &r);
  }
  lanes_add_loads(&t.def, &r);
  trio_start(&t, 1e-3);
  trio_run(&t, 20, NULL);
  for (int w = 0; w < WAY_COUNT; w++) write_state(hb_sim_state(t.sim[w]), t.model->nv, ends == LANE_FREE);
  trio_run(&t, 20, NULL);
  trio_gap g = trio_compare(&t, WAY_PLAIN, WAY_BEST);
  say("%s, %d %s rods of %d vertices, ends %d\n", integrator, rods, general ? "general" : "isotropic", nv,
      (int)ends);
  trio_say("all steps", g);
  trio_check(g, close_by, "written");
  trio_end(&t);
}

/* Pieces and bundles. */
static void test_written_state(void **state) {
  (void)state;
  for (int k = 0; hb_integrators[k] && !hb_integrators[k]->implicit; k++)
    for (int nv = 12; nv <= 42; nv += 30)
      for (int rods = 1; rods <= 5; rods += 4)
        for (int ends = 0; ends < LANE_ENDS; ends++)
          for (int general = 0; general < 2; general++)
            try_written(hb_integrators[k]->name, nv, rods, (lane_ends)ends, general);
}

/* A block that was saved goes on with the same bits in a simulation that did something else before, and in
 * the other ways with the same numbers. */
static void test_restored_state(void **state) {
  (void)state;
  for (int k = 0; hb_integrators[k] && !hb_integrators[k]->implicit; k++)
    for (int nv = 12; nv <= 1102; nv = nv < 42 ? 42 : nv + 1060)
      for (int rods = 1, general = 0; rods <= 5; general++, rods += general % 2 ? 0 : 4) {
        trio t = {0}, u = {0};
        for (int copy = 0; copy < 2; copy++) {
          rng r = rng_start((uint64_t)(nv + rods));
          trio *one = copy ? &u : &t;
          scene_begin(&one->def, hb_integrators[k]->name, 1e-3);
          one->def.method.duration = 1;
          for (int n = 0; n < rods; n++) {
            lanes_add_rod(&one->def, &r, nv, (lane_ends)rng_int(&r, 0, LANE_CARRIED - 1));
            if (n % 2 == general % 2) lanes_make_general(&one->def, &r);
          }
          lanes_add_loads(&one->def, &r);
          trio_start(one, 1e-3);
        }
        trio_run(&t, 23, NULL);
        trio_run(&u, 11, NULL);
        size_t count = hb_sim_const_state(t.sim[WAY_BEST])->count;
        double *saved = scene_copy(hb_sim_const_state(t.sim[WAY_BEST])->block, count);
        for (int w = 0; w < WAY_COUNT; w++)
          assert_int_equal(hb_sim_restore(u.sim[w], saved, count, NULL), HB_OK);
        rng push = rng_start(2);
        trio_push(&u, &push, 1e-14);
        trio_run(&t, 17, NULL);
        trio_run(&u, 17, NULL);
        assert_memory_equal(hb_sim_const_state(t.sim[WAY_BEST])->block,
                            hb_sim_const_state(u.sim[WAY_BEST])->block, count * sizeof *saved);
        trio_check(trio_compare(&u, WAY_PLAIN, WAY_BEST), trio_bound(trio_compare(&u, WAY_PLAIN, WAY_PUSHED)),
                   "restored");
        hb_free(saved);
        trio_end(&t);
        trio_end(&u);
      }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_loads_that_fail),
      cmocka_unit_test(test_edge_led_apart),
      cmocka_unit_test(test_few_projections),
      cmocka_unit_test(test_taut),
      cmocka_unit_test(test_folds),
      cmocka_unit_test(test_directions_without_folds),
      cmocka_unit_test(test_many_steps_at_once),
      cmocka_unit_test(test_far_turns),
      cmocka_unit_test(test_written_state),
      cmocka_unit_test(test_restored_state),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
