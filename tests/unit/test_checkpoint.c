/* Checkpoints: they come back whole, a damaged one is refused, and a run goes on from one bit for bit. */
#include "support/near.h"

#include "support/smallsim.h"

#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

static char directory[256];

/* Path of a file in the test's directory; valid until the next call but one. */
static const char *in_directory(const char *name) {
  static char paths[2][320];
  static int turn;
  turn = !turn;
  snprintf(paths[turn], sizeof paths[turn], "%s/%s", directory, name);
  return paths[turn];
}

/* Makes the directory. */
static int set_up(void **state) {
  (void)state;
  const char *scratch = getenv("HEBRA_SCRATCH");
  snprintf(directory, sizeof directory, "%s/checkpoint-XXXXXX", scratch ? scratch : ".");
  return mkdtemp(directory) ? 0 : -1;
}

/* Removes it; a temporary file left behind fails. */
static int tear_down(void **state) {
  (void)state;
  unlink(in_directory("a.checkpoint"));
  unlink(in_directory("bad.checkpoint"));
  return rmdir(directory);
}

/* A simulation, or a failed test. */
static void make(smallsim *s) {
  hb_error err = {0};
  if (!smallsim_make(s, &err)) fail_msg("%s", err.text);
}

/* Steps, or a failed test. */
static void steps(hb_sim *sim, int count) {
  hb_error err = {0};
  for (int k = 0; k < count; k++)
    if (hb_sim_step(sim, &err) != HB_OK) fail_msg("%s", err.text);
}

/* Everything that was written comes back. */
static void test_round_trip(void **state) {
  (void)state;
  smallsim s;
  hb_checkpoint saved;
  hb_error err = {0};
  char here[4096], expected[4200];
  make(&s);
  steps(s.sim, 7);
  assert_int_equal(hb_checkpoint_write(in_directory("a.checkpoint"), s.sim, 42, &err), HB_OK);
  if (hb_checkpoint_read(in_directory("a.checkpoint"), &saved, &err) != HB_OK) fail_msg("%s", err.text);
  assert_string_equal(saved.source, "title: A small rod\n");
  assert_non_null(getcwd(here, sizeof here));
  snprintf(expected, sizeof expected, "%s/scenes", here);
  assert_string_equal(saved.base_dir, expected);
  assert_int_equal(saved.frames, 42);
  const hb_state *now = hb_sim_const_state(s.sim);
  assert_int_equal(saved.count, now->count);
  assert_memory_equal(saved.block, now->block, now->count * sizeof(double));
  uint64_t run = saved.run;
  assert_true(run != 0);
  hb_checkpoint_free(&saved);
  assert_null(saved.source);
  /* A run that goes on keeps its number whatever becomes of the text; another text without it is another run.
   */
  static char longer[] = "title: A small rod\nmethod: {duration: 9}\n";
  s.def.source = longer;
  for (int k = 0; k < 2; k++) {
    s.def.run = k ? run : 0;
    assert_int_equal(hb_checkpoint_write(in_directory("a.checkpoint"), s.sim, 42, &err), HB_OK);
    assert_int_equal(hb_checkpoint_read(in_directory("a.checkpoint"), &saved, &err), HB_OK);
    assert_true((saved.run == run) == (k == 1));
    hb_checkpoint_free(&saved);
  }
  smallsim_free(&s);
}

/* 20 steps at once, and 9 steps, a checkpoint, and 11 more in another simulation, give the same bits. */
static void test_same_bits(void **state) {
  (void)state;
  smallsim whole, before, after;
  hb_checkpoint saved;
  hb_error err = {0};
  make(&whole);
  make(&before);
  make(&after);
  steps(whole.sim, 20);
  steps(before.sim, 9);
  assert_int_equal(hb_checkpoint_write(in_directory("a.checkpoint"), before.sim, 10, &err), HB_OK);
  assert_int_equal(hb_checkpoint_read(in_directory("a.checkpoint"), &saved, &err), HB_OK);
  if (hb_sim_restore(after.sim, saved.block, saved.count, &err) != HB_OK) fail_msg("%s", err.text);
  steps(after.sim, 11);
  assert_int_equal(hb_sim_steps(after.sim), 20);
  assert_true(hb_state_hash(hb_sim_const_state(after.sim)) == hb_state_hash(hb_sim_const_state(whole.sim)));
  assert_true(hb_state_hash(hb_sim_const_state(after.sim)) != hb_state_hash(hb_sim_const_state(before.sim)));
  hb_checkpoint_free(&saved);
  smallsim_free(&whole);
  smallsim_free(&before);
  smallsim_free(&after);
}

/* Writes bytes to bad.checkpoint and reads them; the status and sentence come back. */
static hb_status read_bytes(const char *bytes, size_t size, hb_error *err) {
  hb_checkpoint saved;
  FILE *file = fopen(in_directory("bad.checkpoint"), "wb");
  assert_non_null(file);
  assert_int_equal(fwrite(bytes, 1, size, file), size);
  assert_int_equal(fclose(file), 0);
  hb_status status = hb_checkpoint_read(in_directory("bad.checkpoint"), &saved, err);
  if (status != HB_OK) assert_null(saved.block);
  hb_checkpoint_free(&saved);
  return status;
}

/* Every cut and every changed byte is noticed. */
static void test_damage(void **state) {
  (void)state;
  smallsim s;
  hb_error err = {0};
  static char bytes[1 << 16];
  make(&s);
  assert_int_equal(hb_checkpoint_write(in_directory("a.checkpoint"), s.sim, 3, &err), HB_OK);
  smallsim_free(&s);
  FILE *file = fopen(in_directory("a.checkpoint"), "rb");
  assert_non_null(file);
  size_t size = fread(bytes, 1, sizeof bytes, file);
  fclose(file);
  assert_true(size > 500 && size < sizeof bytes);
  assert_int_equal(read_bytes(bytes, size, &err), HB_OK);
  for (size_t cut = 0; cut < size; cut += 13) {
    assert_int_equal(read_bytes(bytes, cut, &err), HB_ERR_INPUT);
    assert_non_null(strstr(err.text, "bad.checkpoint: "));
  }
  for (size_t at = 0; at < size; at += 3) {
    bytes[at] ^= 0x10;
    assert_int_equal(read_bytes(bytes, size, &err), HB_ERR_INPUT);
    bytes[at] ^= 0x10;
  }
  bytes[size - 20] ^= 1;
  assert_int_equal(read_bytes(bytes, size, &err), HB_ERR_INPUT);
  assert_non_null(strstr(err.text, "the checkpoint is damaged, its check sum is wrong"));
  bytes[size - 20] ^= 1;
  assert_int_equal(read_bytes(bytes, size - 8, &err), HB_ERR_INPUT);
  assert_non_null(strstr(err.text, "do not match its header"));
  assert_int_equal(read_bytes("title: a scene\n", 15, &err), HB_ERR_INPUT);
  assert_non_null(strstr(err.text, "is no checkpoint"));
}

/* Places where no file is or can be. */
static void test_places(void **state) {
  (void)state;
  smallsim s;
  hb_checkpoint saved;
  hb_error err = {0};
  make(&s);
  assert_int_equal(hb_checkpoint_write(in_directory("none/a.checkpoint"), s.sim, 3, &err), HB_ERR_IO);
  assert_non_null(strstr(err.text, "none/a.checkpoint: cannot be written: No such file or directory"));
  assert_int_equal(hb_checkpoint_read(in_directory("none.checkpoint"), &saved, &err), HB_ERR_INPUT);
  assert_non_null(strstr(err.text, "cannot be opened: No such file or directory"));
  assert_int_equal(hb_checkpoint_read(directory, &saved, &err), HB_ERR_IO);
  assert_non_null(strstr(err.text, "is no checkpoint"));
  smallsim_free(&s);
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_round_trip), cmocka_unit_test(test_same_bits),
                                     cmocka_unit_test(test_damage), cmocka_unit_test(test_places)};
  return cmocka_run_group_tests(tests, set_up, tear_down);
}
