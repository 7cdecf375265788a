/* Rods step in lanes as they step vertex by vertex, whatever they are, and with the same bits whatever the
 * instructions are (docs/theory, 10). */
#include "support/lanes.h"

#include "hebra/plug.h"

/* What one step may differ by. A number of either way is a few dozen rounded operations away from the exact
 * one: 2e-16 of the rod's length in positions, the same over the time step in velocities. Forces are
 * stiffness times differences of positions, a few hundred of them near a sharp bend. The energy of a rod that
 * has just begun to move is made of such velocities. */
static const trio_gap one_step = {1e-14, 1e-14, 1e-12, 1e-13, 1e-10};

/* What a random scene is made of. */
typedef struct recipe {
  const char *integrator;
  uint64_t seed;
  int rods, nv[12];
  int ends;    /* lane_ends of all rods, or -1: each as it comes */
  int general; /* every so many rods one is general; 0: none */
  double tolerance;
  hb_length_tolerance_kind kind;
  long steps;
} recipe;

/* The definition; a sentence that names the scene goes to what. */
static void cook(const recipe *q, trio *t, rng *r, char *what, size_t room) {
  *t = (trio){0};
  *r = rng_start(q->seed);
  scene_begin(&t->def, q->integrator, 1e-3);
  t->def.method.duration =
      1; /* formulas of supports are looked at over this time for the largest stable step */
  if (q->tolerance > 0) t->def.method.length_tolerance = q->tolerance;
  t->def.method.length_tolerance_kind = q->kind;
  int at =
      snprintf(what, room, "%s, seed %lu, %s, tolerance %g, vertices", q->integrator, (unsigned long)q->seed,
               q->general ? "general" : "isotropic", t->def.method.length_tolerance);
  for (int n = 0; n < q->rods; n++) {
    lanes_add_rod(&t->def, r, q->nv[n],
                  q->ends < 0 ? (lane_ends)rng_int(r, 0, LANE_ENDS - 1) : (lane_ends)q->ends);
    if (q->general > 0 && n % q->general == 0) lanes_make_general(&t->def, r);
    at += snprintf(what + at, room - (size_t)at, " %d", q->nv[n]);
  }
  lanes_add_loads(&t->def, r);
}

/* Lanes iterate as often as the plain way: a wrong derivative, or a seam that forgets, ends in the same
 * place, later. One iteration more per rod and step for each rod's last one, which may be either side of
 * round-off. */
static void check_iterations(const trio *t, int rods, const char *what) {
  static const int counted[] = {HB_S_PROJECTIONS, HB_S_TWIST_ITERATIONS};
  for (size_t k = 0; k < sizeof counted / sizeof counted[0]; k++) {
    const hb_state *plain = hb_sim_const_state(t->sim[WAY_PLAIN]),
                   *best = hb_sim_const_state(t->sim[WAY_BEST]);
    double a = plain->scalar[counted[k]], b = best->scalar[counted[k]];
    say("%s, %s: %g iterations, in lanes %g\n", what, k ? "twist" : "lengths", a, b);
    assert_at_most(b, 1.05 * a + rods);
  }
}

/* After one step the ways agree to round-off, and after more to what becomes of round-off. */
static void try_scene(const recipe *q) {
  trio t;
  rng r;
  char what[200];
  cook(q, &t, &r, what, sizeof what);
  trio_start(&t, 2e-3);
  if (q->ends != LANE_CARRIED && q->ends != -1) assert_true(trio_all_in_lanes(&t));
  trio_push(&t, &r, 1e-14);
  trio_run(&t, 1, NULL);
  trio_gap one = trio_compare(&t, WAY_PLAIN, WAY_BEST);
  trio_run(&t, q->steps - 1, NULL);
  trio_gap many = trio_compare(&t, WAY_PLAIN, WAY_BEST), pushed = trio_compare(&t, WAY_PLAIN, WAY_PUSHED);
  say("%s: time step %.2g\n", what, t.def.method.time_step);
  trio_say("one step", one);
  trio_say("all steps", many);
  trio_say("pushed", pushed);
  trio_check(one, one_step, what);
  trio_check(many, trio_bound(pushed), what);
  check_iterations(&t, q->rods, what);
  trio_end(&t);
}

/* Every padding of pieces and bundles, every kind of ends. */
static void test_short_rods(void **state) {
  (void)state;
  for (int k = 0; hb_integrators[k] && !hb_integrators[k]->implicit; k++)
    for (int nv = 3; nv <= 40; nv++)
      for (int ends = 0; ends < LANE_ENDS; ends++) {
        if (SHORTER > 1 && ends != nv % LANE_ENDS) continue;
        recipe q = {.integrator = hb_integrators[k]->name,
                    .seed = (uint64_t)nv,
                    .rods = 1,
                    .nv = {nv},
                    .ends = ends,
                    .steps = 100};
        for (q.general = 0; q.general < 2; q.general++) try_scene(&q);
      }
}

/* Around the lengths of panels, of one strip and of two; many strips. */
static void test_long_rods(void **state) {
  (void)state;
  static const int ranges[][2] = {{63, 70}, {129, 129}, {1025, 1035}, {2048, 2070}, {5000, 5000}};
  for (int k = 0; hb_integrators[k] && !hb_integrators[k]->implicit; k++)
    for (size_t n = 0; n < sizeof ranges / sizeof ranges[0]; n++)
      for (int nv = ranges[n][0]; nv <= ranges[n][1]; nv += nv > 200 ? (SHORTER + 1) / 2 : 1)
        for (int general = 0; general < 2; general++)
          try_scene(&(recipe){.integrator = hb_integrators[k]->name,
                              .seed = (uint64_t)nv,
                              .rods = 1,
                              .nv = {nv},
                              .ends = nv % LANE_ENDS,
                              .general = general,
                              .steps = nv > 200 ? 10 : 100});
}

/* Two to eleven rods, of the same length, of lengths within 20 % and beyond. */
static void test_bundles(void **state) {
  (void)state;
  for (int k = 0; hb_integrators[k] && !hb_integrators[k]->implicit; k++)
    for (int rods = 2; rods <= 11; rods++)
      for (int spread = 0; spread < 3; spread++) {
        recipe q = {.integrator = hb_integrators[k]->name,
                    .seed = (uint64_t)(100 * rods + spread),
                    .rods = rods,
                    .ends = -1,
                    .steps = 100};
        rng r = rng_start(q.seed);
        int base = rng_int(&r, 4, 50);
        for (int n = 0; n < rods; n++)
          q.nv[n] = spread == 0 ? base : spread == 1 ? rng_int(&r, base * 4 / 5, base) : rng_int(&r, 3, 80);
        for (int n = 0; n < rods; n++)
          if (q.nv[n] < 3) q.nv[n] = 3;
        for (q.general = 0; q.general < 3; q.general++) try_scene(&q);
      }
}

/* Coarse and fine tolerances, of both kinds. */
static void test_tolerances(void **state) {
  (void)state;
  static const double tolerances[] = {1e-3, 1e-5, 6e-9, 4e-9, 1e-12, 1e-13};
  for (int k = 0; hb_integrators[k] && !hb_integrators[k]->implicit; k++)
    for (size_t n = 0; n < sizeof tolerances / sizeof tolerances[0]; n++)
      for (int kind = 0; kind < 2; kind++)
        for (int many = 0; many < 2; many++) {
          recipe q = {.integrator = hb_integrators[k]->name,
                      .seed = n + 10,
                      .rods = many ? 6 : 1,
                      .nv = {33, 21, 20, 9, 30, 27},
                      .ends = -1,
                      .steps = 100,
                      .tolerance = tolerances[n],
                      .kind = kind ? HB_TOLERANCE_ABSOLUTE : HB_TOLERANCE_RELATIVE};
          for (q.general = 0; q.general < 3; q.general += 2) try_scene(&q);
        }
}

/* Positions of the first rod after some steps, with mates that have more to correct or less. */
static void run_with_mates(const char *integrator, uint64_t mates, int nv, double tolerance, bool general,
                           double *x) {
  trio t = {0};
  rng own = rng_start(7), others = rng_start(mates);
  scene_begin(&t.def, integrator, 2e-3);
  t.def.method.length_tolerance = tolerance;
  lanes_add_rod(&t.def, &own, nv, LANE_FREE);
  if (general) lanes_make_general(&t.def, &own);
  for (int n = 0; n < 3; n++) {
    lanes_add_rod(&t.def, &others, nv, LANE_FREE);
    if (general) lanes_make_general(&t.def, &others);
    hb_rod_def *mate = &t.def.rods[t.def.rod_count - 1];
    for (int k = 0; mate->velocity && k < 3 * nv; k++) mate->velocity[k] *= (double)mates;
  }
  trio_start(&t, 0);
  trio_run(&t, 100, NULL);
  memcpy(x, hb_sim_const_state(t.sim[WAY_BEST])->x, 3 * (size_t)nv * sizeof *x);
  trio_end(&t);
}

/* Rods of a bundle do not feel each other, to the last bit, however coarse the tolerance is. */
static void test_strangers(void **state) {
  (void)state;
  static const double tolerances[] = {1e-3, 1e-6, 1e-10};
  double a[3 * 20], b[3 * 20];
  for (int k = 0; hb_integrators[k] && !hb_integrators[k]->implicit; k++)
    for (int n = 0; n < 6; n++) {
      run_with_mates(hb_integrators[k]->name, 1, 20, tolerances[n / 2], n % 2, a);
      run_with_mates(hb_integrators[k]->name, 5, 20, tolerances[n / 2], n % 2, b);
      assert_memory_equal(a, b, sizeof a);
    }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_short_rods), cmocka_unit_test(test_long_rods), cmocka_unit_test(test_bundles),
      cmocka_unit_test(test_tolerances), cmocka_unit_test(test_strangers),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
