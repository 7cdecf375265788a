/* Files of modes. Numbers read back to the same bits. */
#include "output/modal.h"

#include "base/memory.h"
#include "output/file.h"
#include "output/json.h"
#include "output/report.h"

#define TURN 6.283185307179586

/* A number after a comma. */
static void cell(FILE *stream, double value) {
  char text[32];
  hb_number_text(value, text);
  fprintf(stream, ",%s", text);
}

/* In words. */
const char *hb_modal_kind(const hb_mode *mode) {
  int kind = hb_mode_kind(mode);
  return kind < 0 ? "unstable" : kind > 0 ? "vibration" : "rigid";
}

/* One mode. Rigid ones have no period, unstable ones a rate instead. */
static void write_mode(hb_json *json, const hb_model *model, const hb_mode *mode, int number) {
  double omega = hb_mode_omega(mode), axis[3] = {0, 0, 0};
  const hb_rod *rod = &model->rods[mode->rod];
  for (int i = 0; i < rod->nv; i++)
    for (int c = 0; c < 3; c++) {
      double d = mode->shape[3 * i + c];
      axis[c] += model->mass[rod->first + i] * d * d;
    }
  hb_json_object(json, NULL);
  hb_json_integer(json, "mode", number);
  hb_json_text(json, "rod", rod->name);
  hb_json_text(json, "kind", hb_modal_kind(mode));
  hb_json_number(json, "omega_squared", mode->square);
  hb_json_number(json, "resolution", mode->resolution);
  hb_json_number(json, "iteration_error", mode->error);
  if (hb_mode_kind(mode) < 0) hb_json_number(json, "growth_rate", omega);
  if (hb_mode_kind(mode) > 0) {
    hb_json_number(json, "omega", omega);
    hb_json_number(json, "frequency", omega / TURN);
    hb_json_number(json, "period", TURN / omega);
  }
  hb_json_vector(json, "mass_moving_along", axis, 3);
  hb_json_object_end(json);
}

/* Whole or not at all. */
hb_status hb_modal_report(const char *path, const hb_model *model, const hb_equilibrium *at,
                          const hb_modes *modes, double wall_seconds, hb_error *err) {
  hb_file file;
  hb_json json;
  hb_status status = hb_file_begin(path, &file, err);
  if (status) return status;
  hb_json_begin(&json, file.stream);
  hb_report_scene(&json, model);
  hb_json_number(&json, "wall_seconds", wall_seconds);
  hb_json_object(&json, "equilibrium");
  hb_json_integer(&json, "unstable_modes", at->unstable);
  hb_json_integer(&json, "neutral_modes", at->neutral);
  hb_json_number(&json, "unbalanced_force", at->residual);
  hb_json_number(&json, "force_scale", at->force_scale);
  hb_json_object_end(&json);
  hb_json_integer(&json, "freedom", modes->freedom);
  hb_json_integer(&json, "unstable", modes->unstable);
  hb_json_integer(&json, "rigid", modes->rigid);
  hb_json_integer(&json, "solves", modes->solves);
  hb_json_integer(&json, "factorisations", modes->factorisations);
  hb_json_array(&json, "modes");
  for (int k = 0; k < modes->count; k++) write_mode(&json, model, &modes->mode[k], k + 1);
  hb_json_array_end(&json);
  hb_json_text(&json, "source", model->def->source);
  hb_json_end(&json);
  return hb_file_end(&file, true, false, err);
}

/* Empty cells where a mode has no frequency. */
hb_status hb_modal_table(const char *path, const hb_model *model, const hb_modes *modes, hb_error *err) {
  hb_file file;
  hb_status status = hb_file_begin(path, &file, err);
  if (status) return status;
  fputs("mode,rod,kind,omega_squared [1/time^2],resolution [1/time^2],omega [1/time],frequency [1/time],"
        "period [time],growth_rate [1/time]\n",
        file.stream);
  for (int k = 0; k < modes->count; k++) {
    const hb_mode *mode = &modes->mode[k];
    double omega = hb_mode_omega(mode);
    fprintf(file.stream, "%d,%s,%s", k + 1, model->rods[mode->rod].name, hb_modal_kind(mode));
    cell(file.stream, mode->square);
    cell(file.stream, mode->resolution);
    if (hb_mode_kind(mode) > 0) {
      cell(file.stream, omega);
      cell(file.stream, omega / TURN);
      cell(file.stream, TURN / omega);
      fputs(",\n", file.stream);
    } else if (hb_mode_kind(mode) < 0) {
      fputs(",,,", file.stream);
      cell(file.stream, omega);
      fputc('\n', file.stream);
    } else
      fputs(",,,,\n", file.stream);
  }
  return hb_file_end(&file, true, false, err);
}

/* The turn of an edge stands in the row of its first vertex. */
hb_status hb_modal_shapes(const char *path, const hb_model *model, const double *position,
                          const hb_modes *modes, hb_error *err) {
  hb_file file;
  hb_status status = hb_file_begin(path, &file, err);
  if (status) return status;
  fputs("mode,rod,vertex,x [length],y [length],z [length],shape_x [mass^-1/2],shape_y [mass^-1/2],"
        "shape_z [mass^-1/2],turn [mass^-1/2 length^-1]\n",
        file.stream);
  for (int k = 0; k < modes->count; k++) {
    const hb_mode *mode = &modes->mode[k];
    const hb_rod *rod = &model->rods[mode->rod];
    for (int i = 0; i < rod->nv; i++) {
      fprintf(file.stream, "%d,%s,%d", k + 1, rod->name, i);
      for (int c = 0; c < 3; c++) cell(file.stream, position[3 * (rod->first + i) + c]);
      for (int c = 0; c < 3; c++) cell(file.stream, mode->shape[3 * i + c]);
      if (i + 1 < rod->nv)
        cell(file.stream, mode->turn[i]);
      else
        fputc(',', file.stream);
      fputc('\n', file.stream);
    }
  }
  return hb_file_end(&file, true, false, err);
}

/* Begins NAME in a directory. */
static hb_status begin(const char *directory, const char *name, hb_file *file, hb_error *err) {
  char *path = hb_file_join(directory, "%s", name);
  if (!path) return hb_fail_memory(err, "name of a file");
  hb_status status = hb_file_begin(path, file, err);
  hb_free(path);
  return status;
}

/* One matrix; Matrix Market counts from 1. */
static hb_status write_matrix(const char *directory, const char *name, const char *what, const hb_matrix *m,
                              hb_error *err) {
  hb_file file;
  hb_status status = begin(directory, name, &file, err);
  if (status) return status;
  fprintf(file.stream, "%%%%MatrixMarket matrix coordinate real %s\n%% %s\n%d %d %ld\n",
          m->symmetric ? "symmetric" : "general", what, m->rows, m->columns, m->entries);
  for (long k = 0; k < m->entries; k++) {
    char text[32];
    hb_number_text(m->value[k], text);
    fprintf(file.stream, "%d %d %s\n", m->row[k] + 1, m->column[k] + 1, text);
  }
  return hb_file_end(&file, true, false, err);
}

/* What the rows and columns are. */
static hb_status write_unknowns(const char *directory, const hb_model *model, const hb_matrices *m,
                                hb_error *err) {
  static const char *const names[] = {"x", "y", "z", "turn"};
  hb_file file;
  hb_status status = begin(directory, "unknowns.csv", &file, err);
  if (status) return status;
  fputs("unknown,rod,vertex_or_edge,component\n", file.stream);
  for (int k = 0; k < m->K.rows; k++) {
    const hb_rod *rod = &model->rods[model->rod_of[m->slot[k]]];
    fprintf(file.stream, "%d,%s,%d,%s\n", k + 1, rod->name, m->slot[k] - rod->first, names[m->component[k]]);
  }
  return hb_file_end(&file, true, false, err);
}

/* Four files. */
hb_status hb_modal_matrices(const char *directory, const hb_model *model, const hb_matrices *m,
                            hb_error *err) {
  hb_status status = write_matrix(directory, "M.mtx", "masses; turns of frames have none", &m->M, err);
  if (!status)
    status = write_matrix(directory, "K.mtx", "stiffness at the equilibrium, tensions included", &m->K, err);
  if (!status)
    status = write_matrix(directory, "G.mtx", "gradients of the edges' lengths: G y = 0", &m->G, err);
  return status ? status : write_unknowns(directory, model, m, err);
}
