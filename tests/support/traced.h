/* A scene of scenes/trace, traced: for tests of branches. */
#ifndef HB_TEST_TRACED_H
#define HB_TEST_TRACED_H

#include "hebra/hebra.h"
#include "support/near.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { TRACED_POINTS = 4000, TRACED_BRANCHES = 16 };

/* What is kept of a point. */
typedef struct traced_point {
  hb_trace_kind kind;
  int branch, unstable, neutral, multiplicity;
  double parameter, arc, residual, energy;
  double force[3];          /* of the supports in the first half of the rod */
  double first[3], last[3]; /* vertices */
  double middle[3];
  double farthest; /* of a vertex from the line between the first and the last, at most */
} traced_point;

typedef struct traced {
  hb_scene_def def;
  traced_point *points;
  int count;
  hb_trace_end ends[TRACED_BRANCHES];
  char reasons[TRACED_BRANCHES][200];
  int end_count;
  hb_trace_costs costs;
  void (*also)(void *context, const hb_trace_point *point, const hb_frame *frame); /* NULL: nothing */
  void *context;
} traced;

/* Measures and keeps. */
static hb_status traced_take(void *context, const hb_trace_point *p, hb_error *err) {
  traced *t = context;
  hb_frame *frame = NULL;
  const hb_model *m = hb_sim_model(p->sim);
  hb_status status = hb_frame_create(m, &frame, err);
  if (status) return status;
  hb_sim_measure_equilibrium(p->sim, &p->found, frame);
  assert_true(t->count < TRACED_POINTS);
  traced_point *to = &t->points[t->count++];
  *to = (traced_point){.kind = p->kind,
                       .branch = p->branch,
                       .unstable = p->found.unstable,
                       .neutral = p->found.neutral,
                       .multiplicity = p->multiplicity,
                       .parameter = p->parameter,
                       .arc = p->arc,
                       .residual = p->found.residual / p->found.force_scale,
                       .energy = frame->bending + frame->twisting};
  for (int k = 0; k < m->nv / 2; k++)
    for (int c = 0; c < 3; c++) to->force[c] += frame->reaction[3 * k + c];
  memcpy(to->first, frame->position, sizeof to->first);
  memcpy(to->last, frame->position + 3 * (m->nv - 1), sizeof to->last);
  memcpy(to->middle, frame->position + 3 * (m->nv / 2), sizeof to->middle);
  if (t->also) t->also(t->context, p, frame);
  hb_frame_free(frame);
  return HB_OK;
}

/* Keeps how a branch ended. */
static hb_status traced_close(void *context, const hb_trace_end *end, hb_error *err) {
  traced *t = context;
  (void)err;
  assert_true(t->end_count < TRACED_BRANCHES);
  snprintf(t->reasons[t->end_count], sizeof t->reasons[0], "%s", end->reason);
  t->ends[t->end_count++] = *end;
  if (getenv("HEBRA_TEST_VERBOSE"))
    printf("branch %d: %ld points, %s (%d)\n", end->branch, end->points, end->reason, (int)end->failed);
  return HB_OK;
}

/* Traces the scene, of scenes/NAME.yaml or the text itself where it has a line break; overrides end with
 * NULL. Ends the test if anything fails. */
static inline void traced_begin(traced *t, const char *name, ...) {
  char path[500], texts[8][80];
  const char *overrides[8], *next;
  int count = 0;
  hb_error err = {HB_OK, ""};
  va_list args;
  va_start(args, name);
  while ((next = va_arg(args, const char *))) {
    snprintf(texts[count], sizeof texts[count], "%s", next);
    overrides[count] = texts[count];
    count++;
  }
  va_end(args);
  t->points = calloc(TRACED_POINTS, sizeof *t->points);
  snprintf(path, sizeof path, "%s/scenes/%s.yaml", HEBRA_SOURCE_DIR, name);
  if (strchr(name, '\n') ? hb_scene_parse(name, strlen(name), "text", ".", overrides, count, &t->def, &err)
                         : hb_scene_read(path, overrides, count, &t->def, &err))
    fail_msg("%s", err.text);
  const hb_trace_def *d = &t->def.trace;
  hb_scene_range range = {&t->def, d->parameter, t->def.method.duration};
  hb_trace_family family = hb_scene_family(&range);
  hb_trace_options options = {d->from, d->to, d->step, d->points, d->branches, false};
  hb_trace_sink sink = {traced_take, traced_close, t};
  if (hb_trace(&family, &options, &sink, &t->costs, &err)) fail_msg("%s: %s", name, err.text);
  if (getenv("HEBRA_TEST_VERBOSE"))
    printf("%ld points, %ld iterations, %ld factorisations, %ld scenes\n", t->costs.points,
           t->costs.iterations, t->costs.factorisations, t->costs.scenes);
}

/* Frees it. */
static inline void traced_end(traced *t) {
  hb_scene_def_free(&t->def);
  free(t->points);
  t->points = NULL;
  t->count = t->end_count = 0;
}

/* "key=value" for a number; buffer of at least 80. */
static inline const char *traced_set(char *buffer, const char *key, double value) {
  snprintf(buffer, 80, "%s=%.17g", key, value);
  return buffer;
}

/* Number `which` (from 0) of a kind on a branch; ends the test if there is none. */
static inline const traced_point *traced_find(const traced *t, int branch, hb_trace_kind kind, int which) {
  for (int k = 0; k < t->count; k++)
    if (t->points[k].branch == branch && t->points[k].kind == kind && which-- == 0) return &t->points[k];
  fail_msg("there is no such %s on branch %d", hb_trace_kind_name(kind), branch);
  return NULL;
}

/* How many of a kind there are on a branch. */
static inline int traced_count(const traced *t, int branch, hb_trace_kind kind) {
  int count = 0;
  for (int k = 0; k < t->count; k++) count += t->points[k].branch == branch && t->points[k].kind == kind;
  return count;
}

#endif
