#include "output/report.h"

#include "output/file.h"
#include "output/report_parts.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* Whose figures these are. */
void hb_report_scene(hb_json *json, const hb_model *model) {
  const hb_scene_def *def = model->def;
  hb_json_text(json, "title", def->title ? def->title : "");
  hb_json_text(json, "program", "hebra");
  hb_json_text(json, "version", HB_VERSION);
  hb_json_text(json, "scene_file", def->path);
  hb_json_object(json, "parameters");
  for (int k = 0; k < def->parameter_count; k++)
    hb_json_number(json, def->parameters[k].name, def->parameters[k].value);
  hb_json_object_end(json);
}

/* What was run. */
static void scene(hb_json *json, const hb_model *model) {
  const hb_method_def *method = &model->def->method;
  hb_report_scene(json, model);
  hb_json_object(json, "method");
  hb_json_text(json, "integrator", method->integrator ? method->integrator : "verlet");
  hb_json_number(json, "time_step", method->time_step);
  hb_json_number(json, "duration", method->duration);
  hb_json_number(json, "length_tolerance", method->length_tolerance);
  hb_json_text(json, "length_tolerance_kind",
               method->length_tolerance_kind == HB_TOLERANCE_RELATIVE ? "relative" : "absolute");
  hb_json_text(json, "precision", method->precision == HB_PRECISION_SINGLE ? "single" : "double");
  hb_json_integer(json, "max_projections", method->max_projections);
  hb_json_integer(json, "max_twist_iterations", method->max_twist_iterations);
  hb_json_object_end(json);
}

/* How it ended. */
static void outcome(hb_json *json, const hb_sim *sim, double wall_seconds, const char *stop_reason) {
  hb_json_text(json, "stopped", stop_reason);
  hb_json_number(json, "time", hb_sim_time(sim));
  hb_json_integer(json, "steps", hb_sim_steps(sim));
  hb_json_integer(json, "steps_planned", hb_sim_total_steps(sim));
  hb_json_integer(json, "vertices", hb_sim_model(sim)->nv);
  hb_json_number(json, "wall_seconds", wall_seconds);
}

/* Energies of one frame. */
static void energies(hb_json *json, const char *key, const hb_frame *frame) {
  hb_json_object(json, key);
  hb_json_number(json, "kinetic", frame->kinetic);
  hb_json_number(json, "bending", frame->bending);
  hb_json_number(json, "twisting", frame->twisting);
  hb_json_number(json, "stretching", frame->stretching);
  hb_json_number(json, "gravity", frame->gravity);
  hb_json_number(json, "sum_without_gravity",
                 frame->kinetic + frame->bending + frame->twisting + frame->stretching);
  hb_json_object_end(json);
}

/* Energies, work, momentum, lengths. */
static void balance(hb_json *json, const hb_frame *start, const hb_frame *end, double scale) {
  hb_json_object(json, "energy");
  energies(json, "start", start);
  energies(json, "end", end);
  hb_json_number(json, "work_of_loads", end->work_loads);
  hb_json_number(json, "work_of_supports", end->work_supports);
  hb_json_number(json, "dissipated", end->dissipated);
  hb_json_number(json, "balance", end->balance);
  hb_json_number(json, "balance_relative", scale > 0 ? end->balance / scale : 0);
  hb_json_object_end(json);
  hb_json_object(json, "momentum");
  hb_json_vector(json, "linear_start", start->momentum, 3);
  hb_json_vector(json, "linear_end", end->momentum, 3);
  hb_json_vector(json, "angular_start", start->angular_momentum, 3);
  hb_json_vector(json, "angular_end", end->angular_momentum, 3);
  hb_json_object_end(json);
  hb_json_object(json, "length_error");
  hb_json_number(json, "last", end->length_error);
  hb_json_number(json, "worst", end->worst_length_error);
  hb_json_object_end(json);
}

/* Twist of one rod: sum over its vertices, and the range of the twisting moment. */
static void rod_twist(hb_json *json, const hb_rod *rod, const hb_frame *frame) {
  double total = 0, least = HUGE_VAL, most = -HUGE_VAL;
  for (int i = rod->first + 1; i <= rod->first + rod->last_joint; i++) {
    total += frame->twist[i];
    least = fmin(least, frame->twisting_moment[i]);
    most = fmax(most, frame->twisting_moment[i]);
  }
  hb_json_number(json, "total_twist", total);
  hb_json_number(json, "total_twist_turns", total / (2 * 3.14159265358979323846));
  hb_json_number(json, "twisting_moment_least", least);
  hb_json_number(json, "twisting_moment_most", most);
}

/* All rods. */
static hb_status rods(hb_json *json, const hb_model *model, const hb_frame *start, const hb_frame *frame,
                      hb_error *err) {
  hb_status status = HB_OK;
  hb_json_array(json, "rods");
  for (int r = 0; r < model->rod_count; r++) {
    const hb_rod *rod = &model->rods[r];
    double energy[3], mass = 0;
    hb_frame_rod_energy(model, frame, r, energy);
    for (int i = rod->first; i < rod->first + rod->nv; i++) mass += model->mass[i];
    hb_json_object(json, NULL);
    hb_json_text(json, "name", rod->name);
    hb_json_integer(json, "vertices", rod->nv);
    hb_json_number(json, "length", rod->length);
    hb_json_number(json, "mass", mass);
    hb_json_number(json, "radius", model->def->rods[r].radius);
    hb_json_text(json, "twist_method",
                 rod->twist_free    ? "none: free to untwist"
                 : rod->closed_form ? "closed form"
                                    : "Newton");
    hb_json_number(json, "kinetic", energy[0]);
    hb_json_number(json, "bending", energy[1]);
    hb_json_number(json, "twisting", energy[2]);
    hb_json_number(json, "stretching", hb_frame_rod_stretching(model, frame, r));
    rod_twist(json, rod, frame);
    hb_report_supports(json, model, rod, frame);
    if (!status) status = hb_report_link(json, "link_start", model, rod, start, err);
    if (!status) status = hb_report_link(json, "link", model, rod, frame, err);
    hb_json_object_end(json);
  }
  hb_json_array_end(json);
  return status;
}

/* What was seen of the links in all frames. */
static void links(hb_json *json, const hb_report_facts *facts) {
  if (facts->link_frames == 0) return;
  hb_json_object(json, "link");
  hb_json_integer(json, "frames", facts->link_frames);
  hb_json_number(json, "largest_error", facts->link_error);
  hb_json_integer(json, "jumps", facts->link_jumps);
  hb_json_object_end(json);
}

/* Iterations, times, memory. */
static void cost(hb_json *json, const hb_sim *sim, const hb_report_facts *facts) {
  const double *scalar = hb_sim_const_state(sim)->scalar;
  double seconds[HB_STAGE_COUNT] = {0}, steps = (double)hb_sim_steps(sim);
  hb_sim_stage_seconds(sim, seconds);
  hb_json_object(json, "iterations_per_step");
  hb_json_number(json, "projection", steps > 0 ? scalar[HB_S_PROJECTIONS] / steps : 0);
  hb_json_number(json, "twist_newton", steps > 0 ? scalar[HB_S_TWIST_ITERATIONS] / steps : 0);
  if (hb_method_is_implicit(&hb_sim_model(sim)->def->method)) {
    hb_json_number(json, "newton", steps > 0 ? scalar[HB_S_NEWTON] / steps : 0);
    hb_json_number(json, "factorisations", steps > 0 ? scalar[HB_S_FACTORISATIONS] / steps : 0);
    hb_json_number(json, "pieces", steps > 0 ? scalar[HB_S_PIECES] / steps : 0);
    hb_json_number(json, "pieces_rejected", steps > 0 ? scalar[HB_S_REJECTED] / steps : 0);
  }
  hb_json_object_end(json);
  hb_json_object(json, "seconds");
  hb_json_number(json, "wall", facts->wall_seconds);
  hb_json_number(json, "stepping_thread", facts->stepping_seconds);
  hb_json_number(json, "writing_thread", facts->writing_seconds);
  for (int k = 0; k < HB_STAGE_COUNT; k++) hb_json_number(json, hb_stage_names[k], seconds[k]);
  hb_json_object_end(json);
  hb_json_number(json, "ns_per_vertex_and_step",
                 steps > 0 ? 1e9 * facts->wall_seconds / (steps * hb_sim_model(sim)->nv) : HUGE_VAL);
  hb_json_object(json, "memory_bytes");
  hb_json_integer(json, "simulation", (long long)hb_sim_memory(sim));
  hb_json_integer(json, "process_peak", (long long)facts->peak_bytes);
  hb_json_object_end(json);
}

/* The rod and its vertex that a slot belongs to; -1 outside. */
static int rod_at(const hb_model *model, double slot) {
  for (int r = 0; r < model->rod_count; r++)
    if (slot >= model->rods[r].first && slot < model->rods[r].first + model->rods[r].nv) return r;
  return -1;
}

/* The step against its limit. */
bool hb_report_step_warning(const hb_model *model, char text[HB_REPORT_SENTENCE]) {
  int rod = 0;
  double step = model->def->method.time_step, limit = hb_model_stable_step(model, &rod);
  text[0] = 0;
  if (!(step > limit)) return false;
  snprintf(
      text, HB_REPORT_SENTENCE,
      "the time step %.6g is above %.3g, the largest that the scheme bears (rod %.60s): the run fails or, "
      "worse, survives with a wrong answer; take at most %.2g, or fewer vertices",
      step, limit, model->rods[rod].name ? model->rods[rod].name : "", 0.8 * limit);
  return true;
}

/* An energy far below all that could matter in the model: what is smaller than this is round-off. */
static double negligible_energy(const hb_model *model) {
  double sum = 0, duration = model->def->method.duration;
  for (int r = 0; r < model->rod_count; r++) {
    const hb_rod *rod = &model->rods[r];
    double mass = 0, stiffness = 0, speed = duration > 0 ? rod->length / duration : 0;
    for (int k = rod->first; k < rod->first + rod->nv; k++) {
      mass += model->mass[k];
      stiffness = fmax(stiffness, fmax(model->B[3 * k], model->B[3 * k + 2]));
    }
    sum += mass * speed * speed + stiffness / rod->length;
  }
  return 1e-9 * sum;
}

/* The largest energy or work that the balance can be compared with. */
static double books_scale(const hb_model *model, const hb_frame *start, const hb_frame *end,
                          double largest_energy) {
  double before = start->kinetic + start->bending + start->twisting + start->stretching;
  double after = end->kinetic + end->bending + end->twisting + end->stretching;
  double scale = fmax(fmax(before, after), fmax(largest_energy, negligible_energy(model)));
  return fmax(scale, fmax(fabs(end->work_loads), fmax(fabs(end->work_supports), fabs(end->dissipated))));
}

/* The books of energy. */
bool hb_report_books_warning(const hb_model *model, const hb_frame *start, const hb_frame *end,
                             double largest_energy, char text[HB_REPORT_SENTENCE]) {
  const char *integrator = model->def->method.integrator;
  double allowed = integrator && strcmp(integrator, "symplectic-euler") == 0 ? 0.2 : 0.05;
  bool damps = integrator && strcmp(integrator, "backward-euler") == 0; /* what is missing was meant to be */
  double scale = books_scale(model, start, end, largest_energy);
  text[0] = 0;
  if (fabs(end->balance) <= allowed * scale || (damps && end->balance < 0)) return false;
  snprintf(
      text, HB_REPORT_SENTENCE,
      "the books of energy do not close: %.3g is missing or too much, %.2g %% of the largest energy or work "
      "(%.3g); the result is not to be trusted, a smaller time step is the cure",
      end->balance, 100 * fabs(end->balance) / scale, scale);
  return true;
}

/* Everything that came in and went out; what is left over is the scheme's. */
void hb_report_books(const hb_model *model, const hb_frame *start, const hb_frame *end, double largest_energy,
                     char text[HB_REPORT_SENTENCE]) {
  double stored = end->bending + end->twisting + end->stretching;
  double before =
      end->kinetic + stored - end->work_loads - end->work_supports + end->dissipated - end->balance;
  double scale = books_scale(model, start, end, largest_energy);
  snprintf(text, HB_REPORT_SENTENCE,
           "energy: kinetic %.6g + stored %.6g = at the start %.6g + work of loads %.6g + of supports %.6g - "
           "dissipated %.6g + made by the scheme %.2e (%.2g %% of the largest)",
           end->kinetic, stored, before, end->work_loads, end->work_supports, end->dissipated, end->balance,
           scale > 0 ? 100 * fabs(end->balance) / scale : 0);
}

/* Things that a person should know of. */
static void warnings(hb_json *json, const hb_sim *sim, const hb_frame *start, const hb_frame *end,
                     double largest_energy) {
  const hb_model *model = hb_sim_model(sim);
  const double *scalar = hb_sim_const_state(sim)->scalar;
  char text[HB_REPORT_SENTENCE];
  hb_json_array(json, "warnings");
  if (hb_report_step_warning(model, text)) hb_json_text(json, NULL, text);
  if (hb_report_books_warning(model, start, end, largest_energy, text)) hb_json_text(json, NULL, text);
  for (int k = 0; k < model->note_count; k++) hb_json_text(json, NULL, model->notes[k]);
  if (scalar[HB_S_FOLDS] > 0) {
    int rod = rod_at(model, scalar[HB_S_FOLD_SLOT]);
    int at = snprintf(text, sizeof text, "%.0f times two neighbouring edges folded back onto each other",
                      scalar[HB_S_FOLDS]);
    if (rod >= 0 && at > 0 && (size_t)at < sizeof text)
      snprintf(text + at, sizeof text - (size_t)at, ", last at vertex %.0f of rod %.80s",
               scalar[HB_S_FOLD_SLOT] - model->rods[rod].first,
               model->rods[rod].name ? model->rods[rod].name : "");
    hb_json_text(json, NULL, text);
  }
  hb_json_array_end(json);
  hb_json_integer(json, "folds", (long long)scalar[HB_S_FOLDS]);
  hb_json_integer(json, "first_order_fallbacks", (long long)scalar[HB_S_FALLBACKS]);
  hb_json_integer(json, "twist_saddles_left", (long long)scalar[HB_S_SADDLES]);
}

/* The whole report. */
hb_status hb_report_write(const char *path, const hb_sim *sim, const hb_frame *start, const hb_frame *end,
                          const hb_report_facts *facts, hb_error *err) {
  hb_file file;
  hb_json json;
  hb_status status = hb_file_begin(path, &file, err);
  if (status != HB_OK) return status;
  const hb_model *model = hb_sim_model(sim);
  hb_json_begin(&json, file.stream);
  scene(&json, model);
  outcome(&json, sim, facts->wall_seconds, facts->stop_reason);
  balance(&json, start, end, books_scale(model, start, end, facts->largest_energy));
  status = rods(&json, model, start, end, err);
  links(&json, facts);
  cost(&json, sim, facts);
  warnings(&json, sim, start, end, facts->largest_energy);
  hb_json_text(&json, "source", model->def->source);
  hb_json_end(&json);
  hb_status ended = hb_file_end(&file, !status, false, status ? NULL : err);
  return status ? status : ended;
}
