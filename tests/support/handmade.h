/* A model and frames made by hand, so that files can be tested without a simulation: two rods of 5 and 4
 * vertices, and frames in which every number tells its field, row, component and frame. */
#ifndef HB_TEST_HANDMADE_H
#define HB_TEST_HANDMADE_H

#include "hebra/output.h"

#include <stdio.h>
#include <string.h>

typedef struct handmade {
  hb_scene_def def;
  hb_rod_def rod_defs[2];
  hb_model model;
  hb_rod rods[2];
  double arc[9];
} handmade;

/* Fills the struct; nothing to free. It must not be moved afterwards. */
static inline void handmade_fill(handmade *h) {
  static char title[] = "Two \"rods\"\n\xce\xb1\\\xce\xb2", source[] = "title: two rods\nrods: []\n",
              path[] = "dir/two.yaml";
  static char first[] = "lower", second[] = "upper rod";
  memset(h, 0, sizeof *h);
  h->def.title = title;
  h->def.source = source;
  h->def.path = path;
  h->def.rods = h->rod_defs;
  h->def.rod_count = 2;
  h->def.method.time_step = 0.25;
  h->rod_defs[0].name = first;
  h->rod_defs[0].nv = 5;
  h->rod_defs[0].radius = 0.5;
  h->rod_defs[1].name = second;
  h->rod_defs[1].nv = 4;
  h->rod_defs[1].radius = 0.125;
  h->rods[0] = (hb_rod){.name = first, .index = 0, .first = 0, .nv = 5, .length = 4};
  h->rods[1] = (hb_rod){.name = second, .index = 1, .first = 5, .nv = 4, .length = 3};
  for (int i = 0; i < 9; i++) h->arc[i] = i < 5 ? i : i - 5;
  h->model.def = &h->def;
  h->model.rod_count = 2;
  h->model.nv = 9;
  h->model.rods = h->rods;
  h->model.arc = h->arc;
}

/* True for the last vertex of a rod, which holds no edge. */
static inline bool handmade_no_edge(int slot) { return slot == 4 || slot == 8; }

/* The number that stands in a frame. */
static inline double handmade_number(int field, int slot, int component, long frame) {
  if (hb_frame_fields[field].location == HB_ON_EDGE && handmade_no_edge(slot)) return 0;
  return (double)frame * 1000 + field + 0.01 * slot + 0.001 * component + 1e-17 * (double)(frame + 1);
}

/* Fills a frame made by hb_frame_create. */
static inline void handmade_frame(hb_frame *frame, long number) {
  for (int k = 0; k < hb_frame_field_count; k++) {
    double *values = NULL;
    memcpy(&values, (char *)frame + hb_frame_fields[k].offset, sizeof values);
    int c = hb_frame_fields[k].components;
    for (int i = 0; i < 9; i++)
      for (int j = 0; j < c; j++) values[i * c + j] = handmade_number(k, i, j, number);
  }
  double base = (double)number;
  frame->time = 0.25 * base;
  frame->step = 10 * number;
  frame->kinetic = base + 0.1;
  frame->bending = base + 0.2;
  frame->twisting = base + 0.3;
  frame->gravity = base + 0.4;
  frame->work_loads = base + 0.5;
  frame->work_supports = base + 0.6;
  frame->dissipated = base + 0.7;
  frame->balance = base * 1e-9;
  for (int j = 0; j < 3; j++) {
    frame->momentum[j] = base + 0.01 * j;
    frame->angular_momentum[j] = base + 0.03 * j;
  }
  frame->length_error = 1e-12 * base;
  frame->worst_length_error = 2e-12 * base;
}

#endif
