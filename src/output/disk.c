#include "output/disk.h"

#include "output/file.h"

#include <errno.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* Largest place that a file can have. */
#define DISK_MOST ((haddr_t)INT64_MAX)

/* Keeps the first reason. */
static void note(hb_disk *disk, bool good) {
  if (!good && disk->error == 0) disk->error = errno ? errno : EIO;
}

/* The descriptor is open already; HDF5 looks a second time when it opens a file. */
static H5FD_t *disk_open(const char *name, unsigned flags, hid_t access, haddr_t most) {
  (void)name;
  (void)flags;
  (void)most;
  struct stat about;
  hb_disk *const *given = H5Pget_driver_info(access);
  if (!given || fstat((*given)->fd, &about) != 0) return NULL;
  memset(&(*given)->own, 0, sizeof(*given)->own);
  (*given)->end = 0;
  (*given)->eof = (haddr_t)about.st_size;
  return &(*given)->own;
}

/* The descriptor stays open. */
static herr_t disk_close(H5FD_t *file) {
  (void)file;
  return 0;
}

/* The same habits as HDF5's own driver for plain files. */
static herr_t disk_query(const H5FD_t *file, unsigned long *flags) {
  (void)file;
  *flags = H5FD_FEAT_AGGREGATE_METADATA | H5FD_FEAT_ACCUMULATE_METADATA | H5FD_FEAT_DATA_SIEVE |
           H5FD_FEAT_AGGREGATE_SMALLDATA | H5FD_FEAT_DEFAULT_VFD_COMPATIBLE;
  return 0;
}

/* End of what is allocated. */
static haddr_t disk_end(const H5FD_t *file, H5FD_mem_t type) {
  (void)type;
  return ((const hb_disk *)file)->end;
}

/* Allocates. */
static herr_t disk_set_end(H5FD_t *file, H5FD_mem_t type, haddr_t end) {
  (void)type;
  ((hb_disk *)file)->end = end;
  return 0;
}

/* Length of the file. */
static haddr_t disk_eof(const H5FD_t *file, H5FD_mem_t type) {
  (void)type;
  return ((const hb_disk *)file)->eof;
}

/* Bytes; zeros behind the end of the file. */
static herr_t disk_read(H5FD_t *file, H5FD_mem_t type, hid_t transfer, haddr_t at, size_t size, void *bytes) {
  hb_disk *disk = (hb_disk *)file;
  (void)type;
  (void)transfer;
  haddr_t left = at < disk->eof ? disk->eof - at : 0;
  size_t there = left < size ? (size_t)left : size;
  memset((char *)bytes + there, 0, size - there);
  errno = 0;
  if (hb_file_get(disk->fd, bytes, there, at)) return 0;
  note(disk, false);
  return -1;
}

/* Never fails. */
static herr_t disk_write(H5FD_t *file, H5FD_mem_t type, hid_t transfer, haddr_t at, size_t size,
                         const void *bytes) {
  hb_disk *disk = (hb_disk *)file;
  (void)type;
  (void)transfer;
  errno = 0;
  note(disk, hb_file_put(disk->fd, bytes, size, at));
  if (at + size > disk->eof) disk->eof = at + size;
  return 0;
}

/* Gives the file the length of what is allocated. Never fails. */
static herr_t disk_truncate(H5FD_t *file, hid_t transfer, hbool_t closing) {
  hb_disk *disk = (hb_disk *)file;
  (void)transfer;
  (void)closing;
  if (disk->end == disk->eof) return 0;
  errno = 0;
  note(disk, ftruncate(disk->fd, (off_t)disk->end) == 0);
  disk->eof = disk->end;
  return 0;
}

/* HDF5 copies the table of functions. The copy must outlive the files that use it: HDF5 1.10 reads it once
 * more after it has let it go. */
hid_t hb_disk_access(hb_disk *disk) {
  const H5FD_class_t driver = {
#if H5_VERSION_GE(1, 13, 0)
    .version = H5FD_CLASS_VERSION,
    .value = 512,
#endif
    .name = "hebra",
    .maxaddr = DISK_MOST,
    .fc_degree = H5F_CLOSE_STRONG,
    .fapl_size = sizeof(hb_disk *),
    .open = disk_open,
    .close = disk_close,
    .query = disk_query,
    .get_eoa = disk_end,
    .set_eoa = disk_set_end,
    .get_eof = disk_eof,
    .read = disk_read,
    .write = disk_write,
    .truncate = disk_truncate,
    .fl_map = H5FD_FLMAP_DICHOTOMY,
  };
  hid_t access = H5Pcreate(H5P_FILE_ACCESS);
  if (disk->driver <= 0) disk->driver = H5FDregister(&driver);
  bool good = access >= 0 && disk->driver > 0 && H5Pset_driver(access, disk->driver, &disk) >= 0;
  good = good && H5Pset_sieve_buf_size(access, 0) >= 0;
  good = good && H5Pset_fclose_degree(access, H5F_CLOSE_STRONG) >= 0;
  if (good) return access;
  if (access >= 0) H5Pclose(access);
  return -1;
}

/* Only if it was known. */
void hb_disk_release(hb_disk *disk) {
  if (disk->driver > 0) H5FDunregister(disk->driver);
  disk->driver = 0;
}
