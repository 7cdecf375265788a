/* Exports and the report: the files hold the numbers of the trajectory, in the form their readers expect. */
#include "support/near.h"

#include "support/handmade.h"
#include "support/smallsim.h"

#include "output/json.h"
#include "output/report.h"

#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <unistd.h>

static char directory[256];

/* Path of a file in the test's directory; valid until the next call but two. */
static const char *in_directory(const char *name) {
  static char paths[3][320];
  static int turn;
  turn = (turn + 1) % 3;
  snprintf(paths[turn], sizeof paths[turn], "%s/%s", directory, name);
  return paths[turn];
}

/* Makes the directory. */
static int set_up(void **state) {
  (void)state;
  const char *scratch = getenv("HEBRA_SCRATCH");
  snprintf(directory, sizeof directory, "%s/export-XXXXXX", scratch ? scratch : ".");
  return mkdtemp(directory) ? 0 : -1;
}

/* Removes a directory of files; counts those left under a temporary name. */
static int remove_directory(const char *path) {
  int strays = 0;
  DIR *listing = opendir(path);
  if (!listing) return 0;
  for (struct dirent *entry = readdir(listing); entry; entry = readdir(listing)) {
    char file[1024];
    snprintf(file, sizeof file, "%s/%s", path, entry->d_name);
    strays += strstr(entry->d_name, ".new-") != NULL;
    unlink(file);
  }
  closedir(listing);
  return rmdir(path) == 0 ? strays : -1;
}

/* Removes everything. */
static int tear_down(void **state) {
  (void)state;
  int strays = remove_directory(in_directory("deep/tables"));
  strays += remove_directory(in_directory("deep"));
  strays += remove_directory(in_directory("vtk"));
  return remove_directory(directory) + strays;
}

/* Whole file as terminated text, to be freed; fails the test if it is not there. */
static char *slurp(const char *path, size_t *size) {
  FILE *file = fopen(path, "rb");
  if (!file) fail_msg("%s is missing", path);
  char *text = calloc(1, 1 << 20);
  assert_non_null(text);
  size_t got = fread(text, 1, (1 << 20) - 1, file);
  fclose(file);
  if (size) *size = got;
  return text;
}

/* A reader of a trajectory of 5 frames of the handmade model. */
static hb_reader *open_handmade(void) {
  handmade h;
  hb_writer *writer = NULL;
  hb_reader *reader = NULL;
  hb_frame *frame = NULL;
  hb_error err = {0};
  handmade_fill(&h);
  if (hb_writer_create(in_directory("t.h5"), &h.model, 6, &writer, &err) != HB_OK) fail_msg("%s", err.text);
  assert_int_equal(hb_frame_create(&h.model, &frame, &err), HB_OK);
  for (long n = 0; n < 5; n++) {
    handmade_frame(frame, n);
    assert_int_equal(hb_writer_add(writer, frame, &err), HB_OK);
  }
  hb_frame_free(frame);
  assert_int_equal(hb_writer_close(writer, &err), HB_OK);
  if (hb_reader_open(in_directory("t.h5"), &reader, &err) != HB_OK) fail_msg("%s", err.text);
  return reader;
}

/* Cell `column` of line `line` (0 is the header) as text in buffer. */
static const char *csv_cell(const char *text, int line, int column, char buffer[128]) {
  for (; line > 0; line--) {
    text = strchr(text, '\n');
    assert_non_null(text);
    text++;
  }
  for (; column > 0; column--) {
    text += strcspn(text, ",\n");
    assert_int_equal(*text, ',');
    text++;
  }
  size_t length = strcspn(text, ",\n");
  assert_true(length < 128);
  memcpy(buffer, text, length);
  buffer[length] = 0;
  return buffer;
}

/* Number of lines. */
static int count_lines(const char *text) {
  int lines = 0;
  for (; *text; text++) lines += *text == '\n';
  return lines;
}

/* Tables: headers with units, bits of the numbers, empty cells where there is no edge. */
static void test_csv(void **state) {
  (void)state;
  hb_reader *reader = open_handmade();
  hb_error err = {0};
  char buffer[128];
  if (hb_export(reader, "csv", in_directory("deep/tables"), 1, 4, 2, &err) != HB_OK) fail_msg("%s", err.text);
  hb_reader_close(reader);

  char *text = slurp(in_directory("deep/tables/scalars.csv"), NULL);
  assert_int_equal(count_lines(text), 3);
  assert_string_equal(csv_cell(text, 0, 1, buffer), "time [time]");
  assert_string_equal(csv_cell(text, 0, 11, buffer), "momentum_x [mass*length/time]");
  assert_string_equal(csv_cell(text, 1, 0, buffer), "1");
  assert_string_equal(csv_cell(text, 2, 0, buffer), "3");
  assert_string_equal(csv_cell(text, 2, 2, buffer), "30");
  assert_same(strtod(csv_cell(text, 2, 4, buffer), NULL), 3 + 0.2);
  free(text);

  text = slurp(in_directory("deep/tables/rod-1-upper_rod.csv"), NULL);
  assert_int_equal(count_lines(text), 1 + 2 * 4);
  int column = 3;
  for (int k = 0; k < hb_frame_field_count; k++)
    for (int j = 0; j < hb_frame_fields[k].components; j++, column++)
      for (int line = 1; line <= 8; line++) {
        int slot = 5 + (line - 1) % 4;
        long frame = line <= 4 ? 1 : 3;
        csv_cell(text, line, column, buffer);
        if (hb_frame_fields[k].location == HB_ON_EDGE && slot == 8)
          assert_string_equal(buffer, "");
        else
          assert_same(strtod(buffer, NULL), handmade_number(k, slot, j, frame));
      }
  assert_string_equal(csv_cell(text, 0, 3, buffer), "position_x [length]");
  assert_string_equal(csv_cell(text, 0, column - 1, buffer), "energy_stretching [energy]");
  assert_string_equal(csv_cell(text, 8, 1, buffer), "0.75");
  assert_string_equal(csv_cell(text, 8, 2, buffer), "3");
  free(text);
}

/* Data of an appended array: the offset stands in its line of the header. */
static const double *appended(const char *text, size_t size, const char *name, uint64_t *bytes) {
  char wanted[96];
  snprintf(wanted, sizeof wanted, "Name=\"%s\"", name);
  const char *line = strstr(text, wanted), *data = strstr(text, "<AppendedData");
  assert_non_null(line);
  assert_non_null(data);
  data = strchr(data, '_') + 1;
  line = strstr(line, "offset=\"");
  size_t offset = strtoul(line + 8, NULL, 10);
  assert_true((size_t)(data - text) + offset + 8 <= size);
  memcpy(bytes, data + offset, 8);
  assert_true((size_t)(data - text) + offset + 8 + *bytes <= size);
  static double values[64];
  assert_true(*bytes <= sizeof values);
  memcpy(values, data + offset + 8, (size_t)*bytes);
  return values;
}

/* VTK files: list with times, polylines, raw numbers. */
static void test_vtp(void **state) {
  (void)state;
  hb_reader *reader = open_handmade();
  hb_error err = {0};
  if (hb_export(reader, "vtp", in_directory("vtk"), 0, 4, 3, &err) != HB_OK) fail_msg("%s", err.text);
  hb_reader_close(reader);
  char *text = slurp(in_directory("vtk/trajectory.pvd"), NULL);
  assert_non_null(strstr(text, "<DataSet timestep=\"0\" part=\"0\" file=\"trajectory_000000.vtp\"/>"));
  assert_non_null(strstr(text, "<DataSet timestep=\"0.75\" part=\"0\" file=\"trajectory_000003.vtp\"/>"));
  assert_null(strstr(text, "000001"));
  free(text);

  size_t size = 0;
  uint64_t bytes = 0;
  text = slurp(in_directory("vtk/trajectory_000003.vtp"), &size);
  assert_non_null(strstr(text, "NumberOfPoints=\"9\" NumberOfVerts=\"0\" NumberOfLines=\"2\""));
  const double *values = appended(text, size, "position", &bytes);
  assert_int_equal(bytes, 27 * 8);
  for (int i = 0; i < 27; i++) assert_same(values[i], handmade_number(0, i / 3, i % 3, 3));
  values = appended(text, size, "tension", &bytes);
  assert_int_equal(bytes, 9 * 8);
  int tension = 0;
  while (strcmp(hb_frame_fields[tension].name, "tension") != 0) tension++;
  for (int i = 0; i < 9; i++)
    assert_same(values[i], handmade_number(tension, handmade_no_edge(i) ? i - 1 : i, 0, 3));
  int64_t offsets[2];
  memcpy(offsets, appended(text, size, "offsets", &bytes), sizeof offsets);
  assert_int_equal(bytes, 16);
  assert_int_equal(offsets[0], 5);
  assert_int_equal(offsets[1], 9);
  assert_string_equal(text + size - 30, "\n  </AppendedData>\n</VTKFile>\n");
  free(text);
}

/* Requests that cannot be met. */
static void test_refused(void **state) {
  (void)state;
  hb_reader *reader = open_handmade();
  hb_error err = {0};
  static const struct { long first, last, stride; } wrong[] = {{0, 5, 1}, {-1, 3, 1}, {3, 2, 1}, {0, 4, 0}};
  assert_int_equal(hb_export(reader, "obj", in_directory("vtk"), 0, 4, 1, &err), HB_ERR_INPUT);
  assert_string_equal(err.text, "export: there is no format \"obj\", allowed are csv and vtp");
  for (size_t k = 0; k < sizeof wrong / sizeof wrong[0]; k++) {
    assert_int_equal(
        hb_export(reader, "csv", in_directory("vtk"), wrong[k].first, wrong[k].last, wrong[k].stride, &err),
        HB_ERR_INPUT);
    assert_non_null(strstr(err.text, "allowed are 0 to 4"));
  }
  assert_int_equal(hb_export(reader, "csv", in_directory("t.h5"), 0, 4, 1, &err), HB_ERR_IO);
  assert_non_null(strstr(err.text, "the directory cannot be made: Not a directory"));
  hb_reader_close(reader);
}

/* Short where short is exact, and always the same number again. */
static void test_numbers(void **state) {
  (void)state;
  static const struct {
    double value;
    const char *text;
  } cases[] = {{0, "0"},
               {-0.0, "-0"},
               {0.1, "0.1"},
               {1e300, "1e+300"},
               {1.0 / 3, "0.3333333333333333"},
               {0.1 + 0.2, "0.30000000000000004"},
               {HUGE_VAL, "inf"},
               {-HUGE_VAL, "-inf"}};
  char text[32];
  for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
    hb_number_text(cases[k].value, text);
    assert_string_equal(text, cases[k].text);
  }
  hb_number_text((double)NAN, text);
  assert_string_equal(text, "nan");
  uint64_t bits = 88172645463325252u;
  for (int k = 0; k < 20000; k++) {
    double value = 0;
    bits ^= bits << 13;
    bits ^= bits >> 7;
    bits ^= bits << 17;
    memcpy(&value, &bits, sizeof value);
    if (!isfinite(value)) continue;
    hb_number_text(value, text);
    assert_true(strtod(text, NULL) == value);
  }
}

/* Escapes, nesting, numbers that JSON does not know, and text that is no UTF-8. */
static void test_json(void **state) {
  (void)state;
  hb_json json;
  FILE *file = fopen(in_directory("a.json"), "wb");
  assert_non_null(file);
  static const double vector[] = {1, HUGE_VAL, 0.1};
  hb_json_begin(&json, file);
  hb_json_text(&json, "a\"\\\n\t\x01", "\xce\xb1 \xff \xe2\x82 \xed\xa0\x80 \xc0\x80 \xf0\x9f\x98\x80");
  hb_json_text(&json, "none", NULL);
  hb_json_number(&json, "nan", (double)NAN);
  hb_json_vector(&json, "v", vector, 3);
  hb_json_array(&json, "list");
  hb_json_integer(&json, NULL, -5);
  hb_json_bool(&json, NULL, true);
  hb_json_object(&json, NULL);
  hb_json_object_end(&json);
  hb_json_array_end(&json);
  hb_json_end(&json);
  assert_int_equal(fclose(file), 0);
  char *text = slurp(in_directory("a.json"), NULL);
  assert_string_equal(
      text, "{\n  \"a\\\"\\\\\\n\\t\\u0001\": \"\xce\xb1 \\ufffd \\ufffd\\ufffd \\ufffd\\ufffd\\ufffd "
            "\\ufffd\\ufffd \xf0\x9f\x98\x80\",\n  \"none\": null,\n  \"nan\": null,\n"
            "  \"v\": [1, null, 0.10000000000000001],\n  \"list\": [\n    -5,\n    true,\n    {}\n  ]\n}\n");
  free(text);
}

/* The number behind "key": after the place where `section` stands. */
static double report_number(const char *text, const char *section, const char *key) {
  char wanted[96];
  const char *at = strstr(text, section);
  snprintf(wanted, sizeof wanted, "\"%s\": ", key);
  if (at) at = strstr(at, wanted);
  if (!at) fail_msg("%s %s is missing", section, key);
  return strtod(at + strlen(wanted), NULL);
}

/* The report of a real run says what the frames say. */
static void test_report(void **state) {
  (void)state;
  smallsim s;
  hb_frame *start = NULL, *end = NULL;
  hb_error err = {0};
  if (!smallsim_make(&s, &err)) fail_msg("%s", err.text);
  hb_sim_time_stages(s.sim, 1);
  assert_int_equal(hb_frame_create(s.model, &start, &err), HB_OK);
  assert_int_equal(hb_frame_create(s.model, &end, &err), HB_OK);
  hb_sim_measure(s.sim, start);
  for (int k = 0; k < 30; k++)
    if (hb_sim_step(s.sim, &err) != HB_OK) fail_msg("%s", err.text);
  hb_sim_measure(s.sim, end);
  if (hb_report_write(in_directory("report.json"), s.sim, start, end,
                      &(hb_report_facts){.wall_seconds = 1.5, .peak_bytes = 12345, .stop_reason = "finished"},
                      &err) != HB_OK)
    fail_msg("%s", err.text);
  char *text = slurp(in_directory("report.json"), NULL);
  assert_int_equal(text[0], '{');
  assert_non_null(strstr(text, "\"title\": \"A small rod\""));
  assert_non_null(strstr(text, "\"integrator\": \"verlet\""));
  assert_non_null(strstr(text, "\"stopped\": \"finished\""));
  assert_non_null(strstr(text, "\"source\": \"title: A small rod\\n\""));
  assert_same(report_number(text, "{", "steps"), 30);
  assert_same(report_number(text, "{", "time"), end->time);
  assert_true(end->kinetic > 0);
  assert_same(report_number(text, "\"end\"", "kinetic"), end->kinetic);
  assert_same(report_number(text, "\"end\"", "bending"), end->bending);
  assert_same(report_number(text, "\"start\"", "kinetic"), start->kinetic);
  assert_same(report_number(text, "\"energy\"", "work_of_loads"), end->work_loads);
  assert_same(report_number(text, "\"energy\"", "balance"), end->balance);
  assert_same(report_number(text, "\"length_error\"", "worst"), end->worst_length_error);
  assert_near(report_number(text, "\"rods\"", "mass"), 0.6, 1e-15);
  double twist = 0;
  for (int i = 1; i < 5; i++) twist += end->twist[i];
  assert_same(report_number(text, "\"rods\"", "total_twist"), twist);
  assert_true(report_number(text, "\"iterations_per_step\"", "projection") > 0);
  assert_same(report_number(text, "\"memory_bytes\"", "process_peak"), 12345);
  for (int k = 0; k < HB_STAGE_COUNT; k++)
    assert_true(report_number(text, "\"seconds\"", hb_stage_names[k]) >= 0);
  assert_near_rel(report_number(text, "{", "ns_per_vertex_and_step"), 1.5e9 / (30 * 6), 1e-15);
  free(text);
  assert_int_equal(hb_report_write(in_directory("none/report.json"), s.sim, start, end,
                                   &(hb_report_facts){.wall_seconds = 1}, &err),
                   HB_ERR_IO);
  hb_frame_free(start);
  hb_frame_free(end);
  smallsim_free(&s);
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_csv),     cmocka_unit_test(test_vtp),
                                     cmocka_unit_test(test_refused), cmocka_unit_test(test_numbers),
                                     cmocka_unit_test(test_json),    cmocka_unit_test(test_report)};
  return cmocka_run_group_tests(tests, set_up, tear_down);
}
