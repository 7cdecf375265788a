#include "base/memory.h"
#include "model/formula_names.h"
#include "model/formula_number.h"
#include "model/formula_program.h"

#include <math.h>
#include <string.h>

/* Bytes of the formula that a sentence repeats around the place of the error. */
#define EXCERPT 64

typedef enum token_kind {
  TOKEN_END,
  TOKEN_NUMBER,
  TOKEN_NAME,
  TOKEN_OPEN,
  TOKEN_CLOSE,
  TOKEN_COMMA,
  TOKEN_OPERATOR,   /* + - * / ^ : op says which */
  TOKEN_COMPARISON, /* < <= > >= == != : op says which */
  TOKEN_STRANGE     /* anything else */
} token_kind;

typedef struct token {
  token_kind kind;
  size_t at, length;
  hb_op op;
  double number;
} token;

/* A parse on its way. status stays HB_OK until the first error, whose sentence it keeps. */
typedef struct parser {
  hb_formula *formula;
  size_t length;
  token now;
  unsigned allowed;
  const hb_parameter *parameters;
  int parameter_count;
  int room;    /* instructions that fit into formula->code */
  int stack;   /* intermediate values at this place of the program */
  int nesting; /* of parentheses, signs and powers */
  hb_status status;
  hb_error *err;
} parser;

static bool expression(parser *p);

/* Blanks and line ends, which YAML may leave inside a formula. */
static bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; }
/* ASCII only: isdigit depends on the locale. */
static bool is_digit(char c) { return c >= '0' && c <= '9'; }
/* ASCII letters and the underscore. */
static bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; }
/* True for the second and later bytes of a character in UTF-8. */
static bool is_tail(char c) { return ((unsigned char)c & 0xC0u) == 0x80u; }

/* ---- sentences
 * ---------------------------------------------------------------------------------------------- */

/* The formula, or the part of it around a place, on one line. */
static void excerpt(const parser *p, size_t around, hb_phrase *out) {
  const char *text = p->formula->text;
  size_t from = 0, to = p->length;
  if (p->length > EXCERPT) {
    from = around > EXCERPT / 2 ? around - EXCERPT / 2 : 0;
    if (from > p->length - EXCERPT) from = p->length - EXCERPT;
    to = from + EXCERPT < p->length ? from + EXCERPT : p->length;
    while (from < around && is_tail(text[from])) from++;
    while (to > from && to < p->length && is_tail(text[to])) to--;
  }
  if (from > 0) hb_phrase_add(out, "...");
  for (size_t k = from; k < to; k++) {
    bool control = (unsigned char)text[k] < 32 || text[k] == 127;
    hb_phrase_add(out, "%c", !control ? text[k] : is_blank(text[k]) ? ' ' : '?');
  }
  if (to < p->length) hb_phrase_add(out, "...");
}

/* Notes the first error as "column N of 'FORMULA': PHRASE". Always false, for `return complain(...)`. */
static bool complain(parser *p, size_t at, const hb_phrase *phrase) {
  if (p->status != HB_OK) return false;
  hb_phrase shown = {{0}, 0};
  excerpt(p, at, &shown);
  p->status = hb_fail(p->err, HB_ERR_INPUT, "column %zu of '%s': %s", at + 1, shown.text, phrase->text);
  return false;
}

/* The same for a fixed sentence. */
static bool complain_text(parser *p, size_t at, const char *text) {
  hb_phrase phrase = {{0}, 0};
  hb_phrase_add(&phrase, "%s", text);
  return complain(p, at, &phrase);
}

/* "found ')'" or "found the end of the formula". */
static void found(const parser *p, hb_phrase *out) {
  const char *text = p->formula->text + p->now.at;
  int length = p->now.length > 40 ? 40 : (int)p->now.length;
  if (p->now.kind == TOKEN_END)
    hb_phrase_add(out, "found the end of the formula");
  else if (length == 1 && ((unsigned char)text[0] < 32 || text[0] == 127))
    hb_phrase_add(out, "found a control character (code %d)", text[0]);
  else
    hb_phrase_add(out, "found '%.*s'", length, text);
}

/* What to write instead of an operator of another language, or NULL. */
static const char *advice(const parser *p) {
  switch (p->formula->text[p->now.at]) {
  case '=': return "write == to compare";
  case '&': return "multiply two comparisons to ask for both, as in (t > 1)*(t < 2)";
  case '|': return "use max(a, b) of two comparisons to ask for either";
  case '!': return "write != for 'not equal', or 1 - c for 'not c'";
  case '%': return "write mod(a, b) for the remainder";
  case '[':
  case '{': return "use round parentheses";
  default: return NULL;
  }
}

/* A character that no formula contains. */
static bool complain_strange(parser *p) {
  hb_phrase phrase = {{0}, 0};
  const char *better = advice(p);
  found(p, &phrase);
  if (better)
    hb_phrase_add(&phrase, "; %s", better);
  else
    hb_phrase_add(&phrase, ", which has no meaning in a formula");
  return complain(p, p->now.at, &phrase);
}

/* A token where a value has to begin. */
static bool complain_value(parser *p) {
  if (p->now.kind == TOKEN_STRANGE) return complain_strange(p);
  hb_phrase phrase = {{0}, 0};
  found(p, &phrase);
  hb_phrase_add(&phrase, " where a value is needed: a number, a name, a function or '('");
  bool power = p->now.kind == TOKEN_OPERATOR && p->now.op == HB_OP_MULTIPLY && p->now.at > 0 &&
               p->formula->text[p->now.at - 1] == '*';
  if (power) hb_phrase_add(&phrase, "; write ^ for a power");
  return complain(p, p->now.at, &phrase);
}

/* A token behind a complete expression. open: place of a parenthesis that is still open, or the length. */
static bool complain_after(parser *p, size_t open, bool arguments) {
  if (p->now.kind == TOKEN_STRANGE) return complain_strange(p);
  hb_phrase phrase = {{0}, 0};
  found(p, &phrase);
  switch (p->now.kind) {
  case TOKEN_NUMBER:
  case TOKEN_NAME:
  case TOKEN_OPEN: hb_phrase_add(&phrase, " directly after a value; write * to multiply"); break;
  case TOKEN_COMPARISON:
    hb_phrase_add(&phrase, " after a comparison; comparisons are not chained, write (a < b)*(b < c)");
    break;
  case TOKEN_COMMA:
    hb_phrase_add(&phrase, " outside the arguments of a function; decimals are written with a point");
    break;
  case TOKEN_CLOSE: hb_phrase_add(&phrase, " without a '(' before it"); break;
  default:
    hb_phrase_add(&phrase, ", but the '(' at column %zu is not closed; %s", open + 1,
                  arguments ? "write ')' or ','" : "write ')'");
    break;
  }
  return complain(p, p->now.at, &phrase);
}

/* ---- tokens
 * ------------------------------------------------------------------------------------------------- */

/* Sets kind and op of a token of one or two characters that is neither a number nor a name. */
static void read_sign(token *out, char c, char next) {
  out->length = 1;
  out->kind = TOKEN_OPERATOR;
  switch (c) {
  case '+': out->op = HB_OP_ADD; return;
  case '-': out->op = HB_OP_SUBTRACT; return;
  case '*': out->op = HB_OP_MULTIPLY; return;
  case '/': out->op = HB_OP_DIVIDE; return;
  case '^': out->op = HB_OP_POWER; return;
  case '(': out->kind = TOKEN_OPEN; return;
  case ')': out->kind = TOKEN_CLOSE; return;
  case ',': out->kind = TOKEN_COMMA; return;
  default: break;
  }
  out->kind = TOKEN_COMPARISON;
  if (next == '=') out->length = 2;
  if (c == '<')
    out->op = next == '=' ? HB_OP_LESS_EQUAL : HB_OP_LESS;
  else if (c == '>')
    out->op = next == '=' ? HB_OP_GREATER_EQUAL : HB_OP_GREATER;
  else if (c == '=' && next == '=')
    out->op = HB_OP_EQUAL;
  else if (c == '!' && next == '=')
    out->op = HB_OP_NOT_EQUAL;
  else
    *out = (token){TOKEN_STRANGE, out->at, 1, HB_OP_CONSTANT, 0};
}

/* Moves on to the token after the present one. A number too large for a double is an error. */
static bool advance(parser *p) {
  const char *text = p->formula->text;
  size_t at = p->now.at + p->now.length;
  while (at < p->length && is_blank(text[at])) at++;
  p->now = (token){TOKEN_END, at, 0, HB_OP_CONSTANT, 0};
  if (at == p->length) return true;
  char c = text[at];
  size_t end = at;
  if (is_digit(c) || (c == '.' && is_digit(text[at + 1]))) {
    p->now.kind = TOKEN_NUMBER;
    p->now.length = hb_number_scan(text + at, p->length - at, &p->now.number);
    if (isfinite(p->now.number)) return true;
    return complain_text(p, at, "the number is too large; the largest is about 1.797e308");
  }
  if (is_letter(c)) {
    while (end < p->length && (is_letter(text[end]) || is_digit(text[end]))) end++;
    p->now.kind = TOKEN_NAME;
    p->now.length = end - at;
    return true;
  }
  read_sign(&p->now, c, text[at + 1]);
  if (p->now.kind == TOKEN_STRANGE)
    while (at + p->now.length < p->length && is_tail(text[at + p->now.length])) p->now.length++;
  return true;
}

/* ---- program
 * ------------------------------------------------------------------------------------------------ */

/* Appends an instruction; its place is *out. */
static bool append(parser *p, hb_instruction instruction) {
  hb_formula *f = p->formula;
  if (f->count == p->room) {
    int room = p->room ? 2 * p->room : 8;
    hb_instruction *grown = hb_realloc(f->code, (size_t)room, sizeof *grown);
    if (!grown) {
      p->status = hb_fail_memory(p->err, "a formula");
      return false;
    }
    f->code = grown;
    p->room = room;
  }
  f->code[f->count++] = instruction;
  return true;
}

/* Appends a constant or a variable: one more value on the stack. */
static bool push(parser *p, hb_instruction instruction) {
  if (++p->stack > HB_FORMULA_STACK_MAX) {
    hb_phrase phrase = {{0}, 0};
    hb_phrase_add(&phrase, "the formula holds back more than %d intermediate values; put it more simply",
                  HB_FORMULA_STACK_MAX);
    return complain(p, p->now.at, &phrase);
  }
  return append(p, instruction);
}

/* Appends an operation, or replaces it with its value if its operands are constants. */
static bool apply(parser *p, hb_op op) {
  int n = hb_op_operands(op);
  hb_instruction *last = p->formula->code + p->formula->count - n;
  p->stack -= n - 1;
  double operands[3] = {0, 0, 0};
  for (int k = 0; k < n; k++) {
    if (last[k].op != HB_OP_CONSTANT) return append(p, (hb_instruction){op, HB_VAR_T, 0});
    operands[k] = last[k].constant;
  }
  last[0].constant = hb_op_value(op, operands);
  p->formula->count -= n - 1;
  return true;
}

/* ---- grammar
 * ------------------------------------------------------------------------------------------------ */

/* A name that stands for a value. */
static bool named_value(parser *p, hb_name name, size_t at) {
  const hb_parameter *parameter = hb_parameter_find(name, p->parameters, p->parameter_count);
  hb_variable variable;
  double value;
  bool is_variable = hb_variable_find(name, &variable), is_constant = hb_builtin_constant(name, &value);
  hb_phrase phrase = {{0}, 0};
  if (parameter && (is_variable || is_constant)) {
    hb_phrase_add(&phrase, "'%s' is a parameter and also a name that formulas have; rename the parameter",
                  parameter->name);
    return complain(p, at, &phrase);
  }
  if (is_variable && (p->allowed & HB_VAR_BIT((unsigned)variable))) {
    p->formula->uses |= HB_VAR_BIT((unsigned)variable);
    return push(p, (hb_instruction){HB_OP_VARIABLE, variable, 0});
  }
  if (parameter || is_constant)
    return push(p, (hb_instruction){HB_OP_CONSTANT, HB_VAR_T, parameter ? parameter->value : value});
  hb_name_unknown(name, p->allowed, p->parameters, p->parameter_count, &phrase);
  return complain(p, at, &phrase);
}

/* Wrong number of arguments; more: reading stopped at the first one too many. */
static bool complain_count(parser *p, const hb_function *function, size_t at, int count, bool more) {
  hb_phrase phrase = {{0}, 0};
  hb_phrase_add(&phrase, "%s takes %d", function->name, function->least);
  if (function->most < 0)
    hb_phrase_add(&phrase, " or more");
  else if (function->most > function->least)
    hb_phrase_add(&phrase, " or %d", function->most);
  hb_phrase_add(&phrase, function->most == 1 ? " argument, found " : " arguments, found ");
  if (more)
    hb_phrase_add(&phrase, "more");
  else
    hb_phrase_add(&phrase, "%d", count);
  return complain(p, at, &phrase);
}

/* The arguments of a function behind its '(', and the ')'. min and max of many are folded from the left. */
static bool arguments(parser *p, const hb_function *function, size_t at, size_t open) {
  int count = 0;
  while (p->now.kind != TOKEN_CLOSE || count > 0) {
    if (!expression(p)) return false;
    count++;
    if (function->most < 0 && count > 1 && !apply(p, function->op)) return false;
    if (p->now.kind == TOKEN_CLOSE) break;
    if (p->now.kind != TOKEN_COMMA) return complain_after(p, open, true);
    if (count == function->most) return complain_count(p, function, at, count, true);
    if (!advance(p)) return false;
  }
  if (count < function->least) return complain_count(p, function, at, count, false);
  if (!advance(p)) return false;
  if (function->most < 0) return true;
  if (function->op == HB_OP_STEP && count == 2) return apply(p, HB_OP_LESS_EQUAL); /* step(edge, x) */
  if (function->op == HB_OP_NOISE && count == 2) return apply(p, HB_OP_NOISE_2);
  return apply(p, function->op);
}

/* A name, or a name with arguments. */
static bool name_or_call(parser *p) {
  size_t at = p->now.at;
  hb_name name = {p->formula->text + at, p->now.length};
  if (!advance(p)) return false;
  if (p->now.kind != TOKEN_OPEN) return named_value(p, name, at);
  const hb_function *function = hb_function_find(name);
  if (!function) {
    hb_phrase phrase = {{0}, 0};
    hb_function_unknown(name, p->parameters, p->parameter_count, &phrase);
    return complain(p, at, &phrase);
  }
  size_t open = p->now.at;
  return advance(p) && arguments(p, function, at, open);
}

/* Number, name, call or parenthesis. */
static bool primary(parser *p) {
  if (p->now.kind == TOKEN_NUMBER)
    return push(p, (hb_instruction){HB_OP_CONSTANT, HB_VAR_T, p->now.number}) && advance(p);
  if (p->now.kind == TOKEN_NAME) return name_or_call(p);
  if (p->now.kind != TOKEN_OPEN) return complain_value(p);
  size_t open = p->now.at;
  if (!advance(p) || !expression(p)) return false;
  if (p->now.kind != TOKEN_CLOSE) return complain_after(p, open, false);
  return advance(p);
}

/* [+|-] unary, or primary [^ unary]: -2^2 is -(2^2), 2^-1 is allowed, 2^3^2 is 2^(3^2). All recursion of the
 * grammar comes through here, so the nesting is counted here. */
static bool unary(parser *p) {
  if (p->nesting == HB_FORMULA_NESTING_MAX) {
    hb_phrase phrase = {{0}, 0};
    hb_phrase_add(&phrase, "the formula is nested more than %d deep", HB_FORMULA_NESTING_MAX);
    return complain(p, p->now.at, &phrase);
  }
  p->nesting++;
  bool sign = p->now.kind == TOKEN_OPERATOR && (p->now.op == HB_OP_ADD || p->now.op == HB_OP_SUBTRACT);
  if (sign) {
    bool minus = p->now.op == HB_OP_SUBTRACT;
    if (!advance(p) || !unary(p) || (minus && !apply(p, HB_OP_NEGATE))) return false;
  } else {
    if (!primary(p)) return false;
    if (p->now.kind == TOKEN_OPERATOR && p->now.op == HB_OP_POWER)
      if (!advance(p) || !unary(p) || !apply(p, HB_OP_POWER)) return false;
  }
  p->nesting--;
  return true;
}

/* unary {* or / unary}, from the left. */
static bool product(parser *p) {
  if (!unary(p)) return false;
  while (p->now.kind == TOKEN_OPERATOR && (p->now.op == HB_OP_MULTIPLY || p->now.op == HB_OP_DIVIDE)) {
    hb_op op = p->now.op;
    if (!advance(p) || !unary(p) || !apply(p, op)) return false;
  }
  return true;
}

/* product {+ or - product}, from the left. */
static bool sum(parser *p) {
  if (!product(p)) return false;
  while (p->now.kind == TOKEN_OPERATOR && (p->now.op == HB_OP_ADD || p->now.op == HB_OP_SUBTRACT)) {
    hb_op op = p->now.op;
    if (!advance(p) || !product(p) || !apply(p, op)) return false;
  }
  return true;
}

/* sum [comparison sum]. */
static bool expression(parser *p) {
  if (!sum(p)) return false;
  if (p->now.kind != TOKEN_COMPARISON) return true;
  hb_op op = p->now.op;
  return advance(p) && sum(p) && apply(p, op);
}

/* The whole text is one expression. */
hb_status hb_formula_compile(hb_formula *formula, unsigned allowed, const hb_parameter *parameters, int count,
                             hb_error *err) {
  parser p = {.formula = formula, .length = strlen(formula->text), .allowed = allowed, .err = err};
  p.parameters = parameters;
  p.parameter_count = parameters ? count : 0;
  if (!advance(&p)) return p.status;
  if (p.now.kind == TOKEN_END)
    return hb_fail(
        err, HB_ERR_INPUT,
        "the formula is empty; a number such as 0.5 or an expression such as sin(2*pi*t) is needed");
  if (expression(&p) && p.now.kind != TOKEN_END) complain_after(&p, p.length, false);
  return p.status;
}
