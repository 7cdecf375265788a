#include "output/json.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Comma where one is due, new line, indentation. */
static void next(hb_json *json) {
  if (!json->first) fputc(',', json->stream);
  if (json->depth > 0) fputc('\n', json->stream);
  for (int k = 0; k < json->depth; k++) fputs("  ", json->stream);
  json->first = false;
}

/* Bytes of the UTF-8 character at text, 0 if it is none. */
static int utf8_length(const unsigned char *text) {
  int length = text[0] < 0x80 ? 1 : text[0] >= 0xc2 && text[0] < 0xe0 ? 2 : (text[0] & 0xf0) == 0xe0 ? 3 : 4;
  if (text[0] >= 0x80 && (text[0] < 0xc2 || text[0] > 0xf4)) return 0;
  for (int k = 1; k < length; k++)
    if ((text[k] & 0xc0) != 0x80) return 0;
  if (text[0] == 0xe0 && text[1] < 0xa0) return 0; /* overlong */
  if (text[0] == 0xed && text[1] > 0x9f) return 0; /* surrogate */
  if (text[0] == 0xf0 && text[1] < 0x90) return 0;
  if (text[0] == 0xf4 && text[1] > 0x8f) return 0;
  return length;
}

/* A string in quotes. */
static void quote(FILE *stream, const char *text) {
  const unsigned char *at = (const unsigned char *)text;
  fputc('"', stream);
  while (*at) {
    int length = utf8_length(at);
    if (*at == '"' || *at == '\\')
      fprintf(stream, "\\%c", *at);
    else if (*at == '\n')
      fputs("\\n", stream);
    else if (*at == '\t')
      fputs("\\t", stream);
    else if (*at < 0x20 || *at == 0x7f)
      fprintf(stream, "\\u%04x", (unsigned)*at);
    else if (length == 0)
      fputs("\\ufffd", stream);
    else
      fwrite(at, 1, (size_t)length, stream);
    at += length > 0 ? length : 1;
  }
  fputc('"', stream);
}

/* Place and name of a value. */
static void name(hb_json *json, const char *key) {
  next(json);
  if (!key) return;
  quote(json->stream, key);
  fputs(": ", json->stream);
}

/* Opens an object or array. */
static void open_level(hb_json *json, const char *key, char bracket) {
  name(json, key);
  fputc(bracket, json->stream);
  json->depth++;
  json->first = true;
}

/* Closes one. */
static void close_level(hb_json *json, char bracket) {
  json->depth--;
  if (!json->first) {
    fputc('\n', json->stream);
    for (int k = 0; k < json->depth; k++) fputs("  ", json->stream);
  }
  fputc(bracket, json->stream);
  json->first = false;
}

/* Opens the outermost object. */
void hb_json_begin(hb_json *json, FILE *stream) {
  *json = (hb_json){.stream = stream, .first = true};
  open_level(json, NULL, '{');
}

/* Closes it. */
void hb_json_end(hb_json *json) {
  close_level(json, '}');
  fputc('\n', json->stream);
}

/* Opens an object. */
void hb_json_object(hb_json *json, const char *key) { open_level(json, key, '{'); }

/* Closes it. */
void hb_json_object_end(hb_json *json) { close_level(json, '}'); }

/* Opens an array. */
void hb_json_array(hb_json *json, const char *key) { open_level(json, key, '['); }

/* Closes it. */
void hb_json_array_end(hb_json *json) { close_level(json, ']'); }

/* Text or null. */
void hb_json_text(hb_json *json, const char *key, const char *text) {
  name(json, key);
  if (text)
    quote(json->stream, text);
  else
    fputs("null", json->stream);
}

/* A number without regard to the locale's decimal point. */
static void plain(FILE *stream, double value) {
  char text[40];
  if (!isfinite(value)) {
    fputs("null", stream);
    return;
  }
  snprintf(text, sizeof text, "%.17g", value);
  char *comma = strchr(text, ',');
  if (comma) *comma = '.';
  fputs(text, stream);
}

/* A real number. */
void hb_json_number(hb_json *json, const char *key, double value) {
  name(json, key);
  plain(json->stream, value);
}

/* A whole number. */
void hb_json_integer(hb_json *json, const char *key, long long value) {
  name(json, key);
  fprintf(json->stream, "%lld", value);
}

/* true or false. */
void hb_json_bool(hb_json *json, const char *key, bool value) {
  name(json, key);
  fputs(value ? "true" : "false", json->stream);
}

/* Numbers on one line. */
void hb_json_vector(hb_json *json, const char *key, const double *values, int count) {
  name(json, key);
  fputc('[', json->stream);
  for (int k = 0; k < count; k++) {
    if (k > 0) fputs(", ", json->stream);
    plain(json->stream, values[k]);
  }
  fputc(']', json->stream);
}

/* Tries fewer digits first. */
void hb_number_text(double value, char text[32]) {
  if (!isfinite(value)) {
    snprintf(text, 32, "%s", isnan(value) ? "nan" : value > 0 ? "inf" : "-inf");
    return;
  }
  for (int digits = 15; digits <= 17; digits++) {
    snprintf(text, 32, "%.*g", digits, value);
    if (strtod(text, NULL) == value) break;
  }
  char *comma = strchr(text, ',');
  if (comma) *comma = '.';
}
