/* Newton's method for one stage of an implicit step (docs/theory, 13.3 and 13.4): factors are kept as long as
 * they serve, and steps are judged by the step that would follow with the same factors (Deuflhard 2004). */
#include "time/implicit.h"

#include "force/force.h"
#include "math/vec3.h"
#include "rod/inextensible.h"

#include <string.h>

/* No edge turns further than this in one step. */
#define LONGEST_TURN 0.8
/* Factors are kept while a step is at most this part of the one before. */
#define KEEP 0.2
#define ITERATIONS 40
#define SMALLEST_PART 0.01
/* Steps of this size that do not get smaller any more are round-off. */
#define ROUND_OFF 1e-7

/* Frames, twist, forces and loads at a trial: now + part direction, multipliers likewise. False: there is
 * no such place. */
static bool look(hb_marcher *w, const hb_rod *rod, const hb_stage_now *stage, double part) {
  hb_implicit *im = w->stepper.implicit;
  hb_stepper *s = &w->stepper;
  hb_state *state = s->state;
  int stride = w->kkt.stride, o = rod->first;
  bool viscous = s->model->def->rods[rod->index].viscosity != NULL;
  w->trouble.cause.status = HB_OK;
  hb_stepper_begin(s);
  hb_state_copy_rod(s->model, rod, state, im->kept);
  for (int i = 0; i < rod->nv; i++) {
    const double *d = w->direction + stride * i;
    for (int c = 0; c < 3; c++) {
      int k = 3 * (o + i) + c;
      im->moved[k] = im->now[k] + part * d[c];
      state->x[k] = im->start.x[k] + im->moved[k];
    }
    if (i + 1 == rod->nv) break;
    im->pull[o + i] = im->lambda[o + i] + part * d[stride + HB_KKT_MULTIPLIER];
    if (!rod->closed_form && part != 0) state->spin[o + i] = part * d[HB_KKT_TURN];
  }
  if (hb_rod_settle(s->model, rod, state, &s->rod_work, stage->t, viscous ? 1.5 * stage->ch : 0,
                    &w->trouble.cause))
    return false;
  hb_stepper_end(s, HB_STAGE_TWIST);
  double inv = 1 / stage->ch;
  for (int k = 3 * o; s->rates[rod->index] && k < 3 * (o + rod->nv); k++)
    s->v_predicted[k] = inv * (im->moved[k] - im->reach[k]);
  hb_stepper_forces(s, rod, stage->t, s->v_predicted);
  return s->rod_work.lowest_chi > HB_FOLD_LIMIT;
}

/* What is not balanced yet, as right-hand side: forces with inertia and the pull of the edges, lengths, and
 * the forces that go with the stiffness added along the edges. False: not a number. */
static bool unbalanced(hb_marcher *w, const hb_rod *rod, const hb_stage_now *stage) {
  const hb_model *m = w->stepper.model;
  const hb_implicit *im = w->stepper.implicit;
  const hb_state *state = w->stepper.state;
  hb_kkt *kkt = &w->kkt;
  int stride = kkt->stride, o = rod->first;
  bool relative = m->def->method.length_tolerance_kind == HB_TOLERANCE_RELATIVE;
  double inv = 1 / stage->ch, worst = 0, sum = 0;
  double *right = kkt->right;
  memset(right, 0, (size_t)kkt->matrix.n * sizeof *right);
  for (int i = 0; i < rod->nv; i++)
    for (int c = 0; c < 3; c++) {
      int k = 3 * (o + i) + c;
      double change = inv * (im->moved[k] - im->reach[k]) - im->speed[k];
      right[stride * i + c] = state->force[k] - m->mass[o + i] * inv * change;
    }
  for (int j = 0; !rod->extensible && j + 1 < rod->nv; j++) { /* springs are in the force */
    int k = o + j;
    double *near = right + stride * j, *far = near + stride;
    const double *old = kkt->gradient + 3 * j;
    hb_v3 g;
    double C = hb_inextensible_edge(state->x + 3 * k, m->rest_length[k], m->inv_rest_length[k], &g);
    double pull = im->pull[k], along = kkt->along[j] * C;
    const double *now = &g.x;
    for (int c = 0; c < 3; c++) {
      double force = pull * now[c] + along * old[c];
      near[c] += force;
      far[c] -= force;
    }
    far[HB_KKT_MULTIPLIER] = -C;
    worst = fmax(worst, fabs(C) * (relative ? m->inv_rest_length[k] : 1));
  }
  w->worst = worst / m->def->method.length_tolerance;
  w->trouble.residual = 0;
  for (int n = 0; n < kkt->matrix.n; n++) {
    if (n % stride >= 3) continue;
    if (kkt->weight[n] == 0) right[n] = 0;
    sum += right[n];
    if (!(fabs(right[n]) > w->trouble.residual)) continue;
    w->trouble.residual = fabs(right[n]);
    w->trouble.vertex = o + n / stride;
  }
  return isfinite(sum + worst);
}

/* The largest turn of an edge in a step, or of the whole rod. */
static double turn_of(const hb_marcher *w, const hb_rod *rod, const double *step) {
  int stride = w->kkt.stride;
  const double *inv = w->stepper.model->inv_rest_length + rod->first;
  double turn = 0, way = 0;
  for (int i = 0; i < rod->nv; i++) {
    const double *d = step + stride * i;
    way = fmax(way, d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
    if (i + 1 == rod->nv) break;
    double a = d[stride] - d[0], b = d[stride + 1] - d[1], c = d[stride + 2] - d[2];
    turn = fmax(turn, (a * a + b * b + c * c) * (inv[i] * inv[i]));
  }
  double size = sqrt(fmax(turn, way / (rod->length * rod->length)));
  return isfinite(size) ? size : HUGE_VAL;
}

/* Matrix and factors where the state is. False: its inertia is not that of a motion that the step can follow.
 */
static bool refactor(hb_marcher *w, const hb_rod *rod, const hb_stage_now *stage) {
  hb_stepper *s = &w->stepper;
  double inv = 1 / stage->ch;
  hb_kkt_assemble(&w->kkt, s->model, rod, s->state, &s->rod_work, stage->t, s->implicit->lambda + rod->first,
                  NULL);
  bool drag =
      s->rates[rod->index] && hb_load_drag(s->model, rod, stage->t, s->state->x, s->v_predicted, w->drag);
  hb_kkt_add_motion(&w->kkt, s->model, rod, inv * inv, drag ? w->drag : NULL, inv);
  w->stepper.state->scalar[HB_S_FACTORISATIONS]++;
  int wrong = hb_kkt_factor(&w->kkt, w->neutral);
  w->factored = stage->ch;
  return wrong == 0;
}

/* Solves for what is unbalanced; the step stays in kkt->right. Returns its size. */
static double next_step(hb_marcher *w, const hb_rod *rod, const hb_stage_now *stage) {
  if (!unbalanced(w, rod, stage)) return HUGE_VAL;
  hb_kkt_solve(&w->kkt);
  double size = turn_of(w, rod, w->kkt.right);
  hb_stepper_end(&w->stepper, HB_STAGE_PROJECT);
  return size;
}

/* kkt->right becomes the step to take. */
static void take_over(hb_marcher *w) {
  memcpy(w->direction, w->kkt.right, (size_t)w->kkt.matrix.n * sizeof *w->direction);
}

/* Goes along the direction, less far while the next step is not shorter: the state is there then. Returns the
 * size of the next step, negative where there is none. */
static double advance(hb_marcher *w, const hb_rod *rod, const hb_stage_now *stage, double size, bool fresh,
                      double *part) {
  hb_implicit *im = w->stepper.implicit;
  size_t o = (size_t)rod->first, n = (size_t)rod->nv;
  for (*part = fmin(1, LONGEST_TURN / size); *part > SMALLEST_PART; *part *= 0.5) {
    double next = look(w, rod, stage, *part) ? next_step(w, rod, stage) : HUGE_VAL;
    if (next <= (1 - 0.25 * *part) * size || next <= w->tolerance) {
      memcpy(im->now + 3 * o, im->moved + 3 * o, 3 * n * sizeof(double));
      memcpy(im->lambda + o, im->pull + o, (n - 1) * sizeof(double));
      return next;
    }
    if (!fresh) break;
  }
  return -1;
}

/* Notes why it does not go on. */
static bool give_up(hb_marcher *w, hb_trouble_kind kind, int iterations, const hb_stage_now *stage) {
  w->trouble.kind = kind;
  w->trouble.iterations = iterations;
  w->trouble.t = stage->t;
  w->factored = 0;
  return false;
}

/* The last step is known and so small that forces need not be looked at again: taken, it leaves next to no
 * error in velocities, which are differences over the short time ch. */
static void settle(hb_marcher *w, const hb_rod *rod) {
  hb_implicit *im = w->stepper.implicit;
  for (int i = 0; i < rod->nv; i++)
    for (int c = 0; c < 3; c++) {
      int k = 3 * (rod->first + i) + c;
      im->moved[k] += w->kkt.right[w->kkt.stride * i + c];
      w->stepper.state->x[k] = im->start.x[k] + im->moved[k];
    }
}

/* Nothing can be evaluated at the iterate itself: what is wrong there? */
static bool blame(hb_marcher *w, const hb_rod *rod, int iterations, const hb_stage_now *stage) {
  const double *load = w->stepper.state->load;
  if (w->trouble.cause.status) return give_up(w, HB_TROUBLE_PLACE, iterations, stage);
  for (int k = 3 * rod->first; k < 3 * (rod->first + rod->nv); k++) {
    if (isfinite(load[k])) continue;
    w->trouble.vertex = k / 3;
    return give_up(w, HB_TROUBLE_LOAD, iterations, stage);
  }
  int fold = hb_rod_find_fold(rod, &w->stepper.rod_work);
  w->trouble.vertex = rod->first + (fold > 0 ? fold : 0);
  return give_up(w, HB_TROUBLE_FOLD, iterations, stage);
}

/* Steps until they are too small to matter. */
bool hb_march_solve(hb_marcher *w, const hb_rod *rod, const hb_stage_now *stage) {
  memset(w->direction, 0, (size_t)w->kkt.matrix.n * sizeof *w->direction);
  if (!look(w, rod, stage, 0)) return blame(w, rod, 0, stage);
  bool fresh = w->factored != stage->ch;
  if (fresh && !refactor(w, rod, stage)) return give_up(w, HB_TROUBLE_UNSTABLE, 0, stage);
  double size = next_step(w, rod, stage), part = 1;
  for (int k = 0;; k++) {
    bool lengths = w->worst <= 1;
    if (size <= w->tolerance && lengths) {
      settle(w, rod);
      return true;
    }
    if (size == HUGE_VAL && k == 0) return blame(w, rod, k, stage);
    if (k == ITERATIONS || size == HUGE_VAL) return give_up(w, HB_TROUBLE_SLOW, k, stage);
    take_over(w);
    double next = advance(w, rod, stage, size, fresh, &part);
    w->stepper.state->scalar[HB_S_NEWTON]++;
    bool good = next >= 0 && part == 1 && next <= KEEP * size;
    if (next < 0 && fresh) {
      memset(w->direction, 0, (size_t)w->kkt.matrix.n * sizeof *w->direction);
      if (!(size < ROUND_OFF && lengths && look(w, rod, stage, 0)))
        return give_up(w, HB_TROUBLE_STUCK, k, stage);
      return true;
    }
    if (next < 0) {
      memset(w->direction, 0, (size_t)w->kkt.matrix.n * sizeof *w->direction);
      if (!look(w, rod, stage, 0)) return blame(w, rod, k, stage);
    }
    fresh = next < 0 || (!good && next > w->tolerance);
    if (fresh && !refactor(w, rod, stage)) return give_up(w, HB_TROUBLE_UNSTABLE, k, stage);
    size = fresh ? next_step(w, rod, stage) : next;
  }
}
