/* What integrators work on, and the moves they are made of. One rod at a time: its data stay in cache for a
 * whole step. */
#ifndef HB_TIME_STEPPER_H
#define HB_TIME_STEPPER_H

#include "base/threads.h"
#include "hebra/plug.h"
#include "lane/plan.h"
#include "rod/rod.h"
#include "solve/project.h"

#define HB_TERMS_MAX 16
/* A rod of so many strips is shared among threads: below, meeting after each pass costs more than it gains.
 */
#define HB_SHARED_STRIPS 4

/* What one thread steps with. */
typedef struct hb_lane_worker hb_lane_worker;
/* What implicit schemes step with (implicit.h). */
typedef struct hb_implicit hb_implicit;

struct hb_stepper {
  const hb_model *model;
  hb_state *state;
  const hb_force_term *const *terms; /* NULL-terminated */
  hb_rod_work rod_work;
  hb_project_work project_work;
  double *x_old, *v_old; /* 3 per slot: at the start of the step */
  double *v_predicted;   /* 3 per slot: velocities extrapolated to the end of the step */
  double *force_old;     /* 3 per prescribed vertex */
  double *torque_old;    /* per prescribed frame */
  double *still_angle;   /* per prescribed frame: its angle if that is constant, else not-a-number */
  double *follower_m1;   /* 3 per slot: directors for follower loads, or NULL */
  unsigned char *rates;  /* per rod: do its loads depend on velocity? */
  unsigned *active;      /* per rod: bit k set if terms[k] acts on it */
  unsigned *uniform;     /* the same for those that are a uniform load on it */
  hb_force_value
      *values;         /* per entry of the scene's forces: at the end of a step, for each step of a block */
  double length_error; /* largest of the last step */
  double worst_error;  /* largest of all steps of the block */
  int block;           /* steps to be taken at once, 1 to HB_BLOCK_STEPS */
  int failed_step;     /* after a failure: which of them it was, from 0 */
  int failed_unit;     /* and in which unit of the plan, -1: in none */
  hb_pool *pool;       /* threads, or NULL for one */
  hb_lane_plan *plan;  /* rods that step in lanes, or NULL */
  hb_lane_worker *workers; /* one per thread */
  hb_implicit *implicit;   /* what implicit schemes need, or NULL */
  bool lanes_current;      /* the lanes hold the state */
  bool state_current;      /* the state's arrays do */
  bool lanes_finite;       /* after a step: all forces and velocities in lanes are numbers */
  bool timed;              /* take stage times in this step */
  double stage_started;
  double stage_seconds[HB_STAGE_COUNT];
};

hb_status hb_stepper_init(hb_stepper *stepper, const hb_model *model, hb_state *state,
                          const hb_force_term *const *terms, hb_error *err);
void hb_stepper_release(hb_stepper *stepper);
/* Bytes of all that it owns: workspaces, lanes, workers, pool. */
size_t hb_stepper_memory(const hb_stepper *stepper);
/* Puts rods into lanes for the scheme that the scene names; rods that do not fit are left to be stepped one
 * by one. After hb_stepper_init. */
hb_status hb_stepper_use_lanes(hb_stepper *stepper, hb_error *err);
void hb_stepper_release_workers(hb_stepper *stepper);
/* Gets what an implicit scheme needs, for a run whose rods do not step in lanes. After hb_stepper_init. */
hb_status hb_stepper_use_implicit(hb_stepper *stepper, hb_error *err);
void hb_implicit_free(hb_implicit *implicit);
size_t hb_implicit_bytes(const hb_implicit *implicit); /* NULL: 0 */
/* May several steps be taken at once? Only if all rods step in lanes. */
bool hb_stepper_may_block(const hb_stepper *stepper);
/* Brings the state's arrays up to date with the lanes; the state may be read then. */
void hb_stepper_store(hb_stepper *stepper);
/* Copies what can be measured to another state of the model, from where it is: time and totals, positions,
 * velocities, frames, twisting moments; with forces also those. The rest of `to` stays as it is. */
void hb_stepper_snapshot(hb_stepper *stepper, bool forces, hb_state *to);
/* The formulas of loads that depend on time alone, once for all rods, at the ends of the steps of a block. */
void hb_stepper_look_at_forces(hb_stepper *stepper, double h);
/* The state may have been written to: lanes are filled anew before the next step. */
void hb_stepper_state_changed(hb_stepper *stepper);

/* Stage clock: begin restarts it, end books the time since to a stage and restarts it. Cheap if not timed. */
void hb_stepper_begin(hb_stepper *stepper);
void hb_stepper_end(hb_stepper *stepper, hb_stage stage);

/* Keeps x and v of a rod as x_old, v_old. */
void hb_stepper_keep(hb_stepper *stepper, const hb_rod *rod);
/* Puts x_old and v_old of a rod back. */
void hb_stepper_undo(hb_stepper *stepper, const hb_rod *rod);
/* v += h M^-1 force on free coordinates; with drift also x += h v. */
void hb_stepper_kick(hb_stepper *stepper, const hb_rod *rod, double h);
void hb_stepper_kick_drift(hb_stepper *stepper, const hb_rod *rod, double kick, double drift);
/* Puts prescribed vertices where they are at time t. exact: their velocity is the formula's derivative at t,
 * else the distance moved since x_old over h. */
void hb_stepper_place(hb_stepper *stepper, const hb_rod *rod, double t, double h, bool exact);
/* Elastic force, loads at time t with velocities v, into state->force and state->load. h: step for viscosity.
 */
hb_status hb_stepper_evaluate(hb_stepper *stepper, const hb_rod *rod, double t, const double *v, double h,
                              hb_error *err);
/* The second part of it: force and loads where the twist is in equilibrium already (hb_rod_settle). */
void hb_stepper_forces(hb_stepper *stepper, const hb_rod *rod, double t, const double *v);
/* Inextensibility of positions; at_old: along the gradients at x_old (SHAKE) instead of those of the iterate.
 * Books iterations and errors. */
hb_status hb_stepper_project(hb_stepper *stepper, const hb_rod *rod, double h, bool at_old, hb_error *err);
/* Half of the work that loads, supports and damping did while the rod moved from x_old to x, with the forces
 * as they are now: called once before and once after the evaluation. */
void hb_stepper_book_work(hb_stepper *stepper, const hb_rod *rod, double h);
/* After fast projection with big turns, for hb_stepper_book_supports: what the supports were pulled by if the
 * whole correction was along the edges as they are now. The multipliers of its iterates belong to other edges
 * each and may overshoot by far before they come back. kick: by which the velocities were kicked before
 * (times force). */
void hb_stepper_find_pull(hb_stepper *stepper, const hb_rod *rod, double h, double kick);
/* Work of moving supports over the step, from the momentum that they must have given. rattle: constraint
 * forces are the mean of those of the two projections of a Verlet step, else those of one fast projection. */
void hb_stepper_book_supports(hb_stepper *stepper, const hb_rod *rod, double h, bool rattle);

/* Does a support follow formulas of time at all? */
bool hb_support_moves(const hb_model *model, const hb_position_support *support);
/* A prescribed vertex at time t: position and exact velocity. base_x, base_v: of the base vertex (tangents).
 */
void hb_support_at(const hb_model *model, const hb_position_support *support, double t,
                   const double base_x[3], const double base_v[3], double x[3], double v[3]);

#endif
