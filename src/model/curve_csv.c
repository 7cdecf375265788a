#include "model/curve_file.h"
#include "model/formula_number.h"

#include <string.h>

/* Fields that are told apart on one line; a vertex has three. */
#define FIELDS 4

typedef struct field {
  const char *at;
  size_t length;
} field;

/* Space or tab. */
static bool is_blank(char c) { return c == ' ' || c == '\t'; }

/* Takes blanks and one pair of double quotes off a field. */
static field trimmed(field f) {
  while (f.length > 0 && is_blank(f.at[0])) {
    f.at++;
    f.length--;
  }
  while (f.length > 0 && is_blank(f.at[f.length - 1])) f.length--;
  if (f.length >= 2 && f.at[0] == '"' && f.at[f.length - 1] == '"') {
    f.at++;
    f.length -= 2;
  }
  return f;
}

/* The present line without its comment and without blanks around it. */
static field content(const hb_lines *lines) {
  const char *mark = lines->line_length ? memchr(lines->line, '#', lines->line_length) : NULL;
  field f = {lines->line, mark ? (size_t)(mark - lines->line) : lines->line_length};
  while (f.length > 0 && is_blank(f.at[f.length - 1])) f.length--;
  while (f.length > 0 && is_blank(f.at[0])) {
    f.at++;
    f.length--;
  }
  return f;
}

/* Splits a line at ; or else at , or else at blanks. Returns the number of fields, which may be more than
 * FIELDS. */
static int split(field line, field out[FIELDS]) {
  bool semicolon = memchr(line.at, ';', line.length) != NULL,
       comma = memchr(line.at, ',', line.length) != NULL;
  int count = 0;
  size_t from = 0;
  for (size_t k = 0; k <= line.length; k++) {
    bool ends = k == line.length;
    if (!ends && (semicolon || comma))
      ends = line.at[k] == (semicolon ? ';' : ',');
    else if (!ends)
      ends = is_blank(line.at[k]);
    if (!ends) continue;
    bool nothing = k == from && !semicolon && !comma; /* several blanks separate once */
    if (!nothing) {
      if (count < FIELDS) out[count] = trimmed((field){line.at + from, k - from});
      count++;
    }
    from = k + 1;
  }
  return count;
}

/* What is wrong with a field that should be a number. */
static hb_status fail_field(const hb_lines *lines, int column, field f, hb_error *err) {
  int shown = f.length > 40 ? 40 : (int)f.length;
  if (f.length == 0) return hb_lines_fail(lines, err, "column %d is empty, a number is needed", column + 1);
  if (memchr(f.at, ',', f.length))
    return hb_lines_fail(lines, err, "column %d is '%.*s'; decimals are written with a point", column + 1,
                         shown, f.at);
  return hb_lines_fail(lines, err, "column %d is '%.*s', allowed are finite decimal numbers", column + 1,
                       shown, f.at);
}

/* One line of three numbers. may_be_header: a line without any number is skipped. */
static hb_status read_row(const hb_lines *lines, field line, bool may_be_header, double p[3], bool *header,
                          hb_error *err) {
  field fields[FIELDS] = {{NULL, 0}};
  int count = split(line, fields), numbers = 0, wrong = -1;
  double unused;
  for (int k = 0; k < count && k < FIELDS; k++) {
    bool number = hb_number_field(fields[k].at, fields[k].length, k < 3 ? &p[k] : &unused);
    numbers += number;
    if (!number && wrong < 0) wrong = k;
  }
  *header = may_be_header && numbers == 0;
  if (*header) return HB_OK;
  if (wrong >= 0 && wrong < 3) return fail_field(lines, wrong, fields[wrong], err);
  if (count != 3)
    return hb_lines_fail(lines, err, "%d %s found, a vertex has three: x, y, z", count,
                         count == 1 ? "column" : "columns");
  return HB_OK;
}

/* Row by row; vertices that repeat the one before are refused here, where the line is known. */
hb_status hb_csv_read(hb_lines *lines, hb_points *points, hb_error *err) {
  bool first = true;
  while (hb_lines_next(lines)) {
    field line = content(lines);
    if (line.length == 0) continue;
    double p[3];
    bool header;
    hb_status status = read_row(lines, line, first, p, &header, err);
    if (status != HB_OK) return status;
    first = false;
    if (header) continue;
    const double *last = points->count ? points->xyz + 3 * (size_t)(points->count - 1) : NULL;
    if (last && memcmp(last, p, sizeof p) == 0)
      return hb_lines_fail(lines, err,
                           "the vertex (%g, %g, %g) repeats the one before, allowed are different points",
                           p[0], p[1], p[2]);
    status = hb_points_add(points, p, err);
    if (status != HB_OK) return status;
  }
  return HB_OK;
}
