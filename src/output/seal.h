/* The seal of a trajectory: a check sum over everything in the file that is HDF5's own structure.
 *
 * libhdf5 can be crashed by a file whose inner structure is damaged. So that a damaged trajectory gives a
 * sentence, the structure is checked before libhdf5 sees it. This is possible because it does not change
 * after creation, but for the two numbers that say how many frames there are. The seal lies in the data set
 * /hebra/seal near the beginning of the file, where it is found by its first bytes. A file that was changed
 * by other programs (repacked, objects added) has another size or another place of the seal, and is then
 * opened without this check. */
#ifndef HB_OUTPUT_SEAL_H
#define HB_OUTPUT_SEAL_H

#include "hebra/base.h"

#define HB_SEAL_BYTES 8192
#define HB_SEAL_PATH "hebra/seal"

/* Bytes from .. from+size-1 of the file. */
typedef struct hb_seal_range {
  uint64_t from, size;
} hb_seal_range;

/* Bytes that the check sum leaves out: data of tables, and the numbers that change. */
typedef struct hb_seal_gaps {
  hb_seal_range range[256];
  int count;
} hb_seal_gaps;
bool hb_seal_leave_out(hb_seal_gaps *gaps, uint64_t from, uint64_t size); /* false if there are too many */

/* Copy of all bytes outside the gaps, to be freed with hb_free. HB_ERR_MEMORY, or HB_ERR_IO. */
hb_status hb_seal_snapshot(int fd, hb_seal_gaps *gaps, unsigned char **bytes, size_t *size);
/* Place in the file of byte `index` of a snapshot. */
uint64_t hb_seal_place(const hb_seal_gaps *gaps, size_t index);
/* Computes the seal and writes it to byte `at`. HB_ERR_MEMORY, or HB_ERR_IO. */
hb_status hb_seal_write(int fd, hb_seal_gaps *gaps, uint64_t at);

/* Checks the file open in fd. HB_ERR_INPUT: the structure is damaged. HB_OK also where there is no seal to
 * check. */
hb_status hb_seal_check(int fd, const char *name, hb_error *err);

#endif
