/* The corpus of broken scenes: each must be refused with exactly the sentence that stands beside it.
 * NAME.yaml is the scene, NAME.expected the sentence, NAME.set (if any) one override per line. */
#include "base/memory.h"
#include "hebra/scene.h"
#include "support/near.h"

#include <dirent.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

enum { LINES = 4, LINE = 1200 };

/* Reads up to LINES lines of a file without their line ends; 0 if it is not there. */
static int read_lines(const char *name, const char *ending, char lines[LINES][LINE]) {
  char path[300];
  int count = 0;
  snprintf(path, sizeof path, "%s.%s", name, ending);
  FILE *file = fopen(path, "r");
  while (file && count < LINES && fgets(lines[count], LINE, file)) {
    lines[count][strcspn(lines[count], "\n")] = 0;
    count++;
  }
  if (file) fclose(file);
  return count;
}

/* Reads and compiles one scene; counts a mistake if the sentence differs. */
static int try_scene(const char *name) {
  char path[300], expected[LINES][LINE], overrides[LINES][LINE];
  const char *list[LINES];
  hb_scene_def def;
  hb_model *model = NULL;
  hb_error err = {.status = HB_OK};
  snprintf(path, sizeof path, "%s.yaml", name);
  int lines = read_lines(name, "expected", expected), count = read_lines(name, "set", overrides);
  for (int k = 0; k < count; k++) list[k] = overrides[k];
  hb_status status = hb_scene_read(path, list, count, &def, &err);
  if (!status) {
    status = hb_model_create(&def, &model, &err);
    hb_model_free(model);
    hb_scene_def_free(&def);
  }
  if (lines == 1 && status == HB_ERR_INPUT && strcmp(err.text, expected[0]) == 0) return 0;
  print_error("%s: status %d\n  found    %s\n  expected %s\n", name, (int)status, err.text,
              lines == 1 ? expected[0] : "(one line in the .expected file)");
  return 1;
}

/* All scenes of the directory. */
static void every_broken_scene_gets_its_sentence(void **state) {
  (void)state;
  int scenes = 0, mistakes = 0;
  assert_int_equal(chdir(HEBRA_SOURCE_DIR "/tests/broken"), 0);
  DIR *directory = opendir(".");
  assert_non_null(directory);
  for (struct dirent *entry; (entry = readdir(directory));) {
    char name[256];
    snprintf(name, sizeof name, "%s", entry->d_name);
    char *dot = strrchr(name, '.');
    if (!dot || strcmp(dot, ".yaml") != 0) continue;
    *dot = 0;
    scenes++;
    mistakes += try_scene(name);
  }
  closedir(directory);
  assert_int_equal(mistakes, 0);
  assert_true(scenes >= 110);
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(every_broken_scene_gets_its_sentence)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
