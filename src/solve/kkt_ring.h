/* The linear system of a closed rod: a band with a border (docs/theory, 12.6). */
#ifndef HB_SOLVE_KKT_RING_H
#define HB_SOLVE_KKT_RING_H

#include "solve/kkt.h"

/* Factors; returns the number of negative pivots. */
int hb_kkt_ring_factor(hb_kkt *kkt, double shift);
/* As hb_kkt_solve. */
void hb_kkt_ring_solve(hb_kkt *kkt);
/* As hb_kkt_multiply. */
void hb_kkt_ring_multiply(const hb_kkt *kkt, const double *v, double *out);

#endif
