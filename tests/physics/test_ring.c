/* Rings against what is known of them: energies, tension of a spinning ring, and the loads at which they
 * leave their plane (catalogue: V13, V14, V15, V33). */
#include "hebra/modes.h"
#include "hebra/scene.h"
#include "hebra/sim.h"
#include "hebra/statics.h"
#include "math/rotation.h"
#include "rod/writhe.h"
#include "support/near.h"
#include "support/scenes.h"

#include <string.h>

/* A ring in the plane z = 0; `setting` changes its numbers. */
static const char ring_scene[] =
    "parameters: {n: 20, B: 1, G: 0.8, perimeter: 2*pi, twist: 0, natural: 0, turning: 0}\n"
    "method: {time_step: 5e-5, duration: 1}\n"
    "rods:\n"
    "  - closed: {twist: twist}\n"
    "    initial: {ring: {radius: perimeter/(2*n*sin(pi/n)), vertices: n + 1}}\n"
    "    natural_curvature: [0, -natural]\n"
    "    director: [0, 0, 1]\n"
    "    bending: B\n"
    "    twisting: G*B\n"
    "    linear_density: 0.1\n"
    "    velocity: [-turning*y, turning*x, 0]\n";

/* A simulation of it. */
static void begin(trial *t, const char *const *settings, int count) {
  hb_error err;
  memset(t, 0, sizeof *t);
  if (hb_scene_parse(ring_scene, strlen(ring_scene), "ring", ".", settings, count, &t->def, &err))
    fail_msg("%s", err.text);
  trial_start(t);
}

/* Unstable modes of the ring with n edges, ratio G and one more number. */
static int unstable(int n, double G, const char *name, double value) {
  trial t;
  char text[3][64];
  const char *settings[3] = {text[0], text[1], text[2]};
  hb_error err;
  hb_equilibrium result;
  hb_equilibrium_options options = hb_equilibrium_defaults(0);
  options.any = true;
  snprintf(text[0], sizeof text[0], "parameters.n=%d", n);
  snprintf(text[1], sizeof text[1], "parameters.G=%.17g", G);
  snprintf(text[2], sizeof text[2], "parameters.%s=%.17g", name, value);
  begin(&t, settings, 3);
  if (hb_sim_find_equilibrium(t.sim, &options, &result, &err)) fail_msg("%s", err.text);
  int count = result.unstable;
  hb_equilibrium_free(&result);
  trial_end(&t);
  return count;
}

/* Where the ring ceases to be stable, between a value where it is and one where it is not. */
static double threshold(int n, double G, const char *name, double stable, double beyond) {
  assert_int_equal(unstable(n, G, name, stable), 0);
  if (unstable(n, G, name, beyond) <= 0) fail_msg("n %d G %g %s %g: no unstable mode", n, G, name, beyond);
  for (int k = 0; k < 27; k++) {
    double middle = 0.5 * (stable + beyond);
    if (unstable(n, G, name, middle) > 0)
      beyond = middle;
    else
      stable = middle;
  }
  return 0.5 * (stable + beyond);
}

/* V13: Michell's ring. The thresholds of regular polygons to their last digit, of second order in the edge.
 */
static void test_michell(void **state) {
  (void)state;
  static const struct {
    int n;
    double twist;
  } exact[] = {{20, 14.7092143}, {30, 14.0841527}, {50, 13.7746168}, {100, 13.6460775}};
  double smooth = 2 * HB_PI * sqrt(3) / 0.8;
  for (size_t k = 0; k < sizeof exact / sizeof exact[0]; k++) {
    double found = threshold(exact[k].n, 0.8, "twist", 13, 15);
    say("V13: N %3d: %.8f, expected %.7f, smooth + %.4f %%\n", exact[k].n, found, exact[k].twist,
        100 * (found / smooth - 1));
    assert_near_rel(found, exact[k].twist, 1e-6);
  }
}

/* V13 again: the smooth threshold 2 pi sqrt(3) alpha/beta is approached at second order, for three ratios
 * within 0.5 % at 100 edges. */
static void test_michell_ratios(void **state) {
  (void)state;
  static const double ratio[3] = {0.5, 1, 1.25};
  for (int k = 0; k < 3; k++) {
    double smooth = 2 * HB_PI * sqrt(3) / ratio[k];
    double coarse = threshold(50, ratio[k], "twist", 0.9 * smooth, 1.1 * smooth) / smooth - 1;
    double fine = threshold(100, ratio[k], "twist", 0.9 * smooth, 1.1 * smooth) / smooth - 1;
    say("V13: beta/alpha %.2f: %.4f %% at 50 edges, %.4f %% at 100\n", ratio[k], 100 * coarse, 100 * fine);
    assert_at_most(fabs(fine), 0.005);
    assert_near(log2(coarse / fine), 2, 0.02);
  }
}

/* V14: the ring of a rod that is more curved by nature, x times as much; smooth thresholds from the
 * linearised rod, those of polygons to their last digit (beta/alpha = 2/3). The negative solutions of the
 * catalogue are not met by a ring whose frames are free: below x = 0 it first rolls over by half a turn,
 * which makes x positive. */
static void test_overcurved(void **state) {
  (void)state;
  static const struct {
    int n;
    double x;
  } exact[] = {{20, 1.86705204}, {50, 1.81738781}, {100, 1.81044784}};
  for (size_t k = 0; k < sizeof exact / sizeof exact[0]; k++) {
    double found = threshold(exact[k].n, 2.0 / 3, "natural", 1.5, 2);
    say("V14: N %3d: %.8f, expected %.8f\n", exact[k].n, found, exact[k].x);
    assert_near_rel(found, exact[k].x, 1e-6);
  }
  static const double smooth[][2] = {{0.5, 1.686140661635}, {1, 2}, {1.5, 2.212214450449}};
  for (int k = 0; k < 3; k++) {
    double G = smooth[k][0], end = 1.3 * smooth[k][1], off[2];
    for (int level = 0; level < 2; level++)
      off[level] = threshold(30 * (level + 1), G, "natural", 1, end) / smooth[k][1] - 1;
    say("V14: beta/alpha %.1f: %.4f %% at 60 edges\n", G, 100 * off[1]);
    assert_at_most(fabs(off[1]), 0.01);
    assert_near(log2(off[0] / off[1]), 2, 0.05);
  }
}

/* V15: bending energy pi alpha/R times (tan(pi/N)/(pi/N))^2; the tension of a spinning ring is rho A R^2 w^2,
 * here on the polygon: the mass of a vertex at its radius, pulled by two edges. */
static void test_energy_and_spin(void **state) {
  (void)state;
  static const struct {
    int n;
    const char *set;
    double factor;
  } exact[] = {{10, "parameters.n=10", 1.069676196833},
               {50, "parameters.n=50", 1.00263779448},
               {100, "parameters.n=100", 1.000658341806}};
  for (int k = 0; k < 3; k++) {
    trial t;
    const char *settings[] = {exact[k].set, "parameters.turning=3", "parameters.perimeter=pi"};
    begin(&t, settings, 3);
    const hb_frame *f = trial_measure(&t);
    double R = 0.5, h = HB_PI / exact[k].n, radius = 0.5 * h / sin(HB_PI / exact[k].n);
    assert_near_rel(f->bending, HB_PI / R * exact[k].factor, 1e-11);
    assert_int_equal(t.model->nv, exact[k].n + 1);
    for (int j = 0; j < exact[k].n; j++)
      assert_near_rel(f->tension[j], 0.1 * h * radius * 9 / (2 * sin(HB_PI / exact[k].n)), 1e-11);
    assert_near(f->tension[0], 0.225, 0.225 * 10 / (exact[k].n * exact[k].n));
    double spin = f->angular_momentum[2], mass = 0.1 * HB_PI;
    assert_near_rel(spin, mass * radius * radius * 3, 1e-12);
    trial_run(&t, 50);
    f = trial_measure(&t);
    assert_near_rel(f->angular_momentum[2], spin, 1e-12);
    trial_end(&t);
  }
}

/* V33: link 2 in a ring of length 1: energy beta (2 pi Lk)^2/(2 L) to the last digit on any polygon, evenly
 * spread, in closed form and by Newton's method. */
static void test_linked_ring(void **state) {
  (void)state;
  for (int general = 0; general < 2; general++) {
    trial t;
    const char *settings[] = {"rods[0].closed={link: 2}", "parameters.perimeter=1", "parameters.B=0.1",
                              "parameters.G=0.15",
                              general ? "rods[0].damping={bending: 0}" : "parameters.n=20"};
    begin(&t, settings, 5);
    assert_int_equal(t.model->rods[0].closed_form, !general);
    const hb_frame *f = trial_measure(&t);
    assert_near_rel(f->twisting, 1.184352528131, 1e-12);
    for (int i = 1; i <= 20; i++) assert_near(f->twist[i], 4 * HB_PI / 20, 1e-12);
    assert_near(f->theta[20] - f->theta[0], 4 * HB_PI, 1e-12);
    trial_end(&t);
  }
}

/* Modes of a ring that is a ring by nature: omega^2 R^4 rho A/alpha in its plane (Hoppe 1871) and out of it
 * (Love, Treatise, art. 293), both for every number of waves k >= 2, each twice. */
static double exact_square(int waves, bool out_of_plane, double G) {
  double k = waves * waves;
  return k * (k - 1) * (k - 1) / (out_of_plane ? k + 1 / G : k + 1);
}

/* The largest error of the first three frequencies of both kinds, relative. */
static double mode_error(int n, double G) {
  trial t;
  char text[2][64];
  const char *settings[] = {text[0], text[1], "parameters.natural=1", "parameters.twist=0"};
  hb_error err;
  hb_equilibrium at;
  hb_modes modes;
  hb_equilibrium_options options = hb_equilibrium_defaults(0);
  double worst = 0;
  snprintf(text[0], sizeof text[0], "parameters.n=%d", n);
  snprintf(text[1], sizeof text[1], "parameters.G=%.17g", G);
  begin(&t, settings, 4);
  options.any = true;
  if (hb_sim_find_equilibrium(t.sim, &options, &at, &err)) fail_msg("%s", err.text);
  if (hb_sim_find_modes(t.sim, &at, 18, &modes, &err)) fail_msg("%s", err.text);
  for (int k = 0; k < 6; k++) assert_near(modes.mode[k].square, 0, 1e-7); /* the ring as a whole */
  assert_int_equal(modes.unstable, 0);
  assert_int_equal(modes.freedom, 3 * n - n);
  for (int k = 0; k < 12; k++) { /* k = 2, 3, 4: out of the plane first, then in it */
    bool out_of_plane = k % 4 < 2;
    double expected = exact_square(2 + k / 4, out_of_plane, G) * 1 / 0.1, found = modes.mode[6 + k].square,
           flat = 0;
    worst = fmax(worst, fabs(found / expected - 1));
    for (int i = 0; i <= n; i++) flat = fmax(flat, fabs(modes.mode[6 + k].shape[3 * i + 2]));
    assert_true(out_of_plane ? flat > 0.1 : flat < 1e-6);
  }
  hb_modes_free(&modes);
  hb_equilibrium_free(&at);
  trial_end(&t);
  return worst;
}

/* Second order. */
static void test_frequencies(void **state) {
  (void)state;
  for (int k = 0; k < 2; k++) {
    double G = k ? 0.5 : 0.8, coarse = mode_error(50, G), fine = mode_error(100, G);
    say("modes: beta/alpha %.1f: omega^2 off by %.4f %% at 50 edges, %.4f %% at 100\n", G, 100 * coarse,
        100 * fine);
    assert_at_most(fine, 0.02);
    assert_near(log2(coarse / fine), 2, 0.05);
  }
}

/* Twist, writhe and link of a frame that is measured now; what they say of each other holds to round-off. */
static hb_link link_now(trial *t) {
  hb_link link;
  hb_error err;
  if (hb_frame_link(t->model, trial_measure(t), 0, &link, &err)) fail_msg("%s", err.text);
  assert_true(link.defined);
  assert_at_most(link.error, 1e-12);
  return link;
}

/* One of the scenes of rings, step by step; every output frame has the link of the first, to round-off.
 * Returns the bending energy of the last one times the length. */
static double run_scene(const char *name, double link_expected) {
  char path[400];
  trial t;
  hb_error err;
  memset(&t, 0, sizeof t);
  snprintf(path, sizeof path, "%s/scenes/rings/%s.yaml", HEBRA_SOURCE_DIR, name);
  if (hb_scene_read(path, NULL, 0, &t.def, &err)) fail_msg("%s", err.text);
  trial_start(&t);
  hb_link first = link_now(&t), link = first;
  assert_near(first.twist + first.writhe, link_expected, 1e-12);
  for (long n = hb_sim_total_steps(t.sim) / t.def.output.every; n > 0; n--) {
    trial_run(&t, t.def.output.every);
    link = link_now(&t);
    assert_near(link.twist + link.writhe, link_expected, 1e-12);
    assert_true(link.link == first.link);
  }
  say("%s: twist %.6f -> %.6f, writhe %.6f -> %.6f turns\n", name, first.twist, link.twist, first.writhe,
      link.writhe);
  double energy = t.frame->bending * t.model->rods[0].length;
  assert_at_most(fabs(t.frame->balance), 1e-3 * (t.frame->bending + t.frame->twisting));
  trial_end(&t);
  return energy;
}

/* Lk = Tw + Wr in every frame (V50.10), while writhe takes over from twist; the trefoil comes near the circle
 * that goes round twice, whose energy is 8 pi^2 alpha/L (Langer and Singer 1984). */
static void test_scenes(void **state) {
  (void)state;
  (void)run_scene("michell", 16 / (2 * HB_PI));
  (void)run_scene("bandsaw", 0);
  double energy = run_scene("trefoil", -3);
  assert_near_rel(energy, 8 * HB_PI * HB_PI, 0.01);
}

/* A ring hung at a vertex: what solve finds is where damped motion ends, explicit or implicit, and the
 * support bears the weight. */
static void test_hanging(void **state) {
  (void)state;
  static const char scene[] =
      "parameters: {n: 24}\n"
      "method: {time_step: 2e-3, duration: 25}\n"
      "gravity: [0, 0, -2]\n"
      "rods:\n"
      "  - closed: true\n"
      "    initial: {ring: {radius: 1, vertices: n + 1, normal: [0, 1, 0], start: [0, 0, 1]}}\n"
      "    bending: 1\n"
      "    twisting: 0.7\n"
      "    linear_density: 1\n"
      "    damping: {mass: 4}\n"
      "    supports: [{vertex: 0, position: fixed}]\n";
  static const char *const ways[] = {"method.integrator=verlet", "method.integrator=implicit"};
  double sag[3];
  for (int k = 0; k < 3; k++) {
    trial t;
    hb_error err;
    const char *settings[] = {k < 2 ? ways[k] : ways[0],
                              k == 1 ? "method.time_step=0.05" : "parameters.n=24"};
    memset(&t, 0, sizeof t);
    if (hb_scene_parse(scene, strlen(scene), "hanging", ".", settings, 2, &t.def, &err))
      fail_msg("%s", err.text);
    trial_start(&t);
    if (k < 2) {
      trial_run(&t, hb_sim_total_steps(t.sim));
      (void)trial_measure(&t);
    } else {
      hb_equilibrium found;
      hb_equilibrium_options options = hb_equilibrium_defaults(0);
      if (hb_sim_find_equilibrium(t.sim, &options, &found, &err)) fail_msg("%s", err.text);
      assert_int_equal(found.unstable, 0);
      hb_sim_measure_equilibrium(t.sim, &found, t.frame);
      hb_equilibrium_free(&found);
    }
    const double *reaction = t.frame->reaction;
    assert_near(reaction[2] + reaction[3 * 24 + 2], 2 * t.model->rods[0].length, 1e-6);
    assert_near(reaction[0], 0, 1e-6); /* each half is half of the whole */
    sag[k] = 1 - t.frame->position[3 * 12 + 2];
    trial_end(&t);
  }
  say("hanging ring: sags to %.9f, %.9f, %.9f\n", sag[0], sag[1], sag[2]);
  assert_near(sag[0], sag[2], 1e-7);
  assert_near(sag[1], sag[2], 1e-7);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_michell),     cmocka_unit_test(test_michell_ratios),
      cmocka_unit_test(test_overcurved),  cmocka_unit_test(test_energy_and_spin),
      cmocka_unit_test(test_linked_ring), cmocka_unit_test(test_frequencies),
      cmocka_unit_test(test_scenes),      cmocka_unit_test(test_hanging)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
