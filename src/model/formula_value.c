#include "model/formula_program.h"

#include <math.h>
#include <string.h>

/* a modulo b with the sign of b, so that mod(t, 1) is a saw tooth on both sides of 0. */
static double modulo(double a, double b) {
  double r = fmod(a, b);
  return r != 0 && (r < 0) != (b < 0) ? r + b : r;
}

/* Smaller of two; a not-a-number is passed on rather than hidden. */
static double smaller(double a, double b) {
  if (isnan(a) || isnan(b)) return a + b;
  return b < a ? b : a;
}

/* Larger of two; a not-a-number is passed on. */
static double larger(double a, double b) {
  if (isnan(a) || isnan(b)) return a + b;
  return b > a ? b : a;
}

/* Place of x between two edges, 0 .. 1; a jump where they are equal. */
static double ramp(double from, double to, double x) {
  if (from == to) {
    if (isnan(x)) return x;
    return x < from ? 0 : 1;
  }
  double s = (x - from) / (to - from);
  if (s < 0) return 0;
  return s > 1 ? 1 : s;
}

/* Spreads every bit over all bits: the finaliser of the generator SplitMix64 (Steele, Lea, Flood 2014). */
static uint64_t mix(uint64_t z) {
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  return z ^ (z >> 31);
}

/* Adds a number to a hash by its bits; -0 counts as 0. The step is that of SplitMix64, so that zeros are seen
 * too. */
static uint64_t mix_number(uint64_t hash, double a) {
  uint64_t bits;
  a = a == 0 ? 0 : a;
  memcpy(&bits, &a, sizeof bits);
  return mix((hash ^ bits) + 0x9e3779b97f4a7c15u);
}

/* A number from [-1, 1) that looks like chance: the 53 upper bits of a hash. */
static double spread(uint64_t hash) { return (double)(hash >> 11) * 0x1p-52 - 1; }

/* Noise of one number; of what is not finite there is none. */
static double noise(double a) { return isfinite(a) ? spread(mix_number(0, a)) : (double)NAN; }

/* Noise of two numbers. */
static double noise_2(double a, double b) {
  return isfinite(a) && isfinite(b) ? spread(mix_number(mix_number(0, a), b)) : (double)NAN;
}

/* Operations with one operand. */
static double value1(hb_op op, double a) {
  switch (op) {
  case HB_OP_NEGATE: return -a;
  case HB_OP_SIN: return sin(a);
  case HB_OP_COS: return cos(a);
  case HB_OP_TAN: return tan(a);
  case HB_OP_ASIN: return asin(a);
  case HB_OP_ACOS: return acos(a);
  case HB_OP_ATAN: return atan(a);
  case HB_OP_SINH: return sinh(a);
  case HB_OP_COSH: return cosh(a);
  case HB_OP_TANH: return tanh(a);
  case HB_OP_EXP: return exp(a);
  case HB_OP_LOG: return log(a);
  case HB_OP_LOG10: return log10(a);
  case HB_OP_SQRT: return sqrt(a);
  case HB_OP_ABS: return fabs(a);
  case HB_OP_FLOOR: return floor(a);
  case HB_OP_CEIL: return ceil(a);
  case HB_OP_SIGN: return isnan(a) ? a : (double)((a > 0) - (a < 0));
  case HB_OP_STEP: return isnan(a) ? a : (double)(a >= 0);
  case HB_OP_NOISE: return noise(a);
  default: return (double)NAN;
  }
}

/* Operations with two operands. */
static double value2(hb_op op, double a, double b) {
  switch (op) {
  case HB_OP_ADD: return a + b;
  case HB_OP_SUBTRACT: return a - b;
  case HB_OP_MULTIPLY: return a * b;
  case HB_OP_DIVIDE: return a / b;
  case HB_OP_POWER: return pow(a, b);
  case HB_OP_LESS: return a < b;
  case HB_OP_LESS_EQUAL: return a <= b;
  case HB_OP_GREATER: return a > b;
  case HB_OP_GREATER_EQUAL: return a >= b;
  case HB_OP_EQUAL: return a == b;
  case HB_OP_NOT_EQUAL: return a != b;
  case HB_OP_ATAN2: return atan2(a, b);
  case HB_OP_MIN: return smaller(a, b);
  case HB_OP_MAX: return larger(a, b);
  case HB_OP_MOD: return modulo(a, b);
  case HB_OP_HYPOT: return hypot(a, b);
  case HB_OP_NOISE_2: return noise_2(a, b);
  default: return (double)NAN;
  }
}

/* Operations with three operands. */
static double value3(hb_op op, double a, double b, double c) {
  switch (op) {
  case HB_OP_IF:
    if (isnan(a)) return a;
    return a != 0 ? b : c;
  case HB_OP_CLAMP: return smaller(larger(a, b), c);
  case HB_OP_SMOOTHSTEP: {
    double s = ramp(a, b, c);
    return s * s * (3 - 2 * s);
  }
  default: return (double)NAN;
  }
}

/* By the number of operands. */
double hb_op_value(hb_op op, const double operands[3]) {
  switch (hb_op_operands(op)) {
  case 1: return value1(op, operands[0]);
  case 2: return value2(op, operands[0], operands[1]);
  default: return value3(op, operands[0], operands[1], operands[2]);
  }
}

/* slope * rate, and 0 for an operand at rest even where the slope is infinite: sqrt(x) at x = 0 does not
 * change. */
static double chain(double slope, double rate) { return rate == 0 ? 0 : slope * rate; }

/* Slope of an operation with one operand. */
static double slope1(hb_op op, double a, double value) {
  switch (op) {
  case HB_OP_NEGATE: return -1;
  case HB_OP_SIN: return cos(a);
  case HB_OP_COS: return -sin(a);
  case HB_OP_TAN: return 1 + value * value;
  case HB_OP_ASIN: return 1 / sqrt((1 - a) * (1 + a));
  case HB_OP_ACOS: return -1 / sqrt((1 - a) * (1 + a));
  case HB_OP_ATAN: return 1 / (1 + a * a);
  case HB_OP_SINH: return cosh(a);
  case HB_OP_COSH: return sinh(a);
  case HB_OP_TANH: {
    double c = cosh(a); /* 1 - value^2 would lose the tail */
    return 1 / (c * c);
  }
  case HB_OP_EXP: return value;
  case HB_OP_LOG: return a < 0 ? (double)NAN : 1 / a;
  case HB_OP_LOG10: return a < 0 ? (double)NAN : 1 / (a * 2.302585092994045684);
  case HB_OP_SQRT: return 0.5 / value;
  default: return isnan(value) ? value : 0; /* floor, ceil, sign, step, noise: flat between jumps */
  }
}

/* d(a^b) = b a^(b-1) da + a^b log(a) db, each part only where something changes: a may be negative or 0. */
static double power_rate(const double operands[3], double value, const double rates[3]) {
  double a = operands[0], b = operands[1], rate = 0;
  if (rates[0] != 0 && b != 0) rate += b * pow(a, b - 1) * rates[0];
  if (rates[1] != 0 && value != 0) rate += value * log(a) * rates[1];
  return rate;
}

/* Rate of the smaller (sign 1) or larger (sign -1) of two; at a tie of the one that will be it just after. */
static double choice_rate(double sign, double a, double b, double da, double db) {
  if (isnan(a) || isnan(b)) return (double)NAN;
  if (a != b) return sign * (b - a) > 0 ? da : db;
  return sign * (db - da) > 0 ? da : db;
}

/* Rate of hypot; from the corner at 0 it starts as the hypotenuse of the rates. */
static double hypot_rate(const double operands[3], double value, const double rates[3]) {
  if (value == 0) return hypot(rates[0], rates[1]);
  return chain(operands[0] / value, rates[0]) + chain(operands[1] / value, rates[1]);
}

/* Rate of atan2(y, x); 0 at the origin, where there is no angle. */
static double angle_rate(const double operands[3], const double rates[3]) {
  double y = operands[0], x = operands[1], r = hypot(x, y);
  return r == 0 ? 0 : (chain(x / r, rates[0]) - chain(y / r, rates[1])) / r;
}

/* Operations with two operands. */
static double rate2(hb_op op, const double operands[3], double value, const double rates[3]) {
  double a = operands[0], b = operands[1], da = rates[0], db = rates[1];
  switch (op) {
  case HB_OP_ADD: return da + db;
  case HB_OP_SUBTRACT: return da - db;
  case HB_OP_MULTIPLY: return chain(b, da) + chain(a, db);
  case HB_OP_DIVIDE: return chain(1 / b, da) - chain(value / b, db);
  case HB_OP_POWER: return power_rate(operands, value, rates);
  case HB_OP_ATAN2: return angle_rate(operands, rates);
  case HB_OP_MIN: return choice_rate(1, a, b, da, db);
  case HB_OP_MAX: return choice_rate(-1, a, b, da, db);
  case HB_OP_MOD: return da - chain(rint((a - value) / b), db);
  case HB_OP_HYPOT: return hypot_rate(operands, value, rates);
  case HB_OP_NOISE_2: return isnan(value) ? value : 0;
  default: return 0; /* comparisons */
  }
}

/* Rate of smoothstep: 6 s (1 - s) times the rate of s between the edges, 0 outside. */
static double smoothstep_rate(const double operands[3], const double rates[3]) {
  double width = operands[1] - operands[0];
  if (width == 0) return 0;
  double s = ramp(operands[0], operands[1], operands[2]);
  if (s <= 0 || s >= 1) return 0;
  double ds = (rates[2] - rates[0] - s * (rates[1] - rates[0])) / width;
  return 6 * s * (1 - s) * ds;
}

/* Operations with three operands. */
static double rate3(hb_op op, const double operands[3], const double rates[3]) {
  switch (op) {
  case HB_OP_IF:
    if (isnan(operands[0])) return operands[0];
    return operands[0] != 0 ? rates[1] : rates[2];
  case HB_OP_CLAMP: {
    double lifted = larger(operands[0], operands[1]);
    double rate = choice_rate(-1, operands[0], operands[1], rates[0], rates[1]);
    return choice_rate(1, lifted, operands[2], rate, rates[2]);
  }
  default: return smoothstep_rate(operands, rates);
  }
}

/* By the number of operands. */
double hb_op_rate(hb_op op, const double operands[3], double value, const double rates[3]) {
  switch (hb_op_operands(op)) {
  case 1:
    if (op == HB_OP_ABS && operands[0] == 0) return fabs(rates[0]);
    if (op == HB_OP_ABS) return operands[0] < 0 ? -rates[0] : rates[0];
    return chain(slope1(op, operands[0], value), rates[0]);
  case 2: return rate2(op, operands, value, rates);
  default: return rate3(op, operands, rates);
  }
}
