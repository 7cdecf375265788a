/* All rods of a step: those in lanes unit by unit, the others one by one. Their data stay in cache for a
 * whole step. */
#include "base/memory.h"
#include "time/integrators.h"

#include <string.h>

/* A stepper of its own, whose totals go to the unit at hand. */
struct hb_lane_worker {
  hb_stepper stepper;
  hb_state state;
};

/* Is everything about this rod known to the lanes? */
static bool fits_lanes(const hb_stepper *s, const hb_rod *rod) {
  const hb_model *m = s->model;
  const char *scheme = m->def->method.integrator;
  bool euler = scheme && strcmp(scheme, "symplectic-euler") == 0;
  if (m->def->rods[rod->index].viscosity || m->any_follower || rod->nv < 3) return false;
  for (int k = rod->first_position; k < rod->first_position + rod->position_count; k++)
    if (euler && hb_support_moves(&m->positions[k])) return false;
  for (int i = rod->first; i < rod->first + rod->nv; i++)
    if (m->inv_mass[3 * i] != m->inv_mass[3 * i + 1] || m->inv_mass[3 * i] != m->inv_mass[3 * i + 2])
      return false; /* held along single axes */
  return true;
}

/* Plan, workers. */
hb_status hb_stepper_use_lanes(hb_stepper *s, hb_error *err) {
  const hb_model *m = s->model;
  if (m->def->method.lanes == HB_LANES_OFF) return HB_OK;
  const hb_lane_kernels *kernels = hb_lane_kernels_for(false, m->def->method.lanes == HB_LANES_PORTABLE);
  unsigned char *wanted = hb_alloc((size_t)m->rod_count, 1);
  if (!wanted) return hb_fail_memory(err, "rods in lanes");
  for (int r = 0; r < m->rod_count; r++) wanted[r] = fits_lanes(s, &m->rods[r]);
  hb_status status = hb_lane_plan_create(m, wanted, kernels, &s->plan, err);
  hb_free(wanted);
  if (status || !s->plan) return status;
  s->worker_count = 1;
  s->workers = hb_alloc((size_t)s->worker_count, sizeof *s->workers);
  if (!s->workers) return hb_fail_memory(err, "rods in lanes");
  return HB_OK;
}

/* Lanes to state. */
void hb_stepper_store(hb_stepper *s) {
  if (!s->plan || s->state_current || !s->lanes_current) return;
  for (int k = 0; k < s->plan->unit_count; k++) hb_unit_store(s->model, s->state, &s->plan->units[k]);
  s->state_current = true;
}

/* Somebody holds the state to write to it. */
void hb_stepper_state_changed(hb_stepper *s) {
  hb_stepper_store(s);
  s->lanes_current = false;
}

/* State to lanes, if it is newer. */
static void load_lanes(hb_stepper *s) {
  if (s->lanes_current) return;
  for (int k = 0; k < s->plan->unit_count; k++) hb_unit_load(s->model, s->state, &s->plan->units[k]);
  s->lanes_current = true;
}

/* What a unit's step adds to the totals. */
static void add_tally(hb_stepper *s, const hb_unit *u) {
  double *total = s->state->scalar;
  for (int k = 0; k < HB_S_COUNT; k++)
    if (k != HB_S_FOLD_SLOT) total[k] += u->tally[k];
  if (u->tally[HB_S_FOLDS] > 0) total[HB_S_FOLD_SLOT] = u->tally[HB_S_FOLD_SLOT];
  if (u->length_error > s->length_error) s->length_error = u->length_error;
  s->lanes_finite = s->lanes_finite && u->finite;
}

/* Units by a worker. */
static hb_status step_units(hb_stepper *s, double t, double h, const hb_scheme *scheme, hb_error *err) {
  hb_lane_worker *w = s->workers;
  w->stepper = *s;
  w->state = *s->state;
  w->stepper.state = &w->state;
  hb_status status = HB_OK;
  for (int k = 0; !status && k < s->plan->unit_count; k++) {
    hb_unit *u = &s->plan->units[k];
    w->state.scalar = u->tally;
    status = scheme->step_lanes(&w->stepper, u, t, h, scheme->step_rod, err);
  }
  for (int k = 0; !status && k < s->plan->unit_count; k++) add_tally(s, &s->plan->units[k]);
  memcpy(s->stage_seconds, w->stepper.stage_seconds, sizeof s->stage_seconds);
  return status;
}

/* Lanes first, then the others in their order. */
hb_status hb_step_rods(hb_stepper *s, double h, const hb_scheme *scheme, hb_error *err) {
  double t = (s->state->scalar[HB_S_STEP] + 1) * h;
  hb_status status = HB_OK;
  s->lanes_finite = true;
  if (s->plan) {
    load_lanes(s);
    s->state_current = false;
    status = step_units(s, t, h, scheme, err);
  }
  for (int r = 0; !status && r < s->model->rod_count; r++)
    if (!s->plan || s->plan->unit_of[r] < 0) status = scheme->step_rod(s, &s->model->rods[r], t, h, err);
  return status;
}
