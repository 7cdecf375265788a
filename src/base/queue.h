/* A thread that takes work in order, and a few slots in which the work is handed to it.
 *
 * The slots themselves belong to the user: the queue only says whose turn each number is. One thread gives,
 * one thread works. */
#ifndef HB_BASE_QUEUE_H
#define HB_BASE_QUEUE_H

#include "hebra/base.h"

typedef struct hb_queue hb_queue;

/* slots: at least 1. work is called for each slot handed over, in that order, one at a time. threaded: on a
 * thread of its own, else (and where the library is built without threads) inside hb_queue_give. what: names
 * the queue in sentences. HB_ERR_MEMORY: out of memory or of threads. */
hb_status hb_queue_create(int slots, bool threaded, void (*work)(void *context, int slot), void *context,
                          const char *what, hb_queue **out, hb_error *err);
/* Waits until all is done, ends the thread. NULL is allowed. */
void hb_queue_free(hb_queue *queue);

/* For work to ask: has more been handed over than what it is at? */
bool hb_queue_more(hb_queue *queue);

/* Number of the slot to fill next; waits until it is free. */
int hb_queue_take(hb_queue *queue);
/* Hands over the slot that hb_queue_take named last. */
void hb_queue_give(hb_queue *queue);
/* Waits until all that was handed over is done; what work wrote is then visible to the caller. */
void hb_queue_wait(hb_queue *queue);

#endif
