#include "output/h5.h"

#include "base/memory.h"

#include <stdio.h>
#include <string.h>

/* Turns HDF5's own printing off and gives what was set. */
hb_h5_quiet hb_h5_quiet_begin(void) {
  hb_h5_quiet saved = {NULL, NULL};
  H5Eget_auto2(H5E_DEFAULT, &saved.function, &saved.data);
  H5Eset_auto2(H5E_DEFAULT, NULL, NULL);
  return saved;
}

/* Puts the setting back. */
void hb_h5_quiet_end(hb_h5_quiet saved) { H5Eset_auto2(H5E_DEFAULT, saved.function, saved.data); }

typedef struct reason {
  char *text;
  size_t size;
} reason;

/* Takes the first entry of the walk, the place where the failure began, and ends the walk. */
static herr_t take_reason(unsigned n, const H5E_error2_t *entry, void *data) {
  reason *to = data;
  (void)n;
  snprintf(to->text, to->size, "%s", entry->desc ? entry->desc : "no reason given");
  return 1;
}

/* Innermost entry of the error stack. */
void hb_h5_reason(char *text, size_t size) {
  reason to = {text, size};
  snprintf(text, size, "HDF5 gives no reason");
  H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, take_reason, &to);
}

/* POSIX driver without locks and without a sieve buffer, so that nothing written waits in memory. */
hid_t hb_h5_access(void) {
  hid_t access = H5Pcreate(H5P_FILE_ACCESS);
  if (access < 0) return access;
  herr_t status = H5Pset_fapl_sec2(access);
#if H5_VERSION_GE(1, 10, 7)
  if (status >= 0) status = H5Pset_file_locking(access, false, true);
#endif
  if (status >= 0) status = H5Pset_sieve_buf_size(access, 0);
  if (status >= 0) status = H5Pset_fclose_degree(access, H5F_CLOSE_STRONG);
  if (status >= 0) return access;
  H5Pclose(access);
  return -1;
}

/* Compression shrinks by 1032 at most, so a file of so many bytes cannot hold more than that times as much.
 * Guards every allocation against extents that a damaged file invents. */
static bool plausible(hsize_t count, size_t size, uint64_t bytes) {
  const uint64_t shrink = 1032;
  uint64_t room = bytes > UINT64_MAX / shrink ? UINT64_MAX : bytes * shrink;
  return size == 0 || count <= room / size;
}

/* Rank and extents of a dataset of rank 0 .. 2; false for any other. */
static bool extents_of(hid_t dataset, hsize_t extents[2], int *rank) {
  hid_t space = H5Dget_space(dataset);
  if (space < 0) return false;
  bool good = H5Sget_simple_extent_type(space) != H5S_NULL;
  *rank = good ? H5Sget_simple_extent_ndims(space) : -1;
  extents[0] = extents[1] = 1;
  good = good && *rank >= 0 && *rank <= 2;
  good = good && (*rank == 0 || H5Sget_simple_extent_dims(space, extents, NULL) == *rank);
  H5Sclose(space);
  return good;
}

/* True if the dataset holds integers or reals; *integer says which. */
static bool number_type(hid_t dataset, bool *integer, size_t *size) {
  hid_t type = H5Dget_type(dataset);
  if (type < 0) return false;
  H5T_class_t kind = H5Tget_class(type);
  *integer = kind == H5T_INTEGER;
  *size = H5Tget_size(type);
  H5Tclose(type);
  return kind == H5T_INTEGER || kind == H5T_FLOAT;
}

/* Opens and checks. */
hb_status hb_h5_array_open(hid_t file, const char *path, uint64_t bytes, const char *where, hb_h5_array *out,
                           hb_error *err) {
  hsize_t extents[2] = {0, 0};
  int rank = 0;
  size_t size = 0;
  memset(out, 0, sizeof *out);
  out->id = H5Dopen2(file, path, H5P_DEFAULT);
  if (out->id < 0)
    return hb_fail(err, HB_ERR_INPUT,
                   "%s: the data set /%s is missing or damaged; is this a trajectory of hebra?", where, path);
  if (!extents_of(out->id, extents, &rank) || rank < 1 || !number_type(out->id, &out->integer, &size)) {
    hb_h5_array_close(out);
    return hb_fail(err, HB_ERR_INPUT, "%s: the data set /%s is no table of numbers", where, path);
  }
  out->rows = extents[0];
  out->columns = rank == 2 ? extents[1] : 1;
  if (!plausible(out->rows, size, bytes) ||
      (out->columns > 0 && !plausible(out->rows, size * out->columns, bytes)) || out->columns > 64) {
    hsize_t rows = out->rows, columns = out->columns;
    hb_h5_array_close(out);
    return hb_fail(err, HB_ERR_INPUT,
                   "%s: the data set /%s claims %llu x %llu numbers, more than the file can hold", where,
                   path, (unsigned long long)rows, (unsigned long long)columns);
  }
  return HB_OK;
}

/* Closes what hb_h5_array_open opened. */
void hb_h5_array_close(hb_h5_array *array) {
  if (array->id > 0) H5Dclose(array->id);
  array->id = -1;
}

/* A block of rows. */
bool hb_h5_array_read(const hb_h5_array *array, hsize_t first, hsize_t count, hid_t type, void *out) {
  if (first > array->rows || count > array->rows - first) return false;
  if (count == 0) return true;
  hsize_t start[2] = {first, 0}, size[2] = {count, array->columns}, total = count * array->columns;
  hid_t space = H5Dget_space(array->id), memory = H5Screate_simple(1, &total, NULL);
  bool good = space >= 0 && memory >= 0;
  good = good && H5Sselect_hyperslab(space, H5S_SELECT_SET, start, NULL, size, NULL) >= 0;
  good = good && H5Dread(array->id, type, memory, space, H5P_DEFAULT, out) >= 0;
  if (space >= 0) H5Sclose(space);
  if (memory >= 0) H5Sclose(memory);
  return good;
}

/* Width of a fixed-length string type, 0 if it is another kind. */
static size_t string_width(hid_t type) {
  if (type < 0 || H5Tget_class(type) != H5T_STRING || H5Tis_variable_str(type) > 0) return 0;
  return H5Tget_size(type);
}

/* A string type in memory, one wider than that of the file so that every string ends. */
static hid_t memory_string(hid_t type, size_t width) {
  hid_t memory = H5Tcopy(H5T_C_S1);
  if (memory < 0) return memory;
  if (H5Tset_size(memory, width) >= 0 && H5Tset_cset(memory, H5Tget_cset(type)) >= 0) return memory;
  H5Tclose(memory);
  return -1;
}

/* Strings of fixed length. */
hb_status hb_h5_strings_read(hid_t file, const char *path, uint64_t bytes, const char *where, size_t *count,
                             size_t *width, char **out, hb_error *err) {
  *out = NULL;
  hb_status status = HB_OK;
  hsize_t extents[2] = {0, 0};
  int rank = 0;
  hid_t memory = -1, set = H5Dopen2(file, path, H5P_DEFAULT), type = set < 0 ? -1 : H5Dget_type(set);
  size_t stored = string_width(type);
  if (stored == 0 || !extents_of(set, extents, &rank) || rank > 1 || stored > bytes ||
      !plausible(extents[0], stored + 1, bytes) || (*count != 0 && extents[0] != *count))
    status = hb_fail(err, HB_ERR_INPUT,
                     "%s: the text /%s is missing or damaged; is this a trajectory of hebra?", where, path);
  if (status == HB_OK) {
    *count = (size_t)extents[0];
    *width = stored + 1;
    *out = hb_alloc(*count, *width);
    memory = memory_string(type, *width);
    if (!*out)
      status = hb_fail_memory(err, "text of a trajectory");
    else if (memory < 0 || H5Dread(set, memory, H5S_ALL, H5S_ALL, H5P_DEFAULT, *out) < 0)
      status = hb_fail(err, HB_ERR_INPUT, "%s: the text /%s cannot be read", where, path);
  }
  for (size_t k = 0; status == HB_OK && k < *count; k++) (*out)[(k + 1) * *width - 1] = 0;
  if (memory >= 0) H5Tclose(memory);
  if (type >= 0) H5Tclose(type);
  if (set >= 0) H5Dclose(set);
  if (status != HB_OK) {
    hb_free(*out);
    *out = NULL;
  }
  return status;
}

/* True if the attribute holds exactly one value. */
static bool single(hid_t attribute) {
  hid_t space = H5Aget_space(attribute);
  if (space < 0) return false;
  bool one = H5Sget_simple_extent_npoints(space) == 1;
  H5Sclose(space);
  return one;
}

/* One integer. */
bool hb_h5_attribute_read(hid_t file, const char *path, const char *name, long long *out) {
  hid_t attribute = H5Aopen_by_name(file, path, name, H5P_DEFAULT, H5P_DEFAULT);
  if (attribute < 0) return false;
  hid_t type = H5Aget_type(attribute);
  bool good = type >= 0 && H5Tget_class(type) == H5T_INTEGER && single(attribute);
  good = good && H5Aread(attribute, H5T_NATIVE_LLONG, out) >= 0;
  if (type >= 0) H5Tclose(type);
  H5Aclose(attribute);
  return good;
}

/* One text of at most a few hundred bytes. */
bool hb_h5_attribute_text(hid_t file, const char *path, const char *name, char *text, size_t size) {
  char buffer[512] = {0};
  hid_t attribute = H5Aopen_by_name(file, path, name, H5P_DEFAULT, H5P_DEFAULT);
  if (attribute < 0) return false;
  hid_t memory = -1, type = H5Aget_type(attribute);
  size_t width = string_width(type);
  bool good = width > 0 && width < sizeof buffer && single(attribute);
  if (good) memory = memory_string(type, width + 1);
  good = good && memory >= 0 && H5Aread(attribute, memory, buffer) >= 0;
  if (good) snprintf(text, size, "%s", buffer);
  if (memory >= 0) H5Tclose(memory);
  if (type >= 0) H5Tclose(type);
  H5Aclose(attribute);
  return good;
}
