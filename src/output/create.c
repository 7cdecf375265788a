/* Lays out an empty trajectory file. Helpers do nothing once one of them has failed, so that the order of the
 * file reads without error checks in between; the first reason is kept. */
#include "output/layout.h"

#include "base/memory.h"
#include "output/identity.h"
#include "output/seal.h"

#include <errno.h>
#include <inttypes.h>
#include <stdio.h>
#include <string.h>

typedef struct build {
  hid_t file;
  const hb_model *model;
  hsize_t frames, nv, rods;
  bool failed, out_of_memory;
  hb_seal_gaps gaps; /* places of the data of all tables */
  char reason[256];
} build;

/* Keeps the reason of the first failure. */
static void check(build *b, bool good) {
  if (good || b->failed) return;
  b->failed = true;
  hb_h5_reason(b->reason, sizeof b->reason);
}

/* Leaves the data of a table out of the seal. */
static void leave_out(build *b, hid_t set) {
  hsize_t size = b->failed ? 0 : H5Dget_storage_size(set);
  if (size == 0) return;
  haddr_t at = H5Dget_offset(set);
  check(b, at != HADDR_UNDEF && hb_seal_leave_out(&b->gaps, at, size));
}

/* Creation properties: no time stamps (the same run gives the same bytes), holes instead of fill values for
 * frames. */
static hid_t properties_of(build *b, bool holes, bool chunked) {
  hid_t properties = H5Pcreate(H5P_DATASET_CREATE);
  check(b, properties >= 0 && H5Pset_obj_track_times(properties, false) >= 0);
  if (holes) {
    check(b, H5Pset_alloc_time(properties, H5D_ALLOC_TIME_EARLY) >= 0);
    check(b, H5Pset_fill_time(properties, H5D_FILL_TIME_NEVER) >= 0);
  }
  if (chunked) check(b, H5Pset_chunk(properties, 1, &b->frames) >= 0);
  return properties;
}

/* A group without time stamps. */
static void group(build *b, const char *path) {
  if (b->failed) return;
  hid_t made = H5Gcreate2(b->file, path, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
  check(b, made >= 0);
  if (made >= 0) H5Gclose(made);
}

/* A data set of rows x columns (columns 0: of rank 1). data NULL: holes for the frames to come. */
static void table(build *b, const char *path, hid_t type, hsize_t rows, hsize_t columns, const void *data) {
  if (b->failed) return;
  hsize_t extents[2] = {rows, columns};
  hid_t space = H5Screate_simple(columns ? 2 : 1, extents, NULL);
  hid_t properties = properties_of(b, data == NULL, false);
  hid_t set = H5Dcreate2(b->file, path, type, space, H5P_DEFAULT, properties, H5P_DEFAULT);
  check(b, set >= 0);
  if (data && rows > 0) check(b, H5Dwrite(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, data) >= 0);
  leave_out(b, set);
  if (set >= 0) H5Dclose(set);
  if (properties >= 0) H5Pclose(properties);
  if (space >= 0) H5Sclose(space);
}

/* Type of a text of so many bytes. */
static hid_t text_type(build *b, size_t width, bool ascii) {
  hid_t type = H5Tcopy(H5T_C_S1);
  check(b, type >= 0 && H5Tset_size(type, width) >= 0);
  check(b, H5Tset_strpad(type, H5T_STR_NULLPAD) >= 0);
  if (!ascii) check(b, H5Tset_cset(type, H5T_CSET_UTF8) >= 0);
  return type;
}

/* A text attribute of the object at path. */
static void note(build *b, const char *path, const char *name, const char *text) {
  if (b->failed) return;
  hid_t type = text_type(b, text[0] ? strlen(text) : 1, true), space = H5Screate(H5S_SCALAR);
  hid_t made = H5Acreate_by_name(b->file, path, name, type, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
  check(b, made >= 0 && H5Awrite(made, type, text) >= 0);
  if (made >= 0) H5Aclose(made);
  if (space >= 0) H5Sclose(space);
  if (type >= 0) H5Tclose(type);
}

/* An attribute of one or two integers; count 1 makes a scalar. */
static void number(build *b, const char *path, const char *name, hsize_t count, const int64_t *values) {
  if (b->failed) return;
  hid_t space = count == 1 ? H5Screate(H5S_SCALAR) : H5Screate_simple(1, &count, NULL);
  hid_t made =
      H5Acreate_by_name(b->file, path, name, H5T_NATIVE_INT64, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
  check(b, made >= 0 && H5Awrite(made, H5T_NATIVE_INT64, values) >= 0);
  if (made >= 0) H5Aclose(made);
  if (space >= 0) H5Sclose(space);
}

/* A scalar data set with a text; NULL counts as empty. */
static void text(build *b, const char *path, const char *value) {
  if (b->failed) return;
  if (!value) value = "";
  hid_t type = text_type(b, strlen(value) + 1, false), space = H5Screate(H5S_SCALAR);
  hid_t properties = properties_of(b, false, false);
  hid_t set = H5Dcreate2(b->file, path, type, space, H5P_DEFAULT, properties, H5P_DEFAULT);
  check(b, set >= 0 && H5Dwrite(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, value) >= 0);
  leave_out(b, set);
  if (set >= 0) H5Dclose(set);
  if (properties >= 0) H5Pclose(properties);
  if (space >= 0) H5Sclose(space);
  if (type >= 0) H5Tclose(type);
}

/* A second name for a data set. */
static void same(build *b, const char *of, const char *path) {
  if (!b->failed) check(b, H5Lcreate_hard(b->file, of, b->file, path, H5P_DEFAULT, H5P_DEFAULT) >= 0);
}

/* Memory for count elements; a failure is remembered. */
static void *take(build *b, size_t count, size_t size) {
  if (b->failed) return NULL;
  void *block = hb_alloc(count, size);
  if (!block) b->failed = b->out_of_memory = true;
  return block;
}

/* A table of one integer value, or of 0, step, 2 step ... */
static void integers(build *b, const char *path, hsize_t rows, hsize_t columns, int64_t start, int64_t step) {
  size_t count = (size_t)(rows * (columns ? columns : 1));
  int64_t *values = take(b, count, sizeof *values);
  if (!values) return;
  for (size_t k = 0; k < count; k++) values[k] = start + step * (int64_t)k;
  table(b, path, H5T_NATIVE_INT64, rows, columns, values);
  hb_free(values);
}

/* One kind of cell that no rod uses. Its connectivity has one entry that nothing refers to: h5repack cannot
 * compress tables without entries. */
static void no_cells(build *b, const char *kind) {
  static const char *const parts[] = {"NumberOfCells", "NumberOfConnectivityIds", "Offsets", "Connectivity"};
  char path[96];
  snprintf(path, sizeof path, "VTKHDF/%s", kind);
  group(b, path);
  for (int k = 0; k < 4; k++) {
    snprintf(path, sizeof path, "VTKHDF/%s/%s", kind, parts[k]);
    integers(b, path, 1, 0, 0, 0);
  }
}

/* One polyline per rod, the same at all times. */
static void lines(build *b) {
  int64_t *offsets = take(b, (size_t)b->rods + 1, sizeof *offsets);
  if (!offsets) return;
  for (hsize_t r = 0; r < b->rods; r++) offsets[r + 1] = b->model->rods[r].first + b->model->rods[r].nv;
  group(b, "VTKHDF/Lines");
  integers(b, "VTKHDF/Lines/NumberOfCells", 1, 0, (int64_t)b->rods, 0);
  integers(b, "VTKHDF/Lines/NumberOfConnectivityIds", 1, 0, (int64_t)b->nv, 0);
  table(b, "VTKHDF/Lines/Offsets", H5T_NATIVE_INT64, b->rods + 1, 0, offsets);
  integers(b, "VTKHDF/Lines/Connectivity", b->nv, 0, 0, 1);
  hb_free(offsets);
}

/* Times, and for every frame where its rows begin. All point arrays begin at the same row: one table, many
 * names. */
static void steps(build *b) {
  const int64_t none = 0;
  group(b, HB_LAYOUT_STEPS);
  number(b, HB_LAYOUT_STEPS, HB_LAYOUT_COUNT, 1, &none);
  if (b->failed) return;
  hsize_t one = 1;
  hid_t space = H5Screate_simple(1, &one, &b->frames), properties = properties_of(b, true, true);
  hid_t set =
      H5Dcreate2(b->file, HB_LAYOUT_VALUES, H5T_NATIVE_DOUBLE, space, H5P_DEFAULT, properties, H5P_DEFAULT);
  check(b, set >= 0);
  if (set >= 0) H5Dclose(set);
  if (properties >= 0) H5Pclose(properties);
  if (space >= 0) H5Sclose(space);
  note(b, HB_LAYOUT_VALUES, "unit", "time");
  integers(b, "VTKHDF/Steps/PointOffsets", b->frames, 0, 0, (int64_t)b->nv);
  integers(b, "VTKHDF/Steps/PartOffsets", b->frames, 0, 0, 0);
  integers(b, "VTKHDF/Steps/NumberOfParts", b->frames, 0, 1, 0);
  integers(b, "VTKHDF/Steps/CellOffsets", b->frames, 4, 0, 0);
  same(b, "VTKHDF/Steps/CellOffsets", "VTKHDF/Steps/ConnectivityIdOffsets");
  group(b, "VTKHDF/Steps/PointDataOffsets");
}

/* What VTK needs besides the fields. */
static void vtk(build *b) {
  const int64_t version[2] = {2, 0};
  group(b, "VTKHDF");
  number(b, "VTKHDF", "Version", 2, version);
  note(b, "VTKHDF", "Type", "PolyData");
  integers(b, "VTKHDF/NumberOfPoints", 1, 0, (int64_t)b->nv, 0);
  no_cells(b, "Vertices");
  lines(b);
  no_cells(b, "Polygons");
  no_cells(b, "Strips");
  group(b, "VTKHDF/PointData");
  steps(b);
}

/* Room for the fields of all frames. */
static void fields(build *b) {
  char path[128];
  uint64_t held = hb_fields_of(b->model);
  for (int k = 0; k < hb_frame_field_count; k++) {
    const hb_frame_field *field = &hb_frame_fields[k];
    if (!(held >> k & 1)) continue;
    hb_layout_field_path(field, path, sizeof path);
    table(b, path, hb_layout_type(b->model), b->frames * b->nv,
          field->components > 1 ? (hsize_t)field->components : 0, NULL);
    note(b, path, "unit", field->unit);
    note(b, path, "text", field->text);
    note(b, path, "location", field->location == HB_ON_EDGE ? "edge" : "vertex");
    if (strncmp(path, "VTKHDF/PointData/", 17) != 0) continue;
    snprintf(path, sizeof path, "VTKHDF/Steps/PointDataOffsets/%s", field->name);
    same(b, "VTKHDF/Steps/PointOffsets", path);
  }
}

/* A point array that is the same at all times. */
static void fixed(build *b, const char *name, hid_t type, const void *values, const char *unit,
                  const char *about) {
  char path[128];
  snprintf(path, sizeof path, "VTKHDF/PointData/%s", name);
  table(b, path, type, b->nv, 0, values);
  note(b, path, "unit", unit);
  note(b, path, "text", about);
  note(b, path, "location", "vertex");
  snprintf(path, sizeof path, "VTKHDF/Steps/PointDataOffsets/%s", name);
  same(b, "VTKHDF/Steps/PartOffsets", path);
}

/* Rod number, arc length and radius of every vertex, for colouring and for tubes; and which slots hold an
 * edge. */
static void constants(build *b) {
  size_t nv = (size_t)b->nv, edges = 0;
  int64_t *index = take(b, nv, sizeof *index);
  double *radius = take(b, nv, sizeof *radius);
  if (index && radius) {
    for (hsize_t r = 0; r < b->rods; r++)
      for (int i = 0; i < b->model->rods[r].nv; i++) {
        index[b->model->rods[r].first + i] = (int64_t)r;
        radius[b->model->rods[r].first + i] = b->model->def->rods[r].radius;
      }
    fixed(b, "rod", H5T_NATIVE_INT64, index, "1", "number of the rod, from 0");
    fixed(b, "radius", H5T_NATIVE_DOUBLE, radius, "length", "radius for drawing");
    fixed(b, "arc_length", H5T_NATIVE_DOUBLE, b->model->arc, "length", "arc length in the rest shape");
    for (size_t i = 0; i + 1 < nv; i++)
      if (index[i] == index[i + 1]) index[edges++] = (int64_t)i;
    table(b, "hebra/edges", H5T_NATIVE_INT64, edges, 0, index);
    note(b, "hebra/edges", "text",
         "rows of a frame that hold an edge; the other rows of edge fields repeat the row "
         "before");
  }
  hb_free(index);
  hb_free(radius);
}

/* Names, ranges and radii of the rods. */
static void rods(build *b) {
  size_t width = 1, count = (size_t)b->rods;
  for (size_t r = 0; r < count; r++) {
    size_t length = b->model->rods[r].name ? strlen(b->model->rods[r].name) : 0;
    if (length > width) width = length;
  }
  char *names = take(b, count, width);
  double *values = take(b, count, sizeof *values);
  int64_t *numbers = take(b, count, sizeof *numbers);
  if (names && values && numbers) {
    group(b, "hebra/rods");
    for (size_t r = 0; r < count; r++) {
      const char *name = b->model->rods[r].name ? b->model->rods[r].name : "";
      memcpy(names + r * width, name,
             strlen(name)); /* padded by zeros, without a terminator where it fills */
    }
    hid_t type = text_type(b, width, false);
    table(b, "hebra/rods/name", type, count, 0, names);
    if (type >= 0) H5Tclose(type);
    for (size_t r = 0; r < count; r++) numbers[r] = b->model->rods[r].first;
    table(b, "hebra/rods/first", H5T_NATIVE_INT64, count, 0, numbers);
    for (size_t r = 0; r < count; r++) numbers[r] = b->model->rods[r].nv;
    table(b, "hebra/rods/nv", H5T_NATIVE_INT64, count, 0, numbers);
    for (size_t r = 0; r < count; r++) numbers[r] = b->model->rods[r].closed;
    table(b, "hebra/rods/closed", H5T_NATIVE_INT64, count, 0, numbers);
    for (size_t r = 0; r < count; r++) values[r] = b->model->def->rods[r].radius;
    table(b, "hebra/rods/radius", H5T_NATIVE_DOUBLE, count, 0, values);
    for (size_t r = 0; r < count; r++) values[r] = b->model->rods[r].length;
    table(b, "hebra/rods/length", H5T_NATIVE_DOUBLE, count, 0, values);
  }
  hb_free(names);
  hb_free(values);
  hb_free(numbers);
}

/* Our own group. */
static void own(build *b) {
  const int64_t layout = HB_LAYOUT_VERSION;
  char path[128], run[32];
  snprintf(run, sizeof run, "%016" PRIx64, hb_run_identity(b->model));
  number(b, "hebra", "layout", 1, &layout);
  note(b, "hebra", "version", HB_VERSION);
  note(b, "hebra", HB_LAYOUT_RUN, run);
  text(b, "hebra/title", b->model->def->title);
  text(b, "hebra/source", b->model->def->source);
  rods(b);
  constants(b);
  group(b, "hebra/series");
  for (int k = 0; k < hb_series_count; k++) {
    const hb_series *series = &hb_series_table[k];
    hb_layout_series_path(series, path, sizeof path);
    table(b, path, series->integer ? H5T_NATIVE_INT64 : H5T_NATIVE_DOUBLE, b->frames, 0, NULL);
    note(b, path, "unit", series->unit);
    note(b, path, "text", series->text);
  }
}

/* Adds the number that changed since the snapshot before to the gaps in found. HB_ERR_IO unless exactly one
 * byte, the lowest of an 8-byte number, is different. */
static hb_status find_number(int fd, hb_seal_gaps *tables, const unsigned char *before, size_t size,
                             hb_seal_gaps *found) {
  const uint16_t one = 1;
  size_t now = 0, at = 0, differing = 0;
  unsigned char *after = NULL, low = 0;
  hb_status status = hb_seal_snapshot(fd, tables, &after, &now);
  if (status != HB_OK) return status;
  for (size_t k = 0; now == size && k < size; k++)
    if (after[k] != before[k]) {
      at = k;
      differing++;
    }
  hb_free(after);
  if (now != size || differing != 1) return HB_ERR_IO;
  memcpy(&low, &one, 1); /* 1: the lowest byte comes first */
  uint64_t from = hb_seal_place(tables, at) - (low ? 0 : 7);
  return hb_seal_leave_out(found, from, 8) ? HB_OK : HB_ERR_IO;
}

/* Finds the numbers that will change by changing them: first the number of frames, then the length of the
 * times. */
static hb_status find_numbers(int fd, const hb_layout_count *count, const hb_seal_gaps *gaps, long frames,
                              hb_seal_gaps *found) {
  int64_t none = 0, some = 1;
  hsize_t one = 1, two = 2;
  size_t size = 0;
  hb_seal_gaps tables = *gaps;
  unsigned char *before = NULL;
  *found = *gaps;
  hb_status status = hb_seal_snapshot(fd, &tables, &before, &size);
  if (status != HB_OK) return status;
  bool good =
      H5Awrite(count->attribute, H5T_NATIVE_INT64, &some) >= 0 && H5Fflush(count->file, H5F_SCOPE_LOCAL) >= 0;
  status = good ? find_number(fd, &tables, before, size, found) : HB_ERR_IO;
  good =
      H5Awrite(count->attribute, H5T_NATIVE_INT64, &none) >= 0 && H5Fflush(count->file, H5F_SCOPE_LOCAL) >= 0;
  if (status == HB_OK && good && frames > 1) {
    good = H5Dset_extent(count->values, &two) >= 0 && H5Fflush(count->file, H5F_SCOPE_LOCAL) >= 0;
    status = good ? find_number(fd, &tables, before, size, found) : HB_ERR_IO;
    good = H5Dset_extent(count->values, &one) >= 0 && H5Fflush(count->file, H5F_SCOPE_LOCAL) >= 0;
  }
  hb_free(before);
  return good || status != HB_OK ? status : HB_ERR_IO;
}

/* Seals the file. One that HDF5 lays out in another way than expected stays without seal: only running out of
 * memory or disk is an error. */
static void put_seal(build *b, hid_t file, const char *path, hb_disk *disk) {
  hb_layout_count count;
  hb_layout_map map = {0};
  hb_seal_gaps gaps;
  hid_t set = H5Dopen2(file, HB_SEAL_PATH, H5P_DEFAULT);
  haddr_t at = set < 0 ? HADDR_UNDEF : H5Dget_offset(set);
  if (set >= 0) H5Dclose(set);
  hb_status status = hb_layout_locate(file, path, b->model, &map, NULL);
  bool good = status == HB_OK && at != HADDR_UNDEF;
  good = good && hb_seal_leave_out(&b->gaps, 20, 4); /* superblock: HDF5 notes here that the file is open */
  good = good && hb_seal_leave_out(&b->gaps, map.at[map.count - 1], map.stride[map.count - 1] * b->frames);
  if (good && hb_layout_count_open(file, &count)) {
    status = find_numbers(disk->fd, &count, &b->gaps, map.capacity, &gaps);
    hb_layout_count_close(&count);
    errno = 0;
    if (status == HB_OK) status = hb_seal_write(disk->fd, &gaps, at);
    if (status == HB_ERR_IO && errno && !disk->error) disk->error = errno;
  }
  hb_layout_map_free(&map);
  if (status == HB_ERR_MEMORY) b->failed = b->out_of_memory = true;
}

/* The sentence of a failure: the system's reason is worth more than HDF5's. */
static hb_status failed(const build *b, const hb_disk *disk, const char *path, long capacity, hb_error *err) {
  if (b->out_of_memory) return hb_fail_memory(err, "tables of a new trajectory");
  return hb_fail(err, HB_ERR_IO, "%s: cannot create the trajectory of %ld frames of %d vertices: %s", path,
                 capacity, b->model->nv, disk->error ? strerror(disk->error) : b->reason);
}

/* Everything in order; the file is closed once, so that what a new opening finds is what lies on the disk. */
hb_status hb_layout_create(hb_disk *disk, const char *path, const hb_model *model, long capacity, hid_t *out,
                           hb_error *err) {
  build b = {.file = -1, .model = model, .frames = (hsize_t)capacity};
  b.nv = (hsize_t)model->nv;
  b.rods = (hsize_t)model->rod_count;
  hid_t access = hb_disk_access(disk);
  check(&b, access >= 0);
  if (!b.failed) b.file = H5Fcreate(path, H5F_ACC_TRUNC, H5P_DEFAULT, access);
  check(&b, b.file >= 0);
  group(&b, "hebra");
  table(&b, HB_SEAL_PATH, H5T_STD_U8LE, HB_SEAL_BYTES, 0,
        NULL); /* first, so that it lies near the beginning */
  vtk(&b);
  own(&b);
  fields(&b);
  if (b.file >= 0) check(&b, H5Fclose(b.file) >= 0);
  *out = -1;
  if (!b.failed && !disk->error) *out = H5Fopen(path, H5F_ACC_RDWR, access);
  check(&b, *out >= 0);
  if (!b.failed) put_seal(&b, *out, path, disk);
  if (access >= 0) H5Pclose(access);
  if (!b.failed && !disk->error) return HB_OK;
  if (*out >= 0) H5Fclose(*out);
  *out = -1;
  return failed(&b, disk, path, capacity, err);
}
