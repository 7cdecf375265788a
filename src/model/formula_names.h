/* The names that a formula knows, and the sentences about names that it does not. Private to the model room.
 */
#ifndef HB_MODEL_FORMULA_NAMES_H
#define HB_MODEL_FORMULA_NAMES_H

#include "model/formula_program.h"

typedef struct hb_function {
  const char *name;
  hb_op op;
  int least, most; /* arguments; most < 0: any number, folded from the left */
} hb_function;

/* A name as it stands in the text, not zero-terminated. */
typedef struct hb_name {
  const char *at;
  size_t length;
} hb_name;

/* A text that is put together piece by piece and cut where it does not fit. */
typedef struct hb_phrase {
  char text[768];
  size_t length;
} hb_phrase;
void hb_phrase_add(hb_phrase *phrase, const char *format, ...) HB_PRINTF(2, 3);

const hb_function *hb_function_find(hb_name name);     /* NULL if there is none */
bool hb_variable_find(hb_name name, hb_variable *out); /* whether allowed here or not */
bool hb_builtin_constant(hb_name name, double *value); /* pi, e */
const hb_parameter *hb_parameter_find(hb_name name, const hb_parameter *parameters, int count);

/* True if a parameter must not have this name because every formula has its own meaning for it. */
bool hb_formula_reserves(const char *name);

/* The sentence for a name that has no value here: why, the nearest known one, what is available. */
void hb_name_unknown(hb_name name, unsigned allowed, const hb_parameter *parameters, int count,
                     hb_phrase *out);
/* The sentence for a call of something that is no function. */
void hb_function_unknown(hb_name name, const hb_parameter *parameters, int count, hb_phrase *out);

#endif
