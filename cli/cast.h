/* The rods of a trajectory or model as tubes with their colours. */
#ifndef HB_CLI_CAST_H
#define HB_CLI_CAST_H

#include "hebra/hebra.h"

typedef struct cli_cast {
  hb_tube *tubes;
  int count;
  int *first;       /* first vertex of each rod in the common arrays */
  double *xyz, *m1; /* 3 per vertex slot: room for one frame; not used where cli_cast_show points elsewhere */
} cli_cast;

/* color: 0..1, of all rods; NULL: one of a palette for each. Of many copies of one rod each is a little
 * different. */
hb_status cli_cast_from_reader(const hb_trajectory_info *info, const double *color, cli_cast *cast,
                               hb_error *err);
hb_status cli_cast_from_model(const hb_model *model, cli_cast *cast, hb_error *err);
void cli_cast_free(cli_cast *cast);
/* Lets the tubes point into these arrays; m1 may be NULL. */
void cli_cast_show(cli_cast *cast, const double *xyz, const double *m1);
/* Reads a frame into the cast's own arrays and shows it. */
hb_status cli_cast_read(cli_cast *cast, hb_reader *reader, long frame, hb_error *err);

#endif
