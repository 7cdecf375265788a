/* Which rods step in which lanes, and the way between the state and the lanes. */
#ifndef HB_LANE_PLAN_H
#define HB_LANE_PLAN_H

#include "hebra/plug.h"
#include "lane/strip.h"
#include "math/rotation.h"

/* Rods that know nothing of each other may each take some steps before the next one's turn: their numbers
 * stay in the cache. At most so many. */
#define HB_BLOCK_STEPS 16
/* What is wanted for a rod, bits. */
#define HB_WANTED 1
#define HB_WANTED_LOADED 2 /* loads act on it */
#define HB_WANTED_DOUBLE 4 /* in doubles, whatever the others are in */

/* What takes its steps together: a bundle of rods in the lanes of one strip, or one rod cut into pieces. */
typedef struct hb_unit {
  const hb_lane_kernels *kernels;
  hb_strip *strips;
  int strip_count;
  int rods[HB_LANES_MAX]; /* bundle: rod of each lane; pieces: the rod */
  int rod_count;
  bool pieces;
  bool twisted; /* closed form, with a twisting moment */
  bool general;
  bool loaded;   /* loads act on some rod of it */
  bool alike;    /* a bundle whose rods have as many held frames and panels each (hb_lane_director) */
  bool steady;   /* and none of these frames turns in this step */
  bool moving;   /* some of its vertices are led by formulas of time */
  double *tally; /* what this step adds to the totals of the state: a row of tallies */
  double tallies[HB_BLOCK_STEPS][HB_S_COUNT], length_errors[HB_BLOCK_STEPS]; /* of the steps of a block */
  double length_error;                                                       /* of this step */
  bool finite;
  int fresh; /* > 0: came from a state in which somebody may have moved held vertices. They are back in their
              * places after one step and at rest after two. */
  double *chain; /* pieces: 4 per lane of all strips, for the system of last rows */
} hb_unit;

typedef struct hb_lane_plan {
  const hb_lane_kernels *kernels;
  const hb_lane_kernels *once; /* in doubles, for what is done once per rod */
  hb_unit *units;
  int unit_count;
  int *unit_of;   /* per rod: its unit, or -1 */
  hb_quat *turns; /* per panel of the model: transport along it */
  void *block;
  size_t bytes;
} hb_lane_plan;

/* Plans the rods with wanted[rod] != 0, by `kernels`, or by `once` those that have to be in doubles. *out
 * NULL if there are none. */
hb_status hb_lane_plan_create(const hb_model *model, const unsigned char *wanted,
                              const hb_lane_kernels *kernels, const hb_lane_kernels *once, hb_lane_plan **out,
                              hb_error *err);
void hb_lane_plan_free(hb_lane_plan *plan);

/* State to lanes and back: positions, velocities, forces, multipliers of the unit's rods. */
void hb_unit_load(const hb_model *model, const hb_state *state, hb_unit *unit);
void hb_unit_store(const hb_model *model, hb_state *state, hb_unit *unit);
/* Only what is measured: positions, velocities, directors and twists; with forces also those. */
void hb_unit_store_measured(const hb_model *model, hb_state *state, hb_unit *unit, bool forces);

/* Where vertex (or edge) i of the unit's n-th rod is; for a vertex that two pieces share, the copy that
 * begins a piece. */
typedef struct hb_lane_place {
  hb_strip *strip;
  int lane, row;
} hb_lane_place;
hb_lane_place hb_unit_find(const hb_unit *unit, int n, int i);

/* One of the vertex arrays of a strip, by its offset in hb_strip: offsetof(hb_strip, x). */
void hb_unit_get3(const hb_unit *unit, int n, int i, size_t array, double out[3]);
void hb_unit_set3(hb_unit *unit, int n, int i, size_t array, const double in[3]); /* all copies */

/* A whole vertex array of the n-th rod: into the state's layout (3 per slot of the model), added from it,
 * set to zero. */
void hb_unit_store3(const hb_model *model, const hb_unit *unit, int n, size_t array, double *to);
void hb_unit_add3(const hb_model *model, hb_unit *unit, int n, size_t array, const double *from);
void hb_unit_clear3(hb_unit *unit, int n, size_t array);
/* The uniform load on the n-th rod, in all pieces and copies. */
void hb_unit_set_loads(hb_unit *unit, int n, const hb_uniform_load *load);
/* `numbers` numbers of edge j of the n-th rod, in one of the edge arrays. */
void hb_unit_get_edge(const hb_unit *unit, int n, int j, size_t array, int numbers, double *out);
void hb_unit_set_edge(hb_unit *unit, int n, int j, size_t array, int numbers, const double *in);
/* Directors, spins and twists of the n-th rod, a general one; the state gets the tangents, too. */
void hb_unit_load_frames(const hb_model *model, const hb_state *state, hb_unit *unit, int n);
void hb_unit_store_frames(const hb_model *model, hb_state *state, const hb_unit *unit, int n);

#endif
