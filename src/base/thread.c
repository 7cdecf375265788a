#include "base/thread.h"

#ifndef HB_NO_THREADS

#include <signal.h>
#include <string.h>

/* Some systems give threads only 128 KiB, too little for file libraries. */
#define STACK_LEAST ((size_t)1 << 20)

/* All three or none. */
bool hb_gate_init(hb_gate *gate) {
  if (pthread_mutex_init(&gate->lock, NULL) != 0) return false;
  if (pthread_cond_init(&gate->there, NULL) == 0) {
    if (pthread_cond_init(&gate->back, NULL) == 0) return true;
    pthread_cond_destroy(&gate->there);
  }
  pthread_mutex_destroy(&gate->lock);
  return false;
}

/* Nobody waits any more. */
void hb_gate_destroy(hb_gate *gate) {
  pthread_cond_destroy(&gate->back);
  pthread_cond_destroy(&gate->there);
  pthread_mutex_destroy(&gate->lock);
}

/* Every signal but those that a thread brings upon itself. */
static void foreign_signals(sigset_t *set) {
  static const int own[] = {SIGABRT, SIGBUS, SIGFPE, SIGILL, SIGPIPE, SIGSEGV,
#ifdef SIGSYS
                            SIGSYS,
#endif
#ifdef SIGTRAP
                            SIGTRAP,
#endif
#ifdef SIGXFSZ
                            SIGXFSZ
#endif
  };
  sigfillset(set);
  for (size_t k = 0; k < sizeof own / sizeof own[0]; k++) sigdelset(set, own[k]);
}

/* The mask is inherited: set before, put back after. */
hb_status hb_thread_start(pthread_t *thread, void *(*body)(void *), void *argument, const char *what,
                          hb_error *err) {
  sigset_t blocked, old;
  pthread_attr_t attributes;
  size_t stack = 0;
  int reason = pthread_attr_init(&attributes);
  if (reason == 0) {
    if (pthread_attr_getstacksize(&attributes, &stack) == 0 && stack < STACK_LEAST)
      (void)pthread_attr_setstacksize(&attributes, STACK_LEAST);
    foreign_signals(&blocked);
    pthread_sigmask(SIG_BLOCK, &blocked, &old);
    reason = pthread_create(thread, &attributes, body, argument);
    pthread_sigmask(SIG_SETMASK, &old, NULL);
    pthread_attr_destroy(&attributes);
  }
  if (reason == 0) return HB_OK;
  return hb_fail(err, HB_ERR_MEMORY, "%s: the system starts no further thread: %s", what, strerror(reason));
}

#endif
