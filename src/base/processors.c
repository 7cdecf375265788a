/* The affinity mask is no POSIX: a file of its own asks for the declarations of the system. */
#if defined(__linux__) && !defined(HB_NO_THREADS)
#define _GNU_SOURCE
#include <sched.h>
#endif

#include "base/threads.h"

#include <unistd.h>

/* Affinity mask, else those on line, else 1. A mask of more than 1024 processors does not fit and is passed
 * over. */
int hb_processors(void) {
#ifndef HB_NO_THREADS
#ifdef __linux__
  cpu_set_t mine;
  if (sched_getaffinity(0, sizeof mine, &mine) == 0 && CPU_COUNT(&mine) > 0) return CPU_COUNT(&mine);
#endif
#ifdef _SC_NPROCESSORS_ONLN
  long there = sysconf(_SC_NPROCESSORS_ONLN);
  if (there > 0) return there < HB_THREADS_MAX ? (int)there : HB_THREADS_MAX;
#endif
#endif
  return 1;
}
