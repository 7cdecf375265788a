/* Small helpers over libhdf5: silence, reasons, checked reading. Nothing here trusts what a file says about
 * itself. */
#ifndef HB_OUTPUT_H5_H
#define HB_OUTPUT_H5_H

#include "hebra/base.h"

#include <hdf5.h>

/* HDF5 prints its error stack by itself; a library must not. Every public function that calls HDF5 stands
 * between hb_h5_quiet_begin and hb_h5_quiet_end, which puts the host program's setting back. */
typedef struct hb_h5_quiet {
  H5E_auto2_t function;
  void *data;
} hb_h5_quiet;
hb_h5_quiet hb_h5_quiet_begin(void);
void hb_h5_quiet_end(hb_h5_quiet saved);

/* Copies the innermost reason of the last failed HDF5 call into text (at most size bytes with the
 * terminator). Call it before any other HDF5 function, since each one clears the reason. */
void hb_h5_reason(char *text, size_t size);

/* File access properties for trajectories: plain POSIX files, no file locks (a run's file can be read while
 * it is written). Negative on failure; the caller closes it with H5Pclose. */
hid_t hb_h5_access(void);

/* A dataset opened for reading with everything about it that was checked: rank 1 or 2, a number type. */
typedef struct hb_h5_array {
  hid_t id;
  hsize_t rows, columns; /* columns is 1 for rank 1 */
  bool integer;
} hb_h5_array;
/* Opens path in file. bytes: size of the file, against which absurd extents are checked. where: the file's
 * name for the sentence. HB_ERR_INPUT if it is missing, not an array of numbers, or larger than such a file
 * can hold. */
hb_status hb_h5_array_open(hid_t file, const char *path, uint64_t bytes, const char *where, hb_h5_array *out,
                           hb_error *err);
void hb_h5_array_close(hb_h5_array *array);
/* Reads rows first .. first+count-1 (all columns) as type (H5T_NATIVE_DOUBLE or H5T_NATIVE_LLONG). False on
 * failure. */
bool hb_h5_array_read(const hb_h5_array *array, hsize_t first, hsize_t count, hid_t type, void *out);

/* Reads an array of `count` fixed-length strings of one dataset; *out has count * *width bytes, each string
 * terminated, to be freed with hb_free. count 0 in: any number, and the number found comes back. */
hb_status hb_h5_strings_read(hid_t file, const char *path, uint64_t bytes, const char *where, size_t *count,
                             size_t *width, char **out, hb_error *err);

/* Reads an integer attribute of the object at path. False if there is none of that kind. */
bool hb_h5_attribute_read(hid_t file, const char *path, const char *name, long long *out);
/* Reads a fixed-length text attribute into text (cut to size). False if there is none of that kind. */
bool hb_h5_attribute_text(hid_t file, const char *path, const char *name, char *text, size_t size);

#endif
