/* Adds frames to a trajectory: raw numbers at places known since the file was made, then the count. */
#include "output/writer.h"

#include "base/memory.h"
#include "output/file.h"
#include "output/identity.h"
#include "output/layout.h"
#include "output/reader.h"

#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <limits.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

/* Frames are collected up to this size, and so many at most. Larger ones go straight to the file. */
#define COLLECT_BYTES (1u << 20)
#define COLLECT_MOST 64

struct hb_writer {
  char *path;
  const hb_model *model;
  hid_t file;
  hb_layout_count count;
  hb_disk disk; /* the open file, shared by HDF5 and the frames */
  hb_layout_map map;
  long frames;
  double *scratch; /* one field as it stands in the file */
  char
      *collected; /* per entry of the map, one behind the other: room rows of its stride; NULL if room is 1 */
  long waiting, room;
};

/* Closes and frees everything; false if the last bytes could not be written, *reason (NULL allowed) is then
 * the system's number for it, 0 if there is none. */
static bool drop(hb_writer *w, int *reason) {
  bool good = true;
  hb_layout_count_close(&w->count);
  if (w->file >= 0) good = H5Fclose(w->file) >= 0;
  hb_disk_release(&w->disk);
  int error = w->disk.error;
  if (w->disk.fd >= 0 && close(w->disk.fd) != 0 && !error) error = errno;
  if (reason) *reason = error;
  good = good && !error;
  hb_layout_map_free(&w->map);
  hb_free(w->scratch);
  hb_free(w->collected);
  hb_free(w->path);
  hb_free(w);
  return good;
}

/* Takes over an open file and finds what frames need. */
static hb_status attach(hb_writer *w, hid_t file, hb_error *err) {
  w->file = file;
  hb_status status = hb_layout_locate(file, w->path, w->model, &w->map, err);
  if (status != HB_OK) return status;
  if (!hb_layout_count_open(file, &w->count))
    return hb_fail(err, HB_ERR_IO, "%s: the trajectory cannot be opened for writing", w->path);
  uint64_t bytes = 0;
  for (int k = 0; k < w->map.count; k++) bytes += w->map.stride[k];
  w->room = bytes > 0 && bytes <= COLLECT_BYTES / 2 ? (long)(COLLECT_BYTES / bytes) : 1;
  if (w->room > COLLECT_MOST) w->room = COLLECT_MOST;
  w->scratch = hb_alloc((size_t)w->model->nv * 4, sizeof *w->scratch);
  if (w->room > 1) w->collected = hb_alloc((size_t)w->room, (size_t)bytes);
  if (!w->scratch || (w->room > 1 && !w->collected)) return hb_fail_memory(err, "buffer of a trajectory");
  return HB_OK;
}

/* An empty writer. */
static hb_writer *blank(const char *path, const hb_model *model) {
  hb_writer *w = hb_alloc(1, sizeof *w);
  if (!w) return NULL;
  w->file = -1;
  w->disk.fd = -1;
  w->model = model;
  w->path = hb_strdup(path);
  if (w->path) return w;
  hb_free(w);
  return NULL;
}

/* Copies `keep` frames; on failure errno tells why. */
static bool copy_frames(hb_writer *w, const hb_writer *from, long keep, char *block, size_t room) {
  for (int k = 0; k < w->map.count; k++) {
    uint64_t left = (uint64_t)keep * w->map.stride[k];
    for (uint64_t done = 0; done < left;) {
      size_t size = left - done < room ? (size_t)(left - done) : room;
      if (!hb_file_get(from->disk.fd, block, size, from->map.at[k] + done) ||
          !hb_file_put(w->disk.fd, block, size, w->map.at[k] + done))
        return false;
      done += size;
    }
  }
  return true;
}

/* A new file with the first `keep` frames of `from` (NULL: none), put in place once it is sound. */
static hb_status make(const char *path, const hb_model *model, long capacity, const hb_writer *from,
                      long keep, hb_writer **out, hb_error *err) {
  enum { BLOCK = 1 << 16 };
  char *temporary = hb_file_temporary(path), *block = hb_alloc(BLOCK, 1);
  hb_writer *w = blank(path, model);
  hid_t file = -1;
  hb_status status = w && temporary && block ? HB_OK : hb_fail_memory(err, "a trajectory");
  if (status == HB_OK && (w->disk.fd = open(temporary, O_RDWR | O_CREAT | O_TRUNC | O_CLOEXEC, 0666)) < 0)
    status = hb_fail(err, HB_ERR_IO, "%s: the trajectory cannot be created: %s", path, strerror(errno));
  bool begun = status == HB_OK;
  if (status == HB_OK) status = hb_layout_create(&w->disk, path, model, capacity, &file, err);
  if (status == HB_OK) status = attach(w, file, err);
  if (status == HB_OK) {
    errno = 0;
    bool good = !from || copy_frames(w, from, keep, block, BLOCK);
    if (keep > 0) good = good && hb_layout_set_frames(&w->count, 0, keep);
    good = good && fsync(w->disk.fd) == 0 && !w->disk.error && rename(temporary, path) == 0;
    int reason = w->disk.error ? w->disk.error : errno;
    if (!good)
      status = hb_fail(err, HB_ERR_IO, "%s: the trajectory cannot be created: %s", path,
                       reason ? strerror(reason) : "the disk did not take all bytes");
  }
  if (status == HB_OK) {
    w->frames = keep;
    *out = w;
  } else {
    if (begun) unlink(temporary);
    if (w) drop(w, NULL);
  }
  hb_free(temporary);
  hb_free(block);
  return status;
}

/* The plan must be a number of frames that the file format takes. */
static hb_status check_plan(const char *path, long frame_count, hb_error *err) {
  if (frame_count >= 1 && frame_count <= HB_LAYOUT_MAX_FRAMES) return HB_OK;
  return hb_fail(err, HB_ERR_INPUT, "%s: a trajectory of %ld frames was asked for, allowed are 1 to %ld",
                 path, frame_count, HB_LAYOUT_MAX_FRAMES);
}

/* Creates. */
hb_status hb_writer_create(const char *path, const hb_model *model, long frame_count, hb_writer **out,
                           hb_error *err) {
  *out = NULL;
  hb_status status = check_plan(path, frame_count, err);
  if (status != HB_OK) return status;
  hb_h5_quiet quiet = hb_h5_quiet_begin();
  errno = 0;
  status = make(path, model, frame_count, NULL, 0, out, err);
  hb_h5_quiet_end(quiet);
  return status;
}

/* The file must be of the run that the model goes on with: its rods, and the run's number. */
static hb_status check_same(const char *path, const hb_model *model, long keep, hb_error *err) {
  hb_reader *reader = NULL;
  hb_status status = hb_reader_open(path, &reader, err);
  if (status != HB_OK) return status;
  const hb_trajectory_info *info = hb_reader_info(reader);
  if (info->rod_count != model->rod_count || info->nv != model->nv)
    status = hb_fail(err, HB_ERR_INPUT, "%s: holds %d rods with %d vertices in all, the scene has %d with %d",
                     path, info->rod_count, info->nv, model->rod_count, model->nv);
  for (int r = 0; status == HB_OK && r < info->rod_count; r++) {
    const char *name = model->rods[r].name ? model->rods[r].name : "";
    if (info->rods[r].nv != model->rods[r].nv || strcmp(info->rods[r].name, name) != 0)
      status = hb_fail(err, HB_ERR_INPUT,
                       "%s: its rod %d is \"%s\" with %d vertices, that of the scene is \"%s\" with %d", path,
                       r, info->rods[r].name, info->rods[r].nv, name, model->rods[r].nv);
  }
  char run[32];
  snprintf(run, sizeof run, "%016" PRIx64, hb_run_identity(model));
  if (status == HB_OK && strcmp(hb_reader_run(reader), run) != 0)
    status = hb_fail(err, HB_ERR_INPUT,
                     "%s: belongs to another run (%s, titled \"%s\") than the one to go on with (%s)", path,
                     hb_reader_run(reader)[0] ? hb_reader_run(reader) : "without number", info->title, run);
  if (status == HB_OK && (keep < 0 || keep > info->frames))
    status = hb_fail(err, HB_ERR_INPUT, "%s: cannot go on after frame %ld, it holds %ld frames", path, keep,
                     info->frames);
  hb_reader_close(reader);
  return status;
}

/* Opens for writing and goes on in place, or in a larger copy if the plan does not fit. */
static hb_status go_on(const char *path, const hb_model *model, long frame_count, long keep, hb_writer **out,
                       hb_error *err) {
  hb_writer *w = blank(path, model);
  if (!w) return hb_fail_memory(err, "a trajectory");
  char reason[256];
  w->disk.fd = open(path, O_RDWR | O_CLOEXEC);
  if (w->disk.fd < 0) {
    hb_fail(err, HB_ERR_IO, "%s: cannot be opened for writing: %s", path, strerror(errno));
    drop(w, NULL);
    return HB_ERR_IO;
  }
  hid_t access = hb_disk_access(&w->disk), file = access < 0 ? -1 : H5Fopen(path, H5F_ACC_RDWR, access);
  if (file < 0) hb_h5_reason(reason, sizeof reason);
  if (access >= 0) H5Pclose(access);
  hb_status status = HB_OK;
  if (file < 0) status = hb_fail(err, HB_ERR_IO, "%s: cannot be opened for writing: %s", path, reason);
  if (status == HB_OK) status = attach(w, file, err);
  if (status == HB_OK && frame_count > w->map.capacity) {
    status = make(path, model, frame_count, w, keep, out, err);
    drop(w, NULL);
    return status;
  }
  /* Shortening Steps/Values loads its chunk into HDF5's cache, which must be gone before raw numbers go
   * there. */
  if (status == HB_OK &&
      (!hb_layout_set_frames(&w->count, LONG_MAX, keep) || !hb_layout_count_close(&w->count) ||
       !hb_layout_count_open(file, &w->count) || w->disk.error))
    status = hb_fail(err, HB_ERR_IO, "%s: the number of frames cannot be set: %s", path,
                     w->disk.error ? strerror(w->disk.error) : "HDF5 refuses");
  if (status == HB_OK) {
    w->frames = keep;
    *out = w;
  } else {
    drop(w, NULL);
  }
  return status;
}

/* Restart. */
hb_status hb_writer_continue(const char *path, const hb_model *model, long frame_count, long keep,
                             hb_writer **out, hb_error *err) {
  *out = NULL;
  hb_status status = check_plan(path, frame_count, err);
  if (status == HB_OK) status = check_same(path, model, keep, err);
  if (status != HB_OK) return status;
  hb_h5_quiet quiet = hb_h5_quiet_begin();
  errno = 0;
  status = go_on(path, model, frame_count, keep, out, err);
  hb_h5_quiet_end(quiet);
  return status;
}

/* Rows of edge fields that hold no edge repeat the row before, so that ParaView's colours end cleanly. */
static void fill_rows(const hb_writer *w, char *values, size_t row) {
  for (int r = 0; r < w->model->rod_count; r++) {
    size_t last = (size_t)(w->model->rods[r].first + w->model->rods[r].nv - 1);
    memcpy(values + last * row, values + (last - 1) * row, row);
  }
}

/* The numbers of a field of a frame. */
static const double *values_of(const hb_frame *frame, int field) {
  const double *values;
  memcpy(&values, (const char *)frame + hb_frame_fields[field].offset, sizeof values);
  return values;
}

/* A field as it stands in the file, into `to`. */
static void field_bytes(const hb_writer *w, const double *values, int field, void *to) {
  size_t components = (size_t)hb_frame_fields[field].components, count = components * (size_t)w->model->nv;
  bool single = w->model->def->output.single;
  float *floats = to;
  if (single)
    for (size_t k = 0; k < count; k++) floats[k] = (float)values[k];
  else
    memcpy(to, values, count * sizeof *values);
  if (hb_frame_fields[field].location == HB_ON_EDGE)
    fill_rows(w, to, components * (single ? sizeof(float) : sizeof(double)));
}

/* A series' value as it stands in the file, 8 bytes. */
static void series_bytes(const hb_frame *frame, const hb_series *series, char bytes[8]) {
  const char *value = (const char *)frame + series->offset;
  if (series->integer) {
    long number = 0;
    memcpy(&number, value, sizeof number);
    int64_t whole = number;
    memcpy(bytes, &whole, sizeof whole);
  } else
    memcpy(bytes, value, sizeof(double));
}

/* `count` rows of an entry of the map from frame `first` on. */
static bool put(const hb_writer *w, int entry, const void *rows, long first, long count) {
  uint64_t stride = w->map.stride[entry];
  return hb_file_put(w->disk.fd, rows, (size_t)(stride * (uint64_t)count),
                     w->map.at[entry] + (uint64_t)first * stride);
}

/* Raw numbers of one frame, straight to the file. */
static bool put_frame(hb_writer *w, const hb_frame *frame) {
  bool good = true, single = w->model->def->output.single;
  int entry = 0;
  char bytes[8];
  uint64_t held = hb_fields_of(w->model);
  for (int k = 0; good && k < hb_frame_field_count; k++) {
    const double *values = values_of(frame, k);
    if (!(held >> k & 1)) continue;
    if (single || hb_frame_fields[k].location == HB_ON_EDGE) {
      field_bytes(w, values, k, w->scratch);
      values = w->scratch;
    }
    good = put(w, entry++, values, w->frames, 1);
  }
  for (int k = 0; good && k < hb_series_count; k++, entry++) {
    series_bytes(frame, &hb_series_table[k], bytes);
    good = put(w, entry, bytes, w->frames, 1);
  }
  return good && put(w, entry, &frame->time, w->frames, 1);
}

/* The same, into the rows that wait. */
static void keep_frame(hb_writer *w, const hb_frame *frame) {
  char *table = w->collected;
  int entry = 0;
  uint64_t held = hb_fields_of(w->model);
  for (int k = 0; k < hb_frame_field_count; k++) {
    if (!(held >> k & 1)) continue;
    size_t stride = (size_t)w->map.stride[entry++];
    field_bytes(w, values_of(frame, k), k, table + (size_t)w->waiting * stride);
    table += (size_t)w->room * stride;
  }
  for (int k = 0; k < hb_series_count; k++, table += (size_t)w->room * 8)
    series_bytes(frame, &hb_series_table[k], table + 8 * w->waiting);
  memcpy(table + 8 * w->waiting, &frame->time, sizeof frame->time);
  w->waiting++;
}

/* Rows first .. first + count - 1 of those that wait, to where the next frames belong. */
static bool put_waiting(const hb_writer *w, long first, long count) {
  const char *table = w->collected;
  bool good = true;
  for (int k = 0; good && k < w->map.count; k++) {
    good = put(w, k, table + (uint64_t)first * w->map.stride[k], w->frames, count);
    table += (uint64_t)w->room * w->map.stride[k];
  }
  return good;
}

/* What the system says of a frame that was not written. */
static hb_status tell_unwritten(const hb_writer *w, hb_error *err) {
  return hb_fail(err, HB_ERR_IO, "%s: frame %ld cannot be written: %s", w->path, w->frames,
                 errno ? strerror(errno) : "the disk did not take all bytes");
}

/* Makes the next `count` frames valid. */
static hb_status count_frames(hb_writer *w, long count, hb_error *err) {
  hb_h5_quiet quiet = hb_h5_quiet_begin();
  char reason[256];
  bool good = hb_layout_set_frames(&w->count, w->frames, w->frames + count);
  if (!good) hb_h5_reason(reason, sizeof reason);
  if (w->disk.error) snprintf(reason, sizeof reason, "%s", strerror(w->disk.error));
  good = good && !w->disk.error;
  hb_h5_quiet_end(quiet);
  if (!good)
    return hb_fail(err, HB_ERR_IO, "%s: frame %ld cannot be counted: %s", w->path, w->frames, reason);
  w->frames += count;
  return HB_OK;
}

/* All in one go; if that fails, one by one, to keep what there is room for. */
hb_status hb_writer_flush(hb_writer *w, hb_error *err) {
  long waiting = w->waiting;
  hb_status status = HB_OK;
  w->waiting = 0;
  if (waiting == 0) return HB_OK;
  errno = 0;
  if (put_waiting(w, 0, waiting)) return count_frames(w, waiting, err);
  for (long n = 0; !status && n < waiting; n++) {
    errno = 0;
    status = put_waiting(w, n, 1) ? count_frames(w, 1, err) : tell_unwritten(w, err);
  }
  return status;
}

/* The plan has an end. */
static hb_status check_room(const hb_writer *w, hb_error *err) {
  if (w->frames < w->map.capacity) return HB_OK;
  return hb_fail(err, HB_ERR_INPUT, "%s: frame %ld does not fit, the trajectory was planned for %ld frames",
                 w->path, w->frames, w->map.capacity);
}

/* Keeps it if there is room for several. */
hb_status hb_writer_collect(hb_writer *w, const hb_frame *frame, hb_error *err) {
  if (w->room == 1) return hb_writer_add(w, frame, err);
  hb_status status = HB_OK;
  if (w->waiting == w->room || w->frames + w->waiting >= w->map.capacity) status = hb_writer_flush(w, err);
  if (!status) status = check_room(w, err);
  if (!status) keep_frame(w, frame);
  return status;
}

/* Adds a frame behind those that wait. */
hb_status hb_writer_add(hb_writer *w, const hb_frame *frame, hb_error *err) {
  hb_status status = hb_writer_flush(w, err);
  if (!status) status = check_room(w, err);
  if (status) return status;
  errno = 0;
  return put_frame(w, frame) ? count_frames(w, 1, err) : tell_unwritten(w, err);
}

/* Valid ones. */
long hb_writer_frames(const hb_writer *w) { return w->frames; }

/* Forces the bytes to the disk, closes, frees. */
hb_status hb_writer_close(hb_writer *w, hb_error *err) {
  if (!w) return HB_OK;
  hb_status status = hb_writer_flush(w, err);
  hb_h5_quiet quiet = hb_h5_quiet_begin();
  char *path = w->path;
  w->path = NULL;
  errno = 0;
  bool good = fsync(w->disk.fd) == 0;
  int reason = good ? 0 : errno, later = 0;
  good = drop(w, &later) && good;
  if (!reason) reason = later;
  hb_h5_quiet_end(quiet);
  if (!good && !status)
    status = hb_fail(err, HB_ERR_IO, "%s: the last bytes could not be written: %s", path,
                     reason ? strerror(reason) : "HDF5 could not close the file");
  hb_free(path);
  return status;
}
