/* Charts by gnuplot: a script and its data go through a pipe. */
#ifndef HB_CLI_CHART_H
#define HB_CLI_CHART_H

#include "cli/pipe.h"
#include "hebra/hebra.h"

enum { CLI_CHART_RODS = 8, CLI_CHART_FRAMES = 12, CLI_CHART_PANELS = 12 };

/* What is drawn, and from what. */
typedef struct cli_chart {
  hb_reader *reader;
  const hb_trajectory_info *info;
  double *times;  /* of all frames */
  double *series; /* room for one series */
  double *field;  /* room for one field, up to 4 components */
  double *points; /* room for positions */
  double *table;  /* room for CLI_CHART_RODS values per frame */
  int rod;        /* whose values along the rod are drawn */
  long frames[CLI_CHART_FRAMES];
  int frame_count; /* frames drawn along the rod */
  cli_pipe pipe;
  hb_status status; /* of the first write that failed; later ones do nothing */
  hb_error *err;
  size_t filled;
  char buffer[16384];
} cli_chart;

/* A kind of panel. */
typedef struct cli_chart_kind {
  const char *name, *text;
  void (*draw)(cli_chart *chart); /* failures stay in chart->status */
} cli_chart_kind;
extern const cli_chart_kind cli_chart_kinds[];
extern const int cli_chart_kind_count;

/* Adds to the script. */
void cli_chart_say(cli_chart *chart, const char *format, ...) HB_PRINTF(2, 3);
/* Sends what is left. */
void cli_chart_flush(cli_chart *chart);

#endif
