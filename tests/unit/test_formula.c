/* Formulas: values and rates against numbers from 60-digit arithmetic (mpmath), rules of the grammar, folding
 * against evaluation on random expressions, and every error sentence. */
#include "hebra/formula.h"
#include "model/formula_names.h"
#include "model/formula_number.h"
#include "support/near.h"
#include "support/rng.h"

#include <locale.h>
#include <stdio.h>
#include <string.h>

static const double no_vars[HB_VAR_COUNT] = {0};

/* Compiles or fails the test with the sentence. */
static hb_formula *compiled(const char *text, unsigned allowed) {
  hb_formula *formula = NULL;
  hb_error err = {HB_OK, ""};
  if (hb_formula_parse(text, allowed, NULL, 0, &formula, &err) != HB_OK) fail_msg("'%s': %s", text, err.text);
  return formula;
}

/* Value of a formula without variables, which must have been folded. */
static double constant(const char *text) {
  hb_formula *formula = compiled(text, HB_VARS_NONE);
  assert_true(hb_formula_is_constant(formula));
  double value = hb_formula_eval(formula, no_vars);
  hb_formula_free(formula);
  return value;
}

/* Value and rate of a formula of t. */
static double rate_at(const char *text, double t, double *value) {
  double vars[HB_VAR_COUNT] = {0}, v = 0, rate = 0;
  vars[HB_VAR_T] = t;
  hb_formula *formula = compiled(text, HB_VARS_TIME);
  hb_formula_eval_dt(formula, vars, &v, &rate);
  double plain = hb_formula_eval(formula, vars);
  if (!isnan(plain) || !isnan(v)) assert_same(v, plain);
  if (value) *value = v;
  hb_formula_free(formula);
  return rate;
}

static const struct {
  const char *text;
  double value;
} known_values[] = {
    {"sin(0.7)", 0.644217687237691},
    {"cos(2.5)", -0.8011436155469337},
    {"tan(1.2)", 2.5721516221263188},
    {"asin(0.3)", 0.3046926540153975},
    {"acos(-0.6)", 2.214297435588181},
    {"atan(3.5)", 1.2924966677897853},
    {"atan2(-1.5,-2.5)", -2.601173153319209},
    {"atan2(2,-3)", 2.5535900500422257},
    {"sinh(1.3)", 1.6983824372926157},
    {"cosh(2.1)", 4.1443131704103155},
    {"tanh(0.4)", 0.3799489622552249},
    {"exp(1.7)", 5.4739473917272},
    {"log(7.3)", 1.9878743481543455},
    {"log10(250)", 2.3979400086720375},
    {"sqrt(2)", 1.4142135623730951},
    {"abs(-3.25)", 3.25},
    {"floor(-2.5)", -3.0},
    {"ceil(-2.5)", -2.0},
    {"min(3,-4)", -4.0},
    {"max(3,-4)", 3.0},
    {"min(3,2,1.5,8)", 1.5},
    {"max(1,9.5,3)", 9.5},
    {"mod(7.5,2)", 1.5},
    {"mod(-7.5,2)", 0.5},
    {"mod(7.5,-2)", -0.5},
    {"sign(-0.3)", -1.0},
    {"sign(0)", 0.0},
    {"step(0)", 1.0},
    {"step(-1e-9)", 0.0},
    {"step(2,1.5)", 0.0},
    {"step(2,2)", 1.0},
    {"clamp(5,1,3)", 3.0},
    {"clamp(-5,1,3)", 1.0},
    {"clamp(2,1,3)", 2.0},
    {"smoothstep(1,3,1.5)", 0.15625},
    {"smoothstep(3,1,1.5)", 0.84375},
    {"smoothstep(0,1,7)", 1.0},
    {"pow(2,0.5)", 1.4142135623730951},
    {"pow(-2,3)", -8.0},
    {"hypot(3,4)", 5.0},
    {"hypot(0.1,0.7)", 0.7071067811865476},
    {"if(2>1,10,20)", 10.0},
    {"if(2<1,10,20)", 20.0},
    {"2^0.5", 1.4142135623730951},
    {"2^-2", 0.25},
    {"pi", 3.141592653589793},
    {"e", 2.718281828459045},
    {"3*pi", 9.42477796076938},
    {"1e3*2.5e-3", 2.5},
};

/* Every function and operator against 60-digit arithmetic. */
static void test_values(void **state) {
  (void)state;
  for (size_t k = 0; k < sizeof known_values / sizeof known_values[0]; k++) {
    double value = constant(known_values[k].text);
    if (fabs(value - known_values[k].value) > 5e-16 * fabs(known_values[k].value))
      fail_msg("%s is %.17g, expected %.17g", known_values[k].text, value, known_values[k].value);
  }
}

static const struct {
  const char *text;
  double value, rate;
} known_rates[] = {
    {"t", 0.375, 1.0},
    {"-t", -0.375, -1.0},
    {"t^2", 0.140625, 0.75},
    {"t^3-2*t", -0.697265625, -1.578125},
    {"1/t", 2.6666666666666665, -7.111111111111111},
    {"t/(1+t^2)", 0.3287671232876712, 0.6605366860574217},
    {"(1+t)/(2-t)", 0.8461538461538461, 1.136094674556213},
    {"sin(2*pi*t)", 0.7071067811865476, -4.442882938158366},
    {"cos(3*t+1)", -0.5262663347043051, -2.550959369455356},
    {"tan(t)", 0.39362657592563277, 1.154941881274938},
    {"asin(t/2)", 0.1886163861754041, 0.5090278103806222},
    {"acos(t/2)", 1.3821799406194926, -0.5090278103806222},
    {"atan(4*t)", 0.982793723247329, 1.2307692307692308},
    {"sinh(t)", 0.38385106791361456, 1.0711403467045868},
    {"cosh(3*t)", 1.7024346581381904, 4.133346572339522},
    {"tanh(5*t)", 0.9540452601799487, 0.4489882076408693},
    {"exp(-t^2)", 0.8688150562628432, -0.6516112921971324},
    {"log(1+t)", 0.3184537311185346, 0.7272727272727273},
    {"log10(2+t)", 0.3756636139608854, 0.18286083448557972},
    {"sqrt(1+3*t)", 1.4577379737113252, 1.028991510855053},
    {"abs(t-2)", 1.625, -1.0},
    {"abs(3*t)", 1.125, 3.0},
    {"t^2.5", 0.0861148737697211, 0.5740991584648074},
    {"2^t", 1.2968395546510096, 0.8989006809449624},
    {"t^t", 0.6922480250493347, 0.013270911741352994},
    {"(1+t^2)^(-1.5)", 0.8208913337591623, -0.8096462469953382},
    {"pow(3,t^2)", 1.1670653535842626, 0.9616142543448475},
    {"atan2(t,2)", 0.18534794999569476, 0.4830188679245283},
    {"atan2(sin(5*t),cos(5*t))", 1.875, 5.0},
    {"atan2(t-1,-t)", -2.1112158270654806, -1.8823529411764706},
    {"hypot(t,1)", 1.0680004681646913, 0.3511234415883917},
    {"hypot(3*t,4*t)", 1.875, 5.0},
    {"min(t,1-t)", 0.375, 1.0},
    {"max(t,1-t)", 0.625, -1.0},
    {"min(t^2,t,3)", 0.140625, 0.75},
    {"clamp(3*t,0.5,4)", 1.125, 3.0},
    {"clamp(t,2,4)", 2.0, 0.0},
    {"clamp(t,0,t^2)", 0.140625, 0.75},
    {"smoothstep(0,1,t)", 0.31640625, 1.40625},
    {"smoothstep(1,0,t)", 0.68359375, -1.40625},
    {"smoothstep(t/2,2*t,2.5*t^2)", 0.20558449074074073, 2.0659722222222223},
    {"smoothstep(2,3,t)", 0.0, 0.0},
    {"mod(5*t,1)", 0.875, 5.0},
    {"mod(2,t)", 0.125, -5.0},
    {"mod(-3*t,0.7*t)", 0.1875, 0.5},
    {"floor(5*t)*t", 0.375, 1.0},
    {"ceil(5*t)+t", 2.375, 1.0},
    {"sign(t)*t^3", 0.052734375, 0.421875},
    {"step(t-0.1)*t^2", 0.140625, 0.75},
    {"if(t<0.5,sin(t),cos(t))", 0.36627252908604757, 0.9305076219123143},
    {"if(t>0.5,sin(t),t^3)", 0.052734375, 0.421875},
    {"(t>0.2)*t", 0.375, 1.0},
    {"exp(sin(t)*cos(t))/(1+t^2)", 1.232744546450385, 0.09141370623253739},
    {"cosh(4.35464*t - 2.17732)/4.35464 - 1.02602", -0.7615109143727837, -0.5716114371264581},
    {"6*pi*smoothstep(0,2,t)", 1.739534213462317, 8.614836104765761},
    {"-t^2", -0.140625, -0.75},
    {"2^-t", 0.7711054127039704, -0.5344895427302702},
    {"(-2)^2*t", 1.5, 4.0},
    {"(-2)^3*t^2", -1.125, -6.0},
    {"(t-2)^3", -4.291015625, 7.921875},
    {"(t-2)^-2", 0.378698224852071, 0.46609012289485663},
};

/* Values and time derivatives at t = 0.375 against 60-digit arithmetic. */
static void test_rates(void **state) {
  (void)state;
  for (size_t k = 0; k < sizeof known_rates / sizeof known_rates[0]; k++) {
    double value, rate = rate_at(known_rates[k].text, 0.375, &value);
    if (fabs(value - known_rates[k].value) > 2e-15 * (1 + fabs(known_rates[k].value)))
      fail_msg("%s is %.17g, expected %.17g", known_rates[k].text, value, known_rates[k].value);
    if (fabs(rate - known_rates[k].rate) > 1e-14 * (1 + fabs(known_rates[k].rate)))
      fail_msg("d/dt %s is %.17g, expected %.17g", known_rates[k].text, rate, known_rates[k].rate);
  }
}

/* At a kink the rate is the one just after; where an operand rests, an infinite slope does not count. */
static void test_rates_at_kinks(void **state) {
  (void)state;
  assert_same(rate_at("abs(t)", 0, NULL), 1);
  assert_same(rate_at("abs(-2*t)", 0, NULL), 2);
  assert_same(rate_at("min(t, 2*t)", 0, NULL), 1);
  assert_same(rate_at("max(t, 2*t)", 0, NULL), 2);
  assert_same(rate_at("clamp(t, 0, 1)", 0, NULL), 1);
  assert_same(rate_at("clamp(t, 0, 1)", 1, NULL), 0);
  assert_same(rate_at("if(t < 1, 0, 3*t)", 1, NULL), 3);
  assert_same(rate_at("hypot(3*t, 4*t)", 0, NULL), 5);
  assert_same(rate_at("sqrt(0)*t + t", 0, NULL), 1);
  assert_same(rate_at("sqrt(if(t < 5, 0, t))", 2, NULL), 0);
  assert_same(rate_at("t^2", 0, NULL), 0);
  assert_same(rate_at("t^1", 0, NULL), 1);
  assert_same(rate_at("t^0", 0, NULL), 0);
  assert_same(rate_at("(-t)^3", 2, NULL), -12);
  assert_same(rate_at("atan2(t - t, t - t)", 3, NULL), 0);
  assert_same(rate_at("smoothstep(1, 1, t)", 1, NULL), 0);
  assert_same(rate_at("floor(t) + ceil(t) + sign(t) + step(t)", 1, NULL), 0);
  assert_true(isinf(rate_at("sqrt(t)", 0, NULL)));
  assert_true(isnan(rate_at("log(t)", -1, NULL)));
  assert_true(isnan(rate_at("log10(t)", -1, NULL)));
  assert_true(isnan(rate_at("min(log(t), 1)", -1, NULL)));
}

/* Only t moves: the other variables are held. */
static void test_rate_holds_the_rest(void **state) {
  (void)state;
  double vars[HB_VAR_COUNT] = {2, 3, 5, 7, 11, 13, 17, 19}, value, rate;
  hb_formula *formula = compiled("t*s + u*x*y + z^2*t + i*L*t", HB_VARS_ALL);
  hb_formula_eval_dt(formula, vars, &value, &rate);
  assert_same(value, 2 * 3 + 5 * 7 * 11 + 169 * 2 + 17 * 19 * 2);
  assert_same(rate, 3 + 169 + 17 * 19);
  hb_formula_free(formula);
}

/* Who binds tighter, and from which side. */
static void test_precedence(void **state) {
  (void)state;
  assert_same(constant("2+3*4"), 14);
  assert_same(constant("2*3+4"), 10);
  assert_same(constant("(2+3)*4"), 20);
  assert_same(constant("10-3-2"), 5);
  assert_same(constant("100/10/2"), 5);
  assert_same(constant("100/10*2"), 20);
  assert_same(constant("-2^2"), -4);
  assert_same(constant("(-2)^2"), 4);
  assert_same(constant("2^3^2"), 512);
  assert_same(constant("2^-1"), 0.5);
  assert_same(constant("2^-2^2"), 0.0625);
  assert_same(constant("--3"), 3);
  assert_same(constant("-+-3"), 3);
  assert_same(constant("2*-3"), -6);
  assert_same(constant("2--3"), 5);
  assert_same(constant("-2*3"), -6);
  assert_same(constant("1+1 < 3"), 1);
  assert_same(constant("1 < 3-5"), 0);
  assert_same(constant("(1 < 2)*(2 < 3)"), 1);
  assert_same(constant("2 <= 2"), 1);
  assert_same(constant("2 >= 3"), 0);
  assert_same(constant("2 > 2"), 0);
  assert_same(constant("2 == 2.0"), 1);
  assert_same(constant("2 != 2"), 0);
  assert_same(constant(" \t\r\n 1 +\n 2 "), 3);
}

/* IEEE where arithmetic has no number, and a not-a-number is never hidden. */
static void test_ieee(void **state) {
  (void)state;
  assert_true(isinf(constant("1/0")) && constant("1/0") > 0);
  assert_true(isinf(constant("-1/0")) && constant("-1/0") < 0);
  assert_true(isnan(constant("0/0")));
  assert_true(isnan(constant("sqrt(-1)")));
  assert_true(isnan(constant("min(0/0, 1)")) && isnan(constant("max(1, 0/0)")));
  assert_true(isnan(constant("clamp(0/0, 0, 1)")) && isnan(constant("smoothstep(0, 1, 0/0)")));
  assert_true(isnan(constant("smoothstep(1, 1, 0/0)")));
  assert_true(isnan(constant("if(0/0, 1, 2)")) && isnan(constant("sign(0/0)")) &&
              isnan(constant("step(0/0)")));
  assert_same(constant("if(1, 2, 0/0)"), 2);
  assert_same(constant("0/0 == 0/0"), 0);
  assert_true(isnan(constant("mod(1, 0)")));
  assert_same(constant("smoothstep(2, 2, 1.9)"), 0);
  assert_same(constant("smoothstep(2, 2, 2)"), 1);
}

/* Numbers are rounded correctly, whatever the locale; nothing that only strtod knows is a number. */
static void test_numbers(void **state) {
  (void)state;
  double value;
  assert_same(constant("0.1"), 0.1);
  assert_same(constant(".5"), 0.5);
  assert_same(constant("5."), 5);
  assert_same(constant("1E-3"), 1e-3);
  assert_same(constant("1e+2"), 100);
  assert_same(constant("9007199254740993"), 9007199254740992.0);
  assert_same(constant("9007199254740993.0000000000000000000000000000000001"), 9007199254740994.0);
  assert_same(constant("2.2250738585072011e-308"), 0x0.fffffffffffffp-1022);
  assert_same(constant("1.7976931348623157e308"), 0x1.fffffffffffffp+1023);
  assert_same(constant("1e-400"), 0);
  assert_true(hb_number_field("-1.5e3", 6, &value));
  assert_same(value, -1500);
  assert_true(hb_number_field("+7", 2, &value));
  assert_same(value, 7);
  static const char *const refused[] = {"",     "-",     ".",  "e5", "inf", "-inf", "nan",
                                        "0x10", "1e999", "1 ", " 1", "--1", "1e",   "1,5"};
  for (size_t k = 0; k < sizeof refused / sizeof refused[0]; k++)
    if (hb_number_field(refused[k], strlen(refused[k]), &value))
      fail_msg("'%s' was taken as a number", refused[k]);
  static const char *const commas[] = {"de_DE.UTF-8", "fr_FR.UTF-8", "C"};
  for (size_t k = 0; k < sizeof commas / sizeof commas[0]; k++) {
    if (!setlocale(LC_NUMERIC, commas[k])) continue;
    hb_formula *formula = NULL;
    assert_same(constant("1.5 + .25"), 1.75);
    assert_int_equal(hb_formula_constant(-2.625, &formula, NULL), HB_OK);
    assert_string_equal(hb_formula_text(formula), "-2.625");
    hb_formula_free(formula);
  }
  setlocale(LC_NUMERIC, "C");
}

/* Which variables are read, what is constant, what the text was. */
static void test_questions(void **state) {
  (void)state;
  hb_formula *formula = compiled("3*x + sin(t)", HB_VARS_ALL);
  assert_true(hb_formula_uses(formula, HB_VAR_X) && hb_formula_uses(formula, HB_VAR_T));
  assert_false(hb_formula_uses(formula, HB_VAR_Y) || hb_formula_uses(formula, HB_VAR_L));
  assert_false(hb_formula_is_constant(formula));
  assert_string_equal(hb_formula_text(formula), "3*x + sin(t)");
  hb_formula_free(formula);
  hb_formula_free(NULL);
  formula = compiled(" 2 * pi ", HB_VARS_ALL);
  assert_true(hb_formula_is_constant(formula));
  assert_string_equal(hb_formula_text(formula), " 2 * pi ");
  hb_formula_free(formula);
  assert_true(hb_formula_reserves("L") && hb_formula_reserves("e") && hb_formula_reserves("t"));
  assert_false(hb_formula_reserves("sin") || hb_formula_reserves("alpha") || hb_formula_reserves(""));
}

/* A formula from a number: the shortest text that reads back as it; only finite numbers. */
static void test_constant(void **state) {
  (void)state;
  static const double values[] = {0, -0.1, 1.0 / 3, 1e300, 5e-324, 123456789.125, -2e-17};
  hb_error err;
  for (size_t k = 0; k < sizeof values / sizeof values[0]; k++) {
    hb_formula *formula = NULL;
    double value = 0, rate = 1;
    assert_int_equal(hb_formula_constant(values[k], &formula, &err), HB_OK);
    hb_formula_eval_dt(formula, no_vars, &value, &rate);
    assert_same(value, values[k]);
    assert_same(rate, 0);
    assert_same(constant(hb_formula_text(formula)), values[k]);
    assert_true(hb_formula_is_constant(formula));
    hb_formula_free(formula);
  }
  hb_formula *formula = NULL;
  assert_int_equal(hb_formula_constant(0.1, &formula, &err), HB_OK);
  assert_string_equal(hb_formula_text(formula), "0.1");
  hb_formula_free(formula);
  assert_int_equal(hb_formula_constant(HUGE_VAL, &formula, &err), HB_ERR_INPUT);
  assert_null(formula);
  assert_string_equal(err.text, "a formula cannot stand for infinity; a finite number is needed");
  assert_int_equal(hb_formula_constant((double)NAN, &formula, &err), HB_ERR_INPUT);
  assert_string_equal(err.text, "a formula cannot stand for not-a-number; a finite number is needed");
}

/* Parameters are constants with a name, also the name of a function. */
static void test_parameters(void **state) {
  (void)state;
  const hb_parameter parameters[] = {{(char *)"alpha", 2.5}, {(char *)"k_2", 4}, {(char *)"step", 7}};
  hb_formula *formula = NULL;
  hb_error err;
  assert_int_equal(
      hb_formula_parse("alpha*k_2 + step + step(1)", HB_VARS_NONE, parameters, 3, &formula, &err), HB_OK);
  assert_true(hb_formula_is_constant(formula));
  assert_same(hb_formula_eval(formula, no_vars), 18);
  hb_formula_free(formula);
}

/* Noise: numbers from the published generator SplitMix64 (Steele, Lea, Flood 2014; its first output from seed
 * 0 is E220A8397B1DCDAF), computed with another program; evenly spread, and no number where the argument is
 * none. */
static void test_noise(void **state) {
  (void)state;
  assert_same(constant("noise(0)"), (double)(0xE220A8397B1DCDAFu >> 11) / 4503599627370496.0 - 1);
  assert_same(constant("noise(-0)"), 0.7666216164272852);
  assert_same(constant("noise(1)"), 0.06908456782539862);
  assert_same(constant("noise(37)"), -0.5838875339609799);
  assert_same(constant("noise(-2.5)"), 0.750765109802195);
  assert_same(constant("noise(0, 0)"), 0.3048969727480644);
  assert_same(constant("noise(37, 1)"), -0.4218504337568032);
  assert_same(constant("noise(1, 37)"), 0.4472746241610619);
  assert_true(isnan(constant("noise(1/0)")) && isnan(constant("noise(0/0, 1)")) &&
              isnan(constant("noise(1, 0/0)")));
  assert_same(rate_at("noise(t) + noise(t, 2*t)", 3, NULL), 0);
  assert_true(isnan(rate_at("noise(log(t), 1)", -1, NULL)));
  enum { N = 20000 };
  hb_formula *formula = compiled("noise(i)", HB_VARS_ALL), *pair = compiled("noise(i, 1)", HB_VARS_ALL);
  double mean = 0, square = 0, cross = 0, last = 0, next = 0, least = 1, most = -1;
  for (int k = 0; k < N; k++) {
    double vars[HB_VAR_COUNT] = {[HB_VAR_I] = k}, a = hb_formula_eval(formula, vars),
           b = hb_formula_eval(pair, vars);
    mean += a / N;
    square += a * a / N;
    cross += a * b / N;
    next += a * last / N;
    last = a;
    least = fmin(least, a);
    most = fmax(most, a);
  }
  hb_formula_free(formula);
  hb_formula_free(pair);
  /* uniform on [-1, 1): variance 1/3; four standard deviations of each mean */
  assert_at_most(fabs(mean), 4 * sqrt(1.0 / 3 / N));
  assert_at_most(fabs(square - 1.0 / 3), 4 * sqrt(4.0 / 45 / N));
  assert_at_most(fabs(cross), 4.0 / 3 / sqrt(N));
  assert_at_most(fabs(next), 4.0 / 3 / sqrt(N));
  assert_true(least >= -1 && least < -0.999 && most < 1 && most > 0.999);
}

/* ---- random expressions
 * -------------------------------------------------------------------------------------- */

typedef struct random_text {
  char with_variables[16384],
      with_numbers[16384]; /* 256 leaves of 24 characters at most, and what joins them */
  size_t a, b;
  rng r;
  double vars[HB_VAR_COUNT];
} random_text;

/* Appends the same piece to both texts. */
static void add(random_text *x, const char *piece) {
  x->a += (size_t)snprintf(x->with_variables + x->a, sizeof x->with_variables - x->a, "%s", piece);
  x->b += (size_t)snprintf(x->with_numbers + x->b, sizeof x->with_numbers - x->b, "%s", piece);
}

/* A variable in one text, its value in the other. */
static void add_leaf(random_text *x) {
  static const char names[] = "tsuxyziL";
  int k = rng_int(&x->r, 0, HB_VAR_COUNT - 1);
  x->a += (size_t)snprintf(x->with_variables + x->a, sizeof x->with_variables - x->a, "%c", names[k]);
  size_t room = sizeof x->with_numbers - x->b;
  char *end = x->with_numbers + x->b;
  double value = x->vars[k];
  x->b += (size_t)(value < 0 ? snprintf(end, room, "(%.17g)", value) : snprintf(end, room, "%.17g", value));
}

/* An expression of at most depth levels. */
static void add_expression(random_text *x, int depth) {
  static const char *const operators[] = {"+", "-", "*", "/", "^", "<", "<=", ">", ">=", "==", "!="};
  static const char *const calls[] = {"1sin",   "1cos",   "1tan",   "1asin", "1acos",  "1atan", "1sinh",
                                      "1cosh",  "1tanh",  "1exp",   "1log",  "1log10", "1sqrt", "1abs",
                                      "1floor", "1ceil",  "1sign",  "1step", "2atan2", "2min",  "2max",
                                      "2mod",   "2pow",   "2hypot", "2step", "3clamp", "3if",   "3smoothstep",
                                      "4min",   "1noise", "2noise"};
  int kind = depth == 0 ? 0 : rng_int(&x->r, 0, 9);
  if (kind == 0) {
    add_leaf(x);
  } else if (kind == 1) {
    add(x, "(-");
    add_expression(x, depth - 1);
    add(x, ")");
  } else if (kind < 6) {
    add(x, "(");
    add_expression(x, depth - 1);
    add(x, operators[rng_int(&x->r, 0, 10)]);
    add_expression(x, depth - 1);
    add(x, ")");
  } else {
    const char *call = calls[rng_int(&x->r, 0, (int)(sizeof calls / sizeof calls[0]) - 1)];
    add(x, call + 1);
    for (int k = 0; k < call[0] - '0'; k++) {
      add(x, k ? "," : "(");
      add_expression(x, depth - 1);
    }
    add(x, ")");
  }
}

/* 10000 random expressions: with variables, and with the variables' values written in so that all is folded,
 * give the same bits; the dual evaluation gives that value too. */
static void test_folding(void **state) {
  (void)state;
  static random_text x;
  int compared = 0, finite = 0;
  for (uint64_t seed = 0; seed < 12000 && compared < 10000; seed++) {
    memset(&x, 0, sizeof x);
    x.r = rng_start(seed);
    for (int k = 0; k < HB_VAR_COUNT; k++) x.vars[k] = rng_uniform(&x.r, -3, 3);
    add_expression(&x, 4);
    if (x.a > HB_FORMULA_TEXT_MAX || x.b > HB_FORMULA_TEXT_MAX) continue;
    hb_formula *open = compiled(x.with_variables, HB_VARS_ALL),
               *folded = compiled(x.with_numbers, HB_VARS_NONE);
    double value, rate, plain = hb_formula_eval(open, x.vars), known = hb_formula_eval(folded, no_vars);
    hb_formula_eval_dt(open, x.vars, &value, &rate);
    assert_true(hb_formula_is_constant(folded));
    bool same = (isnan(plain) && isnan(known) && isnan(value)) || (plain == known && plain == value);
    if (!same)
      fail_msg("seed %d: %s is %.17g, folded %.17g, dual %.17g", (int)seed, x.with_variables, plain, known,
               value);
    finite += isfinite(plain) != 0;
    compared++;
    hb_formula_free(open);
    hb_formula_free(folded);
  }
  assert_int_equal(compared, 10000);
  assert_in_range(finite, 5000, 10000);
}

/* Rates of random smooth expressions against central differences (Richardson), on those that are tame enough.
 */
static void test_random_rates(void **state) {
  (void)state;
  static random_text x;
  int compared = 0;
  for (uint64_t seed = 0; seed < 4000; seed++) {
    memset(&x, 0, sizeof x);
    x.r = rng_start(seed + 1000000);
    for (int k = 0; k < HB_VAR_COUNT; k++) x.vars[k] = rng_uniform(&x.r, 0.2, 1.7);
    add_expression(&x, 3);
    if (x.a > HB_FORMULA_TEXT_MAX) continue;
    hb_formula *formula = compiled(x.with_variables, HB_VARS_ALL);
    double f[5], value, rate, t = x.vars[HB_VAR_T], h = 1e-3;
    hb_formula_eval_dt(formula, x.vars, &value, &rate);
    for (int k = -2; k <= 2; k++) {
      x.vars[HB_VAR_T] = t + k * h;
      f[k + 2] = hb_formula_eval(formula, x.vars);
    }
    double wide = (f[4] - f[0]) / (4 * h), narrow = (f[3] - f[1]) / (2 * h);
    bool tame = hb_formula_uses(formula, HB_VAR_T) && isfinite(wide) && isfinite(narrow) &&
                fabs(value) < 1e3 && fabs(wide - narrow) < 1e-4 * (1 + fabs(narrow));
    double estimate = narrow + (narrow - wide) / 3;
    if (tame && fabs(estimate - rate) > 2e-5 * (1 + fabs(rate)))
      fail_msg("d/dt %s is %.12g, by differences %.12g", x.with_variables, rate, estimate);
    compared += tame;
    hb_formula_free(formula);
  }
  assert_in_range(compared, 800, 4000);
}

/* ---- sentences
 * ----------------------------------------------------------------------------------------------- */

#define FUNCTIONS                                                                                            \
  "functions are sin, cos, tan, asin, acos, atan, atan2, sinh, cosh, tanh, exp, log, log10, sqrt, abs, "     \
  "floor, "                                                                                                  \
  "ceil, min, max, mod, sign, step, clamp, smoothstep, pow, hypot, if, noise"
#define EMPTY "the formula is empty; a number such as 0.5 or an expression such as sin(2*pi*t) is needed"
#define VALUE " where a value is needed: a number, a name, a function or '('"
#define MULTIPLY " directly after a value; write * to multiply"
#define HERE "available here are t, pi, e and the parameters alpha, L"

/* Sentences with t allowed and the parameters alpha and L. */
static const struct {
  const char *text, *sentence;
} broken[] = {
    {"", EMPTY},
    {" \n", EMPTY},
    {"(", "column 2 of '(': found the end of the formula" VALUE},
    {"1+", "column 3 of '1+': found the end of the formula" VALUE},
    {"*2", "column 1 of '*2': found '*'" VALUE},
    {"2**3", "column 3 of '2**3': found '*'" VALUE "; write ^ for a power"},
    {"2*/3", "column 3 of '2*/3': found '/'" VALUE},
    {"()", "column 2 of '()': found ')'" VALUE},
    {"1+<2", "column 3 of '1+<2': found '<'" VALUE},
    {"sin(,1)", "column 5 of 'sin(,1)': found ','" VALUE},
    {"min(1,)", "column 7 of 'min(1,)': found ')'" VALUE},
    {"(1+2",
     "column 5 of '(1+2': found the end of the formula, but the '(' at column 1 is not closed; write ')'"},
    {"2*(1+(2)", "column 9 of '2*(1+(2)': found the end of the formula, but the '(' at column 3 is not "
                 "closed; write ')'"},
    {"sin(t", "column 6 of 'sin(t': found the end of the formula, but the '(' at column 4 is not closed; "
              "write ')' or ','"},
    {"1)", "column 2 of '1)': found ')' without a '(' before it"},
    {"2 t", "column 3 of '2 t': found 't'" MULTIPLY},
    {"2pi", "column 2 of '2pi': found 'pi'" MULTIPLY},
    {"2(3)", "column 2 of '2(3)': found '('" MULTIPLY},
    {"(2)(3)", "column 4 of '(2)(3)': found '('" MULTIPLY},
    {"(2 3)", "column 4 of '(2 3)': found '3'" MULTIPLY},
    {"1.2.3", "column 4 of '1.2.3': found '.3'" MULTIPLY},
    {"0x10", "column 2 of '0x10': found 'x10'" MULTIPLY},
    {"1e", "column 2 of '1e': found 'e'" MULTIPLY},
    {"2,5",
     "column 2 of '2,5': found ',' outside the arguments of a function; decimals are written with a point"},
    {"(2,5)",
     "column 3 of '(2,5)': found ',' outside the arguments of a function; decimals are written with a point"},
    {"1 < t < 2", "column 7 of '1 < t < 2': found '<' after a comparison; comparisons are not chained, write "
                  "(a < b)*(b < c)"},
    {"1e999", "column 1 of '1e999': the number is too large; the largest is about 1.797e308"},
    {"t = 2", "column 3 of 't = 2': found '='; write == to compare"},
    {"= 2", "column 1 of '= 2': found '='; write == to compare"},
    {"1 & 2",
     "column 3 of '1 & 2': found '&'; multiply two comparisons to ask for both, as in (t > 1)*(t < 2)"},
    {"1 | 2", "column 3 of '1 | 2': found '|'; use max(a, b) of two comparisons to ask for either"},
    {"!t", "column 1 of '!t': found '!'; write != for 'not equal', or 1 - c for 'not c'"},
    {"5 % 2", "column 3 of '5 % 2': found '%'; write mod(a, b) for the remainder"},
    {"[1]", "column 1 of '[1]': found '['; use round parentheses"},
    {"{1}", "column 1 of '{1}': found '{'; use round parentheses"},
    {"3$", "column 2 of '3$': found '$', which has no meaning in a formula"},
    {"1.", NULL},
    {".", "column 1 of '.': found '.', which has no meaning in a formula"},
    {"2\xC2\xB7pi", "column 2 of '2\xC2\xB7pi': found '\xC2\xB7', which has no meaning in a formula"},
    {"1\x01", "column 2 of '1?': found a control character (code 1), which has no meaning in a formula"},
    {"1\n+\n", "column 5 of '1 + ': found the end of the formula" VALUE},
    {"sin()", "column 1 of 'sin()': sin takes 1 argument, found 0"},
    {"sin(1,2)", "column 1 of 'sin(1,2)': sin takes 1 argument, found more"},
    {"1+atan2(1)", "column 3 of '1+atan2(1)': atan2 takes 2 arguments, found 1"},
    {"if(t>1,2)", "column 1 of 'if(t>1,2)': if takes 3 arguments, found 2"},
    {"step()", "column 1 of 'step()': step takes 1 or 2 arguments, found 0"},
    {"step(1,2,3)", "column 1 of 'step(1,2,3)': step takes 1 or 2 arguments, found more"},
    {"max(1)", "column 1 of 'max(1)': max takes 2 or more arguments, found 1"},
    {"sin", "column 1 of 'sin': 'sin' is a function; write its arguments in parentheses, as in sin(...)"},
    {"sin t", "column 1 of 'sin t': 'sin' is a function; write its arguments in parentheses, as in sin(...)"},
    {"t(3)", "column 1 of 't(3)': 't' is not a function; write t*(...) to multiply"},
    {"pi (3)", "column 1 of 'pi (3)': 'pi' is not a function; write pi*(...) to multiply"},
    {"alpha(3)", "column 1 of 'alpha(3)': 'alpha' is not a function; write alpha*(...) to multiply"},
    {"1+x", "column 3 of '1+x': 'x' (position) cannot be used here; " HERE},
    {"u", "column 1 of 'u': 'u' (relative arc length) cannot be used here; " HERE},
    {"foo", "column 1 of 'foo': unknown name 'foo'; " HERE},
    {"nan", "column 1 of 'nan': unknown name 'nan'; " HERE},
    {"inf", "column 1 of 'inf': unknown name 'inf'; " HERE},
    {"alhpa*2", "column 1 of 'alhpa*2': unknown name 'alhpa', did you mean 'alpha'? " HERE},
    {"PI", "column 1 of 'PI': unknown name 'PI', did you mean 'pi'? " HERE},
    {"2*T", "column 3 of '2*T': unknown name 'T', did you mean 't'? " HERE},
    {"L", "column 1 of 'L': 'L' is a parameter and also a name that formulas have; rename the parameter"},
    {"sni(t)", "column 1 of 'sni(t)': unknown function 'sni', did you mean 'sin'? " FUNCTIONS},
    {"Sqrt(t)", "column 1 of 'Sqrt(t)': unknown function 'Sqrt', did you mean 'sqrt'? " FUNCTIONS},
    {"smothstep(0,1,t)",
     "column 1 of 'smothstep(0,1,t)': unknown function 'smothstep', did you mean 'smoothstep'? " FUNCTIONS},
    {"frobnicate(t)", "column 1 of 'frobnicate(t)': unknown function 'frobnicate'; " FUNCTIONS},
    {"(((((((((((((((((((((((((((((((((((((((((((((((((((t + 1 + 2 + 3 + 4 + 5 + 6 + 7 + 8 + foo",
     "column 88 of '...(((((((((((((((((((((((((t + 1 + 2 + 3 + 4 + 5 + 6 + 7 + 8 + foo': unknown name "
     "'foo'; " HERE},
};

/* Every sentence, to the letter. */
static void test_sentences(void **state) {
  (void)state;
  const hb_parameter parameters[] = {{(char *)"alpha", 2.5}, {(char *)"L", 4}};
  for (size_t k = 0; k < sizeof broken / sizeof broken[0]; k++) {
    hb_formula *formula = NULL;
    hb_error err = {HB_OK, ""};
    hb_status status = hb_formula_parse(broken[k].text, HB_VARS_TIME, parameters, 2, &formula, &err);
    if (!broken[k].sentence) {
      assert_int_equal(status, HB_OK);
      hb_formula_free(formula);
      continue;
    }
    assert_int_equal(status, HB_ERR_INPUT);
    assert_int_equal(err.status, HB_ERR_INPUT);
    assert_null(formula);
    assert_string_equal(err.text, broken[k].sentence);
    assert_int_equal(hb_formula_parse(broken[k].text, HB_VARS_TIME, parameters, 2, &formula, NULL),
                     HB_ERR_INPUT);
  }
}

/* The list of what is available: variables by place, parameters cut after twelve; NULL is an empty text. */
static void test_available(void **state) {
  (void)state;
  static const char *const names[] = {"p0", "p1", "p2", "p3", "p4", "p5", "p6",
                                      "p7", "p8", "p9", "q0", "q1", "q2", "q3"};
  hb_parameter parameters[14];
  for (int k = 0; k < 14; k++) parameters[k] = (hb_parameter){(char *)names[k], k};
  hb_formula *formula = NULL;
  hb_error err;
  assert_int_equal(hb_formula_parse("what", HB_VARS_ARC, parameters, 14, &formula, &err), HB_ERR_INPUT);
  assert_string_equal(err.text,
                      "column 1 of 'what': unknown name 'what'; available here are s, u, i, L, pi, e and the "
                      "parameters p0, p1, p2, p3, p4, p5, p6, p7, p8, p9, q0, q1 and 2 more");
  assert_int_equal(hb_formula_parse("what", HB_VARS_NONE, parameters, 1, &formula, &err), HB_ERR_INPUT);
  assert_string_equal(
      err.text, "column 1 of 'what': unknown name 'what'; available here are pi, e and the parameter p0");
  assert_int_equal(hb_formula_parse("t", HB_VARS_PLACE, NULL, 0, &formula, &err), HB_ERR_INPUT);
  assert_string_equal(err.text,
                      "column 1 of 't': 't' (time) cannot be used here; available here are x, y, z, pi, e");
  assert_int_equal(hb_formula_parse(NULL, HB_VARS_NONE, NULL, 0, &formula, &err), HB_ERR_INPUT);
  assert_string_equal(err.text, EMPTY);
}

/* Limits: length, nesting, values held back. */
static void test_limits(void **state) {
  (void)state;
  static char text[5000];
  hb_formula *formula = NULL;
  hb_error err;
  memset(text, ' ', sizeof text);
  text[4095] = '1';
  text[4096] = '\0';
  assert_same(constant(text), 1);
  text[4096] = ' ';
  text[4097] = '\0';
  assert_int_equal(hb_formula_parse(text, HB_VARS_NONE, NULL, 0, &formula, &err), HB_ERR_INPUT);
  assert_string_equal(err.text, "the formula has 4097 characters; at most 4096 are allowed");

  memset(text, '-', 200);
  strcpy(text + 199, "1");
  assert_same(constant(text), -1);
  strcpy(text + 199, "-1");
  assert_int_equal(hb_formula_parse(text, HB_VARS_NONE, NULL, 0, &formula, &err), HB_ERR_INPUT);
  assert_string_equal(err.text,
                      "column 201 of '...---------------------------------------------------------------1': "
                      "the formula is nested more than 200 deep");

  size_t n = 0;
  for (int k = 0; k < 127; k++) n += (size_t)snprintf(text + n, sizeof text - n, "t+t*(");
  n += (size_t)snprintf(text + n, sizeof text - n, "t*t");
  memset(text + n, ')', 127);
  text[n + 127] = '\0';
  formula = compiled(text, HB_VARS_TIME);
  double vars[HB_VAR_COUNT] = {0.5};
  assert_near(hb_formula_eval(formula, vars), 1 - 0.5 * ldexp(1, -126) * 1.0, 1e-15);
  hb_formula_free(formula);
  n = 0;
  for (int k = 0; k < 128; k++) n += (size_t)snprintf(text + n, sizeof text - n, "t+t*(");
  snprintf(text + n, sizeof text - n, "t");
  assert_int_equal(hb_formula_parse(text, HB_VARS_TIME, NULL, 0, &formula, &err), HB_ERR_INPUT);
  assert_non_null(
      strstr(err.text, "': the formula holds back more than 256 intermediate values; put it more simply"));
}

/* A cut through a character of several bytes leaves neither half in the sentence. */
static void test_excerpt(void **state) {
  (void)state;
  char text[200];
  size_t n = (size_t)snprintf(text, sizeof text, "$");
  for (int k = 0; k < 60; k++) n += (size_t)snprintf(text + n, sizeof text - n, "\xC2\xB7");
  hb_formula *formula = NULL;
  hb_error err;
  assert_int_equal(hb_formula_parse(text, HB_VARS_NONE, NULL, 0, &formula, &err), HB_ERR_INPUT);
  const char *cut = strstr(err.text, "...': found '$'");
  assert_non_null(cut);
  assert_int_equal((unsigned char)cut[-1], 0xB7);
  memset(text, 0xB7, 150);
  text[150] = '\0';
  assert_int_equal(hb_formula_parse(text, HB_VARS_NONE, NULL, 0, &formula, &err), HB_ERR_INPUT);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_values),         cmocka_unit_test(test_rates),
      cmocka_unit_test(test_rates_at_kinks), cmocka_unit_test(test_rate_holds_the_rest),
      cmocka_unit_test(test_precedence),     cmocka_unit_test(test_ieee),
      cmocka_unit_test(test_numbers),        cmocka_unit_test(test_questions),
      cmocka_unit_test(test_constant),       cmocka_unit_test(test_parameters),
      cmocka_unit_test(test_folding),        cmocka_unit_test(test_random_rates),
      cmocka_unit_test(test_sentences),      cmocka_unit_test(test_available),
      cmocka_unit_test(test_limits),         cmocka_unit_test(test_excerpt),
      cmocka_unit_test(test_noise),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
