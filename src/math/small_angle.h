/* Sine and cosine of small angles by their series: the same bits everywhere, no library call. */
#ifndef HB_MATH_SMALL_ANGLE_H
#define HB_MATH_SMALL_ANGLE_H

/* |a| <= 1: error below 2e-16 (first term left out: a^19/19! = 8e-18, a^20/20! = 4e-19). */
static inline void hb_small_sincos(double a, double *s, double *c) {
  double q = a * a;
  double p = 1.0 / 355687428096000.0;
  p = p * q - 1.0 / 1307674368000.0;
  p = p * q + 1.0 / 6227020800.0;
  p = p * q - 1.0 / 39916800.0;
  p = p * q + 1.0 / 362880.0;
  p = p * q - 1.0 / 5040.0;
  p = p * q + 1.0 / 120.0;
  p = p * q - 1.0 / 6.0;
  *s = a + a * (q * p);
  double r = -1.0 / 6402373705728000.0;
  r = r * q + 1.0 / 20922789888000.0;
  r = r * q - 1.0 / 87178291200.0;
  r = r * q + 1.0 / 479001600.0;
  r = r * q - 1.0 / 3628800.0;
  r = r * q + 1.0 / 40320.0;
  r = r * q - 1.0 / 720.0;
  r = r * q + 1.0 / 24.0;
  *c = 1 - q * (0.5 - q * r);
}

#endif
