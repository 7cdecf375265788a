#include "output/layout.h"

#include "base/memory.h"

#include <stdio.h>
#include <string.h>
#include <sys/stat.h>

/* Positions are the points of the geometry; everything else is point data. */
void hb_layout_field_path(const hb_frame_field *field, char *text, size_t size) {
  if (strcmp(field->name, "position") == 0)
    snprintf(text, size, "VTKHDF/Points");
  else
    snprintf(text, size, "VTKHDF/PointData/%s", field->name);
}

/* Floats or doubles. */
hid_t hb_layout_type(const hb_model *model) {
  return model->def->output.single ? H5T_NATIVE_FLOAT : H5T_NATIVE_DOUBLE;
}

/* All series stand in one group. */
void hb_layout_series_path(const hb_series *series, char *text, size_t size) {
  snprintf(text, size, "hebra/series/%s", series->name);
}

/* True if numbers of type lie in the file exactly as in memory, in one piece at *at. */
static bool raw_place(hid_t set, hid_t type, uint64_t *at) {
  hid_t stored = H5Dget_type(set), properties = H5Dget_create_plist(set);
  bool same = stored >= 0 && properties >= 0 && H5Tequal(stored, type) > 0;
  H5D_layout_t kind = properties < 0 ? H5D_LAYOUT_ERROR : H5Pget_layout(properties);
  haddr_t place = HADDR_UNDEF;
  if (same && kind == H5D_CONTIGUOUS) place = H5Dget_offset(set);
  if (same && kind == H5D_CHUNKED) {
    hsize_t chunks = 0, start[2] = {1, 1}, size = 0;
    unsigned filters = 0;
    hid_t space = H5Dget_space(set);
    same = H5Dget_num_chunks(set, space, &chunks) >= 0 && chunks == 1 && H5Pget_nfilters(properties) == 0;
    same = same && H5Dget_chunk_info(set, space, 0, start, &filters, &place, &size) >= 0 && start[0] == 0;
    if (space >= 0) H5Sclose(space);
  }
  if (stored >= 0) H5Tclose(stored);
  if (properties >= 0) H5Pclose(properties);
  *at = place;
  return same && place != HADDR_UNDEF;
}

/* Rows that a data set has or, if it grows, can have at most. */
static hsize_t most_rows(hid_t set, hsize_t *columns) {
  hsize_t now[2] = {0, 1}, most[2] = {0, 1};
  hid_t space = H5Dget_space(set);
  if (space < 0) return 0;
  int rank = H5Sget_simple_extent_ndims(space);
  bool good = rank >= 1 && rank <= 2 && H5Sget_simple_extent_dims(space, now, most) == rank;
  H5Sclose(space);
  *columns = now[1];
  return good ? most[0] : 0;
}

/* One entry of the map. per_frame: rows of one frame. */
static bool locate_one(hid_t file, const char *path, hid_t type, hsize_t per_frame, hsize_t columns,
                       uint64_t bytes, hb_layout_map *map) {
  hid_t set = H5Dopen2(file, path, H5P_DEFAULT);
  if (set < 0) return false;
  uint64_t at = 0;
  hsize_t found = 0, rows = most_rows(set, &found);
  bool good = raw_place(set, type, &at) && found == columns && rows % per_frame == 0;
  hsize_t frames = rows / per_frame;
  if (map->count == 0) map->capacity = frames <= (hsize_t)HB_LAYOUT_MAX_FRAMES ? (long)frames : 0;
  uint64_t stride = per_frame * columns * H5Tget_size(type);
  good = good && map->capacity > 0 && frames == (hsize_t)map->capacity && at <= bytes &&
         frames * stride <= bytes - at;
  map->at[map->count] = at;
  map->stride[map->count++] = stride;
  H5Dclose(set);
  return good;
}

/* All entries of the map. */
static bool locate_all(hid_t file, const hb_model *model, uint64_t bytes, hb_layout_map *map) {
  char path[128];
  uint64_t held = hb_fields_of(model);
  for (int k = 0; k < hb_frame_field_count; k++) {
    hb_layout_field_path(&hb_frame_fields[k], path, sizeof path);
    if (held >> k & 1 && !locate_one(file, path, hb_layout_type(model), (hsize_t)model->nv,
                                     (hsize_t)hb_frame_fields[k].components, bytes, map))
      return false;
  }
  for (int k = 0; k < hb_series_count; k++) {
    hb_layout_series_path(&hb_series_table[k], path, sizeof path);
    hid_t type = hb_series_table[k].integer ? H5T_NATIVE_INT64 : H5T_NATIVE_DOUBLE;
    if (!locate_one(file, path, type, 1, 1, bytes, map)) return false;
  }
  return locate_one(file, HB_LAYOUT_VALUES, H5T_NATIVE_DOUBLE, 1, 1, bytes, map);
}

/* Places of the raw numbers. */
hb_status hb_layout_locate(hid_t file, const char *path, const hb_model *model, hb_layout_map *out,
                           hb_error *err) {
  size_t entries = (size_t)hb_frame_field_count + (size_t)hb_series_count + 1;
  hsize_t bytes = 0;
  memset(out, 0, sizeof *out);
  out->at = hb_alloc(entries, sizeof *out->at);
  out->stride = hb_alloc(entries, sizeof *out->stride);
  if (!out->at || !out->stride) {
    hb_layout_map_free(out);
    return hb_fail_memory(err, "map of a trajectory");
  }
  if (H5Fget_filesize(file, &bytes) < 0 || !locate_all(file, model, bytes, out)) {
    hb_layout_map_free(out);
    return hb_fail(
        err, HB_ERR_INPUT,
        "%s: frames cannot be added, its data sets are not laid out as hebra %s writes them (written by "
        "another version, or repacked); write to another file",
        path, HB_VERSION);
  }
  return HB_OK;
}

/* Frees the tables, not the struct. */
void hb_layout_map_free(hb_layout_map *map) {
  hb_free(map->at);
  hb_free(map->stride);
  memset(map, 0, sizeof *map);
}

/* Writes NSteps and flushes it. */
static bool set_count(hid_t file, hid_t steps, long frames) {
  int64_t count = frames;
  return H5Awrite(steps, H5T_NATIVE_INT64, &count) >= 0 && H5Fflush(file, H5F_SCOPE_LOCAL) >= 0;
}

/* The order matters: a reader that comes in between sees one time too few in Steps/Values, which VTK
 * tolerates, never one too many. So the count goes up before the length and down after it. */
bool hb_layout_set_frames(const hb_layout_count *count, long before, long frames) {
  hsize_t length = frames > 0 ? (hsize_t)frames : 1;
  bool good = true;
  if (frames >= before) good = set_count(count->file, count->attribute, frames);
  good = good && H5Dset_extent(count->values, &length) >= 0 && H5Fflush(count->file, H5F_SCOPE_LOCAL) >= 0;
  if (frames < before) good = good && set_count(count->file, count->attribute, frames);
  return good;
}

/* HDF5 1.10 cannot write an attribute that H5Aopen_by_name opened, so the group stays open beside it. */
bool hb_layout_count_open(hid_t file, hb_layout_count *out) {
  out->file = file;
  out->group = H5Gopen2(file, HB_LAYOUT_STEPS, H5P_DEFAULT);
  out->attribute = out->group < 0 ? -1 : H5Aopen(out->group, HB_LAYOUT_COUNT, H5P_DEFAULT);
  out->values = H5Dopen2(file, HB_LAYOUT_VALUES, H5P_DEFAULT);
  if (out->attribute >= 0 && out->values >= 0) return true;
  hb_layout_count_close(out);
  return false;
}

/* Closes what is open. */
bool hb_layout_count_close(hb_layout_count *count) {
  bool good = true;
  if (count->attribute > 0) good = H5Aclose(count->attribute) >= 0 && good;
  if (count->group > 0) good = H5Gclose(count->group) >= 0 && good;
  if (count->values > 0) good = H5Dclose(count->values) >= 0 && good;
  count->attribute = count->group = count->values = -1;
  return good;
}
