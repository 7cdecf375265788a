/* YAML text to the tree, by the events of libyaml. Scalars stay text: whether `on`, `1_000` or `3*pi` is
 * allowed is decided where the value is used. */
#include "scene/tree.h"

#include "base/memory.h"

#include <stdio.h>
#include <string.h>
#include <yaml.h>

enum { MAX_DEPTH = 64, MAX_ANCHORS = 1000, MAX_KEYS = 10000 };

/* A named node that aliases may copy. */
typedef struct anchor {
  char *name;
  const hb_node *node;
} anchor;

/* A mapping or list that is being filled. */
typedef struct level {
  hb_node *node;
  char *key; /* mapping: a key was read, its value is due */
  int key_line, key_column;
} level;

/* All that the reading needs. */
typedef struct builder {
  const char *name;
  const hb_scene_limits *limits;
  hb_error *err;
  hb_node *root;
  level stack[MAX_DEPTH];
  int depth;
  anchor *anchors;
  int anchor_count;
  long nodes, alias_nodes;
  int documents;
} builder;

/* Fails at a place in the document. */
static hb_status fail_at(const builder *b, int line, int column, const char *sentence) {
  return hb_fail(b->err, HB_ERR_INPUT, "%s:%d:%d: %s", b->name, line, column, sentence);
}

/* Fails at the start of an event. */
static hb_status fail_event(const builder *b, const yaml_event_t *event, const char *sentence) {
  return fail_at(b, (int)event->start_mark.line + 1, (int)event->start_mark.column + 1, sentence);
}

/* Line and column of a byte offset. */
static void locate(const char *text, size_t length, size_t offset, int *line, int *column) {
  *line = *column = 1;
  for (size_t i = 0; i < offset && i < length; i++) {
    if (text[i] == '\n') {
      ++*line;
      *column = 1;
    } else if (((unsigned char)text[i] & 0xC0) != 0x80)
      ++*column;
  }
}

/* The first byte of the character with this index, from 0; 0 behind the end. */
static char character_at(const char *text, size_t length, size_t index) {
  for (size_t i = 0; i < length; i++)
    if (((unsigned char)text[i] & 0xC0) != 0x80 && index-- == 0) return text[i];
  return 0;
}

/* Puts libyaml's complaint into one sentence. */
static hb_status fail_syntax(const builder *b, const yaml_parser_t *parser, const char *text, size_t length) {
  int line = (int)parser->problem_mark.line + 1, column = (int)parser->problem_mark.column + 1;
  const char *problem = parser->problem ? parser->problem : "unreadable";
  if (parser->error == YAML_MEMORY_ERROR) return hb_fail_memory(b->err, "YAML document");
  if (parser->error == YAML_READER_ERROR) {
    locate(text, length, parser->problem_offset, &line, &column);
    return hb_fail(b->err, HB_ERR_INPUT, "%s:%d:%d: not valid YAML: %s; the file must be plain UTF-8 text",
                   b->name, line, column, problem);
  }
  if (character_at(text, length, parser->problem_mark.index) == '\t')
    return fail_at(b, line, column, "not valid YAML: a tab stands here; lines are indented by spaces only");
  if (parser->context && parser->context_mark.line != parser->problem_mark.line)
    return hb_fail(b->err, HB_ERR_INPUT, "%s:%d:%d: not valid YAML: %s (%s that begins at line %d)", b->name,
                   line, column, problem, parser->context, (int)parser->context_mark.line + 1);
  return hb_fail(b->err, HB_ERR_INPUT, "%s:%d:%d: not valid YAML: %s%s%s", b->name, line, column, problem,
                 parser->context ? " " : "", parser->context ? parser->context : "");
}

/* A scalar in key position becomes the pending key. */
static hb_status take_key(builder *b, const yaml_event_t *event) {
  level *top = &b->stack[b->depth - 1];
  const char *key = (const char *)event->data.scalar.value;
  int line = (int)event->start_mark.line + 1, column = (int)event->start_mark.column + 1;
  if (strlen(key) != event->data.scalar.length) return fail_event(b, event, "a key holds a zero byte");
  if (top->node->count == MAX_KEYS)
    return fail_event(b, event, "a mapping with more than 10000 keys is not allowed");
  const hb_node *twin = hb_node_find(top->node, key);
  if (twin) {
    char path[512];
    hb_node_path(twin, path, sizeof path);
    return hb_fail(b->err, HB_ERR_INPUT,
                   "%s:%d:%d: %s: the key \"%.60s\" stands twice; it was given at line %d already", b->name,
                   line, column, path, key, twin->key_line);
  }
  top->key = hb_strdup(key);
  if (!top->key) return hb_fail_memory(b->err, "YAML key");
  top->key_line = line;
  top->key_column = column;
  return HB_OK;
}

/* Hangs a finished or opened node into the tree; owns it from then on, also on failure. */
static hb_status attach(builder *b, hb_node *node) {
  if (b->depth == 0) {
    b->root = node;
    return HB_OK;
  }
  level *top = &b->stack[b->depth - 1];
  node->key_line = top->key_line;
  node->key_column = top->key_column;
  if (!hb_node_append(top->node, node, top->node->kind == HB_NODE_MAP ? top->key : NULL)) {
    hb_node_free(node);
    return hb_fail_memory(b->err, "YAML node");
  }
  hb_free(top->key);
  top->key = NULL;
  return HB_OK;
}

/* Remembers an anchor; a later one of the same name hides the earlier. */
static hb_status remember(builder *b, const yaml_event_t *event, const yaml_char_t *name,
                          const hb_node *node) {
  if (!name) return HB_OK;
  if (b->anchor_count == MAX_ANCHORS) return fail_event(b, event, "more than 1000 anchors are not allowed");
  if (!b->anchors) b->anchors = hb_alloc(MAX_ANCHORS, sizeof *b->anchors);
  char *copy = b->anchors ? hb_strdup((const char *)name) : NULL;
  if (!copy) return hb_fail_memory(b->err, "YAML anchor");
  b->anchors[b->anchor_count++] = (anchor){copy, node};
  return HB_OK;
}

/* Is the node still being filled? Then an alias to it would hold itself. */
static bool is_open(const builder *b, const hb_node *node) {
  for (int i = 0; i < b->depth; i++)
    if (b->stack[i].node == node) return true;
  return false;
}

/* Depth of the tree below a node, itself counted. */
static int height(const hb_node *node) {
  int most = 0;
  for (int i = 0; i < node->count; i++) {
    int h = height(node->children[i]);
    if (h > most) most = h;
  }
  return most + 1;
}

/* Copies what an alias names. */
static hb_status take_alias(builder *b, const yaml_event_t *event) {
  const char *name = (const char *)event->data.alias.anchor;
  const hb_node *from = NULL;
  for (int i = b->anchor_count - 1; i >= 0 && !from; i--)
    if (strcmp(b->anchors[i].name, name) == 0) from = b->anchors[i].node;
  int line = (int)event->start_mark.line + 1, column = (int)event->start_mark.column + 1;
  if (!from)
    return hb_fail(
        b->err, HB_ERR_INPUT,
        "%s:%d:%d: the alias *%.60s names no anchor; a value that begins with * must stand in quotes",
        b->name, line, column, name);
  if (is_open(b, from)) return fail_at(b, line, column, "an alias inside its own anchor is not allowed");
  if (b->depth + height(from) > b->limits->depth)
    return fail_event(b, event, "the document is nested too deeply");
  hb_node *copy = hb_node_copy(from, &b->alias_nodes, b->limits->alias_nodes);
  if (!copy && b->alias_nodes > b->limits->alias_nodes)
    return hb_fail(b->err, HB_ERR_INPUT, "%s:%d:%d: aliases copy more than %ld values, which is not allowed",
                   b->name, line, column, b->limits->alias_nodes);
  if (!copy) return hb_fail_memory(b->err, "YAML alias");
  return attach(b, copy);
}

/* Opens a mapping, a list or takes a scalar. */
static hb_status take_node(builder *b, const yaml_event_t *event, hb_node_kind kind, const yaml_char_t *name,
                           const yaml_char_t *tag) {
  if (tag)
    return fail_event(b, event, "YAML tags (!...) are not used in scenes; quote a value that begins with !");
  if (++b->nodes > b->limits->nodes)
    return hb_fail(b->err, HB_ERR_INPUT,
                   "%s:%d:%d: the document holds more than %ld values, which is not allowed", b->name,
                   (int)event->start_mark.line + 1, (int)event->start_mark.column + 1, b->limits->nodes);
  if (b->depth >= b->limits->depth || b->depth >= MAX_DEPTH)
    return fail_event(b, event, "the document is nested too deeply");
  hb_node *node = hb_node_create(kind, (int)event->start_mark.line + 1, (int)event->start_mark.column + 1);
  if (!node) return hb_fail_memory(b->err, "YAML node");
  if (kind == HB_NODE_SCALAR) {
    const char *text = (const char *)event->data.scalar.value;
    node->quoted = event->data.scalar.style != YAML_PLAIN_SCALAR_STYLE;
    node->text = hb_strdup(text);
    if (!node->text || strlen(text) != event->data.scalar.length) {
      bool memory = !node->text;
      hb_node_free(node);
      return memory ? hb_fail_memory(b->err, "YAML scalar")
                    : fail_event(b, event, "a value holds a zero byte");
    }
  }
  hb_status status = attach(b, node);
  if (status != HB_OK) return status;
  if (kind != HB_NODE_SCALAR) b->stack[b->depth++] = (level){.node = node};
  return remember(b, event, name, node);
}

/* Is a key due at this point? */
static bool key_due(const builder *b) {
  return b->depth > 0 && b->stack[b->depth - 1].node->kind == HB_NODE_MAP && !b->stack[b->depth - 1].key;
}

/* One event. */
static hb_status take_event(builder *b, const yaml_event_t *event) {
  switch (event->type) {
  case YAML_DOCUMENT_START_EVENT:
    if (++b->documents > 1)
      return fail_event(b, event, "a second document (---) begins here; a scene file holds one document");
    return HB_OK;
  case YAML_SCALAR_EVENT:
    if (key_due(b)) return take_key(b, event);
    return take_node(b, event, HB_NODE_SCALAR, event->data.scalar.anchor, event->data.scalar.tag);
  case YAML_SEQUENCE_START_EVENT:
    if (key_due(b)) return fail_event(b, event, "a key must be a word, not a list");
    return take_node(b, event, HB_NODE_LIST, event->data.sequence_start.anchor,
                     event->data.sequence_start.tag);
  case YAML_MAPPING_START_EVENT:
    if (key_due(b)) return fail_event(b, event, "a key must be a word, not a mapping");
    return take_node(b, event, HB_NODE_MAP, event->data.mapping_start.anchor, event->data.mapping_start.tag);
  case YAML_ALIAS_EVENT:
    if (key_due(b)) return fail_event(b, event, "a key must be a word, not an alias");
    return take_alias(b, event);
  case YAML_SEQUENCE_END_EVENT:
  case YAML_MAPPING_END_EVENT: b->depth--; return HB_OK;
  default: return HB_OK;
  }
}

/* Runs through all events. */
static hb_status build(builder *b, yaml_parser_t *parser, const char *text, size_t length) {
  bool more = true;
  while (more) {
    yaml_event_t event;
    if (!yaml_parser_parse(parser, &event)) return fail_syntax(b, parser, text, length);
    more = event.type != YAML_STREAM_END_EVENT;
    hb_status status = take_event(b, &event);
    yaml_event_delete(&event);
    if (status != HB_OK) return status;
  }
  if (!b->root) return hb_fail(b->err, HB_ERR_INPUT, "%s:1:1: the document is empty", b->name);
  return HB_OK;
}

/* Parses a document. */
hb_status hb_scene_yaml_parse(const char *text, size_t length, const char *name,
                              const hb_scene_limits *limits, hb_node **root, hb_error *err) {
  *root = NULL;
  if (length > limits->bytes)
    return hb_fail(err, HB_ERR_INPUT, "%s: the file has %zu bytes; at most %zu are allowed", name, length,
                   limits->bytes);
  builder b = {.name = name, .limits = limits, .err = err};
  yaml_parser_t parser;
  if (!yaml_parser_initialize(&parser)) return hb_fail_memory(err, "YAML parser");
  yaml_parser_set_encoding(&parser, YAML_UTF8_ENCODING);
  yaml_parser_set_input_string(&parser, (const unsigned char *)text, length);
  hb_status status = build(&b, &parser, text, length);
  yaml_parser_delete(&parser);
  for (int i = 0; i < b.depth; i++) hb_free(b.stack[i].key);
  for (int i = 0; i < b.anchor_count; i++) hb_free(b.anchors[i].name);
  hb_free(b.anchors);
  if (status != HB_OK) {
    hb_node_free(b.root);
    b.root = NULL;
  }
  *root = b.root;
  return status;
}
