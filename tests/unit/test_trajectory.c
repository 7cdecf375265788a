/* Trajectory files: what is written comes back, whatever interrupts the writing. */
#include "support/near.h"

#include "support/handmade.h"

#include "hebra/output.h"

#include <fcntl.h>
#include <hdf5.h>
#include <signal.h>
#include <stdlib.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <time.h>
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
  snprintf(directory, sizeof directory, "%s/trajectory-XXXXXX", scratch ? scratch : ".");
  return mkdtemp(directory) ? 0 : -1;
}

/* Removes the directory, which must hold nothing but finished files: a temporary file left behind fails. */
static int tear_down(void **state) {
  (void)state;
  static const char *const names[] = {"a.h5", "b.h5", "c.h5", "killed.h5", "bad.h5", "promised"};
  for (size_t k = 0; k < sizeof names / sizeof names[0]; k++) unlink(in_directory(names[k]));
  return rmdir(directory);
}

/* Compares all fields of one frame with what was written. */
static void check_frame(hb_reader *reader, long number) {
  double values[4 * 9];
  hb_error err;
  for (int k = 0; k < hb_frame_field_count; k++) {
    int c = hb_frame_fields[k].components;
    assert_int_equal(hb_reader_field(reader, hb_frame_fields[k].name, number, values, &err), HB_OK);
    for (int i = 0; i < 9 * c; i++) assert_same(values[i], handmade_number(k, i / c, i % c, number));
  }
}

/* Compares every series. */
static void check_series(hb_reader *reader) {
  long frames = hb_reader_info(reader)->frames;
  static const struct {
    const char *name;
    double factor, constant;
  } expected[] = {{"time", 0.25, 0},
                  {"step", 10, 0},
                  {"kinetic", 1, 0.1},
                  {"bending", 1, 0.2},
                  {"twisting", 1, 0.3},
                  {"gravity", 1, 0.4},
                  {"work_loads", 1, 0.5},
                  {"work_supports", 1, 0.6},
                  {"dissipated", 1, 0.7},
                  {"balance", 1e-9, 0},
                  {"momentum_x", 1, 0},
                  {"momentum_y", 1, 0.01},
                  {"momentum_z", 1, 0.02},
                  {"angular_momentum_x", 1, 0},
                  {"angular_momentum_y", 1, 0.03},
                  {"angular_momentum_z", 1, 0.06},
                  {"length_error", 1e-12, 0},
                  {"worst_length_error", 2e-12, 0}};
  double *values = malloc((size_t)frames * sizeof *values);
  assert_non_null(values);
  for (size_t k = 0; k < sizeof expected / sizeof expected[0]; k++) {
    hb_error err;
    assert_int_equal(hb_reader_series(reader, expected[k].name, values, &err), HB_OK);
    for (long n = 0; n < frames; n++)
      assert_same(values[n], expected[k].factor * (double)n + expected[k].constant);
  }
  free(values);
}

/* Opens, checks all series and the fields of the first, the last, and some frames between; gives their
 * number. */
static long check_file(const char *path) {
  hb_reader *reader = NULL;
  hb_error err = {0};
  if (hb_reader_open(path, &reader, &err) != HB_OK) fail_msg("%s", err.text);
  const hb_trajectory_info *info = hb_reader_info(reader);
  long frames = info->frames;
  assert_int_equal(info->nv, 9);
  assert_int_equal(info->rod_count, 2);
  assert_string_equal(info->rods[0].name, "lower");
  assert_string_equal(info->rods[1].name, "upper rod");
  assert_int_equal(info->rods[1].first, 5);
  assert_int_equal(info->rods[1].nv, 4);
  assert_same(info->rods[1].radius, 0.125);
  assert_string_equal(info->title, "Two \"rods\"\n\xce\xb1\\\xce\xb2");
  assert_string_equal(info->source, "title: two rods\nrods: []\n");
  assert_string_equal(info->version, HB_VERSION);
  for (long n = 0; n < frames; n += n < 8 || n > frames - 8 ? 1 : 1 + (frames - n) / 4)
    check_frame(reader, n);
  check_series(reader);
  hb_reader_close(reader);
  return frames;
}

/* Adds frames from .. to-1. */
static void add(hb_writer *writer, const handmade *h, long from, long to) {
  hb_frame *frame = NULL;
  hb_error err;
  assert_int_equal(hb_frame_create(&h->model, &frame, &err), HB_OK);
  for (long n = from; n < to; n++) {
    handmade_frame(frame, n);
    if (hb_writer_add(writer, frame, &err) != HB_OK) fail_msg("%s", err.text);
  }
  hb_frame_free(frame);
}

/* A whole file of `frames` frames planned for `plan`. */
static void write_file(const char *path, const handmade *h, long plan, long frames) {
  hb_writer *writer = NULL;
  hb_error err;
  if (hb_writer_create(path, &h->model, plan, &writer, &err) != HB_OK) fail_msg("%s", err.text);
  add(writer, h, 0, frames);
  assert_int_equal(hb_writer_close(writer, &err), HB_OK);
}

/* All numbers come back bit for bit. */
static void test_round_trip(void **state) {
  (void)state;
  handmade h;
  handmade_fill(&h);
  write_file(in_directory("a.h5"), &h, 7, 7);
  assert_int_equal(check_file(in_directory("a.h5")), 7);
}

/* Another opening, while the writer holds the file, sees each frame as soon as it is added. */
static void test_readable_while_written(void **state) {
  (void)state;
  handmade h;
  handmade_fill(&h);
  hb_writer *writer = NULL;
  hb_error err;
  assert_int_equal(hb_writer_create(in_directory("a.h5"), &h.model, 5, &writer, &err), HB_OK);
  for (long n = 0; n < 5; n++) {
    pid_t child = fork();
    if (child == 0) {
      hb_reader *reader = NULL;
      bool good =
          hb_reader_open(in_directory("a.h5"), &reader, &err) == HB_OK && hb_reader_info(reader)->frames == n;
      double values[27];
      for (long k = 0; good && k < n; k++)
        good = hb_reader_field(reader, "position", k, values, &err) == HB_OK &&
               values[4] == handmade_number(0, 1, 1, k);
      _exit(good ? 0 : 1);
    }
    int status = 0;
    assert_int_equal(waitpid(child, &status, 0), child);
    assert_true(WIFEXITED(status));
    assert_int_equal(WEXITSTATUS(status), 0);
    add(writer, &h, n, n + 1);
  }
  assert_int_equal(hb_writer_close(writer, &err), HB_OK);
  assert_int_equal(check_file(in_directory("a.h5")), 5);
}

/* Frames that were planned but not written take no disk space. */
static void test_holes(void **state) {
  (void)state;
  handmade h;
  handmade_fill(&h);
  write_file(in_directory("a.h5"), &h, 100000, 3);
  struct stat info;
  assert_int_equal(stat(in_directory("a.h5"), &info), 0);
  assert_true(info.st_size > 100000L * 9 * 41 * 8);
  assert_true((long)info.st_blocks * 512 < 8L << 20);
  assert_int_equal(check_file(in_directory("a.h5")), 3);
}

/* What VTK needs to find, checked with HDF5 itself: versions, offsets, length of the times equal to the
 * frames. */
static void test_vtk_layout(void **state) {
  (void)state;
  handmade h;
  handmade_fill(&h);
  write_file(in_directory("a.h5"), &h, 6, 4);
  hid_t file = H5Fopen(in_directory("a.h5"), H5F_ACC_RDONLY, H5P_DEFAULT);
  assert_true(file >= 0);
  long long version[2] = {0, 0}, numbers[24] = {0};
  hid_t attribute = H5Aopen_by_name(file, "VTKHDF", "Version", H5P_DEFAULT, H5P_DEFAULT);
  assert_true(H5Aread(attribute, H5T_NATIVE_LLONG, version) >= 0);
  H5Aclose(attribute);
  assert_int_equal(version[0], 2);
  assert_int_equal(version[1], 0);
  hid_t set = H5Dopen2(file, "VTKHDF/Steps/Values", H5P_DEFAULT), space = H5Dget_space(set);
  double times[4] = {0};
  assert_int_equal(H5Sget_simple_extent_npoints(space), 4);
  assert_true(H5Dread(set, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, times) >= 0);
  for (int n = 0; n < 4; n++) assert_same(times[n], 0.25 * n);
  H5Sclose(space);
  H5Dclose(set);
  set = H5Dopen2(file, "VTKHDF/Steps/PointDataOffsets/m1", H5P_DEFAULT);
  assert_true(H5Dread(set, H5T_NATIVE_LLONG, H5S_ALL, H5S_ALL, H5P_DEFAULT, numbers) >= 0);
  for (int n = 0; n < 6; n++) assert_int_equal(numbers[n], 9 * n);
  H5Dclose(set);
  set = H5Dopen2(file, "VTKHDF/Steps/PointDataOffsets/radius", H5P_DEFAULT);
  assert_true(H5Dread(set, H5T_NATIVE_LLONG, H5S_ALL, H5S_ALL, H5P_DEFAULT, numbers) >= 0);
  for (int n = 0; n < 6; n++) assert_int_equal(numbers[n], 0);
  H5Dclose(set);
  set = H5Dopen2(file, "VTKHDF/Lines/Offsets", H5P_DEFAULT);
  assert_true(H5Dread(set, H5T_NATIVE_LLONG, H5S_ALL, H5S_ALL, H5P_DEFAULT, numbers) >= 0);
  assert_int_equal(numbers[0], 0);
  assert_int_equal(numbers[1], 5);
  assert_int_equal(numbers[2], 9);
  H5Dclose(set);
  double tension[54];
  set = H5Dopen2(file, "VTKHDF/PointData/tension", H5P_DEFAULT);
  assert_true(H5Dread(set, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, tension) >= 0);
  assert_same(tension[9 + 4], tension[9 + 3]); /* the row without an edge repeats the one before */
  assert_same(tension[9 + 8], tension[9 + 7]);
  assert_true(tension[9 + 5] != tension[9 + 4]);
  H5Dclose(set);
  set = H5Dopen2(file, "hebra/edges", H5P_DEFAULT);
  assert_true(H5Dread(set, H5T_NATIVE_LLONG, H5S_ALL, H5S_ALL, H5P_DEFAULT, numbers) >= 0);
  static const int edges[] = {0, 1, 2, 3, 5, 6, 7};
  for (int k = 0; k < 7; k++) assert_int_equal(numbers[k], edges[k]);
  H5Dclose(set);
  H5Fclose(file);
}

/* Going on after any number of frames, in place or with a longer plan, gives the file of an uninterrupted
 * run. */
static void test_continue(void **state) {
  (void)state;
  handmade h;
  handmade_fill(&h);
  for (long keep = 0; keep <= 4; keep++)
    for (long plan = 6; plan <= 9; plan += 3) {
      hb_writer *writer = NULL;
      hb_error err;
      write_file(in_directory("b.h5"), &h, 6, 4);
      if (hb_writer_continue(in_directory("b.h5"), &h.model, plan, keep, &writer, &err) != HB_OK)
        fail_msg("%s", err.text);
      assert_int_equal(check_file(in_directory("b.h5")), keep);
      add(writer, &h, keep, plan);
      assert_int_equal(hb_writer_close(writer, &err), HB_OK);
      assert_int_equal(check_file(in_directory("b.h5")), plan);
    }
}

/* A file of another scene, or with fewer frames, is refused with a sentence and left as it is. */
static void test_continue_refused(void **state) {
  (void)state;
  handmade h, other;
  hb_writer *writer = NULL;
  hb_error err;
  handmade_fill(&h);
  handmade_fill(&other);
  write_file(in_directory("b.h5"), &h, 6, 4);
  assert_int_equal(hb_writer_continue(in_directory("b.h5"), &h.model, 6, 5, &writer, &err), HB_ERR_INPUT);
  assert_non_null(strstr(err.text, "cannot go on after frame 5, it holds 4 frames"));
  other.rods[1].name = "another";
  assert_int_equal(hb_writer_continue(in_directory("b.h5"), &other.model, 6, 2, &writer, &err), HB_ERR_INPUT);
  assert_non_null(strstr(
      err.text, "its rod 1 is \"upper rod\" with 4 vertices, that of the scene is \"another\" with 4"));
  other.model.nv = 10;
  assert_int_equal(hb_writer_continue(in_directory("b.h5"), &other.model, 6, 2, &writer, &err), HB_ERR_INPUT);
  assert_non_null(strstr(err.text, "holds 2 rods with 9 vertices in all, the scene has 2 with 10"));
  assert_null(writer);
  assert_int_equal(check_file(in_directory("b.h5")), 4);
}

/* Only the run that wrote a file goes on with it: the same rods in another scene are refused, the same run
 * made longer is not, whatever its text has become, also from the larger copy on. */
static void test_run_number(void **state) {
  (void)state;
  static char changed[] = "title: two rods\nmethod: {duration: 9}\nrods: []\n";
  handmade h, other;
  hb_writer *writer = NULL;
  hb_error err;
  handmade_fill(&h);
  handmade_fill(&other);
  h.def.run = 0x1234abcd;
  write_file(in_directory("b.h5"), &h, 6, 4);
  other.def.source = changed;
  assert_int_equal(hb_writer_continue(in_directory("b.h5"), &other.model, 6, 2, &writer, &err), HB_ERR_INPUT);
  assert_non_null(strstr(err.text, "b.h5: belongs to another run (000000001234abcd, titled "));
  assert_null(writer);
  assert_int_equal(check_file(in_directory("b.h5")), 4);
  other.def.run = 0x1234abcd;
  for (long plan = 6; plan <= 10; plan += 2) {
    if (hb_writer_continue(in_directory("b.h5"), &other.model, plan, 2, &writer, &err) != HB_OK)
      fail_msg("%s", err.text);
    assert_int_equal(hb_writer_close(writer, &err), HB_OK);
  }
  other.def.run = 0;
  other.def.source = NULL;
  writer = NULL;
  assert_int_equal(hb_writer_create(in_directory("b.h5"), &other.model, 6, &writer, &err), HB_OK);
  add(writer, &other, 0, 3);
  assert_int_equal(hb_writer_close(writer, &err), HB_OK);
  assert_int_equal(hb_writer_continue(in_directory("b.h5"), &other.model, 6, 2, &writer, &err), HB_OK);
  assert_int_equal(hb_writer_close(writer, &err), HB_OK);
  other.def.method.time_step += 1;
  assert_int_equal(hb_writer_continue(in_directory("b.h5"), &other.model, 6, 2, &writer, &err), HB_ERR_INPUT);
}

/* Files may become no longer than this; gives what was allowed before. */
static rlim_t limit_files(rlim_t bytes) {
  struct rlimit limit;
  assert_int_equal(getrlimit(RLIMIT_FSIZE, &limit), 0);
  rlim_t before = limit.rlim_cur;
  limit.rlim_cur = bytes;
  assert_int_equal(setrlimit(RLIMIT_FSIZE, &limit), 0);
  return before;
}

/* A disk that takes no more bytes while a file is made: a sentence with the system's reason, the older file
 * as it was, nothing else left (the directory is empty in the end), and HDF5 can end in peace. */
static void test_full_while_created(void **state) {
  (void)state;
  handmade h;
  struct stat about;
  void (*handler)(int) = signal(SIGXFSZ, SIG_IGN);
  handmade_fill(&h);
  write_file(in_directory("c.h5"), &h, 6, 5);
  assert_int_equal(stat(in_directory("c.h5"), &about), 0);
  for (off_t bytes = 0; bytes < about.st_size; bytes += about.st_size / 37) {
    hb_writer *writer = NULL;
    hb_error err = {0};
    rlim_t before = limit_files((rlim_t)bytes);
    hb_status made = hb_writer_create(in_directory("c.h5"), &h.model, 6, &writer, &err);
    hb_status longer = hb_writer_continue(in_directory("c.h5"), &h.model, 20, 2, &writer, NULL);
    limit_files(before);
    assert_int_equal(made, HB_ERR_IO);
    assert_int_equal(longer, HB_ERR_IO);
    assert_null(writer);
    assert_non_null(strstr(err.text, "c.h5: "));
    assert_non_null(strstr(err.text, ": File too large"));
  }
  assert_int_equal(check_file(in_directory("c.h5")), 5);
  signal(SIGXFSZ, handler);
}

/* A disk that takes no more bytes while frames are added, wherever it begins to refuse them: a sentence, and
 * the file opens with the frames that were added. */
static void test_full_while_added(void **state) {
  (void)state;
  handmade h;
  hb_frame *frame = NULL;
  struct stat about;
  hb_error err = {0};
  void (*handler)(int) = signal(SIGXFSZ, SIG_IGN);
  handmade_fill(&h);
  assert_int_equal(hb_frame_create(&h.model, &frame, &err), HB_OK);
  write_file(in_directory("c.h5"), &h, 6, 6);
  assert_int_equal(stat(in_directory("c.h5"), &about), 0);
  for (off_t bytes = 0; bytes < about.st_size; bytes += about.st_size / 37) {
    hb_writer *writer = NULL;
    assert_int_equal(hb_writer_create(in_directory("c.h5"), &h.model, 6, &writer, &err), HB_OK);
    add(writer, &h, 0, 2);
    long n = 2;
    rlim_t before = limit_files((rlim_t)bytes);
    hb_status status = HB_OK;
    for (; status == HB_OK && n < 6; n++) {
      handmade_frame(frame, n);
      status = hb_writer_add(writer, frame, &err);
    }
    (void)hb_writer_close(writer, NULL); /* may say again what went wrong */
    limit_files(before);
    long found = check_file(in_directory("c.h5"));
    if (status == HB_OK) {
      assert_int_equal(found, 6);
      continue;
    }
    assert_int_equal(status, HB_ERR_IO);
    assert_non_null(strstr(err.text, ": File too large"));
    assert_true(found == n - 1 || found == n);
  }
  hb_frame_free(frame);
  signal(SIGXFSZ, handler);
}

/* More frames than planned, absurd plans, places where no file can be. */
static void test_writer_errors(void **state) {
  (void)state;
  handmade h;
  hb_writer *writer = NULL;
  hb_error err;
  handmade_fill(&h);
  assert_int_equal(hb_writer_create(in_directory("c.h5"), &h.model, 2, &writer, &err), HB_OK);
  add(writer, &h, 0, 2);
  hb_frame *frame = NULL;
  assert_int_equal(hb_frame_create(&h.model, &frame, &err), HB_OK);
  assert_int_equal(hb_writer_add(writer, frame, &err), HB_ERR_INPUT);
  assert_non_null(strstr(err.text, "frame 2 does not fit, the trajectory was planned for 2 frames"));
  hb_frame_free(frame);
  assert_int_equal(hb_writer_close(writer, &err), HB_OK);
  writer = NULL;
  assert_int_equal(hb_writer_create(in_directory("c.h5"), &h.model, 0, &writer, &err), HB_ERR_INPUT);
  assert_int_equal(hb_writer_create(in_directory("c.h5"), &h.model, 600000000L, &writer, &err), HB_ERR_INPUT);
  assert_int_equal(hb_writer_create(in_directory("none/c.h5"), &h.model, 2, &writer, &err), HB_ERR_IO);
  assert_non_null(strstr(err.text, "none/c.h5"));
  assert_null(writer);
  assert_int_equal(check_file(in_directory("c.h5")), 2); /* the failures left the older file alone */
  assert_int_equal(hb_writer_close(NULL, &err), HB_OK);
}

/* Writes bytes to bad.h5. */
static void write_bytes(const void *bytes, size_t size) {
  FILE *file = fopen(in_directory("bad.h5"), "wb");
  assert_non_null(file);
  assert_int_equal(fwrite(bytes, 1, size, file), size);
  assert_int_equal(fclose(file), 0);
}

/* Files that are no trajectories. */
static void test_reader_errors(void **state) {
  (void)state;
  hb_reader *reader = NULL;
  hb_error err;
  assert_int_equal(hb_reader_open(in_directory("none.h5"), &reader, &err), HB_ERR_INPUT);
  assert_non_null(strstr(err.text, "none.h5: cannot be opened: No such file or directory"));
  write_bytes("title: a scene\n", 15);
  assert_int_equal(hb_reader_open(in_directory("bad.h5"), &reader, &err), HB_ERR_INPUT);
  assert_non_null(strstr(err.text, "is no trajectory, expected an HDF5 file"));
  hid_t file = H5Fcreate(in_directory("bad.h5"), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
  H5Fclose(file);
  assert_int_equal(hb_reader_open(in_directory("bad.h5"), &reader, &err), HB_ERR_INPUT);
  assert_non_null(strstr(err.text, "no trajectory of hebra"));
  assert_int_equal(hb_reader_open(directory, &reader, &err), HB_ERR_IO);
  assert_null(reader);
}

/* A trajectory cut anywhere gives a sentence. */
static void test_truncated(void **state) {
  (void)state;
  handmade h;
  handmade_fill(&h);
  write_file(in_directory("a.h5"), &h, 2, 2);
  FILE *file = fopen(in_directory("a.h5"), "rb");
  assert_non_null(file);
  static char bytes[1 << 17];
  size_t size = fread(bytes, 1, sizeof bytes, file);
  fclose(file);
  assert_true(size < sizeof bytes);
  for (size_t cut = 0; cut < size; cut += 97) {
    hb_reader *reader = NULL;
    hb_error err = {0};
    write_bytes(bytes, cut);
    assert_int_equal(hb_reader_open(in_directory("bad.h5"), &reader, &err), HB_ERR_INPUT);
    assert_null(reader);
    assert_non_null(strstr(err.text, "bad.h5: "));
  }
}

/* Opens bad.h5 and asks for everything; true if nothing was refused. */
static bool read_bad(void) {
  hb_reader *reader = NULL;
  hb_error err = {0};
  double values[36];
  if (hb_reader_open(in_directory("bad.h5"), &reader, &err) != HB_OK) {
    assert_non_null(strstr(err.text, "bad.h5: "));
    return false;
  }
  bool good = hb_reader_info(reader)->nv == 9 && hb_reader_info(reader)->frames <= 2;
  for (int k = 0; good && k < hb_frame_field_count; k++)
    good = hb_reader_field(reader, hb_frame_fields[k].name, 0, values, &err) == HB_OK;
  hb_reader_close(reader);
  return good;
}

/* A changed byte in the structure of the file is noticed before HDF5 sees it; one in a table changes no more
 * than numbers. */
static void test_damaged(void **state) {
  (void)state;
  handmade h;
  handmade_fill(&h);
  write_file(in_directory("a.h5"), &h, 2, 2);
  FILE *file = fopen(in_directory("a.h5"), "rb");
  assert_non_null(file);
  static char bytes[1 << 17];
  size_t size = fread(bytes, 1, sizeof bytes, file), refused = 0, tried = 0;
  fclose(file);
  write_bytes(bytes, size);
  assert_true(read_bad());
  for (size_t at = 0; at < size; at += 41, tried++) {
    char kept = bytes[at];
    bytes[at] = (char)(kept ^ 0x5a);
    write_bytes(bytes, size);
    refused += !read_bad();
    bytes[at] = kept;
  }
  assert_true(refused > tried / 3);
}

/* A file to which another program has added something is still read. */
static void test_added_object(void **state) {
  (void)state;
  handmade h;
  handmade_fill(&h);
  write_file(in_directory("a.h5"), &h, 3, 3);
  hid_t file = H5Fopen(in_directory("a.h5"), H5F_ACC_RDWR, H5P_DEFAULT);
  assert_true(file >= 0);
  hid_t group = H5Gcreate2(file, "mine", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
  assert_true(group >= 0);
  H5Gclose(group);
  H5Fclose(file);
  assert_int_equal(check_file(in_directory("a.h5")), 3);
}

/* Wrong names and frames. */
static void test_wrong_requests(void **state) {
  (void)state;
  handmade h;
  hb_reader *reader = NULL;
  hb_error err;
  double values[36];
  handmade_fill(&h);
  write_file(in_directory("a.h5"), &h, 3, 2);
  assert_int_equal(hb_reader_open(in_directory("a.h5"), &reader, &err), HB_OK);
  assert_int_equal(hb_reader_field(reader, "colour", 0, values, &err), HB_ERR_INPUT);
  assert_non_null(strstr(err.text, "there is no field \"colour\""));
  assert_int_equal(hb_reader_field(reader, "twist", 2, values, &err), HB_ERR_INPUT);
  assert_non_null(strstr(err.text, "there is no frame 2, the trajectory holds 2 frames"));
  assert_int_equal(hb_reader_field(reader, "twist", -1, values, &err), HB_ERR_INPUT);
  assert_int_equal(hb_reader_series(reader, "momentum", values, &err), HB_ERR_INPUT);
  assert_non_null(strstr(err.text, "there is no series \"momentum\""));
  hb_reader_close(reader);
  hb_reader_close(NULL);
}

/* The host program's own HDF5 error printing stays as it was. */
static void test_quiet(void **state) {
  (void)state;
  H5E_auto2_t before = NULL, after = NULL;
  void *data = NULL;
  hb_reader *reader = NULL;
  H5Eget_auto2(H5E_DEFAULT, &before, &data);
  assert_int_equal(hb_reader_open(in_directory("none.h5"), &reader, NULL), HB_ERR_INPUT);
  write_bytes("\x89HDF\r\n\x1a\nrest", 12);
  assert_int_equal(hb_reader_open(in_directory("bad.h5"), &reader, NULL), HB_ERR_INPUT);
  H5Eget_auto2(H5E_DEFAULT, &after, &data);
  assert_true(before == after);
}

/* The child of the kill test: adds frames for ever, telling after each one how many are promised. */
static void write_for_ever(const handmade *h, volatile long *promised) {
  enum { PLAN = 100000 };
  hb_writer *writer = NULL;
  hb_frame *frame = NULL;
  hb_error err;
  if (hb_writer_create(in_directory("killed.h5"), &h->model, PLAN, &writer, &err) != HB_OK) _exit(1);
  if (hb_frame_create(&h->model, &frame, &err) != HB_OK) _exit(1);
  for (long n = 0; n < PLAN; n++) {
    handmade_frame(frame, n);
    if (hb_writer_add(writer, frame, &err) != HB_OK) _exit(1);
    *promised = n + 1;
  }
  for (;;) pause();
}

/* SIGKILL at 50 moments, from inside the first frames to a few hundred frames: every promised frame is there
 * and whole, at most one more is. */
static void test_killed(void **state) {
  (void)state;
  handmade h;
  handmade_fill(&h);
  int shared = open(in_directory("promised"), O_RDWR | O_CREAT, 0600);
  assert_true(shared >= 0 && ftruncate(shared, sizeof(long)) == 0);
  volatile long *promised = mmap(NULL, sizeof *promised, PROT_READ | PROT_WRITE, MAP_SHARED, shared, 0);
  assert_true(promised != MAP_FAILED);
  unsigned seed = 12345;
  long most = 0;
  for (int round = 0; round < 50; round++) {
    *promised = 0;
    pid_t child = fork();
    if (child == 0) write_for_ever(&h, promised);
    while (*promised < 1) {
      int status = 0;
      if (waitpid(child, &status, WNOHANG) != 0) fail_msg("the writing child ended by itself");
    }
    seed = seed * 1103515245u + 12345u;
    struct timespec wait = {0, (long)(seed >> 8) % 20000000L};
    nanosleep(&wait, NULL);
    kill(child, SIGKILL);
    int status = 0;
    assert_int_equal(waitpid(child, &status, 0), child);
    assert_true(WIFSIGNALED(status));
    long frames = check_file(in_directory("killed.h5"));
    assert_true(frames >= *promised && frames <= *promised + 1);
    if (frames > most) most = frames;
    hb_writer *writer = NULL;
    hb_error err;
    if (hb_writer_continue(in_directory("killed.h5"), &h.model, 100000, frames / 2, &writer, &err) != HB_OK)
      fail_msg("%s", err.text);
    add(writer, &h, frames / 2, frames / 2 + 3);
    assert_int_equal(hb_writer_close(writer, &err), HB_OK);
    assert_int_equal(check_file(in_directory("killed.h5")), frames / 2 + 3);
  }
  assert_true(most > 10);
  munmap((void *)promised, sizeof *promised);
  close(shared);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_round_trip),    cmocka_unit_test(test_readable_while_written),
      cmocka_unit_test(test_holes),         cmocka_unit_test(test_vtk_layout),
      cmocka_unit_test(test_continue),      cmocka_unit_test(test_continue_refused),
      cmocka_unit_test(test_writer_errors), cmocka_unit_test(test_reader_errors),
      cmocka_unit_test(test_truncated),     cmocka_unit_test(test_damaged),
      cmocka_unit_test(test_added_object),  cmocka_unit_test(test_wrong_requests),
      cmocka_unit_test(test_run_number),    cmocka_unit_test(test_full_while_created),
      cmocka_unit_test(test_quiet),         cmocka_unit_test(test_full_while_added),
      cmocka_unit_test(test_killed)};
  return cmocka_run_group_tests(tests, set_up, tear_down);
}
