/* hebra/scene.h - scene files in YAML to definitions. */
#ifndef HEBRA_SCENE_H
#define HEBRA_SCENE_H

#include "hebra/model.h"
#include "hebra/trace.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Reads path, applies overrides ("method.time_step=1e-4", "rods[0].bending=2", "rods.NAME.twisting=3"), fills
 * *def (initialised by the call). Errors: "file:line:column: key: sentence, value found, what is allowed". */
hb_status hb_scene_read(const char *path, const char *const *overrides, int override_count, hb_scene_def *def,
                        hb_error *err);
/* The same from text in memory; name stands for the file in messages. base_dir resolves relative paths. */
hb_status hb_scene_parse(const char *text, size_t length, const char *name, const char *base_dir,
                         const char *const *overrides, int override_count, hb_scene_def *def, hb_error *err);

/* The scene of def once more with another value of one of its parameters ("t": as it is), read from
 * def->source; *out is initialised by the call. */
hb_status hb_scene_vary(const hb_scene_def *def, const char *parameter, double value, hb_scene_def *out,
                        hb_error *err);
/* All scenes that differ from def in the value of one parameter; "t": in the time at which loads and supports
 * are taken, which is `time` else. To be given to hb_trace; range must outlive it. */
typedef struct hb_scene_range {
  const hb_scene_def *def;
  const char *parameter;
  double time;
} hb_scene_range;
hb_trace_family hb_scene_family(hb_scene_range *range);

#ifdef __cplusplus
}
#endif
#endif
