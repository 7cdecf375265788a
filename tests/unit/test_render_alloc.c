/* Pictures when memory runs out: every allocation fails once; nothing is left behind. */
#include "hebra/render.h"
#include "support/failing_alloc.h"
#include "support/near.h"

#include <stdio.h>
#include <stdlib.h>

/* A bent tube that casts a shadow, and a straight one. */
static const double bent[] = {0, 0, 0, 1, 0.2, 0.5, 2, 0, 0, 2.5, 0.5, -0.5}, straight[] = {0, 1, 0, 2, 1, 0};

/* Everything that allocates, on a small picture. */
static hb_status picture_trial(void *context, hb_error *err) {
  (void)context;
  const hb_tube tubes[2] = {{.xyz = bent, .nv = 4, .radius = 0.1, .color = {0.2, 0.4, 0.6}},
                            {.xyz = straight, .nv = 2, .radius = 0.1, .color = {0.6, 0.4, 0.2}}};
  const double lo[3] = {0, 0, -0.6}, hi[3] = {2.6, 1.1, 0.6};
  hb_image image = {0};
  hb_status status = hb_image_create(400, 240, &image, err);
  if (status == HB_OK) status = hb_render_three_views(&image, tubes, 2, lo, hi, 0, "out of memory", err);
  hb_image_free(&image);
  return status;
}

/* Every allocation of a picture. */
static void test_picture(void **state) {
  (void)state;
  assert_true(failing_alloc_loop(picture_trial, NULL, 1) >= 40);
}

/* So many thin tubes that they are a thicket. */
static hb_status thicket_trial(void *context, hb_error *err) {
  enum { COUNT = 400 };
  (void)context;
  double xyz[6 * COUNT];
  hb_tube tubes[COUNT];
  for (int k = 0; k < COUNT; k++) {
    const double ends[6] = {0, 0.001 * k, 0, 2.6, 1.1 - 0.002 * k, 0.5};
    for (int c = 0; c < 6; c++) xyz[6 * k + c] = ends[c];
    tubes[k] = (hb_tube){.xyz = xyz + 6 * k, .nv = 2, .color = {0.2, 0.4, 0.6}};
  }
  const double lo[3] = {0, 0, -0.6}, hi[3] = {2.6, 1.1, 0.6}, from[3] = {0.3, -1, 0.4}, up[3] = {0, 0, 1};
  hb_camera camera;
  hb_camera_fit(lo, hi, from, up, true, 1.6, &camera);
  hb_image image = {0};
  hb_status status = hb_image_create(160, 100, &image, err);
  if (status == HB_OK) status = hb_render_view(&image, 0, 0, 160, 100, tubes, COUNT, &camera, lo + 2, err);
  hb_image_free(&image);
  return status;
}

/* Every allocation of a picture of them. */
static void test_thicket(void **state) {
  (void)state;
  assert_true(failing_alloc_loop(thicket_trial, NULL, 1) >= 8);
}

/* Where the file goes. */
static void file_name(char *path, size_t size) {
  const char *scratch = getenv("HEBRA_SCRATCH");
  snprintf(path, size, "%s/picture-alloc.png", scratch ? scratch : ".");
}

/* Writing: the name of the temporary file. */
static hb_status file_trial(void *context, hb_error *err) {
  char path[512];
  file_name(path, sizeof path);
  return hb_image_write_png(context, path, err);
}

/* A picture that cannot be named is not written. */
static void test_file(void **state) {
  (void)state;
  hb_image image;
  char path[512];
  file_name(path, sizeof path);
  assert_int_equal(hb_image_create(8, 8, &image, NULL), HB_OK);
  assert_true(failing_alloc_loop(file_trial, &image, 1) >= 1);
  assert_int_equal(remove(path), 0);
  hb_image_free(&image);
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_picture), cmocka_unit_test(test_thicket),
                                     cmocka_unit_test(test_file)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
