/* hebra/trace.h - branches of equilibria over a parameter (docs/theory, 16). */
#ifndef HEBRA_TRACE_H
#define HEBRA_TRACE_H

#include "hebra/sim.h"
#include "hebra/statics.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Scenes that differ in the value of one parameter. */
typedef struct hb_trace_family {
  /* The scene for a value, compiled, and the time at which its loads and supports are taken. All scenes of a
   * family have one rod, with the same number of vertices and the same kinds of supports. *model is given
   * back by drop. */
  hb_status (*at)(void *context, double value, const hb_model **model, double *time, hb_error *err);
  void (*drop)(void *context, const hb_model *model);
  void *context;
} hb_trace_family;

/* How branches are followed. */
typedef struct hb_trace_options {
  double from, to; /* values of the parameter; the branches never leave this range */
  double step;    /* longest step; 1 is the whole range of the parameter, or a displacement of all vertices by
                     the rod's length, > 0 */
  int max_points; /* of one branch, >= 2 */
  int max_branches; /* in all, the first included, >= 1 */
  bool any;         /* start from the nearest equilibrium, stable or not */
} hb_trace_options;

/* The step 0.02, 1000 points, 5 branches. */
hb_trace_options hb_trace_defaults(double from, double to);

#define HB_TRACE_SENTENCE 480

typedef enum hb_trace_kind {
  HB_TRACE_START,       /* of a branch: the first equilibrium, or the bifurcation that it comes from */
  HB_TRACE_REGULAR,     /* one of the points between */
  HB_TRACE_FOLD,        /* the parameter turns back */
  HB_TRACE_BIFURCATION, /* other branches cross */
  HB_TRACE_LIMIT        /* the end of the parameter's range */
} hb_trace_kind;
const char *hb_trace_kind_name(hb_trace_kind kind); /* "start", "regular", "fold", "bifurcation", "limit" */

/* One equilibrium of a branch. */
typedef struct hb_trace_point {
  int branch; /* from 0 */
  long index; /* in its branch, from 0 */
  hb_trace_kind kind;
  double parameter;
  double arc;       /* along the branch, in the units of options.step */
  int bifurcation;  /* BIFURCATION, or START of another branch than the first: its number from 0, else -1 */
  int multiplicity; /* BIFURCATION: modes that change sides; 0 elsewhere */
  hb_equilibrium found; /* as of `hebra solve`; the multipliers are borrowed */
  hb_sim *sim;          /* in this state; borrowed, until the call returns */
} hb_trace_point;

/* How a branch ended. */
typedef struct hb_trace_end {
  int branch;
  int bifurcation; /* that it comes from, -1: the first branch */
  int side;        /* of the mode it was left along: 1, -1; 0: the first branch */
  long points;
  bool failed;        /* it could not be followed further */
  const char *reason; /* one sentence, shorter than HB_TRACE_SENTENCE */
} hb_trace_end;

/* Who is told; what they return other than HB_OK ends the trace. */
typedef struct hb_trace_sink {
  hb_status (*point)(void *context, const hb_trace_point *point, hb_error *err);
  hb_status (*end)(void *context, const hb_trace_end *end, hb_error *err);
  void *context;
} hb_trace_sink;

/* Counts of everything that was done. */
typedef struct hb_trace_costs {
  long points, iterations, factorisations, scenes;
} hb_trace_costs;

/* Finds the equilibrium at options->from and follows the branch to which it belongs, then those that cross
 * it, one after the other, until max_branches are done. Points of a branch come in order. HB_ERR_INPUT: the
 * scene cannot be traced. HB_ERR_NUMERIC: there is no first equilibrium. A branch that cannot be followed
 * further is no error: its end says so. */
hb_status hb_trace(const hb_trace_family *family, const hb_trace_options *options, const hb_trace_sink *sink,
                   hb_trace_costs *costs, hb_error *err);

#ifdef __cplusplus
}
#endif
#endif
