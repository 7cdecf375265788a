#include "scene/tree.h"

#include "base/memory.h"

#include <stdio.h>
#include <string.h>

/* Generous for a person, small against a machine's memory. */
hb_scene_limits hb_scene_default_limits(void) {
  return (hb_scene_limits){.bytes = (size_t)256 << 20,
                           .nodes = 10000000,
                           .alias_nodes = 100000,
                           .depth = 32,
                           .vertices = 10000000};
}

/* A new node without children. */
hb_node *hb_node_create(hb_node_kind kind, int line, int column) {
  hb_node *node = hb_alloc(1, sizeof *node);
  if (node) {
    node->kind = kind;
    node->line = line;
    node->column = column;
  }
  return node;
}

/* Frees a node and all below it. The depth is limited where trees are made. */
void hb_node_free(hb_node *node) {
  if (!node) return;
  for (int i = 0; i < node->count; i++) hb_node_free(node->children[i]);
  hb_free(node->children);
  hb_free(node->text);
  hb_free(node->key);
  hb_free(node);
}

/* Appends a child. */
bool hb_node_append(hb_node *parent, hb_node *child, const char *key) {
  if (parent->count == parent->capacity) {
    int capacity = parent->capacity ? 2 * parent->capacity : 4;
    hb_node **children = hb_realloc(parent->children, (size_t)capacity, sizeof *children);
    if (!children) return false;
    parent->children = children;
    parent->capacity = capacity;
  }
  if (key) {
    char *copy = hb_strdup(key);
    if (!copy) return false;
    hb_free(child->key);
    child->key = copy;
  }
  child->parent = parent;
  parent->children[parent->count++] = child;
  return true;
}

/* Replaces a node in its parent; the key and its place stay. */
void hb_node_replace(hb_node *old, hb_node *fresh) {
  hb_node *parent = old->parent;
  for (int i = 0; i < parent->count; i++)
    if (parent->children[i] == old) parent->children[i] = fresh;
  fresh->parent = parent;
  fresh->key = old->key;
  fresh->key_line = old->key_line;
  fresh->key_column = old->key_column;
  old->key = NULL;
  hb_node_free(old);
}

/* Deep copy with a limit on the number of nodes. */
hb_node *hb_node_copy(const hb_node *node, long *made, long limit) {
  if (++*made > limit) return NULL;
  hb_node *copy = hb_node_create(node->kind, node->line, node->column);
  if (!copy) return NULL;
  copy->quoted = node->quoted;
  copy->origin = node->origin;
  if (node->text && !(copy->text = hb_strdup(node->text))) goto fail;
  for (int i = 0; i < node->count; i++) {
    const hb_node *from = node->children[i];
    hb_node *child = hb_node_copy(from, made, limit);
    if (!child) goto fail;
    child->key_line = from->key_line;
    child->key_column = from->key_column;
    if (!hb_node_append(copy, child, from->key)) {
      hb_node_free(child);
      goto fail;
    }
  }
  return copy;
fail:
  hb_node_free(copy);
  return NULL;
}

/* The value of a key. */
hb_node *hb_node_find(const hb_node *node, const char *key) {
  if (!node || node->kind != HB_NODE_MAP) return NULL;
  for (int i = 0; i < node->count; i++)
    if (strcmp(node->children[i]->key, key) == 0) return node->children[i];
  return NULL;
}

/* Index of a list item in its list. */
static int index_of(const hb_node *node) {
  for (int i = 0; i < node->parent->count; i++)
    if (node->parent->children[i] == node) return i;
  return -1;
}

/* Writes the path, root first. */
void hb_node_path(const hb_node *node, char *buffer, size_t size) {
  buffer[0] = 0;
  if (!node || !node->parent) return;
  hb_node_path(node->parent, buffer, size);
  size_t used = strlen(buffer);
  if (node->key)
    snprintf(buffer + used, size - used, "%s%.64s", used ? "." : "", node->key);
  else
    snprintf(buffer + used, size - used, "[%d]", index_of(node));
}
