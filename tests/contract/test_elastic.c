/* What every elastic force must satisfy, whatever the rod: nothing at rest, no net force or torque, and the
 * same answer however the rod is placed, numbered, framed, mirrored, scaled or listed (V50, 3 to 6 and 8). */
#include "base/memory.h"
#include "math/rotation.h"
#include "support/energy.h"
#include "support/near.h"
#include "support/rods.h"

#include <stdio.h>
#include <string.h>

#define TRIALS 10
#define ROOM 64

/* One rod solved: angles, directors, force and energy. */
typedef struct solved {
  rod_case c;
  double theta[ROOM], m1[ROOM], energy;
} solved;

/* Gives the rest shape explicit directors where it has natural twist, so that it can be turned and mirrored.
 */
static void make_rest_explicit(hb_rod_def *def) {
  const double *x = def->rest;
  if (!def->natural_twist) return;
  def->rest_m1 = rod_array(3 * (def->nv - 1));
  hb_v3 t = {0, 0, 0}, d = {0, 0, 0};
  double before = 0;
  for (int j = 0; j + 1 < def->nv; j++) {
    hb_v3 e = hb_v3_sub(hb_v3_load(x + 3 * j + 3), hb_v3_load(x + 3 * j)), n = hb_v3_unit(e);
    double length = hb_v3_norm(e);
    d = j == 0 ? hb_project_normal(hb_v3_load(def->first_director), n)
               : hb_turn(hb_transport(d, t, n), n, 0.5 * def->natural_twist[j] * (before + length));
    hb_v3_store(def->rest_m1 + 3 * j, d);
    before = length;
    t = n;
  }
  hb_free(def->natural_twist);
  def->natural_twist = NULL;
}

/* The random rod number seed of a family, not yet compiled. */
static void draw(solved *s, uint64_t seed, int family, int ends) {
  rng r = rng_start(seed);
  rod_case_random(&s->c, &r, (rod_family)family, (rod_ends)ends, 5);
  make_rest_explicit(&s->c.def.rods[0]);
}

/* Compiles, relaxes, and measures. */
static void solve(solved *s) {
  rod_energy e;
  rod_case_compile(&s->c);
  rod_case_start(&s->c, NULL);
  rod_case_angles(&s->c, s->theta);
  rod_case_directors(&s->c, s->m1);
  rod_energy_create(&e, &s->c.def.rods[0]);
  rod_energy_bind(&e, s->c.state->x, s->c.state->anchor_m1, s->theta);
  s->energy = creal(rod_energy_moved(&e, s->c.state->x, -1, 0));
  rod_energy_free(&e);
}

/* Prescribes in variant the edges that are held in original, at angles made from the original's. from_end:
 * edges count from the other end. angle = offset + factor * theta. */
static void hold_like(solved *variant, const solved *original, bool from_end, double offset, double factor) {
  int last = original->c.rod->nv - 2;
  for (int j = 0; j <= last; j++) {
    char text[64];
    if (original->c.model->frame_of[j] < 0) continue;
    snprintf(text, sizeof text, "%.17g", offset + factor * original->theta[j]);
    rod_hold_angle(&variant->c.def.rods[0], from_end ? last - j : j, text);
  }
}

/* Same energy; forces equal after out = map(original force), relative to the largest. */
static void check_same(const solved *variant, const solved *original, const double *expected_force) {
  int n = 3 * original->c.rod->nv;
  double scale = rod_largest(expected_force, n);
  assert_near(variant->energy, original->energy, 1e-12 * (1 + fabs(original->energy)));
  assert_at_most(rod_difference(rod_case_force(&variant->c), expected_force, n), 1e-11 * scale);
}

/* A check for one random rod. */
typedef void (*check)(uint64_t seed, int family, int ends);

/* Over all kinds of rods and ends. */
static void sweep(uint64_t seed, check one) {
  for (int family = 0; family < ROD_FAMILY_COUNT; family++)
    for (int ends = 0; ends < ROD_ENDS_COUNT; ends++)
      for (int k = 0; k < TRIALS; k++) one(seed + (uint64_t)(100 * family + 20 * ends + k), family, ends);
}

/* Rest and initial shape, all directors turned and shifted: the force turns along. */
static void rigid_motion(uint64_t seed, int family, int ends) {
  solved a, b;
  rng r = rng_start(seed + 5000);
  double rotation[9], shift[3] = {0.3, -2, 1.1}, force[ROOM];
  rod_random_rotation(&r, rotation);
  draw(&a, seed, family, ends);
  solve(&a);
  draw(&b, seed, family, ROD_FREE_FREE);
  hb_rod_def *def = &b.c.def.rods[0];
  rod_move(rotation, shift, def->rest, def->nv, def->rest);
  rod_move(rotation, shift, def->initial, def->nv, def->initial);
  if (def->rest_m1) rod_move(rotation, NULL, def->rest_m1, def->nv - 1, def->rest_m1);
  rod_move(rotation, NULL, a.c.state->anchor_m1, 1, def->first_director);
  hold_like(&b, &a, false, 0, 1);
  solve(&b);
  rod_move(rotation, NULL, rod_case_force(&a.c), def->nv, force);
  check_same(&b, &a, force);
  for (int k = 0; k < a.c.model->frame_count; k++)
    assert_near(b.c.state->frame_torque[k], a.c.state->frame_torque[k],
                1e-11 * (1 + fabs(a.c.state->frame_torque[k])));
  rod_case_free(&a.c);
  rod_case_free(&b.c);
}

/* Turned and shifted. */
static void test_rigid_motion(void **state) {
  (void)state;
  sweep(1000, rigid_motion);
}

/* Another first Bishop director, angles shifted: nothing changes. */
static void frame_choice(uint64_t seed, int family, int ends) {
  solved a, b;
  rng r = rng_start(seed + 5000);
  double turn = rng_uniform(&r, -3, 3);
  draw(&a, seed, family, ends);
  solve(&a);
  draw(&b, seed, family, ROD_FREE_FREE);
  hb_v3 u = hb_turn(hb_v3_load(a.c.state->anchor_m1), hb_v3_load(a.c.work.tangent), turn);
  hb_v3 rest_director = hb_v3_load(b.c.def.rods[0].first_director);
  hb_v3_store(b.c.def.rods[0].first_director, u);
  if (!b.c.def.rods[0].rest_m1) { /* the straight rest shape keeps the directors that it had */
    int ne = b.c.def.rods[0].nv - 1;
    b.c.def.rods[0].rest_m1 = rod_array(3 * ne);
    for (int j = 0; j < ne; j++) hb_v3_store(b.c.def.rods[0].rest_m1 + 3 * j, rest_director);
  }
  hold_like(&b, &a, false, -turn, 1);
  solve(&b);
  check_same(&b, &a, rod_case_force(&a.c));
  if (a.c.rod->frame_count > 0) assert_near_array(b.m1, a.m1, 3 * (a.c.rod->nv - 1), 1e-11);
  rod_case_free(&a.c);
  rod_case_free(&b.c);
}

/* Framed otherwise. */
static void test_frame_choice(void **state) {
  (void)state;
  sweep(2000, frame_choice);
}

/* Puts rows of so many doubles in the opposite order. */
static void reverse(double *a, int rows, int width) {
  for (int i = 0; i < rows / 2; i++)
    for (int c = 0; c < width; c++) {
      double keep = a[width * i + c];
      a[width * i + c] = a[width * (rows - 1 - i) + c];
      a[width * (rows - 1 - i) + c] = keep;
    }
}

/* Vertices counted from the other end: tangents and second directors change sign, so B12 does. */
static void reversal(uint64_t seed, int family, int ends) {
  solved a, b;
  double force[ROOM];
  draw(&a, seed, family, ends);
  solve(&a);
  draw(&b, seed, family, ROD_FREE_FREE);
  hb_rod_def *def = &b.c.def.rods[0];
  int nv = def->nv, last = nv - 2;
  reverse(def->rest, nv, 3);
  reverse(def->initial, nv, 3);
  reverse(def->beta, nv, 1);
  reverse(def->B, nv - 1, 3);
  if (!def->rest_m1) {
    def->rest_m1 = rod_array(3 * (nv - 1));
    for (int j = 0; j <= last; j++) memcpy(def->rest_m1 + 3 * j, def->first_director, 3 * sizeof(double));
  } else {
    reverse(def->rest_m1, nv - 1, 3);
  }
  for (int j = 0; j <= last; j++) def->B[3 * j + 1] = -def->B[3 * j + 1];
  memcpy(def->first_director, a.m1 + 3 * last, 3 * sizeof(double));
  hold_like(&b, &a, true, a.theta[last], -1);
  solve(&b);
  memcpy(force, rod_case_force(&a.c), 3 * (size_t)nv * sizeof(double));
  reverse(force, nv, 3);
  check_same(&b, &a, force);
  rod_case_free(&a.c);
  rod_case_free(&b.c);
}

/* Numbered from the other end. */
static void test_reversal(void **state) {
  (void)state;
  sweep(3000, reversal);
}

/* Changes the sign of every third component. */
static void mirror(double *a, int count) {
  for (int i = 0; i < count; i++) a[3 * i + 2] = -a[3 * i + 2];
}

/* The mirror image: angles and B12 change sign, energy does not, the force is mirrored. */
static void mirror_image(uint64_t seed, int family, int ends) {
  solved a, b;
  double force[ROOM];
  draw(&a, seed, family, ends);
  solve(&a);
  draw(&b, seed, family, ROD_FREE_FREE);
  hb_rod_def *def = &b.c.def.rods[0];
  int nv = def->nv;
  if (!def->rest_m1) {
    def->rest_m1 = rod_array(3 * (nv - 1));
    for (int j = 0; j + 1 < nv; j++) memcpy(def->rest_m1 + 3 * j, def->first_director, 3 * sizeof(double));
  }
  mirror(def->rest, nv);
  mirror(def->initial, nv);
  mirror(def->rest_m1, nv - 1);
  for (int j = 0; j + 1 < nv; j++) def->B[3 * j + 1] = -def->B[3 * j + 1];
  memcpy(def->first_director, a.c.state->anchor_m1, 3 * sizeof(double));
  mirror(def->first_director, 1);
  hold_like(&b, &a, false, 0, -1);
  solve(&b);
  memcpy(force, rod_case_force(&a.c), 3 * (size_t)nv * sizeof(double));
  mirror(force, nv);
  check_same(&b, &a, force);
  rod_case_free(&a.c);
  rod_case_free(&b.c);
}

/* Mirrored. */
static void test_mirror(void **state) {
  (void)state;
  sweep(4000, mirror_image);
}

/* Internal forces: no net force; their torque is what the supports of held frames give. */
static void balance(uint64_t seed, int family, int ends) {
  solved a;
  draw(&a, seed, family, ends);
  solve(&a);
  const double *f = rod_case_force(&a.c);
  hb_v3 sum = {0, 0, 0}, torque = {0, 0, 0};
  double scale = rod_largest(f, 3 * a.c.rod->nv), reach = 0;
  for (int i = 0; i < a.c.rod->nv; i++) {
    hb_v3 x = hb_v3_load(a.c.state->x + 3 * i), force = hb_v3_load(f + 3 * i);
    sum = hb_v3_add(sum, force);
    torque = hb_v3_add(torque, hb_v3_cross(x, force));
    reach = fmax(reach, hb_v3_norm(x));
  }
  for (int k = 0; k < a.c.model->frame_count; k++) {
    hb_v3 t = hb_v3_load(a.c.work.tangent + 3 * a.c.model->frames[k].slot);
    torque = hb_v3_axpy(torque, -a.c.state->frame_torque[k], t);
    scale = fmax(scale, fabs(a.c.state->frame_torque[k]) / reach);
  }
  assert_at_most(hb_v3_norm(sum), 1e-13 * scale);
  assert_at_most(hb_v3_norm(torque), 1e-13 * scale * (1 + reach) * 3);
  rod_case_free(&a.c);
}

/* Newton and Euler. */
static void test_balance(void **state) {
  (void)state;
  sweep(5000, balance);
}

/* Stiffness times 1e-6 and 1e6, lengths times 1e-3: energy as B/L, force as B/L^2. */
static void scaling(uint64_t seed, int family, int ends) {
  static const struct { double stiffness, length; } factors[] = {{1e-6, 1}, {1e6, 1}, {1, 1e-3}, {1e6, 1e-3}};
  solved a;
  draw(&a, seed, family, ends);
  solve(&a);
  for (int k = 0; k < 4; k++) {
    solved b;
    double force[ROOM], stiffness = factors[k].stiffness, length = factors[k].length;
    draw(&b, seed, family, ends);
    hb_rod_def *def = &b.c.def.rods[0];
    for (int i = 0; i < def->nv; i++) def->beta[i] *= stiffness;
    for (int j = 0; j < 3 * (def->nv - 1); j++) def->B[j] *= stiffness;
    for (int i = 0; i < 3 * def->nv; i++) def->rest[i] *= length;
    for (int i = 0; i < 3 * def->nv; i++) def->initial[i] *= length;
    solve(&b);
    for (int i = 0; i < 3 * def->nv; i++)
      force[i] = rod_case_force(&b.c)[i] / (stiffness / (length * length));
    double largest = rod_largest(rod_case_force(&a.c), 3 * def->nv);
    assert_at_most(rod_difference(force, rod_case_force(&a.c), 3 * def->nv), 1e-11 * largest);
    assert_near(b.energy / (stiffness / length), a.energy, 1e-12 * (1 + a.energy));
    rod_case_free(&b.c);
  }
  rod_case_free(&a.c);
}

/* In other units. */
static void test_scale(void **state) {
  (void)state;
  sweep(6000, scaling);
}

/* At its rest shape, wherever that lies, and with its ends held as they are at rest, a rod feels nothing. */
static void at_rest(uint64_t seed, int family, int ends) {
  solved a;
  rng r = rng_start(seed + 5000);
  double rotation[9], shift[3] = {1, 2, 3}, sum = 0;
  rod_random_rotation(&r, rotation);
  draw(&a, seed, family, ROD_FREE_FREE);
  hb_rod_def *def = &a.c.def.rods[0];
  rod_move(rotation, shift, def->rest, def->nv, def->initial);
  rod_move(rotation, NULL, def->rest_m1 ? def->rest_m1 : def->first_director, 1, def->first_director);
  rod_case plain = a.c;
  rod_case_compile(&plain); /* its rest twists are the angles to hold */
  for (int j = 0; j + 1 < def->nv; j++) {
    char text[64];
    bool held = (j == 0 && (ends == ROD_CLAMPED_FREE || ends == ROD_CLAMPED_CLAMPED)) ||
                (j == def->nv - 2 && ends == ROD_CLAMPED_CLAMPED) || (j == 2 && ends == ROD_CLAMPED_INNER);
    if (j > 0) sum += plain.model->rest_twist[j];
    snprintf(text, sizeof text, "%.17g", sum);
    if (held) rod_hold_angle(def, j, text);
  }
  hb_rod_work_free(&plain.work);
  hb_state_free(plain.state);
  hb_model_free(plain.model);
  solve(&a);
  double h = a.c.model->rest_length[0], stiffness = rod_largest(def->B, 3 * (def->nv - 1));
  assert_at_most(fabs(a.energy), 1e-25 * stiffness / h);
  assert_at_most(rod_largest(rod_case_force(&a.c), 3 * def->nv), 1e-13 * stiffness / (h * h));
  rod_case_free(&a.c);
}

/* At rest. */
static void test_rest(void **state) {
  (void)state;
  sweep(7000, at_rest);
}

/* Two rods in one scene, in both orders: the same bits for each. */
static void test_listing(void **state) {
  (void)state;
  for (uint64_t seed = 8000; seed < 8016; seed++) {
    double force[2][2][ROOM];
    for (int order = 0; order < 2; order++) {
      rod_case parts[2], both;
      hb_error err;
      hb_sim *sim = NULL;
      for (int k = 0; k < 2; k++) {
        rng r = rng_start(seed + 100 * (uint64_t)k);
        int kind = (int)(seed + (uint64_t)k) % ROD_FAMILY_COUNT;
        rod_case_random(&parts[k], &r, (rod_family)kind,
                        (rod_ends)((seed / 4 + (uint64_t)k) % ROD_ENDS_COUNT), 3);
      }
      both = parts[order];
      both.def.rods = hb_realloc(both.def.rods, 2, sizeof *both.def.rods);
      assert_non_null(both.def.rods);
      both.def.rods[1] = parts[1 - order].def.rods[0];
      both.def.rod_count = 2;
      hb_free(parts[1 - order].def.rods);
      assert_int_equal(hb_model_create(&both.def, &both.model, &err), HB_OK);
      assert_int_equal(hb_sim_create(both.model, &sim, &err), HB_OK);
      for (int k = 0; k < 2; k++) {
        const hb_rod *rod = &both.model->rods[order ? 1 - k : k];
        memcpy(force[order][k], hb_sim_const_state(sim)->force + 3 * rod->first,
               3 * (size_t)rod->nv * sizeof(double));
        if (order == 1) assert_memory_equal(force[1][k], force[0][k], 3 * (size_t)rod->nv * sizeof(double));
      }
      hb_sim_free(sim);
      rod_case_free(&both);
    }
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_rest),         cmocka_unit_test(test_balance),
                                     cmocka_unit_test(test_rigid_motion), cmocka_unit_test(test_frame_choice),
                                     cmocka_unit_test(test_reversal),     cmocka_unit_test(test_mirror),
                                     cmocka_unit_test(test_scale),        cmocka_unit_test(test_listing)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
