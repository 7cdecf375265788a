/* Fuzzing of the scene reader: YAML, overrides, sections and the rules of the model. Lines that begin with
 * "#--set " are comments of YAML and overrides for this target. A scene that is accepted must give the same
 * rods again from the text that the definition keeps. */
#include "hebra/hebra.h"
#include "scene/read.h"

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { OVERRIDES = 8, OVERRIDE_LENGTH = 200, LARGEST = 65536 };

/* Small enough that no input takes long. */
static const hb_scene_limits small = {
    .bytes = LARGEST, .nodes = 20000, .alias_nodes = 2000, .depth = 32, .vertices = 2000};

/* Copies the overrides out of the comments. */
static int find_overrides(const char *text, char overrides[OVERRIDES][OVERRIDE_LENGTH]) {
  int count = 0;
  const char *at = text;
  while (count < OVERRIDES && (at = strstr(at, "\n#--set "))) {
    at += strlen("\n#--set ");
    size_t n = strcspn(at, "\n");
    if (n < OVERRIDE_LENGTH) {
      memcpy(overrides[count], at, n);
      overrides[count++][n] = 0;
    }
  }
  return count;
}

/* Ends the program with a message that the fuzzer reports. */
static void broken(const char *what, const char *detail) {
  fprintf(stderr, "%s: %s\n", what, detail);
  abort();
}

/* Reads the kept text again and compares the rods. */
static void read_again(const hb_scene_def *def) {
  hb_scene_def again;
  hb_error err;
  hb_scene_reader settings = {.name = "again", .base_dir = ".", .limits = small, .def = &again, .err = &err};
  settings.limits.bytes = (size_t)8 * LARGEST;
  settings.limits.nodes = 40000;
  if (hb_scene_parse_limited(def->source, strlen(def->source), &settings, NULL, 0))
    broken("kept text", err.text);
  if (again.rod_count != def->rod_count || again.force_count != def->force_count)
    broken("kept text", "other counts");
  for (int r = 0; r < def->rod_count; r++) {
    const hb_rod_def *a = &def->rods[r], *b = &again.rods[r];
    if (a->nv != b->nv || strcmp(a->name, b->name) || a->support_count != b->support_count)
      broken("kept text", "other rod");
    size_t size = 3 * (size_t)a->nv * sizeof(double);
    if (memcmp(a->rest, b->rest, size) || memcmp(a->initial, b->initial, size))
      broken("kept text", "other shape");
  }
  hb_scene_def_free(&again);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

/* One input: read, compile, read again from the kept text. */
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  char overrides[OVERRIDES][OVERRIDE_LENGTH];
  const char *list[OVERRIDES];
  if (size > LARGEST) return 0;
  char *text = malloc(size + 1);
  if (!text) return 0;
  memcpy(text, data, size);
  text[size] = 0;
  if (strstr(text, "file")) { /* no files of the machine */
    free(text);
    return 0;
  }
  int count = find_overrides(text, overrides);
  for (int k = 0; k < count; k++) list[k] = overrides[k];
  hb_scene_def def;
  hb_error err = {.status = HB_OK};
  hb_scene_reader settings = {.name = "input", .base_dir = ".", .limits = small, .def = &def, .err = &err};
  hb_status status = hb_scene_parse_limited(text, size, &settings, list, count);
  if (status == HB_OK) {
    hb_model *model = NULL;
    read_again(&def);
    hb_status compiled = hb_model_create(&def, &model, &err);
    if (compiled && !err.text[0]) broken("model", "no sentence");
    hb_model_free(model);
    hb_scene_def_free(&def);
  } else if (!err.text[0])
    broken("scene", "no sentence");
  free(text);
  return 0;
}
