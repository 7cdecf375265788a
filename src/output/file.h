/* Files that appear whole or not at all: written under a temporary name in the same directory, then renamed.
 */
#ifndef HB_OUTPUT_FILE_H
#define HB_OUTPUT_FILE_H

#include "hebra/base.h"

#include <stdio.h>

/* "path.new-PID", to be freed with hb_free. NULL: out of memory. */
char *hb_file_temporary(const char *path);

typedef struct hb_file {
  FILE *stream;
  char *path, *temporary;
} hb_file;
/* Opens the temporary file for writing. */
hb_status hb_file_begin(const char *path, hb_file *out, hb_error *err);
/* Ends it: durable also forces the bytes to the disk. good false (or a write error) removes the temporary
 * file and leaves what was at path. Frees the struct's memory in every case. */
hb_status hb_file_end(hb_file *file, bool good, bool durable, hb_error *err);

/* All bytes to, or from, a place of an open file. False on failure: errno tells why, and stays as it was
 * where the system gives no reason (the end of the file). */
bool hb_file_put(int fd, const void *data, size_t size, uint64_t at);
bool hb_file_get(int fd, void *data, size_t size, uint64_t at);

/* Makes a directory and those above it where missing. */
hb_status hb_file_directory(const char *path, hb_error *err);
/* "directory/name" with printf, to be freed with hb_free. NULL: out of memory. */
char *hb_file_join(const char *directory, const char *format, ...) HB_PRINTF(2, 3);

#endif
