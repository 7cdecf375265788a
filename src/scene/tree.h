/* The tree of a scene document: mappings, lists and scalars with their places, free of any YAML library. A
 * reader (yaml.c, or a page's JavaScript parser) builds it, override.c changes it, the section readers walk
 * it. */
#ifndef HB_SCENE_TREE_H
#define HB_SCENE_TREE_H

#include "hebra/base.h"

typedef enum hb_node_kind { HB_NODE_SCALAR, HB_NODE_LIST, HB_NODE_MAP } hb_node_kind;

/* One node. A child of a mapping carries its key; every node knows its parent, so that a message can name it.
 */
typedef struct hb_node {
  hb_node_kind kind;
  int line, column;         /* where the value begins, from 1 */
  char *text;               /* scalar: its characters, no zero byte among them */
  bool quoted;              /* scalar: written in quotes or as a block, so that "" is a value */
  char *key;                /* child of a mapping */
  int key_line, key_column; /* where the key begins */
  struct hb_node *parent;
  struct hb_node **children; /* list items, or the values of a mapping in the order of the file */
  int count, capacity;
  const char *origin; /* text of the --set that made the node (borrowed); NULL: the file */
} hb_node;

/* Limits that keep a hostile document from using up the memory. */
typedef struct hb_scene_limits {
  size_t bytes;     /* of the document */
  long nodes;       /* written in the document */
  long alias_nodes; /* made by copying anchors */
  int depth;        /* of nesting */
  long vertices;    /* of all rods together */
} hb_scene_limits;

/* The limits that hb_scene_read and hb_scene_parse use. */
hb_scene_limits hb_scene_default_limits(void);

/* A new node without children; NULL if out of memory. */
hb_node *hb_node_create(hb_node_kind kind, int line, int column);
/* Frees the node and all below it; NULL is allowed. */
void hb_node_free(hb_node *node);
/* Puts child at the end of a list or mapping and owns it from then on. key is copied (NULL in a list). False
 * if out of memory; child then still belongs to the caller. */
bool hb_node_append(hb_node *parent, hb_node *child, const char *key);
/* Puts fresh in the place of old, which is freed; key and parent go over. False if out of memory. */
void hb_node_replace(hb_node *old, hb_node *fresh);
/* Deep copy; *made counts the nodes and the copy stops with NULL when it passes limit. */
hb_node *hb_node_copy(const hb_node *node, long *made, long limit);
/* The value of a key of a mapping; NULL if it is not there or node is no mapping. */
hb_node *hb_node_find(const hb_node *node, const char *key);
/* Name of the node from the root: `rods[0].rest.line`; "" for the root. */
void hb_node_path(const hb_node *node, char *buffer, size_t size);

/* Parses a YAML document into *root. name stands for the file in messages. */
hb_status hb_scene_yaml_parse(const char *text, size_t length, const char *name,
                              const hb_scene_limits *limits, hb_node **root, hb_error *err);
/* Applies one `key.path=value` to the tree; the value is a YAML flow value. The nodes borrow the override's
 * text. */
hb_status hb_scene_override(hb_node *root, const char *override, const hb_scene_limits *limits,
                            hb_error *err);
/* YAML text that gives the same tree again; *out is freed with hb_free. */
hb_status hb_scene_emit(const hb_node *root, char **out, hb_error *err);

#endif
