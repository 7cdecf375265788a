/* A small real simulation built in C: one rod of 6 vertices, held and turned at its first end, in gravity. */
#ifndef HB_TEST_SMALLSIM_H
#define HB_TEST_SMALLSIM_H

#include "hebra/hebra.h"

#include <string.h>

typedef struct smallsim {
  hb_scene_def def;
  hb_rod_def rod;
  hb_force_def gravity;
  hb_support_def supports[2];
  double rest[18], mass[6], B[15], beta[6];
  hb_model *model;
  hb_sim *sim;
} smallsim;

/* Builds everything; false (with a sentence) if the library refuses. The struct must not be moved afterwards.
 */
static inline bool smallsim_make(smallsim *s, hb_error *err) {
  static char name[] = "whip", title[] = "A small rod", source[] = "title: A small rod\n",
              path[] = "scenes/small.yaml";
  memset(s, 0, sizeof *s);
  hb_scene_def_init(&s->def);
  hb_rod_def_init(&s->rod);
  hb_force_def_init(&s->gravity);
  for (int i = 0; i < 6; i++) {
    s->rest[3 * i] = 0.2 * i;
    s->mass[i] = 0.1;
    s->beta[i] = 0.5;
    if (i < 5) s->B[3 * i] = s->B[3 * i + 2] = 0.75;
  }
  s->def.title = title;
  s->def.source = source;
  s->def.path = path;
  s->def.rods = &s->rod;
  s->def.rod_count = 1;
  s->def.forces = &s->gravity;
  s->def.force_count = 1;
  s->def.method.time_step = 1e-3;
  s->def.method.duration = 0.05;
  s->rod.name = name;
  s->rod.nv = 6;
  s->rod.rest = s->rest;
  s->rod.initial = s->rest;
  s->rod.mass = s->mass;
  s->rod.B = s->B;
  s->rod.beta = s->beta;
  s->rod.radius = 0.01;
  s->rod.supports = s->supports;
  s->rod.support_count = 2;
  hb_support_def_init(&s->supports[0]);
  hb_support_def_init(&s->supports[1]);
  s->supports[0].kind = HB_SUPPORT_POSITION;
  s->supports[0].held = true;
  s->supports[1].kind = HB_SUPPORT_ANGLE;
  s->gravity.kind = HB_FORCE_GRAVITY;
  s->gravity.rod = -1;
  bool good = hb_formula_parse("3*t", HB_VARS_TIME, NULL, 0, &s->supports[1].angle, err) == HB_OK;
  for (int j = 0; good && j < 3; j++)
    good = hb_formula_constant(j == 2 ? -9.81 : 0, &s->gravity.value[j], err) == HB_OK;
  good = good && hb_model_create(&s->def, &s->model, err) == HB_OK;
  return good && hb_sim_create(s->model, &s->sim, err) == HB_OK;
}

/* Frees what smallsim_make made, also when it failed. */
static inline void smallsim_free(smallsim *s) {
  hb_sim_free(s->sim);
  hb_model_free(s->model);
  hb_formula_free(s->supports[1].angle);
  for (int j = 0; j < 3; j++) hb_formula_free(s->gravity.value[j]);
}

#endif
