/* One thread and one gate to wait at: what pool and queue share. The only header that shows pthreads, so only
 * this room includes it. Where the library is built without threads (HB_NO_THREADS) there is nothing here. */
#ifndef HB_BASE_THREAD_H
#define HB_BASE_THREAD_H

#include "hebra/base.h"

#ifndef HB_NO_THREADS
#include <pthread.h>

/* A lock with one condition per direction. */
typedef struct hb_gate {
  pthread_mutex_t lock;
  pthread_cond_t there; /* for the thread that works: there is something to do */
  pthread_cond_t back;  /* for the thread that gave the work: something is done */
} hb_gate;
bool hb_gate_init(hb_gate *gate); /* false: the system has no room for it, and nothing is left of it */
void hb_gate_destroy(hb_gate *gate);

/* Starts a thread that no signal meant for the whole process is delivered to, so that Ctrl-C goes where the
 * program waits for it. HB_ERR_MEMORY with a sentence that names what the thread is for. To be joined. */
hb_status hb_thread_start(pthread_t *thread, void *(*body)(void *), void *argument, const char *what,
                          hb_error *err);
#endif

#endif
