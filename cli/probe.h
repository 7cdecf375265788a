/* Quantities of a measured moment by name, such as "position.z[-1]" or "sum reaction.x[0:1]", and what
 * becomes of them over time. */
#ifndef HB_CLI_PROBE_H
#define HB_CLI_PROBE_H

#include "hebra/hebra.h"

/* A moment that quantities are read from. Not all of it is there in every kind of work. */
typedef struct cli_moment {
  const hb_model *model;
  const hb_frame *frame;
  const double *force;         /* 3 per slot: hb_state.force */
  const hb_equilibrium *found; /* NULL: none was looked for */
  double threshold;            /* NAN: none was looked for */
  const hb_modes *modes;       /* NULL: none were looked for */
} cli_moment;

/* How several numbers become one. */
typedef enum cli_reduce { CLI_ONE, CLI_SUM, CLI_LEAST_OF, CLI_MOST_OF, CLI_SIZE_OF } cli_reduce;

/* A quantity, compiled for one model. */
typedef struct cli_probe {
  int kind;       /* what it is, private */
  size_t offset;  /* in hb_frame */
  int components; /* of one entry */
  int component;  /* -1: Euclidean norm of all */
  cli_reduce reduce;
  int from, to; /* slots, both included */
} cli_probe;

/* Text: [sum|least|most|size] [ROD:]NAME[.x|.y|.z|.0..3][[INDEX]|[FROM:TO]|[:]]. NAME is a field of
 * trajectories, a number of hb_frame or of hb_equilibrium, force, net_force, writhe, threshold, or omega of a
 * mode. Indices are formulas of the scene's parameters and count from the end where negative. Without a
 * component a vector gives its length; `size` is the root of the sum of squares. HB_ERR_INPUT says what is
 * wrong with the text.
 */
hb_status cli_probe_parse(const char *text, const cli_moment *moment, cli_probe *out, hb_error *err);
double cli_probe_read(const cli_probe *probe, const cli_moment *moment);

/* A quantity over time: count values at the times given (ascending). */
typedef struct cli_series {
  const double *times, *values;
  long count;
} cli_series;
/* Value at a time, cubic between samples; NAN outside. */
double cli_series_at(const cli_series *s, double time);
/* Largest distance from the first value. */
double cli_series_drift(const cli_series *s);
/* First time at which the value passes through a level; NAN: never. */
double cli_series_reaches(const cli_series *s, double level);
/* Mean time between passages through a level in the same sense; NAN: fewer than two. */
double cli_series_period(const cli_series *s, double level);
/* Circular frequency of the strongest oscillation near guess (NAN: from the passages through the mean). The
 * samples are weighted with a window that fades at both ends, so that other frequencies hardly disturb: least
 * squares of a cos + b sin + c. Evenly spaced samples, at least two periods; NAN if there is nothing to fit.
 */
double cli_series_frequency(const cli_series *s, double guess);

#endif
