/* Table and report of a trace. */
#include "output/branches.h"

#include "output/file.h"
#include "output/json.h"

#include <math.h>

/* Names of the measures, in their order. */
static const char *measure_name(int k) {
  static const char *const names[] = {
#define HB_NAME(name, text) #name,
      HB_BRANCH_MEASURES(HB_NAME)
#undef HB_NAME
  };
  return names[k];
}

/* Sums over one half of the rod. */
static void sum_supports(const hb_rod *rod, const hb_frame *frame, bool second, double force[3],
                         double *torque) {
  int middle = rod->nv / 2;
  for (int i = second ? middle : 0; i < (second ? rod->nv : middle); i++) {
    int k = rod->first + i;
    for (int c = 0; c < 3; c++) force[c] += frame->reaction[3 * k + c];
    *torque += frame->torque[k];
  }
}

/* Numbers of a diagram. */
void hb_branch_measure(const hb_trace_point *point, const hb_model *model, const hb_frame *frame,
                       const double *first, hb_branch_row *row) {
  const hb_rod *rod = &model->rods[0];
  const double *x = frame->position, *last = x + 3 * (rod->nv - 1), *middle = x + 3 * (rod->nv / 2);
  double *m = row->measure;
  *row = (hb_branch_row){.branch = point->branch,
                         .index = point->index,
                         .kind = point->kind,
                         .bifurcation = point->bifurcation,
                         .multiplicity = point->multiplicity,
                         .unstable = point->found.unstable,
                         .neutral = point->found.neutral,
                         .parameter = point->parameter,
                         .arc = point->arc,
                         .residual = point->found.residual / point->found.force_scale};
  for (int k = 0; k < rod->nv; k++) {
    const double *a = x + 3 * k, *b = first + 3 * k;
    m[HB_MEASURE_amplitude] =
        fmax(m[HB_MEASURE_amplitude], hypot(hypot(a[0] - b[0], a[1] - b[1]), a[2] - b[2]));
  }
  m[HB_MEASURE_distance] = hypot(hypot(last[0] - x[0], last[1] - x[1]), last[2] - x[2]);
  m[HB_MEASURE_energy] = frame->bending + frame->twisting + frame->stretching;
  m[HB_MEASURE_energy_bending] = frame->bending;
  m[HB_MEASURE_energy_twisting] = frame->twisting;
  sum_supports(rod, frame, false, m + HB_MEASURE_start_force_x, m + HB_MEASURE_start_torque);
  sum_supports(rod, frame, true, m + HB_MEASURE_end_force_x, m + HB_MEASURE_end_torque);
  m[HB_MEASURE_tension] = frame->tension[rod->nv / 2];
  m[HB_MEASURE_moment] = frame->twisting_moment[rod->nv / 2];
  for (int c = 0; c < 3; c++) {
    m[HB_MEASURE_middle_x + c] = middle[c];
    m[HB_MEASURE_end_x + c] = last[c];
  }
}

/* One line per point. */
hb_status hb_branches_table(const char *path, const hb_branches *all, hb_error *err) {
  hb_file file;
  char text[32];
  hb_status status = hb_file_begin(path, &file, err);
  if (status) return status;
  fprintf(file.stream,
          "branch,index,kind,bifurcation,multiplicity,unstable,neutral,parameter,arc,unbalanced");
  for (int k = 0; k < HB_MEASURE_COUNT; k++) fprintf(file.stream, ",%s", measure_name(k));
  fputc('\n', file.stream);
  for (long n = 0; n < all->row_count; n++) {
    const hb_branch_row *row = &all->rows[n];
    const double numbers[] = {row->parameter, row->arc, row->residual};
    fprintf(file.stream, "%d,%ld,%s,%d,%d,%d,%d", row->branch, row->index, hb_trace_kind_name(row->kind),
            row->bifurcation, row->multiplicity, row->unstable, row->neutral);
    for (int k = 0; k < 3 + HB_MEASURE_COUNT; k++) {
      hb_number_text(k < 3 ? numbers[k] : row->measure[k - 3], text);
      fprintf(file.stream, ",%s", text);
    }
    fputc('\n', file.stream);
  }
  return hb_file_end(&file, true, false, err);
}

/* Folds and bifurcations. */
static void events(hb_json *json, const hb_branches *all) {
  hb_json_array(json, "events");
  for (long n = 0; n < all->row_count; n++) {
    const hb_branch_row *row = &all->rows[n];
    if (row->kind != HB_TRACE_FOLD && row->kind != HB_TRACE_BIFURCATION) continue;
    hb_json_object(json, NULL);
    hb_json_text(json, "kind", hb_trace_kind_name(row->kind));
    hb_json_integer(json, "branch", row->branch);
    hb_json_integer(json, "point", row->index);
    hb_json_number(json, "parameter", row->parameter);
    if (row->kind == HB_TRACE_BIFURCATION) {
      hb_json_integer(json, "bifurcation", row->bifurcation);
      hb_json_integer(json, "multiplicity", row->multiplicity);
    }
    for (int k = 0; k < 3; k++) hb_json_number(json, measure_name(k), row->measure[k]);
    hb_json_object_end(json);
  }
  hb_json_array_end(json);
}

/* How the branches went. */
static void branches(hb_json *json, const hb_branches *all) {
  char file[64];
  hb_json_array(json, "branches");
  for (int k = 0; k < all->end_count; k++) {
    const hb_branch_end *end = &all->ends[k];
    hb_json_object(json, NULL);
    hb_json_integer(json, "branch", k);
    if (end->bifurcation >= 0) {
      hb_json_integer(json, "from_bifurcation", end->bifurcation);
      hb_json_integer(json, "side", end->side);
    }
    hb_json_integer(json, "points", end->points);
    snprintf(file, sizeof file, "branch-%d.h5", k);
    hb_json_text(json, "trajectory", end->points > 0 ? file : NULL);
    hb_json_bool(json, "failed", end->failed);
    hb_json_text(json, "end", end->reason);
    hb_json_object_end(json);
  }
  hb_json_array_end(json);
}

/* Whole or not at all. */
hb_status hb_branches_report(const char *path, const hb_branches *all, hb_error *err) {
  hb_file file;
  hb_json json;
  const hb_scene_def *def = all->model->def;
  hb_status status = hb_file_begin(path, &file, err);
  if (status) return status;
  hb_json_begin(&json, file.stream);
  hb_json_text(&json, "title", def->title ? def->title : "");
  hb_json_text(&json, "program", "hebra");
  hb_json_text(&json, "version", HB_VERSION);
  hb_json_text(&json, "scene_file", def->path);
  hb_json_text(&json, "parameter", all->parameter);
  hb_json_number(&json, "from", all->from);
  hb_json_number(&json, "to", all->to);
  hb_json_number(&json, "time", all->time);
  hb_json_number(&json, "wall_seconds", all->wall_seconds);
  hb_json_integer(&json, "points", all->costs->points);
  hb_json_integer(&json, "iterations", all->costs->iterations);
  hb_json_integer(&json, "factorisations", all->costs->factorisations);
  hb_json_integer(&json, "scenes", all->costs->scenes);
  branches(&json, all);
  events(&json, all);
  hb_json_text(&json, "source", def->source);
  hb_json_end(&json);
  return hb_file_end(&file, true, false, err);
}
