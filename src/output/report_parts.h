/* Parts that the reports of runs and of equilibria share. */
#ifndef HB_OUTPUT_REPORT_PARTS_H
#define HB_OUTPUT_REPORT_PARTS_H

#include "hebra/sim.h"
#include "output/json.h"

/* reactions, torques, and supports: prescribed vertices that stand side by side as one, with the force and
 * the moment about their middle that it gives to the rod. Nothing if the frame holds no reactions. */
void hb_report_supports(hb_json *json, const hb_model *model, const hb_rod *rod, const hb_frame *frame);
/* An object with linking number (twist + writhe), twist in turns, writhe, closing, the whole number they
 * belong to and how far they miss it: where a link is defined, and the rod is not too long for it
 * (hb_frame_link). HB_ERR_MEMORY. */
hb_status hb_report_link(hb_json *json, const char *key, const hb_model *model, const hb_rod *rod,
                         const hb_frame *frame, hb_error *err);

#endif
