/* Folds and bifurcations between two points of a branch, to round-off (docs/theory, 16.6). */
#include "statics/branch.h"

#include <math.h>
#include <stdlib.h>

#define EVALUATIONS 60
/* Modes whose stiffness changes sign within this part of a step are taken for modes of one stiffness. */
#define TOGETHER 1e-5
/* A zero is found if it is known to this part of the step. */
#define FOUND 1e-13
/* Rate of the parameter at a fold, relative to its range. */
#define FLAT 1e-8
/* Stiffness at a bifurcation, as a part of what counts as none. */
#define EXACT 0.05

/* At a fold the parameter turns back and one mode changes sides; other changes are bifurcations. */
hb_branch_events hb_branch_compare(const hb_branch_point *a, const hb_branch_point *z, int before) {
  hb_branch_events found = {(a->tangent_p < 0) != (z->tangent_p < 0), z->unstable - before, false};
  if (!found.fold) return found;
  found.unclear = abs(found.change) > 1;
  found.change = 0; /* that of the fold; none at all where the branch passes a bifurcation sideways */
  return found;
}

/* An interval with a change of sign. */
typedef struct bracket {
  double low, high, f_low, f_high; /* 0: no value */
  int side;                        /* end that moved last: -1 low, 1 high */
} bracket;

/* The next place to look: by the secant, every fourth time in the middle. */
static double next_place(const bracket *k, int n) {
  double middle = 0.5 * (k->low + k->high);
  if (n % 4 == 3 || k->f_low * k->f_high >= 0) return middle;
  double secant = k->low - k->f_low * (k->high - k->low) / (k->f_high - k->f_low);
  return secant > k->low && secant < k->high ? secant : middle;
}

/* The end on that side moves; one that stays twice counts half (Dowell and Jarratt 1971). */
static void take(bracket *k, bool low, double at, double f) {
  if (low) {
    k->low = at;
    k->f_low = f;
    if (k->side < 0) k->f_high *= 0.5;
  } else {
    k->high = at;
    k->f_high = f;
    if (k->side > 0) k->f_low *= 0.5;
  }
  k->side = low ? -1 : 1;
}

/* The tangent has no part of the parameter. There the parameter is flat: it is known to the square of the
 * error of the place. */
bool hb_branch_find_fold(hb_branch *b, const hb_branch_point *a, const hb_branch_point *z, double end,
                         hb_branch_point *out) {
  bracket k = {0, end, a->tangent_p, z->tangent_p, 0};
  for (int n = 0; n < EVALUATIONS; n++) {
    double at = next_place(&k, n);
    if (!hb_branch_step(b, a, at, out)) return false;
    take(&k, (out->tangent_p < 0) == (a->tangent_p < 0), at, out->tangent_p);
    if (fabs(out->tangent_p) <= FLAT * b->range || k.high - k.low <= FLAT * end) return true;
  }
  return false;
}

/* Mean stiffness of the `count` softest modes at a point that was just finished; `rigid` motions are left
 * out. */
static double mean_stiffness(hb_branch *b, int rigid, int count, bool fresh) {
  double values[HB_BRANCH_MODES], sum = 0;
  (void)hb_kkt_factor(&b->s.kkt, b->shift);
  hb_branch_find_rigid(b, rigid);
  hb_branch_softest(b, count, fresh, values);
  for (int i = 0; i < count; i++) sum += values[i] / count;
  return sum;
}

/* Halves the interval until the modes that change in it do so together, or only one does. */
static bool separate(hb_branch *b, const hb_branch_point *a, bracket *k, int before, int *after,
                     hb_branch_point *out) {
  double least = TOGETHER * (k->high - k->low);
  while (abs(*after - before) > 1 && k->high - k->low > least) {
    double at = 0.5 * (k->low + k->high);
    if (!hb_branch_step(b, a, at, out)) return false;
    if (out->unstable == before) {
      k->low = at;
    } else {
      k->high = at;
      *after = out->unstable;
    }
  }
  return true;
}

/* Motions of the whole rod that cost nothing at a: they go on doing so. Others may, just at a bifurcation. */
static int count_rigid(hb_branch *b, const hb_branch_point *a) {
  if (hb_branch_return(b, a, NULL) || !hb_branch_factor(b)) return -1;
  hb_branch_find_rigid(b, -1);
  return b->rigid_count;
}

/* The stiffness of the modes that change: its sign is known at both ends, its value only where these modes
 * are the softest. */
bool hb_branch_find_bifurcation(hb_branch *b, const hb_branch_point *a, double start, double end, int before,
                                int after, double *at, int *multiplicity, int *left, hb_branch_point *out) {
  bracket k = {start, end, 0, 0, 0};
  double width = end - start, last = start;
  int rigid = count_rigid(b, a);
  if (rigid < 0 || !separate(b, a, &k, before, &after, out)) return false;
  int count = abs(after - before);
  *multiplicity = count;
  *left = after;
  if (count > HB_BRANCH_MODES) count = HB_BRANCH_MODES;
  for (int n = 0, tries = 0; n < EVALUATIONS; n++) {
    *at = next_place(&k, n);
    if (!hb_branch_step(b, a, *at, out)) return false;
    double f = mean_stiffness(b, rigid, count, n == 0);
    bool blurred = fabs(f) <= 4 * out->resolution, positive = f > 0, low;
    low = blurred ? positive == (after > before) : out->unstable == before;
    if (blurred && (tries++ > 0 || fabs(f) <= EXACT * out->resolution)) return true;
    if (fabs(*at - last) <= FOUND * width) return blurred;
    last = *at;
    take(&k, low, *at, low == (positive == (after > before)) ? f : 0);
    if (k.high - k.low <= FOUND * width) return true;
  }
  return false;
}
