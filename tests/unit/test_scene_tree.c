/* YAML to the tree and back: places, kinds, quoting, aliases, limits. */
#include "base/memory.h"
#include "scene/tree.h"
#include "support/near.h"

#include <stdio.h>
#include <string.h>

/* Parses text that must be sound. */
static hb_node *parse(const char *text) {
  hb_scene_limits limits = hb_scene_default_limits();
  hb_node *root = NULL;
  hb_error err = {.status = HB_OK};
  if (hb_scene_yaml_parse(text, strlen(text), "t.yaml", &limits, &root, &err)) fail_msg("%s", err.text);
  return root;
}

/* Parses text that must fail with this sentence. */
static void refuse(const char *text, const hb_scene_limits *limits, const char *sentence) {
  hb_node *root = NULL;
  hb_error err = {.status = HB_OK};
  assert_int_equal(hb_scene_yaml_parse(text, strlen(text), "t.yaml", limits, &root, &err), HB_ERR_INPUT);
  assert_null(root);
  assert_string_equal(err.text, sentence);
}

/* Are two trees the same in kinds, texts and keys? */
static void assert_same_tree(const hb_node *a, const hb_node *b) {
  assert_int_equal(a->kind, b->kind);
  assert_int_equal(a->count, b->count);
  if (a->kind == HB_NODE_SCALAR) assert_string_equal(a->text, b->text);
  for (int i = 0; i < a->count; i++) {
    assert_int_equal(a->children[i]->key == NULL, b->children[i]->key == NULL);
    if (a->children[i]->key) assert_string_equal(a->children[i]->key, b->children[i]->key);
    assert_same_tree(a->children[i], b->children[i]);
  }
}

/* Every node knows its place, its key and its name from the root. */
static void places_and_paths(void **state) {
  (void)state;
  hb_node *root = parse("# comment\nmethod: {time_step: 1e-3}\nrods:\n  - name: a\n    rest: [1, [2, 3]]\n");
  char path[64];
  assert_int_equal(root->kind, HB_NODE_MAP);
  assert_int_equal(root->count, 2);
  const hb_node *step = hb_node_find(hb_node_find(root, "method"), "time_step");
  assert_string_equal(step->text, "1e-3");
  assert_int_equal(step->key_line, 2);
  assert_int_equal(step->key_column, 10);
  assert_int_equal(step->line, 2);
  assert_int_equal(step->column, 21);
  const hb_node *rest = hb_node_find(hb_node_find(root, "rods")->children[0], "rest");
  assert_int_equal(rest->kind, HB_NODE_LIST);
  const hb_node *three = rest->children[1]->children[1];
  hb_node_path(three, path, sizeof path);
  assert_string_equal(path, "rods[0].rest[1][1]");
  assert_int_equal(three->line, 5);
  assert_int_equal(three->column, 19);
  hb_node_path(root, path, sizeof path);
  assert_string_equal(path, "");
  hb_node_path(three, path, 9); /* cut, never overrun */
  assert_string_equal(path, "rods[0].");
  assert_null(hb_node_find(root, "nothing"));
  assert_null(hb_node_find(rest, "nothing"));
  assert_null(hb_node_find(NULL, "nothing"));
  hb_node_free(root);
}

/* Words that YAML 1.1 would turn into something else stay text. */
static void scalars_stay_text(void **state) {
  (void)state;
  hb_node *root =
      parse("a: yes\nb: 1_000\nc: 0x10\nd: 3*pi\ne: ~\nf: ''\ng: |\n  two\n  lines\nh:\ni: 12:30\n");
  const char *const expected[] = {"yes", "1_000", "0x10", "3*pi", "~", "", "two\nlines\n", "", "12:30"};
  for (int k = 0; k < 9; k++) assert_string_equal(root->children[k]->text, expected[k]);
  assert_false(root->children[0]->quoted);
  assert_true(root->children[5]->quoted);
  assert_true(root->children[6]->quoted);
  assert_false(root->children[7]->quoted);
  hb_node_free(root);
}

/* An alias is a copy: changing one leaves the other. */
static void aliases_are_copies(void **state) {
  (void)state;
  hb_node *root = parse("a: &x {k: [1, 2]}\nb: *x\nc: &x 5\nd: *x\n");
  assert_same_tree(hb_node_find(root, "a"), hb_node_find(root, "b"));
  assert_ptr_not_equal(hb_node_find(root, "a"), hb_node_find(root, "b"));
  assert_string_equal(hb_node_find(root, "d")->text, "5");
  hb_node_free(root);
}

/* Text made from a tree gives the same tree, whatever characters stand in it. */
static void emitted_text_gives_the_tree_again(void **state) {
  (void)state;
  static const char *const texts[] = {
      "a: 1\n",
      "just a text\n",
      "[]\n",
      "{}\n",
      "- - - a\n    - b\n  - {}\n- []\n- [[1, 2], [3]]\n",
      "a: {b: {c: {d: [1, -2, +3, -(4), '*x', '- y', '# z', 'k: v', '', ' ', '[', '{']}}}\n'key with: "
      "colon': x\n",
      "a: \"tab\\t newline\\n quote\\\" back\\\\ bell\\a nel\\N ls\\L e\xc3\xa9 \xf0\x9f\x8c\xbf \\U0010FFFF "
      "\\x7f \\uFEFF\"\n",
      "rods:\n  - name: a\n    rest: {line: {to: [0, 0, 1], vertices: 3}}\n  - name: b\n    x:\n      - [1, "
      "2, 3]\n",
      "a: &x {k: [1, 2]}\nb: *x\n",
  };
  for (size_t k = 0; k < sizeof texts / sizeof texts[0]; k++) {
    hb_node *root = parse(texts[k]), *again;
    char *text = NULL, *second = NULL;
    hb_error err;
    assert_int_equal(hb_scene_emit(root, &text, &err), HB_OK);
    again = parse(text);
    assert_same_tree(root, again);
    assert_int_equal(hb_scene_emit(again, &second, &err), HB_OK);
    assert_string_equal(text, second);
    hb_free(text);
    hb_free(second);
    hb_node_free(root);
    hb_node_free(again);
  }
}

/* Simple scenes stay easy to read. */
static void emitted_text_is_readable(void **state) {
  (void)state;
  hb_node *root =
      parse("{method: {time_step: 1e-3}, rods: [{name: a, start: {position: [x, 'max(y, 0)', fixed]}}]}");
  char *text = NULL;
  hb_error err;
  assert_int_equal(hb_scene_emit(root, &text, &err), HB_OK);
  assert_string_equal(text, "method:\n  time_step: 1e-3\nrods:\n  - name: a\n    start:\n"
                            "      position: [x, \"max(y, 0)\", fixed]\n");
  hb_free(text);
  hb_node_free(root);
}

/* Each limit ends the reading with its own sentence. */
static void limits_hold(void **state) {
  (void)state;
  hb_scene_limits limits = hb_scene_default_limits();
  limits.bytes = 4;
  refuse("a: 12345\n", &limits, "t.yaml: the file has 9 bytes; at most 4 are allowed");
  limits = hb_scene_default_limits();
  limits.nodes = 3;
  refuse("[1, 2,\n 3]\n", &limits, "t.yaml:2:2: the document holds more than 3 values, which is not allowed");
  limits = hb_scene_default_limits();
  limits.alias_nodes = 5;
  refuse("a: &x [1, 2]\nb: *x\nc: *x\n", &limits,
         "t.yaml:3:4: aliases copy more than 5 values, which is not allowed");
  limits = hb_scene_default_limits();
  limits.depth = 4;
  refuse("[[[[1]]]]\n", &limits, "t.yaml:1:5: the document is nested too deeply");
  refuse("a: &x [[1]]\nb: [*x]\n", &limits, "t.yaml:2:5: the document is nested too deeply");
}

/* Invalid bytes are located by line and column, counted in characters. */
static void bad_bytes_are_located(void **state) {
  (void)state;
  hb_scene_limits limits = hb_scene_default_limits();
  refuse("a: 1\nb: \xc3\xa9\xff\n", &limits,
         "t.yaml:2:5: not valid YAML: invalid leading UTF-8 octet; the file must be plain UTF-8 text");
  refuse("a: 1\nb: \x01\n", &limits,
         "t.yaml:2:4: not valid YAML: control characters are not allowed; the file must be plain UTF-8 text");
  refuse("\xc3\xa9: 1\n\tb: 1\n", &limits,
         "t.yaml:2:1: not valid YAML: a tab stands here; lines are indented by spaces only");
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(places_and_paths),         cmocka_unit_test(scalars_stay_text),
      cmocka_unit_test(aliases_are_copies),       cmocka_unit_test(emitted_text_gives_the_tree_again),
      cmocka_unit_test(emitted_text_is_readable), cmocka_unit_test(limits_hold),
      cmocka_unit_test(bad_bytes_are_located),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
