/* Reading values out of the tree, with one clear sentence for everything that is wrong. The section readers
 * (read_*.c) stand on these. */
#ifndef HB_SCENE_READ_H
#define HB_SCENE_READ_H

#include "hebra/scene.h"
#include "hebra/sim.h"
#include "scene/tree.h"

/* One entry of the list of rods and what became of it. */
typedef struct hb_scene_entry {
  char name[64]; /* of the rod, or of all its copies */
  int first;     /* index of its (first) rod in the definition */
  int count;     /* rods made of it */
  bool copied;   /* the key "copies" is given: rods are called name-0, name-1, ... */
} hb_scene_entry;

/* Behind the scene's parameters the definition has room for the numbers of a copy, `k` and `K`. */
#define HB_SCENE_COPY_NAMES 2

/* What every reading function needs. */
typedef struct hb_scene_reader {
  const char *name;     /* of the file, for messages */
  const char *base_dir; /* for relative paths */
  hb_scene_limits limits;
  hb_scene_def *def;
  hb_error *err;
  long vertices;           /* made so far */
  hb_scene_entry *entries; /* of the list of rods */
  int entry_count;
  int *names;        /* hash table of their names: 1 + index of the entry, 0: free */
  size_t name_slots; /* its size, a power of 2 */
  int copy, copies;  /* number of the copy that is being read, of how many; copies 0: not one of several */
} hb_scene_reader;

/* Which numbers are allowed. */
typedef enum hb_scene_rule { HB_RULE_ANY, HB_RULE_NOT_NEGATIVE, HB_RULE_POSITIVE } hb_scene_rule;

/* A rod's arc length, for formulas that vary along it. place may be NULL where x, y, z are not allowed. */
typedef struct hb_scene_arc {
  int nv;
  const double *s;     /* nv */
  const double *place; /* 3 nv */
} hb_scene_arc;

/* ---- messages: "name:line:column: key: sentence", or "--set text: key: sentence"
 * ---------------------------- */
hb_status hb_scene_fail(const hb_scene_reader *r, const hb_node *node, const char *format, ...)
    HB_PRINTF(3, 4);
/* The same, pointing at the key instead of the value. */
hb_status hb_scene_fail_key(const hb_scene_reader *r, const hb_node *node, const char *format, ...)
    HB_PRINTF(3, 4);
/* `"-3" is not allowed; WHAT is expected`. */
hb_status hb_scene_expected(const hb_scene_reader *r, const hb_node *node, const char *what);
/* Passes on a sentence of another part of the library, with the place. */
hb_status hb_scene_pass(const hb_scene_reader *r, const hb_node *node, const hb_error *inner);
/* Line and column for a definition; 0 where an override made the node. */
void hb_scene_place(const hb_node *node, int *line, int *column);
/* The word of a NULL-terminated list nearest to text, NULL if none is near. */
const char *hb_scene_nearest(const char *text, const char *const *words);

/* ---- mappings
 * ------------------------------------------------------------------------------------------------ */
/* node must be a mapping with no other keys than those of the NULL-terminated list. */
hb_status hb_scene_check_keys(const hb_scene_reader *r, const hb_node *node, const char *const *keys);
/* The value of a key that must be there; hint ends the sentence ("a number > 0"). */
hb_status hb_scene_need(const hb_scene_reader *r, const hb_node *node, const char *key, const char *hint,
                        const hb_node **out);

/* node must be a list of count entries; what names it in the sentence. */
hb_status hb_scene_list(const hb_scene_reader *r, const hb_node *node, int count, const char *what);

/* ---- values; a NULL node leaves *out as it is
 * ------------------------------------------------------------------ */
hb_status hb_scene_number(const hb_scene_reader *r, const hb_node *node, hb_scene_rule rule, double *out);
hb_status hb_scene_whole(const hb_scene_reader *r, const hb_node *node, long lo, long hi, int *out);
hb_status hb_scene_flag(const hb_scene_reader *r, const hb_node *node, bool *out);
/* *out becomes the index of the word. */
hb_status hb_scene_choice(const hb_scene_reader *r, const hb_node *node, const char *const *words, int *out);
/* *out is allocated; an older text is freed. */
hb_status hb_scene_text(const hb_scene_reader *r, const hb_node *node, char **out);
hb_status hb_scene_vector(const hb_scene_reader *r, const hb_node *node, double out[3]);
/* A vector that is not zero. */
hb_status hb_scene_direction(const hb_scene_reader *r, const hb_node *node, double out[3]);
/* allowed: bits of the variables that may stand in the formula. */
hb_status hb_scene_formula(const hb_scene_reader *r, const hb_node *node, unsigned allowed, hb_formula **out);
/* [x, y, z] of formulas. On failure nothing is left in out. */
hb_status hb_scene_formulas(const hb_scene_reader *r, const hb_node *node, unsigned allowed,
                            hb_formula *out[3]);

/* ---- along a rod
 * ------------------------------------------------------------------------------------------------ */
/* Variables of a formula at vertex k, or at the middle of edge k. */
void hb_scene_vars(const hb_scene_arc *arc, bool on_edges, int k, double vars[HB_VAR_COUNT]);
/* Evaluates a formula of s, u, i, L at all vertices (or edges) into out[k * stride]. */
hb_status hb_scene_along(const hb_scene_reader *r, const hb_node *node, const hb_scene_arc *arc,
                         bool on_edges, hb_scene_rule rule, double *out, int stride);
/* Evaluates three formulas of s, u, i, L, x, y, z at all vertices into out[3 k + c]. */
hb_status hb_scene_along_vector(const hb_scene_reader *r, const hb_node *node, const hb_scene_arc *arc,
                                double *out);
/* Arc lengths of a polyline into s[count]. */
void hb_scene_arc_lengths(const double *xyz, int count, double *s);

/* ---- sections
 * ---------------------------------------------------------------------------------------------------- */
/* What becomes of the two ends of a curve. Ends meet if they are no further apart than round-off makes them;
 * the last vertex is then put where the first is. */
typedef enum hb_scene_ends {
  HB_ENDS_OPEN,
  HB_ENDS_MAY_MEET,
  HB_ENDS_CLOSED /* where they do not meet an edge is added that leads back to the first vertex */
} hb_scene_ends;

/* A curve with its changes. base (NULL: none) stands in where no generator is given and gives the number of
 * vertices. halves: where a curve is divided, its first, its last edge gets half the length of the others.
 * *xyz is allocated. */
hb_status hb_scene_read_curve(hb_scene_reader *r, const hb_node *node, const double *base, int base_count,
                              const bool halves[2], hb_scene_ends ends, double **xyz, int *count);
/* Has the curve (NULL: none) a generator of its own? */
bool hb_scene_curve_generates(const hb_node *node);
/* Is it the reader that chooses where on this curve (NULL: none) the vertices lie? */
bool hb_scene_curve_divides(const hb_node *node);
/* B, beta and mass of a rod. */
hb_status hb_scene_read_moduli(hb_scene_reader *r, const hb_node *node, const hb_scene_arc *arc,
                               hb_rod_def *rod);
/* Does this value of start or end (NULL: none) clamp the rod at its end vertex? */
bool hb_scene_has_wall(const hb_node *node);
/* start, end and supports of a rod. */
hb_status hb_scene_read_supports(hb_scene_reader *r, const hb_node *node, hb_rod_def *rod);
/* One rod of an entry with the shapes and numbers of copy r->copy; the keys have been checked, rod->name is
 * set by the caller. */
hb_status hb_scene_read_rod(hb_scene_reader *r, const hb_node *node, hb_rod_def *rod);
/* Rods *first .. *first + *count - 1 of a name: a single rod, one copy ("hair-37"), or all copies of an entry
 * ("hair"). False if there is none. The rods must have been read. */
bool hb_scene_find_rods(const hb_scene_reader *r, const char *name, int *first, int *count);
/* All rods, copies counted. */
hb_status hb_scene_read_rods(hb_scene_reader *r, const hb_node *node);
/* gravity and forces; the rods must have been read. */
hb_status hb_scene_read_forces(hb_scene_reader *r, const hb_node *root);
/* trace; the parameters must have been read (read_trace.c). */
hb_status hb_scene_read_trace(hb_scene_reader *r, const hb_node *node);
/* hb_scene_parse with other limits; fuzzing uses small ones. */
hb_status hb_scene_parse_limited(const char *text, size_t length, const hb_scene_reader *settings,
                                 const char *const *overrides, int override_count);

#endif
