/* hebra/plug.h - the three small interfaces through which parts meet.
 *
 * A new effect is one file that exports one const object, one line in the list in src/sim/builtin.c, and it
 * is swept by the contract tests from then on. */
#ifndef HEBRA_PLUG_H
#define HEBRA_PLUG_H

#include "hebra/state.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Stages of a step, for timings. */
typedef enum hb_stage {
  HB_STAGE_TWIST,   /* frames and quasi-static twist */
  HB_STAGE_ELASTIC, /* bending and twisting forces */
  HB_STAGE_LOADS,   /* gravity, loads, wind, damping */
  HB_STAGE_MOVE,    /* kick, drift, supports */
  HB_STAGE_PROJECT, /* inextensibility */
  HB_STAGE_COUNT
} hb_stage;
extern const char *const hb_stage_names[HB_STAGE_COUNT];

/* The formulas of one entry of hb_scene_def.forces at one time. */
typedef struct hb_force_value {
  bool uniform; /* they depend on time alone; else value means nothing */
  double value[3];
} hb_force_value;

/* A load that is the same law at every vertex of a rod: on a vertex of mass m to which the length w belongs
 * (hb_model.weight), moving with v,
 *   m acceleration + w per_length + per_vertex - w D(v - medium)
 * with the drag D of wind (docs/theory, 8.3), and -damping m v, which counts as dissipation. */
typedef struct hb_uniform_load {
  double acceleration[3], per_length[3], per_vertex[3];
  double medium[3];               /* velocity of the medium */
  double linear[2], quadratic[2]; /* drag per length: normal, tangential */
  double damping;                 /* 1/time */
} hb_uniform_load;

/* External loads: a force on the vertices that depends on time, place and velocity. */
typedef struct hb_force_term {
  const char *name, *text;
  /* Is there anything to do for this rod? */
  bool (*active)(const hb_model *model, const hb_rod *rod);
  /* Adds the force on one rod at time t to f. x, v, f, m1: 3 per slot of the whole model; only the rod's
   * slots are read and written. m1 (first directors) is NULL unless the model has follower loads. */
  void (*add)(const hb_model *model, const hb_rod *rod, double t, const double *x, const double *v,
              const double *m1, double *f);
  /* Potential energy of one rod, if the force has one that is a function of x (and t) alone; NULL otherwise.
   */
  double (*energy)(const hb_model *model, const hb_rod *rod, double t, const double *x);
  bool uses_velocity; /* depends on v: second-order schemes then extrapolate the velocities */
  bool dissipative;   /* its work counts as dissipated energy, not as work of loads */
  /* The way past `add` for rods that step in lanes. If all that the term does on this rod is a uniform load:
   * adds it to sum and returns true. values: one per entry of model->def->forces. Else returns false,
   * whatever sum holds then; the answer depends on the rod and on values[].uniform only. NULL: never. */
  bool (*uniform)(const hb_model *model, const hb_rod *rod, const hb_force_value *values,
                  hb_uniform_load *sum);
} hb_force_term;

/* A set of scalar constraints C(x) = 0 with tridiagonal coupling along each rod. */
typedef struct hb_constraint {
  const char *name, *text;
  /* Number of rows on one rod. */
  int (*count)(const hb_model *model, const hb_rod *rod);
  /* values[row] and, where not NULL, rows[6*row]: derivative by the vertices row and row+1 of the rod. */
  void (*evaluate)(const hb_model *model, const hb_rod *rod, const double *x, double *values, double *rows);
} hb_constraint;

/* What an integrator works on: model, state, workspace, force evaluation (src/time/stepper.h). */
typedef struct hb_stepper hb_stepper;

/* A time integrator. */
typedef struct hb_integrator {
  const char *name, *text;
  int order;      /* claimed order of convergence */
  bool symmetric; /* conserves angular momentum to round-off and shows no energy drift */
  bool implicit;  /* stable at any step: hb_model_stable_step is no limit. Rods never step in lanes */
  hb_status (*step)(hb_stepper *stepper, double h, hb_error *err);
} hb_integrator;

/* The lists, NULL-terminated, in the order in which parts run. */
extern const hb_force_term *const hb_force_terms[];
extern const hb_constraint *const hb_constraints[];
extern const hb_integrator *const hb_integrators[];

#ifdef __cplusplus
}
#endif
#endif
