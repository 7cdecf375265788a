/* How a run tells where it is: a bar on a terminal, plain lines elsewhere, nothing if quiet. */
#ifndef HB_CLI_PROGRESS_H
#define HB_CLI_PROGRESS_H

#include "hebra/hebra.h"

typedef struct cli_progress {
  bool quiet, terminal;
  double started, shown; /* wall clock */
  long first_step, total_steps;
  double duration;
  int last_tenth;
} cli_progress;

/* first_step: where the run starts (not 0 after a restart). */
void cli_progress_begin(cli_progress *progress, const hb_sim *sim, bool quiet);
/* Shows the state if it is time to. */
void cli_progress_show(cli_progress *progress, const hb_frame *frame);
/* Ends the bar's line. */
void cli_progress_end(cli_progress *progress, const hb_frame *frame);
/* Seconds since begin. */
double cli_progress_seconds(const cli_progress *progress);

#endif
