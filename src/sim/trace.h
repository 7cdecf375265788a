/* Inside of a trace: the rods of a family, and the branches that wait. */
#ifndef HB_SIM_TRACE_H
#define HB_SIM_TRACE_H

#include "hebra/trace.h"
#include "sim/sim.h"
#include "statics/branch.h"

/* One rod of the family: as it is at the start of its scene, and held directors from there. */
typedef struct hb_member {
  const hb_model *model; /* NULL: none */
  hb_sim *sim;           /* NULL: nobody has asked for it yet */
  double p, t;
  double *held; /* 6 per prescribed frame: director before its turn, tangent */
  long used;    /* when it was asked for last */
} hb_member;

typedef struct hb_members {
  const hb_trace_family *family;
  hb_member kept[HB_FAMILY_KEPT];
  hb_member first; /* that all others must look like */
  long asked, made;
} hb_members;

/* hb_family.enter for a hb_members. */
hb_status hb_members_enter(void *context, double p, hb_state *state, const hb_model **model, double *t,
                           hb_error *err);
/* The member of the value p; valid until HB_FAMILY_KEPT - 1 others were asked for. */
hb_status hb_members_find(hb_members *m, double p, hb_member **out, hb_error *err);
/* Makes the sim of a member if it has none. */
hb_status hb_member_start(hb_member *member, hb_error *err);
/* The first one, which stays. Rules that every scene must keep to be traced. */
hb_status hb_members_begin(hb_members *m, const hb_trace_family *family, double p, hb_error *err);
void hb_members_free(hb_members *m);

/* A bifurcation from which branches are still to be followed. */
typedef struct hb_crossing {
  hb_branch_point at;
  double *mode;
  int number, multiplicity, branch;
} hb_crossing;

typedef struct hb_tracer {
  hb_members members;
  hb_branch b;
  const hb_trace_options *options;
  const hb_trace_sink *sink;
  hb_trace_costs costs;
  hb_branch_point here, there, special;
  hb_crossing *crossings; /* max_branches of them at most */
  int crossing_count;
  int branch;
  long index;     /* of the next point of the branch */
  int clear;      /* unstable modes where it was clear last how many there are */
  int usual;      /* neutral modes that the branch has anyhow */
  int blurred;    /* points in a row with more of them */
  int met;        /* number of a known bifurcation that the branch has come back to, or -1 */
  bool unlocated; /* a fold or bifurcation was seen, but not found */
} hb_tracer;

/* trace_walk.c: follows the branch on which t->here is. fresh: it has just left a bifurcation. */
hb_status hb_tracer_walk(hb_tracer *t, int bifurcation, int side, bool fresh, hb_error *err);
/* Tells the sink about a point. */
hb_status hb_tracer_tell(hb_tracer *t, const hb_branch_point *point, hb_trace_kind kind, int bifurcation,
                         int multiplicity, hb_error *err);

#endif
