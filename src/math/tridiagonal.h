/* Eigenvalues and eigenvectors of symmetric tridiagonal matrices. */
#ifndef HB_MATH_TRIDIAGONAL_H
#define HB_MATH_TRIDIAGONAL_H

#include <stdbool.h>

/* diagonal: n entries; beside: n - 1, entry k stands between k and k + 1. On return diagonal holds the
 * eigenvalues, in no order, and Q (rows x n, row by row) what it was times the matrix whose columns are the
 * unit eigenvectors: from the identity these themselves, from one row of it that row of them. False: no
 * convergence, which only not-a-numbers bring about. */
bool hb_tridiagonal_eigen(int n, double *diagonal, double *beside, int rows, double *Q);

#endif
