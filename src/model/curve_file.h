/* Readers of curve files. Private to the model room. */
#ifndef HB_MODEL_CURVE_FILE_H
#define HB_MODEL_CURVE_FILE_H

#include "hebra/curve.h"

/* Largest file in bytes. */
#define HB_CURVE_FILE_MAX (256L * 1024 * 1024)

/* A file in memory, taken line by line. */
typedef struct hb_lines {
  const char *path;
  char *text;
  size_t length, next;
  int number; /* of the present line, from 1 */
  char *line; /* present line without its end, not zero-terminated */
  size_t line_length;
} hb_lines;

/* Moves to the next line (ends: LF, CRLF or CR). False at the end of the file. */
bool hb_lines_next(hb_lines *lines);
/* Next word of the present line from *at on, separated by blanks. False if there is none. */
bool hb_lines_word(const hb_lines *lines, size_t *at, size_t *from, size_t *length);
/* "path:line: " before the sentence. */
hb_status hb_lines_fail(const hb_lines *lines, hb_error *err, const char *format, ...) HB_PRINTF(3, 4);

/* Points that grow one by one. */
typedef struct hb_points {
  double *xyz;
  int count, room;
} hb_points;
hb_status hb_points_add(hb_points *points, const double p[3], hb_error *err);

/* Reads the lines of a CSV file. */
hb_status hb_csv_read(hb_lines *lines, hb_points *points, hb_error *err);
/* Reads the vertices of an OBJ file and puts them in the order of its polyline. */
hb_status hb_obj_read(hb_lines *lines, hb_points *points, hb_error *err);

#endif
