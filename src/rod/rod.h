/* The discrete rod: geometry, frames, quasi-static twist, elastic forces (docs/theory, chapters 2 to 5).
 *
 * All functions work on one rod and allocate nothing. Arrays of model and state run over the slots of the
 * whole model; arrays of the workspace belong to the rod at hand and count its own vertices and edges from 0.
 */
#ifndef HB_ROD_ROD_H
#define HB_ROD_ROD_H

#include "hebra/model.h"
#include "hebra/state.h"
#include "math/rotation.h"

/* What is known about one rod at the current positions. Big enough for the longest rod. */
typedef struct hb_rod_work {
  /* per edge; of a closed rod the first edge once more behind the last, as far as joints see edges */
  double *tangent;    /* 3 per edge: t^j */
  double *inv_length; /* per edge: 1/|e^j| */
  double *m1;         /* 3 per edge: material directors of closed-form rods, where they are asked for */
  /* general rods only */
  double *kb;     /* 3 per vertex: (kappa b)_i */
  double *omega;  /* 4 per vertex: omega_i^{i-1}, omega_i^i */
  double *moment; /* per vertex: M_i = 2 beta_i (m_i - rest)/l_i */
  double *stress; /* 4 per vertex: B^j omega_i^j - pull, what the bending energy's gradient is made of */
  double *B_now;  /* 3 per edge: B, plus viscosity over the step where there is any */
  double *pull;   /* 4 per vertex: B omega-bar, plus what viscosity draws to */
  double *gradient, *diagonal, *bending_diagonal, *off_diagonal, *delta, *pivot,
      *corner;         /* per edge: twist Newton */
  double *trial_m1;    /* 3 per edge */
  double *trial_twist; /* per vertex */
  bool *held;          /* per edge: frame prescribed */
  bool convex;         /* the last Newton step of the twist saw a positive definite Hessian */
  /* per prescribed frame of the whole model */
  double *frame_now;    /* 3: the director now */
  double *frame_turned; /* how far it was turned since the last call */
  double lowest_chi;    /* smallest 1 + t.t' of the last elastic force: near 0 where the rod folds back */
  double *block;
  size_t bytes;
} hb_rod_work;

hb_status hb_rod_work_create(const hb_model *model, hb_rod_work *work, hb_error *err);
void hb_rod_work_free(hb_rod_work *work);

/* geometry.c */
/* Tangents and inverse lengths at x. Returns false if an edge has length zero or a coordinate is not finite.
 */
bool hb_rod_geometry(const hb_rod *rod, const double *x, hb_rod_work *work);
/* First vertex where two edges fold back on each other (1 + t.t' below HB_FOLD_LIMIT), or -1. */
int hb_rod_find_fold(const hb_rod *rod, const hb_rod_work *work);

/* frames.c: after hb_rod_geometry */
/* HB_ERR_NUMERIC if a prescribed angle or director means nothing at time t. */
hb_status hb_frames_check(const hb_model *model, const hb_rod *rod, const hb_rod_work *work, double t,
                          hb_error *err);
/* Prescribed directors at time t, anchor of the Bishop frame. */
void hb_frames_hold(const hb_model *model, const hb_rod *rod, hb_state *state, hb_rod_work *work, double t);
/* Prescribed directors as the state has them, into work->frame_now. */
void hb_frames_now(const hb_model *model, const hb_rod *rod, const hb_state *state, hb_rod_work *work);
/* Initial frames and windings at time 0: fills every frame field of the state; the twist is still a first
 * guess. */
void hb_frames_start(const hb_model *model, const hb_rod *rod, hb_state *state, hb_rod_work *work);
/* Directors of all edges of a closed-form rod into work->m1 (uniform twist over its spans). */
void hb_frames_closed(const hb_model *model, const hb_rod *rod, const hb_state *state, hb_rod_work *work);
/* Bishop directors along the rod from u0 on edge 0, into out (3 per edge). */
void hb_frames_bishop(const hb_rod *rod, const hb_rod_work *work, const double u0[3], double *out);

/* twist_closed.c: after hb_frames_hold. Twist and moment of each span in closed form. turns: transport along
 * each panel of the model where it is known (then only tangents at panels' far ends are read), or NULL. */
void hb_twist_closed(const hb_model *model, const hb_rod *rod, hb_state *state, hb_rod_work *work,
                     const hb_quat *turns);

/* twist_newton.c: after hb_frames_hold. Carries the frames to the current tangents and minimises the energy
 * over the material angles. h: step for viscosity, 0: none. Adds its iterations to the state's counter. */
hb_status hb_twist_newton(const hb_model *model, const hb_rod *rod, hb_state *state, hb_rod_work *work,
                          double h, hb_error *err);
/* The same without carrying: the frames are a guess at the current positions (start of a run). */
hb_status hb_twist_relax(const hb_model *model, const hb_rod *rod, hb_state *state, hb_rod_work *work,
                         hb_error *err);
/* Newton from frames that are at the current tangents already, twists with the right windings. */
hb_status hb_twist_resume(const hb_model *model, const hb_rod *rod, hb_state *state, hb_rod_work *work,
                          hb_error *err);
/* theta^0 follows the director m1 of the first edge, against the anchor. */
void hb_twist_first_angle(const hb_rod *rod, hb_state *state, const double m1[3], const hb_rod_work *work);
/* Turns all frames of a rod without prescribed frames by the one of 16 angles that has the least energy. */
void hb_twist_scan(const hb_model *model, const hb_rod *rod, hb_state *state, hb_rod_work *work);
/* Largest |dE/dtheta^j| over free edges and the scale it is to be compared with, at the last solve's frames.
 */
void hb_twist_residual(const hb_rod *rod, const hb_rod_work *work, double *residual, double *scale);

/* elastic.c: after the twist. Writes (not adds) the elastic force on the rod's vertices into f. */
void hb_elastic_closed(const hb_model *model, const hb_rod *rod, const hb_state *state, hb_rod_work *work,
                       double *f);
void hb_elastic_general(const hb_model *model, const hb_rod *rod, const hb_state *state, hb_rod_work *work,
                        double *f);
/* Shifts the history of material curvatures by one step; returns the energy dissipated over the step h. */
double hb_elastic_commit(const hb_model *model, const hb_rod *rod, hb_state *state, const hb_rod_work *work,
                         double h);

/* stretch.c: extensible rods; nothing where the rod is none. After hb_rod_geometry. */
/* |e|/|e-bar| - 1 of edge slot k, from 1/|e|. */
static inline double hb_stretch_strain(const hb_model *model, int k, double inv_length) {
  return model->inv_rest_length[k] / inv_length - 1;
}
/* Adds the force of stretching on the rod's vertices to f. */
void hb_stretch_force(const hb_model *model, const hb_rod *rod, const hb_rod_work *work, double *f);
double hb_stretch_energy(const hb_model *model, const hb_rod *rod, const hb_rod_work *work);

/* evaluate.c */
/* Geometry, prescribed frames and quasi-static twist of one rod at time t and the state's positions. h as
 * above. */
hb_status hb_rod_settle(const hb_model *model, const hb_rod *rod, hb_state *state, hb_rod_work *work,
                        double t, double h, hb_error *err);
/* The two slots of the vertex where a closed rod's ends meet (f: 3 per slot of the model) get half of their
 * sum each. Once more changes nothing. */
void hb_rod_share_seam(const hb_rod *rod, double *f);
/* After that: its elastic force into state->force, torques of supports into state->frame_torque. */
void hb_rod_force(const hb_model *model, const hb_rod *rod, hb_state *state, hb_rod_work *work);
/* Torque of the support on prescribed frame k, after hb_rod_settle and, for general rods, before the next
 * look at the twist. */
double hb_rod_frame_torque(const hb_model *model, const hb_rod *rod, const hb_state *state,
                           const hb_rod_work *work, int frame);

#endif
