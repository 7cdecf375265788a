/* What the live view stands on: pictures as characters, and programs at the end of a pipe. */
#include "support/near.h"

/* The command line is not a library: its files are compiled into this test. */
#include "cli/dots.c"
#include "cli/pipe.c"

/* A black picture of columns x rows cells with some pixels set. */
static hb_image cells(int columns, int rows) {
  hb_image image;
  const unsigned char black[3] = {0, 0, 0};
  assert_int_equal(hb_image_create(columns * CLI_DOTS_ACROSS, rows * CLI_DOTS_DOWN, &image, NULL), HB_OK);
  hb_image_fill(&image, black);
  return image;
}

/* Sets a pixel. */
static void set(hb_image *image, int x, int y, unsigned char r, unsigned char g, unsigned char b) {
  unsigned char *p = image->rgb + 3 * (y * image->width + x);
  p[0] = r;
  p[1] = g;
  p[2] = b;
}

/* Every dot has its bit in the braille block, U+2800 and on. */
static void test_braille(void **state) {
  (void)state;
  const char *const expected[4][2] = {{"\xe2\xa0\x81", "\xe2\xa0\x88"},
                                      {"\xe2\xa0\x82", "\xe2\xa0\x90"},
                                      {"\xe2\xa0\x84", "\xe2\xa0\xa0"},
                                      {"\xe2\xa1\x80", "\xe2\xa2\x80"}};
  const cli_dots plain = {.utf8 = true, .colors = 0};
  for (int y = 0; y < 4; y++)
    for (int x = 0; x < 2; x++) {
      hb_image image = cells(3, 2);
      char text[4 * CLI_DOTS_CELL] = "";
      set(&image, 2 + x, 4 + y, 200, 200, 200);
      assert_int_equal(cli_dots_row(plain, &image, 0, text), 3);
      assert_string_equal(text, "   ");
      assert_int_equal(cli_dots_row(plain, &image, 1, text), 5);
      assert_memory_equal(text, " ", 1);
      assert_memory_equal(text + 1, expected[y][x], 3);
      assert_string_equal(text + 4, " ");
      hb_image_free(&image);
    }
}

/* Colours are written where they change and reset at the end; dark ones are lifted. */
static void test_colors(void **state) {
  (void)state;
  hb_image image = cells(3, 1);
  char text[4 * CLI_DOTS_CELL];
  set(&image, 0, 0, 200, 100, 0);
  set(&image, 2, 0, 200, 100, 0);
  set(&image, 4, 0, 50, 75, 25);
  cli_dots_row((cli_dots){.utf8 = true, .colors = 1 << 24}, &image, 0, text);
  assert_string_equal(text,
                      "\033[38;2;200;100;0m\xe2\xa0\x81\xe2\xa0\x81\033[38;2;100;150;50m\xe2\xa0\x81\033[0m");
  cli_dots_row((cli_dots){.utf8 = true, .colors = 256}, &image, 0, text);
  assert_string_equal(text, "\033[38;5;172m\xe2\xa0\x81\xe2\xa0\x81\033[38;5;107m\xe2\xa0\x81\033[0m");
  hb_image_free(&image);
}

/* Without UTF-8 the density of a cell becomes a character. */
static void test_ascii(void **state) {
  (void)state;
  hb_image image = cells(3, 1);
  char text[4 * CLI_DOTS_CELL];
  set(&image, 2, 0, 255, 255, 255);
  for (int k = 0; k < 8; k++) set(&image, 4 + k % 2, k / 2, 255, 255, 255);
  cli_dots_row((cli_dots){.utf8 = false, .colors = 0}, &image, 0, text);
  assert_string_equal(text, " :@");
  hb_image_free(&image);
}

/* The longest text fits into the room that the header names. */
static void test_room(void **state) {
  (void)state;
  enum { COLUMNS_OF_CELLS = 50 };
  hb_image image = cells(COLUMNS_OF_CELLS, 1);
  for (int x = 0; x < image.width; x++)
    set(&image, x, 0, (unsigned char)(155 + x), 155, (unsigned char)(255 - x));
  char text[CLI_DOTS_CELL * (COLUMNS_OF_CELLS + 1)];
  size_t length = cli_dots_row((cli_dots){.utf8 = true, .colors = 1 << 24}, &image, 0, text);
  assert_true(length < sizeof text);
  assert_true(length > COLUMNS_OF_CELLS * 20);
  hb_image_free(&image);
}

/* The environment decides. */
static void test_terminal(void **state) {
  (void)state;
  const char *const names_of[] = {"LC_ALL", "LC_CTYPE", "LANG", "COLORTERM", "NO_COLOR", "TERM"};
  for (int k = 0; k < 6; k++) unsetenv(names_of[k]);
  assert_false(cli_dots_of_terminal().utf8);
  assert_int_equal(cli_dots_of_terminal().colors, 256);
  setenv("LANG", "es_ES.UTF-8", 1);
  setenv("COLORTERM", "truecolor", 1);
  assert_true(cli_dots_of_terminal().utf8);
  assert_int_equal(cli_dots_of_terminal().colors, 1 << 24);
  setenv("LC_ALL", "C", 1); /* stronger than LANG */
  setenv("NO_COLOR", "1", 1);
  assert_false(cli_dots_of_terminal().utf8);
  assert_int_equal(cli_dots_of_terminal().colors, 0);
}

/* A file for answers. */
static void scratch_path(char *path, size_t size) {
  const char *scratch = getenv("HEBRA_SCRATCH");
  snprintf(path, size, "%s/answer.txt", scratch ? scratch : ".");
}

/* What goes in comes out at the other end. */
static void test_pipe_carries(void **state) {
  (void)state;
  char path[512], *block = calloc(1, 300000), *back = calloc(1, 300001);
  scratch_path(path, sizeof path);
  for (int i = 0; i < 300000; i++) block[i] = (char)(i * 7 % 251);
  const char *const argv[] = {"cat", NULL};
  cli_pipe p;
  hb_error err = {HB_OK, ""};
  assert_int_equal(cli_pipe_open(&p, argv, "coreutils", path, &err), HB_OK);
  assert_int_equal(cli_pipe_write(&p, block, 300000, &err), HB_OK);
  assert_int_equal(cli_pipe_close(&p, &err), HB_OK);
  FILE *file = fopen(path, "rb");
  assert_non_null(file);
  assert_int_equal(fread(back, 1, 300001, file), 300000);
  fclose(file);
  assert_memory_equal(block, back, 300000);
  remove(path);
  free(block);
  free(back);
}

/* A program that is not there is named with its package. */
static void test_pipe_missing(void **state) {
  (void)state;
  const char *const argv[] = {"hebra-no-such-program", NULL};
  cli_pipe p;
  hb_error err = {HB_OK, ""};
  assert_int_equal(cli_pipe_open(&p, argv, "some-package", NULL, &err), HB_ERR_MISSING);
  assert_string_equal(err.text, "the program hebra-no-such-program is not installed; on Debian and Ubuntu: "
                                "apt-get install some-package");
}

/* A program that fails is quoted; one that stops reading does not end us. */
static void test_pipe_fails(void **state) {
  (void)state;
  const char *const failing[] = {"sh", "-c", "echo no good >&2; exit 3", NULL};
  const char *const deaf[] = {"sh", "-c", "exec 0<&-; echo had enough >&2; exit 0", NULL};
  const char *const killed[] = {"sh", "-c", "kill -9 $$", NULL};
  static char block[1 << 20];
  cli_pipe p;
  hb_error err = {HB_OK, ""};
  assert_int_equal(cli_pipe_open(&p, failing, "dash", NULL, &err), HB_OK);
  assert_int_equal(cli_pipe_close(&p, &err), HB_ERR_IO);
  assert_string_equal(err.text, "sh failed with status 3: no good");
  assert_int_equal(cli_pipe_open(&p, deaf, "dash", NULL, &err), HB_OK);
  assert_int_equal(cli_pipe_write(&p, block, sizeof block, &err), HB_ERR_IO);
  assert_memory_equal(err.text, "sh stopped reading", 18);
  assert_int_equal(cli_pipe_close(&p, NULL), HB_OK);
  assert_int_equal(cli_pipe_close(&p, &err), HB_OK); /* twice is once */
  assert_int_equal(cli_pipe_open(&p, killed, "dash", NULL, &err), HB_OK);
  assert_int_equal(cli_pipe_close(&p, &err), HB_ERR_IO);
  assert_string_equal(err.text, "sh was ended by signal 9");
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_braille),      cmocka_unit_test(test_colors),
                                     cmocka_unit_test(test_ascii),        cmocka_unit_test(test_room),
                                     cmocka_unit_test(test_terminal),     cmocka_unit_test(test_pipe_carries),
                                     cmocka_unit_test(test_pipe_missing), cmocka_unit_test(test_pipe_fails)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
