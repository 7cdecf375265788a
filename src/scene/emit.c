/* The tree back to YAML text. */
#include "scene/tree.h"

#include "base/memory.h"

#include <stdio.h>
#include <string.h>

/* A growing text. */
typedef struct text {
  char *data;
  size_t used, size;
  bool failed; /* out of memory; all later additions do nothing */
} text;

/* Adds length characters. */
static void put(text *out, const char *data, size_t length) {
  if (out->failed) return;
  if (out->used + length + 1 > out->size) {
    size_t size = 2 * (out->used + length) + 256;
    char *grown = hb_realloc(out->data, size, 1);
    if (!grown) {
      out->failed = true;
      return;
    }
    out->data = grown;
    out->size = size;
  }
  memcpy(out->data + out->used, data, length);
  out->used += length;
  out->data[out->used] = 0;
}

/* Adds a string. */
static void puts_text(text *out, const char *data) { put(out, data, strlen(data)); }

/* Adds spaces. */
static void indent(text *out, int n) {
  for (int i = 0; i < n; i++) put(out, " ", 1);
}

/* A character that a plain scalar may hold anywhere but at its start. */
static bool is_plain(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
         (c && strchr("_.+*/^()-", c));
}

/* Can the text stand without quotes, also inside [ ]? */
static bool is_plain_text(const char *s) {
  bool sign = s[0] == '-' || s[0] == '+';
  if (!s[0] || strchr("*/^)", s[0]) || (sign && (!s[1] || strchr("+-*/^)", s[1])))) return false;
  for (; *s; s++)
    if (!is_plain(*s)) return false;
  return true;
}

/* Code point of the UTF-8 sequence at s and its length; a broken sequence counts as one byte. */
static unsigned decode(const char *s, int *length) {
  const unsigned char *p = (const unsigned char *)s;
  int n = p[0] < 0x80 ? 1 : p[0] >= 0xF0 ? 4 : p[0] >= 0xE0 ? 3 : p[0] >= 0xC0 ? 2 : 1;
  unsigned code = n == 1 ? p[0] : p[0] & (0xFFu >> (n + 1));
  for (int i = 1; i < n; i++) {
    if ((p[i] & 0xC0) != 0x80) {
      n = 1;
      code = 0xFFFD;
      break;
    }
    code = code << 6 | (p[i] & 0x3F);
  }
  *length = n;
  return code;
}

/* May the character stand as itself between double quotes? */
static bool is_printable(unsigned c) {
  if (c == '"' || c == '\\' || c == 0x2028 || c == 0x2029 || c == 0xFEFF) return false;
  return (c >= 0x20 && c <= 0x7E) || (c >= 0xA0 && c <= 0xD7FF) || (c >= 0xE000 && c <= 0xFFFD) ||
         c >= 0x10000;
}

/* A scalar or key, quoted where it must be. */
static void put_scalar(text *out, const char *s) {
  if (is_plain_text(s)) {
    puts_text(out, s);
    return;
  }
  put(out, "\"", 1);
  while (*s) {
    int length;
    unsigned code = decode(s, &length);
    if (is_printable(code))
      put(out, s, (size_t)length);
    else {
      char escape[16];
      snprintf(escape, sizeof escape, "\\U%08X", code);
      puts_text(out, escape);
    }
    s += length;
  }
  put(out, "\"", 1);
}

/* Is it a list of scalars only? Then it goes on one line. */
static bool is_row(const hb_node *node) {
  if (node->kind != HB_NODE_LIST) return false;
  for (int i = 0; i < node->count; i++)
    if (node->children[i]->kind != HB_NODE_SCALAR) return false;
  return true;
}

/* A value. The cursor stands after `key: ` (fresh false) or after the `- ` of a list item (fresh true), where
 * a block begins on the same line. */
static void put_node(text *out, const hb_node *node, int depth, bool fresh) {
  if (node->kind == HB_NODE_SCALAR) {
    put_scalar(out, node->text);
    put(out, "\n", 1);
    return;
  }
  if (node->count == 0) {
    puts_text(out, node->kind == HB_NODE_MAP ? "{}\n" : "[]\n");
    return;
  }
  if (is_row(node)) {
    for (int i = 0; i < node->count; i++) {
      puts_text(out, i ? ", " : "[");
      put_scalar(out, node->children[i]->text);
    }
    puts_text(out, "]\n");
    return;
  }
  if (!fresh && !out->failed) { /* the space after the colon goes */
    out->used--;
    put(out, "\n", 1);
  }
  for (int i = 0; i < node->count; i++) {
    const hb_node *child = node->children[i];
    if (i > 0 || !fresh) indent(out, depth);
    if (node->kind == HB_NODE_MAP) {
      put_scalar(out, child->key);
      puts_text(out, ": ");
    } else
      puts_text(out, "- ");
    put_node(out, child, depth + 2, node->kind == HB_NODE_LIST);
  }
}

/* Text of the whole tree. */
hb_status hb_scene_emit(const hb_node *root, char **out, hb_error *err) {
  text buffer = {0};
  put_node(&buffer, root, 0, true);
  if (buffer.failed) {
    hb_free(buffer.data);
    *out = NULL;
    return hb_fail_memory(err, "scene text");
  }
  *out = buffer.data;
  return HB_OK;
}
