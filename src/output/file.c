#include "output/file.h"

#include "base/memory.h"

#include <errno.h>
#include <stdarg.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* Name that no other running program uses. */
char *hb_file_temporary(const char *path) {
  size_t size = strlen(path) + 32;
  char *text = hb_alloc(size, 1);
  if (text) snprintf(text, size, "%s.new-%ld", path, (long)getpid());
  return text;
}

/* Opens the temporary file. */
hb_status hb_file_begin(const char *path, hb_file *out, hb_error *err) {
  out->stream = NULL;
  out->path = hb_strdup(path);
  out->temporary = hb_file_temporary(path);
  hb_status status = HB_OK;
  if (!out->path || !out->temporary) status = hb_fail_memory(err, "name of a file");
  if (status == HB_OK && !(out->stream = fopen(out->temporary, "wb")))
    status = hb_fail(err, HB_ERR_IO, "%s: cannot be written: %s", path, strerror(errno));
  if (status == HB_OK) return HB_OK;
  hb_free(out->path);
  hb_free(out->temporary);
  out->path = out->temporary = NULL;
  return status;
}

/* Renames, or removes. The first reason that the system gave is kept. */
hb_status hb_file_end(hb_file *file, bool good, bool durable, hb_error *err) {
  int reason = 0;
  errno = 0;
  bool written = fflush(file->stream) == 0 && !ferror(file->stream);
  if (written && good && durable) written = fsync(fileno(file->stream)) == 0;
  if (!written) reason = errno;
  if (fclose(file->stream) != 0 && written) {
    written = false;
    reason = errno;
  }
  if (good && written && rename(file->temporary, file->path) != 0) {
    written = false;
    reason = errno;
  }
  if (!good || !written) unlink(file->temporary);
  hb_status status = HB_OK;
  if (good && !written)
    status = hb_fail(err, HB_ERR_IO, "%s: cannot be written: %s", file->path,
                     reason ? strerror(reason) : "the disk did not take all bytes");
  hb_free(file->path);
  hb_free(file->temporary);
  memset(file, 0, sizeof *file);
  return status;
}

/* All bytes to a place. */
bool hb_file_put(int fd, const void *data, size_t size, uint64_t at) {
  const char *bytes = data;
  while (size > 0) {
    ssize_t done = pwrite(fd, bytes, size, (off_t)at);
    if (done < 0 && errno == EINTR) continue;
    if (done <= 0) return false;
    bytes += done;
    size -= (size_t)done;
    at += (uint64_t)done;
  }
  return true;
}

/* All bytes from a place. */
bool hb_file_get(int fd, void *data, size_t size, uint64_t at) {
  char *bytes = data;
  while (size > 0) {
    ssize_t done = pread(fd, bytes, size, (off_t)at);
    if (done < 0 && errno == EINTR) continue;
    if (done <= 0) return false;
    bytes += done;
    size -= (size_t)done;
    at += (uint64_t)done;
  }
  return true;
}

/* True if a directory is there in the end. */
static bool make_directory(const char *path) {
  struct stat info;
  if (mkdir(path, 0777) == 0) return true;
  int reason = errno;
  if (stat(path, &info) == 0 && S_ISDIR(info.st_mode)) return true;
  errno = reason == EEXIST ? ENOTDIR : reason;
  return false;
}

/* From the top down. */
hb_status hb_file_directory(const char *path, hb_error *err) {
  char *part = hb_strdup(path);
  if (!part) return hb_fail_memory(err, "name of a directory");
  bool good = part[0] != 0;
  if (!good) errno = ENOENT;
  for (char *at = part + 1; good && part[0] && *at; at++) {
    if (*at != '/') continue;
    *at = 0;
    good = make_directory(part);
    *at = '/';
  }
  good = good && make_directory(part);
  hb_free(part);
  if (good) return HB_OK;
  return hb_fail(err, HB_ERR_IO, "%s: the directory cannot be made: %s", path, strerror(errno));
}

/* Joins with one slash. */
char *hb_file_join(const char *directory, const char *format, ...) {
  va_list args;
  va_start(args, format);
  int tail = vsnprintf(NULL, 0, format, args);
  va_end(args);
  size_t head = strlen(directory), size = head + (size_t)tail + 2;
  char *text = tail < 0 ? NULL : hb_alloc(size, 1);
  if (!text) return NULL;
  memcpy(text, directory, head);
  if (head > 0 && text[head - 1] != '/') text[head++] = '/';
  va_start(args, format);
  vsnprintf(text + head, size - head, format, args);
  va_end(args);
  return text;
}
