/* Frames from a measured moment: positions, directors and twists as an output has them. */
#include "rod/resume.h"

#include "math/rotation.h"

#include <string.h>

/* A cut by less than this is none: the round-off of what was measured. */
#define WHOLE 1e-9

/* A prescribed angle at time t. */
static double angle_at(const hb_frame_support *f, double t) {
  double vars[HB_VAR_COUNT] = {0};
  vars[HB_VAR_T] = t;
  return f->def->angle ? hb_formula_eval(f->def->angle, vars) : 0;
}

/* The turn past which the frames of a closed rod meet: total twist beyond what the Bishop frame lacks. */
static double cut_of(const hb_rod *rod, const hb_rod_work *work, const double *u0, const double *twist) {
  int n = rod->nv - 1;
  hb_v3 u = hb_v3_load(u0), t = hb_v3_load(work->tangent);
  double total = 0;
  for (int i = 1; i <= n; i++) {
    hb_v3 next = hb_v3_load(work->tangent + 3 * i);
    u = hb_carry(u, t, next);
    t = next;
    total += twist[rod->first + i];
  }
  double cut = hb_nearest_angle(total - hb_angle_about(u, hb_v3_load(u0), t), 0);
  return fabs(cut) < WHOLE ? 0 : cut;
}

/* Held directors before their prescribed turning; witnesses of the panels with the twist that they span. */
void hb_frames_resume(const hb_model *model, const hb_rod *rod, hb_state *state, const hb_rod_work *work,
                      double t, const double *m1, const double *twist, const double *u0, double theta_0) {
  int o = rod->first;
  memcpy(state->anchor_m1 + 3 * rod->index, u0, 3 * sizeof *u0);
  memcpy(state->anchor_tangent + 3 * rod->index, work->tangent, 3 * sizeof *u0);
  state->theta_0[rod->index] = theta_0;
  if (rod->closed) state->seam[rod->index] = cut_of(rod, work, u0, twist);
  for (int k = rod->first_frame; k < rod->first_frame + rod->frame_count; k++) {
    const hb_frame_support *f = &model->frames[k];
    int j = f->slot - o;
    hb_v3 tangent = hb_v3_load(work->tangent + 3 * j);
    double angle = angle_at(f, t), turned = f->def->kind == HB_SUPPORT_ANGLE ? angle - angle_at(f, 0) : angle;
    hb_v3 now = hb_project_normal(hb_v3_load(m1 + 3 * f->slot), tangent);
    state->frame_angle[k] = angle;
    hb_v3_store(state->frame_m1 + 3 * k, hb_turn(now, tangent, -turned));
    hb_v3_store(state->frame_tangent + 3 * k, tangent);
  }
  for (int s = rod->first_span; s < rod->first_span + rod->span_count; s++)
    for (int p = model->spans[s].first_panel; p < model->spans[s].first_panel + model->spans[s].panel_count;
         p++) {
      int to = model->panels[p].to;
      hb_v3 tangent = hb_v3_load(work->tangent + 3 * (to - o));
      hb_v3_store(state->panel_m1 + 3 * p, hb_project_normal(hb_v3_load(m1 + 3 * to), tangent));
      hb_v3_store(state->panel_tangent + 3 * p, tangent);
      state->panel_twist[p] = 0;
      for (int k = model->panels[p].from + 1; k <= to; k++) state->panel_twist[p] += twist[k];
    }
  if (rod->closed_form) return;
  for (int j = 0; j <= rod->last_joint; j++) {
    hb_v3 tangent = hb_v3_load(work->tangent + 3 * j);
    hb_v3_store(state->m1 + 3 * (o + j), hb_project_normal(hb_v3_load(m1 + 3 * (o + j)), tangent));
    hb_v3_store(state->tangent + 3 * (o + j), tangent);
    state->twist[o + j] = j > 0 ? twist[o + j] : 0;
    state->spin[o + j] = 0;
  }
}
