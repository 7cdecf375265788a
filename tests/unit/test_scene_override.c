/* --set: every form of path, what it makes of the tree, and what it says when a path leads nowhere. */
#include "base/memory.h"
#include "scene/tree.h"
#include "support/near.h"

#include <stdio.h>
#include <string.h>

static const char scene[] = "method: {time_step: 1e-3}\n"
                            "rods:\n"
                            "  - {name: trunk, bending: 1}\n"
                            "  - {name: branch, bending: 2, rest: {vertices: [[0, 0, 0], [1, 0, 0]]}}\n";

/* The scene after some overrides, as text. */
static char *after(const char *const *overrides, int count) {
  hb_scene_limits limits = hb_scene_default_limits();
  hb_node *root = NULL;
  hb_error err = {.status = HB_OK};
  char *text = NULL;
  if (hb_scene_yaml_parse(scene, strlen(scene), "t", &limits, &root, &err)) fail_msg("%s", err.text);
  for (int k = 0; k < count; k++)
    if (hb_scene_override(root, overrides[k], &limits, &err)) fail_msg("%s", err.text);
  if (hb_scene_emit(root, &text, &err)) fail_msg("%s", err.text);
  hb_node_free(root);
  return text;
}

/* The scene after one override must hold this line. */
static void expect_line(const char *override, const char *line) {
  char *text = after(&override, 1);
  if (!strstr(text, line)) fail_msg("%s: no \"%s\" in\n%s", override, line, text);
  hb_free(text);
}

/* Keys, indices, names, wildcards; new keys, new entries, new mappings. */
static void paths_lead_to_their_place(void **state) {
  (void)state;
  expect_line("method.time_step=2e-4", "  time_step: 2e-4\n");
  expect_line("method.duration=3", "  time_step: 1e-3\n  duration: 3\n");
  expect_line("output.every=5", "output:\n  every: 5\n");
  expect_line("forces[0]={gravity: [0, 0, -1]}", "forces:\n  - gravity:");
  expect_line("title=a: b", "title:\n  a: b\n");
  expect_line("title=\"a: b\"", "title: \"a: b\"\n");
  expect_line("rods[0].bending=[1, 2]", "  - name: trunk\n    bending: [1, 2]\n");
  expect_line("rods.branch.bending=7", "  - name: branch\n    bending: 7\n");
  expect_line("rods[-1].bending=7", "  - name: branch\n    bending: 7\n");
  expect_line("rods[1].rest.vertices[1][2]=5", "        - [1, 0, 5]\n");
  expect_line("rods[1].rest.vertices[2]=[2, 0, 0]", "        - [1, 0, 0]\n        - [2, 0, 0]\n");
  expect_line("rods[2].name=twig", "  - name: twig\n");
  expect_line("rods[0].start.position=fixed", "    bending: 1\n    start:\n      position: fixed\n");
  expect_line("gravity=[0, 0, -9.81]", "gravity: [0, 0, -9.81]\n");
}

/* Both wildcards reach every entry. */
static void wildcards_reach_all(void **state) {
  (void)state;
  static const char *const forms[] = {"rods.*.bending=9", "rods[*].bending=9"};
  for (int k = 0; k < 2; k++) {
    char *text = after(&forms[k], 1);
    const char *first = strstr(text, "bending: 9"), *second = first ? strstr(first + 1, "bending: 9") : NULL;
    assert_non_null(second);
    hb_free(text);
  }
}

/* A later override sees what an earlier one has made. */
static void overrides_follow_one_another(void **state) {
  (void)state;
  static const char *const list[] = {"rods[2]={name: twig, bending: 1}", "rods.twig.bending=4",
                                     "rods.twig.radius=0.1"};
  char *text = after(list, 3);
  assert_non_null(strstr(text, "  - name: twig\n    bending: 4\n    radius: 0.1\n"));
  hb_free(text);
}

/* Sentences of paths that lead nowhere. */
static void wrong_paths_are_explained(void **state) {
  (void)state;
  static const char *const cases[][2] = {
      {"rods.twig.bending=3", "no entry of rods has the name \"twig\"; the names there are trunk, branch"},
      {"rods[1].rest.vertices.a=3",
       "no entry of rods[1].rest.vertices has the name \"a\"; give its index in [ ], from 0"},
      {"rods[3].bending=3", "rods has 2 entries, so there is no [3]"},
      {"rods[-3].bending=3", "rods has 2 entries, so there is no [-3]"},
      {"rods[1.5].bending=3", "a whole number or * is expected in [ ]"},
      {"rods[0.bending=3", "a whole number or * is expected in [ ]"},
      {"rods[0]bending=3", "the path before = is not of the form a.b[0].c"},
      {"method.time_step.x=3", "method.time_step is a single value, so the path cannot go on with x"},
      {"method[0]=3", "method is a mapping, so the path cannot go on with an index"},
      {"[0]=3", "the scene is a mapping, so the path cannot go on with an index"},
      {"method.=3", "a key is missing in the path before ="},
      {"method.time_step=", "a value is missing after ="},
      {"method", "KEY=VALUE is expected, for example --set method.time_step=1e-4"},
      {"method.time_step=[1", NULL},
      {"a.b.c.d.e.f.g.h.i.j.k.l.m.n.o.p.q.r.s.t.u.v.w.x.y.z.a.b.c.d.e.f.g.h=1",
       "the path before = is too long"},
  };
  hb_scene_limits limits = hb_scene_default_limits();
  for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
    hb_node *root = NULL;
    hb_error err = {.status = HB_OK};
    char expected[400];
    if (hb_scene_yaml_parse(scene, strlen(scene), "t", &limits, &root, &err)) fail_msg("%s", err.text);
    assert_int_equal(hb_scene_override(root, cases[k][0], &limits, &err), HB_ERR_INPUT);
    snprintf(expected, sizeof expected, "--set %s: %s", cases[k][0], cases[k][1] ? cases[k][1] : "");
    if (cases[k][1])
      assert_string_equal(err.text, expected);
    else
      assert_memory_equal(err.text, expected, strlen(expected));
    hb_node_free(root);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(paths_lead_to_their_place),
      cmocka_unit_test(wildcards_reach_all),
      cmocka_unit_test(overrides_follow_one_another),
      cmocka_unit_test(wrong_paths_are_explained),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
