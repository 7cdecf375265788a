/* The report of a run. */
#ifndef HB_OUTPUT_REPORT_H
#define HB_OUTPUT_REPORT_H

#include "hebra/output.h"

/* Writes report.json to path (whole or not at all): what was run, how it ended, and how well the books
 * balance. start, end: frames measured at the beginning and the end. wall_seconds: of the whole run.
 * peak_bytes: largest memory of the process, 0 if unknown. stop_reason: one sentence or word, e.g.
 * "finished"; NULL gives null. */
hb_status hb_report_write(const char *path, const hb_sim *sim, const hb_frame *start, const hb_frame *end,
                          double wall_seconds, size_t peak_bytes, const char *stop_reason, hb_error *err);

#endif
