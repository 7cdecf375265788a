/* Frequencies and modes against answers computed outside this project: beams, ropes, strings and their
 * discrete counterparts (V19, V20, V24, V46 of the validation catalogue), a dense eigenvalue problem solved
 * here in another way, differences of the force, and the motion itself. */
#include "hebra/modes.h"
#include "sim/sim.h"
#include "support/rng.h"
#include "support/solved.h"

#include <stdlib.h>

#define say(...)                                                                                             \
  do {                                                                                                       \
    if (getenv("HEBRA_TEST_VERBOSE")) printf(__VA_ARGS__);                                                   \
  } while (0)
#define PI 3.14159265358979323846
enum { MOST = 70 };

/* A solved scene of scenes/modes and its modes. */
typedef struct vibrating {
  solved s;
  hb_modes modes;
} vibrating;

/* Looks for modes of what was solved. */
static void find(vibrating *v, int count) {
  hb_error err = {HB_OK, ""};
  if (hb_sim_find_modes(v->s.sim, &v->s.found, count, &v->modes, &err)) fail_msg("%s", err.text);
}

/* From a text with its parameters. */
static void from_text(vibrating *v, const char *text, bool any, int count) {
  hb_error err = {HB_OK, ""};
  memset(v, 0, sizeof *v);
  if (hb_scene_parse(text, strlen(text), "test", ".", NULL, 0, &v->s.def, &err)) fail_msg("%s", err.text);
  if (hb_model_create(&v->s.def, &v->s.model, &err)) fail_msg("%s", err.text);
  if (hb_sim_create(v->s.model, &v->s.sim, &err)) fail_msg("%s", err.text);
  if (hb_frame_create(v->s.model, &v->s.frame, &err)) fail_msg("%s", err.text);
  hb_equilibrium_options options = hb_equilibrium_defaults(v->s.def.method.duration);
  options.any = any;
  if (hb_sim_find_equilibrium(v->s.sim, &options, &v->s.found, &err)) fail_msg("%s", err.text);
  find(v, count);
}

/* Frees both. */
static void done(vibrating *v) {
  hb_modes_free(&v->modes);
  solved_end(&v->s);
}

/* A straight beam of bending 0.02, density 0.05 from x = a on, edges of length h. */
static void beam(vibrating *v, int n, double h, const char *ends, int count) {
  char text[800];
  snprintf(text, sizeof text,
           "method: {time_step: 1e-5, duration: 1}\n"
           "rods:\n"
           "  - rest: {line: {from: [0, 0, 0], to: [%.17g, 0, 0], vertices: %d}}\n"
           "    bending: 0.02\n    twisting: 0.015\n    linear_density: 0.05\n"
           "    supports: [%s]\n",
           h * (n - 1), n, ends);
  from_text(v, text, false, count);
}

/* V19: errors of the first three frequencies of the discrete beams, to their printed digits. Every frequency
 * is there twice, sideways and up. */
static void beam_frequencies(void **state) {
  (void)state;
  static const char clamped[] = "{edge: 0, position: fixed, tangent: fixed}";
  static const char both[] =
      "{edge: 0, position: fixed, tangent: fixed}, {vertex: -2, position: [free, 0, 0]}, "
      "{vertex: -1, position: [free, 0, 0]}";
  static const char pinned[] = "{vertex: 0, position: fixed}, {vertex: -1, position: [free, 0, 0]}";
  static const struct {
    const char *name, *ends;
    double z[3], edges; /* z; how many edges the free length is short of n - 1 */
    int rigid;
    double error[3][3]; /* n = 11, 41, 161 */
  } table[] = {
      {"clamped-free",
       clamped,
       {1.875104068712, 4.6940911329742, 7.8547574382376},
       0.5,
       0,
       {{-1.768e-3, -2.091e-2, -5.560e-2},
        {-1.013e-4, -1.220e-3, -3.286e-3},
        {-6.223e-6, -7.487e-5, -2.018e-4}}},
      {"clamped-clamped",
       both,
       {4.7300407448627, 7.8532046240958, 10.995607838002},
       1,
       0,
       {{5.703e-3, -1.959e-2, -6.833e-2},
        {3.423e-4, -8.139e-4, -3.047e-3},
        {2.071e-5, -4.822e-5, -1.812e-4}}},
      {"free",
       "",
       {4.7300407448627, 7.8532046240958, 10.995607838002},
       0,
       5, /* three shifts, two turns; the turn about its axis has no mass */
       {{-3.927e-2, -8.276e-2, -1.355e-1},
        {-2.569e-3, -5.638e-3, -9.638e-3},
        {-1.610e-4, -3.544e-4, -6.079e-4}}},
      {"pinned",
       pinned,
       {3.1415926535898, 6.2831853071796, 9.4247779607694},
       0,
       0,
       {{-8.198e-3, -3.247e-2, -7.186e-2},
        {-5.139e-4, -2.054e-3, -4.618e-3},
        {-3.212e-5, -1.285e-4, -2.891e-4}}},
  };
  for (size_t k = 0; k < sizeof table / sizeof table[0]; k++)
    for (int level = 0, n = 11; level < 3; level++, n = 4 * n - 3) {
      vibrating v;
      int rigid = table[k].rigid;
      double length = 0.5, h = length / (n - 1 - table[k].edges);
      beam(&v, n, h, table[k].ends, rigid + 6);
      assert_int_equal(v.modes.count, rigid + 6);
      assert_int_equal(v.modes.rigid, rigid);
      assert_int_equal(v.modes.unstable, 0);
      for (int i = 0; i < 6; i++) {
        const hb_mode *mode = &v.modes.mode[rigid + i];
        double z = table[k].z[i / 2], exact = z * z * sqrt(0.02 / 0.05) / (length * length);
        double error = hb_mode_omega(mode) / exact - 1, printed = table[k].error[level][i / 2];
        double digit = pow(10, floor(log10(fabs(printed))) - 3);
        if (i % 2 == 0)
          say("%s n = %d mode %d: %.4g, printed %.4g\n", table[k].name, n, i / 2 + 1, error, printed);
        assert_near(error, printed,
                    fmax(0.51 * digit, 2e-8)); /* round-off of that program, where h is smallest */
      }
      done(&v);
    }
}

/* The first frequency of the clamped-free beam of n vertices, by inverse iteration with 40 digits. */
static void many_vertices(void **state) {
  (void)state;
  static const double exact[][2] = {/* n, omega */
                                    {21, 8.891190386422021},
                                    {41, 8.893992514855368},
                                    {161, 8.894838020054993},
                                    {1001, 8.894891823224846}};
  for (size_t k = 0; k < sizeof exact / sizeof exact[0]; k++) {
    vibrating v;
    beam(&v, (int)exact[k][0], 0.5 / (exact[k][0] - 1.5), "{edge: 0, position: fixed, tangent: fixed}", 2);
    const hb_mode *mode = &v.modes.mode[0];
    double error = hb_mode_omega(mode) - exact[k][1];
    say("n = %g: omega off by %.2e, resolution %.2e\n", exact[k][0], error,
        0.5 * mode->resolution / exact[k][1]);
    assert_at_most(fabs(error), 1e-9 * pow(exact[k][0] / 41, 4));      /* round-off grows so */
    assert_at_most(fabs(error), 0.5 * mode->resolution / exact[k][1]); /* it knows its round-off */
    done(&v);
  }
}

/* V46: first and highest frequency of the cantilever of 21 vertices; in between all 38 modes. */
static void all_modes(void **state) {
  (void)state;
  vibrating v;
  beam(&v, 21, 0.5 / 19.5, "{edge: 0, position: fixed, tangent: fixed}", 1000);
  assert_int_equal(v.modes.freedom, 38);
  assert_int_equal(v.modes.count, 38);
  assert_near_rel(hb_mode_omega(&v.modes.mode[0]), 8.8911903864356, 1e-9);
  assert_near_rel(hb_mode_omega(&v.modes.mode[37]), 3822.945072, 1e-9);
  for (int k = 0; k < 38; k++) {
    assert_at_most(v.modes.mode[k].error, 1e-6 * v.modes.mode[k].square);
    assert_near_rel(v.modes.mode[k].square, v.modes.mode[k ^ 1].square, 1e-9); /* in pairs */
    const double *d = v.modes.mode[k].shape; /* up and sideways, not a mixture */
    assert_true(fabs(d[3 * 20 + 1]) < 1e-9 || fabs(d[3 * 20 + 2]) < 1e-9);
  }
  done(&v);
}

/* V24: first frequency of the discrete hanging rope; the errors of the first three against the zeros of J0
 * fall with h^2. */
static void hanging_rope(void **state) {
  (void)state;
  static const double first[][2] = {
      {5, 1.18839322629}, {10, 1.19886077397}, {20, 1.20152326331}, {40, 1.20219039367}, {80, 1.20235718757}};
  static const double smooth[3] = {1.2024127788479, 2.7600390551432, 4.3268639564555};
  double error[2][3];
  for (size_t k = 0; k < sizeof first / sizeof first[0]; k++) {
    vibrating v;
    char a[80];
    solved_begin(&v.s, "../modes/hanging-rope", false, solved_set(a, "parameters.n", first[k][0] + 1), NULL);
    find(&v, 6);
    double unit = sqrt(9.81);
    assert_near_rel(hb_mode_omega(&v.modes.mode[0]) / unit, first[k][1], 1e-11);
    for (int i = 0; k >= 3 && i < 3; i++)
      error[k - 3][i] = hb_mode_omega(&v.modes.mode[2 * i]) / unit - smooth[i];
    done(&v);
  }
  for (int i = 0; i < 3; i++) {
    say("rope, mode %d: %.4g at n = 80, %.4f times as much at 40\n", i + 1, error[1][i],
        error[0][i] / error[1][i]);
    assert_near(error[0][i] / error[1][i], 4, 0.06);
  }
  assert_near_rel(error[1][0] * 6400, -0.295 * smooth[0], 0.22); /* -0.295/n^2 of itself or of the unit */
}

/* V20 and a string: for the pinned discrete beam under tension k_h = 2 sin(k h/2)/h takes the place of k, and
 * bending also that of the angle's tangent. All frequencies; the smooth one at the wave number 8 pi. */
static void stiff_string(void **state) {
  (void)state;
  double error[2];
  for (int fine = 0; fine < 2; fine++) {
    vibrating v;
    char a[80], b[80];
    int n = fine ? 129 : 65;
    double h = 1.0 / (n - 1), tension = 0.3;
    solved_begin(&v.s, "../modes/string", false, solved_set(a, "parameters.n", n),
                 solved_set(b, "parameters.tension", tension), NULL);
    find(&v, 2 * (n - 2));
    assert_int_equal(v.modes.freedom, 2 * (n - 2)); /* the axis has no room */
    for (int i = 0; i < v.modes.count; i++) {
      double k = 2 * sin(0.5 * (i / 2 + 1) * PI * h) / h,
             exact = (0.02 * k * k * k * k + tension * k * k) / 0.05;
      assert_near_rel(v.modes.mode[i].square, exact, 1e-8);
    }
    error[fine] = hb_mode_omega(&v.modes.mode[15]) / 404.2090830747 - 1;
    done(&v);
  }
  say("string at k = 8 pi: %.4g, %.4g\n", error[0], error[1]);
  assert_near_rel(error[0] / error[1], 4, 0.01);
}

/* A string that is pushed: where the first frequency is 0 it buckles, beyond it leaves like an exponential.
 */
static void pushed_string(void **state) {
  (void)state;
  for (int beyond = 0; beyond < 2; beyond++) {
    vibrating v;
    char a[80];
    int n = 41;
    double h = 1.0 / (n - 1), k = 2 * sin(0.5 * PI * h) / h, tension = -0.02 * k * k * (beyond ? 1.1 : 0.999);
    solved_begin(&v.s, "../modes/string", true, solved_set(a, "parameters.tension", tension), NULL);
    find(&v, 4);
    assert_int_equal(v.modes.unstable, beyond ? 2 : 0);
    assert_int_equal(v.modes.unstable, v.s.found.unstable);
    assert_int_equal(hb_mode_kind(&v.modes.mode[0]), beyond ? -1 : 1);
    assert_near_rel(v.modes.mode[0].square, (0.02 * k * k + tension) * k * k / 0.05, 1e-7);
    hb_modes_free(&v.modes);
    find(&v, 1); /* there are more than are asked for */
    assert_int_equal(v.modes.unstable, beyond ? 2 : 0);
    done(&v);
  }
}

/* A dense symmetric matrix's eigenvalues by cyclic Jacobi, in increasing order. */
static void jacobi(int n, double A[MOST][MOST], double *values) {
  for (int sweep = 0; sweep < 14; sweep++)
    for (int p = 0; p < n; p++)
      for (int q = p + 1; q < n; q++) {
        if (A[p][q] == 0) continue;
        double angle = 0.5 * atan2(2 * A[p][q], A[p][p] - A[q][q]), c = cos(angle), s = sin(angle);
        for (int k = 0; k < n; k++) {
          double x = A[k][p], y = A[k][q];
          A[k][p] = c * x + s * y;
          A[k][q] = c * y - s * x;
        }
        for (int k = 0; k < n; k++) {
          double x = A[p][k], y = A[q][k];
          A[p][k] = c * x + s * y;
          A[q][k] = c * y - s * x;
        }
      }
  for (int k = 0; k < n; k++) {
    int at = k;
    for (; at > 0 && values[at - 1] > A[k][k]; at--) values[at] = values[at - 1];
    values[at] = A[k][k];
  }
}

/* A matrix of the export, dense. */
static void unpack(const hb_matrix *m, double out[2 * MOST][2 * MOST]) {
  memset(out, 0, sizeof(double[2 * MOST][2 * MOST]));
  for (long k = 0; k < m->entries; k++) {
    out[m->row[k]][m->column[k]] = m->value[k];
    if (m->symmetric) out[m->column[k]][m->row[k]] = m->value[k];
  }
}

/* The same coil with few vertices. */
static void small_coil(vibrating *v, int n, int count) {
  char a[80];
  solved_begin(&v->s, "../modes/telephone-cord", false, solved_set(a, "parameters.n", n),
               "parameters.turns=1.3", NULL);
  find(v, count);
}

/* K with the turns eliminated: what they do to the places. */
static void eliminate_turns(int n, const int *component, double K[2 * MOST][2 * MOST]) {
  for (int k = 0; k < n; k++) {
    if (component[k] != 3) continue;
    for (int i = 0; i < n; i++) {
      double ratio = i == k ? 0 : K[i][k] / K[k][k];
      for (int j = 0; ratio != 0 && j < n; j++) K[i][j] -= ratio * K[k][j];
    }
    for (int i = 0; i < n; i++)
      if (i != k) K[k][i] = 0;
  }
}

/* All modes of a heavy coil against the exported matrices: turns eliminated, masses scaled to 1, a basis of
 * what keeps the lengths by Gram and Schmidt, Jacobi's method. */
static void dense(void **state) {
  (void)state;
  static double K[2 * MOST][2 * MOST], M[2 * MOST][2 * MOST], G[2 * MOST][2 * MOST], A[MOST][MOST];
  static double basis[2 * MOST][2 * MOST];
  double values[MOST];
  vibrating v;
  hb_matrices m;
  hb_error err = {HB_OK, ""};
  small_coil(&v, 14, 1000);
  if (hb_sim_find_matrices(v.s.sim, &v.s.found, &m, &err)) fail_msg("%s", err.text);
  int n = m.K.rows, constraints = m.G.rows, total = 0;
  assert_int_equal(n, 12 * 3 + 12); /* one edge is clamped */
  unpack(&m.K, K);
  unpack(&m.M, M);
  unpack(&m.G, G);
  eliminate_turns(n, m.component, K);
  for (int pass = 0; pass < constraints + n; pass++) { /* rows of G first, then everything that is left */
    double row[2 * MOST] = {0}, size = 0;
    bool gradient = pass < constraints;
    if (!gradient && m.component[pass - constraints] == 3) continue;
    for (int i = 0; i < n; i++) {
      double root = m.component[i] == 3 ? 0 : 1 / sqrt(M[i][i]);
      row[i] = gradient ? G[pass][i] * root : i == pass - constraints;
      size += row[i] * row[i];
    }
    double left = 0;
    for (int round = 0; round < 2; round++)
      for (int b = 0; b < total; b++) {
        double dot = 0;
        for (int i = 0; i < n; i++) dot += row[i] * basis[b][i];
        for (int i = 0; i < n; i++) row[i] -= dot * basis[b][i];
      }
    for (int i = 0; i < n; i++) left += row[i] * row[i];
    if (left < 1e-12 * size) continue;
    for (int i = 0; i < n; i++) basis[total][i] = row[i] / sqrt(left);
    total++;
  }
  int free = total - constraints;
  assert_int_equal(free, v.modes.freedom);
  assert_int_equal(free, v.modes.count);
  for (int a = 0; a < free; a++)
    for (int b = 0; b < free; b++) {
      A[a][b] = 0;
      for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++)
          if (m.component[i] != 3 && m.component[j] != 3)
            A[a][b] +=
                basis[constraints + a][i] * K[i][j] * basis[constraints + b][j] / sqrt(M[i][i] * M[j][j]);
    }
  jacobi(free, A, values);
  double worst = 0;
  for (int k = 0; k < free; k++) worst = fmax(worst, fabs(v.modes.mode[k].square / values[k] - 1));
  say("%d modes against the dense problem: %.2e\n", free, worst);
  assert_at_most(worst, 1e-9);
  hb_matrices_free(&m);
  done(&v);
}

/* Forces, edges included, at the equilibrium displaced by amount times the shape of a mode. */
static void force_at(const vibrating *v, const hb_mode *mode, double amount, const double *block,
                     double *out) {
  hb_sim *sim = v->s.sim;
  const hb_model *m = v->s.model;
  const hb_rod *rod = &m->rods[0];
  hb_error err = {HB_OK, ""};
  memcpy(sim->state->block, block, sim->state->count * sizeof *block);
  for (int k = 0; k < 3 * rod->nv; k++) sim->state->x[k] += amount * mode->shape[k];
  if (hb_stepper_evaluate(&sim->stepper, rod, sim->state->scalar[HB_S_TIME], sim->state->v, 0, &err))
    fail_msg("%s", err.text);
  memcpy(out, sim->state->force, 3 * (size_t)rod->nv * sizeof *out);
  for (int j = 0; j + 1 < rod->nv; j++)
    for (int c = 0; c < 3; c++) { /* tension/length of the equilibrium, on the edge as it is */
      double pull = 2 * v->s.found.multiplier[j] * m->inv_rest_length[j] *
                    (sim->state->x[3 * j + 3 + c] - sim->state->x[3 * j + c]);
      out[3 * j + c] += pull;
      out[3 * j + 3 + c] -= pull;
    }
}

/* The force of a mode, by differences of the force, twist solved anew: -omega^2 M shape along everything that
 * keeps the lengths; among the modes it is diagonal. */
static void differences(void **state) {
  (void)state;
  vibrating v;
  small_coil(&v, 16, 1000);
  hb_sim *sim = v.s.sim;
  double *kept = malloc(sim->state->count * sizeof *kept), change[2][3 * 16], down[3 * 16], worst = 0;
  assert_non_null(kept);
  memcpy(kept, sim->state->block, sim->state->count * sizeof *kept);
  for (int k = 0; k < v.modes.count; k++) {
    for (int fine = 0; fine < 2; fine++) { /* central differences, extrapolated */
      double step = fine ? 1e-7 : 2e-7;
      force_at(&v, &v.modes.mode[k], step, kept, change[fine]);
      force_at(&v, &v.modes.mode[k], -step, kept, down);
      for (int i = 0; i < 3 * 16; i++) change[fine][i] = (change[fine][i] - down[i]) / (2 * step);
    }
    for (int q = 0; q < v.modes.count; q++) {
      double work = 0, expected = k == q ? -v.modes.mode[k].square : 0;
      for (int i = 0; i < 3 * 16; i++)
        work += (4 * change[1][i] - change[0][i]) / 3 * v.modes.mode[q].shape[i];
      worst = fmax(worst, fabs(work - expected) / sqrt(v.modes.mode[k].square * v.modes.mode[q].square));
    }
  }
  say("modes in differences of the force: %.2e\n", worst);
  assert_at_most(worst, 1e-6);
  memcpy(sim->state->block, kept, sim->state->count * sizeof *kept);
  free(kept);
  done(&v);
}

/* The rod let go in its mode: what it moves along the mode is a cosine, of the frequency that Verlet's step
 * makes of omega: sin(Omega h/2) = omega h/2. */
static void motion(void **state) {
  (void)state;
  for (int k = 0; k < 12; k += 4) {
    vibrating v;
    hb_error err = {HB_OK, ""};
    small_coil(&v, 16, 12);
    hb_sim *sim = v.s.sim;
    const hb_mode *mode = &v.modes.mode[k];
    const hb_model *m = v.s.model;
    double omega = hb_mode_omega(mode), h = m->def->method.time_step, amplitude = 1e-8, worst = 0;
    double shifted = 2 / h * asin(0.5 * omega * h), *middle = malloc(3 * (size_t)m->nv * sizeof *middle);
    assert_non_null(middle);
    hb_state *s = hb_sim_state(sim);
    memcpy(middle, s->x, 3 * (size_t)m->nv * sizeof *middle);
    s->scalar[HB_S_TIME] = s->scalar[HB_S_STEP] = 0;
    for (int i = 0; i < 3 * m->nv; i++) s->x[i] += amplitude * mode->shape[i];
    if (hb_stepper_evaluate(&sim->stepper, &m->rods[0], 0, s->v, 0, &err)) fail_msg("%s", err.text);
    int steps = (int)(6.3 / (omega * h)); /* one period */
    for (int n = 1; n <= steps; n++) {
      if (hb_sim_step(sim, &err)) fail_msg("%s", err.text);
      const double *x = hb_sim_const_state(sim)->x;
      double along = 0;
      for (int i = 0; i < 3 * m->nv; i++) along += m->mass[i / 3] * mode->shape[i] * (x[i] - middle[i]);
      worst = fmax(worst, fabs(along / amplitude - cos(shifted * n * h)));
    }
    say("mode %d, omega %.6g, in %d steps: off a cosine by %.2e\n", k + 1, omega, steps, worst);
    assert_at_most(worst, 2e-5);
    free(middle);
    done(&v);
  }
}

/* A measured mode: as far away as asked for, lengths kept, energy of the vibration at second order. */
static void measured(void **state) {
  (void)state;
  vibrating v;
  hb_error err = {HB_OK, ""};
  small_coil(&v, 16, 6);
  const hb_mode *mode = &v.modes.mode[2];
  double largest = 0, amplitude = 1e-4, middle[48],
         rest = v.s.frame->bending + v.s.frame->twisting + v.s.frame->gravity;
  uint64_t hash = hb_state_hash(hb_sim_const_state(v.s.sim));
  memcpy(middle, v.s.frame->position, sizeof middle);
  if (hb_sim_measure_mode(v.s.sim, &v.s.found, mode, amplitude, 0, v.s.frame, &err)) fail_msg("%s", err.text);
  for (int i = 0; i < 16; i++) {
    double away = 0;
    for (int c = 0; c < 3; c++) away += pow(v.s.frame->position[3 * i + c] - middle[3 * i + c], 2);
    largest = fmax(largest, sqrt(away));
  }
  assert_near_rel(largest, amplitude, 1e-2);
  assert_at_most(v.s.frame->length_error, 1e-5);
  assert_same(v.s.frame->kinetic, 0);
  double stored = v.s.frame->bending + v.s.frame->twisting + v.s.frame->gravity - rest;
  if (hb_sim_measure_mode(v.s.sim, &v.s.found, mode, amplitude, 0.5 * PI, v.s.frame, &err))
    fail_msg("%s", err.text);
  say("energy of the mode: %.6g away, %.6g in passing\n", stored, v.s.frame->kinetic);
  assert_near_rel(stored, v.s.frame->kinetic, 2e-2);
  assert_near_rel(v.s.frame->time, 0.5 * PI / hb_mode_omega(mode), 1e-12);
  assert_true(hash == hb_state_hash(hb_sim_const_state(v.s.sim)));
  assert_int_equal(hb_sim_measure_mode(v.s.sim, &v.s.found, mode, 1e3, 0, v.s.frame, &err), HB_ERR_INPUT);
  assert_non_null(strstr(err.text, "smaller amplitude"));
  hb_modes none;
  assert_int_equal(hb_sim_find_modes(v.s.sim, &v.s.found, 0, &none, &err), HB_ERR_INPUT);
  hb_modes_free(&none);
  done(&v);
}

/* Free rods have six rigid modes, straight ones five: turning about its axis moves no mass. */
static void free_rods(void **state) {
  (void)state;
  static const struct {
    const char *rod;
    int rigid;
  } cases[] = {
      {"rest: {helix: {radius: 0.1, pitch: 0.05, turns: 1.5, vertices: 30}}\n    bending: [0.01, 0.02]\n", 6},
      {"rest: {helix: {radius: 0.1, pitch: 0.05, turns: 1.5, vertices: 30}}\n    bending: 0.02\n", 6},
      {"rest: {line: {from: [0, 0, 0], to: [0.3, 0.4, 0], vertices: 30}}\n    bending: [0.01, 0.02]\n", 5},
      {"rest: {line: {from: [0, 0, 0], to: [0.3, 0.4, 0], vertices: 30}}\n    bending: 0.01\n"
       "    damping: {bending: 1e-4}\n",
       5}};
  for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
    char text[600];
    vibrating v;
    snprintf(
        text, sizeof text,
        "method: {time_step: 1e-5, duration: 1}\nrods:\n  - %s    twisting: 0.01\n    linear_density: 0.1\n",
        cases[k].rod);
    from_text(&v, text, false, 10);
    assert_int_equal(v.modes.rigid, cases[k].rigid);
    assert_int_equal(v.modes.unstable, 0);
    for (int i = 0; i < 10; i++) assert_int_equal(hb_mode_kind(&v.modes.mode[i]), i >= cases[k].rigid);
    done(&v);
  }
}

/* A closed ring: Hoppe's (1871) frequencies in its plane, Michell's (1890) out of it, each twice, at second
 * order. */
static void ring(void **state) {
  (void)state;
  double error[2][4];
  for (int fine = 0; fine < 2; fine++) {
    vibrating v;
    char a[80];
    solved_begin(&v.s, "../modes/ring", false, solved_set(a, "parameters.n", fine ? 160 : 80), NULL);
    find(&v, fine ? 14 : 1000);
    if (!fine) assert_int_equal(v.modes.count, 160); /* all of them: 80 vertices less 80 lengths */
    assert_int_equal(v.modes.rigid, 6);
    for (int k = 0; k < 4; k++) { /* n = 2 out of the plane, in it, n = 3 likewise */
      int n = k < 2 ? 2 : 3;
      double exact = n * n * pow(n * n - 1, 2) / (n * n + (k % 2 == 0 ? 1 / 0.8 : 1)), out = 0;
      const hb_mode *mode = &v.modes.mode[6 + 2 * k];
      for (int i = 0; i < v.s.model->nv; i++) out += v.s.model->mass[i] * pow(mode->shape[3 * i + 2], 2);
      assert_near(out, k % 2 == 0, 1e-9);
      assert_near_rel(mode[0].square, mode[1].square, 1e-9);
      error[fine][k] = mode->square / exact - 1;
      say("ring, n = %d %s the plane: %.3e\n", n, k % 2 == 0 ? "out of" : "in", error[fine][k]);
    }
    done(&v);
  }
  for (int k = 0; k < 4; k++) {
    assert_at_most(fabs(error[1][k]), 2e-3);
    assert_near_rel(error[0][k] / error[1][k], 4, 0.03);
  }
}

/* Several rods: one list, the same figures as of each alone. */
static void several_rods(void **state) {
  (void)state;
  static const char both[] =
      "method: {time_step: 1e-4, duration: 1}\n"
      "gravity: [0, 0, -9.81]\n"
      "rods:\n"
      "  - {name: a, copies: 3, rest: {line: {from: [k, 0, 0], to: [k, 0, -1 - 0.1*k], "
      "vertices: 9}}, bending: 0.001, twisting: 0.001, linear_density: 0.1, start: {clamp: true}}\n";
  vibrating v;
  from_text(&v, both, false, 7);
  assert_int_equal(v.modes.count, 7);
  int seen[3] = {0, 0, 0};
  for (int k = 0; k < 7; k++) {
    if (k > 0) assert_true(v.modes.mode[k].square >= v.modes.mode[k - 1].square);
    seen[v.modes.mode[k].rod]++;
  }
  assert_true(seen[0] == 2 && seen[1] == 2 && seen[2] == 3);
  done(&v);
}

/* Taut between two walls: there is no room, and it says so. */
static void no_room(void **state) {
  (void)state;
  vibrating v;
  hb_error err = {HB_OK, ""};
  beam(&v, 11, 0.1, "{vertex: 0, position: fixed}, {vertex: -1, position: [free, 0, 0]}", 2);
  hb_modes_free(&v.modes);
  v.s.model->inv_mass[30] = 0; /* the end's last freedom */
  assert_int_equal(hb_sim_find_modes(v.s.sim, &v.s.found, 2, &v.modes, &err), HB_ERR_NUMERIC);
  assert_non_null(strstr(err.text, "no room"));
  done(&v);
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(beam_frequencies),
                                     cmocka_unit_test(many_vertices),
                                     cmocka_unit_test(all_modes),
                                     cmocka_unit_test(hanging_rope),
                                     cmocka_unit_test(stiff_string),
                                     cmocka_unit_test(pushed_string),
                                     cmocka_unit_test(dense),
                                     cmocka_unit_test(differences),
                                     cmocka_unit_test(motion),
                                     cmocka_unit_test(measured),
                                     cmocka_unit_test(free_rods),
                                     cmocka_unit_test(ring),
                                     cmocka_unit_test(several_rods),
                                     cmocka_unit_test(no_room)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
