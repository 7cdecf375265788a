/* Rods as tubes. */
#include "cli/cast.h"

#include "base/memory.h"

/* Colours that differ in hue and in lightness, in the order of the rods. */
static const double palette[][3] = {{0.15, 0.44, 0.53}, {0.79, 0.35, 0.27}, {0.36, 0.33, 0.62},
                                    {0.85, 0.62, 0.22}, {0.31, 0.50, 0.30}, {0.58, 0.29, 0.45},
                                    {0.33, 0.58, 0.68}, {0.55, 0.40, 0.28}};
enum { COLORS = sizeof palette / sizeof palette[0] };

/* Room for the rods and one frame of nv slots. */
static hb_status create(int rods, int nv, cli_cast *cast, hb_error *err) {
  *cast = (cli_cast){.count = rods};
  cast->tubes = hb_alloc((size_t)rods, sizeof *cast->tubes);
  cast->first = hb_alloc((size_t)rods, sizeof *cast->first);
  cast->xyz = hb_alloc((size_t)nv, 3 * sizeof(double));
  cast->m1 = hb_alloc((size_t)nv, 3 * sizeof(double));
  if (cast->tubes && cast->first && cast->xyz && cast->m1) return HB_OK;
  cli_cast_free(cast);
  return hb_fail_memory(err, "rods to draw");
}

/* One rod. */
static void enter(cli_cast *cast, int index, int first, int nv, double radius) {
  hb_tube *tube = &cast->tubes[index];
  *tube = (hb_tube){.nv = nv, .radius = radius};
  for (int k = 0; k < 3; k++) tube->color[k] = palette[index % COLORS][k];
  cast->first[index] = first;
}

/* From a trajectory. */
hb_status cli_cast_from_reader(const hb_trajectory_info *info, cli_cast *cast, hb_error *err) {
  hb_status status = create(info->rod_count, info->nv, cast, err);
  if (status != HB_OK) return status;
  for (int i = 0; i < info->rod_count; i++)
    enter(cast, i, info->rods[i].first, info->rods[i].nv, info->rods[i].radius);
  cli_cast_show(cast, cast->xyz, cast->m1);
  return HB_OK;
}

/* From a model that is going to run. */
hb_status cli_cast_from_model(const hb_model *model, cli_cast *cast, hb_error *err) {
  hb_status status = create(model->rod_count, model->nv, cast, err);
  if (status != HB_OK) return status;
  for (int i = 0; i < model->rod_count; i++)
    enter(cast, i, model->rods[i].first, model->rods[i].nv, model->def->rods[i].radius);
  cli_cast_show(cast, model->initial, NULL);
  return HB_OK;
}

/* Frees the arrays. */
void cli_cast_free(cli_cast *cast) {
  hb_free(cast->tubes);
  hb_free(cast->first);
  hb_free(cast->xyz);
  hb_free(cast->m1);
  *cast = (cli_cast){0};
}

/* Every rod's part of the common arrays. */
void cli_cast_show(cli_cast *cast, const double *xyz, const double *m1) {
  for (int i = 0; i < cast->count; i++) {
    size_t at = 3 * (size_t)cast->first[i];
    cast->tubes[i].xyz = xyz + at;
    cast->tubes[i].m1 = m1 ? m1 + at : NULL;
  }
}

/* Positions and directors of one frame. */
hb_status cli_cast_read(cli_cast *cast, hb_reader *reader, long frame, hb_error *err) {
  hb_status status = hb_reader_field(reader, "position", frame, cast->xyz, err);
  if (status == HB_OK) status = hb_reader_field(reader, "m1", frame, cast->m1, err);
  if (status == HB_OK) cli_cast_show(cast, cast->xyz, cast->m1);
  return status;
}
