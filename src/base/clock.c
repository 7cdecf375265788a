#include "base/clock.h"

#include <time.h>

/* Monotonic seconds. */
double hb_clock_now(void) {
  struct timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* Of this thread alone. */
double hb_clock_thread(void) {
  struct timespec used = {0, 0};
#ifdef CLOCK_THREAD_CPUTIME_ID
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &used);
#endif
  return (double)used.tv_sec + 1e-9 * (double)used.tv_nsec;
}
