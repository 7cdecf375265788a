/* Pictures of very many tubes: how thin they are drawn, how light fades among them, the same bytes
 * everywhere. */
#include "math/rotation.h"
#include "render/thicket.h"
#include "support/near.h"
#include "support/rng.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#define GOLDEN_THICKET 0x47ecfc040c14629au
enum { MOST = 6000 };

/* Straight segments of the given length and any direction, evenly spread over a cube of side 1 around the
 * origin: their middles, folded back into it. */
static void scatter(int count, double length, double *xyz, hb_tube *tubes) {
  rng r = rng_start(77);
  for (int k = 0; k < count; k++) {
    double d[3];
    rng_direction(&r, d);
    for (int c = 0; c < 3; c++) {
      double middle = rng_uniform(&r, -0.5, 0.5);
      xyz[6 * k + c] = middle - 0.5 * length * d[c];
      xyz[6 * k + 3 + c] = middle + 0.5 * length * d[c];
    }
    tubes[k] = (hb_tube){.xyz = xyz + 6 * k, .nv = 2, .color = {0.5, 0.3, 0.2}};
  }
}

/* A parallel view of 2 units' height. */
static hb_camera front(void) {
  return (hb_camera){.eye = {0, -10, 0}, .up = {0, 0, 1}, .orthographic = true, .height = 2};
}

/* Strands of so many segments as they are drawn on 400 x 400 pixels. */
static void make(int count, double length, double *xyz, hb_tube *tubes, hb_lens *lens, hb_strands *strands) {
  hb_camera camera = front();
  hb_error err;
  scatter(count, length, xyz, tubes);
  hb_lens_make(&camera, (hb_rect){0, 0, 400, 400}, lens);
  assert_int_equal(hb_strands_make(tubes, count, lens, strands, &err), HB_OK);
}

/* One tube has its 3.5 pixels; more tubes than the picture holds get thinner, but never vanish; a tube that
 * is thick by itself stays so. */
static void test_radius(void **state) {
  (void)state;
  static double xyz[6 * MOST];
  static hb_tube tubes[MOST];
  hb_lens lens;
  hb_strands strands;
  hb_error err;
  static const struct {
    int count;
    double pixels; /* radius: 1.75, or that with which the tubes cover half of the picture, at least 0.3 */
  } cases[] = {{1, 1.75}, {500, 1.75}, {2000, 1.0}, {4000, 0.5}, {MOST, 1.0 / 3}};
  for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
    /* 20 pixels each: n tubes of radius r cover 40 n r of the 160000 pixels */
    make(cases[k].count, 0.1, xyz, tubes, &lens, &strands);
    assert_near(strands.radius / lens.pixel, cases[k].pixels, 1e-9);
    assert_int_equal(strands.thicket, cases[k].pixels < 0.5 * 1.75);
    hb_strands_free(&strands);
  }
  make(MOST, 0.2, xyz, tubes, &lens, &strands);
  assert_near(strands.radius / lens.pixel, 0.3, 1e-9);
  hb_strands_free(&strands);
  tubes[MOST - 1].radius = 0.05;
  assert_int_equal(hb_strands_make(tubes, MOST, &lens, &strands, &err), HB_OK);
  assert_same(strands.radius, 0.05);
  assert_false(strands.thicket);
  hb_strands_free(&strands);
}

/* Segments of total length Z and any direction in a unit cube hide, over a way w, the share 1 - exp(-tau) of
 * the lamp with tau = Z 2r (pi/4) w: pi/4 is the mean of the sine of the angle to a line (isotropic fibres).
 * The depth on the grid is that, and the light fades exponentially with it. */
static void test_depth(void **state) {
  (void)state;
  static double xyz[6 * MOST];
  static hb_tube tubes[MOST];
  hb_lens lens;
  hb_strands strands;
  hb_thicket thicket;
  hb_error err;
  make(MOST, 0.02, xyz, tubes, &lens, &strands); /* 4 pixels each */
  for (int i = 0; i < MOST; i++) strands.look[i].radius = 0.01;
  const hb_v3 key = {0, -1, 0}; /* from above */
  assert_int_equal(hb_thicket_make(&strands, key, &thicket, &err), HB_OK);
  double tau = MOST * 0.02 * 2 * 0.01 * HB_PI / 4, rate = 0, sums[3] = {0, 0, 0};
  static const double ways[3] = {0.25, 0.5, 0.75};
  for (int n = 0; n < 3; n++)
    for (int k = 0; k < 441; k++) { /* mean over a level */
      hb_v3 p = {0.04 * (k % 21 - 10), -0.5 + ways[n], 10 + 0.04 * (k / 21 - 10)};
      sums[n] -= log(hb_thicket_sun(&thicket, p)) / 441;
    }
  rate = sums[1] / (0.5 * tau); /* share of what is in the way that the light loses */
  assert_in_range(1000 * rate, 400, 700);
  assert_near_rel(sums[0], rate * 0.25 * tau, 0.04);
  assert_near_rel(sums[2], rate * 0.75 * tau, 0.04);
  double whole = -log(hb_thicket_sun(&thicket, (hb_v3){0.05, 3, 10})),
         beside = hb_thicket_sun(&thicket, (hb_v3){3, 0, 10});
  assert_near_rel(whole, rate * tau, 0.15); /* one column only */
  assert_same(beside, 1);
  assert_same(hb_thicket_sun(&thicket, (hb_v3){0, -2, 10}), 1);
  double sun, sky, outside;
  hb_thicket_light(&thicket, (hb_v3){0, 0, 10}, &sun, &sky);
  assert_same(sun, hb_thicket_sun(&thicket, (hb_v3){0, 0, 10}));
  hb_thicket_light(&thicket, (hb_v3){0, -0.49, 10}, &sun, &outside);
  assert_true(sky > 0.2 && sky < outside && outside < 1);
  hb_thicket_free(&thicket);
  hb_strands_free(&strands);
}

/* Bytes of a picture with a shadow, a place that is no number, and tubes of nothing. */
static void test_golden(void **state) {
  (void)state;
  static double xyz[6 * MOST];
  static hb_tube tubes[MOST];
  hb_camera camera = front();
  hb_image image;
  hb_error err;
  const double ground = -0.7, up[3] = {0, 0, 1}, lo[3] = {-0.6, -0.6, -0.7}, hi[3] = {0.6, 0.6, 0.6};
  scatter(MOST, 0.2, xyz, tubes);
  xyz[0] = (double)NAN;
  tubes[1].nv = 0;
  hb_camera_fit(lo, hi, (const double[3]){0.4, -0.9, 0.5}, up, false, 1.5, &camera);
  assert_int_equal(hb_image_create(300, 200, &image, &err), HB_OK);
  assert_int_equal(hb_render_view(&image, 0, 0, 300, 200, tubes, MOST, &camera, &ground, &err), HB_OK);
  const char *keep = getenv("HEBRA_KEEP_PICTURES");
  if (keep) {
    char path[512];
    snprintf(path, sizeof path, "%s/thicket.png", keep);
    assert_int_equal(hb_image_write_png(&image, path, NULL), HB_OK);
  }
  uint64_t hash = 0xcbf29ce484222325u;
  for (int i = 0; i < 3 * 300 * 200; i++) hash = (hash ^ image.rgb[i]) * 0x100000001b3u;
  if (hash != GOLDEN_THICKET) print_error("the picture's hash is 0x%016llx\n", (unsigned long long)hash);
  assert_true(hash == GOLDEN_THICKET);
  hb_image_free(&image);
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_radius), cmocka_unit_test(test_depth),
                                     cmocka_unit_test(test_golden)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
