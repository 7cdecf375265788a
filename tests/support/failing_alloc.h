/* Lets the n-th allocation of the library fail. Works in tests named test_*_alloc.c, whose executables are
 * linked with
 * --wrap=malloc, calloc, realloc, free, pthread_create and pthread_join: calls from the static library and
 * the test go through here, those of libc and of shared libraries do not. A thread counts as an allocation.
 */
#ifndef HB_TEST_FAILING_ALLOC_H
#define HB_TEST_FAILING_ALLOC_H

#include "hebra/base.h"

/* The n-th allocation from now fails (1 is the next one), later ones work again. 0: none fails. */
void failing_alloc_arm(long n);
/* Ends it. True if the failing allocation was reached. */
bool failing_alloc_disarm(void);
/* Allocations asked for since the last arm. */
long failing_alloc_count(void);
/* Blocks allocated and not yet freed. */
long failing_alloc_live(void);
/* Bytes of those blocks, as the system rounds them. */
long failing_alloc_bytes(void);

/* Something that allocates: builds, uses and frees all it owns, whether it succeeds or not. */
typedef hb_status (*failing_alloc_trial)(void *context, hb_error *err);

/* Runs trial with its 1st, 2nd, 3rd ... allocation failing until it gets through without reaching the failing
 * one. Fails the cmocka test unless every failed run reports HB_ERR_MEMORY with a sentence and leaves no
 * block behind, and the last run gives HB_OK. step > 1 tries only every step-th allocation. Returns the
 * number of allocations of a whole run; fails if that is none. */
long failing_alloc_loop(failing_alloc_trial trial, void *context, long step);

/* The same for a trial whose context is the hb_scene_def of a scene's text, every allocation in turn. */
long failing_alloc_scene(failing_alloc_trial trial, const char *scene);

#endif
