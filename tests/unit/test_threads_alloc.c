/* Pools and queues when memory or threads run out: one sentence, and nothing is left, threads neither. */
#include "base/queue.h"
#include "base/threads.h"
#include "support/failing_alloc.h"
#include "support/near.h"

/* Adds the index to a place of its own. */
static void add(void *context, int index, int worker) {
  (void)worker;
  ((int *)context)[index] += index;
}

/* A pool from beginning to end. */
static hb_status try_pool(void *context, hb_error *err) {
  int sums[9] = {0};
  hb_pool *pool = NULL;
  hb_status status = hb_pool_create(*(const int *)context, &pool, err);
  if (status) {
    assert_null(pool);
    return status;
  }
  long before = failing_alloc_count();
  for (int n = 0; n < 3; n++) hb_pool_run(pool, 9, add, sums);
  assert_int_equal(failing_alloc_count(), before);
  for (int k = 0; k < 9; k++) assert_int_equal(sums[k], 3 * k);
  hb_pool_free(pool);
  return HB_OK;
}

/* Counts. */
static void served(void *context, int slot) { *(int *)context += 1 + 0 * slot; }

/* A queue from beginning to end. */
static hb_status try_queue(void *context, hb_error *err) {
  int count = 0;
  hb_queue *queue = NULL;
  (void)context;
  hb_status status = hb_queue_create(2, true, served, &count, "queue of a test", &queue, err);
  if (status) {
    assert_null(queue);
    return status;
  }
  for (int n = 0; n < 5; n++) {
    (void)hb_queue_take(queue);
    hb_queue_give(queue);
  }
  hb_queue_free(queue);
  assert_int_equal(count, 5);
  return HB_OK;
}

/* Memory and threads fail one after the other: threads count like allocations here. */
static void every_allocation_may_fail(void **state) {
  (void)state;
  hb_pool *one = NULL;
  assert_int_equal(hb_pool_create(2, &one, NULL), HB_OK);
  bool threads = hb_pool_threads(one) == 2;
  hb_pool_free(one);
  for (int n = 1; n <= 5; n++) assert_int_equal(failing_alloc_loop(try_pool, &n, 1), threads ? 2 + n - 1 : 1);
  assert_int_equal(failing_alloc_loop(try_queue, NULL, 1), threads ? 2 : 1);
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(every_allocation_may_fail)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
