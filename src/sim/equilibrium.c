/* Equilibria of a simulation: the search of the statics room on the state of a sim. */
#include "sim/measure.h"

#include "base/memory.h"
#include "rod/resume.h"
#include "statics/equilibrium.h"

#include <math.h>
#include <string.h>

/* What a user means who says nothing. */
hb_equilibrium_options hb_equilibrium_defaults(double time) {
  return (hb_equilibrium_options){.time = time, .load_steps = 1, .max_iterations = 200, .tolerance = 1e-10};
}

/* Supports of a rod at time t. */
static void place(void *context, const hb_rod *rod, double t) {
  hb_sim *sim = context;
  hb_stepper_place(&sim->stepper, rod, t, 1, true);
}

/* What the last load step found counts, but for the costs. */
static void forget(hb_equilibrium *result) {
  result->unstable = result->neutral = 0;
  result->resolution = result->residual = result->force_scale = result->last_step = result->elastic = 0;
}

/* All rods at the next time. */
static hb_status solve_all(hb_statics *s, double from, double t, const hb_equilibrium_options *options,
                           hb_equilibrium *result, hb_error *err) {
  hb_status status = HB_OK;
  forget(result);
  for (int r = 0; !status && r < s->model->rod_count; r++)
    status = hb_statics_solve(s, &s->model->rods[r], from, t, options, result, err);
  return status;
}

/* The options, one rule after the other. */
static hb_status check_options(const hb_equilibrium_options *o, hb_error *err) {
  if (!(o->time >= 0 && o->time < HUGE_VAL))
    return hb_fail(err, HB_ERR_INPUT, "the time of an equilibrium is %g; a number from 0 on is allowed",
                   o->time);
  if (o->load_steps < 1)
    return hb_fail(err, HB_ERR_INPUT, "%d load steps; at least 1 is needed", o->load_steps);
  if (o->max_iterations < 1)
    return hb_fail(err, HB_ERR_INPUT, "%d iterations; at least 1 is needed", o->max_iterations);
  if (!(o->tolerance > 0))
    return hb_fail(err, HB_ERR_INPUT, "a tolerance of %g; it must be above 0", o->tolerance);
  return HB_OK;
}

/* Load step after load step. */
hb_status hb_sim_find_equilibrium(hb_sim *sim, const hb_equilibrium_options *options, hb_equilibrium *result,
                                  hb_error *err) {
  hb_statics s;
  hb_error inner = {HB_OK, ""};
  memset(result, 0, sizeof *result);
  memset(&s, 0, sizeof s);
  hb_status status = check_options(options, err);
  if (status) return status;
  (void)hb_sim_state(sim); /* rods may be elsewhere in lanes; from here on the state counts */
  status = hb_statics_create(&s, sim->model, sim->state, hb_force_terms, place, sim, err);
  double start = sim->state->scalar[HB_S_TIME], t = start;
  for (int k = 1; !status && k <= options->load_steps; k++) {
    double next =
        k < options->load_steps ? start + (options->time - start) * k / options->load_steps : options->time;
    status = solve_all(&s, t, next, options, result, &inner);
    if (status == HB_ERR_NUMERIC)
      status =
          hb_fail(err, status, "load step %d of %d (t = %.9g): %s", k, options->load_steps, next, inner.text);
    else if (status && err)
      *err = inner;
    t = next;
  }
  if (!status) {
    memset(sim->state->v, 0, 3 * (size_t)sim->model->nv * sizeof(double));
    sim->state->scalar[HB_S_TIME] = options->time;
    result->multiplier = s.multiplier;
    s.multiplier = NULL;
  }
  hb_statics_free(&s);
  return status;
}

/* Lengths and places of supports of the given moment, to the digits that a file may have lost. */
static hb_status check_moment(hb_sim *sim, const hb_rod *rod, const hb_frame *frame, hb_error *err) {
  const double *x = frame->position;
  double worst = hb_project_length_error(sim->model, rod, x), off = 0;
  for (int k = 3 * rod->first; k < 3 * (rod->first + rod->nv); k++)
    off = fmax(off, fabs(sim->state->x[k] - x[k]));
  if (!(worst <= 1e-5))
    return hb_fail(err, HB_ERR_INPUT, "rod %s: the given shape has edges that are off their lengths by %.3g",
                   rod->name, worst);
  if (!(off <= 1e-6 * rod->length))
    return hb_fail(
        err, HB_ERR_INPUT,
        "rod %s: supports are %.3g away from where they are in the given shape at t = %.9g: it is of another "
        "scene",
        rod->name, off, frame->time);
  return HB_OK;
}

/* Rod by rod. */
hb_status hb_sim_resume(hb_sim *sim, const hb_frame *frame, hb_error *err) {
  const hb_model *m = sim->model;
  size_t size = 3 * (size_t)m->nv * sizeof(double);
  hb_status status = HB_OK;
  (void)hb_sim_state(sim); /* as above */
  memcpy(sim->state->x, frame->position, size);
  sim->state->scalar[HB_S_TIME] = frame->time;
  for (int r = 0; !status && r < m->rod_count; r++) {
    const hb_rod *rod = &m->rods[r];
    hb_stepper_place(&sim->stepper, rod, frame->time, 1, true);
    status = check_moment(sim, rod, frame, err);
    if (status) return status;
    if (!hb_rod_geometry(rod, sim->state->x, &sim->stepper.rod_work))
      return hb_fail(err, HB_ERR_INPUT, "rod %s: the given shape has an edge of length zero", rod->name);
    hb_frames_resume(m, rod, sim->state, &sim->stepper.rod_work, frame->time, frame->m1, frame->twist,
                     frame->bishop_u + 3 * rod->first, frame->theta[rod->first]);
    memset(sim->state->v + 3 * rod->first, 0, 3 * (size_t)rod->nv * sizeof(double));
    status = hb_stepper_evaluate(&sim->stepper, rod, frame->time, sim->state->v, 0, err);
    bool viscous = m->def->rods[r].viscosity != NULL; /* nothing has moved before */
    for (int k = 4 * rod->first; !status && viscous && k < 4 * (rod->first + rod->nv); k++)
      sim->state->omega_1[k] = sim->state->omega_2[k] = sim->stepper.rod_work.omega[k - 4 * rod->first];
  }
  return status;
}

/* The array that it owns. */
void hb_equilibrium_free(hb_equilibrium *result) {
  if (!result) return;
  hb_free(result->multiplier);
  result->multiplier = NULL;
}

/* Nothing accelerates: supports give what loads, elasticity and edges leave over. */
void hb_sim_measure_equilibrium(hb_sim *sim, const hb_equilibrium *result, hb_frame *frame) {
  const hb_model *m = sim->model;
  const double *x = sim->state->x;
  hb_sim_measure(sim, frame);
  frame->balance = 0; /* nothing was integrated, nothing can be wrong with it */
  for (int r = 0; r < m->rod_count; r++) {
    const hb_rod *rod = &m->rods[r];
    double before[3] = {0, 0, 0};
    for (int k = rod->first; k < rod->first + rod->nv; k++) {
      double length = 0;
      for (int c = 0; c < 3; c++) {
        bool edge = k + 1 < rod->first + rod->nv;
        double along = edge ? x[3 * k + 3 + c] - x[3 * k + c] : 0;
        double pull = edge ? 2 * result->multiplier[k] * m->inv_rest_length[k] * along : 0;
        bool held = m->inv_mass[3 * k + c] == 0;
        frame->reaction[3 * k + c] = held ? -(sim->state->force[3 * k + c] + pull - before[c]) : 0;
        before[c] = pull;
        length += along * along;
      }
      frame->tension[k] = 2 * result->multiplier[k] * m->inv_rest_length[k] * sqrt(length);
      if (k + 1 < rod->first + rod->nv) frame->tension[k] += hb_measure_spring(m, k, x);
    }
    hb_rod_share_seam(rod, frame->reaction);
    hb_measure_internal_force(rod, frame);
  }
}
