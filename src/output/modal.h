/* Modes and matrices as files: JSON, CSV, Matrix Market. */
#ifndef HB_OUTPUT_MODAL_H
#define HB_OUTPUT_MODAL_H

#include "hebra/modes.h"
#include "hebra/sim.h"

/* "unstable", "rigid" or "vibration". */
const char *hb_modal_kind(const hb_mode *mode);

/* modes.json: the scene, its equilibrium in short, and a list of all modes with their figures. */
hb_status hb_modal_report(const char *path, const hb_model *model, const hb_equilibrium *at,
                          const hb_modes *modes, double wall_seconds, hb_error *err);
/* modes.csv: one row per mode. */
hb_status hb_modal_table(const char *path, const hb_model *model, const hb_modes *modes, hb_error *err);
/* shapes.csv: one row per mode and vertex of its rod; position: of the equilibrium, 3 per slot. */
hb_status hb_modal_shapes(const char *path, const hb_model *model, const double *position,
                          const hb_modes *modes, hb_error *err);
/* M.mtx, K.mtx, G.mtx (coordinate format) and unknowns.csv, which says what the rows mean, in a directory. */
hb_status hb_modal_matrices(const char *directory, const hb_model *model, const hb_matrices *matrices,
                            hb_error *err);

#endif
