/* What is known of the branches of a trace, as a table and as a report. */
#ifndef HB_OUTPUT_BRANCHES_H
#define HB_OUTPUT_BRANCHES_H

#include "hebra/output.h"
#include "hebra/trace.h"

/* name, one sentence */
#define HB_BRANCH_MEASURES(M)                                                                                \
  M(amplitude, "largest distance of a vertex from where it is at the first point of all")                    \
  M(distance, "distance between the first and the last vertex")                                              \
  M(energy, "bending and twisting energy")                                                                   \
  M(energy_bending, "bending energy")                                                                        \
  M(energy_twisting, "twisting energy")                                                                      \
  M(start_force_x, "force of the supports in the first half of the rod")                                     \
  M(start_force_y, "the same along y")                                                                       \
  M(start_force_z, "the same along z")                                                                       \
  M(end_force_x, "force of the supports in the second half")                                                 \
  M(end_force_y, "the same along y")                                                                         \
  M(end_force_z, "the same along z")                                                                         \
  M(start_torque, "torque of the supports on held frames in the first half")                                 \
  M(end_torque, "the same in the second half")                                                               \
  M(tension, "axial force of the middle edge")                                                               \
  M(moment, "twisting moment at the middle vertex")                                                          \
  M(middle_x, "place of the middle vertex")                                                                  \
  M(middle_y, "the same along y")                                                                            \
  M(middle_z, "the same along z")                                                                            \
  M(end_x, "place of the last vertex")                                                                       \
  M(end_y, "the same along y")                                                                               \
  M(end_z, "the same along z")

enum {
#define HB_NAME(name, text) HB_MEASURE_##name,
  HB_BRANCH_MEASURES(HB_NAME)
#undef HB_NAME
      HB_MEASURE_COUNT
};

/* A row of the table. */
typedef struct hb_branch_row {
  int branch;
  long index;
  hb_trace_kind kind;
  int bifurcation, multiplicity, unstable, neutral;
  double parameter, arc, residual; /* unbalanced force, relative */
  double measure[HB_MEASURE_COUNT];
} hb_branch_row;

/* One branch. */
typedef struct hb_branch_end {
  int bifurcation, side;
  long points;
  bool failed;
  char reason[HB_TRACE_SENTENCE];
} hb_branch_end;

typedef struct hb_branches {
  const hb_model *model; /* of the first point */
  const char *parameter;
  double from, to, time, wall_seconds;
  const hb_trace_costs *costs;
  const hb_branch_row *rows;
  long row_count;
  const hb_branch_end *ends;
  int end_count;
} hb_branches;

/* Measures a point: frame as of hb_sim_measure_equilibrium, first: positions of the first point of all. */
void hb_branch_measure(const hb_trace_point *point, const hb_model *model, const hb_frame *frame,
                       const double *first, hb_branch_row *row);
/* Writes branches.csv: one line per point, names of the columns in the first. Whole or not at all. */
hb_status hb_branches_table(const char *path, const hb_branches *all, hb_error *err);
/* Writes branches.json: what was traced, how every branch ended, all folds and bifurcations. */
hb_status hb_branches_report(const char *path, const hb_branches *all, hb_error *err);

#endif
