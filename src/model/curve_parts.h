/* Shared by the curve generators: checks of input, and division of a curve into equal chords. Private to the
 * model room. */
#ifndef HB_MODEL_CURVE_PARTS_H
#define HB_MODEL_CURVE_PARTS_H

#include "hebra/curve.h"

/* Most vertices of one curve. */
#define HB_CURVE_COUNT_MAX 10000000

/* A curve p -> (x, y, z), differentiable except at corners, for from <= p <= to. */
typedef struct hb_path {
  void (*at)(const void *context, double p, double position[3], double slope[3]);
  const void *context;
  double from, to;
} hb_path;

/* Vertices on the path at equal chords, the first and the last at its ends. samples: places (>= 2) evenly
 * spaced in p that show the path's shape well enough to start from; for a polyline they are its vertices. */
hb_status hb_path_divide(const hb_path *path, int samples, int count, double *xyz, hb_error *err);

/* HB_ERR_INPUT unless least <= count <= HB_CURVE_COUNT_MAX. */
hb_status hb_curve_check_count(int count, int least, hb_error *err);
/* HB_ERR_INPUT unless all n numbers are finite; what names them in the sentence. */
hb_status hb_curve_check_finite(const char *what, const double *values, int n, hb_error *err);
/* HB_ERR_INPUT unless value is finite and > 0. */
hb_status hb_curve_check_positive(const char *what, double value, hb_error *err);
/* HB_ERR_INPUT if a vertex is not finite or two neighbours coincide. */
hb_status hb_curve_check_edges(const double *xyz, int count, hb_error *err);

#endif
