/* One picture with a panel for every mode: the rod at rest, and displaced to both sides. */
#ifndef HB_CLI_MODAL_PICTURE_H
#define HB_CLI_MODAL_PICTURE_H

#include "cli/solution.h"

/* How far each mode is shown displaced: `part` of the rod's extent (the longest side of the box around it at
 * rest), or the largest half, quarter ... of it at which its lengths can be kept. strict: not less, else
 * HB_ERR_INPUT. amplitude: one per mode. */
hb_status cli_modal_amplitudes(cli_solution *s, const hb_modes *modes, double part, bool strict,
                               double *amplitude, hb_error *err);
/* Draws the modes into a PNG. */
hb_status cli_modal_picture(cli_solution *s, const hb_modes *modes, const double *amplitude, const char *path,
                            hb_error *err);

#endif
