/* The scalars of a frame as a table: names, units, places. */
#ifndef HB_OUTPUT_SERIES_H
#define HB_OUTPUT_SERIES_H

#include "hebra/sim.h"

/* A scalar of hb_frame that is kept for every frame under /hebra/series. */
typedef struct hb_series {
  const char *name, *unit, *text;
  size_t offset; /* in hb_frame */
  bool integer;  /* a long, else a double */
} hb_series;
extern const hb_series hb_series_table[];
extern const int hb_series_count;

#endif
