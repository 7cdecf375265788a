/* One rod over an implicit step, in as many pieces as it takes (docs/theory, 13.6). */
#include "time/implicit.h"

#include <float.h>
#include <math.h>
#include <string.h>

/* A step is not divided further. */
#define SHORTEST 1e-6
/* Error control: what is aimed at, how fast pieces may grow and shrink. */
#define SAFETY 0.85
#define GROW 2.5
#define SHRINK 0.2

/* The smallest stiffness that counts, for turns of frames that cost no energy: (bending stiffness)/length^4,
 * and a part of it. */
static double neutral_stiffness(const hb_model *m, const hb_rod *rod) {
  double most = 0, square = rod->length * rod->length;
  for (int j = rod->first; j + 1 < rod->first + rod->nv; j++)
    most = fmax(most, m->B[3 * j] + m->B[3 * j + 2]);
  return 1e-8 * most / (square * square);
}

/* The turn of an edge that need not be mended: far below what is allowed of its length, but no less than the
 * round-off of positions makes of it. */
static double small_turn(const hb_model *m, const hb_rod *rod) {
  const hb_method_def *method = &m->def->method;
  bool relative = method->length_tolerance_kind == HB_TOLERANCE_RELATIVE;
  double shortest = rod->length;
  for (int j = rod->first; j + 1 < rod->first + rod->nv; j++) shortest = fmin(shortest, m->rest_length[j]);
  double allowed = method->length_tolerance / (relative ? 1 : shortest);
  return fmax(fmin(1e-3 * allowed, 1e-9), 32 * DBL_EPSILON * rod->length / shortest);
}

/* The next piece by its error against the one allowed. */
static double scaled(double size, double ratio, int order) {
  double factor = ratio > 0 ? SAFETY * pow(ratio, -1.0 / (order + 1)) : GROW;
  return size * fmin(fmax(factor, SHRINK), GROW);
}

/* Why a rod could not go on. */
static hb_status report(const hb_marcher *w, const hb_rod *rod, double size, hb_error *err) {
  const hb_trouble *t = &w->trouble;
  int vertex = t->vertex - rod->first;
  const char *reason = "Newton's method does not converge";
  if (t->kind == HB_TROUBLE_PLACE) return hb_fail(err, HB_ERR_NUMERIC, "%s", t->cause.text);
  if (t->kind == HB_TROUBLE_LOAD)
    return hb_fail(err, HB_ERR_NUMERIC, "rod %s: the load of vertex %d is not finite any more", rod->name,
                   vertex);
  if (t->kind == HB_TROUBLE_FOLD)
    return hb_fail(err, HB_ERR_NUMERIC, "rod %s: the rod folds back onto itself at vertex %d", rod->name,
                   vertex);
  if (t->kind == HB_TROUBLE_NONE) reason = "the error stays above error_tolerance";
  if (t->kind == HB_TROUBLE_UNSTABLE) reason = "the motion grows faster than that";
  if (t->kind == HB_TROUBLE_STUCK) reason = "Newton's method finds no way on";
  return hb_fail(
      err, HB_ERR_NUMERIC,
      "rod %s: no solution in pieces of %.3g of time: %s (t = %.9g, %d iterations, largest unbalanced "
      "force %.3g at vertex %d)",
      rod->name, size, reason, t->t, t->iterations, t->residual, vertex);
}

/* What a piece books; one that is not taken has to give it back. */
static const int books[] = {HB_S_WORK_LOADS, HB_S_WORK_SUPPORTS, HB_S_DISSIPATED};
enum { BOOKS = sizeof books / sizeof books[0] };

/* Pieces of equal length over what is left, as long as errors and Newton's method allow. */
hb_status hb_march_rod(hb_marcher *w, const hb_rod *rod, double t, double h, hb_error *err) {
  hb_stepper *s = &w->stepper;
  const hb_method_def *method = &s->model->def->method;
  double *scalar = s->state->scalar, *kept = &s->state->piece[rod->index];
  double allowed = method->error_tolerance, left = h, wanted = allowed > 0 && *kept > 0 ? *kept : h;
  int order = s->implicit->second_order ? 2 : 1;
  hb_kkt_begin(&w->kkt, s->model, rod);
  w->factored = 0;
  w->neutral = neutral_stiffness(s->model, rod);
  w->tolerance = small_turn(s->model, rod);
  while (left > 0) {
    double pieces = ceil(left / wanted * (1 - 1e-12)), error = 0;
    double size = pieces > 1 ? left / pieces : left, rest = pieces > 1 ? left - size : 0;
    w->trouble = (hb_trouble){.kind = HB_TROUBLE_NONE, .vertex = rod->first, .t = t - left};
    double booked[BOOKS];
    for (int k = 0; k < BOOKS; k++) booked[k] = scalar[books[k]];
    bool solved = hb_march_piece(w, rod, t - left, t - rest, &error);
    bool taken = solved && (error <= allowed || !(allowed > 0)); /* an error that is no number is none */
    if (solved && !taken) hb_state_copy_rod(s->model, rod, s->state, s->implicit->begin);
    for (int k = 0; !taken && k < BOOKS; k++) scalar[books[k]] = booked[k];
    scalar[taken ? HB_S_PIECES : HB_S_REJECTED]++;
    if (taken) left = rest;
    if (!solved)
      wanted = 0.5 * size;
    else if (allowed > 0)
      wanted = scaled(size, error / allowed, order);
    else
      wanted = 2 * size;
    if (!taken && !(wanted > SHORTEST * h)) return report(w, rod, size, err);
    wanted = fmin(wanted, h);
  }
  if (allowed > 0) *kept = wanted;
  return HB_OK;
}
