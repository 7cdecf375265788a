/* A cyclic tridiagonal system by elimination with a border: edges 1 .. n-1 are a chain as that of an open
 * rod, each row carries beside it a column for edge 0, which comes last. The pivot of edge 0 is then the one
 * that knows whether all frames can be turned together at no cost. */
#include "rod/twist_ring.h"

/* A pivot below this part of what it was made of says nothing. */
#define SINGULAR 1e-13

/* Entry of joint i, which couples the edges i - 1 and i (n: n - 1 and 0), or 0 where one of them is held. */
static double link_of(const hb_rod_work *w, int n, int i) {
  return w->held[i - 1] || w->held[i == n ? 0 : i] ? 0 : w->off_diagonal[i];
}

/* Bending part of the diagonal. */
static double bend_of(const hb_rod_work *w, int j, bool convex) {
  double bend = w->bending_diagonal[j];
  return convex && bend < 0 ? 0 : bend;
}

/* Sum of the bending parts of all edges that edge 0 takes along when it turns. *loose: is none of them
 * coupled to a held one? */
static double chain_of_first(const hb_rod_work *w, int n, bool convex, double shift, bool *loose) {
  double sum = bend_of(w, 0, convex) + shift;
  int j = 1, k = n - 1;
  for (; j < n && w->off_diagonal[j] != 0 && !w->held[j]; j++) sum += bend_of(w, j, convex) + shift;
  *loose = j == n || w->off_diagonal[j] == 0;
  if (j == n) return sum;
  for (; k > j && w->off_diagonal[k + 1] != 0 && !w->held[k]; k--) sum += bend_of(w, k, convex) + shift;
  *loose = *loose && w->off_diagonal[k + 1] == 0;
  return sum;
}

/* What elimination leaves of the row of edge 0. */
typedef struct border {
  double pivot, whole, right;
} border;

/* Eliminates the edges 1 .. n-1; false if one of their pivots is below `least` of its diagonal (*saddle: and
 * negative by more than round-off). */
static bool eliminate_chain(hb_rod_work *w, int n, bool convex, double shift, double noise, border *b,
                            bool *saddle) {
  bool loose = true;
  double sum = 0;
  *saddle = false;
  b->pivot = w->diagonal[0] + bend_of(w, 0, convex) + shift;
  b->whole = w->diagonal[0] + fabs(bend_of(w, 0, convex)) + shift;
  b->right = -w->gradient[0];
  for (int j = 1; j < n; j++) {
    double bend = bend_of(w, j, convex), link = link_of(w, n, j), ahead = w->off_diagonal[j + 1];
    double pivot = w->diagonal[j] + bend + shift, whole = fabs(pivot), right = -w->gradient[j];
    double corner = (j == 1 ? link : 0) + (j == n - 1 ? link_of(w, n, n) : 0);
    w->pivot[j] = w->corner[j] = w->delta[j] = 0;
    if (w->held[j]) continue;
    if (w->off_diagonal[j] == 0) sum = 0;
    loose = w->off_diagonal[j] == 0 || (loose && link != 0 && j > 1);
    sum += bend + shift;
    if (j > 1 && link != 0) {
      double ratio = link * w->pivot[j - 1];
      pivot -= ratio * link;
      right -= ratio * w->delta[j - 1];
      corner -= ratio * w->corner[j - 1];
    }
    if (loose && ahead == 0 && fabs(pivot) < HB_TWIST_SOFT * whole) {
      pivot = hb_twist_soft_pivot(sum, noise);
    } else if (!(pivot > SINGULAR * whole) || pivot == 0) {
      *saddle = pivot < -1e-8 * (w->diagonal[j] + fabs(bend));
      return false;
    }
    w->pivot[j] = 1 / pivot;
    w->corner[j] = corner;
    w->delta[j] = right;
    b->pivot -= corner * corner * w->pivot[j];
    b->right -= corner * right * w->pivot[j];
  }
  return true;
}

/* Chain, border, and back. */
bool hb_twist_solve_ring(const hb_rod *rod, hb_rod_work *w, bool convex, double shift, double noise) {
  int n = rod->nv - 1;
  border b;
  bool loose, saddle;
  w->delta[0] = 0;
  if (!eliminate_chain(w, n, convex, shift, noise, &b, &saddle)) return false;
  if (!w->held[0]) {
    double sum = chain_of_first(w, n, convex, shift, &loose);
    if (loose && fabs(b.pivot) < HB_TWIST_SOFT * b.whole)
      b.pivot = hb_twist_soft_pivot(sum, noise);
    else if (!(b.pivot > SINGULAR * b.whole) || b.pivot == 0)
      return false;
    w->delta[0] = b.right / b.pivot;
  }
  for (int j = n - 1; j > 0; j--) {
    double next = j + 1 < n ? link_of(w, n, j + 1) * w->delta[j + 1] : 0;
    w->delta[j] = (w->delta[j] - next - w->corner[j] * w->delta[0]) * w->pivot[j];
  }
  return true;
}

/* The pivots tell. */
bool hb_twist_ring_on_saddle(const hb_rod *rod, hb_rod_work *w) {
  int n = rod->nv - 1;
  border b;
  bool saddle;
  if (!eliminate_chain(w, n, false, 0, 0, &b, &saddle)) return saddle;
  return !w->held[0] && b.pivot < -1e-8 * b.whole;
}
