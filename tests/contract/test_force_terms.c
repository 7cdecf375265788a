/* What every load in the list must satisfy: it adds, touches its own rod only, is minus the gradient of its
 * energy where it has one, turns with space, gives no power where it calls itself dissipative, and does
 * nothing where it is not active. */
#include "base/memory.h"
#include "hebra/plug.h"
#include "support/near.h"
#include "support/rods.h"

#include <string.h>

#define NV 9
#define NUMBERS (6 * NV)

/* Two rods of NV vertices with every kind of load on them, constants turned by a rotation. */
typedef struct scene {
  rod_case c;
  double x[NUMBERS], v[NUMBERS], m1[NUMBERS];
} scene;

/* One more load with constant components. */
static hb_force_def *add_force(hb_scene_def *def, hb_force_kind kind, const double value[3]) {
  hb_error err;
  def->forces = hb_realloc(def->forces, (size_t)def->force_count + 1, sizeof *def->forces);
  assert_non_null(def->forces);
  hb_force_def *f = &def->forces[def->force_count++];
  hb_force_def_init(f);
  f->kind = kind;
  for (int c = 0; c < 3; c++) assert_int_equal(hb_formula_constant(value[c], &f->value[c], &err), HB_OK);
  return f;
}

/* One more rod like the first. */
static void add_rod(rod_case *c) {
  rod_case other;
  rod_case_straight(&other, NV, 0.1, 1, 1);
  c->def.rods = hb_realloc(c->def.rods, 2, sizeof *c->def.rods);
  assert_non_null(c->def.rods);
  c->def.rods[1] = other.def.rods[0];
  c->def.rod_count = 2;
  hb_free(other.def.rods);
}

/* Gravity, wind, loads of every kind (dead and follower), damping on the second rod only. */
static void make_loads(scene *s, const double rotation[9]) {
  static const double vectors[6][3] = {{0.3, -9.8, 1}, {2, 0.5, -1}, {0.1, 0.2, 0.3},
                                       {-1, 4, 2},     {3, 1, -2},   {0.5, 2, -1}};
  double turned[6][3];
  rod_move(rotation, NULL, &vectors[0][0], 6, &turned[0][0]);
  (void)add_force(&s->c.def, HB_FORCE_GRAVITY, turned[0]);
  hb_force_def *f = add_force(&s->c.def, HB_FORCE_POINT, turned[3]);
  f->vertex = -2;
  (void)add_force(&s->c.def, HB_FORCE_DISTRIBUTED, turned[4]);
  (void)add_force(&s->c.def, HB_FORCE_PER_VERTEX, turned[2]);
  f = add_force(&s->c.def, HB_FORCE_PER_VERTEX,
                vectors[5]); /* along t, m1, m2: the same whatever the rotation */
  f->follower = true;
  f->rod = 0;
  f = add_force(&s->c.def, HB_FORCE_POINT, vectors[1]);
  f->follower = true;
  f->vertex = 0;
  f = add_force(&s->c.def, HB_FORCE_WIND, turned[1]);
  f->linear[0] = 0.4;
  f->linear[1] = 0.2;
  f->quadratic[0] = 0.7;
  f->quadratic[1] = 0.1;
  s->c.def.rods[1].mass_damping = 0.8;
}

/* Random shapes, velocities and directors from seed, all turned by the rotation (NULL: not at all). */
static void make(scene *s, uint64_t seed, const double *rotation, bool loads) {
  static const double none[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  const double *turn = rotation ? rotation : none;
  rng r = rng_start(seed);
  double lengths[NV];
  memset(s, 0, sizeof *s);
  rod_case_straight(&s->c, NV, 0.1, 1, 1);
  add_rod(&s->c);
  for (int k = 0; k < NV; k++) lengths[k] = 0.1;
  for (int k = 0; k < 2; k++) {
    hb_rod_def *def = &s->c.def.rods[k];
    rod_random_shape(&r, NV, lengths, 0.5, s->x + 3 * NV * k);
    rod_move(turn, NULL, s->x + 3 * NV * k, NV, s->x + 3 * NV * k);
    memcpy(def->initial, s->x + 3 * NV * k, 3 * NV * sizeof(double));
    for (int i = 0; i < NV; i++) def->mass[i] = rng_uniform(&r, 0.5, 2);
    for (int i = 0; i < NV; i++) {
      const double *e = s->x + 3 * (NV * k + i), *next = i + 1 < NV ? e + 3 : e;
      double d[3], along = 0, size = 0;
      rng_direction(&r, d);
      rod_move(turn, NULL, d, 1, d);
      for (int c = 0; c < 3; c++) along += d[c] * (next[c] - e[c]) / 0.1;
      for (int c = 0; c < 3; c++) d[c] -= along * (next[c] - e[c]) / 0.1;
      for (int c = 0; c < 3; c++) size += d[c] * d[c];
      for (int c = 0; c < 3; c++) s->m1[3 * (NV * k + i) + c] = d[c] / sqrt(size);
    }
  }
  for (int k = 0; k < NUMBERS; k++) s->v[k] = rng_uniform(&r, -3, 3);
  rod_move(turn, NULL, s->v, 2 * NV, s->v);
  if (loads) make_loads(s, turn);
  rod_case_compile(&s->c);
}

/* The force of one term on one rod, others' slots left 0. */
static void force_of(const scene *s, const hb_force_term *term, int rod, double t, double *f) {
  memset(f, 0, NUMBERS * sizeof *f);
  term->add(s->c.model, &s->c.model->rods[rod], t, s->x, s->v, s->m1, f);
}

/* Adds to what is there; reads and writes the slots of its rod only; the same bits every time. */
static void test_adds_to_its_rod(void **state) {
  (void)state;
  for (int k = 0; hb_force_terms[k]; k++)
    for (int rod = 0; rod < 2; rod++) {
      scene s;
      double f[NUMBERS], g[NUMBERS];
      make(&s, 601, NULL, true);
      if (hb_force_terms[k]->active(s.c.model, &s.c.model->rods[rod])) {
        force_of(&s, hb_force_terms[k], rod, 0.3, f);
        for (int i = 0; i < NUMBERS; i++)
          if ((i / (3 * NV)) != rod) s.x[i] = s.v[i] = s.m1[i] = (double)NAN;
        for (int i = 0; i < NUMBERS; i++) g[i] = 100 + i;
        hb_force_terms[k]->add(s.c.model, &s.c.model->rods[rod], 0.3, s.x, s.v, s.m1, g);
        for (int i = 0; i < NUMBERS; i++) {
          if (i / (3 * NV) == rod)
            assert_near(g[i], 100 + i + f[i], 1e-11);
          else
            assert_same(g[i], 100 + i);
        }
        assert_true(rod_largest(f + 3 * NV * rod, 3 * NV) > 0);
        double again[NUMBERS];
        memset(again, 0, sizeof again);
        hb_force_terms[k]->add(s.c.model, &s.c.model->rods[rod], 0.3, s.x, s.v, s.m1, again);
        assert_memory_equal(again, f, sizeof f);
      }
      rod_case_free(&s.c);
    }
}

/* Nobody is active in a scene without loads; each is active somewhere in the scene with all of them. */
static void test_active(void **state) {
  (void)state;
  scene bare, full;
  make(&bare, 602, NULL, false);
  make(&full, 602, NULL, true);
  for (int k = 0; hb_force_terms[k]; k++) {
    bool anywhere = false;
    assert_true(strlen(hb_force_terms[k]->name) > 0 && strlen(hb_force_terms[k]->text) > 0);
    for (int rod = 0; rod < 2; rod++) {
      assert_false(hb_force_terms[k]->active(bare.c.model, &bare.c.model->rods[rod]));
      anywhere = anywhere || hb_force_terms[k]->active(full.c.model, &full.c.model->rods[rod]);
    }
    assert_true(anywhere);
  }
  rod_case_free(&bare.c);
  rod_case_free(&full.c);
}

/* Force = -dE/dx, by extrapolated differences, for every term that says it has an energy. */
static void test_energy(void **state) {
  (void)state;
  int with_energy = 0;
  for (int k = 0; hb_force_terms[k]; k++) {
    const hb_force_term *term = hb_force_terms[k];
    if (!term->energy) continue;
    with_energy++;
    for (int rod = 0; rod < 2; rod++) {
      scene s;
      double f[NUMBERS], h = 0.02, t = 0.3;
      make(&s, 603, NULL, true);
      const hb_rod *r = &s.c.model->rods[rod];
      force_of(&s, term, rod, t, f);
      double scale = rod_largest(f, NUMBERS);
      for (int i = 3 * r->first; i < 3 * (r->first + r->nv); i++) {
        double keep = s.x[i], e[4];
        for (int place = 0; place < 4; place++) {
          static const double steps[4] = {-1, 1, -0.5, 0.5};
          s.x[i] = keep + steps[place] * h;
          e[place] = term->energy(s.c.model, r, t, s.x);
        }
        s.x[i] = keep;
        double whole = (e[1] - e[0]) / (2 * h), half = (e[3] - e[2]) / h;
        assert_near(-(4 * half - whole) / 3, f[i], 1e-10 * scale);
      }
      rod_case_free(&s.c);
    }
  }
  assert_true(with_energy > 0);
}

/* Everything turned, the constants of the loads as well: the force turns along. */
static void test_rotation(void **state) {
  (void)state;
  rng r = rng_start(604);
  for (int trial = 0; trial < 10; trial++) {
    double rotation[9], f[NUMBERS], g[NUMBERS];
    scene a, b;
    rod_random_rotation(&r, rotation);
    make(&a, 610 + (uint64_t)trial, NULL, true);
    make(&b, 610 + (uint64_t)trial, rotation, true);
    for (int k = 0; hb_force_terms[k]; k++)
      for (int rod = 0; rod < 2; rod++) {
        if (!hb_force_terms[k]->active(a.c.model, &a.c.model->rods[rod])) continue;
        force_of(&a, hb_force_terms[k], rod, 0.3, f);
        force_of(&b, hb_force_terms[k], rod, 0.3, g);
        rod_move(rotation, NULL, f, 2 * NV, f);
        assert_near_array(g, f, NUMBERS, 1e-12 * rod_largest(f, NUMBERS));
      }
    rod_case_free(&a.c);
    rod_case_free(&b.c);
  }
}

/* A dissipative term takes energy out at any velocity, and is nothing at rest. */
static void test_dissipative(void **state) {
  (void)state;
  int found = 0;
  for (int k = 0; hb_force_terms[k]; k++)
    for (int rod = 0; rod < 2; rod++) {
      scene s;
      double f[NUMBERS], power = 0;
      make(&s, 605, NULL, true);
      if (hb_force_terms[k]->dissipative && hb_force_terms[k]->active(s.c.model, &s.c.model->rods[rod])) {
        found++;
        force_of(&s, hb_force_terms[k], rod, 0.3, f);
        for (int i = 0; i < NUMBERS; i++) power += f[i] * s.v[i];
        assert_true(power < 0);
        memset(s.v, 0, sizeof s.v);
        force_of(&s, hb_force_terms[k], rod, 0.3, f);
        assert_near(rod_largest(f, NUMBERS), 0, 0);
      }
      rod_case_free(&s.c);
    }
  assert_true(found > 0);
}

/* The named terms' own laws: weight m g; loads add up to what was asked for; damping -c m v; drag against the
 * relative velocity, nothing where the rod goes with the wind. */
static void test_laws(void **state) {
  (void)state;
  scene s;
  double f[NUMBERS];
  make(&s, 606, NULL, true);
  const hb_model *m = s.c.model;
  for (int k = 0; hb_force_terms[k]; k++) {
    const char *name = hb_force_terms[k]->name;
    force_of(&s, hb_force_terms[k], 1, 0.3, f);
    double sum[3] = {0, 0, 0}, power = 0;
    for (int i = NV; i < 2 * NV; i++)
      for (int c = 0; c < 3; c++) sum[c] += f[3 * i + c];
    for (int i = NV; i < 2 * NV; i++)
      for (int c = 0; c < 3; c++) {
        static const double gravity[3] = {0.3, -9.8, 1}, wind[3] = {2, 0.5, -1};
        if (strcmp(name, "gravity") == 0) assert_near(f[3 * i + c], m->mass[i] * gravity[c], 1e-13);
        if (strcmp(name, "damping") == 0)
          assert_near(f[3 * i + c], -0.8 * m->mass[i] * s.v[3 * i + c], 1e-13);
        power += f[3 * i + c] * (s.v[3 * i + c] - wind[c]);
      }
    if (strcmp(name, "wind") == 0) {
      assert_true(power < 0);
      for (int i = 0; i < 2 * NV; i++) memcpy(s.v + 3 * i, (double[3]){2, 0.5, -1}, 3 * sizeof(double));
      force_of(&s, hb_force_terms[k], 1, 0.3, f);
      assert_near(rod_largest(f, NUMBERS), 0, 1e-15);
    }
    if (strcmp(name, "load") ==
        0) { /* point + force per length 0.8 + NV per vertex + follower of length |(2, 0.5, -1)| */
      double rest[3] = {-1 + 3 * 0.8 + 0.1 * NV, 4 + 1 * 0.8 + 0.2 * NV, 2 - 2 * 0.8 + 0.3 * NV},
             follower = 0;
      for (int c = 0; c < 3; c++) follower += (sum[c] - rest[c]) * (sum[c] - rest[c]);
      assert_near(follower, 4 + 0.25 + 1, 1e-12);
    }
  }
  rod_case_free(&s.c);
}

/* What a uniform load is to be on vertex i of a rod, by its definition in plug.h. */
static void law_of(const scene *s, const hb_rod *rod, const hb_uniform_load *u, int i, double f[3]) {
  const hb_model *m = s->c.model;
  int a = i > rod->first ? i - 1 : i, b = i + 1 < rod->first + rod->nv ? i + 1 : i;
  double chord[3], along = 0, length = 0, across = 0, w[3], n[3];
  for (int c = 0; c < 3; c++) {
    chord[c] = s->x[3 * b + c] - s->x[3 * a + c];
    w[c] = s->v[3 * i + c] - u->medium[c];
    length += chord[c] * chord[c];
    along += w[c] * chord[c];
  }
  along /= sqrt(length);
  for (int c = 0; c < 3; c++) {
    n[c] = w[c] - along * chord[c] / sqrt(length);
    across += n[c] * n[c];
  }
  for (int c = 0; c < 3; c++) {
    double drag = (u->linear[0] + u->quadratic[0] * sqrt(across)) * n[c] +
                  (u->linear[1] + u->quadratic[1] * fabs(along)) * along * chord[c] / sqrt(length);
    f[c] = m->mass[i] * (u->acceleration[c] - u->damping * s->v[3 * i + c]) +
           m->weight[i] * (u->per_length[c] - drag) + u->per_vertex[c];
  }
}

/* A term that calls what it does uniform does just that; it does not where formulas have places. */
static void test_uniform(void **state) {
  (void)state;
  for (int k = 0; hb_force_terms[k]; k++)
    for (int rod = 0; rod < 2; rod++) {
      const hb_force_term *term = hb_force_terms[k];
      hb_force_value values[8] = {{.uniform = false}};
      hb_uniform_load sum = {.damping = 0};
      double f[NUMBERS], law[3];
      scene s;
      make(&s, 607, NULL, true);
      const hb_rod *r = &s.c.model->rods[rod];
      assert_true(s.c.def.force_count <= 8);
      if (term->uniform && term->active(s.c.model, r)) {
        if (strcmp(term->name, "damping") != 0) assert_false(term->uniform(s.c.model, r, values, &sum));
        for (int n = 0; n < s.c.def.force_count; n++) {
          const double none[HB_VAR_COUNT] = {0};
          values[n].uniform = true;
          for (int c = 0; c < 3; c++) values[n].value[c] = hb_formula_eval(s.c.def.forces[n].value[c], none);
        }
        sum = (hb_uniform_load){.damping = 0};
        bool uniform = term->uniform(s.c.model, r, values, &sum);
        assert_int_equal(uniform, strcmp(term->name, "load") != 0); /* a point, followers */
        ;
        force_of(&s, term, rod, 0.3, f);
        for (int i = r->first; uniform && i < r->first + r->nv; i++) {
          law_of(&s, r, &sum, i, law);
          assert_near_array(f + 3 * i, law, 3, 1e-13 * rod_largest(f, NUMBERS));
        }
      }
      rod_case_free(&s.c);
    }
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_adds_to_its_rod), cmocka_unit_test(test_active),
                                     cmocka_unit_test(test_energy),          cmocka_unit_test(test_rotation),
                                     cmocka_unit_test(test_dissipative),     cmocka_unit_test(test_laws),
                                     cmocka_unit_test(test_uniform)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
