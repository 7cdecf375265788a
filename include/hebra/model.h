/* hebra/model.h - what is simulated: definitions that a scene (or a program) fills in, and the constant
 * tables compiled from them.
 *
 * Vertices count from 0 .. nv-1, edge j joins vertices j and j+1, interior vertices are 1 .. nv-2
 * (docs/theory). A closed rod lists its first vertex once more as its last: nv - 1 vertices and as many edges
 * in truth. In the compiled model all rods lie one behind the other in one numbering of slots: vertex i of a
 * rod is slot first + i, edge j is slot first + j (the last slot of a rod holds no edge). */
#ifndef HEBRA_MODEL_H
#define HEBRA_MODEL_H

#include "hebra/base.h"
#include "hebra/formula.h"

#ifdef __cplusplus
extern "C" {
#endif

/* ---- definitions: plain data, owned by the definition, freed by hb_scene_def_free
 * --------------------------- */

typedef enum hb_support_kind {
  HB_SUPPORT_POSITION, /* a vertex: each axis is free, held, or follows a formula of t (x, y, z: initial
                          place) */
  HB_SUPPORT_TANGENT,  /* an edge's direction follows formulas of t (or is held); the base vertex must be held
                          too */
  HB_SUPPORT_ANGLE,   /* an edge's material angle, against the Bishop frame of the initial shape, formula of t
                       */
  HB_SUPPORT_DIRECTOR /* an edge's first director m1 in space, formulas of t, projected normal to the edge */
} hb_support_kind;

/* A boundary condition at any vertex or edge (rows A7 of the mission). */
typedef struct hb_support_def {
  hb_support_kind kind;
  int index; /* vertex (POSITION) or edge (others), 0-based; negative counts from the end: -1 is last */
  bool held; /* POSITION, TANGENT: as in the initial shape. ANGLE: as the relaxed initial state has it */
  bool axis_free[3]; /* POSITION: this coordinate is free */
  bool base_is_end; /* TANGENT: the base vertex is index+1 and vertex index is carried (for a rod's last edge)
                     */
  bool wall; /* TANGENT at a rod's end: the rod is clamped at its end vertex, not at the middle of the held
                edge (docs/theory, 2.7) */
  hb_formula *
      value[3]; /* POSITION x, y, z; TANGENT direction; DIRECTOR m1. Any of them of t. NULL where held/free */
  hb_formula *angle; /* ANGLE: angle in radians. DIRECTOR: extra turn about the tangent. May be NULL (0).
                        Windings count: going from 0 to 6 pi is three turns. */
  int line, column;  /* place in the scene file, 0 if none */
} hb_support_def;

/* How the two ends of a rod are joined, in the initial shape (docs/theory, 12). */
typedef enum hb_closing {
  HB_CLOSING_NONE,  /* an open rod */
  HB_CLOSING_TURNS, /* as little twist as makes the material frame meet itself, and so many turns more */
  HB_CLOSING_TWIST, /* so much twist in all, radians */
  HB_CLOSING_LINK   /* so much twist that the linking number is this */
} hb_closing;

/* One rod. Arrays have nv entries per vertex, nv-1 per edge. */
typedef struct hb_rod_def {
  char *name;
  int nv; /* >= 3; of a closed rod >= 4, since its first vertex is the last once more (in the initial shape;
             the rest shape may be open, the vertex of the joint then has the mean of what its neighbours
             have at rest). What belongs to that vertex (mass, moduli) is the mean of both entries, the mass
             their sum */
  double *rest; /* 3 nv: rest shape; gives rest lengths, rest curvature, and (with rest_m1) natural twist */
  double *rest_m1; /* 3 (nv-1) first directors on the rest shape, projected and normalised; NULL: Bishop frame
                      of the rest shape, turned by natural_twist */
  double *natural_twist; /* nv: twist per length at interior vertices (radians per length); NULL: 0 */
  double *initial;       /* 3 nv: initial shape */
  double *velocity;      /* 3 nv: initial velocity; NULL: at rest */
  double *mass;          /* nv: > 0 */
  double *B;             /* 3 (nv-1): B11, B12, B22 of edge j in its material frame; positive semi-definite */
  double *beta;          /* nv: twisting modulus at interior vertices, >= 0 */
  double *stretching;    /* nv-1: E A of edge j, > 0; NULL: the rod is inextensible */
  double *viscosity;     /* nv-1: bending-rate viscosity, same unit as B times time; NULL: 0 */
  double mass_damping;   /* 1/time: force -c m v */
  double first_director[3];  /* m1 of the first edge in the initial shape (projected); 0,0,0: chosen by the
                                library */
  bool straight_rest;        /* rest curvature taken as zero whatever `rest` is: only its lengths count */
  bool lengths_from_initial; /* rest lengths = edge lengths of the initial shape */
  hb_closing closing;
  double closing_value; /* turns, radians or linking number */
  double radius;        /* for drawing and for drag on a thickness, > 0 */
  hb_support_def *supports;
  int support_count;
  int line, column;
} hb_rod_def;

typedef enum hb_force_kind {
  HB_FORCE_GRAVITY,     /* value = acceleration */
  HB_FORCE_POINT,       /* value = force on one vertex */
  HB_FORCE_DISTRIBUTED, /* value = force per length; acts with the Voronoi length of each vertex */
  HB_FORCE_PER_VERTEX,  /* value = force on every vertex (as the thesis's F_ext) */
  HB_FORCE_WIND         /* value = velocity of the medium; drag by `normal`, `tangential` coefficients */
} hb_force_kind;

/* A load. Components are formulas of t and place (x, y, z now) and s, u, i, L. */
typedef struct hb_force_def {
  hb_force_kind kind;
  int rod;              /* index of the first rod, or -1 for every rod */
  int rods;             /* how many rods from there on; 0 counts as 1 */
  int vertex;           /* POINT: vertex, negative from the end */
  hb_formula *value[3]; /* in space, or along (t, m1, m2) of the rod where follower */
  bool follower;        /* POINT, DISTRIBUTED, PER_VERTEX: turns with the material frame */
  double linear[2];     /* WIND: force per length = -linear * relative velocity, [normal, tangential] */
  double quadratic[2];  /* WIND: force per length = -quadratic * |w| w of the normal and tangential part */
  double per_radius[2]; /* WIND: what the rod's radius adds to quadratic, per length of the radius */
  int line, column;
} hb_force_def;

typedef enum hb_length_tolerance_kind {
  HB_TOLERANCE_RELATIVE, /* max |C_j| / |rest e^j| */
  HB_TOLERANCE_ABSOLUTE  /* max |C_j|, as the thesis printed it */
} hb_length_tolerance_kind;

/* How rods are stepped; the answers are the same to round-off, and those of the first two to the last bit. */
typedef enum hb_lane_choice {
  HB_LANES_BEST,     /* many vertices at a time, with all instructions that the processor has */
  HB_LANES_PORTABLE, /* without special instructions */
  HB_LANES_OFF       /* vertex by vertex */
} hb_lane_choice;

typedef enum hb_precision {
  HB_PRECISION_DOUBLE,
  HB_PRECISION_SINGLE /* the step in float: faster, for pictures; length tolerances from 1e-6 on only */
} hb_precision;

typedef struct hb_method_def {
  char *integrator;        /* "symplectic-euler", "verlet", "implicit" or "backward-euler" */
  double time_step;        /* > 0 */
  double duration;         /* >= 0 */
  double length_tolerance; /* default 1e-10 (a scene file with precision single: 1e-5) */
  hb_length_tolerance_kind length_tolerance_kind;
  double error_tolerance; /* implicit schemes: largest error of a position per piece of a step, over the rod's
                             length; default 0: steps are taken whole */
  int max_projections;    /* iterations before giving up, default 100 */
  int max_twist_iterations; /* default 100 */
  hb_lane_choice lanes;     /* no key of a scene: the program's to choose */
  hb_precision precision;   /* default double */
  int threads; /* of a run, >= 1; 0: as many as the machine has processors. Not part of a scene file */
  int line, column;
} hb_method_def;

/* Is it one of the schemes that are stable at any step? */
bool hb_method_is_implicit(const hb_method_def *method);

typedef struct hb_output_def {
  int every;                 /* steps between frames, >= 1 */
  double checkpoint_seconds; /* wall seconds between checkpoints, default 2; 0: at every frame */
  uint64_t fields;           /* HB_FIELD_BIT of those that the trajectory holds; 0: not said */
  bool single;               /* fields in the trajectory are floats */
  bool link;                 /* look at the link of every rod that has one in every frame */
} hb_output_def;

/* A branch of equilibria over a parameter (hebra/trace.h). */
typedef struct hb_trace_def {
  char *parameter;      /* its name, or "t"; NULL: the scene asks for no branch */
  double from, to;      /* different */
  double step;          /* longest step, > 0, <= 1 */
  int points, branches; /* at most */
  int line, column;
} hb_trace_def;

/* A whole scene. */
typedef struct hb_scene_def {
  char *title, *description, *path; /* path of the scene file, may be NULL */
  char *source; /* the scene file's text with --set applied, kept in the output; may be NULL */
  hb_parameter *parameters;
  int parameter_count;
  hb_rod_def *rods;
  int rod_count;
  hb_force_def *forces;
  int force_count;
  hb_method_def method;
  hb_output_def output;
  hb_trace_def trace;
  uint64_t run; /* number of the run that goes on here (hb_checkpoint.run); 0: a new run */
} hb_scene_def;

/* Arrays and strings in a definition come from malloc: hb_scene_def_free gives them to free. */
/* Sets every default (strings NULL, integrator "verlet" allocated on demand: NULL means "verlet"). */
void hb_scene_def_init(hb_scene_def *def);
void hb_rod_def_init(hb_rod_def *def);
void hb_force_def_init(hb_force_def *def);
void hb_support_def_init(hb_support_def *def);
/* Does the load act on the rod of this index? */
static inline bool hb_force_def_acts_on(const hb_force_def *def, int rod) {
  return def->rod < 0 || (rod >= def->rod && rod - def->rod < (def->rods > 1 ? def->rods : 1));
}
/* WIND: coefficient of |w| w on a rod, c = 0 normal, 1 tangential. */
static inline double hb_force_def_quadratic(const hb_force_def *def, const hb_rod_def *rod, int c) {
  return def->quadratic[c] + def->per_radius[c] * rod->radius;
}
void hb_scene_def_free(hb_scene_def *def); /* frees everything inside, also formulas; not the struct itself */

/* ---- compiled model: constant during a run, shared between threads
 * ------------------------------------------ */

typedef struct hb_rod {
  const char *name;
  int index, first, nv;
  bool closed;      /* vertex nv - 1 is vertex 0: each of the two slots holds half of it */
  int last_joint;   /* vertices 1 .. last_joint bend and twist: nv - 2, of a closed rod nv - 1 */
  bool closed_form; /* isotropic, straight at rest, no viscosity: twist in closed form */
  bool extensible;  /* edges are springs; no constraint keeps their lengths */
  bool twist_free;  /* closed_form and no span has both ends held: no twisting moment ever */
  double length;    /* rest length */
  int first_span, span_count;
  int first_frame, frame_count;       /* its entries in frames, in order of edges */
  int first_position, position_count; /* its entries in positions, bases before what hangs on them */
  int first_force, force_count;       /* its entries in rod_forces */
} hb_rod;

/* A stretch of a rod between neighbouring edges whose material frame is prescribed, or a rod's end. That of a
 * closed rod leads once around it: its last edge, in the slot behind all edges, is the first. */
typedef struct hb_span {
  int rod;
  int first_edge, last_edge;   /* slots; the span's interior vertices are first_edge+1 .. last_edge */
  int first_frame, last_frame; /* index into frames, or -1: stress-free end, or joined to the other one */
  int first_panel,
      panel_count;      /* panels of at most HB_PANEL_EDGES edges; 0 where the span carries no twist */
  double compliance;    /* sum of l_i / (2 beta_i) */
  double natural_twist; /* sum of rest twists */
} hb_span;
#define HB_PANEL_EDGES 64

/* Edges from .. to of a span; the director at `to` is carried in time so that windings are never lost. */
typedef struct hb_panel {
  int from, to;
} hb_panel;

typedef struct hb_position_support {
  int slot; /* vertex */
  const hb_support_def *def;
  bool tangent;   /* this vertex is placed along a prescribed tangent from base */
  int base, edge; /* tangent: base vertex slot and edge slot; sign: +1 vertex = base + l t, -1 base - l t */
  double sign;
  bool fixed[3];
  double initial[3];
} hb_position_support;

typedef struct hb_frame_support {
  int slot; /* edge */
  const hb_support_def *def;
} hb_frame_support;

typedef struct hb_model {
  const hb_scene_def *def; /* must outlive the model */
  int rod_count, nv;       /* nv: slots in all */
  hb_rod *rods;
  /* one entry per slot (or 2, 3, 4 where said) */
  int *rod_of;
  double *rest_length, *inv_rest_length; /* |e-bar^j|; 0 at a rod's last slot */
  double *arc;                           /* arc length of vertices in the rest shape */
  double *voronoi; /* l_i = |e-bar^{i-1}| + |e-bar^i|; 0 at end vertices; beside a wall: 2.7 */
  double *weight;  /* length that belongs to a vertex: l_i/2, half an edge at ends */
  double *mass;
  double *inv_mass;   /* 3 per slot: 0 for a prescribed coordinate */
  double *alpha;      /* bending modulus at interior vertices (closed-form rods) */
  double *bend_gain;  /* 8 alpha_i / l_i: the only bending number a closed-form step needs */
  double *B;          /* 3 per edge slot: B11 B12 B22 */
  double *stretching; /* per edge slot: E A; 0 where the length is kept */
  double *viscosity;  /* per edge slot */
  double *beta;       /* interior vertices */
  double *twist_gain; /* 2 beta_i / l_i */
  double *rest_twist; /* m-bar_i */
  double *rest_omega; /* 4 per interior vertex: omega-bar_i^{i-1} (2), omega-bar_i^i (2) */
  double *rest_pull;  /* 4: B^j omega-bar_i^j */
  double *start_m1;   /* 3 per rod: u^0, director of the first Bishop frame of the initial shape */
  hb_span *spans;
  int span_count;
  hb_panel *panels;
  int panel_count;
  hb_position_support *positions;
  int position_count;
  hb_frame_support *frames;
  int frame_count;
  int *frame_of;   /* per edge slot: index into frames or -1 */
  int *rod_forces; /* indices into the scene's forces, rod by rod: those that act on it, in their order */
  bool any_general, any_viscosity, any_follower;
  double *initial; /* 3 per slot: the initial shape as given, supports at t = 0 in their places */
  char **notes;    /* sentences that check and run show, e.g. "constraints leave no room" */
  int note_count;
} hb_model;

/* The n-th of the scene's forces that act on the rod, n < rod->force_count. */
static inline const hb_force_def *hb_rod_force_def(const hb_model *model, const hb_rod *rod, int n) {
  return &model->def->forces[model->rod_forces[rod->first_force + n]];
}

/* Checks every rule and compiles. def stays owned by the caller and must outlive the model. */
hb_status hb_model_create(const hb_scene_def *def, hb_model **out, hb_error *err);
void hb_model_free(hb_model *model);

/* Estimate of the largest time step that the explicit schemes bear (docs/theory, 7.6): bending waves, twist,
 * tension from the loads and speeds at the start, waves of stretching, viscosity, damping. rod: gets the rod
 * that limits it, NULL allowed. INFINITY if nothing limits it: without bending, damping, loads and motion
 * there is no estimate, and implicit schemes have no limit. */
double hb_model_stable_step(const hb_model *model, int *rod);

#ifdef __cplusplus
}
#endif
#endif
