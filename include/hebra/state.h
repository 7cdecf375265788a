/* hebra/state.h - everything that changes in a run, in one block of doubles.
 *
 * One field table drives allocation, copy, hash, checkpoint and documentation: copying the block copies the
 * state, writing it out and reading it back continues a run bit for bit. */
#ifndef HEBRA_STATE_H
#define HEBRA_STATE_H

#include "hebra/model.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Scalars of the state, by index into hb_state.scalar. */
enum {
  HB_S_TIME,             /* current time */
  HB_S_STEP,             /* steps done (an integer) */
  HB_S_WORK_LOADS,       /* work done by external loads since the start */
  HB_S_WORK_SUPPORTS,    /* work done by moving supports */
  HB_S_ENERGY_START,     /* kinetic + bending + twisting + stretching energy of the initial state */
  HB_S_DISSIPATED,       /* energy taken out by damping */
  HB_S_LENGTH_ERROR,     /* largest relative length error after the last step */
  HB_S_WORST_LENGTH,     /* the same, largest over the run */
  HB_S_PROJECTIONS,      /* projection iterations in all (an integer) */
  HB_S_TWIST_ITERATIONS, /* twist Newton iterations in all (an integer) */
  HB_S_FOLDS,            /* number of times that two edges folded back onto each other (an integer) */
  HB_S_FOLD_SLOT,        /* last vertex slot where that happened, -1: none */
  HB_S_FALLBACKS, /* steps of a rod whose lengths needed the moving gradient in a scheme that uses the old one
                   */
  HB_S_SADDLES,   /* times that the twist was led off a saddle of its energy */
  HB_S_NEWTON,    /* steps of Newton's method in implicit schemes in all (an integer) */
  HB_S_FACTORISATIONS, /* matrices that they factored (an integer) */
  HB_S_PIECES,         /* pieces that they divided the steps of rods into (an integer) */
  HB_S_REJECTED,       /* pieces that were taken again, shorter (an integer) */
  HB_S_COUNT
};

/* How many entries a field has. */
typedef enum hb_extent {
  HB_PER_MODEL,
  HB_PER_SLOT,    /* vertices, or edges with one unused slot per rod */
  HB_PER_GENERAL, /* slots if the model has general rods, else none */
  HB_PER_VISCOUS, /* slots if the model has bending-rate viscosity, else none */
  HB_PER_PANEL,
  HB_PER_SPAN,
  HB_PER_ROD,
  HB_PER_FRAME
} hb_extent;

/* name, extent, components, one sentence */
#define HB_STATE_FIELDS(F)                                                                                   \
  F(scalar, HB_PER_MODEL, HB_S_COUNT, "time, step and running totals, see HB_S_...")                         \
  F(x, HB_PER_SLOT, 3, "vertex positions")                                                                   \
  F(v, HB_PER_SLOT, 3, "vertex velocities")                                                                  \
  F(force, HB_PER_SLOT, 3, "total force on the vertices at the current positions, without constraints")      \
  F(load, HB_PER_SLOT, 3, "the part of it that comes from external loads")                                   \
  F(lambda, HB_PER_SLOT, 1,                                                                                  \
    "pull of each edge per its vector in the last projection, a first guess for the next")                   \
  F(moment, HB_PER_SPAN, 1, "twisting moment of each span of closed-form rods")                              \
  F(m1, HB_PER_GENERAL, 3, "first material director of each edge (general rods)")                            \
  F(tangent, HB_PER_GENERAL, 3, "tangent to which m1 belongs (general rods)")                                \
  F(twist, HB_PER_GENERAL, 1, "twist m_i of interior vertices with windings (general rods)")                 \
  F(spin, HB_PER_GENERAL, 1, "how far each edge's frame turned beyond parallel transport in the last step")  \
  F(omega_1, HB_PER_VISCOUS, 4, "material curvatures one step ago")                                          \
  F(omega_2, HB_PER_VISCOUS, 4,                                                                              \
    "material curvatures two steps ago; implicit schemes: omega_1 less a time step at its rate")             \
  F(panel_m1, HB_PER_PANEL, 3, "director at the far end of each panel (closed-form rods)")                   \
  F(panel_tangent, HB_PER_PANEL, 3, "tangent to which it belongs")                                           \
  F(panel_twist, HB_PER_PANEL, 1, "twist over the panel with windings")                                      \
  F(frame_m1, HB_PER_FRAME, 3, "held director before its prescribed turning, per prescribed edge")           \
  F(frame_tangent, HB_PER_FRAME, 3, "tangent to which it belongs")                                           \
  F(frame_angle, HB_PER_FRAME, 1, "prescribed angle at the current time")                                    \
  F(frame_torque, HB_PER_FRAME, 1, "torque of the support about the tangent")                                \
  F(anchor_m1, HB_PER_ROD, 3, "director u^0 of each rod's first Bishop frame, carried in time")              \
  F(anchor_tangent, HB_PER_ROD, 3, "tangent to which it belongs")                                            \
  F(theta_0, HB_PER_ROD, 1, "material angle of the first edge, windings counted")                            \
  F(seam, HB_PER_ROD, 1, "turn by which the material frame of a closed rod is cut off where its ends meet")  \
  F(piece, HB_PER_ROD, 1, "how long a piece of a step error control takes next; 0: a whole step")

typedef struct hb_state {
#define HB_DECLARE(name, extent, components, text) double *name;
  HB_STATE_FIELDS(HB_DECLARE)
#undef HB_DECLARE
  double *block; /* all of the above, contiguous */
  size_t count;  /* doubles in the block */
} hb_state;

typedef struct hb_state_field {
  const char *name;
  hb_extent extent;
  int components;
  const char *text;
  size_t offset; /* of the pointer inside hb_state */
} hb_state_field;

extern const hb_state_field hb_state_fields[];
extern const int hb_state_field_count;

/* Entries of a field in a model (extent times components). */
size_t hb_state_field_size(const hb_model *model, const hb_state_field *field);
/* Allocates the block, all zero. */
hb_status hb_state_create(const hb_model *model, hb_state **out, hb_error *err);
void hb_state_free(hb_state *state);
void hb_state_copy(hb_state *to, const hb_state *from); /* same model */
/* Copies all that belongs to one rod, but not the scalars, which belong to none. */
void hb_state_copy_rod(const hb_model *model, const hb_rod *rod, hb_state *to, const hb_state *from);
uint64_t hb_state_hash(const hb_state *state); /* FNV-1a over the bytes of the block */

#ifdef __cplusplus
}
#endif
#endif
