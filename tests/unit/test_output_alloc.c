/* Running out of memory at every single allocation of writing, reading, exporting and saving. */
#include "support/near.h"

#include "support/failing_alloc.h"
#include "support/handmade.h"
#include "support/smallsim.h"

#include "output/report.h"

#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

/* What all trials share; made before anything fails. */
typedef struct shared {
  handmade h;
  smallsim s;
  hb_frame *frame, *start;
  char trajectory[300], checkpoint[300], tables[300], report[300], directory[256];
} shared;

static shared all;

/* Removes a directory of files. */
static void remove_directory(const char *path) {
  DIR *listing = opendir(path);
  if (!listing) return;
  for (struct dirent *entry = readdir(listing); entry; entry = readdir(listing)) {
    char file[1024];
    snprintf(file, sizeof file, "%s/%s", path, entry->d_name);
    unlink(file);
  }
  closedir(listing);
  rmdir(path);
}

/* Makes directory, model, simulation and frames. */
static int set_up(void **state) {
  (void)state;
  hb_error err;
  const char *scratch = getenv("HEBRA_SCRATCH");
  snprintf(all.directory, sizeof all.directory, "%s/alloc-XXXXXX", scratch ? scratch : ".");
  if (!mkdtemp(all.directory)) return -1;
  snprintf(all.trajectory, sizeof all.trajectory, "%s/t.h5", all.directory);
  snprintf(all.checkpoint, sizeof all.checkpoint, "%s/c", all.directory);
  snprintf(all.tables, sizeof all.tables, "%s/tables", all.directory);
  snprintf(all.report, sizeof all.report, "%s/report.json", all.directory);
  handmade_fill(&all.h);
  if (!smallsim_make(&all.s, &err)) return -1;
  if (hb_frame_create(&all.h.model, &all.frame, &err) != HB_OK) return -1;
  if (hb_frame_create(all.s.model, &all.start, &err) != HB_OK) return -1;
  handmade_frame(all.frame, 0);
  hb_sim_measure(all.s.sim, all.start);
  return 0;
}

/* Frees and removes it. */
static int tear_down(void **state) {
  (void)state;
  hb_frame_free(all.frame);
  hb_frame_free(all.start);
  smallsim_free(&all.s);
  remove_directory(all.tables);
  remove_directory(all.directory);
  return 0;
}

/* A whole trajectory, begun, continued in a longer plan, and read. */
static hb_status try_trajectory(void *context, hb_error *err) {
  (void)context;
  hb_writer *writer = NULL;
  hb_reader *reader = NULL;
  double values[27];
  hb_status status = hb_writer_create(all.trajectory, &all.h.model, 2, &writer, err);
  if (status == HB_OK) status = hb_writer_add(writer, all.frame, err);
  hb_status closed = hb_writer_close(writer, err);
  if (status == HB_OK) status = closed;
  writer = NULL;
  if (status == HB_OK) status = hb_writer_continue(all.trajectory, &all.h.model, 3, 1, &writer, err);
  if (status == HB_OK) status = hb_writer_add(writer, all.frame, err);
  closed = hb_writer_close(writer, err);
  if (status == HB_OK) status = closed;
  if (status == HB_OK) status = hb_reader_open(all.trajectory, &reader, err);
  if (status == HB_OK) status = hb_reader_field(reader, "position", 1, values, err);
  if (status == HB_OK) status = hb_reader_series(reader, "time", values, err);
  hb_reader_close(reader);
  return status;
}

/* Both exports of the trajectory that the first test left. */
static hb_status try_export(void *context, hb_error *err) {
  (void)context;
  hb_reader *reader = NULL;
  hb_status status = hb_reader_open(all.trajectory, &reader, err);
  if (status == HB_OK) status = hb_export(reader, "csv", all.tables, 0, 1, 1, err);
  if (status == HB_OK) status = hb_export(reader, "vtp", all.tables, 0, 1, 1, err);
  hb_reader_close(reader);
  return status;
}

/* A checkpoint and back. */
static hb_status try_checkpoint(void *context, hb_error *err) {
  (void)context;
  hb_checkpoint saved = {0};
  hb_status status = hb_checkpoint_write(all.checkpoint, all.s.sim, 1, err);
  if (status == HB_OK) status = hb_checkpoint_read(all.checkpoint, &saved, err);
  hb_checkpoint_free(&saved);
  return status;
}

/* A recorder with its thread: memory may also run out in the thread, while it makes a checkpoint. */
static hb_status try_recorder(void *context, hb_error *err) {
  hb_recorder *recorder = NULL;
  hb_record_plan plan = {.frame = all.start, .checkpoint = all.checkpoint, .threaded = *(bool *)context};
  hb_status status = hb_recorder_create(all.s.model, &plan, &recorder, err);
  if (status) return status;
  (void)hb_recorder_add(recorder, all.s.sim, true, NULL);
  (void)hb_recorder_checkpoint(recorder, all.s.sim, NULL);
  status = hb_recorder_wait(recorder, err);
  hb_recorder_free(recorder);
  return status;
}

/* The report. */
static hb_status try_report(void *context, hb_error *err) {
  (void)context;
  return hb_report_write(all.report, all.s.sim, all.start, all.start,
                         &(hb_report_facts){.wall_seconds = 1, .stop_reason = "finished"}, err);
}

/* Each in turn; the trajectory that is left at the end is whole. */
static void test_all(void **state) {
  (void)state;
  hb_reader *reader = NULL;
  hb_error err;
  assert_true(failing_alloc_loop(try_trajectory, NULL, 1) > 30);
  assert_true(failing_alloc_loop(try_export, NULL, 1) > 40);
  assert_true(failing_alloc_loop(try_checkpoint, NULL, 1) > 6);
  for (int threaded = 0; threaded < 2; threaded++)
    assert_true(failing_alloc_loop(try_recorder, &(bool){threaded}, 1) > 12);
  assert_true(failing_alloc_loop(try_report, NULL, 1) >= 2);
  assert_int_equal(hb_reader_open(all.trajectory, &reader, &err), HB_OK);
  assert_int_equal(hb_reader_info(reader)->frames, 2);
  hb_reader_close(reader);
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_all)};
  return cmocka_run_group_tests(tests, set_up, tear_down);
}
