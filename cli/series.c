/* What becomes of a quantity over time: values, passages, frequencies. */
#include "cli/probe.h"

#include <math.h>

#define PI 3.14159265358979323846

/* The cubic through four neighbouring samples (fewer at the ends of a short series) at a time between samples
 * k and k + 1. */
static double between(const cli_series *s, long k, double time) {
  long from = k - 1 < 0 ? 0 : k - 1, to = k + 2 > s->count - 1 ? s->count - 1 : k + 2;
  if (to - from < 3 && from > 0) from = to - 3 < 0 ? 0 : to - 3;
  if (to - from < 3) to = from + 3 > s->count - 1 ? s->count - 1 : from + 3;
  double sum = 0;
  for (long i = from; i <= to; i++) {
    double weight = 1;
    for (long j = from; j <= to; j++)
      if (j != i) weight *= (time - s->times[j]) / (s->times[i] - s->times[j]);
    sum += weight * s->values[i];
  }
  return sum;
}

/* Between samples. */
double cli_series_at(const cli_series *s, double time) {
  double slack = s->count > 1 ? 1e-6 * (s->times[1] - s->times[0]) : 1e-12;
  if (s->count < 1 || !(time >= s->times[0] - slack && time <= s->times[s->count - 1] + slack))
    return (double)NAN;
  if (s->count == 1) return s->values[0];
  long k = 0;
  while (k < s->count - 2 && s->times[k + 1] <= time) k++;
  for (long i = k; i <= k + 1; i++)
    if (fabs(s->times[i] - time) <= slack) return s->values[i];
  return between(s, k, time);
}

/* Distance from the first. */
double cli_series_drift(const cli_series *s) {
  double most = 0;
  for (long k = 1; k < s->count; k++) most = fmax(most, fabs(s->values[k] - s->values[0]));
  return most;
}

/* Time of the passage between samples k and k + 1, by halving on the cubic. */
static double passage(const cli_series *s, long k, double level) {
  double low = s->times[k], high = s->times[k + 1];
  bool rising = s->values[k + 1] > s->values[k];
  for (int n = 0; n < 60; n++) {
    double middle = 0.5 * (low + high);
    bool beyond = (between(s, k, middle) >= level) == rising;
    *(beyond ? &high : &low) = middle;
  }
  return 0.5 * (low + high);
}

/* Does the value pass the level between samples k and k + 1? 1 upwards, -1 downwards, 0 not. */
static int passes(const cli_series *s, long k, double level) {
  double a = s->values[k] - level, b = s->values[k + 1] - level;
  return a < 0 && b >= 0 ? 1 : a > 0 && b <= 0 ? -1 : 0;
}

/* First passage. */
double cli_series_reaches(const cli_series *s, double level) {
  if (s->count > 0 && s->values[0] == level) return s->times[0];
  for (long k = 0; k + 1 < s->count; k++)
    if (passes(s, k, level)) return passage(s, k, level);
  return (double)NAN;
}

/* Passages in the sense of the first one. */
double cli_series_period(const cli_series *s, double level) {
  double first = (double)NAN, last = (double)NAN;
  int sense = 0, count = 0;
  for (long k = 0; k + 1 < s->count; k++) {
    int now = passes(s, k, level);
    if (!now || (sense && now != sense)) continue;
    sense = now;
    last = passage(s, k, level);
    if (count++ == 0) first = last;
  }
  return count < 2 ? (double)NAN : (last - first) / (count - 1);
}

/* Solves the 3 x 3 normal equations by Cramer's rule and gives how much of the right side the fit explains.
 */
static double explained(const double A[6], const double b[3]) {
  double a11 = A[0], a12 = A[1], a13 = A[2], a22 = A[3], a23 = A[4], a33 = A[5];
  double c11 = a22 * a33 - a23 * a23, c12 = a13 * a23 - a12 * a33, c13 = a12 * a23 - a13 * a22;
  double c22 = a11 * a33 - a13 * a13, c23 = a12 * a13 - a11 * a23, c33 = a11 * a22 - a12 * a12;
  double det = a11 * c11 + a12 * c12 + a13 * c13;
  return (b[0] * (c11 * b[0] + c12 * b[1] + c13 * b[2]) + b[1] * (c12 * b[0] + c22 * b[1] + c23 * b[2]) +
          b[2] * (c13 * b[0] + c23 * b[1] + c33 * b[2])) /
         det;
}

/* How much of the weighted square of the series about its mean the frequency w explains. Times are taken from
 * the middle; the window is cos^4. */
static double power(const cli_series *s, double mean, double w) {
  double start = s->times[0], span = s->times[s->count - 1] - start, middle = start + 0.5 * span;
  double A[6] = {0}, b[3] = {0};
  for (long k = 0; k < s->count; k++) {
    double t = s->times[k] - middle, hann = cos(PI * t / span), weight = hann * hann * hann * hann;
    double c = cos(w * t), d = sin(w * t), x = s->values[k] - mean;
    A[0] += weight * c * c;
    A[1] += weight * c * d;
    A[2] += weight * c;
    A[3] += weight * d * d;
    A[4] += weight * d;
    A[5] += weight;
    b[0] += weight * c * x;
    b[1] += weight * d * x;
    b[2] += weight * x;
  }
  return explained(A, b);
}

/* Golden section over the main lobe around the guess, then parabolas, which do not stop at the root of the
 * round-off. */
double cli_series_frequency(const cli_series *s, double guess) {
  const double golden = 0.61803398874989485;
  if (s->count < 8) return (double)NAN;
  double span = s->times[s->count - 1] - s->times[0], mean = 0;
  for (long k = 0; k < s->count; k++) mean += s->values[k] / (double)s->count;
  if (!(guess > 0)) guess = 2 * PI / cli_series_period(s, mean);
  if (!(guess > 0) || guess * span < 4 * PI * 0.95) return (double)NAN;
  double low = guess - 2 * PI / span, high = guess + 2 * PI / span;
  double p = high - golden * (high - low), q = low + golden * (high - low), at_p = power(s, mean, p),
         at_q = power(s, mean, q);
  while (high - low > 1e-3 / span) {
    if (at_p > at_q) {
      high = q, q = p, at_q = at_p;
      p = high - golden * (high - low), at_p = power(s, mean, p);
    } else {
      low = p, p = q, at_p = at_q;
      q = low + golden * (high - low), at_q = power(s, mean, q);
    }
  }
  double w = 0.5 * (low + high), d = 0.03 / span;
  for (int n = 0; n < 3; n++) {
    double left = power(s, mean, w - d), centre = power(s, mean, w), right = power(s, mean, w + d),
           bend = left - 2 * centre + right;
    if (!(bend < 0)) return (double)NAN;
    w += 0.5 * d * (left - right) / bend;
  }
  return w;
}
