/* Recording beside the run: the same bytes as recording in the run, in order, and every failure comes back.
 */
#include "support/near.h"
#include "support/smallsim.h"

#include "base/memory.h"
#include "output/layout.h"

#include <dirent.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

/* A run with its files in a directory of its own, and what was seen of it. */
typedef struct recording {
  smallsim s;
  hb_writer *writer;
  hb_frame *frame;
  hb_recorder *recorder;
  char directory[256], trajectory[300], checkpoint[300];
  long seen[64], count;
} recording;

/* Notes the step of each frame; slow enough for the run to be ahead. */
static void see(void *context, const hb_frame *frame) {
  const struct timespec nap = {0, 300000};
  recording *r = context;
  nanosleep(&nap, NULL);
  assert_true(r->count < 64);
  r->seen[r->count++] = frame->step;
}

/* A place for the files and their names. */
static void new_directory(recording *r) {
  const char *scratch = getenv("HEBRA_SCRATCH");
  memset(r, 0, sizeof *r);
  snprintf(r->directory, sizeof r->directory, "%s/recorder-XXXXXX", scratch ? scratch : ".");
  assert_non_null(mkdtemp(r->directory));
  snprintf(r->trajectory, sizeof r->trajectory, "%s/t.h5", r->directory);
  snprintf(r->checkpoint, sizeof r->checkpoint, "%s/c", r->directory);
}

/* Everything up to the recorder; room: frames that the trajectory has place for. */
static void in_directory(recording *r, bool threaded, long room, double checkpoint_seconds,
                         void (*seen)(void *, const hb_frame *)) {
  hb_error err = {HB_OK, ""};
  if (!smallsim_make(&r->s, &err) || hb_frame_create(r->s.model, &r->frame, &err) ||
      hb_writer_create(r->trajectory, r->s.model, room, &r->writer, &err))
    fail_msg("%s", err.text);
  hb_record_plan plan = {.writer = r->writer,
                         .frame = r->frame,
                         .checkpoint = r->checkpoint,
                         .checkpoint_seconds = checkpoint_seconds,
                         .threaded = threaded,
                         .seen = seen,
                         .context = r};
  if (hb_recorder_create(r->s.model, &plan, &r->recorder, &err)) fail_msg("%s", err.text);
}

/* The same in a new directory. */
static void begin(recording *r, bool threaded, long room, double checkpoint_seconds) {
  new_directory(r);
  in_directory(r, threaded, room, checkpoint_seconds, see);
}

/* Closes, frees, removes. */
static void end(recording *r) {
  hb_recorder_free(r->recorder);
  hb_writer_close(r->writer, NULL);
  hb_frame_free(r->frame);
  smallsim_free(&r->s);
  unlink(r->trajectory);
  unlink(r->checkpoint);
  rmdir(r->directory);
}

/* Steps to the end with a frame every other step; stops at the first failure. Steps done. */
static long go(recording *r, hb_status *status, hb_error *err) {
  long total = hb_sim_total_steps(r->s.sim), n = 0;
  *status = HB_OK;
  while (!*status && n < total) {
    if (hb_sim_step(r->s.sim, err)) fail_msg("%s", err->text);
    n++;
    if (n % 2 == 0) *status = hb_recorder_add(r->recorder, r->s.sim, n == total, err);
  }
  return n;
}

/* All bytes of a file, to be freed; fails if there is none. */
static char *bytes_of(const char *path, size_t *size) {
  struct stat about;
  FILE *file = fopen(path, "rb");
  assert_non_null(file);
  assert_int_equal(fstat(fileno(file), &about), 0);
  *size = (size_t)about.st_size;
  char *bytes = hb_alloc(*size, 1);
  assert_non_null(bytes);
  assert_int_equal(fread(bytes, 1, *size, file), *size);
  fclose(file);
  return bytes;
}

/* Fails unless both files have the same bytes. */
static void assert_same_file(const char *a, const char *b) {
  size_t size_a, size_b;
  char *of_a = bytes_of(a, &size_a), *of_b = bytes_of(b, &size_b);
  assert_int_equal(size_a, size_b);
  assert_memory_equal(of_a, of_b, size_a);
  hb_free(of_a);
  hb_free(of_b);
}

/* With and without a thread: the same trajectory and checkpoint, every frame seen once and in order. */
static void a_thread_changes_nothing(void **state) {
  (void)state;
  recording with, without;
  recording *both[2] = {&with, &without};
  for (int k = 0; k < 2; k++) {
    recording *r = both[k];
    hb_error err = {HB_OK, ""};
    hb_status status;
    begin(r, k == 0, 25, 1000);
    assert_int_equal(go(r, &status, &err), 50);
    assert_int_equal(status, HB_OK);
    assert_int_equal(hb_recorder_wait(r->recorder, &err), HB_OK);
    assert_int_equal(hb_recorder_frames(r->recorder), 25);
    assert_int_equal(r->count, 25);
    for (int n = 0; n < 25; n++) assert_int_equal(r->seen[n], 2 * n + 2);
    assert_int_equal(r->frame->step, 50);
    assert_int_equal(hb_writer_close(r->writer, &err), HB_OK);
    r->writer = NULL;
  }
  assert_same_file(with.trajectory, without.trajectory);
  assert_same_file(with.checkpoint, without.checkpoint);
  for (int k = 0; k < 2; k++) end(both[k]);
}

/* A checkpoint alone is of the state when it was asked for, although the run goes on, and counts the frames
 * handed over before it. */
static void a_checkpoint_is_of_its_moment(void **state) {
  (void)state;
  for (int threaded = 0; threaded < 2; threaded++) {
    recording r;
    hb_error err = {HB_OK, ""};
    hb_checkpoint saved;
    begin(&r, threaded, 25, 1000);
    for (int n = 0; n < 7; n++) assert_int_equal(hb_sim_step(r.s.sim, &err), HB_OK);
    assert_int_equal(hb_recorder_add(r.recorder, r.s.sim, false, &err), HB_OK);
    assert_int_equal(hb_recorder_checkpoint(r.recorder, r.s.sim, &err), HB_OK);
    if (!threaded) assert_int_equal(access(r.checkpoint, F_OK), 0);
    for (int n = 0; n < 30; n++) assert_int_equal(hb_sim_step(r.s.sim, &err), HB_OK);
    assert_int_equal(hb_recorder_wait(r.recorder, &err), HB_OK);
    assert_int_equal(hb_checkpoint_read(r.checkpoint, &saved, &err), HB_OK);
    assert_int_equal(saved.frames, 1);
    assert_int_equal((long)saved.block[HB_S_STEP], 7);
    assert_int_equal(saved.count, hb_sim_const_state(r.s.sim)->count);
    hb_checkpoint_free(&saved);
    end(&r);
  }
}

/* 0 seconds between checkpoints: one with every frame, whose number of frames grows. */
static void checkpoints_come_in_time(void **state) {
  (void)state;
  recording r;
  hb_error err = {HB_OK, ""};
  hb_checkpoint saved;
  begin(&r, true, 25, 0);
  for (int n = 0; n < 3; n++) assert_int_equal(hb_recorder_add(r.recorder, r.s.sim, false, &err), HB_OK);
  assert_int_equal(hb_recorder_wait(r.recorder, &err), HB_OK);
  assert_int_equal(hb_checkpoint_read(r.checkpoint, &saved, &err), HB_OK);
  assert_int_equal(saved.frames, 3);
  hb_checkpoint_free(&saved);
  end(&r);
}

/* The frame that does not fit ends the recording with the writer's own sentence; the frames before it stay,
 * and nothing is seen or saved any more. */
static void a_failure_comes_back(void **state) {
  (void)state;
  for (int threaded = 0; threaded < 2; threaded++) {
    recording r;
    hb_error err = {HB_OK, ""}, again = {HB_OK, ""};
    hb_status status;
    begin(&r, threaded, 4, 1000);
    long steps = go(&r, &status, &err);
    if (!threaded) assert_int_equal(steps, 10); /* the fifth frame; with a thread the run is ahead of it */
    if (!status) status = hb_recorder_wait(r.recorder, &err);
    assert_int_equal(status, HB_ERR_INPUT);
    assert_int_equal(err.status, HB_ERR_INPUT);
    assert_non_null(strstr(err.text, "t.h5: frame 4 does not fit, the trajectory was planned for 4 frames"));
    assert_int_equal(hb_recorder_checkpoint(r.recorder, r.s.sim, &again), HB_ERR_INPUT);
    assert_string_equal(err.text, again.text);
    assert_int_equal(hb_recorder_wait(r.recorder, &again), HB_ERR_INPUT);
    assert_int_equal(hb_recorder_check(r.recorder, NULL), HB_ERR_INPUT);
    assert_string_equal(err.text, again.text);
    assert_int_equal(hb_recorder_frames(r.recorder), 4);
    assert_int_equal(r.count, 4);
    assert_int_equal(r.frame->step, 10); /* the one that failed is the last that was measured */
    assert_true(access(r.checkpoint, F_OK) != 0);
    end(&r);
  }
}

/* The length of file that `frames` frames need in a trajectory laid out for `room`: to the byte in the table
 * that lies last. */
static rlim_t length_of(const recording *r, long room, long frames) {
  char path[320];
  hb_writer *writer = NULL;
  hb_error err = {HB_OK, ""};
  hb_layout_map map;
  uint64_t length = 0, last = 0;
  snprintf(path, sizeof path, "%s/twin.h5", r->directory);
  if (hb_writer_create(path, r->s.model, room, &writer, &err) || hb_writer_close(writer, &err))
    fail_msg("%s", err.text);
  hid_t file = H5Fopen(path, H5F_ACC_RDONLY, H5P_DEFAULT);
  assert_true(file >= 0);
  if (hb_layout_locate(file, path, r->s.model, &map, &err)) fail_msg("%s", err.text);
  for (int k = 0; k < map.count; k++) {
    if (map.at[k] < last) continue;
    last = map.at[k];
    length = map.at[k] + (uint64_t)frames * map.stride[k];
  }
  hb_layout_map_free(&map);
  H5Fclose(file);
  unlink(path);
  return (rlim_t)length;
}

/* A disk that has room for three frames: these are kept, and the fourth is told of, also where all were to be
 * written in one go. */
static void a_full_disk_is_told(void **state) {
  (void)state;
  struct sigaction ignore = {.sa_handler = SIG_IGN}, old_action;
  for (int threaded = 0; threaded < 2; threaded++) {
    recording r;
    struct rlimit old, limit;
    hb_error err = {HB_OK, ""};
    hb_status status;
    hb_reader *reader = NULL;
    begin(&r, threaded, 100000, 1000);
    assert_int_equal(getrlimit(RLIMIT_FSIZE, &old), 0);
    limit = old;
    limit.rlim_cur = length_of(&r, 100000, 3);
    sigaction(SIGXFSZ, &ignore, &old_action);
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &limit), 0);
    (void)go(&r, &status, &err);
    if (!status) status = hb_recorder_wait(r.recorder, &err);
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &old), 0);
    sigaction(SIGXFSZ, &old_action, NULL);
    assert_int_equal(status, HB_ERR_IO);
    assert_non_null(strstr(err.text, "t.h5: frame 3 cannot be written: File too large"));
    assert_int_equal(hb_recorder_wait(r.recorder, NULL), HB_ERR_IO);
    assert_int_equal(hb_recorder_frames(r.recorder), 3);
    hb_writer_close(r.writer, NULL);
    r.writer = NULL;
    assert_int_equal(hb_reader_open(r.trajectory, &reader, &err), HB_OK);
    assert_int_equal(hb_reader_info(reader)->frames, 3);
    hb_reader_close(reader);
    end(&r);
  }
}

/* Ends the process at the seventh frame, as a kill would. */
static void die_at_seven(void *context, const hb_frame *frame) {
  see(context, frame);
  if (((recording *)context)->count == 7) _exit(7);
}

/* A checkpoint never counts frames that are not in the file: a run is killed just after the checkpoint of its
 * fifth frame, while more frames wait. */
static void a_checkpoint_comes_after_its_frames(void **state) {
  (void)state;
  recording r;
  hb_error err = {HB_OK, ""};
  hb_checkpoint saved;
  hb_reader *reader = NULL;
  int how = 0;
  new_directory(&r);
  pid_t child = fork(); /* before there is any thread */
  assert_true(child >= 0);
  if (child == 0) {
    in_directory(&r, true, 25, 1000, die_at_seven);
    for (int n = 1; n <= 20; n++) {
      if (hb_sim_step(r.s.sim, &err) || hb_recorder_add(r.recorder, r.s.sim, n == 5, &err)) _exit(1);
    }
    hb_recorder_wait(r.recorder, &err);
    _exit(2);
  }
  assert_int_equal(waitpid(child, &how, 0), child);
  assert_true(WIFEXITED(how));
  assert_int_equal(WEXITSTATUS(how), 7);
  if (hb_checkpoint_read(r.checkpoint, &saved, &err)) fail_msg("%s", err.text);
  assert_int_equal(saved.frames, 5);
  assert_int_equal((long)saved.block[HB_S_STEP], 5);
  hb_checkpoint_free(&saved);
  if (hb_reader_open(r.trajectory, &reader, &err)) fail_msg("%s", err.text);
  assert_true(hb_reader_info(reader)->frames >= 5);
  hb_reader_close(reader);
  end(&r);
}

/* A checkpoint that cannot be written is told too, after its frame has been kept. */
static void a_lost_directory_is_told(void **state) {
  (void)state;
  recording r;
  hb_error err = {HB_OK, ""};
  begin(&r, true, 25, 0);
  assert_int_equal(hb_recorder_add(r.recorder, r.s.sim, false, &err), HB_OK);
  assert_int_equal(hb_recorder_wait(r.recorder, &err), HB_OK);
  unlink(r.trajectory);
  unlink(r.checkpoint);
  assert_int_equal(rmdir(r.directory), 0);
  (void)hb_recorder_add(r.recorder, r.s.sim, false, &err);
  assert_int_equal(hb_recorder_wait(r.recorder, &err), HB_ERR_IO);
  assert_non_null(strstr(err.text, "/c: cannot be written: No such file or directory"));
  assert_int_equal(hb_recorder_frames(r.recorder), 2);
  end(&r);
}

/* A measure of its own says the same as the simulation, to the bit, on every scene of the gallery, and also
 * when it has just measured another state. */
static void a_copy_measures_the_same(void **state) {
  (void)state;
  int scenes = 0;
  DIR *directory = opendir(HEBRA_SOURCE_DIR "/scenes");
  assert_non_null(directory);
  for (struct dirent *entry; (entry = readdir(directory));) {
    char path[600];
    const char *dot = strrchr(entry->d_name, '.');
    if (!dot || strcmp(dot, ".yaml") != 0) continue;
    hb_scene_def def;
    hb_model *model = NULL;
    hb_sim *sim = NULL;
    hb_frame *first = NULL, *second = NULL;
    hb_measure *measure = NULL;
    hb_state *copy = NULL;
    hb_error err = {HB_OK, ""};
    snprintf(path, sizeof path, "%s/scenes/%s", HEBRA_SOURCE_DIR, entry->d_name);
    if (hb_scene_read(path, NULL, 0, &def, &err) || hb_model_create(&def, &model, &err) ||
        hb_sim_create(model, &sim, &err) || hb_frame_create(model, &first, &err) ||
        hb_frame_create(model, &second, &err) || hb_measure_create(model, &measure, &err) ||
        hb_state_create(model, &copy, &err))
      fail_msg("%s", err.text);
    size_t doubles = 0;
    for (int k = 0; k < hb_frame_field_count; k++)
      doubles += (size_t)hb_frame_fields[k].components * (size_t)model->nv;
    for (int n = 0; n < 12; n++) {
      hb_measure_state(measure, hb_sim_const_state(sim), second); /* of the step before */
      if (hb_sim_step(sim, &err)) fail_msg("%s", err.text);
      hb_state_copy(copy, hb_sim_const_state(sim));
      hb_sim_measure(sim, first);
      hb_measure_state(measure, copy, second);
      assert_memory_equal(first, second, offsetof(hb_frame, position));
      assert_memory_equal(first->position, second->position, doubles * sizeof(double));
    }
    hb_state_free(copy);
    hb_measure_free(measure);
    hb_frame_free(second);
    hb_frame_free(first);
    hb_sim_free(sim);
    hb_model_free(model);
    hb_scene_def_free(&def);
    scenes++;
  }
  closedir(directory);
  assert_true(scenes >= 10);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_thread_changes_nothing),
      cmocka_unit_test(a_checkpoint_is_of_its_moment),
      cmocka_unit_test(checkpoints_come_in_time),
      cmocka_unit_test(a_failure_comes_back),
      cmocka_unit_test(a_full_disk_is_told),
      cmocka_unit_test(a_lost_directory_is_told),
      cmocka_unit_test(a_checkpoint_comes_after_its_frames),
      cmocka_unit_test(a_copy_measures_the_same),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
