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
  double stepping_seconds; /* of processor, that the thread which steps has used; 0 if unknown */
  double writing_seconds;  /* the same for the thread that measures and writes */
  size_t peak_bytes;       /* largest memory of the process, 0 if unknown */
  long link_frames;        /* in which links were looked at, 0: none */
  double link_error;       /* largest distance of twist + writhe + closing from a whole number */
  long link_jumps;         /* times that twist + writhe changed by more than a half between frames */
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

/* One line with the whole energy balance at the end: kinetic and stored energy, what was there at the start,
 * work of loads and supports, dissipation, and what the scheme itself made or lost. */
void hb_report_books(const hb_model *model, const hb_frame *start, const hb_frame *end, double largest_energy,
                     char text[HB_REPORT_SENTENCE]);

/* A sentence if the energy balance at the end is more than 5 % (first-order schemes: 20 %) of the largest of
 * the change of energy, the work done and the largest energy seen: then the answer is not to be trusted.
 * False: the books close, and text is empty. */
bool hb_report_books_warning(const hb_model *model, const hb_frame *start, const hb_frame *end,
                             double largest_energy, char text[HB_REPORT_SENTENCE]);

#endif
