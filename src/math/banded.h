/* Symmetric banded matrices: L D L^T without exchange of rows, and the inertia that its pivots tell.
 *
 * Without exchange the band stays as it is, and by Sylvester's law the numbers of positive and negative
 * pivots are those of the eigenvalues. The price is that no leading block may be singular: the caller's
 * matrices must be definite, or saddle-point matrices that are made safe by an added multiple of the
 * constraints (docs/theory, 11.4). */
#ifndef HB_MATH_BANDED_H
#define HB_MATH_BANDED_H

#include <stdbool.h>
#include <stddef.h>

/* Entry (j + k, j), 0 <= k <= half, is at a[(half + 1) j + k]: columns of the lower half, one behind the
 * other. There is room for `half` columns more than n: elimination may write past the end without asking. */
typedef struct hb_band {
  int n, half;
  double *a;
} hb_band;

/* Doubles that a has to hold. */
size_t hb_band_size(int n, int half);
/* All entries 0. */
void hb_band_clear(hb_band *m);
/* out = M v; n doubles each, not the same. */
void hb_band_multiply(const hb_band *m, const double *v, double *out);

/* Adds to the entry of row and column, row >= column, row - column <= half. */
static inline void hb_band_add(hb_band *m, int row, int column, double value) {
  m->a[(size_t)(m->half + 1) * (size_t)column + (size_t)(row - column)] += value;
}

/* What the pivots tell. */
typedef struct hb_inertia {
  int positive, negative;
  int dropped;   /* pivots that were nothing but round-off: their unknowns are kept at 0 */
  double growth; /* largest of (sum of what a pivot is made of)/|pivot|: digits that the factors lost */
} hb_inertia;

/* Replaces M by its factors: D on the diagonal (1/pivot; 0 where dropped), L below. scratch: n + half
 * doubles. A pivot below `round_off` of what it is the sum of is dropped. */
hb_inertia hb_band_factor(hb_band *m, double round_off, double *scratch);
/* Solves with the factors; b becomes the answer. b has room for n + half doubles. */
void hb_band_solve(const hb_band *factors, double *b);

#endif
