/* Wall clock for timings and progress; never part of a result. */
#ifndef HB_BASE_CLOCK_H
#define HB_BASE_CLOCK_H

/* Seconds from an arbitrary start, monotonic, nanosecond resolution. */
double hb_clock_now(void);
/* Seconds of processor that the calling thread has used; 0 where the system does not tell. */
double hb_clock_thread(void);

#endif
