#include "hebra/base.h"

#include <stdarg.h>
#include <stdio.h>

/* Fills the error. */
hb_status hb_fail(hb_error *err, hb_status status, const char *format, ...) {
  if (err) {
    va_list args;
    va_start(args, format);
    err->status = status;
    vsnprintf(err->text, sizeof err->text, format, args);
    va_end(args);
  }
  return status;
}

/* Out of memory, with the thing that was wanted. */
hb_status hb_fail_memory(hb_error *err, const char *what) {
  return hb_fail(err, HB_ERR_MEMORY, "out of memory: %s", what);
}

/* Version of the library. */
const char *hb_version(void) { return HB_VERSION; }
