/* The list of rods: names, and entries that stand for many rods. */
#include "scene/read.h"

#include "base/memory.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char *const rod_keys[] = {"name",
                                       "copies",
                                       "rest",
                                       "initial",
                                       "velocity",
                                       "closed",
                                       "straight_rest",
                                       "lengths",
                                       "bending",
                                       "twisting",
                                       "stretching",
                                       "inextensible",
                                       "section",
                                       "E",
                                       "nu",
                                       "G",
                                       "density",
                                       "vertex_mass",
                                       "linear_density",
                                       "natural_twist",
                                       "rest_director",
                                       "rest_directors",
                                       "natural_curvature",
                                       "director",
                                       "damping",
                                       "radius",
                                       "start",
                                       "end",
                                       "supports",
                                       NULL};

/* FNV-1a. */
static size_t hash_of(const char *name, size_t length) {
  uint64_t hash = 14695981039346656037u;
  for (size_t k = 0; k < length; k++) hash = (hash ^ (unsigned char)name[k]) * 1099511628211u;
  return (size_t)(hash ^ (hash >> 32));
}

/* Slot of the table of names where a name stands, or the free one where it would stand. */
static size_t slot_of(const hb_scene_reader *r, const char *name, size_t length) {
  size_t at = hash_of(name, length) & (r->name_slots - 1);
  for (; r->names[at]; at = (at + 1) & (r->name_slots - 1)) {
    const char *other = r->entries[r->names[at] - 1].name;
    if (strlen(other) == length && memcmp(other, name, length) == 0) break;
  }
  return at;
}

/* Index of the entry of a name, -1 if there is none. */
static int find_entry(const hb_scene_reader *r, const char *name, size_t length) {
  return r->names[slot_of(r, name, length)] - 1;
}

/* "hair-37" is copy 37 of the entry "hair": index of the entry and *number, -1 if the name is of no copy. */
static int find_copy(const hb_scene_reader *r, const char *name, int *number) {
  const char *dash = strrchr(name, '-'), *digits = dash ? dash + 1 : "";
  size_t length = strlen(digits);
  bool plain = length > 0 && length < 10 && strspn(digits, "0123456789") == length;
  if (!plain || (digits[0] == '0' && length > 1)) return -1;
  int entry = find_entry(r, name, (size_t)(dash - name));
  *number = (int)strtol(digits, NULL, 10);
  return entry >= 0 && r->entries[entry].copied && *number < r->entries[entry].count ? entry : -1;
}

/* Rods of a name: one, or all copies of an entry. */
bool hb_scene_find_rods(const hb_scene_reader *r, const char *name, int *first, int *count) {
  int number = 0, entry = find_entry(r, name, strlen(name));
  if (entry >= 0) {
    *first = r->entries[entry].first;
    *count = r->entries[entry].count;
    return true;
  }
  entry = find_copy(r, name, &number);
  if (entry < 0) return false;
  *first = r->entries[entry].first + number;
  *count = 1;
  return true;
}

/* name: a word that can stand in a path and in a file */
static hb_status read_name(hb_scene_reader *r, const hb_node *node, int index, hb_scene_entry *entry) {
  const hb_node *given = hb_node_find(node, "name");
  snprintf(entry->name, sizeof entry->name, "rod%d", index);
  if (!given) return HB_OK;
  if (given->kind != HB_NODE_SCALAR) return hb_scene_expected(r, given, "a text");
  size_t n = strlen(given->text);
  bool letters = strspn(given->text, "0123456789-") < n; /* a bare number would look like an index */
  if (n > 60 || !letters ||
      strspn(given->text, "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-") != n ||
      !strcmp(given->text, "all"))
    return hb_scene_expected(r, given,
                             "a name of letters, digits, _ and - (at most 60, not only digits, not \"all\")");
  memcpy(entry->name, given->text, n + 1);
  return HB_OK;
}

/* copies: number | {count: number}; k and K are then names of the formulas of this rod. */
static hb_status read_copies(hb_scene_reader *r, const hb_node *node, hb_scene_entry *entry) {
  static const char *const keys[] = {"count", NULL};
  const hb_node *copies = hb_node_find(node, "copies"), *count = copies;
  entry->count = 1;
  if (!copies) return HB_OK;
  hb_status status = HB_OK;
  if (copies->kind == HB_NODE_MAP) {
    status = hb_scene_check_keys(r, copies, keys);
    if (!status) status = hb_scene_need(r, copies, "count", "the number of copies", &count);
  }
  if (!status) status = hb_scene_whole(r, count, 1, r->limits.vertices / 3, &entry->count);
  entry->copied = true;
  for (int k = 0; !status && k < r->def->parameter_count; k++) {
    const char *name = r->def->parameters[k].name;
    if (!strcmp(name, "k") || !strcmp(name, "K"))
      return hb_scene_fail_key(r, copies,
                               "the parameter \"%s\" has the name of the %s, which the formulas of this rod "
                               "may use; another name for the parameter is expected",
                               name, name[0] == 'k' ? "number of a copy" : "number of copies");
  }
  return status;
}

/* Names and counts of all entries, each with a name of its own. */
static hb_status read_entries(hb_scene_reader *r, const hb_node *node) {
  long total = 0;
  r->entries = hb_alloc((size_t)node->count, sizeof *r->entries);
  for (r->name_slots = 4; r->name_slots < 2 * (size_t)node->count; r->name_slots *= 2) {
  }
  r->names = hb_alloc(r->name_slots, sizeof *r->names);
  if (!r->entries || !r->names) return hb_fail_memory(r->err, "rods");
  r->entry_count = node->count;
  for (int k = 0; k < node->count; k++) {
    hb_scene_entry *entry = &r->entries[k];
    const hb_node *child = node->children[k], *given = hb_node_find(child, "name");
    hb_status status = hb_scene_check_keys(r, child, rod_keys);
    if (!status) status = read_name(r, child, k, entry);
    if (!status) status = read_copies(r, child, entry);
    if (status) return status;
    entry->first = (int)total;
    total += entry->count;
    if (total > r->limits.vertices / 3)
      return hb_scene_fail_key(r, child, "the scene would hold more than %ld rods, which is not allowed",
                               r->limits.vertices / 3);
    int *slot = &r->names[slot_of(r, entry->name, strlen(entry->name))];
    if (*slot)
      return hb_scene_fail(r, given ? given : child,
                           "the name \"%s\" is that of rods[%d] already; every rod needs its own",
                           entry->name, *slot - 1);
    *slot = k + 1;
  }
  for (int k = 0; k < node->count; k++) {
    const hb_node *child = node->children[k], *given = hb_node_find(child, "name");
    int number = 0, other = find_copy(r, r->entries[k].name, &number);
    if (other >= 0)
      return hb_scene_fail(r, given ? given : child,
                           "the name \"%s\" is that of copy %d of rods[%d] already; every rod needs its own",
                           r->entries[k].name, number, other);
  }
  r->def->rods = hb_alloc((size_t)total, sizeof *r->def->rods);
  return r->def->rods ? HB_OK : hb_fail_memory(r->err, "rods");
}

/* All rods of one entry. */
static hb_status read_entry(hb_scene_reader *r, const hb_node *node, const hb_scene_entry *entry) {
  char names[HB_SCENE_COPY_NAMES][2] = {"k", "K"}, name[80];
  hb_parameter *own = r->def->parameters + r->def->parameter_count;
  hb_status status = HB_OK;
  r->copies = entry->copied ? entry->count : 0;
  for (r->copy = 0; !status && r->copy < entry->count; r->copy++) {
    hb_rod_def *rod = &r->def->rods[r->def->rod_count++];
    hb_rod_def_init(rod);
    if (entry->copied)
      snprintf(name, sizeof name, "%s-%d", entry->name, r->copy);
    else
      snprintf(name, sizeof name, "%s", entry->name);
    own[0] = (hb_parameter){names[0], r->copy};
    own[1] = (hb_parameter){names[1], entry->count};
    rod->name = hb_strdup(name);
    status = rod->name ? hb_scene_read_rod(r, node, rod) : hb_fail_memory(r->err, "name");
  }
  r->copy = r->copies = 0;
  own[0] = own[1] = (hb_parameter){NULL, 0};
  return status;
}

/* rods */
hb_status hb_scene_read_rods(hb_scene_reader *r, const hb_node *node) {
  if (node->kind != HB_NODE_LIST) return hb_scene_expected(r, node, "a list of rods, each beginning with -");
  if (node->count == 0) return hb_scene_fail(r, node, "the list is empty; at least one rod is expected");
  hb_status status = read_entries(r, node);
  for (int k = 0; !status && k < node->count; k++) status = read_entry(r, node->children[k], &r->entries[k]);
  return status;
}
