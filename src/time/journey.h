/* A unit on its way through a step: what the files of this room that step lanes share. */
#ifndef HB_TIME_JOURNEY_H
#define HB_TIME_JOURNEY_H

#include "time/stepper.h"

/* Offset of an array or record of a strip. */
#define AT(name) offsetof(hb_strip, name)

/* One unit under way. */
typedef struct hb_journey {
  hb_stepper *s;
  hb_unit *u;
  const hb_lane_kernels *k;
  double t, h;
  bool along; /* lengths along the edges at the start of the step, velocities projected (second order) */
} hb_journey;

/* One pass over all strips of a unit, whose strips may be passed over at the same time. */
typedef enum hb_pass {
  ADVANCE,
  ELIMINATE,
  SPREAD,
  RATES,
  SPREAD_RATES,
  TRANSPORT,
  FLEX,
  ELASTIC,
  CARRY,
  FIRST_LOOK,
  LOOK,
  SOLVE_TURNS,
  TURN,
  GENERAL,
  LOADS,
  SUM_UP
} hb_pass;

/* How an attempt went. */
typedef enum hb_outcome { REGULAR, IRREGULAR } hb_outcome;

/* Lanes that count: idle ones repeat the first rod. */
static inline int hb_journey_lanes(const hb_unit *u) { return u->pieces ? u->strips->lanes : u->rod_count; }

/* lane_pass.c */
/* One pass over all strips; by all threads where the unit has many and the threads have nothing else to do.
 */
void hb_journey_pass(const hb_journey *journey, hb_pass which);
/* A strip's record (its offset) in every lane. */
void hb_journey_set(hb_unit *unit, size_t record, double value);
/* Largest of a record over the lanes of a rod in pieces, or in one lane of a bundle; not-a-number stays. */
double hb_journey_largest(const hb_unit *unit, size_t record, int lane);
/* Had all rows of a rod sound pivots? */
bool hb_journey_full(const hb_unit *unit, int lane);

/* lane_lengths.c */
/* Elimination of the lengths, or of their rates, in all strips; false if the pieces do not fit together. */
bool hb_journey_solve(const hb_journey *journey, bool rates);
/* Newton on the lengths of all rods of the unit; rods that are done wait. */
hb_outcome hb_journey_fit(const hb_journey *journey);

/* lane_force.c */
/* Elastic forces, twist in equilibrium, loads, at the new positions. */
hb_status hb_journey_evaluate(const hb_journey *journey, hb_error *err);

#endif
