/* Rods as tubes. */
#include "cli/cast.h"

#include "base/memory.h"

#include <math.h>
#include <string.h>

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
  cast->tubes[index] = (hb_tube){.nv = nv, .radius = radius};
  cast->first[index] = first;
}

/* Length of the part of a name that the copies of a rod share: "hair" of "hair-37"; 0 if it is no copy's
 * name. */
static size_t stem(const char *name) {
  const char *dash = strrchr(name, '-');
  return dash && dash[1] && strspn(dash + 1, "0123456789") == strlen(dash + 1) ? (size_t)(dash - name) : 0;
}

/* Number in 0..1 that looks like chance. */
static double chance(uint32_t n) {
  n = (n ^ 61u ^ n >> 16) * 9u;
  n = (n ^ n >> 4) * 0x27d4eb2du;
  return (n ^ n >> 15) / 4294967296.0;
}

/* One of many copies: lighter or darker, a little warmer or colder than the others. */
static void vary(double color[3], int copy) {
  double light = 0.72 + 0.56 * chance(2u * (uint32_t)copy),
         warm = 0.12 * chance(2u * (uint32_t)copy + 1) - 0.06;
  for (int k = 0; k < 3; k++) color[k] = fmin(fmax(color[k] * light * (1 + warm * (1 - k)), 0), 1);
}

/* A colour for every rod; copies of one rod, if there are more of them than colours, share one and vary.
 * color: in place of the palette, or NULL. */
static void paint(cli_cast *cast, const char *(*name_of)(const void *, int), const void *from,
                  const double *color) {
  for (int i = 0, next = 0; i < cast->count; next++) {
    const char *name = name_of(from, i);
    size_t length = stem(name);
    int end = i + 1;
    while (length > 0 && end < cast->count && stem(name_of(from, end)) == length &&
           strncmp(name, name_of(from, end), length) == 0)
      end++;
    bool many = end - i > COLORS;
    if (!many) end = i + 1;
    for (int copy = 0; i < end; i++, copy++) {
      for (int k = 0; k < 3; k++) cast->tubes[i].color[k] = color ? color[k] : palette[next % COLORS][k];
      if (many) vary(cast->tubes[i].color, copy);
    }
  }
}

/* Name of a rod of a trajectory. */
static const char *name_in_file(const void *info, int rod) {
  return ((const hb_trajectory_info *)info)->rods[rod].name;
}

/* Name of a rod of a model. */
static const char *name_in_model(const void *model, int rod) {
  return ((const hb_model *)model)->rods[rod].name;
}

/* From a trajectory. */
hb_status cli_cast_from_reader(const hb_trajectory_info *info, const double *color, cli_cast *cast,
                               hb_error *err) {
  hb_status status = create(info->rod_count, info->nv, cast, err);
  if (status != HB_OK) return status;
  for (int i = 0; i < info->rod_count; i++)
    enter(cast, i, info->rods[i].first, info->rods[i].nv, info->rods[i].radius);
  paint(cast, name_in_file, info, color);
  cli_cast_show(cast, cast->xyz, cast->m1);
  return HB_OK;
}

/* From a model that is going to run. */
hb_status cli_cast_from_model(const hb_model *model, cli_cast *cast, hb_error *err) {
  hb_status status = create(model->rod_count, model->nv, cast, err);
  if (status != HB_OK) return status;
  for (int i = 0; i < model->rod_count; i++)
    enter(cast, i, model->rods[i].first, model->rods[i].nv, model->def->rods[i].radius);
  paint(cast, name_in_model, model, NULL);
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
  bool directors = hb_reader_fields(reader) & HB_FIELD_BIT(m1);
  if (status == HB_OK && directors) status = hb_reader_field(reader, "m1", frame, cast->m1, err);
  if (status == HB_OK) cli_cast_show(cast, cast->xyz, directors ? cast->m1 : NULL);
  return status;
}
