/* Fuzz target: bytes to a curve, as CSV (first byte even) or OBJ (odd). What is read is finite and can be
 * measured; what is not read has a sentence. */
#include "base/memory.h"
#include "hebra/curve.h"
#include "model/curve_file.h"

#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

/* Ends the program where a promise is broken, so that the fuzzer keeps the input. */
static void require(bool promise) {
  if (!promise) abort();
}

/* A division of what was read: equal edges, or a sentence. */
static void resample(const hb_points *points) {
  double xyz[3 * 33];
  hb_error err = {HB_OK, ""};
  hb_status status = hb_curve_resample(points->xyz, points->count, 33, xyz, &err);
  require(status == HB_OK || (status == HB_ERR_INPUT && strlen(err.text) > 10));
  if (status == HB_OK)
    for (int i = 0; i < 99; i++) require(isfinite(xyz[i]));
}

/* One input. */
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  if (size < 1) return 0;
  /* the reader works on its own copy of exactly the file's length */
  char *text = malloc(size > 1 ? size - 1 : 1);
  if (!text) return 0;
  if (size > 1) memcpy(text, data + 1, size - 1);
  hb_lines lines = {.path = "file", .text = text, .length = size - 1};
  hb_points points = {NULL, 0, 0};
  hb_error err = {HB_OK, ""};
  hb_status status = data[0] % 2 ? hb_obj_read(&lines, &points, &err) : hb_csv_read(&lines, &points, &err);
  if (status == HB_OK) {
    for (int i = 0; i < 3 * points.count; i++) require(isfinite(points.xyz[i]));
    if (points.count >= 2 && points.count < 200) resample(&points);
  } else {
    require(status == HB_ERR_INPUT && err.status == status && strncmp(err.text, "file:", 5) == 0);
  }
  hb_free(points.xyz);
  free(text);
  return 0;
}
