/* The tube renderer: what it draws where, and that it draws the same bytes everywhere. */
#include "render/draw.h"
#include "render/lens.h"
#include "render/tripod.h"
#include "support/near.h"

#include "hebra/render.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const unsigned char page[3] = {250, 249, 246};
static const double up[3] = {0, 0, 1};
#define not_a_number ((double)NAN)

/* Hashes of the golden pictures. */
#define GOLDEN_TREFOIL 0x878ccf83544068f1u
#define GOLDEN_HELIX 0x18193b1a7abd145au
#define GOLDEN_THREE_VIEWS 0x356b390dd32e5158u

/* FNV-1a over the pixels. */
static uint64_t hash(const hb_image *image) {
  uint64_t h = 0xcbf29ce484222325u;
  size_t count = (size_t)image->width * (size_t)image->height * 3;
  for (size_t i = 0; i < count; i++) h = (h ^ image->rgb[i]) * 0x100000001b3u;
  return h;
}

/* Cosine and sine of a turn 0..1 from square roots and products only: the same bits with every C library. */
static void turn(double part, double *c, double *s) {
  double x = 1, y = 0, a = -1, b = 0; /* a, b: half a turn, then a quarter, an eighth ... */
  part -= floor(part);
  for (int k = 0; k < 40; k++) {
    part *= 2;
    if (part >= 1) {
      double nx = x * a - y * b;
      y = x * b + y * a;
      x = nx;
      part -= 1;
    }
    double half = sqrt(0.5 * (1 + a));
    b = k == 0 ? 1 : sqrt(0.5 * (1 - a));
    a = k == 0 ? 0 : half;
  }
  *c = x;
  *s = y;
}

/* A helix about the x axis, five turns. */
static void helix(double *xyz, int nv) {
  for (int i = 0; i < nv; i++) {
    double c, s;
    turn(5.0 * i / (nv - 1), &c, &s);
    xyz[3 * i] = 4.0 * i / (nv - 1);
    xyz[3 * i + 1] = 0.5 * c;
    xyz[3 * i + 2] = 0.5 * s;
  }
}

/* A trefoil on a torus. */
static void trefoil(double *xyz, int nv) {
  for (int i = 0; i < nv; i++) {
    double c2, s2, c3, s3;
    turn(2.0 * i / (nv - 1), &c2, &s2);
    turn(3.0 * i / (nv - 1), &c3, &s3);
    xyz[3 * i] = (2 + c3) * c2;
    xyz[3 * i + 1] = (2 + c3) * s2;
    xyz[3 * i + 2] = s3;
  }
}

/* A straight rod along (1, 1, 0) and first directors that turn three half turns. */
static void twisted(double *xyz, double *m1, int nv) {
  const double r = 0.7071067811865476;
  for (int i = 0; i < nv; i++) {
    xyz[3 * i] = xyz[3 * i + 1] = (double)i / (nv - 1);
    xyz[3 * i + 2] = i == 1 ? 0.05 : 0;
    if (i == nv - 1) break;
    double c, s;
    turn(1.5 * i / (nv - 2), &c, &s);
    m1[3 * i] = s * r;
    m1[3 * i + 1] = -s * r;
    m1[3 * i + 2] = c;
  }
}

/* A picture of the page's colour. */
static hb_image blank(int width, int height) {
  hb_image image;
  hb_error err;
  assert_int_equal(hb_image_create(width, height, &image, &err), HB_OK);
  hb_image_fill(&image, page);
  return image;
}

/* Pixel x, y. */
static const unsigned char *pixel(const hb_image *image, int x, int y) {
  return image->rgb + 3 * ((size_t)y * (size_t)image->width + (size_t)x);
}

/* Does a pixel differ from the page? */
static bool drawn(const hb_image *image, int x, int y) { return memcmp(pixel(image, x, y), page, 3) != 0; }

/* Pixels that differ from the page. */
static int count_drawn(const hb_image *image) {
  int count = 0;
  for (int y = 0; y < image->height; y++)
    for (int x = 0; x < image->width; x++) count += drawn(image, x, y);
  return count;
}

/* A parallel view along +y of `height` units around the origin: 1 unit is image height / height pixels. */
static hb_camera front(double height) {
  return (hb_camera){
      .eye = {0, -10, 0}, .target = {0, 0, 0}, .up = {0, 0, 1}, .orthographic = true, .height = height};
}

/* One tube drawn over the whole picture. */
static void draw(hb_image *image, const hb_tube *tubes, int count, const hb_camera *camera,
                 const double *ground) {
  hb_error err = {HB_OK, ""};
  assert_int_equal(
      hb_render_view(image, 0, 0, image->width, image->height, tubes, count, camera, ground, &err), HB_OK);
}

/* A straight tube has its width and length, to a pixel. */
static void test_silhouette(void **state) {
  (void)state;
  const double xyz[] = {-1, 0, 0, 0, 0, 0, 1, 0, 0};
  const hb_tube tube = {.xyz = xyz, .nv = 3, .radius = 0.25, .color = {0.2, 0.4, 0.6}};
  hb_image image = blank(300, 200);
  hb_camera camera = front(4); /* 50 pixels per unit: 25 wide, 100 long and two round ends of 12.5 */
  draw(&image, &tube, 1, &camera, NULL);
  int tall = 0, wide = 0;
  for (int y = 0; y < 200; y++) tall += drawn(&image, 150, y);
  for (int x = 0; x < 300; x++) wide += drawn(&image, x, 100);
  assert_near(tall, 25, 1.01);
  assert_near(wide, 125, 1.01);
  assert_false(drawn(&image, 150 + 61, 100 - 9)); /* the corner that a round end leaves free */
  assert_true(drawn(&image, 150 + 49, 100 - 9));
  hb_image_free(&image);
}

/* Bends have neither cracks nor spikes: the picture of a ring is one closed band. */
static void test_no_cracks(void **state) {
  (void)state;
  enum { NV = 9 };
  double xyz[3 * NV];
  for (int i = 0; i < NV; i++) {
    double c, s;
    turn((double)i / (NV - 1), &c, &s);
    xyz[3 * i] = c;
    xyz[3 * i + 1] = 0;
    xyz[3 * i + 2] = s;
  }
  const hb_tube tube = {.xyz = xyz, .nv = NV, .radius = 0.1, .color = {0.2, 0.4, 0.6}};
  hb_image image = blank(300, 300);
  hb_camera camera = front(3);
  draw(&image, &tube, 1, &camera, NULL);
  for (int k = 0; k < 720; k++) {
    double c, s;
    turn(k / 720.0, &c, &s);
    for (int n = -7; n <= 7; n++) { /* well inside the band */
      double r = 100 + n;
      assert_true(drawn(&image, (int)floor(150 + r * c), (int)floor(150 - r * s)));
    }
    assert_false(drawn(&image, (int)floor(150 + 117 * c), (int)floor(150 - 117 * s)));
    assert_false(drawn(&image, (int)floor(150 + 82 * c), (int)floor(150 - 82 * s)));
  }
  hb_image_free(&image);
}

/* What is nearer hides what is behind, whatever the order. */
static void test_depth(void **state) {
  (void)state;
  const double level[] = {-1, -1, 0, 1, -1, 0}, steep[] = {0, 1, -1, 0, 1, 1};
  const hb_tube a = {.xyz = level, .nv = 2, .radius = 0.2, .color = {0.9, 0.1, 0.1}};
  const hb_tube b = {.xyz = steep, .nv = 2, .radius = 0.2, .color = {0.1, 0.1, 0.9}};
  hb_camera camera = front(3);
  for (int order = 0; order < 2; order++) {
    const hb_tube tubes[2] = {order ? b : a, order ? a : b};
    hb_image image = blank(200, 200);
    draw(&image, tubes, 2, &camera, NULL);
    assert_true(pixel(&image, 100, 100)[0] > pixel(&image, 100, 100)[2]); /* red in front */
    assert_true(pixel(&image, 100, 60)[2] > pixel(&image, 100, 60)[0]);   /* blue above it */
    hb_image_free(&image);
  }
}

/* The stripe is where the first director points. */
static void test_stripe(void **state) {
  (void)state;
  const double xyz[] = {-1, 0, 0, 1, 0, 0}, toward[] = {0, -1, 0}, away[] = {0, 1, 0};
  hb_tube tube = {.xyz = xyz, .nv = 2, .radius = 0.3, .color = {0.15, 0.44, 0.53}};
  hb_camera camera = front(3);
  int red[3];
  const double *const directors[3] = {NULL, toward, away};
  for (int k = 0; k < 3; k++) {
    tube.m1 = directors[k];
    hb_image image = blank(120, 120);
    draw(&image, &tube, 1, &camera, NULL);
    red[k] = pixel(&image, 60, 60)[0];
    hb_image_free(&image);
  }
  assert_int_equal(red[0], red[2]);
  assert_true(red[1] > red[0] + 60);
}

/* The stripe leads once around the tube where the director does. */
static void test_stripe_turns(void **state) {
  (void)state;
  enum { NV = 65 };
  double xyz[3 * NV], m1[3 * (NV - 1)];
  for (int i = 0; i < NV; i++) {
    xyz[3 * i] = 4.0 * i / (NV - 1) - 2;
    xyz[3 * i + 1] = xyz[3 * i + 2] = 0;
    if (i == NV - 1) break;
    m1[3 * i] = 0;
    turn((i + 0.5) / (NV - 1), &m1[3 * i + 1], &m1[3 * i + 2]);
  }
  const hb_tube tube = {.xyz = xyz, .m1 = m1, .nv = NV, .radius = 0.3, .color = {0.15, 0.44, 0.53}};
  hb_camera camera = front(3);
  hb_image image = blank(500, 300);
  draw(&image, &tube, 1, &camera, NULL);
  /* Along the middle line the director faces the viewer (-y) only about half a turn: the middle of the rod.
   */
  for (int x = 60; x < 440; x += 10) {
    const unsigned char *p = pixel(&image, x, 150);
    double part = (x - 50) / 400.0, off = fabs(part - 0.5);
    if (off < 0.115) assert_true(p[0] > p[2]);
    if (off > 0.135) assert_true(p[0] < p[2]);
  }
  hb_image_free(&image);
}

/* The ground is darker under the tube than far away; without ground nothing is. */
static void test_shadow(void **state) {
  (void)state;
  const double xyz[] = {-1, 0, 0.3, 1, 0, 0.3}, ground = 0;
  const hb_tube tube = {.xyz = xyz, .nv = 2, .radius = 0.1, .color = {0.5, 0.5, 0.5}};
  const hb_camera camera = {.eye = {0, -6, 6}, .target = {0, 0, 0}, .up = {0, 0, 1}, .height = 0.6};
  hb_image with = blank(300, 300), without = blank(300, 300);
  draw(&with, &tube, 1, &camera, &ground);
  draw(&without, &tube, 1, &camera, NULL);
  int darker = 0;
  for (int y = 0; y < 300; y++)
    for (int x = 0; x < 300; x++) {
      if (drawn(&without, x, y)) continue;
      darker += drawn(&with, x, y);
      assert_true(pixel(&with, x, y)[1] <= page[1]);
    }
  assert_true(darker > 1000);
  assert_false(drawn(&with, 5, 5));
  hb_image_free(&with);
  hb_image_free(&without);
}

/* A tube too thin to see is drawn a few pixels wide. */
static void test_thin(void **state) {
  (void)state;
  const double xyz[] = {-1, 0, 0, 1, 0, 0};
  const double radii[] = {0, 1e-9, -1, not_a_number};
  hb_camera camera = front(3);
  for (int k = 0; k < 4; k++) {
    const hb_tube tube = {.xyz = xyz, .nv = 2, .radius = radii[k], .color = {0, 0, 0}};
    hb_image image = blank(600, 600);
    draw(&image, &tube, 1, &camera, NULL);
    int tall = 0;
    for (int y = 0; y < 600; y++) tall += drawn(&image, 300, y);
    assert_true(tall >= 2 && tall <= 5); /* 3.5 pixels */
    hb_image_free(&image);
  }
}

/* Places that are not numbers cut a tube in two; the rest is drawn as if they were two tubes. */
static void test_not_a_number(void **state) {
  (void)state;
  double xyz[3 * 20];
  helix(xyz, 20);
  const double lo[3] = {-1, -1, -1}, most[3] = {5, 1, 1}, dir[3] = {0.3, -1, 0.4};
  hb_camera camera;
  hb_camera_fit(lo, most, dir, up, false, 1.5, &camera);
  const hb_tube halves[2] = {{.xyz = xyz, .nv = 9, .radius = 0.1, .color = {0.2, 0.4, 0.6}},
                             {.xyz = xyz + 30, .nv = 10, .radius = 0.1, .color = {0.2, 0.4, 0.6}}};
  hb_image expected = blank(300, 200), actual = blank(300, 200);
  draw(&expected, halves, 2, &camera, NULL);
  xyz[28] = not_a_number;
  const hb_tube whole = {.xyz = xyz, .nv = 20, .radius = 0.1, .color = {0.2, 0.4, 0.6}};
  draw(&actual, &whole, 1, &camera, NULL);
  assert_true(count_drawn(&actual) > 500);
  assert_true(hash(&actual) == hash(&expected));
  hb_image_free(&expected);
  hb_image_free(&actual);
}

/* Whatever comes in, a picture comes out. */
static void test_survives(void **state) {
  (void)state;
  const double odd[] = {0, not_a_number, HUGE_VAL, -HUGE_VAL, 1e99, -1e99, 1e150, 1e300, 1e-300, 1};
  enum { ODD = sizeof odd / sizeof odd[0], NV = 6 };
  double xyz[3 * NV], m1[3 * NV];
  unsigned seed = 1;
  for (int trial = 0; trial < 300; trial++) {
    double values[64];
    for (int k = 0; k < 64; k++) {
      seed = seed * 1664525u + 1013904223u;
      values[k] = seed >> 29 == 0 ? odd[(seed >> 8) % ODD] : (seed >> 8 & 0xffff) / 32768.0 - 1;
    }
    memcpy(xyz, values, sizeof xyz);
    memcpy(m1, values + 18, sizeof m1);
    if (trial % 3 == 0) memcpy(xyz + 6, xyz + 3, 3 * sizeof(double)); /* coincident vertices */
    const hb_tube tube = {.xyz = xyz,
                          .m1 = trial & 1 ? m1 : NULL,
                          .nv = trial % (NV + 1),
                          .radius = values[40] * 0.2,
                          .color = {values[41], values[42], values[43]}};
    hb_camera camera = {.orthographic = trial % 2, .height = values[44]};
    for (int k = 0; k < 3; k++) {
      camera.eye[k] = values[45 + k] * 3;
      camera.target[k] = values[48 + k];
      camera.up[k] = values[51 + k];
    }
    hb_image image = blank(48, 32);
    hb_error err = {HB_OK, ""};
    assert_int_equal(hb_render_view(&image, -5, 3, 60, 40, &tube, 1, &camera, &values[54], &err), HB_OK);
    assert_int_equal(
        hb_render_three_views(&image, &tube, 1, values + 55, values + 58, values[61], "odd", &err), HB_OK);
    hb_image_free(&image);
  }
}

/* No tubes, tubes without length: the page stays as it is. */
static void test_nothing(void **state) {
  (void)state;
  const double point[] = {0, 0, 0};
  const hb_tube tubes[2] = {{.xyz = point, .nv = 1, .radius = 1}, {.xyz = point, .nv = 0, .radius = 1}};
  hb_image image = blank(64, 64);
  hb_camera camera = front(3);
  draw(&image, tubes, 2, &camera, NULL);
  draw(&image, NULL, 0, &camera, NULL);
  assert_int_equal(count_drawn(&image), 0);
  hb_image_free(&image);
}

/* The camera shows the whole box and does not leave much room around it. */
static void test_camera_fit(void **state) {
  (void)state;
  unsigned seed = 7;
  for (int trial = 0; trial < 200; trial++) {
    double v[16], lo[3], hi[3];
    for (int k = 0; k < 16; k++) {
      seed = seed * 1664525u + 1013904223u;
      v[k] = (seed >> 8 & 0xffff) / 32768.0 - 1;
    }
    for (int k = 0; k < 3; k++) {
      lo[k] = fmin(v[k], v[3 + k]) * 7;
      hi[k] = fmax(v[k], v[3 + k]) * 7;
      if (trial % 5 == k) hi[k] = lo[k]; /* flat boxes too */
    }
    const double dir[3] = {v[6], v[7], v[8] * 0.5}, aspect = 1.5 + 0.7 * v[9];
    hb_camera camera;
    hb_camera_fit(lo, hi, dir, up, trial & 1, aspect, &camera);
    hb_lens lens;
    int w = 1000, h = (int)(1000 / aspect);
    hb_lens_make(&camera, (hb_rect){0, 0, w, h}, &lens);
    double left = 1e9, right = -1e9, top = 1e9, bottom = -1e9;
    for (int corner = 0; corner < 8; corner++) {
      double at[2];
      hb_v3 p = {corner & 1 ? hi[0] : lo[0], corner & 2 ? hi[1] : lo[1], corner & 4 ? hi[2] : lo[2]};
      hb_lens_pixel(&lens, hb_lens_look(&lens, p), at);
      left = fmin(left, at[0]);
      right = fmax(right, at[0]);
      top = fmin(top, at[1]);
      bottom = fmax(bottom, at[1]);
    }
    assert_true(left >= 0 && right <= w && top >= 0 && bottom <= h + 1);
    assert_true((right - left) / w > 0.88 || (bottom - top) / h > 0.88);
  }
}

/* Directions of the three views. */
static void test_views(void **state) {
  (void)state;
  const double r = 0.7071067811865476;
  const double diagonal[] = {0, 0, 0, 1, 1, 0.1, 2, 2, 0}, along_y[] = {0, -1, 0, 0.001, 0, 0.5, 0, 1, 0};
  const double mast[] = {1, 1, 0, 1, 1, 1, 1, 1, 2}, helical[] = {0, 0, 0, 3, 1, 0};
  hb_tube tube = {.xyz = diagonal, .nv = 3, .radius = 0.1};
  hb_views views;
  hb_views_start(&views);
  hb_views_add(&views, &tube, 1);
  assert_true(hb_views_aim(&views));
  hb_views_measure(&views, &tube, 1);
  assert_near(views.along[0], r, 1e-15);
  assert_near(views.along[1], r, 1e-15);
  assert_near(views.across[0], r, 1e-15);
  assert_near(views.across[1], -r, 1e-15);
  assert_false(views.upright);
  assert_near(views.along_range[0], -0.1, 1e-12);
  assert_near(views.along_range[1], 2 * 1.4142135623730951 + 0.1, 1e-12);
  assert_near(views.across_range[1], 0.1, 1e-12);
  assert_near(views.hi[2], 0.2, 1e-15);
  tube.xyz = along_y;
  hb_views_start(&views);
  hb_views_add(&views, &tube, 1);
  assert_true(hb_views_aim(&views));
  assert_same(views.along[1], 1);
  assert_same(views.across[0], 1);
  tube.xyz = mast;
  hb_views_start(&views);
  hb_views_add(&views, &tube, 1);
  assert_false(hb_views_aim(&views));
  assert_true(views.upright);
  tube.xyz = helical;
  tube.nv = 2;
  hb_views_start(&views);
  hb_views_add(&views, &tube, 1);
  assert_true(hb_views_aim(&views));
  assert_near(views.along[0], 3 / sqrt(10), 1e-12);
  assert_near(views.along[1], 1 / sqrt(10), 1e-12);
}

/* Small tools. */
static void test_tools(void **state) {
  (void)state;
  for (double a = 0; a < 1.5; a += 0.01) assert_near_rel(hb_lens_tan(a), tan(a), 4e-15);
  assert_near_rel(hb_tick_step(10, 5), 2, 1e-12);
  assert_near_rel(hb_tick_step(0.07, 4), 0.02, 1e-12);
  assert_near_rel(hb_tick_step(1, 3), 0.5, 1e-12);
  assert_near_rel(hb_tick_step(1e-5, 10), 1e-6, 1e-9);
  assert_true(hb_tick_step(0, 5) > 0 && hb_tick_step(not_a_number, 5) > 0);
  assert_int_equal(hb_text_width("abc", 2), 34);
  assert_int_equal(hb_text_width("", 2), 0);
  assert_int_equal(hb_text_width("\xc3\xa9", 1), 5); /* one letter in two bytes */
}

/* Text draws inside its cells and is cut at the picture's edge. */
static void test_text(void **state) {
  (void)state;
  const unsigned char ink[3] = {0, 0, 0};
  for (int scale = 1; scale <= 3; scale++) {
    hb_image image = blank(100, 60);
    hb_image_text(&image, 20, 10, scale, ink, "Hg");
    int inside = 0;
    for (int y = 0; y < 60; y++)
      for (int x = 0; x < 100; x++) {
        if (!drawn(&image, x, y)) continue;
        inside++;
        assert_true(x >= 20 && x < 20 + 12 * scale && y >= 10 && y < 10 + 9 * scale);
      }
    assert_true(inside >= 30 * scale * scale * 7 / 10);
    hb_image_free(&image);
  }
  hb_image image = blank(30, 10);
  hb_image_text(&image, -8, -3, 3, ink, "cut at every edge \xff\xc3");
  hb_image_text(&image, 25, 5, 2, ink, "W\nW");
  assert_true(count_drawn(&image) > 20);
  hb_image_free(&image);
}

/* Axes and bar: the letters stand where their axes lead, the bar has a round length; without a parallel view
 * there is no bar. */
static void test_tripod(void **state) {
  (void)state;
  hb_camera camera = front(4); /* 50 pixels per unit; x to the right, z up, y away from the eye */
  for (int parallel = 0; parallel < 2; parallel++) {
    hb_image image = blank(400, 200);
    camera.orthographic = parallel;
    if (!parallel) camera.height = 0.4;
    hb_render_tripod(&image, &camera, 1, 36, 54);
    assert_true(drawn(&image, 36 + 15, 146)); /* the x axis */
    assert_true(drawn(&image, 36, 146 - 15)); /* the z axis */
    assert_false(drawn(&image, 36 - 15, 146));
    int bar = 0;
    for (int x = 200; x < 400; x++) bar += drawn(&image, x, 190);
    assert_int_equal(bar, parallel ? 50 : 0); /* 8 units wide: a bar of 1 */
    hb_image_free(&image);
    camera.height = 4;
  }
}

/* In a thicket what is hidden costs nothing and changes nothing: many rods behind a wall draw as the wall. */
static void test_hidden(void **state) {
  (void)state;
  enum { HIDDEN = 200 };
  const double wall[] = {-1, 0, 0, 1, 0, 0}, behind[] = {-0.5, 3, 0, 0.5, 3, 0};
  hb_tube tubes[HIDDEN + 1];
  for (int i = 0; i < HIDDEN; i++)
    tubes[i] = (hb_tube){.xyz = behind, .nv = 2, .radius = 0.05, .color = {0.9, 0.1, 0.1}};
  tubes[HIDDEN] = (hb_tube){.xyz = wall, .nv = 2, .radius = 0.6, .color = {0.1, 0.1, 0.9}};
  hb_camera camera = front(3);
  hb_image image = blank(120, 120);
  draw(&image, tubes, HIDDEN + 1, &camera, NULL);
  for (int y = 45; y < 75; y++)
    for (int x = 30; x < 90; x++) assert_true(pixel(&image, x, y)[2] > pixel(&image, x, y)[0]);
  hb_image_free(&image);
}

/* Sizes and files: sentences, and nothing left behind. */
static void test_files(void **state) {
  (void)state;
  hb_image image;
  hb_error err = {HB_OK, ""};
  assert_int_equal(hb_image_create(0, 10, &image, &err), HB_ERR_INPUT);
  assert_string_equal(err.text, "the picture's size is 0 x 10; each side must be 1 to 16384 pixels");
  assert_int_equal(hb_image_create(10, 16385, &image, &err), HB_ERR_INPUT);
  assert_int_equal(hb_image_create(10, 10, &image, NULL), HB_OK);
  hb_image_free(&image);
  image = blank(33, 17);
  assert_int_equal(hb_image_write_png(&image, "no/such/directory/a.png", &err), HB_ERR_IO);
  assert_string_equal(err.text,
                      "no/such/directory/a.png: the picture cannot be written: No such file or directory");
  assert_int_equal(hb_render_view(&image, 0, 0, 0, 5, NULL, 0, &(hb_camera){0}, NULL, &err), HB_ERR_INPUT);
  char path[512], part[520];
  const char *scratch = getenv("HEBRA_SCRATCH");
  snprintf(path, sizeof path, "%s/picture.png", scratch ? scratch : ".");
  snprintf(part, sizeof part, "%s.part", path);
  assert_int_equal(hb_image_write_png(&image, path, &err), HB_OK);
  assert_null(fopen(part, "rb"));
  FILE *file = fopen(path, "rb");
  assert_non_null(file);
  unsigned char head[26];
  assert_int_equal(fread(head, 1, sizeof head, file), sizeof head);
  fclose(file);
  remove(path);
  assert_memory_equal(head, "\x89PNG\r\n\x1a\n", 8);
  assert_int_equal(head[19], 33); /* width, height, 8 bits, colour */
  assert_int_equal(head[23], 17);
  assert_int_equal(head[24], 8);
  assert_int_equal(head[25], 2);
  hb_image_free(&image);
}

/* Pictures that must not change unseen. After a change that is meant, look at the pictures (set
 * HEBRA_KEEP_PICTURES to a directory) and take over the hashes that the test prints. */
static void check_golden(const char *name, const hb_image *image, uint64_t expected) {
  const char *keep = getenv("HEBRA_KEEP_PICTURES");
  if (keep) {
    char path[512];
    snprintf(path, sizeof path, "%s/%s.png", keep, name);
    assert_int_equal(hb_image_write_png(image, path, NULL), HB_OK);
  }
  uint64_t actual = hash(image);
  if (actual != expected)
    print_error("%s: the picture's hash is 0x%016llx\n", name, (unsigned long long)actual);
  assert_true(actual == expected);
}

/* Perspective, shadow, crossings. */
static void test_golden_trefoil(void **state) {
  (void)state;
  double xyz[3 * 90];
  trefoil(xyz, 90);
  const double lo[3] = {-3.3, -3.3, -1.3}, hi[3] = {3.3, 3.3, 1.3}, dir[3] = {0.5, -0.9, 0.6}, ground = -1.4;
  const hb_tube tube = {.xyz = xyz, .nv = 90, .radius = 0.3, .color = {0.15, 0.44, 0.53}};
  hb_camera camera;
  hb_camera_fit(lo, hi, dir, up, false, 1.5, &camera);
  hb_image image = blank(480, 320);
  draw(&image, &tube, 1, &camera, &ground);
  check_golden("trefoil", &image, GOLDEN_TREFOIL);
  hb_image_free(&image);
}

/* Parallel view of two rods. */
static void test_golden_helix(void **state) {
  (void)state;
  double xyz[3 * 120], other[] = {0, 0, 0, 4, 0, 0};
  helix(xyz, 120);
  const hb_tube tubes[2] = {{.xyz = xyz, .nv = 120, .radius = 0.05, .color = {0.79, 0.35, 0.27}},
                            {.xyz = other, .nv = 2, .radius = 0, .color = {0.36, 0.33, 0.62}}};
  const double lo[3] = {0, -0.6, -0.6}, hi[3] = {4, 0.6, 0.6}, dir[3] = {0.2, -0.9, 0.3};
  hb_camera camera;
  hb_camera_fit(lo, hi, dir, up, true, 2.4, &camera);
  hb_image image = blank(480, 200);
  draw(&image, tubes, 2, &camera, NULL);
  check_golden("helix", &image, GOLDEN_HELIX);
  hb_image_free(&image);
}

/* The thesis's first example in three views. */
static void test_golden_three_views(void **state) {
  (void)state;
  double xyz[3 * 25], m1[3 * 24];
  twisted(xyz, m1, 25);
  const double lo[3] = {0, 0, -0.02}, hi[3] = {1, 1, 0.08};
  const hb_tube tube = {.xyz = xyz, .m1 = m1, .nv = 25, .radius = 0.02, .color = {0.15, 0.44, 0.53}};
  hb_image image = blank(960, 540);
  hb_error err;
  assert_int_equal(
      hb_render_three_views(&image, &tube, 1, lo, hi, 0.25, "Straight rod, three half turns", &err), HB_OK);
  check_golden("three-views", &image, GOLDEN_THREE_VIEWS);
  hb_image_free(&image);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_silhouette),   cmocka_unit_test(test_no_cracks),
      cmocka_unit_test(test_depth),        cmocka_unit_test(test_stripe),
      cmocka_unit_test(test_stripe_turns), cmocka_unit_test(test_shadow),
      cmocka_unit_test(test_thin),         cmocka_unit_test(test_not_a_number),
      cmocka_unit_test(test_survives),     cmocka_unit_test(test_nothing),
      cmocka_unit_test(test_camera_fit),   cmocka_unit_test(test_views),
      cmocka_unit_test(test_tools),        cmocka_unit_test(test_text),
      cmocka_unit_test(test_tripod),       cmocka_unit_test(test_hidden),
      cmocka_unit_test(test_files),        cmocka_unit_test(test_golden_trefoil),
      cmocka_unit_test(test_golden_helix), cmocka_unit_test(test_golden_three_views)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
