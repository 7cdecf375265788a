/* Fuzzes the reader of trajectories.
 *
 * libhdf5 1.10 itself can be crashed by files with damaged inner structures, which no program above it can
 * prevent; what is fuzzed here is everything that a sound HDF5 file can say wrongly to the reader. The input
 * is a list of changes to a valid trajectory: objects and attributes are removed, replaced by others of any
 * kind, type and extent, linked elsewhere, or their numbers are overwritten. The changed file is opened and
 * everything in it is asked for.
 *
 * Input: records of 12 bytes: object, action, type, rank, and 8 bytes of value or extents. */
#include "support/handmade.h"

#include "output/layout.h"
#include "output/reader.h"

#include <stdlib.h>
#include <unistd.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

enum { RECORD = 12, FRAMES = 3, IMAGE_ROOM = 1 << 18 };

/* What can be changed besides fields and series. An attribute stands behind '@'. */
static const char *const objects[] = {
    "hebra",         "hebra@layout",        "hebra@version",    "hebra/title",
    "hebra/source",  "hebra/rods",          "hebra/rods/name",  "hebra/rods/first",
    "hebra/rods/nv", "hebra/rods/radius",   "hebra/series",     "VTKHDF",
    "VTKHDF/Steps",  "VTKHDF/Steps@NSteps", "VTKHDF/PointData", "VTKHDF/Steps/Values"};
enum { OBJECTS = sizeof objects / sizeof objects[0] };

/* Bytes of a valid trajectory, made once. */
static const unsigned char *valid_image(size_t *size) {
  static unsigned char image[IMAGE_ROOM];
  static size_t bytes;
  if (bytes == 0) {
    char path[64];
    handmade h;
    hb_writer *writer = NULL;
    hb_frame *frame = NULL;
    snprintf(path, sizeof path, "fuzz-trajectory-%ld.h5", (long)getpid());
    handmade_fill(&h);
    if (hb_writer_create(path, &h.model, FRAMES, &writer, NULL) != HB_OK) abort();
    if (hb_frame_create(&h.model, &frame, NULL) != HB_OK) abort();
    for (long n = 0; n < FRAMES; n++) {
      handmade_frame(frame, n);
      if (hb_writer_add(writer, frame, NULL) != HB_OK) abort();
    }
    hb_frame_free(frame);
    if (hb_writer_close(writer, NULL) != HB_OK) abort();
    FILE *file = fopen(path, "rb");
    if (!file) abort();
    bytes = fread(image, 1, sizeof image, file);
    fclose(file);
    unlink(path);
    if (bytes == 0 || bytes == sizeof image) abort();
  }
  *size = bytes;
  return image;
}

/* A file in memory that starts as image. */
static hid_t open_image(const void *image, size_t size) {
  hid_t access = H5Pcreate(H5P_FILE_ACCESS), file = -1;
  unsigned char copy[IMAGE_ROOM];
  memcpy(copy, image, size);
  H5Pset_fapl_core(access, 1 << 16, 0);
  H5Pset_fclose_degree(access, H5F_CLOSE_STRONG);
  if (H5Pset_file_image(access, copy, size) >= 0) file = H5Fopen("image", H5F_ACC_RDWR, access);
  H5Pclose(access);
  return file;
}

/* Path of the object that a byte names; *attribute is NULL for data sets and groups. */
static void choose(unsigned byte, char path[128], const char **attribute) {
  *attribute = NULL;
  byte %= (unsigned)(OBJECTS + hb_frame_field_count + hb_series_count);
  if (byte < OBJECTS) {
    snprintf(path, 128, "%s", objects[byte]);
    char *at = strchr(path, '@');
    if (at) {
      *at = 0;
      *attribute = at + 1;
    }
  } else if (byte < OBJECTS + (unsigned)hb_frame_field_count) {
    hb_layout_field_path(&hb_frame_fields[byte - OBJECTS], path, 128);
  } else {
    hb_layout_series_path(&hb_series_table[byte - OBJECTS - (unsigned)hb_frame_field_count], path, 128);
  }
}

/* A type for a new object; the caller closes it. */
static hid_t make_type(unsigned byte, const uint8_t *value) {
  hid_t type = -1;
  hsize_t three = 3;
  switch (byte % 9) {
  case 0: return H5Tcopy(H5T_NATIVE_DOUBLE);
  case 1: return H5Tcopy(H5T_NATIVE_INT64);
  case 2: return H5Tcopy(H5T_STD_U8BE);
  case 3: return H5Tcopy(H5T_IEEE_F32BE);
  case 4:
    type = H5Tcopy(H5T_C_S1);
    H5Tset_size(type, 1 + (size_t)value[7] * value[6]);
    return type;
  case 5:
    type = H5Tcopy(H5T_C_S1);
    H5Tset_size(type, H5T_VARIABLE);
    return type;
  case 6:
    type = H5Tcreate(H5T_COMPOUND, 8);
    H5Tinsert(type, "a", 0, H5T_NATIVE_DOUBLE);
    return type;
  case 7: return H5Tarray_create2(H5T_NATIVE_INT, 1, &three);
  default: return H5Tcreate(H5T_OPAQUE, 1 + value[7]);
  }
}

/* Extents of a new object, up to 2^56 rows; *total is their product where it is small, else 0. */
static hid_t make_space(unsigned byte, const uint8_t *value, hsize_t *total, unsigned *rank,
                        hsize_t extents[3]) {
  *total = 1;
  *rank = byte % 6;
  if (*rank == 4) return H5Screate(H5S_NULL);
  if (*rank == 5 || *rank == 0) {
    *rank = 0;
    return H5Screate(H5S_SCALAR);
  }
  extents[0] = (hsize_t)value[0] << (value[1] % 48);
  extents[1] = value[2];
  extents[2] = value[3];
  for (unsigned k = 0; k < *rank; k++) *total = extents[k] < 4096 ? *total * extents[k] : 0;
  if (*total > 4096) *total = 0;
  return H5Screate_simple((int)*rank, extents, NULL);
}

/* Numbers of a new object: the 8 bytes over and over. */
static void fill(unsigned char *buffer, size_t size, const uint8_t *value) {
  for (size_t k = 0; k < size; k++) buffer[k] = value[k % 8];
}

/* A new data set, in chunks where it is larger than memory should bear. */
static void new_set(hid_t file, const char *path, const uint8_t *record) {
  static unsigned char buffer[1 << 18];
  hsize_t total = 0, extents[3] = {0, 0, 0}, chunk[3] = {16, 1, 1};
  unsigned rank = 0;
  hid_t type = make_type(record[2], record + 4),
        space = make_space(record[3], record + 4, &total, &rank, extents);
  hid_t properties = H5Pcreate(H5P_DATASET_CREATE);
  if (total == 0 && rank > 0) {
    H5Pset_chunk(properties, (int)rank, chunk);
    if (record[3] & 0x40) H5Pset_deflate(properties, 1);
  }
  hid_t set = H5Dcreate2(file, path, type, space, H5P_DEFAULT, properties, H5P_DEFAULT);
  size_t bytes = (size_t)total * H5Tget_size(type);
  if (set >= 0 && total > 0 && bytes <= sizeof buffer && H5Tis_variable_str(type) <= 0) {
    fill(buffer, bytes, record + 4);
    H5Dwrite(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, buffer);
  }
  if (set >= 0) H5Dclose(set);
  H5Pclose(properties);
  if (space >= 0) H5Sclose(space);
  if (type >= 0) H5Tclose(type);
}

/* A new attribute. */
static void new_attribute(hid_t file, const char *path, const char *name, const uint8_t *record) {
  static unsigned char buffer[1 << 18];
  hsize_t total = 0, extents[3] = {0, 0, 0};
  unsigned rank = 0;
  hid_t type = make_type(record[2], record + 4),
        space = make_space(record[3], record + 4, &total, &rank, extents);
  hid_t made = total == 0
                   ? -1
                   : H5Acreate_by_name(file, path, name, type, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
  size_t bytes = (size_t)total * H5Tget_size(type);
  if (made >= 0 && bytes <= sizeof buffer && H5Tis_variable_str(type) <= 0) {
    fill(buffer, bytes, record + 4);
    H5Awrite(made, type, buffer);
  }
  if (made >= 0) H5Aclose(made);
  if (space >= 0) H5Sclose(space);
  if (type >= 0) H5Tclose(type);
}

/* Overwrites all numbers of a small data set by value, as an integer or a double. */
static void overwrite(hid_t file, const char *path, const uint8_t *record) {
  int64_t whole = 0;
  double real = 0, values[1024];
  memcpy(&whole, record + 4, sizeof whole);
  memcpy(&real, record + 4, sizeof real);
  if (record[2] & 1) real = (double)(record[2] & 2 ? whole : (int64_t)(int8_t)record[4]);
  hid_t set = H5Dopen2(file, path, H5P_DEFAULT), space = set < 0 ? -1 : H5Dget_space(set);
  hssize_t count = space < 0 ? 0 : H5Sget_simple_extent_npoints(space);
  for (int k = 0; k < 1024; k++) values[k] = real;
  if (count > 0 && count <= 1024) H5Dwrite(set, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values);
  if (space >= 0) H5Sclose(space);
  if (set >= 0) H5Dclose(set);
}

/* One change. */
static void change(hid_t file, const uint8_t *record) {
  char path[128], other[128];
  const char *attribute = NULL, *unused = NULL;
  choose(record[0], path, &attribute);
  choose(record[4], other, &unused);
  if (attribute) {
    H5Adelete_by_name(file, path, attribute, H5P_DEFAULT);
    if (record[1] % 8 != 0) new_attribute(file, path, attribute, record);
    return;
  }
  if (record[1] % 8 == 5) {
    overwrite(file, path, record);
    return;
  }
  H5Ldelete(file, path, H5P_DEFAULT);
  switch (record[1] % 8) {
  case 0: break;
  case 1: H5Lcreate_soft(other, file, path, H5P_DEFAULT, H5P_DEFAULT); break;
  case 2: H5Lcreate_hard(file, other, file, path, H5P_DEFAULT, H5P_DEFAULT); break;
  case 3: {
    hid_t group = H5Gcreate2(file, path, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
    if (group >= 0) H5Gclose(group);
    break;
  }
  default: new_set(file, path, record); break;
  }
}

/* Asks for everything; what comes back must be usable memory. */
static void read_all(hb_reader *reader) {
  const hb_trajectory_info *info = hb_reader_info(reader);
  size_t room = 4 * (size_t)info->nv > (size_t)info->frames ? 4 * (size_t)info->nv : (size_t)info->frames;
  size_t seen = strlen(info->title) + strlen(info->source) + strlen(info->version);
  int last = 0;
  for (int r = 0; r < info->rod_count; r++) {
    seen += strlen(info->rods[r].name);
    if (info->rods[r].first != last || info->rods[r].nv < 2) abort();
    last += info->rods[r].nv;
  }
  if (last != info->nv || info->frames < 0 || seen > (size_t)1 << 40) abort();
  double *values = room > 1 << 16 ? NULL : malloc((room + 1) * sizeof *values);
  hb_error err;
  for (int k = 0; values && k < hb_frame_field_count; k++)
    for (long n = 0; n<info->frames; n += info->frames> 1 ? info->frames - 1 : 1)
      if (hb_reader_field(reader, hb_frame_fields[k].name, n, values, &err) != HB_OK && !err.text[0]) abort();
  for (int k = 0; values && k < hb_series_count; k++)
    if (hb_reader_series(reader, hb_series_table[k].name, values, &err) != HB_OK && !err.text[0]) abort();
  free(values);
}

/* One input. */
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  size_t bytes = 0;
  const unsigned char *image = valid_image(&bytes);
  H5Eset_auto2(H5E_DEFAULT, NULL, NULL);
  hid_t file = open_image(image, bytes);
  if (file < 0) abort();
  for (size_t at = 0; at + RECORD <= size && at < 8 * RECORD; at += RECORD) change(file, data + at);
  hb_reader *reader = NULL;
  hb_error err = {0};
  if (hb_reader_adopt(file, "image", &reader, &err) == HB_OK)
    read_all(reader);
  else if (!err.text[0])
    abort();
  hb_reader_close(reader);
  return 0;
}
