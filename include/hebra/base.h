/* hebra/base.h - status codes, error sentences, version.
 *
 * Every call that can fail returns an hb_status and, when it is not HB_OK, has put one clear sentence into
 * the hb_error that the caller passed (NULL is allowed: the sentence is dropped). The library never prints
 * and never exits. */
#ifndef HEBRA_BASE_H
#define HEBRA_BASE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define HB_VERSION_MAJOR 0
#define HB_VERSION_MINOR 1
#define HB_VERSION_PATCH 0
#define HB_VERSION "0.1.0"

/* What went wrong, by kind of treatment. The command line maps HB_ERR_INPUT to exit status 2, the rest to 1.
 */
typedef enum hb_status {
  HB_OK = 0,
  HB_ERR_INPUT,      /* the user's input is wrong; the sentence says where and what is allowed */
  HB_ERR_MEMORY,     /* an allocation failed */
  HB_ERR_IO,         /* a file could not be read or written */
  HB_ERR_NUMERIC,    /* a run went wrong: not-a-number, no convergence, length error; says when and where */
  HB_ERR_MISSING,    /* an outside program or optional library is not there; names the package */
  HB_ERR_INTERRUPTED /* stopped on request */
} hb_status;

/* One sentence for a person. Always zero-terminated; cut if longer. */
typedef struct hb_error {
  hb_status status;
  char text[1024];
} hb_error;

#if defined(__GNUC__)
#define HB_PRINTF(format_at, args_at) __attribute__((format(printf, format_at, args_at)))
#else
#define HB_PRINTF(format_at, args_at)
#endif

/* Fills *err (if not NULL) and returns status, so that a caller writes `return hb_fail(err, ...)`. */
hb_status hb_fail(hb_error *err, hb_status status, const char *format, ...) HB_PRINTF(3, 4);

/* "out of memory" as a status and sentence; what names the thing that was asked for. */
hb_status hb_fail_memory(hb_error *err, const char *what);

/* Version text of the library that is linked, to compare with HB_VERSION of the headers. */
const char *hb_version(void);

#ifdef __cplusplus
}
#endif
#endif
