/* V19, V20, V46: frequencies of small bending vibrations, mesh-exact in space and time. An eigenvector of the
 * discrete rod is found here by inverse iteration on its own stiffness matrix (second differences), the rod
 * starts in it with an amplitude of 1e-8, and its phase after many periods gives the frequency. */
#include "support/near.h"

#include "support/scenes.h"

#define PI 3.14159265358979323846
#define MOST 42

typedef struct beam {
  int n;           /* vertices */
  bool clamped[2]; /* the end edge is held; else the end is free */
  bool pinned[2];  /* the end vertex is held */
  double alpha, density, edge;
} beam;

/* Small displacements w: energy sum alpha/(2 edge) ((w_{i-1} - 2 w_i + w_{i+1})/edge)^2 over interior
 * vertices. */
static void stiffness(const beam *b, double K[MOST][MOST]) {
  static const double stencil[3] = {1, -2, 1};
  double k = b->alpha / (b->edge * b->edge * b->edge);
  memset(K, 0, sizeof(double[MOST][MOST]));
  for (int i = 1; i + 1 < b->n; i++)
    for (int p = 0; p < 3; p++)
      for (int q = 0; q < 3; q++) K[i - 1 + p][i - 1 + q] += k * stencil[p] * stencil[q];
}

/* Does this vertex not move? */
static bool fixed(const beam *b, int i) {
  int from_end = b->n - 1 - i;
  return (i == 0 && (b->pinned[0] || b->clamped[0])) || (i == 1 && b->clamped[0]) ||
         (from_end == 0 && (b->pinned[1] || b->clamped[1])) || (from_end == 1 && b->clamped[1]);
}

/* Half a mass at the ends. */
static double mass_of(const beam *b, int i) {
  return b->density * b->edge * (i == 0 || i == b->n - 1 ? 0.5 : 1);
}

/* Solves (K - shift M) x = right by elimination with row exchanges; held rows give 0. */
static void solve(const beam *b, double shift, const double *right, double *x) {
  static double A[MOST][MOST + 1]; /* too big for small stacks */
  double K[MOST][MOST];
  int n = b->n;
  stiffness(b, K);
  for (int i = 0; i < n; i++) {
    for (int j = 0; j < n; j++)
      A[i][j] = fixed(b, i) || fixed(b, j) ? (i == j) : K[i][j] - (i == j ? shift * mass_of(b, i) : 0);
    A[i][n] = fixed(b, i) ? 0 : right[i];
  }
  for (int c = 0; c < n; c++) {
    int pivot = c;
    for (int r = c + 1; r < n; r++)
      if (fabs(A[r][c]) > fabs(A[pivot][c])) pivot = r;
    for (int k = 0; k <= n; k++) {
      double swap = A[c][k];
      A[c][k] = A[pivot][k];
      A[pivot][k] = swap;
    }
    if (A[c][c] == 0) A[c][c] = 1e-300;
    for (int r = c + 1; r < n; r++) {
      double factor = A[r][c] / A[c][c];
      for (int k = c; k <= n; k++) A[r][k] -= factor * A[c][k];
    }
  }
  for (int r = n - 1; r >= 0; r--) {
    x[r] = A[r][n];
    for (int k = r + 1; k < n; k++) x[r] -= A[r][k] * x[k];
    x[r] /= A[r][r];
  }
}

/* Eigenvalue nearest to guess^2 and its vector, largest entry 1. Returns the circular frequency. */
static double eigenmode(const beam *b, double guess, double *w) {
  double right[MOST], value = 0;
  for (int i = 0; i < b->n; i++) w[i] = 1 + 0.3 * i + 0.1 * i * i * sin(i);
  for (int turn = 0; turn < 60; turn++) {
    double old[MOST], top = 0, largest = 0;
    memcpy(old, w, sizeof old);
    for (int i = 0; i < b->n; i++) right[i] = mass_of(b, i) * w[i];
    solve(b, guess * guess, right, w);
    for (int i = 0; i < b->n; i++)
      if (fabs(w[i]) > fabs(largest)) {
        largest = w[i];
        top = old[i] / w[i];
      }
    value = guess * guess + top;
    for (int i = 0; i < b->n; i++) w[i] /= largest;
  }
  return sqrt(value);
}

/* The rod of the beam, along x, moved by amplitude * w towards y with its edges kept at their lengths. */
static void set_beam(trial *t, const beam *b, const double *w, double amplitude, const char *integrator,
                     double h) {
  double line[3 * MOST], xyz[3 * MOST] = {0};
  shape_line(b->n, b->edge * (b->n - 1), 0, 0, line);
  for (int i = 0; i < b->n; i++) {
    double rise = i ? amplitude * (w[i] - w[i - 1]) : 0;
    xyz[3 * i] = i ? xyz[3 * i - 3] + sqrt(b->edge * b->edge - rise * rise) : 0;
    xyz[3 * i + 1] = amplitude * w[i];
  }
  scene_begin(&t->def, integrator, h);
  hb_rod_def *rod = scene_rod(&t->def, b->n, line, b->alpha, b->alpha, b->density * b->edge);
  rod->mass[0] *= 0.5;
  rod->mass[b->n - 1] *= 0.5;
  scene_initial(rod, xyz);
  for (int end = 0; end < 2; end++) {
    /* the far end must be free to come nearer, else the rod would be stretched */
    const char *along = end == 1 ? "free" : NULL;
    if (b->clamped[end] || b->pinned[end]) scene_path(rod, end ? -1 : 0, along, NULL, NULL);
    if (b->clamped[end]) scene_path(rod, end ? -2 : 1, along, NULL, NULL);
  }
  t->def.method.length_tolerance = 1e-13;
  trial_start(t);
}

/* Part of the mode in the displacements. */
static double project(const beam *b, const double *w, const double *x) {
  double sum = 0, norm = 0;
  for (int i = 0; i < b->n; i++) {
    sum += mass_of(b, i) * w[i] * x[3 * i + 1];
    norm += mass_of(b, i) * w[i] * w[i];
  }
  return sum / norm;
}

/* Phase of the harmonic sequence q_n = C cos(n a + phase) from two neighbours. */
static double phase_of(double now, double next, double a) {
  return atan2((now * cos(a) - next) / sin(a), now);
}

/* Circular frequency of the run over about so many periods. */
static double measured(const beam *b, const double *w, double expected, const char *integrator, double h,
                       int periods) {
  trial t = {0};
  double a = expected * h, q[4];
  long steps = lrint(2 * PI * periods / a);
  set_beam(&t, b, w, 1e-8, integrator, h);
  q[0] = project(b, w, hb_sim_const_state(t.sim)->x);
  trial_run(&t, 1);
  q[1] = project(b, w, hb_sim_const_state(t.sim)->x);
  trial_run(&t, steps - 1);
  q[2] = project(b, w, hb_sim_const_state(t.sim)->x);
  trial_run(&t, 1);
  q[3] = project(b, w, hb_sim_const_state(t.sim)->x);
  trial_end(&t);
  double turned = phase_of(q[2], q[3], a) - phase_of(q[0], q[1], a);
  turned += 2 * PI * rint((expected * h * (double)steps - turned) / (2 * PI));
  return turned / (h * (double)steps);
}

static const beam cantilever_21 = {
    .n = 21, .clamped = {true, false}, .alpha = 0.02, .density = 0.05, .edge = 0.5 / 19.5};

/* The scheme's own frequency: sin(W h/2) = w h/2, for both integrators; W from the catalogue. */
static void test_time_step_shift(void **state) {
  (void)state;
  static const double step[3] = {1e-4, 2.5e-4, 5e-4},
                      table[3] = {8.8911906793013, 8.8911922168471, 8.891197708094};
  double w[MOST], omega = eigenmode(&cantilever_21, 9, w);
  assert_near_rel(omega, 8.8911903864356, 1e-10);
  for (int k = 0; k < 3; k++) {
    double expected = 2 / step[k] * asin(0.5 * omega * step[k]);
    double verlet = measured(&cantilever_21, w, expected, "verlet", step[k], 10);
    double euler = measured(&cantilever_21, w, expected, "symplectic-euler", step[k], 10);
    say("shift h %.1e: verlet %.13f euler %.13f table %.13f\n", step[k], verlet, euler, table[k]);
    assert_near_rel(expected, table[k], 1e-10);
    assert_near_rel(verlet, table[k], 1e-10);
    assert_near_rel(euler, table[k], 1e-10);
  }
}

/* Above the step 2/w_max the highest mode grows from round-off, below it does not. */
static void test_stability_limit(void **state) {
  (void)state;
  double w[MOST], top[MOST], omega = eigenmode(&cantilever_21, 3823, top);
  (void)eigenmode(&cantilever_21, 9, w);
  assert_near_rel(omega, 3822.945072, 1e-9);
  for (int k = 0; k < 2; k++) {
    trial t = {0};
    hb_error err = {HB_OK, ""};
    set_beam(&t, &cantilever_21, w, 1e-6, "verlet", 0.0005231568757 * (k ? 1.002 : 0.998));
    bool failed = false;
    double largest = 0;
    for (int n = 0; n < 1000 && !failed; n++) {
      failed = hb_sim_step(t.sim, &err) != HB_OK;
      for (int i = 0; i < 21; i++) largest = fmax(largest, fabs(hb_sim_const_state(t.sim)->x[3 * i + 1]));
    }
    say("step %s the limit: largest displacement %.1e%s\n", k ? "above" : "below", largest,
        failed ? ", failed" : "");
    if (k == 0)
      assert_at_most(largest, 1.01e-6);
    else
      assert_true(failed || largest > 1e-4); /* a hundred times the start, where nonlinearity may hold it */
    trial_end(&t);
  }
}

/* V19: the spectrum of the discrete rod, relative to the smooth beam as tabled (signs and sizes), three modes
 * each; and the program's first frequency on every support against its own mesh-exact one. */
static void test_spectra(void **state) {
  (void)state;
  static const struct {
    const char *name;
    bool clamped[2], pinned[2];
    double cut;         /* half edges that the clamps take off the length (clamp in the middle of the edge) */
    double z[3];        /* smooth */
    double error[2][3]; /* N = 11 and 41, relative, to the digits of the table */
  } cases[] = {{"cf",
                {true, false},
                {false, false},
                0.5,
                {1.875104068712, 4.6940911329742, 7.8547574382376},
                {{-1.768e-03, -2.091e-02, -5.560e-02}, {-1.013e-04, -1.220e-03, -3.286e-03}}},
               {"cc",
                {true, true},
                {false, false},
                1,
                {4.7300407448627, 7.8532046240958, 10.995607838002},
                {{5.703e-03, -1.959e-02, -6.833e-02}, {3.423e-04, -8.139e-04, -3.047e-03}}},
               {"ff",
                {false, false},
                {false, false},
                0,
                {4.7300407448627, 7.8532046240958, 10.995607838002},
                {{-3.927e-02, -8.276e-02, -1.355e-01}, {-2.569e-03, -5.638e-03, -9.638e-03}}},
               {"pp",
                {false, false},
                {true, true},
                0,
                {3.1415926535898, 6.2831853071796, 9.4247779607694},
                {{-8.198e-03, -3.247e-02, -7.186e-02}, {-5.139e-04, -2.054e-03, -4.618e-03}}}};
  for (size_t c = 0; c < sizeof cases / sizeof cases[0]; c++)
    for (int k = 0; k < 2; k++) {
      int n = k ? 41 : 11;
      beam b = {.n = n, .alpha = 0.02, .density = 0.05, .edge = 0.5 / (n - 1 - cases[c].cut)};
      memcpy(b.clamped, cases[c].clamped, sizeof b.clamped);
      memcpy(b.pinned, cases[c].pinned, sizeof b.pinned);
      for (int mode = 0; mode < 3; mode++) {
        double w[MOST], z = cases[c].z[mode], smooth = z * z * sqrt(0.02 / 0.05) / 0.25;
        double omega = eigenmode(&b, smooth * (1 + cases[c].error[k][mode]), w);
        assert_near(omega / smooth - 1, cases[c].error[k][mode], 6e-4 * fabs(cases[c].error[k][mode]));
        if (mode > 1) continue;
        double h = 0.02 * b.edge * b.edge * sqrt(0.05 / 0.02), expected = 2 / h * asin(0.5 * omega * h);
        double run = measured(&b, w, expected, "verlet", h, 2);
        say("%s N %d mode %d: program %.10f expected %.10f (smooth %.10f)\n", cases[c].name, n, mode + 1, run,
            expected, smooth);
        assert_near_rel(run, expected, 1e-9);
      }
    }
}

/* V20: a wave of 8, 16, 32 vertices on a rod with pinned ends: slower than the smooth wave by
 * (sin(kh/2)/(kh/2))^2. */
static void test_dispersion(void **state) {
  (void)state;
  static const double table[3] = {0.949641203552, 0.987214830767, 0.996791364045};
  for (int k = 0; k < 3; k++) {
    int per_wave = 8 << k;
    beam b = {.n = 33, .pinned = {true, true}, .alpha = 0.02, .density = 0.05, .edge = 0.01};
    double wave = 2 * PI / (per_wave * b.edge), w[MOST];
    double smooth = sqrt(0.02 / 0.05) * wave * wave, h = 2e-6;
    for (int i = 0; i < b.n; i++) w[i] = sin(wave * b.edge * i);
    double expected = 2 / h * asin(0.5 * h * smooth * table[k]);
    double run = measured(&b, w, expected, "verlet", h, 2);
    say("wave of %d vertices: %.12f of the smooth one's frequency, table %.12f\n", per_wave,
        2 / h * sin(0.5 * run * h) / smooth, table[k]);
    assert_near(2 / h * sin(0.5 * run * h) / smooth, table[k], 1e-9);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_time_step_shift),
      cmocka_unit_test(test_stability_limit),
      cmocka_unit_test(test_spectra),
      cmocka_unit_test(test_dispersion),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
