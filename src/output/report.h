/* The report of a run. */
#ifndef HB_OUTPUT_REPORT_H
#define HB_OUTPUT_REPORT_H

#include "hebra/output.h"
#include "hebra/statics.h"
#include "output/json.h"

#define HB_REPORT_SENTENCE 400

/* What the report cannot read off the simulation. */
typedef struct hb_report_facts {
  double wall_seconds;     /* of the whole run */
  size_t peak_bytes;       /* largest memory of the process, 0 if unknown */
  const char *stop_reason; /* one sentence or word, e.g. "finished"; NULL gives null */
  double largest_energy; /* largest sum of kinetic, bending and twisting energy in any frame, 0 if unknown */
} hb_report_facts;

/* Members that every report begins with: title, program, version, scene file, parameters. */
void hb_report_scene(hb_json *json, const hb_model *model);

/* Writes report.json to path (whole or not at all): what was run, how it ended, and how well the books
 * balance. start, end: frames measured at the beginning and the end. */
hb_status hb_report_write(const char *path, const hb_sim *sim, const hb_frame *start, const hb_frame *end,
                          const hb_report_facts *facts, hb_error *err);

/* The same for an equilibrium, whose frame is measured by hb_sim_measure_equilibrium. */
hb_status hb_report_equilibrium(const char *path, const hb_model *model, const hb_frame *frame,
                                const hb_equilibrium *found, double wall_seconds, hb_error *err);

/* A sentence if the time step is above the stable step of the model (hb_model_stable_step). False: it is not,
 * and text is empty. */
bool hb_report_step_warning(const hb_model *model, char text[HB_REPORT_SENTENCE]);

/* A sentence if the energy balance at the end is more than 5 % (first-order schemes: 20 %) of the largest of
 * the change of energy, the work done and the largest energy seen: then the answer is not to be trusted.
 * False: the books close, and text is empty. */
bool hb_report_books_warning(const hb_model *model, const hb_frame *start, const hb_frame *end,
                             double largest_energy, char text[HB_REPORT_SENTENCE]);

/* An object with linking number, twist in turns and writhe of a rod. */
void hb_report_link(hb_json *json, const char *key, const hb_model *model, int rod, const hb_frame *frame);

#endif
