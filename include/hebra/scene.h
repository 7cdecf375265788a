/* hebra/scene.h - scene files in YAML to definitions. */
#ifndef HEBRA_SCENE_H
#define HEBRA_SCENE_H

#include "hebra/model.h"

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

#ifdef __cplusplus
}
#endif
#endif
