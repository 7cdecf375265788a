#include "output/reader.h"

#include "base/memory.h"
#include "output/layout.h"
#include "output/seal.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

struct hb_reader {
  hid_t file;
  uint64_t bytes;
  char *name, *title, *source, *rod_names;
  char version[64], run[32];
  hb_reader_rod *rods;
  uint64_t fields; /* that it holds */
  hb_trajectory_info info;
};

/* Title, scene text, version and layout number. */
static hb_status read_texts(hb_reader *r, hb_error *err) {
  long long layout = 0;
  size_t one = 1, width = 0;
  if (!hb_h5_attribute_read(r->file, "hebra", "layout", &layout))
    return hb_fail(err, HB_ERR_INPUT,
                   "%s: is an HDF5 file but no trajectory of hebra (it has no group /hebra)", r->name);
  if (!hb_h5_attribute_text(r->file, "hebra", "version", r->version, sizeof r->version))
    snprintf(r->version, sizeof r->version, "unknown");
  if (!hb_h5_attribute_text(r->file, "hebra", HB_LAYOUT_RUN, r->run, sizeof r->run)) r->run[0] = 0;
  if (layout != HB_LAYOUT_VERSION)
    return hb_fail(err, HB_ERR_INPUT,
                   "%s: has layout %lld (written by hebra %s), this program reads layout %d", r->name, layout,
                   r->version, HB_LAYOUT_VERSION);
  hb_status status =
      hb_h5_strings_read(r->file, "hebra/title", r->bytes, r->name, &one, &width, &r->title, err);
  one = 1;
  if (status == HB_OK)
    status = hb_h5_strings_read(r->file, "hebra/source", r->bytes, r->name, &one, &width, &r->source, err);
  r->info.title = r->title;
  r->info.source = r->source;
  r->info.version = r->version;
  return status;
}

/* One column of the table of rods as doubles; values has rod_count entries. */
static hb_status read_column(hb_reader *r, const char *path, double *values, hb_error *err) {
  hb_h5_array array;
  hb_status status = hb_h5_array_open(r->file, path, r->bytes, r->name, &array, err);
  if (status != HB_OK) return status;
  bool good = array.columns == 1 && array.rows == (hsize_t)r->info.rod_count;
  good = good && hb_h5_array_read(&array, 0, array.rows, H5T_NATIVE_DOUBLE, values);
  hb_h5_array_close(&array);
  if (good) return HB_OK;
  return hb_fail(err, HB_ERR_INPUT, "%s: the data set /%s does not hold one number for each of the %d rods",
                 r->name, path, r->info.rod_count);
}

/* Whole number in a range. */
static bool whole(double value, double least, double most) {
  return value >= least && value <= most && floor(value) == value;
}

/* Rods must lie one behind the other from vertex 0. */
static hb_status check_rods(hb_reader *r, const double *first, const double *nv, const double *radius,
                            const double *closed, hb_error *err) {
  long long total = 0;
  for (int k = 0; k < r->info.rod_count; k++) {
    if (first[k] != (double)total || !whole(nv[k], 2, INT_MAX) || total + (long long)nv[k] > INT_MAX)
      return hb_fail(err, HB_ERR_INPUT,
                     "%s: rod %d claims %g vertices from %g on, expected at least 2 from %lld on", r->name, k,
                     nv[k], first[k], total);
    if (!(radius[k] >= 0) || isinf(radius[k]))
      return hb_fail(err, HB_ERR_INPUT, "%s: rod %d has radius %g, allowed are finite numbers from 0",
                     r->name, k, radius[k]);
    r->rods[k].first = (int)total;
    r->rods[k].nv = (int)nv[k];
    r->rods[k].radius = radius[k];
    r->rods[k].closed = closed[k] == 1;
    total += (long long)nv[k];
  }
  r->info.nv = (int)total;
  return HB_OK;
}

/* The table of rods. */
static hb_status read_rods(hb_reader *r, hb_error *err) {
  size_t count = 0, width = 0;
  hb_status status =
      hb_h5_strings_read(r->file, "hebra/rods/name", r->bytes, r->name, &count, &width, &r->rod_names, err);
  if (status != HB_OK) return status;
  if (count < 1 || count > INT_MAX / 4)
    return hb_fail(err, HB_ERR_INPUT, "%s: claims %zu rods, expected at least 1", r->name, count);
  double *values = hb_alloc(count, 4 * sizeof *values);
  r->rods = hb_alloc(count, sizeof *r->rods);
  if (values && r->rods) {
    double *first = values, *nv = values + count, *radius = values + 2 * count, *closed = values + 3 * count;
    r->info.rod_count = (int)count;
    r->info.rods = r->rods;
    for (size_t k = 0; k < count; k++) r->rods[k].name = r->rod_names + k * width;
    status = read_column(r, "hebra/rods/first", first, err);
    if (status == HB_OK) status = read_column(r, "hebra/rods/nv", nv, err);
    if (status == HB_OK) status = read_column(r, "hebra/rods/radius", radius, err);
    /* files of before there were closed rods do not say */
    if (status == HB_OK && H5Lexists(r->file, "hebra/rods/closed", H5P_DEFAULT) > 0)
      status = read_column(r, "hebra/rods/closed", closed, err);
    if (status == HB_OK) status = check_rods(r, first, nv, radius, closed, err);
  } else {
    status = hb_fail_memory(err, "table of rods");
  }
  hb_free(values);
  return status;
}

/* Opens the data set of a field; it must have room for all frames. */
static hb_status open_field(hb_reader *r, const hb_frame_field *field, hb_h5_array *array, hb_error *err) {
  char path[128];
  hb_layout_field_path(field, path, sizeof path);
  hb_status status = hb_h5_array_open(r->file, path, r->bytes, r->name, array, err);
  if (status != HB_OK) return status;
  hsize_t rows = (hsize_t)r->info.frames * (hsize_t)r->info.nv;
  if (array->rows >= rows && array->columns == (hsize_t)field->components) return HB_OK;
  status = hb_fail(err, HB_ERR_INPUT, "%s: the data set /%s has %llu rows of %llu, expected %llu of %d",
                   r->name, path, (unsigned long long)array->rows, (unsigned long long)array->columns,
                   (unsigned long long)rows, field->components);
  hb_h5_array_close(array);
  return status;
}

/* Which fields are there. */
static void find_fields(hb_reader *r) {
  char path[128];
  for (int k = 0; k < hb_frame_field_count; k++) {
    hb_layout_field_path(&hb_frame_fields[k], path, sizeof path);
    if (H5Lexists(r->file, path, H5P_DEFAULT) > 0) r->fields |= (uint64_t)1 << k;
  }
}

/* Number of valid frames; the positions must be there for all of them. */
static hb_status read_frames(hb_reader *r, hb_error *err) {
  long long frames = 0;
  hb_h5_array positions;
  if (!hb_h5_attribute_read(r->file, HB_LAYOUT_STEPS, HB_LAYOUT_COUNT, &frames) || frames < 0 ||
      frames > HB_LAYOUT_MAX_FRAMES)
    return hb_fail(err, HB_ERR_INPUT,
                   "%s: the number of frames (attribute NSteps of /VTKHDF/Steps) is missing or wrong",
                   r->name);
  r->info.frames = (long)frames;
  hb_status status = open_field(r, &hb_frame_fields[0], &positions, err);
  if (status == HB_OK) hb_h5_array_close(&positions);
  return status;
}

/* Reads everything but the frames. */
hb_status hb_reader_adopt(hid_t file, const char *name, hb_reader **out, hb_error *err) {
  hsize_t bytes = 0;
  *out = NULL;
  hb_reader *r = hb_alloc(1, sizeof *r);
  if (!r) {
    H5Fclose(file);
    return hb_fail_memory(err, "reader of a trajectory");
  }
  r->file = file;
  r->name = hb_strdup(name);
  hb_status status = r->name ? HB_OK : hb_fail_memory(err, "reader of a trajectory");
  if (status == HB_OK && H5Fget_filesize(file, &bytes) < 0)
    status = hb_fail(err, HB_ERR_IO, "%s: the size of the file cannot be found", name);
  r->bytes = bytes;
  if (status == HB_OK) status = read_texts(r, err);
  if (status == HB_OK) status = read_rods(r, err);
  if (status == HB_OK) status = read_frames(r, err);
  if (status == HB_OK) find_fields(r);
  if (status == HB_OK)
    *out = r;
  else
    hb_reader_close(r);
  return status;
}

/* A clear word about files that are not there or no HDF5 at all, before HDF5 sees them. */
static hb_status check_file(const char *path, hb_error *err) {
  static const unsigned char magic[8] = {0x89, 'H', 'D', 'F', '\r', '\n', 0x1a, '\n'};
  unsigned char head[8] = {0};
  int fd = open(path, O_RDONLY);
  if (fd < 0) return hb_fail(err, HB_ERR_INPUT, "%s: cannot be opened: %s", path, strerror(errno));
  ssize_t got = read(fd, head, sizeof head);
  int reason = errno;
  bool ours = got == (ssize_t)sizeof head && memcmp(head, magic, sizeof head) == 0;
  hb_status status = ours ? hb_seal_check(fd, path, err) : HB_OK;
  close(fd);
  if (got < 0) return hb_fail(err, HB_ERR_IO, "%s: cannot be read: %s", path, strerror(reason));
  if (ours) return status;
  return hb_fail(err, HB_ERR_INPUT, "%s: is no trajectory, expected an HDF5 file written by hebra run", path);
}

/* Opens without locks, so that a running simulation's file can be read. */
hb_status hb_reader_open(const char *path, hb_reader **out, hb_error *err) {
  *out = NULL;
  hb_status status = check_file(path, err);
  if (status != HB_OK) return status;
  char reason[256] = "";
  hb_h5_quiet quiet = hb_h5_quiet_begin();
  hid_t access = hb_h5_access(), file = access < 0 ? -1 : H5Fopen(path, H5F_ACC_RDONLY, access);
  if (file < 0) hb_h5_reason(reason, sizeof reason);
  if (access >= 0) H5Pclose(access);
  if (file < 0)
    status =
        hb_fail(err, HB_ERR_INPUT, "%s: the trajectory is damaged and cannot be opened: %s", path, reason);
  else
    status = hb_reader_adopt(file, path, out, err);
  hb_h5_quiet_end(quiet);
  return status;
}

/* What was read when the file was opened. */
const hb_trajectory_info *hb_reader_info(const hb_reader *reader) { return &reader->info; }

/* Found when it was opened. */
uint64_t hb_reader_fields(const hb_reader *reader) { return reader->fields; }

/* The name that it was opened by. */
const char *hb_reader_name(const hb_reader *reader) { return reader->name; }

/* As it stands in the file. */
const char *hb_reader_run(const hb_reader *reader) { return reader->run; }

/* Rows of edge fields that hold no edge are 0, as in a measured frame. */
static void clear_unused(const hb_reader *r, int components, double *out) {
  for (int k = 0; k < r->info.rod_count; k++) {
    size_t last = (size_t)(r->rods[k].first + r->rods[k].nv - 1);
    memset(out + last * (size_t)components, 0, (size_t)components * sizeof *out);
  }
}

/* What to do about a field that is not there. */
static hb_status tell_absent(const hb_reader *r, const hb_frame_field *field, hb_error *err) {
  char held[512] = "";
  for (int k = 0; k < hb_frame_field_count; k++) {
    size_t used = strlen(held);
    if (r->fields >> k & 1)
      snprintf(held + used, sizeof held - used, "%s%s", used ? ", " : "", hb_frame_fields[k].name);
  }
  return hb_fail(err, HB_ERR_INPUT,
                 "%s: does not hold the field %s, only %s; a run writes what output.fields of its scene asks "
                 "for",
                 r->name, field->name, held);
}

/* One field of one frame. */
static hb_status read_field(hb_reader *r, const hb_frame_field *field, long frame, double *out,
                            hb_error *err) {
  hb_h5_array array;
  hb_status status = open_field(r, field, &array, err);
  if (status != HB_OK) return status;
  hsize_t nv = (hsize_t)r->info.nv;
  if (!hb_h5_array_read(&array, (hsize_t)frame * nv, nv, H5T_NATIVE_DOUBLE, out))
    status = hb_fail(err, HB_ERR_INPUT, "%s: %s of frame %ld cannot be read, the file is damaged", r->name,
                     field->name, frame);
  hb_h5_array_close(&array);
  if (status == HB_OK && field->location == HB_ON_EDGE) clear_unused(r, field->components, out);
  return status;
}

/* Finds the field by name. */
hb_status hb_reader_field(hb_reader *r, const char *name, long frame, double *out, hb_error *err) {
  const hb_frame_field *field = NULL;
  for (int k = 0; k < hb_frame_field_count && !field; k++)
    if (strcmp(hb_frame_fields[k].name, name) == 0) field = &hb_frame_fields[k];
  if (!field)
    return hb_fail(err, HB_ERR_INPUT, "%s: there is no field \"%s\" in a trajectory", r->name, name);
  if (frame < 0 || frame >= r->info.frames)
    return hb_fail(err, HB_ERR_INPUT, "%s: there is no frame %ld, the trajectory holds %ld frames from 0 on",
                   r->name, frame, r->info.frames);
  if (!(r->fields >> (field - hb_frame_fields) & 1)) return tell_absent(r, field, err);
  hb_h5_quiet quiet = hb_h5_quiet_begin();
  hb_status status = read_field(r, field, frame, out, err);
  hb_h5_quiet_end(quiet);
  return status;
}

/* One scalar at all frames. */
static hb_status read_series(hb_reader *r, const hb_series *series, double *out, hb_error *err) {
  char path[128];
  hb_h5_array array;
  hb_layout_series_path(series, path, sizeof path);
  hb_status status = hb_h5_array_open(r->file, path, r->bytes, r->name, &array, err);
  if (status != HB_OK) return status;
  bool good =
      array.columns == 1 && hb_h5_array_read(&array, 0, (hsize_t)r->info.frames, H5T_NATIVE_DOUBLE, out);
  if (!good)
    status =
        hb_fail(err, HB_ERR_INPUT, "%s: the data set /%s does not hold a number for each of the %ld frames",
                r->name, path, r->info.frames);
  hb_h5_array_close(&array);
  return status;
}

/* Finds the series by name. */
hb_status hb_reader_series(hb_reader *r, const char *name, double *out, hb_error *err) {
  const hb_series *series = NULL;
  for (int k = 0; k < hb_series_count && !series; k++)
    if (strcmp(hb_series_table[k].name, name) == 0) series = &hb_series_table[k];
  if (!series)
    return hb_fail(err, HB_ERR_INPUT, "%s: there is no series \"%s\" in a trajectory", r->name, name);
  hb_h5_quiet quiet = hb_h5_quiet_begin();
  hb_status status = read_series(r, series, out, err);
  hb_h5_quiet_end(quiet);
  return status;
}

/* Closes the file and frees everything. */
void hb_reader_close(hb_reader *r) {
  if (!r) return;
  hb_h5_quiet quiet = hb_h5_quiet_begin();
  if (r->file >= 0) H5Fclose(r->file);
  hb_h5_quiet_end(quiet);
  hb_free(r->name);
  hb_free(r->title);
  hb_free(r->source);
  hb_free(r->rod_names);
  hb_free(r->rods);
  hb_free(r);
}
