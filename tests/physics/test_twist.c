/* Quasi-static twist: the Newton solver against smooth solutions on a frozen arc, from starts far away, along
 * a slowly turned end, and against the closed form. */
#include "math/rotation.h"
#include "support/energy.h"
#include "support/near.h"
#include "support/rods.h"

#include <stdio.h>
#include <string.h>

#define ROOM 1600

/* ---- V28: material frame on a frozen circular arc. Bending and twisting make a pendulum equation of the
 * angle. ---- */

/* theta(L) and what belongs to it: theta at L/4, L/2, 3L/4 (0: not known), end torque, start torque, energy.
 * From a Chebyshev collocation of beta theta'' = kappa^2 (B22 - B11) sin theta cos theta (rest straight), or
 * of beta theta'' = alpha kappa khat sin theta (isotropic, natural curvature khat = 2); kappa = 3, L = 1.2,
 * beta = 0.015. */
typedef struct arc_row {
  bool natural;
  double end, quarter, half, three, torque, start_torque, energy;
} arc_row;
static const arc_row arc_rows[] = {{false, 0.25 * HB_PI, 0.0036394127095, 0.022617830198, 0.1367218931,
                                    0.063639707683, 0.00011132834442, 0.13436042412},
                                   {false, 0.5 * HB_PI, 0.008786181955, 0.054592645445, 0.32762729199,
                                    0.090000401309, 0.00026876717586, 0.19800020066},
                                   {false, 0.75 * HB_PI, 0.021209461631, 0.13163312809, 0.75936086559,
                                    0.063642917512, 0.00064880614483, 0.26164077972},
                                   {false, 2 * HB_PI, 1.5707963268, 3.1415926536, 4.7123889804,
                                    0.055427935131, 0.055427935131, 0.50369991826},
                                   {true, 0.5 * HB_PI, 0, 0.29281929737, 0, 0.060185055884, 0, 0},
                                   {true, 0.9 * HB_PI, 0, 0.59768893065, 0, 0.084363195864, 0, 0}};

/* A polygon of nv vertices with equal turns; its end edges are clamped at their midpoints, nv-2 spacings
 * apart. */
static void make_arc(rod_case *c, const arc_row *row, int nv) {
  double h = 1.2 / (nv - 2);
  char angle[64];
  rod_case_straight(c, nv, h, 0.02, 0.015);
  hb_rod_def *def = &c->def.rods[0];
  rod_set_bending(def, 0.02, 0, row->natural ? 0.02 : 0.08);
  for (int which = 0; which < 2; which++) {
    double *x = which ? def->initial : def->rest, curvature = which ? 3 : row->natural ? 2 : 0;
    for (int j = 0; j + 1 < nv; j++) {
      x[3 * j + 3] = x[3 * j] + h * cos(curvature * h * j);
      x[3 * j + 4] = x[3 * j + 1] + h * sin(curvature * h * j);
    }
  }
  snprintf(angle, sizeof angle, "%.17g", row->end);
  rod_hold_angle(def, 0, "0");
  rod_hold_angle(def, -1, angle);
  rod_case_compile(c);
}

/* What the row holds, measured on nv vertices. */
static arc_row solve_arc(const arc_row *row, int nv) {
  rod_case c;
  rod_energy e;
  double theta[ROOM];
  int quarter = (nv - 2) / 4;
  make_arc(&c, row, nv);
  rod_case_start(&c, NULL);
  rod_case_angles(&c, theta);
  rod_energy_create(&e, &c.def.rods[0]);
  rod_energy_bind(&e, c.state->x, c.state->anchor_m1, theta);
  arc_row found = {row->natural,
                   theta[nv - 2],
                   theta[quarter],
                   theta[2 * quarter],
                   theta[3 * quarter],
                   c.state->frame_torque[1],
                   -c.state->frame_torque[0],
                   creal(rod_energy_moved(&e, c.state->x, -1, 0))};
  rod_energy_free(&e);
  rod_case_free(&c);
  return found;
}

/* Three meshes: the order, and the value for an infinitely fine mesh by extrapolation (errors in h^2, h^4).
 */
static void check_convergence(double coarse, double middle, double fine, double exact) {
  double order = log2((coarse - exact) / (middle - exact)), finer = log2((middle - exact) / (fine - exact));
  assert_near(order, 2, 0.15);
  assert_near(finer, 2, 0.1);
  double first = (4 * middle - coarse) / 3, second = (4 * fine - middle) / 3;
  assert_near_rel((16 * second - first) / 15, exact, 2e-7);
}

/* Every row of the table: second order, and the right value in the limit. */
static void test_arc(void **state) {
  (void)state;
  for (size_t k = 0; k < sizeof arc_rows / sizeof arc_rows[0]; k++) {
    const arc_row *row = &arc_rows[k];
    arc_row a = solve_arc(row, 42), b = solve_arc(row, 82), c = solve_arc(row, 162);
    check_convergence(a.torque, b.torque, c.torque, row->torque);
    if (row->end < 6)
      check_convergence(a.half, b.half, c.half, row->half);
    else
      assert_near(c.half, row->half, 1e-10); /* half way round by symmetry, on every mesh */
    if (row->natural) continue;
    check_convergence(a.start_torque, b.start_torque, c.start_torque, row->start_torque);
    if (row->end < 6) check_convergence(a.quarter, b.quarter, c.quarter, row->quarter);
    if (row->end < 6) check_convergence(a.three, b.three, c.three, row->three);
    check_convergence(a.energy, b.energy, c.energy, row->energy);
  }
}

/* The errors of the end torque that an independent solver of the same discrete problem has, on five meshes.
 */
static void test_arc_mesh(void **state) {
  (void)state;
  static const double errors[5] = {-3.85e-2, -8.39e-3, -2.04e-3, -5.07e-4, -1.27e-4};
  for (int k = 0, nv = 12; k < 5; k++, nv = 2 * nv - 2) {
    double error = solve_arc(&arc_rows[1], nv).torque / arc_rows[1].torque - 1;
    assert_near_rel(error, errors[k], 4e-3);
  }
}

/* The trap of this case: plain Newton from evenly spread twist runs away where the library's solver arrives.
 */
static void test_arc_trap(void **state) {
  (void)state;
  double u0[3] = {0, 1, 0};
  for (int nv = 12; nv <= 42; nv = 2 * nv - 2) {
    rod_case c;
    rod_energy e;
    double theta[ROOM], most = 0;
    make_arc(&c, &arc_rows[1], nv);
    rod_energy_create(&e, &c.def.rods[0]);
    for (int j = 0; j + 1 < nv; j++) theta[j] = arc_rows[1].end * j / (nv - 2);
    rod_energy_bind(&e, c.model->initial, u0, theta);
    (void)rod_energy_moved(&e, c.model->initial, -1, 0);
    for (int k = 0; k < 60; k++) {
      (void)rod_energy_newton(&e, theta);
      most = fmax(most, rod_largest(theta, nv - 1));
    }
    assert_true(most > 1e5);
    rod_case_start(&c, NULL);
    rod_case_angles(&c, theta);
    for (int j = 0; j + 1 < nv; j++) assert_true(theta[j] > -1e-12 && theta[j] < arc_rows[1].end + 1e-12);
    assert_at_most(c.state->scalar[HB_S_TWIST_ITERATIONS], 12);
    rod_energy_free(&e);
    rod_case_free(&c);
  }
}

/* ---- starts far away
 * ---------------------------------------------------------------------------------------------- */

/* Every free frame turned at random, every twist wound by up to so many turns. */
static void spoil(rod_case *c, rng *r, int turns) {
  int ne = c->rod->nv - 1;
  double *m1 = c->state->m1;
  for (int j = 0; j < ne; j++) {
    hb_v3 d =
        hb_turn(hb_v3_load(m1 + 3 * j), hb_v3_load(c->work.tangent + 3 * j), rng_uniform(r, -HB_PI, HB_PI));
    if (c->model->frame_of[j] < 0) hb_v3_store(m1 + 3 * j, d);
  }
  for (int i = 1; i < ne; i++) {
    hb_v3 t = hb_v3_load(c->work.tangent + 3 * i - 3), n = hb_v3_load(c->work.tangent + 3 * i);
    hb_v3 carried = hb_transport(hb_v3_load(m1 + 3 * i - 3), t, n);
    c->state->twist[i] =
        hb_angle_about(carried, hb_v3_load(m1 + 3 * i), n) + 2 * HB_PI * rng_int(r, -turns, turns);
  }
}

/* The energy by the independent function, at the library's angles now. */
static double energy_now(rod_case *c, rod_energy *e, double *theta) {
  rod_case_angles(c, theta);
  rod_energy_bind(e, c->state->x, c->state->anchor_m1, theta);
  return creal(rod_energy_moved(e, c->state->x, -1, 0));
}

/* Twists and directors must tell the same story, up to whole turns. */
static void check_consistent(const rod_case *c) {
  for (int i = 1; i + 1 < c->rod->nv; i++) {
    hb_v3 t = hb_v3_load(c->work.tangent + 3 * i - 3), n = hb_v3_load(c->work.tangent + 3 * i);
    hb_v3 d = hb_v3_load(c->state->m1 + 3 * i),
          carried = hb_transport(hb_v3_load(c->state->m1 + 3 * i - 3), t, n);
    double turns = (c->state->twist[i] - hb_angle_about(carried, d, n)) / (2 * HB_PI);
    assert_near(turns, rint(turns), 1e-12);
    assert_near(hb_v3_dot(d, n), 0, 1e-13);
    assert_near(hb_v3_dot(d, d), 1, 1e-13);
  }
}

/* Down to round-off, and the energy never above the start's; after the next evaluation as well. */
static void test_far_starts(void **state) {
  (void)state;
  rng r = rng_start(201);
  hb_error err;
  for (int turns = 0; turns <= 10; turns += 5)
    for (int family = 0; family < ROD_FAMILY_COUNT; family++)
      for (int ends = 0; ends < ROD_ENDS_COUNT; ends++)
        for (int k = 0; k < 12; k++) {
          rod_case c;
          rod_energy e;
          double theta[ROOM], gradient[ROOM];
          rod_case_random(&c, &r, (rod_family)family, (rod_ends)ends, turns);
          if (!c.def.rods[0].viscosity)
            c.def.rods[0].viscosity = rod_array(c.def.rods[0].nv); /* no closed form */
          rod_case_compile(&c);
          rod_case_start(&c, NULL);
          rod_energy_create(&e, &c.def.rods[0]);
          spoil(&c, &r, turns);
          double stiffest =
              rod_largest(c.model->twist_gain, c.rod->nv); /* what an angle's round-off is worth */
          double before = energy_now(&c, &e, theta);
          assert_int_equal(hb_twist_relax(c.model, c.rod, c.state, &c.work, &err), HB_OK);
          double after = energy_now(&c, &e, theta), scale = rod_energy_gradient(&e, theta, gradient);
          assert_at_most(after, before * (1 + 1e-14));
          for (int j = 0; j + 1 < c.rod->nv; j++)
            if (!e.held[j])
              assert_near(gradient[j], 0,
                          2e-15 * (scale + stiffest) * (30 + rod_largest(theta, c.rod->nv - 1)));
          rod_case_evaluate(&c, NULL, 0);
          assert_near_rel(energy_now(&c, &e, theta), after, 1e-13);
          scale = rod_energy_gradient(&e, theta, gradient);
          for (int j = 0; j + 1 < c.rod->nv; j++)
            if (!e.held[j])
              assert_near(gradient[j], 0,
                          1e-15 * (scale + stiffest) * (30 + rod_largest(theta, c.rod->nv - 1)));
          check_consistent(&c);
          rod_energy_free(&e);
          rod_case_free(&c);
        }
}

/* The solution is a minimum: small random turns of the free frames never lower the energy. */
static void test_minimum(void **state) {
  (void)state;
  rng r = rng_start(202);
  for (int k = 0; k < 120; k++) {
    rod_case c;
    rod_energy e;
    double theta[ROOM], shaken[ROOM];
    double complex x[ROOM];
    rod_case_random(&c, &r, (rod_family)(1 + k % 3), (rod_ends)(k / 3 % ROD_ENDS_COUNT), 3);
    rod_case_compile(&c);
    rod_case_start(&c, NULL);
    rod_energy_create(&e, &c.def.rods[0]);
    double least = energy_now(&c, &e, theta);
    for (int i = 0; i < 3 * c.rod->nv; i++) x[i] = c.state->x[i];
    for (int trial = 0; trial < 40; trial++) {
      for (int j = 0; j + 1 < c.rod->nv; j++) shaken[j] = theta[j] + rng_uniform(&r, -0.02, 0.02);
      assert_true(creal(rod_energy_value(&e, x, shaken)) >= least - 1e-13 * (1 + fabs(least)));
    }
    rod_energy_free(&e);
    rod_case_free(&c);
  }
}

/* Bent exactly in its stiff plane with both ends held there: the gradient is 0, the energy a maximum. It must
 * not stay there at the start. */
static void test_saddle(void **state) {
  (void)state;
  static const arc_row row = {false, 0, 0, 0, 0, 0, 0, 0};
  double theta[ROOM], shaken[ROOM];
  double complex x[3 * 100];
  rng r = rng_start(204);
  for (int nv = 12; nv <= 82; nv = 2 * nv - 2) {
    rod_case soft, stiff;
    rod_energy e;
    make_arc(&soft, &row, nv); /* in its soft plane: stays */
    rod_case_start(&soft, NULL);
    rod_case_angles(&soft, theta);
    assert_near(rod_largest(theta, nv - 1), 0, 1e-13);
    stiff = soft;
    rod_set_bending(&stiff.def.rods[0], 0.08, 0, 0.02);
    rod_case_compile(&stiff);
    rod_case_start(&stiff, NULL);
    rod_energy_create(&e, &stiff.def.rods[0]);
    double least = energy_now(&stiff, &e, theta);
    for (int k = 0; k < 3 * nv; k++) x[k] = stiff.state->x[k];
    assert_near(fabs(theta[nv / 2]), 0.5 * HB_PI, 0.2);
    for (int trial = 0; trial < 50; trial++) {
      for (int j = 0; j + 1 < nv; j++) shaken[j] = theta[j] + rng_uniform(&r, -0.05, 0.05);
      assert_true(creal(rod_energy_value(&e, x, shaken)) > least);
    }
    rod_energy_free(&e);
    hb_rod_work_free(&stiff.work);
    hb_state_free(stiff.state);
    hb_model_free(stiff.model);
    rod_case_free(&soft);
  }
}

/* Rods that nothing holds and that are all but straight: next to nothing decides how the frames lie, and it
 * does. */
static void test_all_but_straight(void **state) {
  (void)state;
  rng r = rng_start(203);
  for (int nv = 6; nv <= 506; nv += 250)
    for (int power = 2; power <= 16; power++)
      for (int held = 0; held < 2; held++) {
        rod_case c;
        rod_energy e;
        double theta[ROOM], gradient[ROOM];
        rod_case_straight(&c, nv, 0.1, 1, 0.7);
        hb_rod_def *def = &c.def.rods[0];
        rod_set_bending(def, 0.4, 0.1, 0.9);
        for (int k = 0; k < 3 * nv; k++) def->initial[k] += pow(10, -power) * rng_uniform(&r, -0.1, 0.1);
        if (held) rod_hold_angle(def, nv / 2, "0.3");
        rod_case_compile(&c);
        rod_case_start(&c, NULL);
        assert_at_most(c.state->scalar[HB_S_TWIST_ITERATIONS], 30);
        rod_energy_create(&e, def);
        (void)energy_now(&c, &e, theta);
        double scale = rod_energy_gradient(&e, theta, gradient),
               stiffest = rod_largest(c.model->twist_gain, nv);
        for (int j = 0; j + 1 < nv; j++)
          if (!e.held[j]) assert_near(gradient[j], 0, 1e-13 * (scale + stiffest));
        for (int i = 1; i + 1 < nv; i++)
          scale = fmax(scale, c.model->twist_gain[i] * fabs(theta[i] - theta[i - 1]));
        double residual, own;
        hb_twist_residual(c.rod, &c.work, &residual, &own);
        assert_at_most(residual, 2e-14 * scale + 2e-15 * stiffest);
        rod_energy_free(&e);
        rod_case_free(&c);
      }
}

/* ---- turning an end slowly
 * ---------------------------------------------------------------------------------------- */

/* A gently curved rod whose last edge is turned by 2 turns between t = 0 and 1; its minimum is unique. */
static void make_turned(rod_case *c, rng *r, bool isotropic, const char *angle) {
  int nv = 12;
  double lengths[12];
  rod_case_straight(c, nv, 0.1, 0.05, 0.08);
  hb_rod_def *def = &c->def.rods[0];
  if (!isotropic) rod_set_bending(def, 0.05, 0.01, 0.09);
  for (int j = 0; j < nv; j++) lengths[j] = 0.1;
  rod_random_shape(r, nv, lengths, 0.12, def->initial);
  rod_hold_angle(def, 0, "0");
  rod_hold_angle(def, -1, angle);
  rod_case_compile(c);
}

/* Turns it in so many steps, checking every one; leaves the final angles in theta. */
static void turn_slowly(rod_case *c, int steps, double *theta) {
  double before[ROOM], torque = 0, energy = 0;
  rod_energy e;
  int last = c->rod->nv - 2;
  rod_energy_create(&e, &c->def.rods[0]);
  rod_case_start(c, NULL);
  for (int k = 0; k <= steps; k++) {
    double t = (double)k / steps, turned = 4 * HB_PI / steps;
    rod_case_evaluate(c, NULL, t);
    double now = energy_now(c, &e, theta);
    assert_near(theta[last] - theta[0], 4 * HB_PI * t, 1e-11);
    for (int j = 0; j <= last && k > 0; j++) assert_at_most(fabs(theta[j] - before[j]), 3 * turned);
    if (k > 0)
      assert_near(now - energy, 0.5 * (torque + c->state->frame_torque[1]) * turned,
                  0.05 * turned * turned * turned);
    memcpy(before, theta, sizeof before);
    torque = c->state->frame_torque[1];
    energy = now;
  }
  rod_energy_free(&e);
}

/* Two turns in small steps: no jump, the work of the torque is the energy, and the end is where a rod arrives
 * that starts with two turns at once. */
static void test_turned_end(void **state) {
  (void)state;
  for (int k = 0; k < 6; k++) {
    double fine[ROOM], coarse[ROOM], direct[ROOM];
    rod_case c;
    const char *angles[3] = {"4*pi*t", "4*pi*t", "4*pi"};
    for (int way = 0; way < 3; way++) {
      rng r = rng_start(210 + (uint64_t)k);
      make_turned(&c, &r, k % 2 == 0, angles[way]);
      if (way < 2)
        turn_slowly(&c, way ? 60 : 300, way ? coarse : fine);
      else
        rod_case_start(&c, NULL);
      if (way == 2) rod_case_angles(&c, direct);
      rod_case_free(&c);
    }
    assert_near_array(coarse, fine, 11, 1e-11);
    assert_near_array(direct, fine, 11, 1e-11);
  }
}

/* Two turns within a single step are still two turns. */
static void test_sudden_turn(void **state) {
  (void)state;
  for (int general = 0; general < 2; general++) {
    double sudden[ROOM], direct[ROOM];
    for (int way = 0; way < 2; way++) {
      rng r = rng_start(215);
      rod_case c;
      make_turned(&c, &r, !general, way ? "4*pi" : "4*pi*t");
      rod_case_start(&c, NULL);
      if (way == 0) rod_case_evaluate(&c, NULL, 1);
      rod_case_angles(&c, way ? direct : sudden);
      rod_case_free(&c);
    }
    assert_near(sudden[10] - sudden[0], 4 * HB_PI, 1e-11);
    assert_near_array(sudden, direct, 11, 1e-11);
  }
}

/* Strongly curved and anisotropic: on the way the minimum vanishes and the frames snap to another; then
 * energy is lost, never won, and no winding with it. */
static void test_snaps_go_down(void **state) {
  (void)state;
  rng r = rng_start(220);
  int snaps = 0;
  for (int k = 0; k < 12; k++) {
    rod_case c;
    rod_energy e;
    double theta[ROOM], torque = 0, energy = 0, turned = 4 * HB_PI / 400;
    rod_case_straight(&c, 24, 1.2 / 22, 0.02, 0.015);
    hb_rod_def *def = &c.def.rods[0];
    rod_set_bending(def, rng_uniform(&r, 0.02, 0.04), 0, rng_uniform(&r, 0.1, 0.3));
    for (int j = 0; j < 23; j++) {
      def->initial[3 * j + 3] = def->initial[3 * j] + 1.2 / 22 * cos(0.16 * j);
      def->initial[3 * j + 4] = def->initial[3 * j + 1] + 1.2 / 22 * sin(0.16 * j);
    }
    rod_hold_angle(def, 0, "0.1");
    rod_hold_angle(def, -1, "0.1 + 4*pi*t");
    rod_case_compile(&c);
    rod_case_start(&c, NULL);
    rod_energy_create(&e, def);
    for (int step = 0; step <= 400; step++) {
      rod_case_evaluate(&c, NULL, step / 400.0);
      double now = energy_now(&c, &e, theta), work = 0.5 * (torque + c.state->frame_torque[1]) * turned;
      double gained = step > 0 ? now - energy - work : 0;
      assert_at_most(gained, 1e-4);
      if (gained < -1e-4) snaps++;
      assert_near(theta[22] - theta[0], 4 * HB_PI * step / 400, 1e-10);
      torque = c.state->frame_torque[1];
      energy = now;
    }
    rod_energy_free(&e);
    rod_case_free(&c);
  }
  assert_true(snaps >= 12);
}

/* ---- the closed form
 * ---------------------------------------------------------------------------------------------- */

/* Isotropic straight rods with every kind of ends, alpha and beta varying: Newton finds what the closed form
 * says. */
static void test_closed_form(void **state) {
  (void)state;
  rng r = rng_start(230);
  for (int k = 0; k < 80; k++) {
    rod_case closed, general;
    double angles[2][ROOM], m1[2][ROOM];
    rod_case_random(&closed, &r, ROD_ISOTROPIC, (rod_ends)(k % ROD_ENDS_COUNT), 10);
    hb_rod_def *def = &closed.def.rods[0];
    for (int j = 0; k % 2 && j < def->nv; j++) def->beta[j] *= rng_uniform(&r, 0.5, 2);
    for (int j = 0; k % 2 && j + 1 < def->nv; j++)
      def->B[3 * j] = def->B[3 * j + 2] = rng_uniform(&r, 0.05, 0.5);
    rod_case_compile(&closed);
    rod_case_start(&closed, NULL);
    assert_true(closed.rod->closed_form);
    general = closed;
    general.model = NULL;
    general.state = NULL;
    general.work_made = false;
    def->viscosity = rod_array(def->nv); /* all 0: the same rod, but the general solver takes it */
    rod_case_compile(&general);
    rod_case_start(&general, NULL);
    assert_false(general.rod->closed_form);
    rod_case_angles(&closed, angles[0]);
    rod_case_angles(&general, angles[1]);
    int ne = def->nv - 1, n = 3 * def->nv;
    for (int j = ne - 1; j >= 0; j--) /* a rod without held frames may be turned as a whole */
      for (int side = 0; side < 2; side++) angles[side][j] -= angles[side][0];
    assert_near_array(angles[1], angles[0], ne, 1e-11);
    rod_case_directors(&closed, m1[0]);
    rod_case_directors(&general, m1[1]);
    if (closed.rod->frame_count > 0) assert_near_array(m1[1], m1[0], 3 * ne, 1e-11);
    double scale = rod_largest(closed.state->force, n);
    assert_at_most(rod_difference(general.state->force, closed.state->force, n), 1e-12 * scale);
    for (int f = 0; f < closed.model->frame_count; f++)
      assert_near(general.state->frame_torque[f], closed.state->frame_torque[f], 1e-11);
    hb_rod_work_free(&general.work);
    hb_state_free(general.state);
    hb_model_free(general.model);
    rod_case_free(&closed);
  }
}

/* m_i/l_i constant, a free end gives none: theta(last) - theta(first) over the sum of l_i. */
static void test_uniform_twist(void **state) {
  (void)state;
  rod_case c;
  double theta[ROOM], lengths[300];
  rng r = rng_start(240);
  int nv = 300; /* several panels */
  rod_case_straight(&c, nv, 0.01, 0.1, 0.3);
  for (int j = 0; j < nv; j++) lengths[j] = 0.01;
  rod_random_shape(&r, nv, lengths, 0.3, c.def.rods[0].initial);
  rod_hold_angle(&c.def.rods[0], 0, "1");
  rod_hold_angle(&c.def.rods[0], -1, "1 + 20*pi");
  rod_case_compile(&c);
  rod_case_start(&c, NULL);
  rod_case_angles(&c, theta);
  double whole = 0.02 * (nv - 2), moment = 2 * 0.3 * 20 * HB_PI / whole;
  for (int i = 1; i < nv - 1; i++) assert_near(theta[i] - theta[i - 1], 20 * HB_PI * 0.02 / whole, 1e-12);
  assert_near_rel(c.state->moment[0], moment, 1e-13);
  assert_near_rel(c.state->frame_torque[1], moment, 1e-13);
  assert_near_rel(c.state->frame_torque[0], -moment, 1e-13);
  rod_case_free(&c);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_arc),         cmocka_unit_test(test_arc_mesh),
      cmocka_unit_test(test_arc_trap),    cmocka_unit_test(test_far_starts),
      cmocka_unit_test(test_minimum),     cmocka_unit_test(test_turned_end),
      cmocka_unit_test(test_sudden_turn), cmocka_unit_test(test_all_but_straight),
      cmocka_unit_test(test_saddle),      cmocka_unit_test(test_snaps_go_down),
      cmocka_unit_test(test_closed_form), cmocka_unit_test(test_uniform_twist)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
