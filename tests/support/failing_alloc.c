#include "support/failing_alloc.h"

#include "hebra/scene.h"
#include "support/near.h"

#include <errno.h>
#include <malloc.h>
#include <pthread.h>
#include <stdatomic.h>
#include <string.h>

/* One per test program; the library has nothing of the kind. Threads of the library allocate too. */
static struct {
  atomic_long asked, fail_at, live, bytes;
  atomic_bool reached;
} alloc;

void *__real_malloc(size_t size);
void *__real_calloc(size_t count, size_t size);
void *__real_realloc(void *block, size_t size);
void __real_free(void *block);
void *__wrap_malloc(size_t size);
void *__wrap_calloc(size_t count, size_t size);
void *__wrap_realloc(void *block, size_t size);
void __wrap_free(void *block);
int __real_pthread_create(pthread_t *thread, const pthread_attr_t *attributes, void *(*body)(void *),
                          void *argument);
int __real_pthread_join(pthread_t thread, void **result);
int __wrap_pthread_create(pthread_t *thread, const pthread_attr_t *attributes, void *(*body)(void *),
                          void *argument);
int __wrap_pthread_join(pthread_t thread, void **result);

/* Counts an allocation; true if it is the one that has to fail. */
static bool fails(void) {
  long number = ++alloc.asked;
  if (alloc.fail_at == 0 || number != alloc.fail_at) return false;
  alloc.reached = true;
  return true;
}

/* Counts a block that was handed out. */
static void *handed_out(void *block) {
  if (block) alloc.live++;
  alloc.bytes += (long)malloc_usable_size(block);
  return block;
}

/* Stands in for malloc. */
void *__wrap_malloc(size_t size) { return fails() ? NULL : handed_out(__real_malloc(size)); }

/* Stands in for calloc. */
void *__wrap_calloc(size_t count, size_t size) {
  return fails() ? NULL : handed_out(__real_calloc(count, size));
}

/* Stands in for realloc. A failure leaves the old block alive. */
void *__wrap_realloc(void *block, size_t size) {
  if (fails()) return NULL;
  long before = (long)malloc_usable_size(block);
  void *grown = __real_realloc(block, size);
  if (!block) return handed_out(grown);
  if (grown) alloc.bytes += (long)malloc_usable_size(grown) - before;
  return grown;
}

/* Stands in for free. */
void __wrap_free(void *block) {
  if (block) alloc.live--;
  alloc.bytes -= (long)malloc_usable_size(block);
  __real_free(block);
}

/* Stands in for pthread_create: a thread is a thing that may run out and has to be given back. */
int __wrap_pthread_create(pthread_t *thread, const pthread_attr_t *attributes, void *(*body)(void *),
                          void *argument) {
  if (fails()) return EAGAIN;
  int reason = __real_pthread_create(thread, attributes, body, argument);
  if (reason == 0) alloc.live++;
  return reason;
}

/* Stands in for pthread_join. */
int __wrap_pthread_join(pthread_t thread, void **result) {
  alloc.live--;
  return __real_pthread_join(thread, result);
}

/* Makes the n-th allocation from now fail. */
void failing_alloc_arm(long n) {
  alloc.asked = 0;
  alloc.fail_at = n;
  alloc.reached = false;
}

/* No allocation fails any more. */
bool failing_alloc_disarm(void) {
  alloc.fail_at = 0;
  return alloc.reached;
}

/* Allocations since the last arm. */
long failing_alloc_count(void) { return alloc.asked; }

/* Blocks in use. */
long failing_alloc_live(void) { return alloc.live; }

/* Bytes in use. */
long failing_alloc_bytes(void) { return alloc.bytes; }

/* One run whose n-th allocation fails; true if the run was long enough to reach it. */
static bool try_one(failing_alloc_trial trial, void *context, long n) {
  hb_error err = {HB_OK, ""};
  long live = failing_alloc_live();
  failing_alloc_arm(n);
  hb_status status = trial(context, &err);
  bool reached = failing_alloc_disarm();
  if (reached && status != HB_ERR_MEMORY)
    fail_msg("allocation %ld failed, but the call returned status %d and said '%s'", n, (int)status,
             err.text);
  if (reached && (err.status != HB_ERR_MEMORY || strlen(err.text) < 10))
    fail_msg("allocation %ld failed, and the sentence is status %d, '%s'", n, (int)err.status, err.text);
  if (!reached && status != HB_OK)
    fail_msg("nothing failed, but the call returned %d: %s", (int)status, err.text);
  if (failing_alloc_live() != live)
    fail_msg("with allocation %ld failing, %ld blocks are left behind", n, failing_alloc_live() - live);
  return reached;
}

/* Fails each allocation in turn. */
long failing_alloc_loop(failing_alloc_trial trial, void *context, long step) {
  long n = 1;
  while (try_one(trial, context, n)) n += step;
  long whole = failing_alloc_count();
  if (whole == 0) fail_msg("the trial allocates nothing through the wrapped functions");
  return whole;
}

/* Read once: what reading allocates is not the trial's. */
long failing_alloc_scene(failing_alloc_trial trial, const char *scene) {
  hb_scene_def def;
  hb_error err = {HB_OK, ""};
  if (hb_scene_parse(scene, strlen(scene), "scene.yaml", NULL, NULL, 0, &def, &err)) fail_msg("%s", err.text);
  long whole = failing_alloc_loop(trial, &def, 1);
  hb_scene_def_free(&def);
  return whole;
}
