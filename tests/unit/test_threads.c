/* The pool of threads and the queue: every piece once, on the thread it belongs to, and visible afterwards.
 */
#include "base/queue.h"
#include "base/threads.h"
#include "support/near.h"

#include "base/clock.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { MOST = 8, PIECES = 257 };

/* How often each piece was computed, by whom, and in which order a worker came by. */
typedef struct tally {
  int times[PIECES], worker[PIECES], last[MOST], threads;
  bool descending[MOST];
} tally;

/* One piece. */
static void count_piece(void *context, int index, int worker) {
  tally *t = context;
  t->times[index]++;
  t->worker[index] = worker;
  if (worker < 0 || worker >= t->threads) return;
  if (index <= t->last[worker]) t->descending[worker] = true;
  t->last[worker] = index;
}

/* A pool of so many threads, or of one where the library has none. */
static hb_pool *pool_of(int threads) {
  hb_pool *pool = NULL;
  hb_error err = {HB_OK, ""};
  if (hb_pool_create(threads, &pool, &err)) fail_msg("%s", err.text);
  assert_true(hb_pool_threads(pool) == threads || hb_pool_threads(pool) == 1);
  return pool;
}

/* For any number of threads and of pieces, more and fewer: each once, in contiguous blocks in the order of
 * the workers, ascending, sizes that differ by one at most; the same blocks every time. */
static void every_piece_once(void **state) {
  (void)state;
  static tally t, again;
  const int counts[] = {0, 1, 2, 3, 5, 7, 8, 9, 31, 64, PIECES};
  for (int threads = 1; threads <= MOST; threads++) {
    hb_pool *pool = pool_of(threads);
    int real = hb_pool_threads(pool);
    for (size_t c = 0; c < sizeof counts / sizeof counts[0]; c++) {
      int size[MOST] = {0}, n = counts[c];
      memset(&t, 0, sizeof t);
      t.threads = real;
      for (int k = 0; k < MOST; k++) t.last[k] = -1;
      again = t;
      hb_pool_run(pool, n, count_piece, &t);
      hb_pool_run(pool, n, count_piece, &again);
      for (int w = 0; w < MOST; w++) assert_false(t.descending[w]);
      for (int k = 0; k < PIECES; k++) {
        assert_int_equal(t.times[k], k < n ? 1 : 0);
        if (k >= n) continue;
        assert_in_range(t.worker[k], 0, real - 1);
        assert_int_equal(t.worker[k], again.worker[k]);
        if (k > 0) assert_true(t.worker[k] >= t.worker[k - 1]);
        size[t.worker[k]]++;
      }
      for (int w = 0; w < real; w++) {
        assert_true(size[w] == n / real || size[w] == n / real + 1);
        if (w > 0) assert_true(size[w] <= size[w - 1]);
      }
    }
    hb_pool_free(pool);
  }
}

/* No pool is a pool of one. */
static void no_pool_is_a_loop(void **state) {
  (void)state;
  static tally t;
  t.threads = 1;
  t.last[0] = -1;
  hb_pool_run(NULL, PIECES, count_piece, &t);
  for (int k = 0; k < PIECES; k++) assert_true(t.times[k] == 1 && t.worker[k] == 0);
  assert_false(t.descending[0]);
  assert_int_equal(hb_pool_threads(NULL), 1);
  hb_pool_free(NULL);
}

/* Two arrays that are computed from one another in turn, across the blocks of the workers: each phase needs
 * what all workers wrote in the one before. */
typedef struct ladder {
  const uint64_t *from;
  uint64_t *to;
  int count;
} ladder;

/* A piece: mixes both neighbours, round the corner. */
static void mix(void *context, int k, int worker) {
  ladder *l = context;
  (void)worker;
  uint64_t a = l->from[(k + 1) % l->count], b = l->from[(k + l->count - 1) % l->count];
  l->to[k] = (l->from[k] ^ (a << 7 | a >> 57)) * 1099511628211u + b;
}

/* Many phases; the caller changes a number in between. Returns a sum over the end, and the seconds. */
static uint64_t climb(hb_pool *pool, int count, int phases, double *seconds) {
  static uint64_t even[PIECES], odd[PIECES];
  for (int k = 0; k < count; k++) even[k] = (uint64_t)k + 1;
  double started = hb_clock_now();
  for (int n = 0; n < phases; n++) {
    ladder l = {n % 2 ? odd : even, n % 2 ? even : odd, count};
    hb_pool_run(pool, count, mix, &l);
    l.to[n % count] ^= (uint64_t)n;
  }
  *seconds = hb_clock_now() - started;
  uint64_t sum = 0;
  for (int k = 0; k < count; k++) sum = sum * 31 + (phases % 2 ? odd : even)[k];
  return sum;
}

/* Thirty thousand phases of pieces that depend on one another give the same bits for every number of threads,
 * fewer pieces than threads included. */
static void phases_follow_one_another(void **state) {
  (void)state;
  const int counts[] = {2, 3, 17, PIECES};
  const bool verbose = getenv("HEBRA_TEST_VERBOSE") != NULL;
  for (size_t c = 0; c < sizeof counts / sizeof counts[0]; c++) {
    double alone = 0;
    int phases = counts[c] == PIECES ? 3000 : 9000;
    uint64_t expected = climb(NULL, counts[c], phases, &alone);
    for (int threads = 1; threads <= MOST; threads = threads < 3 ? threads + 1 : threads + 2) {
      /* More threads than processors sleep in every phase; a few thousand wake-ups tell as much. */
      int fewer = threads > hb_processors() ? phases / 10 : phases;
      double seconds = 0;
      if (fewer != phases) expected = climb(NULL, counts[c], fewer, &alone);
      hb_pool *pool = pool_of(threads);
      assert_true(climb(pool, counts[c], fewer, &seconds) == expected);
      hb_pool_free(pool);
      if (verbose)
        printf("%d pieces, %d threads: %.0f ns per phase beyond %.0f ns alone\n", counts[c], threads,
               1e9 * (seconds - alone / threads) / fewer, 1e9 * alone / fewer);
    }
  }
}

/* Workers that have gone to sleep are woken, and a caller that is done long before a worker waits for it. */
static void sleepers_wake(void **state) {
  (void)state;
  const struct timespec nap = {0, 2000000};
  static tally t;
  hb_pool *pool = pool_of(3);
  memset(&t, 0, sizeof t);
  t.threads = 3;
  for (int n = 0; n < 20; n++) {
    for (int k = 0; k < MOST; k++) t.last[k] = -1;
    nanosleep(&nap, NULL);
    hb_pool_run(pool, 5, count_piece, &t);
    for (int k = 0; k < 5; k++) assert_int_equal(t.times[k], n + 1);
  }
  hb_pool_free(pool);
}

/* Counts on a line of the cache of its own. */
static void count_far_apart(void *context, int index, int worker) {
  (void)worker;
  ((long *)context)[32 * index]++;
}

/* What a phase costs beyond its work while nobody sleeps: the fastest of many rows of a hundred. */
static void phases_are_counted(void **state) {
  enum { ROWS = 200, ROW = 100 };
  (void)state;
  static long counts[2 * 32];
  double best = 1;
  hb_pool *pool = pool_of(2);
  for (int n = 0; n < ROWS; n++) {
    double started = hb_clock_now();
    for (int k = 0; k < ROW; k++) hb_pool_run(pool, 2, count_far_apart, counts);
    double seconds = hb_clock_now() - started;
    if (seconds < best) best = seconds;
  }
  hb_pool_free(pool);
  assert_int_equal(counts[0], ROWS * ROW);
  assert_int_equal(counts[32], ROWS * ROW);
  if (getenv("HEBRA_TEST_VERBOSE")) printf("a phase of two threads costs %.0f ns\n", 1e9 * best / ROW);
}

/* The last piece takes its time; its mark must be there when the phase is over. */
static void slow_piece(void *context, int index, int worker) {
  const struct timespec nap = {0, 3000000};
  int *marks = context;
  (void)worker;
  if (index == 3) nanosleep(&nap, NULL);
  marks[index]++;
}

/* The caller sleeps rather than spins through a long piece of another, and misses nothing. */
static void the_caller_waits(void **state) {
  (void)state;
  int marks[4] = {0};
  hb_pool *pool = pool_of(2);
  for (int n = 1; n <= 10; n++) {
    hb_pool_run(pool, 4, slow_piece, marks);
    for (int k = 0; k < 4; k++) assert_int_equal(marks[k], n);
  }
  hb_pool_free(pool);
}

/* Pools that nobody used end as well as used ones, many times. */
static void pools_come_and_go(void **state) {
  (void)state;
  static tally t;
  for (int n = 0; n < 50; n++) {
    hb_pool *pool = pool_of(1 + n % MOST);
    t.threads = hb_pool_threads(pool);
    if (n % 3 == 0) hb_pool_run(pool, PIECES, count_piece, &t);
    hb_pool_free(pool);
  }
  assert_int_equal(t.times[PIECES - 1], 17);
}

/* Impossible numbers of threads are refused in a sentence. */
static void absurd_numbers_are_refused(void **state) {
  (void)state;
  const int wrong[] = {0, -1, HB_THREADS_MAX + 1};
  for (int k = 0; k < 3; k++) {
    hb_error err = {HB_OK, ""};
    hb_pool *pool = (hb_pool *)&err;
    assert_int_equal(hb_pool_create(wrong[k], &pool, &err), HB_ERR_INPUT);
    assert_null(pool);
    assert_non_null(strstr(err.text, "allowed are 1 to 1024"));
  }
  assert_in_range(hb_processors(), 1, 1 << 20);
}

/* ---- queue ---- */

enum { SLOTS = 3, PARCELS = 400 };

/* Slots with a parcel each, and what was received. */
typedef struct post {
  int slot[SLOTS], received[PARCELS], count;
  bool slow;
} post;

/* Takes the parcel out of its slot, now and then slowly. */
static void receive(void *context, int slot) {
  const struct timespec nap = {0, 100000};
  post *p = context;
  if (p->slow && p->count % 7 == 0) nanosleep(&nap, NULL);
  p->received[p->count++] = p->slot[slot];
  p->slot[slot] = -1; /* a slot must not be filled again before this */
}

/* All parcels arrive in order, whoever is the faster one, with and without a thread. */
static void parcels_arrive_in_order(void **state) {
  (void)state;
  for (int variant = 0; variant < 8; variant++) {
    const struct timespec nap = {0, 100000};
    int slots = variant & 4 ? SLOTS : 1;
    post p = {.slow = variant & 1};
    hb_queue *queue = NULL;
    hb_error err = {HB_OK, ""};
    for (int k = 0; k < SLOTS; k++) p.slot[k] = -1;
    if (hb_queue_create(slots, variant & 2, receive, &p, "post", &queue, &err)) fail_msg("%s", err.text);
    for (int n = 0; n < PARCELS; n++) {
      if (!p.slow && n % 7 == 0) nanosleep(&nap, NULL);
      int slot = hb_queue_take(queue);
      assert_in_range(slot, 0, slots - 1);
      assert_int_equal(p.slot[slot], -1);
      p.slot[slot] = n;
      hb_queue_give(queue);
      if (n == PARCELS / 2) {
        hb_queue_wait(queue);
        assert_int_equal(p.count, n + 1);
      }
    }
    hb_queue_free(queue);
    assert_int_equal(p.count, PARCELS);
    for (int n = 0; n < PARCELS; n++) assert_int_equal(p.received[n], n);
  }
  hb_queue_free(NULL);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(every_piece_once),          cmocka_unit_test(no_pool_is_a_loop),
      cmocka_unit_test(phases_follow_one_another), cmocka_unit_test(sleepers_wake),
      cmocka_unit_test(phases_are_counted),        cmocka_unit_test(the_caller_waits),
      cmocka_unit_test(pools_come_and_go),         cmocka_unit_test(absurd_numbers_are_refused),
      cmocka_unit_test(parcels_arrive_in_order),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
