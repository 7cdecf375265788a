/* A small writer of JSON: indented, escaped, numbers that read back to the same bits. */
#ifndef HB_OUTPUT_JSON_H
#define HB_OUTPUT_JSON_H

#include "hebra/base.h"

#include <stdio.h>

/* The writer never fails by itself: errors of the stream show in ferror. */
typedef struct hb_json {
  FILE *stream;
  int depth;
  bool first; /* nothing yet in the innermost object or array */
} hb_json;

void hb_json_begin(hb_json *json, FILE *stream); /* opens the outermost object */
void hb_json_end(hb_json *json);                 /* closes it and ends the line */

/* key is NULL inside an array. */
void hb_json_object(hb_json *json, const char *key);
void hb_json_object_end(hb_json *json);
void hb_json_array(hb_json *json, const char *key);
void hb_json_array_end(hb_json *json);
void hb_json_text(hb_json *json, const char *key,
                  const char *text); /* NULL gives null; bad UTF-8 is replaced */
void hb_json_number(hb_json *json, const char *key, double value); /* %.17g, not finite gives null */
void hb_json_integer(hb_json *json, const char *key, long long value);
void hb_json_bool(hb_json *json, const char *key, bool value);
void hb_json_vector(hb_json *json, const char *key, const double *values, int count); /* on one line */

/* Shortest of %.15g, %.16g, %.17g that reads back to the same number, with a point whatever the locale; nan,
 * inf, -inf. text has at least 32 bytes. */
void hb_number_text(double value, char text[32]);

#endif
