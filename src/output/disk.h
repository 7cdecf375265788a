/* A file driver for HDF5 that never tells HDF5 about a disk that takes no more bytes.
 *
 * A file of libhdf5 that could not be written cannot be closed either, and the library then crashes when the
 * program ends. So trajectories are written through this driver: it remembers the first error of the system
 * and lets HDF5 believe that all went well; who writes asks for the error afterwards. */
#ifndef HB_OUTPUT_DISK_H
#define HB_OUTPUT_DISK_H

#include "output/h5.h"

/* Begins with HDF5's own part of an open file. It must not be moved while the file is open. */
typedef struct hb_disk {
  H5FD_t own;
  int fd;           /* -1: not open; closed by the caller after HDF5 has closed the file */
  int error;        /* errno of the first failure, 0: none */
  haddr_t end, eof; /* of what HDF5 has allocated, and of the file */
  hid_t driver;     /* 0: not known to HDF5 yet */
} hb_disk;

/* File access properties with this driver; one HDF5 file at a time may be opened with them. Negative on
 * failure; the caller closes them with H5Pclose. */
hid_t hb_disk_access(hb_disk *disk);
/* After the last file and property list are closed. */
void hb_disk_release(hb_disk *disk);

#endif
