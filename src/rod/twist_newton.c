/* Quasi-static twist of general rods: Newton on dE/dtheta^j = 0, globalised (docs/theory, 3.3).
 *
 * The unknowns are turns delta^j of the material frames about their tangents; the frames carried from the
 * last step (time-parallel) are the start, so that the minimum is followed continuously and windings are kept
 * in the twists m_i, which are unbounded real numbers. */
#include "rod/rod.h"

#include "math/rotation.h"
#include "math/small_angle.h"
#include "rod/twist_ring.h"

#include <float.h>
#include <string.h>

/* Turns longer than this are shortened: Newton's model of a cosine is no good beyond. */
#define LONGEST_TURN 1.0
/* A gradient below this part of the terms that it is made of is round-off. */
#define ROUND_OFF (16 * DBL_EPSILON)

/* A start may be far away, and each iteration goes at most LONGEST_TURN: so many times the iterations of a
 * step. */
#define START_FACTOR 100

/* What one look at the energy tells. */
typedef struct hb_look {
  double energy;    /* bending + twisting, up to a constant */
  double magnitude; /* sum of the absolute values it was made of: its round-off is this times epsilon */
  double residual;  /* max |gradient| over free edges */
  double scale;     /* what the residual's terms were made of */
  double floor;     /* gradient that one rounding of the frames themselves makes */
} hb_look;

/* omega_i^j and B omega - pull for one side of vertex i; adds to the gradient and Hessian of edge j. */
static void look_side(const hb_rod_work *w, int i, int side, double inv_l, hb_v3 kb, const double *m1,
                      hb_look *look) {
  int j = i - 1 + side;
  hb_v3 d1 = hb_v3_load(m1 + 3 * j), t = hb_v3_load(w->tangent + 3 * j);
  const double *B = w->B_now + 3 * j, *pull = w->pull + 4 * i + 2 * side;
  double o1 = hb_v3_dot(kb, hb_v3_cross(t, d1)), o2 = -hb_v3_dot(kb, d1);
  double s1 = B[0] * o1 + B[1] * o2, s2 = B[1] * o1 + B[2] * o2;
  double b1 = s1 - pull[0], b2 = s2 - pull[1];
  w->omega[4 * i + 2 * side] = o1;
  w->omega[4 * i + 2 * side + 1] = o2;
  w->stress[4 * i + 2 * side] = b1;
  w->stress[4 * i + 2 * side + 1] = b2;
  w->gradient[j] += inv_l * (o2 * b1 - o1 * b2);
  w->bending_diagonal[j] +=
      inv_l * (o2 * (B[0] * o2 - B[1] * o1) - o1 * (B[1] * o2 - B[2] * o1) - o1 * b1 - o2 * b2);
  double half = 0.5 * (o1 * s1 + o2 * s2), draw = pull[0] * o1 + pull[1] * o2;
  look->energy += inv_l * (half - draw);
  look->magnitude += inv_l * (half + fabs(draw));
  look->scale = fmax(look->scale,
                     inv_l * (fabs(o1) + fabs(o2)) * (fabs(s1) + fabs(s2) + fabs(pull[0]) + fabs(pull[1])));
}

/* Energy, gradient and Hessian at frames m1 and twists; leaves omega, stress and moments in the workspace. */
static hb_look look_at(const hb_model *m, const hb_rod *rod, hb_rod_work *w, const double *m1,
                       const double *twist) {
  int ne = rod->nv - 1, o = rod->first;
  size_t seen = (size_t)(rod->last_joint + 1);
  hb_look look = {0, 0, 0, 0, DBL_MIN};
  memset(w->gradient, 0, seen * sizeof(double));
  memset(w->bending_diagonal, 0, seen * sizeof(double));
  memset(w->diagonal, 0, seen * sizeof(double));
  for (int i = 1; i <= rod->last_joint; i++) {
    hb_v3 kb = hb_v3_load(w->kb + 3 * i);
    double inv_l = 1 / m->voronoi[o + i], gain = m->twist_gain[o + i];
    look_side(w, i, 0, inv_l, kb, m1, &look);
    look_side(w, i, 1, inv_l, kb, m1, &look);
    double excess = twist[i] - m->rest_twist[o + i], M = gain * excess;
    w->moment[i] = M;
    w->gradient[i - 1] -= M;
    w->gradient[i] += M;
    w->diagonal[i - 1] += gain;
    w->diagonal[i] += gain;
    w->off_diagonal[i] = -gain;
    look.energy += 0.5 * M * excess;
    look.magnitude += 0.5 * M * excess;
    look.floor = fmax(look.floor, 4 * DBL_EPSILON * gain);
    look.scale = fmax(look.scale, gain * (fabs(twist[i]) + fabs(m->rest_twist[o + i])));
  }
  if (rod->closed) { /* the edge behind the last is the first */
    w->gradient[0] += w->gradient[ne];
    w->bending_diagonal[0] += w->bending_diagonal[ne];
    w->diagonal[0] += w->diagonal[ne];
  }
  for (int j = 0; j < ne; j++)
    if (!w->held[j]) look.residual = fmax(look.residual, fabs(w->gradient[j]));
  return look;
}

/* L D L^T of the tridiagonal Hessian with held edges taken out; false if a pivot is not clearly positive.
 * noise: what round-off there may be in the bending parts. */
static bool solve_chain(const hb_rod *rod, hb_rod_work *w, bool convex, double shift, double noise) {
  int ne = rod->nv - 1;
  bool loose = true; /* edges of this chain so far are coupled to no held one */
  double bending_sum = 0;
  for (int j = 0; j < ne; j++) {
    double bend = w->bending_diagonal[j], link = j > 0 ? w->off_diagonal[j] : 0,
           ahead = j + 1 < ne ? w->off_diagonal[j + 1] : 0;
    if (convex && bend < 0) bend = 0;
    double pivot = w->diagonal[j] + bend + shift, right = -w->gradient[j], whole = fabs(pivot);
    if (w->held[j]) {
      w->pivot[j] = 1;
      w->delta[j] = 0;
      continue;
    }
    if (link == 0) bending_sum = 0;
    loose = link == 0 || (loose && !w->held[j - 1]);
    bending_sum += bend + shift;
    if (link != 0 && !w->held[j - 1]) {
      double ratio = link * w->pivot[j - 1];
      pivot -= ratio * link;
      right -= ratio * w->delta[j - 1];
    }
    if (loose && ahead == 0 && fabs(pivot) < HB_TWIST_SOFT * whole)
      pivot = hb_twist_soft_pivot(bending_sum, noise);
    else if (!(pivot > 1e-13 * whole) || pivot == 0)
      return false;
    w->pivot[j] = 1 / pivot;
    w->delta[j] = right;
  }
  for (int j = ne - 1; j >= 0; j--) {
    if (w->held[j]) continue;
    double next = j + 1 < ne && !w->held[j + 1] ? w->off_diagonal[j + 1] * w->delta[j + 1] : 0;
    w->delta[j] = (w->delta[j] - next) * w->pivot[j];
  }
  return true;
}

/* Open or closed. */
static bool solve_turns(const hb_rod *rod, hb_rod_work *w, bool convex, double shift, double noise) {
  return rod->closed ? hb_twist_solve_ring(rod, w, convex, shift, noise)
                     : solve_chain(rod, w, convex, shift, noise);
}

/* A descent direction: Newton's if the Hessian is positive definite, else with as little added to its
 * diagonal as makes it so (the direction of negative curvature then goes furthest: where a minimum has just
 * vanished, the way out is not crept along), else with its negative parts cut off. Shortened to LONGEST_TURN.
 * Returns the slope gradient . delta. */
static double find_direction(const hb_rod *rod, hb_rod_work *w, double noise) {
  int ne = rod->nv - 1;
  bool found = solve_turns(rod, w, false, 0, noise);
  w->convex = found;
  double largest = 0;
  for (int j = 0; j < ne; j++) largest = fmax(largest, w->diagonal[j] + fabs(w->bending_diagonal[j]));
  for (double shift = 1e-10; !found && shift < 4; shift *= shift < 1e-6 ? 100 : 4)
    found = solve_turns(rod, w, false, shift * largest, noise);
  if (!found) found = solve_turns(rod, w, true, 1e-10 * largest, noise);
  if (!found) memset(w->delta, 0, (size_t)ne * sizeof(double));
  double longest = 0, slope = 0;
  for (int j = 0; j < ne; j++) longest = fmax(longest, fabs(w->delta[j]));
  double shorten = longest > LONGEST_TURN ? LONGEST_TURN / longest : 1;
  for (int j = 0; j < ne; j++) {
    w->delta[j] *= shorten;
    if (!w->held[j]) slope += w->gradient[j] * w->delta[j];
  }
  return slope;
}

/* trial = frames turned by part * delta. */
static void turn_frames(const hb_rod *rod, hb_rod_work *w, const double *m1, const double *twist,
                        double part) {
  for (int j = 0; j + 1 < rod->nv; j++) {
    double s, c, a = part * w->delta[j];
    hb_v3 d = hb_v3_load(m1 + 3 * j), t = hb_v3_load(w->tangent + 3 * j), n = hb_v3_cross(t, d);
    hb_small_sincos(a, &s, &c);
    hb_v3_store(w->trial_m1 + 3 * j, (hb_v3){c * d.x + s * n.x, c * d.y + s * n.y, c * d.z + s * n.z});
    if (j > 0) w->trial_twist[j] = twist[j] + part * (w->delta[j] - w->delta[j - 1]);
  }
  if (!rod->closed) return;
  int n = rod->nv - 1;
  memcpy(w->trial_m1 + 3 * n, w->trial_m1, 3 * sizeof(double));
  w->trial_twist[n] = twist[n] + part * (w->delta[0] - w->delta[n - 1]);
}

/* The trial becomes what counts. */
static void accept(const hb_rod *rod, const hb_rod_work *w, double *m1, double *twist) {
  size_t seen = (size_t)(rod->last_joint + 1);
  memcpy(m1, w->trial_m1, 3 * seen * sizeof(double));
  memcpy(twist, w->trial_twist, seen * sizeof(double));
}

/* Newton until the gradient is round-off. m1, twist: the rod's part of the state, improved in place. */
static hb_status minimise(const hb_model *m, const hb_rod *rod, hb_state *state, hb_rod_work *w, int limit,
                          hb_error *err) {
  double *m1 = state->m1 + 3 * (size_t)rod->first, *twist = state->twist + rod->first;
  hb_look now = look_at(m, rod, w, m1, twist);
  w->convex = false;
  for (int k = 0;; k++) {
    if (now.residual <= ROUND_OFF * now.scale + now.floor) break;
    if (k >= limit || !isfinite(now.energy))
      return hb_fail(
          err, HB_ERR_NUMERIC,
          "rod %s: the quasi-static twist did not converge in %d Newton iterations (largest dE/dtheta %.3g, "
          "its terms are of size %.3g)",
          rod->name, k, now.residual, now.scale);
    double noise = (8 + rod->nv) * DBL_EPSILON * now.magnitude, slope = find_direction(rod, w, noise),
           part = 1;
    hb_look next;
    for (;; part *= 0.5) {
      turn_frames(rod, w, m1, twist, part);
      next = look_at(m, rod, w, w->trial_m1, w->trial_twist);
      if (next.energy <= now.energy + 1e-4 * part * slope + noise || part < 1e-10) break;
    }
    state->scalar[HB_S_TWIST_ITERATIONS]++;
    /* at the bottom round-off decides: stop when a full step no longer lowers the gradient */
    bool stuck = next.residual >= 0.5 * now.residual && next.residual <= 1e-11 * now.scale;
    if (stuck && next.residual >= now.residual) {
      now = look_at(m, rod, w, m1, twist);
      break;
    }
    accept(rod, w, m1, twist);
    for (int j = 0; j + 1 < rod->nv; j++) state->spin[rod->first + j] += part * w->delta[j];
    now = next;
    if (stuck) break;
  }
  return HB_OK;
}

/* (kappa b)_i of all interior vertices from the tangents. */
static void curvature_binormals(const hb_rod *rod, hb_rod_work *w) {
  hb_v3 t = hb_v3_load(w->tangent);
  for (int i = 1; i <= rod->last_joint; i++) {
    hb_v3 next = hb_v3_load(w->tangent + 3 * i);
    double chi = fmax(1 + hb_v3_dot(t, next), HB_FOLD_LIMIT);
    hb_v3_store(w->kb + 3 * i, hb_v3_scale(2 / chi, hb_v3_cross(t, next)));
    t = next;
  }
}

/* B and pull of this step: elastic, plus viscosity as a spring towards the curvatures that the rate formula
 * (3 omega - 4 omega_1 + omega_2)/(2 h) makes stress-free (second-order backward difference). */
static void set_targets(const hb_model *m, const hb_rod *rod, const hb_state *state, hb_rod_work *w,
                        double h) {
  int o = rod->first, nv = rod->nv;
  memcpy(w->B_now, m->B + 3 * o, 3 * (size_t)nv * sizeof(double));
  memcpy(w->pull, m->rest_pull + 4 * o, 4 * (size_t)nv * sizeof(double));
  if (!(h > 0) || !m->def->rods[rod->index].viscosity) return;
  for (int j = 0; j <= rod->last_joint; j++) {
    w->B_now[3 * j] += 1.5 * m->viscosity[o + j] / h;
    w->B_now[3 * j + 2] += 1.5 * m->viscosity[o + j] / h;
  }
  for (int i = 1; i <= rod->last_joint; i++)
    for (int c = 0; c < 4; c++) {
      double eta = m->viscosity[o + i - 1 + c / 2] / h;
      w->pull[4 * i + c] +=
          eta * (2 * state->omega_1[4 * (o + i) + c] - 0.5 * state->omega_2[4 * (o + i) + c]);
    }
}

/* A carried frame turned once more by what it turned in the last step: first guess of this step, off by the
 * square of the step only. Long turns are not guesses any more and are dropped. keep < 1 where nothing holds
 * the frames: where such a rod has no stiffness against the turn nothing would ever end it. */
static hb_v3 spin_on(hb_v3 d, hb_v3 t, double keep, double *spin) {
  double s, c;
  *spin = fabs(*spin) < 0.5 ? keep * *spin : 0;
  hb_small_sincos(*spin, &s, &c);
  hb_v3 n = hb_v3_cross(t, d);
  return (hb_v3){c * d.x + s * n.x, c * d.y + s * n.y, c * d.z + s * n.z};
}

/* Twist of joint i from its two frames, nearest to what is expected; on the joint of a closed rod past the
 * cut. */
static double twist_at(const hb_rod *rod, const hb_state *state, const hb_rod_work *w, int i,
                       double expected) {
  const double *m1 = state->m1 + 3 * (size_t)rod->first;
  hb_v3 t = hb_v3_load(w->tangent + 3 * i);
  hb_v3 u = hb_transport(hb_v3_load(m1 + 3 * i - 3), hb_v3_load(w->tangent + 3 * i - 3), t);
  double angle = hb_angle_about(u, hb_v3_load(m1 + 3 * i), t);
  if (i + 1 == rod->nv) angle += state->seam[rod->index];
  return hb_nearest_angle(angle, expected);
}

/* What the joint of a closed rod sees behind it: the first edge's frame. */
static void repeat_first(const hb_rod *rod, hb_state *state) {
  size_t first = 3 * (size_t)rod->first, behind = first + 3 * (size_t)(rod->nv - 1);
  if (!rod->closed) return;
  memcpy(state->m1 + behind, state->m1 + first, 3 * sizeof(double));
  memcpy(state->tangent + behind, state->tangent + first, 3 * sizeof(double));
}

/* Frames to the new tangents; twists measured anew, their windings from the last step. */
static void carry_frames(const hb_model *m, const hb_rod *rod, hb_state *state, hb_rod_work *w) {
  int o = rod->first, ne = rod->nv - 1;
  double turned_before = 0, turned_first = 0, keep = rod->frame_count > 0 ? 1 : 0.9;
  for (int j = 0; j < ne; j++) {
    hb_v3 t = hb_v3_load(w->tangent + 3 * j), d;
    int frame = m->frame_of[o + j];
    double turned;
    if (frame >= 0) {
      d = hb_v3_load(w->frame_now + 3 * frame);
      turned = w->frame_turned[frame];
    } else {
      d = hb_carry(hb_v3_load(state->m1 + 3 * (o + j)), hb_v3_load(state->tangent + 3 * (o + j)), t);
      d = spin_on(d, t, keep, &state->spin[o + j]);
      turned = state->spin[o + j];
    }
    hb_v3_store(state->m1 + 3 * (o + j), d);
    hb_v3_store(state->tangent + 3 * (o + j), t);
    w->held[j] = frame >= 0;
    if (j == 0) turned_first = turned;
    if (j > 0) state->twist[o + j] = twist_at(rod, state, w, j, state->twist[o + j] + turned - turned_before);
    turned_before = turned;
  }
  repeat_first(rod, state);
  if (!rod->closed) return;
  double *joint = &state->twist[o + ne];
  *joint = twist_at(rod, state, w, ne, *joint + turned_first - turned_before);
}

/* theta^0 against the anchor, on the branch where it was. */
void hb_twist_first_angle(const hb_rod *rod, hb_state *state, const double m1[3], const hb_rod_work *w) {
  double angle =
      hb_angle_about(hb_v3_load(state->anchor_m1 + 3 * rod->index), hb_v3_load(m1), hb_v3_load(w->tangent));
  state->theta_0[rod->index] = hb_nearest_angle(angle, state->theta_0[rod->index]);
}

/* Is there a direction in which the energy falls at second order? Pivots of the Hessian that are clearly
 * negative. */
static bool on_a_saddle(const hb_rod *rod, hb_rod_work *w) {
  double before = 1;
  if (rod->closed) return hb_twist_ring_on_saddle(rod, w);
  for (int j = 0; j + 1 < rod->nv; j++) {
    if (w->held[j]) continue;
    double whole = w->diagonal[j] + fabs(w->bending_diagonal[j]),
           pivot = w->diagonal[j] + w->bending_diagonal[j];
    if (j > 0 && !w->held[j - 1]) pivot -= w->off_diagonal[j] * w->off_diagonal[j] / before;
    if (pivot < -1e-8 * whole) return true;
    if (!(pivot > 1e-13 * whole)) return false;
    before = pivot;
  }
  return false;
}

/* Minimises; where symmetry has led to a saddle, leaves it by a small uneven turn of all frames and goes on.
 * The last Newton step has mostly shown already that the energy is convex there. */
static hb_status minimise_past_saddles(const hb_model *m, const hb_rod *rod, hb_state *state, hb_rod_work *w,
                                       int limit, hb_error *err) {
  double *m1 = state->m1 + 3 * (size_t)rod->first, *twist = state->twist + rod->first;
  for (int attempt = 0;; attempt++) {
    hb_status status = minimise(m, rod, state, w, limit, err);
    if (status || attempt == 3 || w->convex || !on_a_saddle(rod, w)) return status;
    state->scalar[HB_S_SADDLES]++;
    for (int j = 0; j + 1 < rod->nv; j++) w->delta[j] = w->held[j] ? 0 : 1e-3 * (1 + 0.1 * (j % 3));
    turn_frames(rod, w, m1, twist, 1);
    accept(rod, w, m1, twist);
  }
}

/* Carry, then minimise. */
hb_status hb_twist_newton(const hb_model *m, const hb_rod *rod, hb_state *state, hb_rod_work *w, double h,
                          hb_error *err) {
  curvature_binormals(rod, w);
  carry_frames(m, rod, state, w);
  set_targets(m, rod, state, w, h);
  double turned = 0;
  for (int k = rod->first_frame; k < rod->first_frame + rod->frame_count; k++)
    turned = fmax(turned, fabs(w->frame_turned[k]));
  /* a frame that is turned far in one step takes the others along by LONGEST_TURN per iteration */
  int limit = m->def->method.max_twist_iterations + (int)fmin(1e6, 20 * turned);
  hb_status status = minimise_past_saddles(m, rod, state, w, limit, err);
  hb_twist_first_angle(rod, state, state->m1 + 3 * (size_t)rod->first, w);
  return status;
}

/* Twists measured anew, then minimise. */
hb_status hb_twist_resume(const hb_model *m, const hb_rod *rod, hb_state *state, hb_rod_work *w,
                          hb_error *err) {
  double *m1 = state->m1 + 3 * (size_t)rod->first, *twist = state->twist + rod->first;
  repeat_first(rod, state);
  for (int j = 0; j + 1 < rod->nv; j++) w->held[j] = m->frame_of[rod->first + j] >= 0;
  for (int i = 1; i <= rod->last_joint; i++) twist[i] = twist_at(rod, state, w, i, twist[i]);
  curvature_binormals(rod, w);
  set_targets(m, rod, state, w, 0);
  hb_status status =
      minimise_past_saddles(m, rod, state, w, START_FACTOR * m->def->method.max_twist_iterations, err);
  hb_twist_first_angle(rod, state, m1, w);
  return status;
}

/* Minimise from the frames as they are; frames held "as relaxed" are still free. */
hb_status hb_twist_relax(const hb_model *m, const hb_rod *rod, hb_state *state, hb_rod_work *w,
                         hb_error *err) {
  for (int j = 0; j + 1 < rod->nv; j++) {
    int frame = m->frame_of[rod->first + j];
    bool deferred =
        frame >= 0 && m->frames[frame].def->kind == HB_SUPPORT_ANGLE && m->frames[frame].def->held;
    w->held[j] = frame >= 0 && !deferred;
  }
  curvature_binormals(rod, w);
  set_targets(m, rod, state, w, 0);
  int limit = START_FACTOR * m->def->method.max_twist_iterations;
  hb_status status = minimise_past_saddles(m, rod, state, w, limit, err);
  for (int j = 0; j + 1 < rod->nv; j++) {
    int frame = m->frame_of[rod->first + j];
    state->spin[rod->first + j] = 0; /* the way to the first minimum is no motion */
    if (frame >= 0 && !w->held[j])
      memcpy(state->frame_m1 + 3 * frame, state->m1 + 3 * (rod->first + j), 3 * sizeof(double));
  }
  hb_twist_first_angle(rod, state, state->m1 + 3 * (size_t)rod->first, w);
  return status;
}

/* Sixteen turns of all frames together: the start of the relaxation for rods that nothing holds. */
void hb_twist_scan(const hb_model *m, const hb_rod *rod, hb_state *state, hb_rod_work *w) {
  double *m1 = state->m1 + 3 * (size_t)rod->first, *twist = state->twist + rod->first;
  memset(w->held, 0, (size_t)rod->nv * sizeof *w->held);
  curvature_binormals(rod, w);
  set_targets(m, rod, state, w, 0);
  double best = look_at(m, rod, w, m1, twist).energy, noise = 1e-9 * fabs(best), best_angle = 0;
  for (int k = 1; k < 16; k++) {
    double angle = 2 * HB_PI * k / 16;
    for (int j = 0; j <= rod->last_joint; j++)
      hb_v3_store(w->trial_m1 + 3 * j,
                  hb_turn(hb_v3_load(m1 + 3 * j), hb_v3_load(w->tangent + 3 * j), angle));
    double energy = look_at(m, rod, w, w->trial_m1, twist).energy;
    if (energy < best - noise) {
      best = energy;
      best_angle = angle;
    }
  }
  for (int j = 0; j <= rod->last_joint; j++)
    hb_v3_store(m1 + 3 * j, hb_turn(hb_v3_load(m1 + 3 * j), hb_v3_load(w->tangent + 3 * j), best_angle));
}

/* The gradient that the last look left behind. */
void hb_twist_residual(const hb_rod *rod, const hb_rod_work *w, double *residual, double *scale) {
  *residual = *scale = 0;
  for (int j = 0; j <= rod->last_joint; j++) {
    if (j + 1 < rod->nv && !w->held[j]) *residual = fmax(*residual, fabs(w->gradient[j]));
    double parts = j > 0 ? fabs(w->moment[j]) : 0;
    for (int c = 0; c < 4 && j > 0; c++)
      parts = fmax(parts, fabs(w->stress[4 * j + c] * w->omega[4 * j + (c ^ 1)]));
    *scale = fmax(*scale, parts);
  }
}
