/* What a formula is compiled to: instructions for a stack of doubles. Private to the model room. */
#ifndef HB_MODEL_FORMULA_PROGRAM_H
#define HB_MODEL_FORMULA_PROGRAM_H

#include "hebra/formula.h"

/* Most characters of a formula, deepest nesting of parentheses and signs, most intermediate values. */
#define HB_FORMULA_TEXT_MAX 4096
#define HB_FORMULA_NESTING_MAX 200
#define HB_FORMULA_STACK_MAX 256

/* Ordered by the number of operands, see hb_op_operands. */
typedef enum hb_op {
  HB_OP_CONSTANT,
  HB_OP_VARIABLE,
  HB_OP_NEGATE, /* first with one operand */
  HB_OP_SIN,
  HB_OP_COS,
  HB_OP_TAN,
  HB_OP_ASIN,
  HB_OP_ACOS,
  HB_OP_ATAN,
  HB_OP_SINH,
  HB_OP_COSH,
  HB_OP_TANH,
  HB_OP_EXP,
  HB_OP_LOG,
  HB_OP_LOG10,
  HB_OP_SQRT,
  HB_OP_ABS,
  HB_OP_FLOOR,
  HB_OP_CEIL,
  HB_OP_SIGN,
  HB_OP_STEP,
  HB_OP_NOISE,
  HB_OP_ADD, /* first with two operands */
  HB_OP_SUBTRACT,
  HB_OP_MULTIPLY,
  HB_OP_DIVIDE,
  HB_OP_POWER,
  HB_OP_LESS,
  HB_OP_LESS_EQUAL,
  HB_OP_GREATER,
  HB_OP_GREATER_EQUAL,
  HB_OP_EQUAL,
  HB_OP_NOT_EQUAL,
  HB_OP_ATAN2,
  HB_OP_MIN,
  HB_OP_MAX,
  HB_OP_MOD,
  HB_OP_HYPOT,
  HB_OP_NOISE_2,
  HB_OP_IF, /* first with three operands */
  HB_OP_CLAMP,
  HB_OP_SMOOTHSTEP
} hb_op;

typedef struct hb_instruction {
  hb_op op;
  hb_variable variable; /* HB_OP_VARIABLE */
  double constant;      /* HB_OP_CONSTANT */
} hb_instruction;

struct hb_formula {
  hb_instruction *code;
  int count;
  unsigned uses; /* bit set of the variables read */
  char *text;
};

/* Operands of an operation: 0, 1, 2 or 3. */
static inline int hb_op_operands(hb_op op) {
  if (op < HB_OP_NEGATE) return 0;
  if (op < HB_OP_ADD) return 1;
  return op < HB_OP_IF ? 2 : 3;
}

/* Value of an operation that is neither a constant nor a variable; operands in the order written. */
double hb_op_value(hb_op op, const double operands[3]);
/* Its rate of change when the operands change at the given rates. Where the value has a kink it is the rate
 * just after; where it jumps, the jump is left out. An operand at rest contributes 0 whatever its slope. */
double hb_op_rate(hb_op op, const double operands[3], double value, const double rates[3]);

/* Compiles text (not NULL, at most HB_FORMULA_TEXT_MAX characters) into formula, which is empty. On failure
 * the caller frees what formula holds. */
hb_status hb_formula_compile(hb_formula *formula, unsigned allowed, const hb_parameter *parameters, int count,
                             hb_error *err);

#endif
