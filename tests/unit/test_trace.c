/* Following branches: options, families, sinks. The physics is in tests/physics/test_trace.c. */
#include "hebra/hebra.h"
#include "support/near.h"

#include <math.h>
#include <string.h>

/* A strut whose stiffness is a parameter too. */
#define STRUT(more)                                                                                          \
  "parameters: {P: 0, B: 1, w: 0}\n"                                                                         \
  "method: {time_step: 1e-4, duration: 0}\n"                                                                 \
  "rods:\n"                                                                                                  \
  "  - name: strut\n"                                                                                        \
  "    rest: {line: {to: [1, 0, 0], vertices: 9}}\n"                                                         \
  "    bending: B\n"                                                                                         \
  "    twisting: 1\n"                                                                                        \
  "    linear_density: 1\n"                                                                                  \
  "    start: {position: fixed, tangent: fixed}\n"                                                           \
  "    supports: [{vertex: -1, position: [free, free, 0]}]\n" more "forces:\n"                               \
  "  - {point: [-P, w, 0], rod: 0, vertex: -1}\n"                                                            \
  "trace: {parameter: P, from: 0, to: 5, step: 0.2, branches: 1}\n"

typedef struct seen {
  double last;
  int points, ends, kinds[HB_TRACE_LIMIT + 1], stop_at;
  uint64_t hash; /* of all states */
} seen;

/* Counts; ends the trace where it is asked to. */
static hb_status take(void *context, const hb_trace_point *point, hb_error *err) {
  seen *s = context;
  s->points++;
  s->kinds[point->kind]++;
  s->last = point->parameter;
  s->hash = s->hash * 31 + hb_state_hash(hb_sim_const_state(point->sim));
  return s->points == s->stop_at ? hb_fail(err, HB_ERR_IO, "enough") : HB_OK;
}

/* Counts ends. */
static hb_status finish(void *context, const hb_trace_end *end, hb_error *err) {
  seen *s = context;
  (void)err;
  s->ends++;
  assert_true(strlen(end->reason) > 5 && strlen(end->reason) < HB_TRACE_SENTENCE);
  return HB_OK;
}

/* Traces a scene; change may be NULL. */
static hb_status go(const char *scene, const char *change, void (*adjust)(hb_trace_options *), seen *s,
                    hb_error *err) {
  hb_scene_def def;
  const char *changes[] = {change};
  int stop_at = s->stop_at;
  *s = (seen){.stop_at = stop_at};
  if (hb_scene_parse(scene, strlen(scene), "scene.yaml", ".", changes, change ? 1 : 0, &def, err))
    fail_msg("%s", err->text);
  hb_scene_range range = {&def, def.trace.parameter, 0};
  hb_trace_family family = hb_scene_family(&range);
  hb_trace_options options = hb_trace_defaults(def.trace.from, def.trace.to);
  options.step = def.trace.step;
  options.max_branches = def.trace.branches;
  if (adjust) adjust(&options);
  hb_trace_sink sink = {take, finish, s};
  hb_status status = hb_trace(&family, &options, &sink, NULL, err);
  hb_scene_def_free(&def);
  return status;
}

/* Wrong options. */
static void no_range(hb_trace_options *o) { o->to = o->from; }
static void no_step(hb_trace_options *o) { o->step = 0; }
static void no_points(hb_trace_options *o) { o->max_points = 1; }
static void no_branches(hb_trace_options *o) { o->max_branches = 0; }
static void few_points(hb_trace_options *o) { o->max_points = 3; }

/* Each gets its sentence, before anything is told. */
static void options_are_checked(void **state) {
  (void)state;
  hb_error err = {HB_OK, ""};
  seen s = {.stop_at = 0};
  void (*const wrong[])(hb_trace_options *) = {no_range, no_step, no_points, no_branches};
  static const char *const words[] = {"two different numbers", "longest step of 0", "1 points", "0 branches"};
  for (int k = 0; k < 4; k++) {
    assert_int_equal(go(STRUT(""), NULL, wrong[k], &s, &err), HB_ERR_INPUT);
    assert_non_null(strstr(err.text, words[k]));
    assert_int_equal(s.points + s.ends, 0);
  }
  assert_string_equal(hb_trace_kind_name(HB_TRACE_FOLD), "fold");
}

/* The end of the range is met to the last bit; the same again gives the same bits; points may be few. */
static void a_branch_is_told(void **state) {
  (void)state;
  hb_error err = {HB_OK, ""};
  seen s = {.stop_at = 0};
  if (go(STRUT(""), NULL, NULL, &s, &err)) fail_msg("%s", err.text);
  assert_true(s.last == 5);
  assert_int_equal(s.kinds[HB_TRACE_START], 1);
  assert_int_equal(s.kinds[HB_TRACE_LIMIT], 1);
  assert_int_equal(s.kinds[HB_TRACE_BIFURCATION], 1);
  assert_int_equal(s.kinds[HB_TRACE_FOLD], 0);
  assert_int_equal(s.ends, 1);
  uint64_t hash = s.hash;
  if (go(STRUT(""), NULL, NULL, &s, &err)) fail_msg("%s", err.text);
  assert_true(s.hash == hash);
  if (go(STRUT(""), NULL, few_points, &s, &err)) fail_msg("%s", err.text);
  assert_int_equal(s.points, 3);
  assert_int_equal(s.kinds[HB_TRACE_LIMIT], 0);
}

/* Stiffness instead of the load, downwards; and a scene with another value of a parameter. */
static void any_parameter(void **state) {
  (void)state;
  hb_error err = {HB_OK, ""};
  seen s = {.stop_at = 0};
  if (go(STRUT(""), "trace={parameter: B, from: 1, to: 0.1, step: 0.2, branches: 1}", NULL, &s, &err))
    fail_msg("%s", err.text);
  assert_int_equal(s.kinds[HB_TRACE_BIFURCATION], 0); /* without a load it never buckles */
  assert_true(s.last == 0.1);
  static const char loaded[] = STRUT("");
  hb_scene_def def, other;
  if (hb_scene_parse(loaded, strlen(loaded), "scene.yaml", ".", NULL, 0, &def, &err))
    fail_msg("%s", err.text);
  if (hb_scene_vary(&def, "B", 0.25, &other, &err)) fail_msg("%s", err.text);
  assert_true(other.parameters[1].value == 0.25 && other.rods[0].B[0] == 0.25);
  assert_true(def.rods[0].B[0] == 1);
  hb_scene_def_free(&other);
  hb_scene_def_free(&def);
}

/* A sideways load rounds the bifurcation off. */
static void imperfection(void **state) {
  (void)state;
  hb_error err = {HB_OK, ""};
  seen s = {.stop_at = 0};
  if (go(STRUT(""), "parameters.w=0.01", NULL, &s, &err)) fail_msg("%s", err.text);
  assert_int_equal(s.kinds[HB_TRACE_BIFURCATION], 0);
  assert_true(s.last == 5);
}

/* What a sink answers ends the trace; what cannot be traced is refused with the place. */
static void refusals(void **state) {
  (void)state;
  hb_error err = {HB_OK, ""};
  seen s = {.stop_at = 2};
  assert_int_equal(go(STRUT(""), NULL, NULL, &s, &err), HB_ERR_IO);
  assert_string_equal(err.text, "enough");
  assert_int_equal(s.points, 2);
  s.stop_at = 0;
  assert_int_equal(go(STRUT("  - {rest: {line: {to: [0, 1, 0], vertices: 9}}, bending: 1, twisting: 1, "
                            "linear_density: 1, start: {clamp: true}}\n"),
                      NULL, NULL, &s, &err),
                   HB_ERR_INPUT);
  assert_non_null(strstr(err.text, "the scene has 2 rods"));
  assert_int_equal(go(STRUT("    end: {material_angle: 0}\n"), NULL, NULL, &s, &err), HB_ERR_INPUT);
  assert_non_null(strstr(err.text, "scene:11:"));
  assert_non_null(strstr(err.text, "may turn"));
  assert_int_equal(s.points + s.ends, 0);
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(options_are_checked),
                                     cmocka_unit_test(a_branch_is_told), cmocka_unit_test(any_parameter),
                                     cmocka_unit_test(imperfection), cmocka_unit_test(refusals)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
