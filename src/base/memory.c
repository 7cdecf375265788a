#include "base/memory.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

/* True if count * size does not fit into size_t. */
static int overflows(size_t count, size_t size) { return size != 0 && count > SIZE_MAX / size; }

/* Zeroed memory. */
void *hb_alloc(size_t count, size_t size) {
  if (overflows(count, size)) return NULL;
  return calloc(count ? count : 1, size ? size : 1);
}

/* Resized memory. */
void *hb_realloc(void *block, size_t count, size_t size) {
  if (overflows(count, size)) return NULL;
  size_t bytes = count * size;
  return realloc(block, bytes ? bytes : 1);
}

/* Back to the system. */
void hb_free(void *block) { free(block); }

/* Copy of a string. */
char *hb_strdup(const char *text) { return hb_strndup(text, strlen(text)); }

/* Copy of the first length characters. */
char *hb_strndup(const char *text, size_t length) {
  size_t n = strnlen(text, length);
  char *copy = hb_alloc(n + 1, 1);
  if (copy) memcpy(copy, text, n);
  return copy;
}
