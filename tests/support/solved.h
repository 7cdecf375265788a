/* A scene of scenes/statics, solved: for tests of statics. */
#ifndef HB_TEST_SOLVED_H
#define HB_TEST_SOLVED_H

#include "hebra/hebra.h"
#include "support/near.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

typedef struct solved {
  hb_scene_def def;
  hb_model *model;
  hb_sim *sim;
  hb_frame *frame;
  hb_equilibrium found;
} solved;

/* Reads scenes/statics/NAME.yaml with the overrides (each "key=value", the last one NULL) and looks for its
 * equilibrium at the end of the scene. Ends the test with the sentence if anything fails. */
static inline void solved_begin(solved *s, const char *name, int any, ...) {
  char path[500], texts[8][80];
  const char *overrides[8], *next;
  int count = 0;
  hb_error err = {HB_OK, ""};
  va_list args;
  va_start(args, any);
  while ((next = va_arg(args, const char *))) {
    snprintf(texts[count], sizeof texts[count], "%s", next);
    overrides[count] = texts[count];
    count++;
  }
  va_end(args);
  memset(s, 0, sizeof *s);
  snprintf(path, sizeof path, "%s/scenes/statics/%s.yaml", HEBRA_SOURCE_DIR, name);
  if (hb_scene_read(path, overrides, count, &s->def, &err)) fail_msg("%s", err.text);
  if (hb_model_create(&s->def, &s->model, &err)) fail_msg("%s", err.text);
  if (hb_sim_create(s->model, &s->sim, &err)) fail_msg("%s", err.text);
  if (hb_frame_create(s->model, &s->frame, &err)) fail_msg("%s", err.text);
  hb_equilibrium_options options = hb_equilibrium_defaults(s->def.method.duration);
  options.any = any;
  if (hb_sim_find_equilibrium(s->sim, &options, &s->found, &err)) fail_msg("%s: %s", name, err.text);
  hb_sim_measure_equilibrium(s->sim, &s->found, s->frame);
}

/* Frees it. */
static inline void solved_end(solved *s) {
  hb_equilibrium_free(&s->found);
  hb_frame_free(s->frame);
  hb_sim_free(s->sim);
  hb_model_free(s->model);
  hb_scene_def_free(&s->def);
}

/* "key=value" for a number; buffer of at least 80. */
static inline const char *solved_set(char *buffer, const char *key, double value) {
  snprintf(buffer, 80, "%s=%.17g", key, value);
  return buffer;
}

/* Coordinate c of the last vertex. */
static inline double solved_tip(const solved *s, int c) {
  return s->frame->position[3 * (s->model->nv - 1) + c];
}

/* Force of the supports of both vertices of the last edge, or of the first. */
static inline double solved_clamp_force(const solved *s, bool last, int c) {
  int k = last ? s->model->nv - 2 : 0;
  return s->frame->reaction[3 * k + c] + s->frame->reaction[3 * k + 3 + c];
}

#endif
