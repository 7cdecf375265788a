/* The base floor: memory, error sentences, clock. */
#include "base/clock.h"
#include "base/memory.h"
#include "hebra/base.h"
#include "support/near.h"

#include <stdio.h>
#include <string.h>

/* Memory comes cleared; a count of 0 gives a block too. */
static void allocates_zeroed(void **state) {
  (void)state;
  unsigned char *block = hb_alloc(1000, 3), sum = 0;
  assert_non_null(block);
  for (int i = 0; i < 3000; i++) sum |= block[i];
  assert_int_equal(sum, 0);
  hb_free(block);
  void *nothing = hb_alloc(0, 8);
  assert_non_null(nothing);
  hb_free(nothing);
  hb_free(NULL);
}

/* Products that do not fit into size_t are refused and leave the old block alone. */
static void refuses_overflow(void **state) {
  (void)state;
  assert_null(hb_alloc(SIZE_MAX / 2, 3));
  assert_null(hb_alloc(3, SIZE_MAX / 2));
  char *block = hb_alloc(4, 1);
  assert_non_null(block);
  memcpy(block, "abc", 4);
  assert_null(hb_realloc(block, SIZE_MAX / 4, 5));
  assert_string_equal(block, "abc");
  char *grown = hb_realloc(block, 1000, 1);
  assert_non_null(grown);
  assert_string_equal(grown, "abc");
  hb_free(grown);
}

/* Copies of strings, whole and cut. */
static void copies_strings(void **state) {
  (void)state;
  static const char *const texts[] = {"", "a", "rods that bend"};
  for (int i = 0; i < 3; i++) {
    char *copy = hb_strdup(texts[i]);
    assert_non_null(copy);
    assert_string_equal(copy, texts[i]);
    hb_free(copy);
  }
  const struct {
    size_t length;
    const char *expected;
  } cuts[] = {{0, ""}, {4, "rods"}, {14, "rods that bend"}, {100, "rods that bend"}};
  for (int i = 0; i < 4; i++) {
    char *copy = hb_strndup(texts[2], cuts[i].length);
    assert_non_null(copy);
    assert_string_equal(copy, cuts[i].expected);
    hb_free(copy);
  }
}

/* hb_fail hands back the status, writes the sentence, cuts a long one, and takes no error for an answer. */
static void fills_errors(void **state) {
  (void)state;
  hb_error err = {HB_OK, "old"};
  assert_int_equal(hb_fail(&err, HB_ERR_INPUT, "line %d: %s", 3, "wrong"), HB_ERR_INPUT);
  assert_int_equal(err.status, HB_ERR_INPUT);
  assert_string_equal(err.text, "line 3: wrong");
  assert_int_equal(hb_fail(NULL, HB_ERR_IO, "nobody %s", "reads this"), HB_ERR_IO);
  assert_int_equal(hb_fail_memory(&err, "frames"), HB_ERR_MEMORY);
  assert_non_null(strstr(err.text, "frames"));
  assert_int_equal(hb_fail_memory(NULL, "frames"), HB_ERR_MEMORY);
  char longer[3000];
  memset(longer, 'x', sizeof longer - 1);
  longer[sizeof longer - 1] = 0;
  hb_fail(&err, HB_ERR_NUMERIC, "%s", longer);
  assert_int_equal(strlen(err.text), sizeof err.text - 1);
}

/* The numbers of the version and its text say the same, in headers and library. */
static void version_agrees(void **state) {
  (void)state;
  char text[32];
  snprintf(text, sizeof text, "%d.%d.%d", HB_VERSION_MAJOR, HB_VERSION_MINOR, HB_VERSION_PATCH);
  assert_string_equal(text, HB_VERSION);
  assert_string_equal(hb_version(), HB_VERSION);
}

/* The clock goes on, and not in jumps of whole milliseconds. */
static void clock_runs(void **state) {
  (void)state;
  double start = hb_clock_now(), last = start, smallest = 1.0;
  while (last - start < 0.01) {
    double now = hb_clock_now();
    assert_true(now >= last);
    if (now > last && now - last < smallest) smallest = now - last;
    last = now;
  }
  assert_at_most(smallest, 1e-4);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(allocates_zeroed), cmocka_unit_test(refuses_overflow),
      cmocka_unit_test(copies_strings),   cmocka_unit_test(fills_errors),
      cmocka_unit_test(version_agrees),   cmocka_unit_test(clock_runs),
  };
  return cmocka_run_group_tests_name("base", tests, NULL, NULL);
}
