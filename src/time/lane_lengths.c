/* Lengths of rods in lanes. */
#include "time/journey.h"

/* As in solve/project.c: along fixed directions lengths may have no solution. */
#define FIXED_ITERATIONS 16

/* Elimination of all strips and, in pieces, of what is left of them. */
bool hb_journey_solve(const hb_journey *j, bool rates) {
  hb_unit *u = j->u;
  hb_journey_pass(j, rates ? RATES : ELIMINATE);
  return !u->pieces || j->k->close(u->strips, u->strip_count, false, u->chain);
}

/* Which rods are done after a look at their lengths; -1 if one never will be. */
static int judge_lengths(const hb_journey *j, int iteration, const double *tolerance, double *worst) {
  hb_unit *u = j->u;
  int going = 0, limit = j->s->model->def->method.max_projections;
  if (limit > FIXED_ITERATIONS) limit = FIXED_ITERATIONS;
  for (int n = 0; n < u->rod_count; n++) {
    hb_strip *s = u->strips;
    if (!(hb_strip_get(s, s->active, 0, n) > 0)) continue;
    worst[n] = hb_journey_largest(u, AT(worst), n);
    if (worst[n] <= *tolerance) {
      hb_strip_set(s, s->active, 0, n, 0);
      if (worst[n] > u->length_error) u->length_error = worst[n];
    } else if (!(worst[n] < HUGE_VAL) || iteration >= limit) {
      return -1;
    } else {
      going++;
    }
  }
  return going;
}

/* Are two neighbouring vertices led by formulas? No correction changes the edge between them, so what one
 * leaves says nothing of its length. Tangents keep it by themselves. */
static bool leads_edges(const hb_model *m, const hb_rod *rod) {
  for (int k = rod->first_position; k < rod->first_position + rod->position_count; k++) {
    const hb_position_support *p = &m->positions[k];
    if (p->tangent || !hb_support_moves(m, p)) continue;
    const double *w = m->inv_mass + 3 * p->slot;
    if ((p->slot > rod->first && w[-3] == 0) || (p->slot + 1 < rod->first + rod->nv && w[3] == 0))
      return true;
  }
  return false;
}

/* Which are done because what a correction leaves is known to be nothing; how many are not. */
static int judge_corrections(const hb_journey *j, bool closed, double tolerance, const double *worst) {
  hb_unit *u = j->u;
  int going = 0;
  for (int n = 0; n < u->rod_count; n++) {
    hb_strip *s = u->strips;
    if (!(hb_strip_get(s, s->active, 0, n) > 0)) continue;
    u->tally[HB_S_PROJECTIONS]++;
    double left = hb_journey_largest(u, AT(left), n);
    if (closed && left <= 0.25 * tolerance && worst[n] < 1e-2 && tolerance >= 1e-12 &&
        hb_journey_full(u, n) &&
        !(j->u->moving && leads_edges(j->s->model, &j->s->model->rods[u->rods[n]]))) {
      hb_strip_set(s, s->active, 0, n, 0);
      if (left > u->length_error) u->length_error = left;
    } else {
      going++;
    }
  }
  return going;
}

/* Newton on the lengths of all rods of the unit; rods that are done wait. */
hb_outcome hb_journey_fit(const hb_journey *j) {
  hb_unit *u = j->u;
  double tolerance = j->s->model->def->method.length_tolerance, worst[HB_LANES_MAX] = {0};
  hb_journey_set(u, AT(active), 1);
  for (int iteration = 0;; iteration++) {
    bool closed = hb_journey_solve(j, false);
    int going = judge_lengths(j, iteration, &tolerance, worst);
    if (going < 0) return IRREGULAR;
    if (going == 0) return REGULAR;
    hb_journey_pass(j, SPREAD);
    for (int g = 0; g < u->strip_count; g++) j->k->join_spread(&u->strips[g], j->along);
    if (judge_corrections(j, closed, tolerance, worst) == 0) return REGULAR;
  }
}
