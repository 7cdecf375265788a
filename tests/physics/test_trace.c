/* Branches of equilibria against known answers. Thresholds are compared with those of the discrete rods
 * themselves, found by hand (chains of hinges with springs: recurrences with constant coefficients) or
 * computed outside this project. */
#include "support/traced.h"

#include <math.h>
#include <time.h>

#define say(...)                                                                                             \
  do {                                                                                                       \
    if (getenv("HEBRA_TEST_VERBOSE")) printf(__VA_ARGS__);                                                   \
  } while (0)

static const double pi = 3.14159265358979323846;

/* The parameter at the first bifurcation of the first branch of a scene with n vertices. */
static double threshold(const char *scene, int n, int multiplicity) {
  traced t = {.count = 0};
  char a[80];
  traced_begin(&t, scene, traced_set(a, "parameters.n", n), "trace.branches=1", "trace.step=0.1", NULL);
  const traced_point *found = traced_find(&t, 0, HB_TRACE_BIFURCATION, 0);
  double p = found->parameter;
  assert_int_equal(found->multiplicity, multiplicity);
  for (int k = 0; k < t.count; k++) { /* stability is labelled on both sides */
    if (t.points[k].kind == HB_TRACE_BIFURCATION) break;
    assert_int_equal(t.points[k].unstable, 0);
  }
  assert_true(t.points[t.count - 1].unstable >= multiplicity);
  assert_false(t.ends[0].failed);
  traced_end(&t);
  return p;
}

/* A strut under a load P at its end; the supports are put in front. */
#define STRUT(shape, start, end, to)                                                                         \
  "parameters: {n: 21, P: 0, l: 1/(n - 1)}\n"                                                                \
  "method: {time_step: 1e-5, duration: 0}\n"                                                                 \
  "rods:\n"                                                                                                  \
  "  - rest: {line: {from: [0, 0, 0], to: [1, 0, 0], vertices: n}}\n"                                        \
  "    bending: 1\n    twisting: 1\n    linear_density: 1\n"                                                 \
  "    start: " start "\n" end "forces:\n  - {point: [-P, 0, 0], vertex: -1}\n"                              \
  "trace: {parameter: P, from: 0, to: " to "}\n"

static const char clamped_free[] = STRUT("", "{position: fixed, tangent: fixed}", "", "7");
static const char clamped_clamped[] = STRUT(
    "", "{position: fixed, tangent: fixed}",
    "    supports: [{vertex: -2, position: [free, 0, 0]}, {vertex: -1, position: [free, 0, 0]}]\n", "70");

/* Euler's loads of a chain: the angles of the edges are sin(k j), P = 4 sin(k/2)^2/h^2. Pinned: k = pi h;
 * clamped and free: from the first edge to half an edge behind the last; clamped twice: one wave between held
 * edges. */
static void euler_loads(void **state) {
  (void)state;
  double before[3] = {0};
  for (int n = 21; n <= 41; n += 20) {
    double h = 1.0 / (n - 1), k[3] = {pi * h, pi / (2 * n - 3), 2 * pi / (n - 2)}, error[3];
    double length[3] = {1, (n - 1.5) * h, (n - 2) * h}, smooth[3] = {pi * pi, pi * pi / 4, 4 * pi * pi};
    const char *const scenes[3] = {"trace/euler", clamped_free, clamped_clamped};
    for (int c = 0; c < 3; c++) {
      double exact = 4 * sin(k[c] / 2) * sin(k[c] / 2) / (h * h), P = threshold(scenes[c], n, c == 0 ? 1 : 2);
      say("%d vertices: P %.12g, exact %.12g (%.1e)\n", n, P, exact, P / exact - 1);
      assert_near_rel(P, exact, 1e-9);
      error[c] = P * length[c] * length[c] / smooth[c] - 1;
      if (n > 21) assert_near_rel(before[c] / error[c], 4, 0.2);
      before[c] = error[c];
    }
  }
}

/* Edges that are springs get shorter under the load: P (1 - P/EA) takes the place of P. */
static void springy_strut(void **state) {
  (void)state;
  traced t = {.count = 0};
  double P = 1600 * sin(pi / 40) * sin(pi / 40), EA = 1000;
  traced_begin(&t, "trace/euler", "parameters.n=21", "rods[0].stretching=1000", "trace.branches=1",
               "trace.to=15", NULL);
  assert_near_rel(traced_find(&t, 0, HB_TRACE_BIFURCATION, 0)->parameter,
                  0.5 * EA * (1 - sqrt(1 - 4 * P / EA)), 1e-9);
  assert_near_rel(t.points[t.count - 1].last[0], 1 - 15 / EA, 1e-9);
  traced_end(&t);
}

/* Sum of the angles' recurrence at the free end of a chain under its own weight Q/L per length; 0 at a
 * critical weight. Moments of hinges: theta'' h + load above * theta = 0, with lumped weights. */
static double column_end(int n, double Q) {
  double l = 1 / (n - 1.5), before = 0, angle = 1, load = 0;
  for (int i = 2; i < n; i++) load += i == n - 1 ? 0.5 * Q * l : Q * l; /* above edge 1 */
  for (int j = 1; j + 1 < n - 1; j++) {
    double next = 2 * angle - before - load * l * l * angle;
    before = angle;
    angle = next;
    load -= Q * l;
  }
  return angle - before - 0.5 * Q * l * l * l * angle - 0; /* the last hinge bears what its edge carries */
}

/* Greenhill's column: critical weight of the chain by bisection; second order to 7.8373474389435. */
static void heavy_column(void **state) {
  (void)state;
  double before = 0;
  for (int n = 21; n <= 41; n += 20) {
    double low = 6, high = 9, Q = threshold("trace/heavy-column", n, 2);
    for (int k = 0; k < 60; k++) {
      double middle = 0.5 * (low + high);
      if ((column_end(n, middle) > 0) == (column_end(n, low) > 0))
        low = middle;
      else
        high = middle;
    }
    double error = Q / 7.8373474389435 - 1;
    say("column of %d: %.12g, chain %.12g, %.3e off the smooth one\n", n, Q, low, error);
    assert_near_rel(Q, low, 1e-9);
    assert_near_rel(error, n == 21 ? -1.35e-3 : -3.30e-4, 6e-3);
    if (n > 21) assert_near_rel(before / error, (39.5 / 19.5) * (39.5 / 19.5), 0.02);
    before = error;
  }
}

/* sum of cos(a k) over k = -m/2 .. m/2 */
static double wave_sum(double a, int m) { return sin(0.5 * a * (m + 1)) / sin(0.5 * a); }

/* A twisted chain between clamps under tension, one of which slides: its edges' angles (complex) are
 * c + A e^{i a k} + B e^{i b k}, k from the middle, with the two waves of 2 (1 - cos a) - M h sin a + T h^2 =
 * 0; both ends 0 and sum 0. The determinant of that, 0 at the critical moment. */
static double twisted_end(int n, double T, double M) {
  int m = n - 2;
  double h = 1.0 / (n - 1), size = hypot(2, M * h), phase = atan2(M * h, 2),
         wide = acos((2 + T * h * h) / size);
  double a = phase + wide, b = phase - wide;
  double ca = cos(0.5 * a * m), cb = cos(0.5 * b * m), sa = sin(0.5 * a * m), sb = sin(0.5 * b * m);
  double Sa = wave_sum(a, m), Sb = wave_sum(b, m);
  /* rows (1, ca, cb), (0, sa, sb), (m + 1, Sa, Sb) */
  return sa * Sb - sb * Sa - (m + 1) * (sa * cb - sb * ca);
}

/* Clamped and twisted (Timoshenko and Gere 2.21; Greenhill for T = 0): 8.9868 and, at T = 20, between. */
static void twisted_rod(void **state) {
  (void)state;
  static const double loads[2] = {50, 20};
  for (int c = 0; c < 2; c++)
    for (int n = 21; n <= 41; n += 20) {
      traced t = {.count = 0};
      char a[80], b[80];
      traced_begin(&t, "trace/twisted-rod", traced_set(a, "parameters.n", n),
                   traced_set(b, "parameters.T", loads[c]), "trace.branches=1", "trace.to=18",
                   "trace.step=0.1", NULL);
      const traced_point *found = traced_find(&t, 0, HB_TRACE_BIFURCATION, 0);
      double M = found->parameter * (n - 1) / (n - 2), step = 1e-3, h = 1.0 / (n - 1);
      double from = 1.001 * sqrt(4 * loads[c] + loads[c] * loads[c] * h * h); /* no waves below */
      assert_int_equal(found->multiplicity, 2);
      while (twisted_end(n, loads[c], from) * twisted_end(n, loads[c], from + step) > 0) from += step;
      double to = from + step;
      for (int k = 0; k < 60; k++) {
        double middle = 0.5 * (from + to);
        if (twisted_end(n, loads[c], from) * twisted_end(n, loads[c], middle) > 0)
          from = middle;
        else
          to = middle;
      }
      say("twisted, T %g, n %d: M %.12g, chain %.12g\n", loads[c], n, M, from);
      assert_near_rel(M, from, 1e-8);
      traced_end(&t);
    }
}

/* Without tension the moment is 2 z with tan z = z; the errors of the discrete rod to their printed digits.
 */
static void twisted_without_tension(void **state) {
  (void)state;
  static const double errors[][2] = {{11, 9.78e-2}, {21, 2.01e-2}, {41, 4.67e-3}};
  for (int k = 0; k < 3; k++) {
    traced t = {.count = 0};
    char a[80];
    int n = (int)errors[k][0];
    traced_begin(&t, "trace/twisted-rod", traced_set(a, "parameters.n", n), "parameters.T=0",
                 "trace.branches=1", "trace.to=12", "trace.step=0.1", NULL);
    double length = (n - 2.0) / (n - 1), M = traced_find(&t, 0, HB_TRACE_BIFURCATION, 0)->parameter / length;
    assert_near_rel(M * length / 8.9868189158181 - 1, errors[k][1], 4e-3);
    traced_end(&t);
  }
}

/* Rings: thresholds of the closed N-gon, computed outside as sign changes of its constrained Hessian. */
static const char twisted_ring[] =
    "parameters: {n: 50, theta: 10, edge: 2*pi/n, radius: edge/(2*sin(pi/n))}\n"
    "method: {time_step: 1e-3, duration: 0}\n"
    "rods:\n"
    "  - rest: {formula: {x: \"radius*cos(2*pi*s)\", y: \"radius*sin(2*pi*s)\", z: 0, from: 0, to: (n + "
    "1)/n, "
    "vertices: n + 2}}\n"
    "    straight_rest: true\n    bending: 1\n    twisting: 0.8\n    linear_density: 1\n"
    "    start: {position: fixed, tangent: fixed, material_angle: 0}\n"
    "    end: {position: fixed, tangent: fixed, material_angle: theta}\n"
    "trace: {parameter: theta, from: 10, to: 16}\n";
static const char curved_ring[] =
    "parameters: {n: 50, natural: 1, edge: 2*pi/n, radius: edge/(2*sin(pi/n))}\n"
    "method: {time_step: 1e-3, duration: 0}\n"
    "rods:\n"
    "  - initial: {formula: {x: \"radius*cos(2*pi*s)\", y: \"radius*sin(2*pi*s)\", z: 0, from: 0, to: (n + "
    "1)/n, "
    "vertices: n + 2}}\n"
    "    natural_curvature: [-natural, 0]\n    director: [0, 0, 1]\n"
    "    bending: 1\n    twisting: 2/3\n    linear_density: 1\n"
    "    start: {position: fixed, tangent: fixed, material: fixed}\n"
    "    end: {position: fixed, tangent: fixed, material: fixed}\n"
    "trace: {parameter: natural, from: 1, to: 2}\n";

/* Michell's ring (Michell 1889; Zajac 1962), and the over-curved one (Manning and Hoffman 2001). */
static void rings(void **state) {
  (void)state;
  static const double twist[][2] = {{20, 14.7092143}, {30, 14.0841527}, {50, 13.7746168}};
  static const double curvature[][2] = {{20, 1.86705204}, {50, 1.81738781}};
  for (size_t k = 0; k < 3; k++) {
    double found = threshold(twisted_ring, (int)twist[k][0], 2);
    say("ring of %g: %.10g (%.1e)\n", twist[k][0], found, found / twist[k][1] - 1);
    assert_near_rel(found, twist[k][1], 1e-6);
    assert_near_rel((found / 13.6034952318 - 1) * twist[k][0] * twist[k][0], 31.4, 0.05);
  }
  for (size_t k = 0; k < 2; k++)
    assert_near_rel(threshold(curved_ring, (int)curvature[k][0], 2), curvature[k][1], 1e-6);
}

static const char strip[] =
    "parameters: {n: 41, P: 1, l: 1/(n - 1.5)}\n"
    "method: {time_step: 2e-6, duration: 0}\n"
    "rods:\n"
    "  - rest: {line: {from: [-l/2, 0, 0], to: [1, 0, 0], vertices: n}}\n"
    "    director: [0, 0, 1]\n    bending: [20, 1]\n    twisting: 0.8\n    linear_density: 1\n"
    "    start: {position: fixed, tangent: fixed, material: fixed}\n"
    "forces:\n  - {point: [0, 0, -P*sqrt(0.8)], vertex: -1}\n"
    "trace: {parameter: P, from: 0, to: 6}\n";

/* Lateral buckling of a strip, off a branch that bends (Michell 1899; Prandtl 1899): the discrete strip's
 * loads, computed outside. */
static void lateral_buckling(void **state) {
  (void)state;
  static const double table[][2] = {{11, 4.26309849}, {21, 4.24690898}, {41, 4.24304952}};
  for (size_t k = 0; k < 3; k++) {
    double P = threshold(strip, (int)table[k][0], 1);
    say("strip of %g: %.10g (%.1e)\n", table[k][0], P, P / table[k][1] - 1);
    assert_near_rel(P, table[k][1], 1e-6);
  }
}

/* A tendril held straight: T = alpha^2 kappa^2/beta - 4 pi^2 alpha/L^2 on fine meshes (McMillen and Goriely
 * 2002 for the infinite one). Second order, 4e-4 at 161 vertices. */
static void tendril(void **state) {
  (void)state;
  double error[2];
  for (int fine = 0; fine < 2; fine++)
    error[fine] = threshold("trace/tendril", fine ? 81 : 41, 1) / 9.87709831458 - 1;
  say("tendril: %.3e, %.3e\n", error[0], error[1]);
  assert_near_rel(error[0] / error[1], (79.0 / 39) * (79.0 / 39), 0.05);
  assert_near_rel(error[1] * (79.0 / 159) * (79.0 / 159), -4e-4, 0.05);
}

/* Complete elliptic integrals of modulus k by the arithmetic-geometric mean. */
static void elliptic(double k, double *K, double *E) {
  double a = 1, g = sqrt(1 - k * k), c = k, sum = 0.5 * k * k, power = 0.5;
  while (fabs(c) > 1e-16) {
    c = 0.5 * (a - g);
    double mean = 0.5 * (a + g);
    g = sqrt(a * g);
    a = mean;
    power *= 2;
    sum += power * c * c;
  }
  *K = pi / (2 * a);
  *E = *K * (1 - sum);
}

/* Largest errors of the pinned elastica along its whole branch: force from the amplitude, and shortening. */
static void elastica_errors(int n, double error[2], bool timed) {
  traced t = {.count = 0};
  char a[80];
  clock_t started = clock();
  traced_begin(&t, "trace/euler", traced_set(a, "parameters.n", n), NULL);
  double seconds = (double)(clock() - started) / CLOCKS_PER_SEC;
  error[0] = error[1] = 0;
  for (int i = 0; i < t.count; i++) {
    const traced_point *p = &t.points[i];
    double low = 0, high = 1 - 1e-9, K, E;
    if (p->branch != 1 || p->kind == HB_TRACE_START) continue;
    for (int k = 0; k < 60; k++) { /* the modulus whose load it is */
      double middle = 0.5 * (low + high);
      elliptic(middle, &K, &E);
      if (4 * K * K < p->parameter)
        low = middle;
      else
        high = middle;
    }
    double scale =
        p->parameter > 14 ? 1 : 0; /* beside the threshold amplitudes grow with the root of the load */
    error[0] = fmax(error[0], scale * fabs(fabs(p->middle[1]) - low / K));
    error[1] = fmax(error[1], scale * fabs(p->last[0] - (1 - 2 * (1 - E / K))));
    assert_true(p->residual < 1e-6);
  }
  say("elastica of %d: %.3e, %.3e; %d points, %.2f s\n", n, error[0], error[1], t.count, seconds);
  /* the ends meet at 130.7 degrees; from there on the loop may turn about them */
  const traced_point *meet = traced_find(&t, 1, HB_TRACE_BIFURCATION, 0);
  assert_near(meet->last[0], 0, 1e-5);
  assert_int_equal(meet->multiplicity, 2);
  assert_near(traced_find(&t, 2, HB_TRACE_LIMIT, 0)->middle[1],
              -traced_find(&t, 1, HB_TRACE_LIMIT, 0)->middle[1], 1e-8);
  if (timed) {
    assert_true(t.count >= 200);
#if defined(__OPTIMIZE__) && !defined(__SANITIZE_ADDRESS__)
    assert_at_most(seconds, 2);
#endif
  }
  traced_end(&t);
}

/* Post-buckling through a loop (Love 1927, art. 262): second order all along; 200 points of 101 vertices in
 * less than 2 s. */
static void elastica(void **state) {
  (void)state;
  double error[2][2];
  elastica_errors(51, error[0], false);
  elastica_errors(101, error[1], true);
  for (int c = 0; c < 2; c++) {
    assert_at_most(error[1][c], 2.5e-3); /* (edge * largest curvature)^2/12 */
    assert_near_rel(error[0][c] / error[1][c], 4, 0.1);
  }
}

/* The heavy column bent over at Q = 20: lateral place and height of the tip; second order, extrapolated. */
static void bent_column(void **state) {
  (void)state;
  double lateral[2], height[2];
  for (int fine = 0; fine < 2; fine++) {
    traced t = {.count = 0};
    traced_begin(&t, "trace/heavy-column", fine ? "parameters.n=81" : "parameters.n=41", NULL);
    const traced_point *end = traced_find(&t, 1, HB_TRACE_LIMIT, 0);
    lateral[fine] = hypot(end->last[0], end->last[1]);
    height[fine] = end->last[2];
    assert_int_equal(end->unstable, 0);
    assert_int_equal(end->neutral, 1); /* it turns about the vertical */
    assert_int_equal(traced_find(&t, 0, HB_TRACE_LIMIT, 0)->unstable, 2);
    traced_end(&t);
  }
  double ratio = (79.5 / 39.5) * (79.5 / 39.5);
  say("bent column: %.3e %.3e\n", lateral[1] / 0.704969563366 - 1, height[1] / -0.334133013538 - 1);
  assert_near(lateral[1] + (lateral[1] - lateral[0]) / (ratio - 1), 0.704969563366, 2e-5);
  assert_near(height[1] + (height[1] - height[0]) / (ratio - 1), -0.334133013538, 2e-5);
}

/* Love's force of the spring whose turns cannot change. */
static double love(double z) {
  double a = 0.02, b = 0.015, R = 0.05, c = 0.02 / (2 * pi), sum = R * R + c * c, kappa = R / sum,
         tau = c / sum;
  double omega = hypot(kappa, tau), k = omega * sqrt(1 - z * z), t = omega * z, r = k / (omega * omega);
  return (b * (t - tau) * k / omega - a * (k - kappa) * t / omega) / r;
}

/* The spring along its whole branch: second order everywhere, extrapolated to Love's force. */
static void spring(void **state) {
  (void)state;
  traced t[2] = {{.count = 0}, {.count = 0}};
  double worst = 0, least = HUGE_VAL, most = 0;
  assert_near_rel(love(0.4), 2.29393530606, 1e-9);
  for (int fine = 0; fine < 2; fine++) {
    char a[80];
    traced_begin(&t[fine], "trace/spring", traced_set(a, "parameters.n", fine ? 121 : 61), "trace.to=0.4",
                 NULL);
    assert_int_equal(traced_find(&t[fine], 0, HB_TRACE_LIMIT, 0)->unstable, 0);
    assert_int_equal(traced_count(&t[fine], 0, HB_TRACE_BIFURCATION), 0);
  }
  for (int i = 0; i < t[0].count; i++) { /* the finer one at the same stretch, between two of its points */
    const traced_point *p = &t[0].points[i], *q = t[1].points;
    while (q[1].parameter < p->parameter) q++;
    double part = (p->parameter - q[0].parameter) / (q[1].parameter - q[0].parameter), T = love(p->parameter);
    double fine = -q[0].force[2] * (1 - part) - q[1].force[2] * part, coarse = -p->force[2];
    worst = fmax(worst, fabs((fine + (fine - coarse) / 3) / T - 1));
    least = fmin(least, (coarse - T) / (fine - T));
    most = fmax(most, (coarse - T) / (fine - T));
  }
  say("spring: extrapolated %.2e off, errors fall by %.3f to %.3f\n", worst, least, most);
  assert_at_most(worst, 3e-3);
  assert_near_rel(least, 4.1, 0.03);
  assert_near_rel(most, 4.1, 0.03);
  traced_end(&t[0]);
  traced_end(&t[1]);
}

/* A twisted rod lets itself be turned through a planar loop at 2 pi; reflected, the angle p becomes 4 pi - p:
 * so do the folds, between which the loop is stable. */
static void loop(void **state) {
  (void)state;
  traced t = {.count = 0};
  traced_begin(&t, "trace/twisted-rod", "parameters.n=41", NULL);
  const traced_point *first = traced_find(&t, 1, HB_TRACE_FOLD, 0),
                     *second = traced_find(&t, 1, HB_TRACE_FOLD, 1);
  say("folds %.12g %.12g, sum over 4 pi %.1e\n", first->parameter, second->parameter,
      (first->parameter + second->parameter) / (4 * pi) - 1);
  assert_near_rel(first->parameter + second->parameter, 4 * pi, 1e-9);
  assert_near_rel(first->energy, second->energy, 1e-6);
  assert_int_equal(traced_count(&t, 1, HB_TRACE_BIFURCATION), 0);
  for (const traced_point *p = first + 1; p < second; p++) assert_int_equal(p->unstable, 0);
  for (const traced_point *p = first - 1; p->kind != HB_TRACE_START; p--) assert_int_equal(p->unstable, 1);
  for (const traced_point *p = first + 1; p < second; p++) assert_true(p->parameter > first->parameter);
  traced_end(&t);
}

/* Clamps that come closer: the supports move with the parameter, and with time the same way. */
static void moving_clamps(void **state) {
  (void)state;
  static const char arch[] =
      "parameters: {n: 22, short: 0.1, l: 1/(n - 2)}\n"
      "method: {time_step: 1e-5, duration: 0}\n"
      "rods:\n"
      "  - rest: {line: {from: [-l/2, 0, 0], to: [1 + l/2, 0, 0], vertices: n}}\n"
      "    initial: {displace: [\"-0.1*u\", \"0.6*sqrt(0.1)*sin(pi*u)^2\", 0]}\n"
      "    bending: 1\n    twisting: 1\n    linear_density: 1\n"
      "    start: {position: [-l/2, 0, 0], tangent: [1, 0, 0], material: fixed}\n"
      "    end: {position: [1 - short - t + l/2, 0, 0], tangent: [1, 0, 0], material: fixed}\n"
      "trace: {parameter: short, from: 0.1, to: 0.3, branches: 1, step: 0.1}\n";
  double force[2];
  for (int time = 0; time < 2; time++) {
    traced t = {.count = 0};
    if (time)
      traced_begin(&t, arch, "trace.parameter=t", "trace.from=0", "trace.to=0.2", NULL);
    else
      traced_begin(&t, arch, NULL);
    force[time] = traced_find(&t, 0, HB_TRACE_LIMIT, 0)->force[0];
    assert_true(t.count <= 25); /* with a wrong derivative by the parameter, steps get short: 42 points */
    assert_int_equal(traced_find(&t, 0, HB_TRACE_LIMIT, 0)->unstable, 0);
    traced_end(&t);
  }
  assert_near_rel(force[0] / 46.61212087983 - 1, 2.52e-2, 6e-3);
  assert_near_rel(force[0], force[1], 1e-9);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(euler_loads),
      cmocka_unit_test(springy_strut),
      cmocka_unit_test(heavy_column),
      cmocka_unit_test(twisted_rod),
      cmocka_unit_test(twisted_without_tension),
      cmocka_unit_test(rings),
      cmocka_unit_test(lateral_buckling),
      cmocka_unit_test(tendril),
      cmocka_unit_test(elastica),
      cmocka_unit_test(bent_column),
      cmocka_unit_test(spring),
      cmocka_unit_test(loop),
      cmocka_unit_test(moving_clamps),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
