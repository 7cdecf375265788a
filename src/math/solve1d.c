#include "math/solve1d.h"

#include <float.h>
#include <math.h>
#include <stdbool.h>

/* Where in the bracket to look next, as a fraction from b to a: bisection, or inverse quadratic interpolation
 * through the last three points where Chandrupatla's criterion says that the function is smooth enough for
 * it. */
static double next_fraction(hb_bracket now, double c, double fc) {
  double xi = (now.a - now.b) / (c - now.b), phi = (now.fa - now.fb) / (fc - now.fb);
  bool smooth = phi * phi < xi && (1 - phi) * (1 - phi) < 1 - xi;
  if (!smooth) return 0.5;
  double first = now.fa / (now.fb - now.fa) * (fc / (now.fb - fc));
  double second = (c - now.a) / (now.b - now.a) * (now.fa / (fc - now.fa)) * (now.fb / (fc - now.fb));
  return first + second;
}

/* Keeps a bracket [a, b] with a the newest point, and c the point before. */
double hb_solve_bracketed(hb_function1 f, const void *context, hb_bracket bracket, double tolerance) {
  double fraction = 0.5;
  if (bracket.fa == 0) return bracket.a;
  if (bracket.fb == 0) return bracket.b;
  for (int round = 0; round < 120; round++) {
    double x = bracket.a + fraction * (bracket.b - bracket.a), fx = f(context, x);
    double c, fc;
    if ((fx > 0) == (bracket.fa > 0)) {
      c = bracket.a;
      fc = bracket.fa;
    } else {
      c = bracket.b;
      fc = bracket.fb;
      bracket.b = bracket.a;
      bracket.fb = bracket.fa;
    }
    bracket.a = x;
    bracket.fa = fx;
    double best = fabs(fx) < fabs(bracket.fb) ? x : bracket.b;
    double width = fabs(bracket.b - bracket.a), least = 2 * DBL_EPSILON * fabs(best) + 0.5 * tolerance;
    if (fx == 0) return x;
    if (width <= least) return best;
    double limit = least / width;
    fraction = next_fraction(bracket, c, fc);
    if (!(fraction > limit)) fraction = limit;
    if (fraction > 1 - limit) fraction = 1 - limit;
  }
  return fabs(bracket.fa) < fabs(bracket.fb) ? bracket.a : bracket.b;
}
