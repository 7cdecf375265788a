/* Chosen fields: what is measured of them, handed over, written, read, and not there. */
#include "support/near.h"

#include "base/memory.h"
#include "hebra/hebra.h"

#include <float.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define STEPS 30

/* Rods of every kind: bundled, in pieces, general, one that steps outside of the lanes. */
static const char scene[] = "method: {time_step: 1e-4, duration: 0.01}\n"
                            "gravity: [0, 0, -9.81]\n"
                            "rods:\n"
                            "  - name: hair\n"
                            "    copies: 5\n"
                            "    rest: {line: {from: [0.1*k, 0, 0], to: [0.1*k, 0, 0.3], vertices: 12+k}}\n"
                            "    initial: {displace: [0.02*sin(9*s), 0, 0]}\n"
                            "    lengths: initial\n"
                            "    bending: 1e-3\n"
                            "    twisting: 1e-3\n"
                            "    linear_density: 0.1\n"
                            "    start: {clamp: true}\n"
                            "    end: {material_angle: 2 + t}\n"
                            "  - name: curl\n"
                            "    rest: {helix: {radius: 0.1, pitch: 0.1, turns: 2, vertices: 60}}\n"
                            "    bending: [1e-3, 2e-3]\n"
                            "    twisting: 1e-3\n"
                            "    linear_density: 0.1\n"
                            "    start: {clamp: true}\n"
                            "  - name: band\n"
                            "    rest: {line: {from: [3, 0, 0], to: [3, 0, 0.3], vertices: 14}}\n"
                            "    initial: {displace: [0.02*sin(9*s), 0, 0]}\n"
                            "    lengths: initial\n"
                            "    bending: 1e-3\n"
                            "    twisting: 1e-3\n"
                            "    stretching: 20\n"
                            "    inextensible: false\n"
                            "    linear_density: 0.1\n"
                            "    start: {clamp: true}\n"
                            "  - name: ring\n"
                            "    closed: true\n"
                            "    rest: {ring: {center: [4, 0, 0], radius: 0.1, vertices: 20}}\n"
                            "    bending: 1e-3\n"
                            "    twisting: 1e-3\n"
                            "    linear_density: 0.1\n"
                            "  - name: slow\n"
                            "    rest: {line: {from: [2, 0, 0], to: [2, 0, 0.3], vertices: 10}}\n"
                            "    initial: {displace: [0.02*sin(9*s), 0, 0]}\n"
                            "    lengths: initial\n"
                            "    bending: 1e-3\n"
                            "    twisting: 1e-3\n"
                            "    damping: {bending: 1e-6}\n"
                            "    linear_density: 0.1\n"
                            "    start: {position: fixed}\n";

/* Definition, model, simulation after some steps, and all of it measured. */
typedef struct world {
  hb_scene_def def;
  hb_model *model;
  hb_sim *sim;
  hb_frame *whole, *part;
} world;

/* Builds it and steps. */
static void make(world *w) {
  hb_error err = {HB_OK, ""};
  memset(w, 0, sizeof *w);
  if (hb_scene_parse(scene, strlen(scene), "scene", ".", NULL, 0, &w->def, &err) ||
      hb_model_create(&w->def, &w->model, &err) || hb_sim_create(w->model, &w->sim, &err) ||
      hb_frame_create(w->model, &w->whole, &err) || hb_frame_create(w->model, &w->part, &err) ||
      hb_sim_advance(w->sim, STEPS, &err))
    fail_msg("%s", err.text);
}

/* Frees it. */
static void drop(world *w) {
  hb_frame_free(w->whole);
  hb_frame_free(w->part);
  hb_sim_free(w->sim);
  hb_model_free(w->model);
  hb_scene_def_free(&w->def);
}

/* Numbers of a field. */
static double *numbers(const hb_frame *frame, int field) {
  double *values = NULL;
  memcpy(&values, (const char *)frame + hb_frame_fields[field].offset, sizeof values);
  return values;
}

/* How many. */
static size_t count_of(const world *w, int field) {
  return (size_t)w->model->nv * (size_t)hb_frame_fields[field].components;
}

/* The scalars of both frames have the same bits. */
static void assert_same_scalars(const hb_frame *a, const hb_frame *b) {
  size_t from = offsetof(hb_frame, time), to = offsetof(hb_frame, position);
  assert_memory_equal((const char *)a + from, (const char *)b + from, to - from);
}

/* Names mean one thing each, and every field is in `all`. */
static void groups(void **state) {
  (void)state;
  assert_int_equal(hb_frame_field_count, HB_FIELD_COUNT);
  assert_string_equal(hb_field_groups[0].name, "all");
  assert_string_equal(hb_field_groups[1].name, "standard");
  assert_true(hb_field_groups[0].fields == HB_FIELDS_ALL);
  uint64_t sum = 0;
  for (int g = 0; g < hb_field_group_count; g++) {
    assert_true((hb_field_groups[g].fields & ~HB_FIELDS_ALL) == 0);
    if (g > 1) sum |= hb_field_groups[g].fields;
    for (int k = 0; k < hb_frame_field_count; k++)
      assert_string_not_equal(hb_field_groups[g].name, hb_frame_fields[k].name);
  }
  assert_true(sum == HB_FIELDS_ALL); /* every field is in some group of its own kind */
}

/* Each field alone: its numbers and all scalars have the bits that they have among all fields. Measured from
 * a snapshot in which everything that was not handed over is not a number. */
static void one_by_one(void **state) {
  (void)state;
  world w;
  hb_error err = {HB_OK, ""};
  hb_measure *measure = NULL;
  hb_state *copy = NULL;
  make(&w);
  assert_int_equal(hb_measure_create(w.model, &measure, &err), HB_OK);
  assert_int_equal(hb_state_create(w.model, &copy, &err), HB_OK);
  for (int field = 0; field <= hb_frame_field_count; field++) { /* the last time none */
    uint64_t bit = field < hb_frame_field_count ? (uint64_t)1 << field : 0;
    for (size_t k = 0; k < copy->count; k++) copy->block[k] = (double)NAN;
    hb_sim_snapshot(w.sim, bit & HB_FIELDS_OF_FORCES, copy);
    hb_measure_choose(measure, bit);
    hb_measure_state(measure, copy, w.part);
    if (field == 0) hb_sim_measure(w.sim, w.whole);
    assert_true(w.part->fields == bit);
    assert_same_scalars(w.part, w.whole);
    if (bit)
      assert_memory_equal(numbers(w.part, field), numbers(w.whole, field),
                          count_of(&w, field) * sizeof(double));
  }
  assert_true(w.whole->fields == HB_FIELDS_ALL);
  hb_state_free(copy);
  hb_measure_free(measure);
  drop(&w);
}

/* A snapshot leaves the run as it is: going on after it gives the bits of a run that was never looked at, and
 * the state is the same when it is brought up to date later. */
static void a_look_changes_nothing(void **state) {
  (void)state;
  world a, b;
  hb_error err = {HB_OK, ""};
  hb_state *copy = NULL;
  make(&a);
  make(&b);
  assert_int_equal(hb_state_create(a.model, &copy, &err), HB_OK);
  for (int n = 0; n < 20; n++) {
    hb_sim_snapshot(a.sim, n % 2, copy);
    assert_same(copy->scalar[HB_S_STEP], (double)(STEPS + n));
    assert_int_equal(hb_sim_advance(a.sim, 1, &err), HB_OK);
  }
  assert_int_equal(hb_sim_advance(b.sim, 20, &err), HB_OK);
  assert_true(hb_state_hash(hb_sim_const_state(a.sim)) == hb_state_hash(hb_sim_const_state(b.sim)));
  hb_sim_snapshot(a.sim, true, copy); /* now the arrays are up to date */
  assert_memory_equal(copy->x, hb_sim_const_state(a.sim)->x, 3 * (size_t)a.model->nv * sizeof(double));
  hb_state_free(copy);
  drop(&a);
  drop(&b);
}

/* A row of an edge field that files do not hold: where a rod ends, or a closed one begins anew. */
static bool is_gap(const world *w, int field, size_t number) {
  const hb_frame_field *f = &hb_frame_fields[field];
  int slot = (int)(number / (size_t)f->components);
  const hb_rod *rod = &w->model->rods[w->model->rod_of[slot]];
  return f->location == HB_ON_EDGE && slot == rod->first + rod->nv - 1;
}

/* A file name in the scratch directory. */
static const char *scratch(const char *name) {
  static char path[300];
  const char *directory = getenv("HEBRA_SCRATCH");
  snprintf(path, sizeof path, "%s/%s-%ld", directory ? directory : ".", name, (long)getpid());
  return path;
}

/* Writes two frames with the fields, the second by going on with the file. */
static void write_file(world *w, const char *path, uint64_t fields, bool single) {
  hb_error err = {HB_OK, ""};
  hb_writer *writer = NULL;
  w->def.output.fields = fields;
  w->def.output.single = single;
  hb_sim_measure(w->sim, w->whole);
  if (hb_writer_create(path, w->model, 3, &writer, &err) || hb_writer_add(writer, w->whole, &err) ||
      hb_writer_close(writer, &err) || hb_writer_continue(path, w->model, 3, 1, &writer, &err) ||
      hb_writer_add(writer, w->whole, &err) || hb_writer_close(writer, &err))
    fail_msg("%s", err.text);
}

/* What is in the file is what was measured, to the precision of the file; the rest is not there, and a
 * sentence says so. */
static void files(void **state) {
  (void)state;
  world w;
  const char *path = scratch("fields.h5");
  make(&w);
  double *values = hb_alloc((size_t)w.model->nv, 4 * sizeof *values);
  assert_non_null(values);
  const uint64_t choices[] = {HB_FIELD_BIT(tension), hb_field_groups[1].fields, HB_FIELDS_ALL, 0};
  for (int n = 0; n < 8; n++) {
    hb_reader *reader = NULL;
    hb_error err = {HB_OK, ""};
    uint64_t chosen = choices[n / 2], held = chosen ? chosen | HB_FIELD_BIT(position) : HB_FIELDS_ALL;
    write_file(&w, path, chosen, n % 2);
    assert_int_equal(hb_reader_open(path, &reader, &err), HB_OK);
    assert_int_equal(hb_reader_info(reader)->frames, 2);
    assert_true(hb_reader_fields(reader) == held);
    for (int k = 0; k < hb_frame_field_count; k++) {
      hb_status status = hb_reader_field(reader, hb_frame_fields[k].name, 1, values, &err);
      assert_int_equal(status, held >> k & 1 ? HB_OK : HB_ERR_INPUT);
      const double *measured = numbers(w.whole, k);
      for (size_t i = 0; !status && i < count_of(&w, k); i++)
        assert_near(values[i], is_gap(&w, k, i) ? 0 : measured[i],
                    n % 2 ? fabs(measured[i]) * (double)FLT_EPSILON + (double)FLT_MIN : 0);
    }
    if (n == 0) {
      assert_int_equal(hb_reader_field(reader, "m1", 0, values, &err), HB_ERR_INPUT);
      assert_non_null(strstr(err.text,
                             "does not hold the field m1, only position, tension; a run writes what "
                             "output.fields of its scene asks for"));
    }
    hb_reader_close(reader);
  }
  hb_free(values);
  unlink(path);
  drop(&w);
}

/* Going on with other fields or in another precision would mix two files: refused. */
static void another_choice_is_refused(void **state) {
  (void)state;
  world w;
  const char *path = scratch("choice.h5");
  hb_writer *writer = NULL;
  hb_error err = {HB_OK, ""};
  make(&w);
  write_file(&w, path, HB_FIELD_BIT(m1), false);
  w.def.output.fields = HB_FIELD_BIT(m2);
  assert_int_equal(hb_writer_continue(path, w.model, 3, 1, &writer, &err), HB_ERR_INPUT);
  assert_non_null(strstr(err.text, "frames cannot be added"));
  w.def.output.fields = HB_FIELD_BIT(m1);
  w.def.output.single = true;
  assert_int_equal(hb_writer_continue(path, w.model, 3, 1, &writer, &err), HB_ERR_INPUT);
  w.def.output.single = false;
  assert_int_equal(hb_writer_continue(path, w.model, 3, 1, &writer, &err), HB_OK);
  assert_int_equal(hb_writer_close(writer, &err), HB_OK);
  unlink(path);
  drop(&w);
}

/* Exports hold the fields that the trajectory holds. */
static void exports(void **state) {
  (void)state;
  world w;
  char directory[320], name[700], line[2000];
  hb_reader *reader = NULL;
  hb_error err = {HB_OK, ""};
  make(&w);
  snprintf(directory, sizeof directory, "%s", scratch("tables"));
  const char *path = scratch("exports.h5");
  write_file(&w, path, HB_FIELD_BIT(position) | HB_FIELD_BIT(theta), true);
  assert_int_equal(hb_reader_open(path, &reader, &err), HB_OK);
  if (hb_export(reader, "csv", directory, 0, 1, 1, &err) ||
      hb_export(reader, "vtp", directory, 1, 1, 1, &err))
    fail_msg("%s", err.text);
  hb_reader_close(reader);
  snprintf(name, sizeof name, "%s/rod-5-curl.csv", directory);
  FILE *file = fopen(name, "r");
  assert_non_null(file);
  assert_non_null(fgets(line, sizeof line, file));
  fclose(file);
  assert_string_equal(line, "frame,time [time],vertex,position_x [length],position_y [length],"
                            "position_z [length],theta [rad]\n");
  snprintf(name, sizeof name, "rm -r '%s' '%s'", directory, path);
  assert_int_equal(system(name), 0);
  drop(&w);
}

/* A recorder measures the fields of the file and those that are looked at; at the end the last frame is
 * completed from its copy. */
static void recorders_complete(void **state) {
  (void)state;
  for (int forces = 0; forces < 2; forces++) {
    world w;
    hb_error err = {HB_OK, ""};
    hb_recorder *recorder = NULL;
    make(&w);
    hb_record_plan plan = {
        .frame = w.part, .threaded = true, .fields = HB_FIELD_BIT(m1) | (forces ? HB_FIELD_BIT(tension) : 0)};
    assert_int_equal(hb_recorder_create(w.model, &plan, &recorder, &err), HB_OK);
    hb_recorder_complete(recorder); /* nothing to complete */
    assert_int_equal(hb_recorder_add(recorder, w.sim, false, &err), HB_OK);
    hb_sim_measure(w.sim, w.whole);
    assert_int_equal(hb_sim_advance(w.sim, 5, &err), HB_OK);
    assert_int_equal(hb_recorder_wait(recorder, &err), HB_OK);
    assert_true(w.part->fields == plan.fields);
    hb_recorder_complete(recorder);
    assert_true(w.part->fields == (forces ? HB_FIELDS_ALL : HB_FIELDS_ALL & ~HB_FIELDS_OF_FORCES));
    assert_same_scalars(w.part, w.whole);
    for (int k = 0; k < hb_frame_field_count; k++)
      if (w.part->fields >> k & 1)
        assert_memory_equal(numbers(w.part, k), numbers(w.whole, k), count_of(&w, k) * sizeof(double));
    hb_recorder_free(recorder);
    drop(&w);
  }
}

/* Words of the key. */
static void words(void **state) {
  (void)state;
  const struct {
    const char *text;
    uint64_t fields;
    bool single;
  } cases[] = {{"{}", 0, false},
               {"{fields: all}", HB_FIELDS_ALL, false},
               {"{fields: []}", HB_FIELD_BIT(position), false},
               {"{fields: theta, precision: single}", HB_FIELD_BIT(position) | HB_FIELD_BIT(theta), true},
               {"{fields: [energies, m1], precision: double}",
                HB_FIELD_BIT(position) | HB_FIELD_BIT(energy_bending) | HB_FIELD_BIT(energy_twisting) |
                    HB_FIELD_BIT(energy_kinetic) | HB_FIELD_BIT(energy_stretching) | HB_FIELD_BIT(m1),
                false}};
  for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
    char text[3000];
    hb_scene_def def;
    hb_error err = {HB_OK, ""};
    snprintf(text, sizeof text, "%soutput: %s\n", scene, cases[k].text);
    if (hb_scene_parse(text, strlen(text), "scene", ".", NULL, 0, &def, &err)) fail_msg("%s", err.text);
    assert_true(def.output.fields == cases[k].fields);
    assert_int_equal(def.output.single, cases[k].single);
    hb_scene_def_free(&def);
  }
}

/* All of it. */
int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(groups),
                                     cmocka_unit_test(one_by_one),
                                     cmocka_unit_test(a_look_changes_nothing),
                                     cmocka_unit_test(files),
                                     cmocka_unit_test(another_choice_is_refused),
                                     cmocka_unit_test(exports),
                                     cmocka_unit_test(recorders_complete),
                                     cmocka_unit_test(words)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
