/* Roots of functions of one variable. */
#ifndef HB_MATH_SOLVE1D_H
#define HB_MATH_SOLVE1D_H

typedef double (*hb_function1)(const void *context, double x);

/* Two places where a function has different signs (or is 0 at one of them). */
typedef struct hb_bracket {
  double a, fa, b, fb;
} hb_bracket;

/* A root of f between the ends of the bracket, by inverse quadratic interpolation where that is safe and
 * bisection where it is not (Chandrupatla 1997). Ends when the bracket is narrower than tolerance or than
 * round-off; where f jumps over 0 it returns the place of the jump. At most some 120 evaluations, usually 6
 * to 10. */
double hb_solve_bracketed(hb_function1 f, const void *context, hb_bracket bracket, double tolerance);

#endif
