/* A pool of threads for work that falls into independent pieces.
 *
 * Who computes a piece never changes what is computed: pieces write to places of their own, and sums over
 * them are taken afterwards in the order of the pieces. So a result has the same bits for any number of
 * threads. */
#ifndef HB_BASE_THREADS_H
#define HB_BASE_THREADS_H

#include "hebra/base.h"

#define HB_THREADS_MAX 1024

/* Processors that this process may use, at least 1 (Linux: the affinity mask; elsewhere those that are on
 * line). 1 where the library is built without threads. */
int hb_processors(void);

typedef struct hb_pool hb_pool;

/* threads: 1 to HB_THREADS_MAX, the caller's own included; 1 starts none. Without threads in the library the
 * pool has one, whatever is asked for. HB_ERR_INPUT outside the range, HB_ERR_MEMORY if memory or the
 * system's threads run out; *out is then NULL. A pool serves one caller at a time. */
hb_status hb_pool_create(int threads, hb_pool **out, hb_error *err);
void hb_pool_free(hb_pool *pool);           /* NULL is allowed */
int hb_pool_threads(const hb_pool *pool);   /* NULL: 1 */
size_t hb_pool_memory(const hb_pool *pool); /* bytes, without what the system takes for threads; NULL: 0 */

/* A piece of work: 0 <= index < count, 0 <= worker < threads. Workers run at the same time. */
typedef void hb_task(void *context, int index, int worker);

/* Calls task for every index from 0 to count - 1 and returns when all are done; what the pieces wrote is then
 * visible to the caller. Worker w always takes the w-th of the contiguous blocks into which the indices are
 * divided, in ascending order, so that in phase after phase over the same pieces their data stay with one
 * core; the caller is worker 0. pool NULL or of one thread: a plain loop. Allocates nothing; between phases
 * that follow within some ten microseconds nobody sleeps and the system is not called. A task must not call
 * hb_pool_run on the same pool. */
void hb_pool_run(hb_pool *pool, int count, hb_task *task, void *context);

#endif
