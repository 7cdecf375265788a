/* hebra/sim.h - a running simulation: create, step, measure. */
#ifndef HEBRA_SIM_H
#define HEBRA_SIM_H

#include "hebra/plug.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct hb_sim hb_sim;

/* Builds the initial state (lengths corrected, frames set, twist relaxed, forces evaluated). model must
 * outlive it. */
hb_status hb_sim_create(const hb_model *model, hb_sim **out, hb_error *err);
void hb_sim_free(hb_sim *sim);

/* One step of method.time_step. Allocates nothing. After an error the state is not to be used any more;
 * restore a block that was saved before to go on. */
hb_status hb_sim_step(hb_sim *sim, hb_error *err);
/* count steps, to the same bits; faster where there are many rods, since each takes several steps while its
 * numbers are in the cache. */
hb_status hb_sim_advance(hb_sim *sim, long count, hb_error *err);

const hb_model *hb_sim_model(const hb_sim *sim);
/* The state as it is now. While the run goes on, rods are kept in another layout (docs/theory, 10), and these
 * calls bring the arrays up to date: call again after every step. hb_sim_state is for writing, and costs a
 * bit more. */
hb_state *hb_sim_state(hb_sim *sim);
const hb_state *hb_sim_const_state(const hb_sim *sim);
/* Largest distance that a vertex of the initial shape was moved so that all edges have their rest lengths. */
double hb_sim_initial_correction(const hb_sim *sim);
double hb_sim_time(const hb_sim *sim);
long hb_sim_steps(const hb_sim *sim);
long hb_sim_total_steps(const hb_sim *sim); /* ceil(duration / time_step - 1e-9) */
/* Bytes of state and workspaces, those of all threads counted (without their stacks); the model and what
 * measures on other threads (hb_measure_create) are not in it. */
size_t hb_sim_memory(const hb_sim *sim);
/* Seconds spent per stage, extrapolated from the timed steps. Only if hb_sim_time_stages(sim, n): time every
 * n-th step. */
void hb_sim_time_stages(hb_sim *sim, int every);
void hb_sim_stage_seconds(const hb_sim *sim, double seconds[HB_STAGE_COUNT]);

/* Puts a saved block (count doubles, from hb_state.block) back. HB_ERR_INPUT if it does not fit the model. */
hb_status hb_sim_restore(hb_sim *sim, const double *block, size_t count, hb_error *err);

/* ---- measuring: everything a user may want to see, computed from a state
 * ----------------------------------- */

typedef enum hb_location { HB_ON_VERTEX, HB_ON_EDGE } hb_location;

/* name, components, location, unit in words of the user's units, one sentence */
#define HB_FRAME_FIELDS(F)                                                                                   \
  F(position, 3, HB_ON_VERTEX, "length", "vertex positions")                                                 \
  F(velocity, 3, HB_ON_VERTEX, "length/time", "vertex velocities")                                           \
  F(tangent, 3, HB_ON_EDGE, "1", "unit tangent, towards the next vertex")                                    \
  F(m1, 3, HB_ON_EDGE, "1", "first material director")                                                       \
  F(m2, 3, HB_ON_EDGE, "1", "second material director, tangent x m1")                                        \
  F(bishop_u, 3, HB_ON_EDGE, "1", "first director of the twist-free (Bishop) frame; theta counts from it")   \
  F(bishop_v, 3, HB_ON_EDGE, "1", "second director of the twist-free frame, tangent x bishop_u")             \
  F(theta, 1, HB_ON_EDGE, "rad", "material angle against the Bishop frame, windings counted")                \
  F(curvature_binormal, 3, HB_ON_VERTEX, "1", "normal of the bend's plane, size 2 tan(bend/2); 0 at ends")   \
  F(curvature, 1, HB_ON_VERTEX, "1/length", "size of the binormal over the vertex's length")                 \
  F(omega, 4, HB_ON_VERTEX, "1", "binormal along m2, -m1 of the edge before (2) and behind (2)")             \
  F(twist, 1, HB_ON_VERTEX, "rad", "twist between the two edges of the vertex")                              \
  F(twist_density, 1, HB_ON_VERTEX, "rad/length", "twist over the vertex's length")                          \
  F(energy_bending, 1, HB_ON_VERTEX, "energy", "bending energy of the vertex")                               \
  F(energy_twisting, 1, HB_ON_VERTEX, "energy", "twisting energy of the vertex")                             \
  F(energy_kinetic, 1, HB_ON_VERTEX, "energy", "kinetic energy of the vertex")                               \
  F(tension, 1, HB_ON_EDGE, "force", "axial force, positive in tension")                                     \
  F(twisting_moment, 1, HB_ON_VERTEX, "force*length", "modulus times twist density beyond the rest")         \
  F(reaction, 3, HB_ON_VERTEX, "force", "force of a support on a prescribed vertex")                         \
  F(torque, 1, HB_ON_EDGE, "force*length", "torque about the tangent of a support on a prescribed frame")    \
  F(torsion, 1, HB_ON_EDGE, "rad/length",                                                                    \
    "turning of the binormal along the edge; 0 beside straight places")                                      \
  F(internal_force, 3, HB_ON_EDGE, "force", "force of what follows the edge on what comes before it")        \
  F(internal_moment, 3, HB_ON_VERTEX, "force*length",                                                        \
    "moment of what follows on what comes before; elastic")                                                  \
  F(bending_moment, 1, HB_ON_VERTEX, "force*length", "size of the internal moment across the rod")           \
  F(strain, 1, HB_ON_EDGE, "1",                                                                              \
    "length over the rest length, less 1; of inextensible rods what is left of it")                          \
  F(energy_stretching, 1, HB_ON_EDGE, "energy", "stretching energy of the edge; 0 in inextensible rods")

/* Numbers of the fields, HB_FIELD_position ..., and their bits in sets of fields. */
typedef enum hb_field_number {
#define HB_DECLARE(name, components, location, unit, text) HB_FIELD_##name,
  HB_FRAME_FIELDS(HB_DECLARE)
#undef HB_DECLARE
      HB_FIELD_COUNT
} hb_field_number;
#define HB_FIELD_BIT(name) ((uint64_t)1 << HB_FIELD_##name)
#define HB_FIELDS_ALL (((uint64_t)1 << HB_FIELD_COUNT) - 1)

/* Those that are measured from the state's forces. */
#define HB_FIELDS_OF_FORCES (HB_FIELD_BIT(tension) | HB_FIELD_BIT(reaction) | HB_FIELD_BIT(internal_force))

/* Sets of fields that have a name. */
typedef struct hb_field_group {
  const char *name;
  uint64_t fields;
  const char *text;
} hb_field_group;
extern const hb_field_group hb_field_groups[]; /* the first is all fields, the second those that runs write if
                                                  the scene does not choose */
extern const int hb_field_group_count;
/* The fields that trajectories of a model hold: those of its scene's output.fields, all if that is 0; always
 * the positions. */
uint64_t hb_fields_of(const hb_model *model);

/* A measured moment. Arrays run over slots as in the model; unused slots are 0. */
typedef struct hb_frame {
  uint64_t fields; /* those whose arrays were measured; the others hold what was there before */
  double time;
  long step;
  double kinetic, bending, twisting, stretching, gravity; /* energies; gravity for constant uniform fields */
  double work_loads, work_supports, dissipated; /* totals since the start; work_loads includes gravity */
  double balance; /* kinetic+bending+twisting+stretching now - at start - work + dissipated: the scheme's
                     error */
  double momentum[3], angular_momentum[3];
  double length_error, worst_length_error;
#define HB_DECLARE(name, components, location, unit, text) double *name;
  HB_FRAME_FIELDS(HB_DECLARE)
#undef HB_DECLARE
} hb_frame;

typedef struct hb_frame_field {
  const char *name;
  int components;
  hb_location location;
  const char *unit, *text;
  size_t offset; /* of the pointer inside hb_frame */
} hb_frame_field;
extern const hb_frame_field hb_frame_fields[];
extern const int hb_frame_field_count;

hb_status hb_frame_create(const hb_model *model, hb_frame **out, hb_error *err);
void hb_frame_free(hb_frame *frame);
/* Fills frame from the sim's current state. Does not change the state. */
void hb_sim_measure(hb_sim *sim, hb_frame *frame);
/* Measures states without their simulation: a thread can measure a copy (hb_state_copy) while the simulation
 * goes on. A measure belongs to one thread at a time; model must outlive it. The frame has the same bits as
 * that of hb_sim_measure. Measuring allocates nothing. */
typedef struct hb_measure hb_measure;
hb_status hb_measure_create(const hb_model *model, hb_measure **out, hb_error *err);
void hb_measure_free(hb_measure *measure);
void hb_measure_state(hb_measure *measure, const hb_state *state, hb_frame *frame);
/* From now on only these fields; at first it is all. The scalars of the frame are always measured, with the
 * same bits. */
void hb_measure_choose(hb_measure *measure, uint64_t fields);
/* Copies what measuring reads from the run to a state of the same model: cheaper than the whole state.
 * forces: also what tension, reaction and internal_force are measured from. All else in `to` stays as it is.
 */
void hb_sim_snapshot(const hb_sim *sim, bool forces, hb_state *to);
/* How a closed rod, or one whose first and last edge have prescribed frames, winds about itself, in turns.
 * The latter is closed to a ring by a path without twist that goes straight on from its last edge, far around
 * it, and straight into the first one. twist + writhe + closing is then the linking number, a whole number
 * (Calugareanu, White, Fuller; docs/theory, 9.6). While the end edges stand still, twist + writhe only
 * changes where the rod passes through itself, by 2. */
typedef struct hb_link {
  bool defined;   /* false: an end is free to turn; all else is 0 */
  double twist;   /* sum of the twists of all vertices */
  double writhe;  /* of the closed polygon */
  double closing; /* between the last director, carried along the path, and the first: -1/2 to 1/2; of a
                     closed rod by how much it was cut off where its ends meet, 0 without a cut */
  double link;    /* the whole number nearest to their sum */
  double error;   /* distance of the sum from it: round-off */
} hb_link;
bool hb_link_defined(const hb_model *model, int rod);
/* Needs position, m1 and twist in the frame. Time grows with the square of the vertices. HB_ERR_MEMORY. */
hb_status hb_frame_link(const hb_model *model, const hb_frame *frame, int rod, hb_link *out, hb_error *err);
/* The rod's own totals: kinetic, bending, twisting. */
void hb_frame_rod_energy(const hb_model *model, const hb_frame *frame, int rod, double energy[3]);
double hb_frame_rod_stretching(const hb_model *model, const hb_frame *frame,
                               int rod); /* the same of stretching */

#ifdef __cplusplus
}
#endif
#endif
