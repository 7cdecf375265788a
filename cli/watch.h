/* The live view of a run: three views, in the terminal or in a window. */
#ifndef HB_CLI_WATCH_H
#define HB_CLI_WATCH_H

#include "hebra/hebra.h"

typedef struct cli_watch cli_watch;

/* mode: "terminal" (needs one on standard output) or "window" (needs ffplay and a display). speed: simulated
 * time per second of watching; 0: as fast as the run goes. Errors: HB_ERR_INPUT for an unknown mode,
 * HB_ERR_MISSING where there is nothing to draw on. model must outlive the watch. */
hb_status cli_watch_open(const hb_model *model, const char *mode, double speed, cli_watch **out,
                         hb_error *err);
/* Shows a frame, at most fifteen a second; with a speed it waits until the frame is due. */
void cli_watch_show(cli_watch *watch, const hb_frame *frame);
/* Leaves the last picture in the terminal, restores the cursor, closes the window. NULL is allowed. */
void cli_watch_close(cli_watch *watch);

#endif
