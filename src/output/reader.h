/* The part of the reader below the file name, for fuzzing: a file image in memory goes the same way. */
#ifndef HB_OUTPUT_READER_H
#define HB_OUTPUT_READER_H

#include "hebra/output.h"
#include "output/h5.h"

/* Takes over an open HDF5 file (closed also on failure). name: for the sentences. */
hb_status hb_reader_adopt(hid_t file, const char *name, hb_reader **out, hb_error *err);

/* Name of the file as it was opened. */
const char *hb_reader_name(const hb_reader *reader);
/* Number of the run that wrote it, in hexadecimal digits; empty if the file does not tell. */
const char *hb_reader_run(const hb_reader *reader);

#endif
