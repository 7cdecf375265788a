#include "model/curve_file.h"

#include "base/memory.h"
#include "model/curve_parts.h"

#include <errno.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

/* Space or tab. */
static bool is_blank(char c) { return c == ' ' || c == '\t'; }

/* One line further. */
bool hb_lines_next(hb_lines *lines) {
  if (lines->next >= lines->length) return false;
  size_t from = lines->next, end = from;
  while (end < lines->length && lines->text[end] != '\n' && lines->text[end] != '\r') end++;
  lines->line = lines->text + from;
  lines->line_length = end - from;
  bool pair = end + 1 < lines->length && lines->text[end] == '\r' && lines->text[end + 1] == '\n';
  lines->next = end + (pair ? 2 : 1);
  lines->number++;
  return true;
}

/* One word further. */
bool hb_lines_word(const hb_lines *lines, size_t *at, size_t *from, size_t *length) {
  while (*at < lines->line_length && is_blank(lines->line[*at])) (*at)++;
  *from = *at;
  while (*at < lines->line_length && !is_blank(lines->line[*at])) (*at)++;
  *length = *at - *from;
  return *length > 0;
}

/* The sentence behind its place. */
hb_status hb_lines_fail(const hb_lines *lines, hb_error *err, const char *format, ...) {
  char text[512];
  va_list args;
  va_start(args, format);
  vsnprintf(text, sizeof text, format, args);
  va_end(args);
  return hb_fail(err, HB_ERR_INPUT, "%s:%d: %s", lines->path, lines->number, text);
}

/* Doubles the room when it is full. */
hb_status hb_points_add(hb_points *points, const double p[3], hb_error *err) {
  if (points->count == HB_CURVE_COUNT_MAX)
    return hb_fail(err, HB_ERR_INPUT, "a curve file may hold at most %d vertices", HB_CURVE_COUNT_MAX);
  if (points->count == points->room) {
    int room = points->room ? 2 * points->room : 64;
    double *grown = hb_realloc(points->xyz, 3 * (size_t)room, sizeof *grown);
    if (!grown) return hb_fail_memory(err, "the vertices of a curve file");
    points->xyz = grown;
    points->room = room;
  }
  memcpy(points->xyz + 3 * (size_t)points->count, p, 3 * sizeof *p);
  points->count++;
  return HB_OK;
}

/* True if path ends in .obj, in any case. */
static bool is_obj(const char *path) {
  size_t n = strlen(path);
  if (n < 4 || path[n - 4] != '.') return false;
  const char *end = path + n - 3;
  return (end[0] == 'o' || end[0] == 'O') && (end[1] == 'b' || end[1] == 'B') &&
         (end[2] == 'j' || end[2] == 'J');
}

/* All bytes of an open file, in blocks, so that pipes work too. */
static hb_status slurp(FILE *file, hb_lines *lines, hb_error *err) {
  size_t room = 0;
  for (;;) {
    if (lines->length == room) {
      room = room ? 2 * room : 65536;
      char *grown = hb_realloc(lines->text, room, 1);
      if (!grown) return hb_fail_memory(err, "a curve file");
      lines->text = grown;
    }
    size_t got = fread(lines->text + lines->length, 1, room - lines->length, file);
    lines->length += got;
    if (got == 0) break;
    if (lines->length > (size_t)HB_CURVE_FILE_MAX)
      return hb_fail(err, HB_ERR_INPUT, "%s: the file is larger than %ld MiB, the most that is read",
                     lines->path, HB_CURVE_FILE_MAX / (1024 * 1024));
  }
  if (ferror(file)) return hb_fail(err, HB_ERR_IO, "%s: cannot be read: %s", lines->path, strerror(errno));
  return HB_OK;
}

/* The file in memory, without a byte order mark. */
static hb_status load(const char *path, hb_lines *lines, hb_error *err) {
  FILE *file = fopen(path, "rb");
  if (!file) return hb_fail(err, HB_ERR_IO, "%s: cannot be opened: %s", path, strerror(errno));
  hb_status status = slurp(file, lines, err);
  fclose(file);
  if (status == HB_OK && lines->length >= 3 && memcmp(lines->text, "\xEF\xBB\xBF", 3) == 0) lines->next = 3;
  return status;
}

/* Reads, converts, checks. */
hb_status hb_curve_read(const char *path, double **xyz, int *count, hb_error *err) {
  *xyz = NULL;
  *count = 0;
  hb_lines lines = {.path = path};
  hb_points points = {NULL, 0, 0};
  hb_status status = load(path, &lines, err);
  if (status == HB_OK)
    status = is_obj(path) ? hb_obj_read(&lines, &points, err) : hb_csv_read(&lines, &points, err);
  if (status == HB_OK && points.count < 2)
    status = hb_fail(err, HB_ERR_INPUT, "%s: the file has %d %s, at least 2 are needed", path, points.count,
                     points.count == 1 ? "vertex" : "vertices");
  hb_free(lines.text);
  if (status != HB_OK) {
    hb_free(points.xyz);
    return status;
  }
  *xyz = points.xyz;
  *count = points.count;
  return HB_OK;
}
