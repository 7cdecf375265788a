/* Curve generators: against closed forms and numbers from mpmath and scipy, equal edges, exact ends, and
 * every sentence. */
#include "hebra/curve.h"
#include "support/near.h"
#include "support/rng.h"

#include <float.h>
#include <stdlib.h>
#include <string.h>

static const double pi = 3.14159265358979323846;
static const double origin[3] = {0, 0, 0}, ex[3] = {1, 0, 0}, ey[3] = {0, 1, 0}, ez[3] = {0, 0, 1};
static const double down[3] = {0, 0, -1};

/* Fails the test with the sentence of a call that should have worked. */
static void must(hb_status status, const hb_error *err) {
  if (status != HB_OK) fail_msg("%s", err->text);
}

/* Length of edge i. */
static double edge(const double *xyz, int i) {
  const double *p = xyz + 3 * i;
  return sqrt((p[3] - p[0]) * (p[3] - p[0]) + (p[4] - p[1]) * (p[4] - p[1]) + (p[5] - p[2]) * (p[5] - p[2]));
}

/* Largest difference of two edges over the mean edge. */
static double spread(const double *xyz, int count) {
  double least = HUGE_VAL, most = 0;
  for (int i = 0; i + 1 < count; i++) {
    least = fmin(least, edge(xyz, i));
    most = fmax(most, edge(xyz, i));
  }
  return (most - least) / (hb_curve_length(xyz, count) / (count - 1));
}

/* Straight, ends exact, and the same points from the other end. */
static void test_line(void **state) {
  (void)state;
  const double a[3] = {0.1, -2, 3}, b[3] = {1.7, 0.3, 3};
  double xyz[3 * 26], back[3 * 26];
  hb_error err;
  must(hb_curve_line(a, b, 26, xyz, &err), &err);
  must(hb_curve_line(b, a, 26, back, &err), &err);
  for (int i = 0; i < 26; i++)
    for (int k = 0; k < 3; k++) {
      assert_near(xyz[3 * i + k], a[k] + (b[k] - a[k]) * i / 25, 1e-15);
      assert_same(xyz[3 * i + k], back[3 * (25 - i) + k]);
    }
  for (int k = 0; k < 3; k++) {
    assert_same(xyz[k], a[k]);
    assert_same(xyz[75 + k], b[k]);
  }
  assert_at_most(spread(xyz, 26), 1e-13);
  assert_near(hb_curve_length(xyz, 26), sqrt(1.6 * 1.6 + 2.3 * 2.3), 1e-14);
  must(hb_curve_line(a, b, 2, xyz, &err), &err);
  assert_same(xyz[5], 3);
  assert_same(hb_curve_length(xyz, 1), 0);
}

/* Quarter circle in a tilted plane; a whole one closes exactly; the start direction is projected. */
static void test_arc(void **state) {
  (void)state;
  const double center[3] = {1, 2, 3}, start[3] = {5, 0, 7};
  double xyz[3 * 31];
  hb_error err;
  must(hb_curve_arc(center, ez, start, 2, pi / 2, 31, xyz, &err), &err);
  for (int i = 0; i < 31; i++) {
    double a = pi / 2 * i / 30;
    assert_near(xyz[3 * i], 1 + 2 * cos(a), 2e-15);
    assert_near(xyz[3 * i + 1], 2 + 2 * sin(a), 2e-15);
    assert_same(xyz[3 * i + 2], 3);
  }
  assert_at_most(spread(xyz, 31), 1e-13);
  must(hb_curve_arc(center, ez, start, 2, -pi / 2, 31, xyz, &err), &err);
  assert_near(xyz[91], 0, 1e-15);
  const double turns[2] = {2 * pi, -2 * pi};
  for (int k = 0; k < 2; k++) {
    must(hb_curve_arc(center, ex, ey, 2, turns[k], 31, xyz, &err), &err);
    assert_memory_equal(xyz, xyz + 90, 3 * sizeof *xyz);
    assert_near(hb_curve_length(xyz, 31), 30 * 4 * sin(pi / 30), 1e-13);
    assert_near(xyz[3 * 15 + 1], 0, 1e-14);
    assert_at_most(spread(xyz, 31), 1e-13);
  }
}

/* Places on a helix, its sense, and edges of the closed form; a hundred turns lose no digits. */
static void test_helix(void **state) {
  (void)state;
  double xyz[3 * 1001];
  hb_error err;
  must(hb_curve_helix(origin, ez, ex, 2, 0.5, 3, 121, xyz, &err), &err);
  for (int i = 0; i < 121; i++) {
    double a = 2 * pi * 3 * i / 120;
    assert_near(xyz[3 * i], 2 * cos(a), 2e-14);
    assert_near(xyz[3 * i + 1], 2 * sin(a), 2e-14);
    assert_near(xyz[3 * i + 2], 1.5 * i / 120, 1e-15);
  }
  assert_near(edge(xyz, 0), sqrt(pow(4 * sin(pi * 3 / 120), 2) + pow(1.5 / 120, 2)), 1e-15);
  assert_at_most(spread(xyz, 121), 1e-13);
  must(hb_curve_helix(origin, ez, ex, 2, 0.5, -3, 121, xyz, &err), &err);
  assert_true(xyz[4] < 0 && xyz[5] > 0);
  must(hb_curve_helix(origin, ez, ex, 2, -0.5, 3, 121, xyz, &err), &err);
  assert_true(xyz[4] > 0 && xyz[5] < 0);
  must(hb_curve_helix(origin, ez, ex, 1, 0.01, 100.25, 1001, xyz, &err), &err);
  assert_near(xyz[3000], 0, 1e-15);
  assert_near(xyz[3001], 1, 1e-15);
  assert_near(xyz[3002], 1.0025, 1e-15);
  assert_at_most(spread(xyz, 1001), 2e-14);
}

/* All vertices on z = A cosh((x - x0)/A) - A cosh(x0/A), and the edges equal. */
static void check_catenary(double span, double rise, double length, double A, double x0, int count,
                           double tolerance) {
  double *xyz = calloc(3 * (size_t)count, sizeof *xyz);
  const double b[3] = {span, 0, rise};
  hb_error err = {HB_OK, ""};
  assert_non_null(xyz);
  must(hb_curve_catenary(origin, b, down, length, count, xyz, &err), &err);
  for (int i = 0; i < count; i++) {
    double x = xyz[3 * i], half = x / (2 * A);
    /* cosh(p) - cosh(q) = 2 sinh((p+q)/2) sinh((p-q)/2) */
    double z = 2 * A * sinh(half - x0 / A) * sinh(half);
    assert_near(xyz[3 * i + 2], z, tolerance);
    assert_same(xyz[3 * i + 1], 0);
  }
  assert_memory_equal(xyz + 3 * (count - 1), b, sizeof b);
  assert_at_most(spread(xyz, count), 1e-13 + 16 * DBL_EPSILON * count * (1 + length / (span + length)));
  free(xyz);
}

/* Case V23 of the catalogue and others; A and x0 from 50-digit arithmetic. */
static void test_catenary_shape(void **state) {
  (void)state;
  static const int counts[] = {5, 25, 26, 101, 1000};
  for (int k = 0; k < 5; k++) {
    check_catenary(1, 0, 1.2, 0.46954152312652814, 0.5, counts[k], 1e-15);
    check_catenary(0.8, 0.5, 1.2, 0.28450391177401324, 0.2737793850463316, counts[k], 2e-15);
    check_catenary(1, 3, 3.1622808224460397, 64.54996449484382, -116.88004201059594, counts[k], 1e-9);
  }
}

/* V23: sag and horizontal force H = A w with w = 0.4905, the angle of the end. */
static void test_catenary_catalogue(void **state) {
  (void)state;
  static double xyz[3 * 20001];
  hb_error err;
  must(hb_curve_catenary(origin, ex, down, 1.2, 20001, xyz, &err), &err);
  assert_near(xyz[3 * 10000 + 2], -0.2923437976009, 1e-13);
  assert_near(xyz[3 * 10000], 0.5, 1e-14);
  assert_near(atan2(xyz[5], xyz[3]), -0.9067746549926, 1e-4);
  /* the first edge's angle tends to the end's with the first power of the edge: extrapolated it agrees */
  double coarse[3 * 10001];
  must(hb_curve_catenary(origin, ex, down, 1.2, 10001, coarse, &err), &err);
  assert_near(2 * atan2(xyz[5], xyz[3]) - atan2(coarse[5], coarse[3]), -0.9067746549926, 1e-8);
  assert_near(hb_curve_length(xyz, 20001), 1.2, 1e-9);
}

/* Nearly taut, and very slack: depth of the lowest vertex from 50-digit arithmetic. */
static void test_catenary_extremes(void **state) {
  (void)state;
  double xyz[3 * 101];
  hb_error err;
  must(hb_curve_catenary(origin, ex, down, 1.000000001, 25, xyz, &err), &err);
  assert_near(xyz[3 * 12 + 2], -1.9364917538944985e-05, 1e-15);
  assert_near(hb_curve_length(xyz, 25), 1.000000001, 2e-12);
  must(hb_curve_catenary(origin, ex, down, 1.00000000000001, 25, xyz, &err), &err);
  assert_near(xyz[3 * 12 + 2], -6.12127658916825e-08, 1e-15);
  must(hb_curve_catenary(origin, ex, down, nextafter(1, 2), 25, xyz, &err), &err);
  assert_true(xyz[3 * 12 + 2] < -8e-9 && xyz[3 * 12 + 2] > -1e-8); /* sqrt(3/8 * 2.2e-16) */
  must(hb_curve_catenary(origin, ex, down, 1000, 25, xyz, &err), &err);
  assert_near(xyz[3 * 12 + 2], -499.9494602330185, 1e-12);
  assert_near(xyz[3 * 12], 0.5, 1e-9); /* the long steep edges hardly tell where it is */
  assert_at_most(spread(xyz, 25), 1e-13);
}

/* Places of the vertices on the curve: chords made equal by 50-digit arithmetic. */
static void test_catenary_chords(void **state) {
  (void)state;
  static const double level[] = {0, 0, 0.21621994838369923, -0.2039464298380838, 0.5, -0.2923437976009288};
  static const double inclined[] = {0.19753467601356134,  -0.13193627901072197, 0.43246566368024486,
                                    -0.09679995904214367, 0.6022136394703216,   0.06937090080442886,
                                    0.7164994162547111,   0.2776156874661036};
  double xyz[3 * 6];
  hb_error err;
  must(hb_curve_catenary(origin, ex, down, 1.2, 5, xyz, &err), &err);
  for (int i = 0; i < 3; i++) {
    assert_near(xyz[3 * i], level[2 * i], 1e-15);
    assert_near(xyz[3 * i + 2], level[2 * i + 1], 1e-15);
    assert_near(xyz[3 * (4 - i)], 1 - level[2 * i], 1e-15);
  }
  const double b[3] = {0.8, 0, 0.5};
  must(hb_curve_catenary(origin, b, down, 1.2, 6, xyz, &err), &err);
  for (int i = 0; i < 4; i++) {
    assert_near(xyz[3 * i + 3], inclined[2 * i], 1e-15);
    assert_near(xyz[3 * i + 5], inclined[2 * i + 1], 1e-15);
  }
}

/* Gravity along any direction, places anywhere: turned and moved like its frame. */
static void test_catenary_turned(void **state) {
  (void)state;
  const double a[3] = {3, -1, 2}, b[3] = {3.5, -1, 2.8}, along_x[3] = {4, 0, 0}, flat_b[3] = {0.8, 0, -0.5};
  double xyz[3 * 26], flat[3 * 26];
  hb_error err;
  must(hb_curve_catenary(a, b, along_x, 1.2, 26, xyz, &err), &err);
  must(hb_curve_catenary(origin, flat_b, down, 1.2, 26, flat, &err), &err);
  for (int i = 0; i < 26; i++) {
    assert_near(xyz[3 * i + 2] - 2, flat[3 * i], 3e-15);
    assert_near(3 - xyz[3 * i], flat[3 * i + 2], 3e-15);
  }
}

/* Natural spline through five points, 8 edges: scipy's spline divided by an independent iteration. */
static void test_spline_natural(void **state) {
  (void)state;
  static const double points[] = {0, 0, 0, 1, 0.5, 0, 1.5, 2, 0.25, 0.5, 3, 1, -1, 2.5, 1.5};
  static const double known[][3] = {
      {0.0, 0.0, 0.0},
      {0.7131573973804252, 0.27485806068122726, -0.007400102729862903},
      {1.2448393158047806, 0.8232439214242658, 0.020572631101374254},
      {1.502186090366857, 1.5359329950184448, 0.12078296231650379},
      {1.4224301806140025, 2.257879601997856, 0.3587478336960615},
      {0.999491433929789, 2.7891507347239943, 0.7095597328177307},
      {0.36042404632591424, 3.0106803297945213, 1.0655270081245014},
      {-0.3399581237894759, 2.840860014871015, 1.3201268213687705},
      {-1.0, 2.5, 1.5},
  };
  double xyz[3 * 101];
  hb_error err;
  must(hb_curve_spline(points, 5, false, 9, xyz, &err), &err);
  assert_near_array(xyz, &known[0][0], 27, 1e-14);
  must(hb_curve_spline(points, 5, false, 101, xyz, &err), &err);
  assert_at_most(spread(xyz, 101), 1e-13);
  must(hb_curve_spline(points, 2, false, 5, xyz, &err), &err);
  assert_near(xyz[6], 0.5, 1e-15);
  assert_near(xyz[7], 0.25, 1e-15);
}

/* Closed spline through the same points, 10 edges; repeating the first point at the end changes nothing. */
static void test_spline_closed(void **state) {
  (void)state;
  static const double points[] = {0, 0, 0, 1, 0.5, 0, 1.5, 2, 0.25, 0.5, 3, 1, -1, 2.5, 1.5, 0, 0, 0};
  static const double known[][3] = {
      {0.0, 0.0, 0.0},
      {0.87224440272119, 0.341761503801267, -0.029911901568571514},
      {1.3621923175799893, 1.1328451082984747, 0.08253238168147717},
      {1.492647770723994, 2.043022223577598, 0.2643700537452247},
      {1.0341156760865469, 2.7514126820879485, 0.6723372361181283},
      {0.2669562527945212, 3.0431504952733097, 1.12495342344075},
      {-0.5898870859833877, 2.9238796569474053, 1.4856470681468332},
      {-1.0686208800458978, 2.127156079840513, 1.3650177121885512},
      {-0.9260489356180293, 1.3097692835301675, 0.9290612793951329},
      {-0.5799736357823398, 0.5796173807068793, 0.45407072047678476},
      {0.0, 0.0, 0.0},
  };
  double xyz[3 * 101], again[3 * 11];
  hb_error err;
  must(hb_curve_spline(points, 5, true, 11, xyz, &err), &err);
  assert_near_array(xyz, &known[0][0], 33, 1e-14);
  assert_memory_equal(xyz, xyz + 30, 3 * sizeof *xyz);
  must(hb_curve_spline(points, 6, true, 11, again, &err), &err);
  assert_memory_equal(xyz, again, sizeof again);
  must(hb_curve_spline(points, 5, true, 101, xyz, &err), &err);
  assert_at_most(spread(xyz, 101), 1e-13);
}

/* Three quarters of a trefoil in 12 edges: chords made equal by 50-digit arithmetic. */
static void test_torus_knot(void **state) {
  (void)state;
  static const double known[][3] = {
      {1.907189652517684, 1.3047786417757494, 0.3916634548137417},
      {0.3399391148476795, 1.729699230687348, 0.44014769763808914},
      {-1.039068237532785, 1.1203293131608656, -0.16498823932528164},
      {-2.0391942453354504, -0.11575539677965024, -0.49819243329366814},
      {-1.7776278468410749, -1.6926676246274088, -0.2081694663530346},
      {-0.3898157328603433, -2.396449118841678, 0.2585763115603942},
      {1.0454821184564076, -1.6745486075668847, 0.4993297255275862},
      {1.4975427103474668, -0.17030282856847692, 0.08451852252708092},
      {1.2521440195529987, 1.3365646343192001, -0.47074034354978245},
      {-0.007723513276986623, 2.3552755161890917, -0.35181004719556763},
      {-1.520557506537367, 1.9718526628970485, 0.09930268917904116},
      {-2.112843008818601, 0.5050715860447057, 0.46934813623317745},
      {-1.327417431503008, -0.9081351249255949, 0.31080498413533225},
  };
  double xyz[3 * 241];
  const double center[3] = {1, 2, 3};
  hb_error err;
  must(hb_curve_torus_knot(origin, 2, 0.5, 2, 3, 0.3, 0.75, 13, xyz, &err), &err);
  assert_near_array(xyz, &known[0][0], 39, 5e-15);
  must(hb_curve_torus_knot(center, 2, 0.5, 2, 3, 0, 1, 241, xyz, &err), &err);
  assert_memory_equal(xyz, xyz + 720, 3 * sizeof *xyz);
  assert_at_most(spread(xyz, 241), 2e-13);
  for (int i = 0; i < 241; i++) {
    double reach = hypot(xyz[3 * i] - 1, xyz[3 * i + 1] - 2) - 2;
    assert_near(hypot(reach, xyz[3 * i + 2] - 3), 0.5, 2e-15);
  }
  for (int i = 0; i <= 80; i++) { /* a third of the way is a third of a turn about z, twice */
    double x = xyz[3 * i] - 1, y = xyz[3 * i + 1] - 2, c = cos(4 * pi / 3), s = sin(4 * pi / 3);
    assert_near(xyz[3 * (i + 80)] - 1, c * x - s * y, 1e-14);
    assert_near(xyz[3 * (i + 80) + 1] - 2, s * x + c * y, 1e-14);
    assert_near(xyz[3 * (i + 80) + 2], xyz[3 * i + 2], 1e-14);
  }
}

/* Uniform in the parameter, as in the thesis's second example; u and i beside s. */
static void test_formula(void **state) {
  (void)state;
  static const char *const texts[] = {"s", "u + 100*i", "cosh(4.35464*s - 2.17732)/4.35464 - 1.02602"};
  hb_formula *f[3] = {NULL, NULL, NULL};
  double xyz[75];
  hb_error err;
  for (int k = 0; k < 3; k++) must(hb_formula_parse(texts[k], HB_VARS_ARC, NULL, 0, &f[k], &err), &err);
  must(hb_curve_formula(f, 0, 1, 25, xyz, &err), &err);
  for (int i = 0; i < 25; i++) {
    assert_near(xyz[3 * i], i / 24.0, 2e-16);
    assert_near(xyz[3 * i + 1], i / 24.0 + 100 * i, 1e-12);
    assert_near(xyz[3 * i + 2], xyz[3 * (24 - i) + 2], 1e-15);
  }
  assert_near(xyz[2], 9.10765316786133e-6, 1e-15); /* cosh(2.17732)/4.35464 - 1.02602 */
  must(hb_curve_formula(f, 2, -1, 4, xyz, &err), &err);
  assert_same(xyz[0], 2);
  assert_near(xyz[3], 1, 1e-15);
  assert_same(xyz[9], -1);
  for (int k = 0; k < 3; k++) hb_formula_free(f[k]);
}

/* Corners: the right angle in 2 and 3 edges has closed forms. */
static void test_resample_corner(void **state) {
  (void)state;
  static const double corner[] = {0, 0, 0, 1, 0, 0, 1, 1, 0};
  double xyz[12], c = 2 - sqrt(2);
  hb_error err;
  must(hb_curve_resample(corner, 3, 3, xyz, &err), &err);
  assert_near_array(xyz, corner, 9, 1e-15);
  must(hb_curve_resample(corner, 3, 4, xyz, &err), &err);
  const double known[] = {0, 0, 0, c, 0, 0, 1, 1 - c, 0, 1, 1, 0};
  assert_near_array(xyz, known, 12, 1e-15);
  must(hb_curve_resample(corner, 3, 2, xyz, &err), &err);
  assert_memory_equal(xyz + 3, corner + 6, 3 * sizeof *xyz);
}

/* A closed square in 4 edges is itself, in 3 edges symmetric about the diagonal. */
static void test_resample_closed(void **state) {
  (void)state;
  static const double square[] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, 0, 0, 0};
  double xyz[15];
  hb_error err;
  must(hb_curve_resample(square, 5, 5, xyz, &err), &err);
  assert_near_array(xyz, square, 15, 1e-15);
  must(hb_curve_resample(square, 5, 4, xyz, &err), &err);
  /* (1, y) and (y, 1) with 1 + y^2 = 2 (1 - y)^2: y = 2 - sqrt(3) */
  assert_near(xyz[3], 1, 1e-15);
  assert_near(xyz[4], 2 - sqrt(3), 1e-15);
  assert_near(xyz[6], 2 - sqrt(3), 1e-15);
  assert_near(xyz[7], 1, 1e-15);
  must(hb_curve_resample(square, 5, 3, xyz, &err), &err);
  assert_near(edge(xyz, 0), edge(xyz, 1), 1e-15);
}

/* Distance of p from the segment a b. */
static double from_segment(const double *p, const double *a, const double *b) {
  double dot = 0, square = 0, sum = 0;
  for (int k = 0; k < 3; k++) {
    dot += (p[k] - a[k]) * (b[k] - a[k]);
    square += (b[k] - a[k]) * (b[k] - a[k]);
  }
  double f = fmin(1, fmax(0, dot / square));
  for (int k = 0; k < 3; k++) sum += pow(p[k] - a[k] - f * (b[k] - a[k]), 2);
  return sqrt(sum);
}

/* Random crooked lines: vertices on the line in order, equal edges, exact ends; resampling again changes
 * nothing. */
static void test_resample_random(void **state) {
  (void)state;
  double points[3 * 30], xyz[3 * 200], again[3 * 200];
  int divided = 0;
  hb_error err;
  for (uint64_t seed = 0; seed < 300; seed++) {
    rng r = rng_start(seed);
    int n = rng_int(&r, 2, 30), count = rng_int(&r, 3 * n, 3 * n + 100);
    points[0] = points[1] = points[2] = 0;
    for (int i = 1; i < n; i++) {
      double d[3];
      rng_direction(&r, d);
      for (int k = 0; k < 3; k++)
        points[3 * i + k] = points[3 * i - 3 + k] + rng_uniform(&r, 0.2, 1.5) * (d[k] + (k == 0 ? 1.2 : 0));
    }
    if (hb_curve_resample(points, n, count, xyz, &err) != HB_OK) {
      assert_non_null(strstr(err.text, "use more vertices"));
      continue;
    }
    divided++;
    assert_memory_equal(xyz, points, 3 * sizeof *xyz);
    assert_memory_equal(xyz + 3 * (count - 1), points + 3 * (n - 1), 3 * sizeof *xyz);
    assert_at_most(spread(xyz, count), 1e-13 + 8 * DBL_EPSILON * count);
    for (int i = 0, k = 0; i < count; i++) {
      while (k < n - 2 && from_segment(xyz + 3 * i, points + 3 * k, points + 3 * k + 3) > 1e-13) k++;
      assert_at_most(from_segment(xyz + 3 * i, points + 3 * k, points + 3 * k + 3), 1e-13);
    }
    must(hb_curve_resample(xyz, count, count, again, &err), &err);
    assert_near_array(again, xyz, 3 * count, 1e-12);
  }
  assert_in_range(divided, 285, 300);
}

/* Ten thousand vertices: edges equal to the round-off of the coordinates. */
static void test_many_vertices(void **state) {
  (void)state;
  enum { COUNT = 10001 };
  static double xyz[3 * COUNT], again[3 * COUNT];
  hb_error err;
  must(hb_curve_torus_knot(origin, 2, 0.5, 3, 7, 0, 1, COUNT, xyz, &err), &err);
  assert_at_most(spread(xyz, COUNT), 1e-11);
  must(hb_curve_resample(xyz, COUNT, 501, again, &err), &err);
  assert_at_most(spread(again, 501), 1e-12);
  must(hb_curve_catenary(origin, ex, down, 3, COUNT, xyz, &err), &err);
  assert_at_most(spread(xyz, COUNT), 2e-11);
}

/* ---- sentences
 * ----------------------------------------------------------------------------------------------- */

/* The call fails with HB_ERR_INPUT and this sentence. */
static void refused(hb_status status, const hb_error *err, const char *sentence) {
  assert_string_equal(err->text, sentence);
  assert_int_equal(status, HB_ERR_INPUT);
  assert_int_equal(err->status, HB_ERR_INPUT);
}

#define COUNT_2 ", allowed are 2 to 10000000"
#define COUNT_3 ", allowed are 3 to 10000000"
#define POSITIVE ", allowed are finite numbers greater than 0"

/* Lines, and what all generators share. */
static void test_sentences_line(void **state) {
  (void)state;
  const double bad[3] = {0, (double)NAN, 0};
  double xyz[30];
  hb_error e;
  refused(hb_curve_line(origin, ex, 1, xyz, &e), &e, "the number of vertices is 1" COUNT_2);
  refused(hb_curve_line(origin, ex, -5, xyz, &e), &e, "the number of vertices is -5" COUNT_2);
  refused(hb_curve_line(origin, ex, 10000001, xyz, &e), &e, "the number of vertices is 10000001" COUNT_2);
  refused(hb_curve_line(ex, ex, 3, xyz, &e), &e,
          "the line starts and ends at (1, 0, 0), allowed are two different points");
  refused(hb_curve_line(bad, ex, 3, xyz, &e), &e,
          "the start of the line has the value nan, allowed are finite numbers");
  refused(hb_curve_line(ex, bad, 3, xyz, &e), &e,
          "the end of the line has the value nan, allowed are finite numbers");
  const double near_x[3] = {nextafter(1, 2), 0, 0};
  refused(hb_curve_line(ex, near_x, 10, xyz, &e), &e, "vertices 0 and 1 of the curve coincide at (1, 0, 0)");
  assert_int_equal(hb_curve_line(ex, ex, 3, xyz, NULL), HB_ERR_INPUT);
}

/* Arcs. */
static void test_sentences_arc(void **state) {
  (void)state;
  const double inf[3] = {HUGE_VAL, 0, 0};
  double xyz[30];
  hb_error e;
  refused(hb_curve_arc(origin, ez, ex, 1, 1, 1, xyz, &e), &e, "the number of vertices is 1" COUNT_2);
  refused(hb_curve_arc(inf, ez, ex, 1, 1, 3, xyz, &e), &e,
          "the centre of the arc has the value inf, allowed are finite numbers");
  refused(hb_curve_arc(origin, ez, ex, 0, 1, 3, xyz, &e), &e, "the radius of the arc is 0" POSITIVE);
  refused(hb_curve_arc(origin, ez, ex, 1, 0, 3, xyz, &e), &e,
          "the angle of the arc is 0, allowed are -2*pi to 2*pi (radians) except 0");
  refused(hb_curve_arc(origin, ez, ex, 1, 6.3, 3, xyz, &e), &e,
          "the angle of the arc is 6.3, allowed are -2*pi to 2*pi (radians) except 0");
  refused(hb_curve_arc(origin, ez, ex, 1, (double)NAN, 3, xyz, &e), &e,
          "the angle of the arc is nan, allowed are -2*pi to 2*pi (radians) except 0");
  refused(hb_curve_arc(origin, ez, ex, 1, 2 * pi, 2, xyz, &e), &e,
          "the number of vertices is 2, a full circle needs at least 3");
  refused(hb_curve_arc(origin, origin, ex, 1, 1, 3, xyz, &e), &e,
          "the normal of the arc is (0, 0, 0), a direction is needed");
  refused(hb_curve_arc(origin, ez, origin, 1, 1, 3, xyz, &e), &e,
          "the start direction is (0, 0, 0), a direction is needed");
  refused(
      hb_curve_arc(origin, ez, ez, 1, 1, 3, xyz, &e), &e,
      "the start direction (0, 0, 1) is parallel to the normal of the arc, allowed is any other direction");
}

/* Helices. */
static void test_sentences_helix(void **state) {
  (void)state;
  double xyz[30];
  hb_error e;
  refused(hb_curve_helix(origin, ez, ex, 1, 1, 1, 0, xyz, &e), &e, "the number of vertices is 0" COUNT_2);
  refused(hb_curve_helix(origin, ez, ex, -1, 1, 1, 3, xyz, &e), &e, "the radius of the helix is -1" POSITIVE);
  refused(hb_curve_helix(origin, ez, ex, 1, HUGE_VAL, 1, 3, xyz, &e), &e,
          "the pitch of the helix has the value inf, allowed are finite numbers");
  refused(hb_curve_helix(origin, ez, ex, 1, 1, HUGE_VAL, 3, xyz, &e), &e,
          "the number of turns has the value inf, allowed are finite numbers");
  refused(hb_curve_helix(origin, ez, ex, 1, 1, 0, 3, xyz, &e), &e,
          "the number of turns is 0, allowed is any other number");
  refused(hb_curve_helix(origin, origin, ex, 1, 1, 1, 3, xyz, &e), &e,
          "the axis of the helix is (0, 0, 0), a direction is needed");
  refused(
      hb_curve_helix(origin, ex, ex, 1, 1, 1, 3, xyz, &e), &e,
      "the start direction (1, 0, 0) is parallel to the axis of the helix, allowed is any other direction");
  refused(hb_curve_helix(origin, ez, ex, 1, 0, 2, 3, xyz, &e), &e,
          "vertices 0 and 1 of the curve coincide at (1, 0, 0)");
}

/* Catenaries. */
static void test_sentences_catenary(void **state) {
  (void)state;
  const double above[3] = {0, 0, 1}, bad[3] = {(double)NAN, 0, 0};
  double xyz[300];
  hb_error e;
  refused(hb_curve_catenary(origin, ex, down, 2, 1, xyz, &e), &e, "the number of vertices is 1" COUNT_2);
  refused(hb_curve_catenary(bad, ex, down, 2, 3, xyz, &e), &e,
          "the first end of the catenary has the value nan, allowed are finite numbers");
  refused(hb_curve_catenary(origin, bad, down, 2, 3, xyz, &e), &e,
          "the last end of the catenary has the value nan, allowed are finite numbers");
  refused(hb_curve_catenary(origin, ex, bad, 2, 3, xyz, &e), &e,
          "the down direction has the value nan, allowed are finite numbers");
  refused(hb_curve_catenary(origin, ex, origin, 2, 3, xyz, &e), &e,
          "the down direction is (0, 0, 0), a direction is needed");
  refused(hb_curve_catenary(origin, ex, down, 0, 3, xyz, &e), &e, "the length of the catenary is 0" POSITIVE);
  refused(hb_curve_catenary(origin, ex, down, 1, 3, xyz, &e), &e,
          "the length of the catenary is 1, allowed are numbers greater than the distance of its ends, 1");
  refused(hb_curve_catenary(origin, above, down, 2, 3, xyz, &e), &e,
          "the ends of the catenary are 0 apart horizontally, allowed are at least 1e-06 times its length; "
          "closer, it "
          "folds back on itself");
  refused(hb_curve_catenary(origin, ex, down, 1000, 26, xyz, &e), &e,
          "25 equal edges are too few for the curve: edge 12 would cut off a bend that is 978 times as long "
          "as the edge; "
          "use more vertices");
}

/* Splines. */
static void test_sentences_spline(void **state) {
  (void)state;
  const double points[] = {0, 0, 0, 1, 0, 0, 1, 0, 0, 2, (double)NAN, 0};
  double xyz[30];
  hb_error e;
  refused(hb_curve_spline(points, 2, false, 1, xyz, &e), &e, "the number of vertices is 1" COUNT_2);
  refused(hb_curve_spline(points, 2, true, 2, xyz, &e), &e, "the number of vertices is 2" COUNT_3);
  refused(hb_curve_spline(points, 1, false, 3, xyz, &e), &e,
          "the spline has 1 points, allowed are 2 to 312500");
  refused(hb_curve_spline(points, 2, true, 3, xyz, &e), &e,
          "the spline has 2 different points, allowed are 3 to 312500");
  refused(hb_curve_spline(points, 3, false, 3, xyz, &e), &e,
          "points 1 and 2 of the spline coincide at (1, 0, 0)");
  refused(hb_curve_spline(points + 6, 2, false, 3, xyz, &e), &e,
          "a point of the spline has the value nan, allowed are finite numbers");
}

/* Torus knots. */
static void test_sentences_knot(void **state) {
  (void)state;
  double xyz[60];
  hb_error e;
#define RADII ", allowed are 0 < r < R"
#define TURNS ", allowed are 1 to 1000"
#define PART ", allowed are numbers greater than 0 up to 1"
  refused(hb_curve_torus_knot(origin, 1, 1, 2, 3, 0, 1, 9, xyz, &e), &e,
          "the torus has the radii R = 1 and r = 1" RADII);
  refused(hb_curve_torus_knot(origin, 1, 0, 2, 3, 0, 1, 9, xyz, &e), &e,
          "the torus has the radii R = 1 and r = 0" RADII);
  refused(hb_curve_torus_knot(origin, 2, 1, 0, 3, 0, 1, 9, xyz, &e), &e,
          "the torus knot has p = 0 and q = 3" TURNS);
  refused(hb_curve_torus_knot(origin, 2, 1, 2, 1001, 0, 1, 9, xyz, &e), &e,
          "the torus knot has p = 2 and q = 1001" TURNS);
  refused(hb_curve_torus_knot(origin, 2, 1, 4, 6, 0, 1, 9, xyz, &e), &e,
          "the torus knot has p = 4 and q = 6 with the common divisor 2, so it would run 2 times over "
          "itself; allowed are "
          "numbers without a common divisor, such as p = 2 and q = 3");
  refused(hb_curve_torus_knot(origin, 2, 1, 2, 3, 0, 0, 9, xyz, &e), &e,
          "the part of the torus knot is 0" PART);
  refused(hb_curve_torus_knot(origin, 2, 1, 2, 3, 0, 1.5, 9, xyz, &e), &e,
          "the part of the torus knot is 1.5" PART);
  refused(hb_curve_torus_knot(origin, 2, 1, 2, 3, 0, 1, 2, xyz, &e), &e,
          "the number of vertices is 2" COUNT_3);
  refused(hb_curve_torus_knot(origin, 2, 1, 2, 3, (double)NAN, 1, 9, xyz, &e), &e,
          "the start angle of the torus knot has the value nan, allowed are finite numbers");
}

/* Curves by formula. */
static void test_sentences_formula(void **state) {
  (void)state;
  hb_formula *f[3] = {NULL, NULL, NULL};
  double xyz[30];
  hb_error e;
  static const char *const texts[] = {"s", "0", "1/(s - 0.5)"};
  for (int k = 0; k < 3; k++) must(hb_formula_parse(texts[k], HB_VARS_ARC, NULL, 0, &f[k], &e), &e);
  refused(hb_curve_formula(f, 0, 1, 1, xyz, &e), &e, "the number of vertices is 1" COUNT_2);
  refused(hb_curve_formula(f, 0, HUGE_VAL, 3, xyz, &e), &e,
          "the end of the parameter has the value inf, allowed are finite numbers");
  refused(hb_curve_formula(f, 2, 2, 3, xyz, &e), &e,
          "the parameter of the curve runs from 2 to 2, allowed are different numbers");
  refused(hb_curve_formula(f, 0, 1, 3, xyz, &e), &e,
          "the formula '1/(s - 0.5)' for z is inf at s = 0.5, allowed are finite numbers");
  hb_formula *flat[3] = {f[1], f[1], f[1]};
  refused(hb_curve_formula(flat, 0, 1, 3, xyz, &e), &e,
          "vertices 0 and 1 of the curve coincide at (0, 0, 0)");
  for (int k = 0; k < 3; k++) hb_formula_free(f[k]);
}

/* Resampling. */
static void test_sentences_resample(void **state) {
  (void)state;
  static const double ring[] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 0},
                      double_point[] = {0, 0, 0, 1, 0, 0, 1, 0, 0};
  const double bad[] = {0, 0, 0, HUGE_VAL, 0, 0};
  double xyz[30];
  hb_error e;
  refused(hb_curve_resample(ring, 1, 3, xyz, &e), &e,
          "a curve to resample has 1 vertex, at least 2 are needed");
  refused(hb_curve_resample(ring, 0, 3, xyz, &e), &e,
          "a curve to resample has 0 vertices, at least 2 are needed");
  refused(hb_curve_resample(ring, 4, 1, xyz, &e), &e, "the number of vertices is 1" COUNT_2);
  refused(hb_curve_resample(ring, 4, 2, xyz, &e), &e,
          "the number of vertices is 2, a closed curve needs at least 3");
  refused(hb_curve_resample(double_point, 3, 3, xyz, &e), &e,
          "vertices 1 and 2 of the curve coincide at (1, 0, 0)");
  refused(hb_curve_resample(bad, 2, 3, xyz, &e), &e,
          "vertex 1 of the curve is (inf, 0, 0), which is not finite");
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_line),
      cmocka_unit_test(test_arc),
      cmocka_unit_test(test_helix),
      cmocka_unit_test(test_catenary_shape),
      cmocka_unit_test(test_catenary_catalogue),
      cmocka_unit_test(test_catenary_extremes),
      cmocka_unit_test(test_catenary_chords),
      cmocka_unit_test(test_catenary_turned),
      cmocka_unit_test(test_spline_natural),
      cmocka_unit_test(test_spline_closed),
      cmocka_unit_test(test_torus_knot),
      cmocka_unit_test(test_formula),
      cmocka_unit_test(test_resample_corner),
      cmocka_unit_test(test_resample_closed),
      cmocka_unit_test(test_resample_random),
      cmocka_unit_test(test_many_vertices),
      cmocka_unit_test(test_sentences_line),
      cmocka_unit_test(test_sentences_arc),
      cmocka_unit_test(test_sentences_helix),
      cmocka_unit_test(test_sentences_catenary),
      cmocka_unit_test(test_sentences_spline),
      cmocka_unit_test(test_sentences_knot),
      cmocka_unit_test(test_sentences_formula),
      cmocka_unit_test(test_sentences_resample),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
