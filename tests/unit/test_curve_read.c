/* Curve files: what the readers take, and the sentence with its place for what they do not. */
#include "hebra/curve.h"
#include "support/near.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Path of a file in the test's own directory. */
static void place(const char *name, char path[512]) {
  const char *scratch = getenv("HEBRA_SCRATCH");
  snprintf(path, 512, "%s/%s", scratch ? scratch : ".", name);
}

/* Writes text to a file of that name and reads it as a curve. */
static hb_status read_text(const char *name, const char *text, size_t length, double **xyz, int *count,
                           hb_error *err) {
  char path[512];
  place(name, path);
  FILE *file = fopen(path, "wb");
  if (!file) fail_msg("cannot write %s", path);
  assert_int_equal(fwrite(text, 1, length, file), length);
  assert_int_equal(fclose(file), 0);
  hb_status status = hb_curve_read(path, xyz, count, err);
  remove(path);
  return status;
}

/* The file holds exactly these vertices. */
static void gives(const char *name, const char *text, int count, const double *known) {
  double *xyz = NULL;
  int found = 0;
  hb_error err = {HB_OK, ""};
  if (read_text(name, text, strlen(text), &xyz, &found, &err) != HB_OK) fail_msg("%s: %s", text, err.text);
  assert_int_equal(found, count);
  assert_near_array(xyz, known, 3 * count, 0.0);
  hb_curve_free(xyz);
}

/* Reading fails with path + sentence. */
static void refused(const char *name, const char *text, const char *sentence) {
  double *xyz = NULL;
  int found = 7;
  char path[512], whole[1024];
  hb_error err = {HB_OK, ""};
  hb_status status = read_text(name, text, strlen(text), &xyz, &found, &err);
  place(name, path);
  snprintf(whole, sizeof whole, "%s:%s", path, sentence);
  assert_string_equal(err.text, whole);
  assert_int_equal(status, HB_ERR_INPUT);
  assert_null(xyz);
  assert_int_equal(found, 0);
}

static const double three[] = {0, 0, 0, 1, -0.5, 0.25, 2, 0, 1e-3};

/* Separators, ends of line, header, comments, quotes, byte order mark. */
static void test_csv(void **state) {
  (void)state;
  gives("a.csv", "0,0,0\n1,-0.5,0.25\n2,0,1e-3\n", 3, three);
  gives("a.csv", "0,0,0\n1,-0.5,0.25\n2,0,1e-3", 3, three);
  gives("a.csv", "x,y,z\r\n0,0,0\r\n1,-.5,.25\r\n2,0,1E-3\r\n", 3, three);
  gives("a.csv", "0;0;0\r1;-0.5;0.25\r2;+0.;0.001\r", 3, three);
  gives("a.txt", "# places\n\n  0 0 0\n\t1\t-0.5   0.25  # the middle\n \n2 0 .001\n#end", 3, three);
  gives("a.csv", "\xEF\xBB\xBF\"x\" , \"y\" , \"z\"\n 0 , 0 , 0 \n\"1\", \"-0.5\" ,0.25\n2,0,1e-3\n", 3,
        three);
  gives("no_suffix", "x y z\n0 0 0\n1 -0.5 0.25\n2 0 1e-3\n\n\n", 3, three);
  static const double ring[] = {0, 0, 0, 1, 0, 0, 0, 0, 0};
  gives("a.csv", "0,0,0\n1,0,0\n0,0,0\n", 3, ring);
}

/* What a CSV file must not hold. */
static void test_csv_sentences(void **state) {
  (void)state;
  refused("b.csv", "", " the file has 0 vertices, at least 2 are needed");
  refused("b.csv", "x,y,z\n# nothing\n", " the file has 0 vertices, at least 2 are needed");
  refused("b.csv", "1,2,3\n", " the file has 1 vertex, at least 2 are needed");
  refused("b.csv", "0,0,0\n1,0\n", "2: 2 columns found, a vertex has three: x, y, z");
  refused("b.csv", "0,0,0\n\n7\n", "3: 1 column found, a vertex has three: x, y, z");
  refused("b.csv", "0,0,0\n1,0,0,5\n", "2: 4 columns found, a vertex has three: x, y, z");
  refused("b.csv", "0,0,0\r\n1,0,0,5,6\r\n", "2: 5 columns found, a vertex has three: x, y, z");
  refused("b.csv", "0,0,0\n1,zero,0\n", "2: column 2 is 'zero', allowed are finite decimal numbers");
  refused("b.csv", "0,0,0\nx,y,z\n", "2: column 1 is 'x', allowed are finite decimal numbers");
  refused("b.csv", "x,y,z\na,b,c\n", "2: column 1 is 'a', allowed are finite decimal numbers");
  refused("b.csv", "0,0,z\n", "1: column 3 is 'z', allowed are finite decimal numbers");
  refused("b.csv", "0,0,0\n1,nan,0\n", "2: column 2 is 'nan', allowed are finite decimal numbers");
  refused("b.csv", "0,0,0\n1,0,-inf\n", "2: column 3 is '-inf', allowed are finite decimal numbers");
  refused("b.csv", "0,0,0\n1,0,1e999\n", "2: column 3 is '1e999', allowed are finite decimal numbers");
  refused("b.csv", "0,0,0\n0x1,0,0\n", "2: column 1 is '0x1', allowed are finite decimal numbers");
  refused("b.csv", "0,0,0\n1,,2\n", "2: column 2 is empty, a number is needed");
  refused("b.csv", "0;0;0\n1,5;0;0\n", "2: column 1 is '1,5'; decimals are written with a point");
  refused("b.csv", "0,0,0\n\n1,2,3\n# here\n1,2,3\n",
          "5: the vertex (1, 2, 3) repeats the one before, allowed are different points");
}

/* A byte 0 is no number, wherever it stands. */
static void test_csv_binary(void **state) {
  (void)state;
  static const char bytes[] = "0,0,0\n1,0\0,0\n";
  double *xyz = NULL;
  int count = 0;
  hb_error err = {HB_OK, ""};
  assert_int_equal(read_text("c.csv", bytes, sizeof bytes - 1, &xyz, &count, &err), HB_ERR_INPUT);
  assert_non_null(strstr(err.text, "c.csv:2: column 2 is '0', allowed are finite decimal numbers"));
  assert_null(xyz);
}

/* Vertices alone, one polyline, several pieces in any order and sense, negative numbers, rings, what is
 * passed over. */
static void test_obj(void **state) {
  (void)state;
  static const double back[] = {2, 0, 1e-3, 1, -0.5, 0.25, 0, 0, 0};
  static const double ring[] = {0, 0, 0, 1, -0.5, 0.25, 2, 0, 1e-3, 0, 0, 0};
#define VERTICES "v 0 0 0\nv 1 -0.5 0.25 1.0\nv 2 0 1e-3 0.5 0.5 0.5\n"
  gives("a.obj", VERTICES, 3, three);
  gives("a.OBJ", VERTICES "l 3 2 1\n", 3, back);
  gives("a.obj",
        "# rod\no rod\n" VERTICES "vn 0 0 1\nvt 0 0\ng all\ns off\nusemtl x\nf 1 2 3\nl 1/1 2/1 3/1\n", 3,
        three);
  gives("a.obj", VERTICES "l -3 -2 -1\r\n", 3, three);
  gives("a.obj", VERTICES "l 1 2\nl 2 3\n", 3, three);
  gives("a.obj", VERTICES "l 3 2\nl 2 1\n", 3, back);
  gives("a.obj", VERTICES "l 2 1\nl 2 3\n", 3, three);
  gives("a.obj", VERTICES "l 2 3\nl 1 2\n", 3, back);
  gives("a.obj", VERTICES "l 1 2 3 1\n", 4, ring);
  gives("a.obj", VERTICES "l 1 2\nl 3 1\nl 2 3\n", 4, ring);
  gives("a.obj", VERTICES "l 1 \\\n 2 \\\r\n3 # end\n", 3, three);
  gives("a.obj", VERTICES "l 1 2 3 \\", 3, three);
  gives("a.obj", "v 9 9 9\nv 0 0 0\nv 5 5 5\nv 1 -.5 .25\nl 2 4\nv 2 0 .001\nl 4 -1\n", 3, three);
  static const double twice[] = {0, 0, 0, 1, -0.5, 0.25, 2, 0, 1e-3, 0, 0, 0, 1, -0.5, 0.25};
  gives("a.obj", VERTICES "l 1 2 3 1 2\n", 5, twice);
}

/* What an OBJ file must not hold. */
static void test_obj_sentences(void **state) {
  (void)state;
  refused("b.obj", "v 0 0\n", "1: a vertex has three numbers, found 2");
  refused("b.obj", "\nv\n", "2: a vertex has three numbers, found 0");
  refused("b.obj", "v 0 0 0\nv 1 nan 0\n",
          "2: coordinate 2 of the vertex is 'nan', allowed are finite decimal numbers");
  refused("b.obj", "v 0 0 0\nv 1 0 1,5\n",
          "2: coordinate 3 of the vertex is '1,5', allowed are finite decimal numbers");
  refused("b.obj", VERTICES "l 1\n", "4: a line joins at least 2 vertices, found 1");
  refused("b.obj", VERTICES "l\n", "4: a line joins at least 2 vertices, found 0");
  refused("b.obj", VERTICES "l 1 4\n", "4: '4' is no vertex; allowed are 1 to 3, or -1 to -3 from the end");
  refused("b.obj", VERTICES "l 0 1\n", "4: '0' is no vertex; allowed are 1 to 3, or -1 to -3 from the end");
  refused("b.obj", VERTICES "l 1 -4\n", "4: '-4' is no vertex; allowed are 1 to 3, or -1 to -3 from the end");
  refused("b.obj", VERTICES "l 1 two\n",
          "4: 'two' is no vertex; allowed are 1 to 3, or -1 to -3 from the end");
  refused("b.obj", VERTICES "l 1 -\n", "4: '-' is no vertex; allowed are 1 to 3, or -1 to -3 from the end");
  refused("b.obj", VERTICES "l 1 /2\n", "4: '/2' is no vertex; allowed are 1 to 3, or -1 to -3 from the end");
  refused("b.obj", VERTICES "l 1 99999999999999999999\n",
          "4: '99999999999999999999' is no vertex; allowed are 1 to 3, or -1 to -3 from the end");
  refused("b.obj", VERTICES "l 1 2 2\n", "4: vertex 2 follows itself in a line");
  refused("b.obj", VERTICES "v 3 0 0\nl 1 2\nl 2 3\nl 4 2\n",
          "7: vertex 2 joins more than two pieces, a curve has no branches");
  refused("b.obj", VERTICES "v 3 0 0\nl 1 2\nl 3 4\n",
          " the lines are not one curve: from vertex 1 only 1 of 2 pieces can be reached");
  refused("b.obj", VERTICES "v 3 0 0\nv 4 0 0\nl 1 2\nl 3 4\nl 4 5\nl 5 3\n",
          " the lines are not one curve: from vertex 1 only 1 of 4 pieces can be reached");
  refused("b.obj", "v 0 0 0\nv 0 0 0\nl 1 2\n", " vertices 1 and 2 of the curve coincide at (0, 0, 0)");
  refused("b.obj", "o nothing\n", " the file has 0 vertices, at least 2 are needed");
}

/* No file, and a directory. */
static void test_no_file(void **state) {
  (void)state;
  double *xyz = NULL;
  int count = 0;
  char path[512], whole[1024];
  hb_error err = {HB_OK, ""};
  place("not_there.csv", path);
  snprintf(whole, sizeof whole, "%s: cannot be opened: No such file or directory", path);
  assert_int_equal(hb_curve_read(path, &xyz, &count, &err), HB_ERR_IO);
  assert_string_equal(err.text, whole);
  assert_null(xyz);
  place(".", path);
  assert_int_equal(hb_curve_read(path, &xyz, &count, &err), HB_ERR_IO);
  assert_non_null(strstr(err.text, ": cannot be read: Is a directory"));
  assert_null(xyz);
}

/* A hundred thousand vertices from a file, each where it belongs. */
static void test_large(void **state) {
  (void)state;
  enum { COUNT = 100000 };
  char *text = malloc((size_t)COUNT * 40);
  double *xyz = NULL;
  int count = 0;
  hb_error err = {HB_OK, ""};
  assert_non_null(text);
  size_t n = 0;
  for (int i = 0; i < COUNT; i++) n += (size_t)sprintf(text + n, "%d,%.17g,%d\n", i, i / 7.0, -i);
  assert_int_equal(read_text("large.csv", text, n, &xyz, &count, &err), HB_OK);
  assert_int_equal(count, COUNT);
  for (int i = 0; i < COUNT; i++) {
    assert_same(xyz[3 * i], i);
    assert_same(xyz[3 * i + 1], i / 7.0);
    assert_same(xyz[3 * i + 2], -i);
  }
  hb_curve_free(xyz);
  free(text);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_csv),   cmocka_unit_test(test_csv_sentences), cmocka_unit_test(test_csv_binary),
      cmocka_unit_test(test_obj),   cmocka_unit_test(test_obj_sentences), cmocka_unit_test(test_no_file),
      cmocka_unit_test(test_large),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
