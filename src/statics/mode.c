/* Inertia and modes: how stable an equilibrium is, and the way down from one that is not (docs/theory, 11.6).
 */
#include "statics/equilibrium.h"

#include <math.h>
#include <string.h>

/* How far, in turns of edges, an unstable equilibrium is left. */
#define ESCAPE_TURN 0.1
/* Stiffness that unbalanced forces may feign, in units of residual/(edge length * rod length). */
#define UNBALANCED 30

/* Factors with the smallest shift that makes the energy convex along the lengths; any: with the least that
 * tells neutral modes from others. Returns the shift, or a negative number if there is none. */
double hb_statics_factor(hb_statics *s, const hb_rod *rod, double start, bool any, hb_equilibrium *result) {
  double shift = start;
  for (int attempt = 0; attempt < 60; attempt++) {
    int wrong = hb_kkt_factor(&s->kkt, shift);
    result->factorisations++;
    if (wrong == 0 || (any && wrong > 0)) return shift;
    double natural = s->unit / (rod->length * rod->length);
    shift = fmax(8 * shift, 0.1 * natural);
  }
  return -1;
}

/* The softest mode, by inverse iteration with the factors as they are: s->direction. Returns its stiffness
 * per length in the metric, shift taken off. */
static double softest_mode(hb_statics *s, double shift) {
  hb_kkt *k = &s->kkt;
  double stiffness = 0, size = 0;
  for (int n = 0; n < k->matrix.n; n++) { /* no symmetry in it */
    s->direction[n] = k->weight[n] != 0 ? sin(1.0 + 0.7 * n) + 0.3 * cos(0.013 * n) : 0;
    size += k->weight[n] * s->direction[n] * s->direction[n];
  }
  for (int round = 0; round < 200; round++) {
    double product = 0, norm = 0, last = stiffness;
    for (int n = 0; n < k->matrix.n; n++) k->right[n] = k->weight[n] * s->direction[n] / sqrt(size);
    hb_kkt_solve(k);
    for (int n = 0; n < k->matrix.n; n++) {
      if (k->weight[n] == 0) k->right[n] = 0;
      product += k->weight[n] * k->right[n] * s->direction[n] / sqrt(size);
      norm += k->weight[n] * k->right[n] * k->right[n];
    }
    memcpy(s->direction, k->right, (size_t)k->matrix.n * sizeof *s->direction);
    size = norm;
    stiffness = 1 / product - shift;
    if (round > 8 && fabs(stiffness - last) <= 1e-6 * (fabs(stiffness) + shift)) break;
  }
  return stiffness;
}

/* Leaves an unstable equilibrium along its most unstable mode, to the side where the energy is lower. False:
 * neither side is lower. */
bool hb_statics_escape(hb_statics *s, const hb_rod *rod, double t, hb_equilibrium *result) {
  double shift = hb_statics_factor(s, rod, s->softest, false, result), longest, change[2];
  if (shift < 0 || softest_mode(s, shift) >= 0) return false;
  double turn = hb_statics_turn(s, rod, &longest), before = s->energy;
  hb_statics_keep(s, rod);
  for (double part = ESCAPE_TURN / turn; part * turn > 1e-5; part *= 0.25) {
    for (int side = 0; side < 2; side++) {
      if (!hb_statics_try(s, rod, t, side ? -part : part, &change[side])) change[side] = HUGE_VAL;
      hb_statics_undo(s, rod);
      s->energy = before;
    }
    bool other = change[1] < change[0];
    if (!(change[other] < 0)) continue;
    result->escapes++;
    return hb_statics_try(s, rod, t, other ? -part : part, &change[0]);
  }
  (void)hb_statics_evaluate(s, rod, t, NULL);
  return false;
}

/* An equilibrium is known up to its unbalanced forces; along a mode that costs nothing (a rod that turns
 * about its own axis) they look like a stiffness. */
void hb_statics_count_modes(hb_statics *s, const hb_rod *rod, double residual, hb_equilibrium *result,
                            int *unstable, int *neutral) {
  double shortest = rod->length;
  for (int k = rod->first; k + 1 < rod->first + rod->nv; k++)
    shortest = fmin(shortest, s->model->rest_length[k]);
  s->resolution = fmax(s->softest, UNBALANCED * residual / (shortest * rod->length));
  int below = hb_kkt_factor(&s->kkt, s->resolution), upto = hb_kkt_factor(&s->kkt, -s->resolution);
  result->factorisations += 2;
  *unstable = below > 0 ? below : 0;
  *neutral = upto > *unstable ? upto - *unstable : 0;
}
