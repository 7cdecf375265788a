/* The only place that allocates. Tests replace the allocator at link time (--wrap=malloc, calloc, realloc) to
 * let the n-th allocation fail. */
#ifndef HB_BASE_MEMORY_H
#define HB_BASE_MEMORY_H

#include <stdarg.h>
#include <stddef.h>

/* count * size bytes, all zero; NULL if out of memory or if the product overflows. count 0 gives a valid
 * pointer. */
void *hb_alloc(size_t count, size_t size);
/* Resizes to count * size bytes; the grown part is not cleared. NULL leaves the old block as it was. */
void *hb_realloc(void *block, size_t count, size_t size);
void hb_free(void *block); /* NULL is allowed */
/* Copy of a string; NULL if out of memory. */
char *hb_strdup(const char *text);
/* At most length characters of text. */
char *hb_strndup(const char *text, size_t length);

#endif
