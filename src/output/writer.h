/* The part of the writer that the recorder uses: several frames in one go. A small frame costs some forty
 * calls of the system, most of them for a few bytes; frames that wait together share them. */
#ifndef HB_OUTPUT_WRITER_H
#define HB_OUTPUT_WRITER_H

#include "hebra/output.h"

/* Takes a frame like hb_writer_add, but may keep it until hb_writer_flush, hb_writer_add or hb_writer_close.
 */
hb_status hb_writer_collect(hb_writer *writer, const hb_frame *frame, hb_error *err);
/* Puts what was collected into the file. If it does not take all, the frames before the first that failed are
 * kept, and the sentence tells of that one; the rest is forgotten. */
hb_status hb_writer_flush(hb_writer *writer, hb_error *err);
long hb_writer_frames(const hb_writer *writer); /* in the file */

#endif
