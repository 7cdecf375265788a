#include "model/formula_number.h"

#include <locale.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Longest decimal point that a locale may have, in bytes. */
#define POINT_MAX 8

/* ASCII only: isdigit depends on the locale. */
static bool is_digit(char c) { return c >= '0' && c <= '9'; }

/* Number of digits at the start of text. */
static size_t digits(const char *text, size_t length) {
  size_t n = 0;
  while (n < length && is_digit(text[n])) n++;
  return n;
}

/* Length of the number at the start of text, *point the place of its decimal point (or its length). */
static size_t measure(const char *text, size_t length, size_t *point) {
  size_t whole = digits(text, length), end = whole, fraction = 0;
  *point = (size_t)-1;
  if (end < length && text[end] == '.') {
    fraction = digits(text + end + 1, length - end - 1);
    *point = end;
    end += 1 + fraction;
  }
  if (whole + fraction == 0) return 0;
  if (end < length && (text[end] == 'e' || text[end] == 'E')) {
    size_t at = end + 1;
    if (at < length && (text[at] == '+' || text[at] == '-')) at++;
    size_t exponent = digits(text + at, length - at);
    if (exponent > 0) end = at + exponent;
  }
  return end;
}

/* The number by strtod, which rounds correctly, on a checked copy with the locale's decimal point put in. */
size_t hb_number_scan(const char *text, size_t length, double *value) {
  size_t point, used = measure(text, length, &point);
  if (used == 0 || used > HB_NUMBER_MAX) return 0;
  char copy[HB_NUMBER_MAX + POINT_MAX + 1];
  size_t at = 0;
  const char *mark = localeconv()->decimal_point;
  size_t mark_length = strlen(mark);
  if (mark_length == 0 || mark_length > POINT_MAX) return 0;
  for (size_t i = 0; i < used; i++) {
    if (i == point) {
      memcpy(copy + at, mark, mark_length);
      at += mark_length;
    } else {
      copy[at++] = text[i];
    }
  }
  copy[at] = '\0';
  *value = strtod(copy, NULL);
  return used;
}

/* Sign and number. */
bool hb_number_field(const char *text, size_t length, double *value) {
  bool negative = length > 0 && text[0] == '-';
  size_t sign = negative || (length > 0 && text[0] == '+') ? 1 : 0;
  double magnitude;
  size_t used = hb_number_scan(text + sign, length - sign, &magnitude);
  if (used == 0 || used + sign != length || !isfinite(magnitude)) return false;
  *value = negative ? -magnitude : magnitude;
  return true;
}

/* Tries 15 digits, then 16, then 17, which always suffice. */
void hb_number_print(double value, char out[40]) {
  const char *mark = localeconv()->decimal_point;
  for (int precision = 15; precision <= 17; precision++) {
    snprintf(out, 40, "%.*g", precision, value);
    if (strtod(out, NULL) == value) break;
  }
  char *found = mark[0] ? strstr(out, mark) : NULL;
  if (!found) return;
  size_t mark_length = strlen(mark);
  *found = '.';
  memmove(found + 1, found + mark_length, strlen(found + mark_length) + 1);
}
