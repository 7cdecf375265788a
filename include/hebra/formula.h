/* hebra/formula.h - arithmetic formulas such as `3*pi`, `sin(2*pi*t)`, `0.1*x + s/L`.
 *
 * A formula is compiled once and evaluated often; evaluation allocates nothing and cannot fail.
 * Grammar: + - * / ^ (right associative, binds tighter than unary minus), parentheses, numbers, comparison <
 * <= > >=
 * == != giving 0 or 1, `if(c, a, b)`, functions sin cos tan asin acos atan atan2 sinh cosh tanh exp log log10
 * sqrt abs floor ceil min max mod sign step clamp smoothstep pow hypot noise, constants pi e. */
#ifndef HEBRA_FORMULA_H
#define HEBRA_FORMULA_H

#include "hebra/base.h"

#ifdef __cplusplus
extern "C" {
#endif

/* The variables a formula may read; which ones are allowed depends on where it stands in the scene. */
typedef enum hb_variable {
  HB_VAR_T, /* `t` time */
  HB_VAR_S, /* `s` arc length from the first vertex in the rest shape */
  HB_VAR_U, /* `u` arc length divided by the rod's length, 0 .. 1 */
  HB_VAR_X, /* `x`, `y`, `z` position (where a force acts now, or the initial position of a support) */
  HB_VAR_Y,
  HB_VAR_Z,
  HB_VAR_I, /* `i` index of the vertex or edge, from 0 */
  HB_VAR_L, /* `L` rest length of the rod */
  HB_VAR_COUNT
} hb_variable;
#define HB_VAR_BIT(v) (1u << (v))
#define HB_VARS_NONE 0u
#define HB_VARS_TIME HB_VAR_BIT(HB_VAR_T)
#define HB_VARS_ARC                                                                                          \
  (HB_VAR_BIT(HB_VAR_S) | HB_VAR_BIT(HB_VAR_U) | HB_VAR_BIT(HB_VAR_I) | HB_VAR_BIT(HB_VAR_L))
#define HB_VARS_PLACE (HB_VAR_BIT(HB_VAR_X) | HB_VAR_BIT(HB_VAR_Y) | HB_VAR_BIT(HB_VAR_Z))
#define HB_VARS_ALL (HB_VARS_TIME | HB_VARS_ARC | HB_VARS_PLACE)

/* A named constant that a scene defines under `parameters`. */
typedef struct hb_parameter {
  char *name;
  double value;
} hb_parameter;

typedef struct hb_formula hb_formula;

/* Compiles text. allowed: bit set of HB_VAR_BIT. parameters may be NULL if count is 0.
 * On error the sentence says the column inside text (from 1) and, for an unknown name, the nearest known one.
 */
hb_status hb_formula_parse(const char *text, unsigned allowed, const hb_parameter *parameters, int count,
                           hb_formula **out, hb_error *err);
/* A formula that is the number value. */
hb_status hb_formula_constant(double value, hb_formula **out, hb_error *err);
void hb_formula_free(hb_formula *formula); /* NULL is allowed */

double hb_formula_eval(const hb_formula *formula, const double vars[HB_VAR_COUNT]);
/* Value and exact derivative by time (dual numbers; x, y, z, s, u, i, L held). */
void hb_formula_eval_dt(const hb_formula *formula, const double vars[HB_VAR_COUNT], double *value,
                        double *rate);
bool hb_formula_is_constant(const hb_formula *formula);
bool hb_formula_uses(const hb_formula *formula, hb_variable variable);
const char *hb_formula_text(const hb_formula *formula); /* as it was written; owned by the formula */

#ifdef __cplusplus
}
#endif
#endif
