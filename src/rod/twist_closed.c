/* Quasi-static twist of rods that are isotropic and straight at rest: uniform, in closed form
 * (docs/theory, 3.2). */
#include "rod/rod.h"

#include "math/rotation.h"

/* The rotation that parallel transport from edge a to edge b amounts to, as a product of (1 + t.t', t x t'),
 * which is 2 cos(phi/2) times the half-angle quaternion: the norm does not matter. At most HB_PANEL_EDGES
 * factors of norm <= 2. */
static hb_quat transport_along(const hb_rod_work *w, int a, int b) {
  hb_quat q = {1, {0, 0, 0}};
  hb_v3 t = hb_v3_load(w->tangent + 3 * a);
  for (int j = a + 1; j <= b; j++) {
    hb_v3 next = hb_v3_load(w->tangent + 3 * j);
    double chi = 1 + hb_v3_dot(t, next);
    if (!(chi > HB_FOLD_LIMIT)) { /* a fold: any half turn that reverses t will do; the step reports it */
      q = hb_quat_mul((hb_quat){0, hb_any_normal(t)}, q);
    } else {
      q = hb_quat_mul((hb_quat){chi, hb_v3_cross(t, next)}, q);
    }
    t = next;
  }
  return q;
}

/* Twist over one panel: from director d at its first edge, carried by turn, to director e at its last edge
 * with tangent t, nearest to what it was. */
static double panel_twist(hb_quat turn, hb_v3 t, hb_v3 d, hb_v3 e, double expected) {
  return hb_nearest_angle(hb_angle_about(hb_quat_rotate(turn, d), e, t), expected);
}

/* Twist of the spans between prescribed frames and the moment that goes with it: m_i/l_i beta_i is constant.
 */
void hb_twist_closed(const hb_model *model, const hb_rod *rod, hb_state *state, hb_rod_work *work,
                     const hb_quat *turns) {
  for (int s = rod->first_span; s < rod->first_span + rod->span_count; s++) {
    const hb_span *span = &model->spans[s];
    state->moment[s] = 0;
    if (span->panel_count == 0) continue;
    /* once around a closed rod: from the anchor on its first edge to the anchor, past the cut */
    const double *start =
        rod->closed ? state->anchor_m1 + 3 * rod->index : work->frame_now + 3 * span->first_frame;
    hb_v3 d = hb_v3_load(start);
    double total = 0;
    for (int k = 0; k < span->panel_count; k++) {
      int p = span->first_panel + k;
      bool last = k == span->panel_count - 1;
      int from = model->panels[p].from - rod->first, to = model->panels[p].to - rod->first;
      double expected = state->panel_twist[p];
      hb_v3 t = hb_v3_load(work->tangent + 3 * to), e;
      if (k == 0 && !rod->closed) expected -= work->frame_turned[span->first_frame];
      if (last && rod->closed) {
        e = hb_turn(hb_v3_load(start), t, state->seam[rod->index]);
      } else if (last) {
        expected += work->frame_turned[span->last_frame];
        e = hb_v3_load(work->frame_now + 3 * span->last_frame);
      } else {
        e = hb_carry(hb_v3_load(state->panel_m1 + 3 * p), hb_v3_load(state->panel_tangent + 3 * p), t);
      }
      hb_quat turn = turns ? turns[p] : transport_along(work, from, to);
      state->panel_twist[p] = panel_twist(turn, t, d, e, expected);
      hb_v3_store(state->panel_m1 + 3 * p, e);
      hb_v3_store(state->panel_tangent + 3 * p, t);
      total += state->panel_twist[p];
      d = e;
    }
    state->moment[s] = (total - span->natural_twist) / span->compliance;
  }
}
