#include "base/threads.h"

#include "base/clock.h"
#include "base/memory.h"
#include "base/thread.h"

/* The plain loop over a part of the indices. */
static void run_range(hb_task *task, void *context, int from, int to, int worker) {
  for (int k = from; k < to; k++) task(context, k, worker);
}

/* HB_ERR_INPUT outside the range. */
static hb_status check_threads(int threads, hb_error *err) {
  if (threads >= 1 && threads <= HB_THREADS_MAX) return HB_OK;
  return hb_fail(err, HB_ERR_INPUT, "%d threads were asked for, allowed are 1 to %d", threads,
                 HB_THREADS_MAX);
}

#ifdef HB_NO_THREADS

struct hb_pool {
  int threads;
};

/* One thread, whatever is asked for. */
hb_status hb_pool_create(int threads, hb_pool **out, hb_error *err) {
  *out = NULL;
  hb_status status = check_threads(threads, err);
  if (status) return status;
  hb_pool *pool = hb_alloc(1, sizeof *pool);
  if (!pool) return hb_fail_memory(err, "pool of threads");
  pool->threads = 1;
  *out = pool;
  return HB_OK;
}

/* Only its memory. */
void hb_pool_free(hb_pool *pool) { hb_free(pool); }

/* The caller. */
int hb_pool_threads(const hb_pool *pool) { return pool ? pool->threads : 1; }

/* Only itself. */
size_t hb_pool_memory(const hb_pool *pool) { return pool ? sizeof *pool : 0; }

/* A plain loop. */
void hb_pool_run(hb_pool *pool, int count, hb_task *task, void *context) {
  (void)pool;
  run_range(task, context, 0, count, 0);
}

#else

#include <stdatomic.h>

/* How long a thread waits awake before it sleeps: longer than what lies between two phases of a step, and a
 * small loss where nothing follows. Waking a sleeping thread takes about as long. */
#define SPIN_SECONDS 50e-6
/* Looks between two looks at the clock. */
#define SPIN_LOOKS 64
/* Distance between words of different writers: two lines of the cache, which processors fetch in pairs. */
#define APART 128

/* A thread beside the caller's. */
typedef struct worker {
  atomic_uint done; /* the phase that it finished last */
  int index;        /* 1 and up: 0 is the caller */
  hb_pool *pool;
  pthread_t thread;
  char apart[APART];
} worker;

struct hb_pool {
  atomic_uint phase; /* counts the calls of hb_pool_run; with its work beside it in one line of the cache */
  int count;
  hb_task *task; /* NULL: the end */
  void *context;
  char apart[APART];
  atomic_int sleepers;  /* workers that wait for a phase and may sleep */
  atomic_bool sleeping; /* the caller waits for workers and may sleep */
  int threads;
  bool spin; /* a processor for everybody, so that waiting awake takes no time from another */
  hb_gate gate;
  worker *workers; /* threads - 1 */
};

/* Tells the processor that this is a loop that waits. */
static void relax(void) {
#if defined(__x86_64__) || defined(__i386__)
  __builtin_ia32_pause();
#elif defined(__aarch64__)
  __asm__ volatile("yield");
#endif
}

/* Waits awake until the word is another than `from`; false if that takes too long. */
static bool spin_until_changed(const hb_pool *pool, const atomic_uint *word, unsigned from) {
  double end = 0;
  for (int looks = 1;; looks++) {
    if (atomic_load_explicit(word, memory_order_acquire) != from) return true;
    if (!pool->spin) return false;
    relax();
    if (looks < SPIN_LOOKS) continue;
    looks = 0;
    double now = hb_clock_now();
    if (end == 0)
      end = now + SPIN_SECONDS;
    else if (now > end)
      return false;
  }
}

/* A worker's wait for the phase after `seen`. Whoever announces a phase looks for sleepers afterwards, and a
 * sleeper looks at the phase after it has counted itself: one of the two sees the other. */
static void await_phase(hb_pool *pool, unsigned seen) {
  if (spin_until_changed(pool, &pool->phase, seen)) return;
  pthread_mutex_lock(&pool->gate.lock);
  atomic_fetch_add(&pool->sleepers, 1);
  while (atomic_load(&pool->phase) == seen) pthread_cond_wait(&pool->gate.there, &pool->gate.lock);
  atomic_fetch_sub(&pool->sleepers, 1);
  pthread_mutex_unlock(&pool->gate.lock);
}

/* Block of a worker: sizes differ by one at most, the longer ones come first. */
static void run_block(const hb_pool *pool, int index) {
  int size = pool->count / pool->threads, longer = pool->count % pool->threads;
  int from = index * size + (index < longer ? index : longer);
  run_range(pool->task, pool->context, from, from + size + (index < longer), index);
}

/* What a worker does until the end. */
static void *work(void *argument) {
  worker *w = argument;
  hb_pool *pool = w->pool;
  for (unsigned seen = 0;;) {
    await_phase(pool, seen);
    seen++; /* no phase is missed: the next one comes only when this one is done */
    if (!pool->task) return NULL;
    run_block(pool, w->index);
    atomic_store(&w->done, seen);
    if (!atomic_load(&pool->sleeping)) continue;
    pthread_mutex_lock(&pool->gate.lock);
    pthread_cond_signal(&pool->gate.back);
    pthread_mutex_unlock(&pool->gate.lock);
  }
}

/* Announces what has been put into the pool. */
static unsigned announce(hb_pool *pool) {
  unsigned phase = atomic_fetch_add(&pool->phase, 1) + 1;
  if (atomic_load(&pool->sleepers) > 0) {
    pthread_mutex_lock(&pool->gate.lock);
    pthread_cond_broadcast(&pool->gate.there);
    pthread_mutex_unlock(&pool->gate.lock);
  }
  return phase;
}

/* The caller's wait for one worker, by the same rule as await_phase. */
static void await_worker(hb_pool *pool, worker *w, unsigned phase) {
  if (spin_until_changed(pool, &w->done, phase - 1)) return;
  pthread_mutex_lock(&pool->gate.lock);
  atomic_store(&pool->sleeping, true);
  while (atomic_load(&w->done) != phase) pthread_cond_wait(&pool->gate.back, &pool->gate.lock);
  atomic_store(&pool->sleeping, false);
  pthread_mutex_unlock(&pool->gate.lock);
}

/* Starts all workers; what was started before a failure is stopped again. */
hb_status hb_pool_create(int threads, hb_pool **out, hb_error *err) {
  *out = NULL;
  hb_status status = check_threads(threads, err);
  if (status) return status;
  hb_pool *pool = hb_alloc(1, sizeof *pool);
  worker *workers = hb_alloc((size_t)threads - 1, sizeof *workers);
  if (!pool || !workers || !hb_gate_init(&pool->gate)) {
    hb_free(workers);
    hb_free(pool);
    return hb_fail_memory(err, "pool of threads");
  }
  pool->workers = workers;
  pool->spin = threads <= hb_processors();
  /* Workers read how many they are: not before the first phase, when it is settled. */
  for (pool->threads = 1; !status && pool->threads < threads;) {
    worker *w = &workers[pool->threads - 1];
    w->index = pool->threads;
    w->pool = pool;
    status = hb_thread_start(&w->thread, work, w, "pool of threads", err);
    if (!status) pool->threads++;
  }
  if (status) {
    hb_pool_free(pool);
    return status;
  }
  *out = pool;
  return HB_OK;
}

/* A phase without a task ends the workers. */
void hb_pool_free(hb_pool *pool) {
  if (!pool) return;
  pool->task = NULL;
  (void)announce(pool);
  for (int k = 0; k < pool->threads - 1; k++) pthread_join(pool->workers[k].thread, NULL);
  hb_gate_destroy(&pool->gate);
  hb_free(pool->workers);
  hb_free(pool);
}

/* The caller and its workers. */
int hb_pool_threads(const hb_pool *pool) { return pool ? pool->threads : 1; }

/* Itself and its workers. */
size_t hb_pool_memory(const hb_pool *pool) {
  return pool ? sizeof *pool + (size_t)(pool->threads - 1) * sizeof *pool->workers : 0;
}

/* A phase. */
void hb_pool_run(hb_pool *pool, int count, hb_task *task, void *context) {
  if (!pool || pool->threads == 1 || count <= 1) {
    run_range(task, context, 0, count, 0);
    return;
  }
  pool->count = count;
  pool->task = task;
  pool->context = context;
  unsigned phase = announce(pool);
  run_block(pool, 0);
  for (int k = 0; k < pool->threads - 1; k++) await_worker(pool, &pool->workers[k], phase);
}

#endif
