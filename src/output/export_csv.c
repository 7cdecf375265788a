/* Tables for spreadsheets and scripts: scalars.csv with one row per frame, rod-NAME.csv with one row per
 * frame and vertex. Numbers read back to the same bits; the header gives the units. */
#include "output/export.h"

#include "base/memory.h"
#include "output/file.h"
#include "output/json.h"
#include "output/series.h"

#include <ctype.h>
#include <string.h>

static const char *const letters = "xyzw";

/* A number after a comma. */
static void cell(FILE *stream, double value) {
  char text[32];
  hb_number_text(value, text);
  fprintf(stream, ",%s", text);
}

/* scalars.csv from the series, which stand one behind the other in values. */
static hb_status scalars(const hb_export_job *job, double *values, hb_error *err) {
  size_t frames = (size_t)job->info->frames;
  hb_status status = HB_OK;
  for (int k = 0; status == HB_OK && k < hb_series_count; k++)
    status = hb_reader_series(job->reader, hb_series_table[k].name, values + (size_t)k * frames, err);
  if (status != HB_OK) return status;
  char *path = hb_file_join(job->directory, "scalars.csv");
  if (!path) return hb_fail_memory(err, "name of a file");
  hb_file file;
  status = hb_file_begin(path, &file, err);
  hb_free(path);
  if (status != HB_OK) return status;
  fputs("frame", file.stream);
  for (int k = 0; k < hb_series_count; k++)
    fprintf(file.stream, ",%s [%s]", hb_series_table[k].name, hb_series_table[k].unit);
  fputc('\n', file.stream);
  for (long n = job->first; n <= job->last; n += job->stride) {
    fprintf(file.stream, "%ld", n);
    for (int k = 0; k < hb_series_count; k++) cell(file.stream, values[(size_t)k * frames + (size_t)n]);
    fputc('\n', file.stream);
    if (job->stride > job->last - n) break; /* n + stride may not fit into a long */
  }
  return hb_file_end(&file, true, false, err);
}

/* "rod-NAME.csv" with letters that every file system takes; the number keeps names apart that become equal.
 */
static char *rod_path(const hb_export_job *job, int rod) {
  char name[80];
  snprintf(name, sizeof name, "%s", job->info->rods[rod].name);
  for (char *at = name; *at; at++)
    if (!isalnum((unsigned char)*at) && !strchr("-_.", *at)) *at = '_';
  return hb_file_join(job->directory, "rod-%d-%s.csv", rod, name);
}

/* Names and units of the columns. */
static void rod_header(const hb_export_job *job, FILE *stream) {
  fputs("frame,time [time],vertex", stream);
  for (int k = 0; k < hb_frame_field_count; k++) {
    const hb_frame_field *field = &hb_frame_fields[k];
    for (int j = 0; job->held >> k & 1 && j < field->components; j++) {
      if (field->components == 1)
        fprintf(stream, ",%s [%s]", field->name, field->unit);
      else
        fprintf(stream, ",%s_%c [%s]", field->name, letters[j], field->unit);
    }
  }
  fputc('\n', stream);
}

/* Rows of one frame. The row of the last vertex has empty cells for edge fields. */
static void rod_rows(const hb_export_job *job, const hb_reader_rod *rod, long frame, FILE *stream) {
  for (int i = 0; i < rod->nv; i++) {
    fprintf(stream, "%ld", frame);
    cell(stream, job->times[frame]);
    fprintf(stream, ",%d", i);
    for (int k = 0; k < hb_frame_field_count; k++) {
      const hb_frame_field *field = &hb_frame_fields[k];
      if (!(job->held >> k & 1)) continue;
      const double *row = job->fields[k] + (size_t)(rod->first + i) * (size_t)field->components;
      bool empty = field->location == HB_ON_EDGE && i == rod->nv - 1;
      for (int j = 0; j < field->components; j++) {
        if (empty)
          fputc(',', stream);
        else
          cell(stream, row[j]);
      }
    }
    fputc('\n', stream);
  }
}

/* One rod's table. Frames are read again for each rod, so that only one file is open at a time. */
static hb_status rod_table(const hb_export_job *job, int rod, hb_error *err) {
  char *path = rod_path(job, rod);
  if (!path) return hb_fail_memory(err, "name of a file");
  hb_file file;
  hb_status status = hb_file_begin(path, &file, err);
  hb_free(path);
  if (status != HB_OK) return status;
  rod_header(job, file.stream);
  for (long n = job->first; status == HB_OK; n += job->stride) {
    status = hb_export_load(job, n, err);
    if (status == HB_OK) rod_rows(job, &job->info->rods[rod], n, file.stream);
    if (job->stride > job->last - n) break;
  }
  hb_status ended = hb_file_end(&file, status == HB_OK, false, err);
  return status != HB_OK ? status : ended;
}

/* All tables. */
hb_status hb_export_csv(const hb_export_job *job, hb_error *err) {
  double *values = hb_alloc((size_t)job->info->frames, (size_t)hb_series_count * sizeof *values);
  if (!values) return hb_fail_memory(err, "scalars of the export");
  hb_status status = scalars(job, values, err);
  hb_free(values);
  for (int r = 0; status == HB_OK && r < job->info->rod_count; r++) status = rod_table(job, r, err);
  return status;
}
