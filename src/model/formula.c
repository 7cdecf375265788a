#include "hebra/formula.h"

#include "base/memory.h"
#include "model/formula_number.h"
#include "model/formula_program.h"

#include <math.h>
#include <string.h>

/* An empty formula that owns a copy of text. */
static hb_status create(const char *text, hb_formula **out, hb_error *err) {
  hb_formula *formula = hb_alloc(1, sizeof *formula);
  if (formula) formula->text = hb_strdup(text);
  if (!formula || !formula->text) {
    hb_formula_free(formula);
    return hb_fail_memory(err, "a formula");
  }
  *out = formula;
  return HB_OK;
}

/* Length check, then the compiler. */
hb_status hb_formula_parse(const char *text, unsigned allowed, const hb_parameter *parameters, int count,
                           hb_formula **out, hb_error *err) {
  *out = NULL;
  size_t length = text ? strlen(text) : 0;
  if (length > HB_FORMULA_TEXT_MAX)
    return hb_fail(err, HB_ERR_INPUT, "the formula has %zu characters; at most %d are allowed", length,
                   HB_FORMULA_TEXT_MAX);
  hb_formula *formula = NULL;
  hb_status status = create(text ? text : "", &formula, err);
  if (status != HB_OK) return status;
  status = hb_formula_compile(formula, allowed, parameters, count, err);
  if (status != HB_OK) {
    hb_formula_free(formula);
    return status;
  }
  *out = formula;
  return HB_OK;
}

/* One instruction. */
hb_status hb_formula_constant(double value, hb_formula **out, hb_error *err) {
  *out = NULL;
  if (!isfinite(value))
    return hb_fail(err, HB_ERR_INPUT, "a formula cannot stand for %s; a finite number is needed",
                   isnan(value) ? "not-a-number" : "infinity");
  char text[40];
  hb_number_print(value, text);
  hb_formula *formula = NULL;
  hb_status status = create(text, &formula, err);
  if (status != HB_OK) return status;
  formula->code = hb_alloc(1, sizeof *formula->code);
  if (!formula->code) {
    hb_formula_free(formula);
    return hb_fail_memory(err, "a formula");
  }
  formula->code[0] = (hb_instruction){HB_OP_CONSTANT, HB_VAR_T, value};
  formula->count = 1;
  *out = formula;
  return HB_OK;
}

/* Everything that create and the compiler allocate. */
void hb_formula_free(hb_formula *formula) {
  if (!formula) return;
  hb_free(formula->code);
  hb_free(formula->text);
  hb_free(formula);
}

/* Runs the program. The compiler has made sure that the stack suffices and ends with one value. */
double hb_formula_eval(const hb_formula *formula, const double vars[HB_VAR_COUNT]) {
  const hb_instruction *code = formula->code;
  if (formula->count == 1 && code->op == HB_OP_CONSTANT) return code->constant;
  double stack[HB_FORMULA_STACK_MAX];
  int top = 0;
  for (int k = 0; k < formula->count; k++) {
    const hb_instruction *in = &code[k];
    if (in->op == HB_OP_CONSTANT) {
      stack[top++] = in->constant;
    } else if (in->op == HB_OP_VARIABLE) {
      stack[top++] = vars[in->variable];
    } else {
      double operands[3] = {0, 0, 0};
      int n = hb_op_operands(in->op);
      top -= n;
      for (int j = 0; j < n; j++) operands[j] = stack[top + j];
      stack[top++] = hb_op_value(in->op, operands);
    }
  }
  return stack[0];
}

/* The same with a second stack of rates. The value is that of hb_formula_eval, bit for bit. */
void hb_formula_eval_dt(const hb_formula *formula, const double vars[HB_VAR_COUNT], double *value,
                        double *rate) {
  double stack[HB_FORMULA_STACK_MAX], speed[HB_FORMULA_STACK_MAX];
  int top = 0;
  for (int k = 0; k < formula->count; k++) {
    const hb_instruction *in = &formula->code[k];
    if (in->op == HB_OP_CONSTANT) {
      stack[top] = in->constant;
      speed[top++] = 0;
    } else if (in->op == HB_OP_VARIABLE) {
      stack[top] = vars[in->variable];
      speed[top++] = in->variable == HB_VAR_T ? 1 : 0;
    } else {
      double operands[3] = {0, 0, 0}, rates[3] = {0, 0, 0};
      int n = hb_op_operands(in->op);
      top -= n;
      for (int j = 0; j < n; j++) {
        operands[j] = stack[top + j];
        rates[j] = speed[top + j];
      }
      stack[top] = hb_op_value(in->op, operands);
      speed[top] = hb_op_rate(in->op, operands, stack[top], rates);
      top++;
    }
  }
  *value = stack[0];
  *rate = speed[0];
}

/* Constants are folded, so a formula of constants is one instruction. */
bool hb_formula_is_constant(const hb_formula *formula) {
  return formula->count == 1 && formula->code[0].op == HB_OP_CONSTANT;
}

/* Also true where the variable stands in a branch that is never taken. */
bool hb_formula_uses(const hb_formula *formula, hb_variable variable) {
  return (formula->uses & HB_VAR_BIT((unsigned)variable)) != 0;
}

/* The copy that create made. */
const char *hb_formula_text(const hb_formula *formula) { return formula->text; }
