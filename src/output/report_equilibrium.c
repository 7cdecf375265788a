/* The report of an equilibrium. */
#include "output/report.h"

#include "output/file.h"
#include "output/report_parts.h"

#include <math.h>

/* How well it balances, and how stable it is. */
static void balance(hb_json *json, const hb_equilibrium *found) {
  hb_json_object(json, "equilibrium");
  hb_json_bool(json, "stable", found->unstable == 0);
  hb_json_integer(json, "unstable_modes", found->unstable);
  hb_json_integer(json, "neutral_modes", found->neutral);
  hb_json_number(json, "stiffness_resolution", found->resolution);
  hb_json_integer(json, "iterations", found->iterations);
  hb_json_integer(json, "factorisations", found->factorisations);
  hb_json_integer(json, "escapes", found->escapes);
  hb_json_number(json, "unbalanced_force", found->residual);
  hb_json_number(json, "force_scale", found->force_scale);
  hb_json_number(json, "last_displacement", found->last_step);
  hb_json_object_end(json);
}

/* Least and most of an array. */
static void range(hb_json *json, const char *least_key, const char *most_key, const double *values, int from,
                  int to) {
  double least = HUGE_VAL, most = -HUGE_VAL;
  for (int k = from; k < to; k++) {
    least = fmin(least, values[k]);
    most = fmax(most, values[k]);
  }
  hb_json_number(json, least_key, least);
  hb_json_number(json, most_key, most);
}

/* All rods. */
static hb_status rods(hb_json *json, const hb_model *model, const hb_frame *frame, hb_error *err) {
  hb_status status = HB_OK;
  hb_json_array(json, "rods");
  for (int r = 0; r < model->rod_count; r++) {
    const hb_rod *rod = &model->rods[r];
    double energy[3], twist = 0;
    int last = rod->first + rod->nv - 1, behind = rod->first + rod->last_joint + 1;
    hb_frame_rod_energy(model, frame, r, energy);
    for (int k = rod->first + 1; k < behind; k++) twist += frame->twist[k];
    hb_json_object(json, NULL);
    hb_json_text(json, "name", rod->name);
    hb_json_integer(json, "vertices", rod->nv);
    hb_json_number(json, "length", rod->length);
    hb_json_number(json, "bending", energy[1]);
    hb_json_number(json, "twisting", energy[2]);
    hb_json_number(json, "stretching", hb_frame_rod_stretching(model, frame, r));
    hb_json_number(json, "total_twist", twist);
    range(json, "twisting_moment_least", "twisting_moment_most", frame->twisting_moment, rod->first + 1,
          behind);
    range(json, "tension_least", "tension_most", frame->tension, rod->first, last);
    hb_json_vector(json, "first_vertex", frame->position + 3 * rod->first, 3);
    hb_json_vector(json, "last_vertex", frame->position + 3 * last, 3);
    hb_report_supports(json, model, rod, frame);
    if (!status) status = hb_report_link(json, "link", model, rod, frame, err);
    hb_json_object_end(json);
  }
  hb_json_array_end(json);
  return status;
}

/* Whole or not at all. */
hb_status hb_report_equilibrium(const char *path, const hb_model *model, const hb_frame *frame,
                                const hb_equilibrium *found, double wall_seconds, hb_error *err) {
  hb_file file;
  hb_json json;
  hb_status status = hb_file_begin(path, &file, err);
  if (status != HB_OK) return status;
  hb_json_begin(&json, file.stream);
  hb_report_scene(&json, model);
  hb_json_number(&json, "time", frame->time);
  hb_json_number(&json, "wall_seconds", wall_seconds);
  balance(&json, found);
  hb_json_object(&json, "energy");
  hb_json_number(&json, "bending", frame->bending);
  hb_json_number(&json, "twisting", frame->twisting);
  hb_json_number(&json, "stretching", frame->stretching);
  hb_json_number(&json, "gravity", frame->gravity);
  hb_json_object_end(&json);
  hb_json_number(&json, "length_error", frame->length_error);
  status = rods(&json, model, frame, err);
  hb_json_array(&json, "warnings");
  for (int k = 0; k < model->note_count; k++) hb_json_text(&json, NULL, model->notes[k]);
  hb_json_array_end(&json);
  hb_json_text(&json, "source", model->def->source);
  hb_json_end(&json);
  hb_status ended = hb_file_end(&file, !status, false, status ? NULL : err);
  return status ? status : ended;
}
