#include "base/queue.h"

#include "base/memory.h"
#include "base/thread.h"

#ifndef HB_NO_THREADS
#include <time.h>

/* Waking a sleeper costs the thread that calls some microseconds: little beside this. */
#define NAP_NANOSECONDS 400000
#endif

struct hb_queue {
  void (*work)(void *context, int slot);
  void *context;
  int slots;
  bool threaded;
  long given, done; /* so many in all: slot number k is that of given or done = k modulo slots */
#ifndef HB_NO_THREADS
  bool stop;
  hb_gate gate; /* guards given, done and stop */
  pthread_t thread;
#endif
};

/* The slot that comes next in a count. */
static int slot_of(const hb_queue *queue, long count) { return (int)(count % queue->slots); }

#ifndef HB_NO_THREADS

/* With the lock: waits until there is work or the end is asked for; a nap, then sleep until called. */
static void await_work(hb_queue *queue) {
  const struct timespec nap = {0, NAP_NANOSECONDS};
  if (queue->done != queue->given || queue->stop) return;
  pthread_mutex_unlock(&queue->gate.lock);
  (void)nanosleep(&nap, NULL);
  pthread_mutex_lock(&queue->gate.lock);
  while (queue->done == queue->given && !queue->stop)
    pthread_cond_wait(&queue->gate.there, &queue->gate.lock);
}

/* What the thread does: one slot after the other until there is nothing left and the end is asked for. */
static void *serve(void *argument) {
  hb_queue *queue = argument;
  pthread_mutex_lock(&queue->gate.lock);
  for (;;) {
    await_work(queue);
    if (queue->done == queue->given) break;
    int slot = slot_of(queue, queue->done);
    pthread_mutex_unlock(&queue->gate.lock);
    queue->work(queue->context, slot);
    pthread_mutex_lock(&queue->gate.lock);
    queue->done++;
    pthread_cond_signal(&queue->gate.back);
  }
  pthread_mutex_unlock(&queue->gate.lock);
  return NULL;
}

/* Waits until at most so many are handed over and not done. */
static void await_open(hb_queue *queue, long open) {
  if (!queue->threaded) return;
  pthread_mutex_lock(&queue->gate.lock);
  while (queue->given - queue->done > open) pthread_cond_wait(&queue->gate.back, &queue->gate.lock);
  pthread_mutex_unlock(&queue->gate.lock);
}

/* More than the one at work. */
bool hb_queue_more(hb_queue *queue) {
  if (!queue->threaded) return false;
  pthread_mutex_lock(&queue->gate.lock);
  bool more = queue->given > queue->done + 1;
  pthread_mutex_unlock(&queue->gate.lock);
  return more;
}

/* Gate and thread. */
static hb_status start(hb_queue *queue, const char *what, hb_error *err) {
  if (!hb_gate_init(&queue->gate)) return hb_fail_memory(err, what);
  hb_status status = hb_thread_start(&queue->thread, serve, queue, what, err);
  if (status) hb_gate_destroy(&queue->gate);
  return status;
}

/* Ends the thread when it has nothing left to do. */
static void stop(hb_queue *queue) {
  pthread_mutex_lock(&queue->gate.lock);
  queue->stop = true;
  pthread_cond_signal(&queue->gate.there);
  pthread_mutex_unlock(&queue->gate.lock);
  pthread_join(queue->thread, NULL);
  hb_gate_destroy(&queue->gate);
}

#else

/* Work is done when it is given. */
bool hb_queue_more(hb_queue *queue) {
  (void)queue;
  return false;
}

/* Nothing is ever open. */
static void await_open(hb_queue *queue, long open) {
  (void)queue;
  (void)open;
}

#endif

/* With its thread, if it has one. */
hb_status hb_queue_create(int slots, bool threaded, void (*work)(void *context, int slot), void *context,
                          const char *what, hb_queue **out, hb_error *err) {
  *out = NULL;
  hb_queue *queue = hb_alloc(1, sizeof *queue);
  if (!queue) return hb_fail_memory(err, what);
  queue->work = work;
  queue->context = context;
  queue->slots = slots;
#ifndef HB_NO_THREADS
  queue->threaded = threaded;
  hb_status status = threaded ? start(queue, what, err) : HB_OK;
  if (status) {
    hb_free(queue);
    return status;
  }
#else
  (void)threaded;
#endif
  *out = queue;
  return HB_OK;
}

/* All is done before it goes. */
void hb_queue_free(hb_queue *queue) {
  if (!queue) return;
#ifndef HB_NO_THREADS
  if (queue->threaded) stop(queue);
#endif
  hb_free(queue);
}

/* Free when fewer than all slots are open. */
int hb_queue_take(hb_queue *queue) {
  await_open(queue, queue->slots - 1);
  return slot_of(queue, queue->given); /* only the thread that gives changes it */
}

/* To the thread, or done at once. */
void hb_queue_give(hb_queue *queue) {
  if (!queue->threaded) {
    queue->work(queue->context, slot_of(queue, queue->given));
    queue->given++;
    queue->done++;
    return;
  }
#ifndef HB_NO_THREADS
  pthread_mutex_lock(&queue->gate.lock);
  queue->given++;
  pthread_cond_signal(&queue->gate.there);
  pthread_mutex_unlock(&queue->gate.lock);
#endif
}

/* Nothing open. */
void hb_queue_wait(hb_queue *queue) { await_open(queue, 0); }
