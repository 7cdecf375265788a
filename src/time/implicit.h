/* Implicit steps (docs/theory, 13): what they work on, and the three layers that they are made of. The step
 * of a rod is divided into pieces (march.c), a piece into stages (stages.c), a stage is solved by Newton's
 * method (newton.c). */
#ifndef HB_TIME_IMPLICIT_H
#define HB_TIME_IMPLICIT_H

#include "solve/kkt.h"
#include "time/stepper.h"

/* Position, velocity, acceleration at one time; 3 per slot each. */
typedef struct hb_instant {
  double *x, *v, *a;
} hb_instant;

/* One stage on its way: with the forces at its end, (displacement from the start of the piece) = reach + ch v
 * and v = speed + ch a there. */
typedef struct hb_stage_now {
  double t;        /* at its end */
  double ch;       /* part of the step that is taken implicitly */
  double duration; /* from the end of the stage before to its own */
} hb_stage_now;

/* Why a stage was not solved. */
typedef enum hb_trouble_kind {
  HB_TROUBLE_NONE,
  HB_TROUBLE_PLACE,    /* frames or twist have no value where it starts */
  HB_TROUBLE_LOAD,     /* nor has a load */
  HB_TROUBLE_FOLD,     /* the rod folds back onto itself there */
  HB_TROUBLE_UNSTABLE, /* the motion grows faster than the step can see */
  HB_TROUBLE_STUCK,    /* no step of Newton's comes nearer */
  HB_TROUBLE_SLOW      /* too many iterations */
} hb_trouble_kind;
typedef struct hb_trouble {
  hb_trouble_kind kind;
  int iterations;
  double residual; /* largest unbalanced force at the last look */
  int vertex;      /* where that is, or what the kind is about, slot */
  double t;
  hb_error cause; /* HB_TROUBLE_PLACE: in words */
} hb_trouble;

/* What one thread steps with. */
typedef struct hb_marcher {
  hb_stepper stepper; /* with workspaces of its own, on the state below */
  hb_state state;     /* the run's, but with totals of its own */
  double totals[HB_S_COUNT];
  hb_rod_work rod_work;
  hb_project_work project_work;
  hb_kkt kkt;
  double *direction; /* per unknown: the step of Newton's method */
  double *drag;      /* 9 per vertex */
  double factored;   /* ch that the factors were made for; 0: there are none */
  double neutral;    /* stiffness per weight that keeps turns which cost nothing in their places */
  double tolerance;  /* turn of an edge that is as good as none */
  double worst;      /* largest |C_j| at the last look, in units of the length tolerance */
  hb_trouble trouble;
  int failed; /* first rod that failed, or -1 */
  hb_status status;
  hb_error err;
} hb_marcher;

/* For all rods; arrays run over the slots of the model, each rod writes its own. */
struct hb_implicit {
  bool second_order;
  hb_state *begin, *kept;        /* the state where the piece, and where the stage began */
  hb_instant start, middle, end; /* of the piece */
  double *reach, *speed;         /* 3 per slot: see hb_stage_now */
  double *now, *moved;   /* 3 per slot: displacements from the start of the piece, at the iterate of Newton's
method and at a trial; velocities are differences of them, not of positions: no cancellation */
  double *lambda, *pull; /* per slot: multipliers of the lengths at the iterate and at a trial */
  double *given;         /* 3 per slot: accelerations of prescribed coordinates */
  double *balance;       /* 3 per slot: force and pull of the edges together */
  double *load_old;      /* 3 per slot: loads where the stage began */
  double *omega_start;   /* 4 per slot, rods with viscosity: material curvatures at the start, */
  double *omega_now;     /* where the last stage ended, */
  double *rate_start, *rate_middle, *rate_end; /* and their rates */
  double *reaction, *reaction_old; /* 3 per prescribed vertex: last known, and where the stage began */
  double *torque_old;              /* per prescribed frame: where the stage began */
  double *totals;                  /* HB_S_COUNT per rod: what its step adds to the running totals */
  double *length_error;            /* per rod */
  double *block;
  size_t bytes;
  hb_pool *pool;
  hb_marcher *marchers; /* one per thread */
};

/* newton.c: solves one stage for the rod, from the displacements guessed in im->now and im->lambda
 * (prescribed vertices in their places) and the state kept in im->kept. On true the state is at the solution,
 * with its forces. */
bool hb_march_solve(hb_marcher *w, const hb_rod *rod, const hb_stage_now *stage);

/* stages.c: takes one piece of a step, from the state at time `from` over h; to: the time at its end. Books
 * work. error: the estimate of the largest error of a position that it makes, over the rod's length. False:
 * w->trouble says why, the state is undone. */
bool hb_march_piece(hb_marcher *w, const hb_rod *rod, double from, double to, double *error);

/* march.c: one rod over a step that ends at time t. */
hb_status hb_march_rod(hb_marcher *w, const hb_rod *rod, double t, double h, hb_error *err);

#endif
