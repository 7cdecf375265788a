/* Fuzz target: text to formula. A formula that compiles evaluates, gives the same value with and without its
 * rate, and compiles again from its own text; one that does not says why in a sentence. */
#include "hebra/formula.h"

#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

/* Ends the program where a promise is broken, so that the fuzzer keeps the input. */
static void require(bool promise) {
  if (!promise) abort();
}

/* The same number, or both not-a-number. */
static bool same(double a, double b) { return a == b || (isnan(a) && isnan(b)); }

/* Evaluates in every way at one place. */
static void evaluate(const hb_formula *formula, const double vars[HB_VAR_COUNT]) {
  double value, rate, plain = hb_formula_eval(formula, vars);
  hb_formula_eval_dt(formula, vars, &value, &rate);
  require(same(value, plain));
  if (!hb_formula_uses(formula, HB_VAR_T)) require(rate == 0 || isnan(rate));
}

/* A second compilation of the formula's text, and one with every variable forbidden. */
static void again(const hb_formula *formula, const hb_parameter *parameters,
                  const double vars[HB_VAR_COUNT]) {
  hb_formula *twin = NULL, *closed = NULL;
  require(hb_formula_parse(hb_formula_text(formula), HB_VARS_ALL, parameters, 2, &twin, NULL) == HB_OK);
  require(same(hb_formula_eval(twin, vars), hb_formula_eval(formula, vars)));
  bool reads = false;
  for (int k = 0; k < HB_VAR_COUNT; k++) reads = reads || hb_formula_uses(formula, (hb_variable)k);
  hb_status status = hb_formula_parse(hb_formula_text(formula), HB_VARS_NONE, parameters, 2, &closed, NULL);
  require(status == (reads ? HB_ERR_INPUT : HB_OK));
  if (closed) require(hb_formula_is_constant(closed));
  hb_formula_free(closed);
  hb_formula_free(twin);
}

/* One input. */
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  static const double places[3][HB_VAR_COUNT] = {{0, 0, 0, 0, 0, 0, 0, 1},
                                                 {0.5, 1, 0.25, -1, 2, 0.125, 7, 3},
                                                 {-1e3, 1e10, 1, 1e-9, -3, 1e200, 99, 1e3}};
  char alpha[] = "alpha", k2[] = "k_2";
  const hb_parameter parameters[] = {{alpha, 2.5}, {k2, -4}};
  char *text = malloc(size + 1);
  if (!text) return 0;
  if (size) memcpy(text, data, size);
  text[size] = '\0';
  hb_formula *formula = NULL;
  hb_error err = {HB_OK, ""};
  hb_status status = hb_formula_parse(text, HB_VARS_ALL, parameters, 2, &formula, &err);
  if (status == HB_OK) {
    require(strcmp(hb_formula_text(formula), text) == 0);
    for (int k = 0; k < 3; k++) evaluate(formula, places[k]);
    again(formula, parameters, places[1]);
  } else {
    require(formula == NULL && status == HB_ERR_INPUT && err.status == status && strlen(err.text) > 10);
  }
  hb_formula_free(formula);
  free(text);
  return 0;
}
