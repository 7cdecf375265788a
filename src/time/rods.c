/* All rods of a step: those in lanes unit by unit, the others one by one. Their data stay in cache for a
 * whole step. */
#include "base/memory.h"
#include "time/integrators.h"
#include "time/lane_frames.h"

#include <float.h>
#include <math.h>
#include <string.h>

/* Vertices in all below which a step is too short to be shared. */
#define SHARED_VERTICES 2000

/* A stepper of its own, whose totals go to the unit at hand. The first worker uses the stepper's workspaces.
 */
struct hb_lane_worker {
  hb_stepper stepper;
  hb_state state;
  hb_rod_work rod_work;
  hb_project_work project_work;
  hb_error err;
  int failed;       /* unit whose step failed earliest in this worker, or -1 */
  int failed_step;  /* and in which step of the block */
  hb_status status; /* HB_OK: a number was not finite */
};

/* Can a rod do with floats? Its edges must stand clear of the rounding of its coordinates, to the tolerance
 * of lengths; the multipliers of led supports on a taut rod are differences that floats do not hold. */
static bool fits_floats(const hb_model *m, const hb_rod *rod) {
  double farthest = 0, shortest = HUGE_VAL;
  for (int k = 3 * rod->first; k < 3 * (rod->first + rod->nv); k++)
    farthest = fmax(farthest, fabs(m->initial[k]));
  for (int j = rod->first; j + 1 < rod->first + rod->nv; j++) shortest = fmin(shortest, m->rest_length[j]);
  for (int k = rod->first_position; k < rod->first_position + rod->position_count; k++)
    if (hb_support_moves(m, &m->positions[k])) return false;
  double unit = m->def->method.length_tolerance_kind == HB_TOLERANCE_RELATIVE ? shortest : 1;
  return (double)FLT_EPSILON * farthest <= m->def->method.length_tolerance * unit;
}

/* Is everything about this rod known to the lanes? */
static bool fits_lanes(const hb_stepper *s, const hb_rod *rod) {
  const hb_model *m = s->model;
  const char *scheme = m->def->method.integrator;
  bool euler = scheme && strcmp(scheme, "symplectic-euler") == 0;
  if (rod->closed || rod->extensible) return false; /* they go the plain way */
  if (m->def->rods[rod->index].viscosity || m->any_follower || rod->nv < 3) return false;
  for (int k = rod->first_position; k < rod->first_position + rod->position_count; k++)
    if (euler && hb_support_moves(m, &m->positions[k])) return false;
  for (int i = rod->first; i < rod->first + rod->nv; i++)
    if (m->inv_mass[3 * i] != m->inv_mass[3 * i + 1] || m->inv_mass[3 * i] != m->inv_mass[3 * i + 2])
      return false; /* held along single axes */
  return true;
}

/* Threads that a run is worth: as many as asked for, else as there are processors, but one where there is
 * nothing to share. */
static int useful_threads(const hb_stepper *s) {
  const hb_model *m = s->model;
  int shared = 0;
  for (int k = 0; k < s->plan->unit_count; k++) {
    int strips = s->plan->units[k].strip_count;
    shared += strips >= HB_SHARED_STRIPS ? strips : 1;
  }
  int threads = m->def->method.threads > 0 ? m->def->method.threads : hb_processors();
  if (m->nv < SHARED_VERTICES || shared < 2) return 1;
  return threads < shared ? threads : shared;
}

/* Pool and workers. */
static hb_status create_workers(hb_stepper *s, hb_error *err) {
  int count = useful_threads(s);
  hb_status status = count > 1 ? hb_pool_create(count, &s->pool, err) : HB_OK;
  if (status) return status;
  s->workers = hb_alloc((size_t)hb_pool_threads(s->pool), sizeof *s->workers);
  if (!s->workers) return hb_fail_memory(err, "rods in lanes");
  for (int w = 1; !status && w < hb_pool_threads(s->pool); w++) {
    status = hb_rod_work_create(s->model, &s->workers[w].rod_work, err);
    if (!status) status = hb_project_work_create(s->model, &s->workers[w].project_work, err);
  }
  return status;
}

/* Workspaces of the workers; also after a failed start. */
void hb_stepper_release_workers(hb_stepper *s) {
  for (int w = 1; s->workers && w < hb_pool_threads(s->pool); w++) {
    hb_rod_work_free(&s->workers[w].rod_work);
    hb_project_work_free(&s->workers[w].project_work);
  }
  hb_free(s->workers);
  s->workers = NULL;
}

/* Every array of hb_stepper_init and hb_stepper_use_lanes. */
size_t hb_stepper_memory(const hb_stepper *s) {
  const hb_model *m = s->model;
  size_t vectors = 3 * (size_t)m->nv * sizeof(double), rods = (size_t)m->rod_count;
  size_t bytes = s->rod_work.bytes + s->project_work.bytes + (s->follower_m1 ? 4 : 3) * vectors +
                 (3 * (size_t)m->position_count + 2 * (size_t)m->frame_count) * sizeof(double) +
                 rods * (sizeof *s->rates + sizeof *s->active + sizeof *s->uniform) +
                 HB_BLOCK_STEPS * (size_t)m->def->force_count * sizeof *s->values + hb_pool_memory(s->pool);
  bytes += hb_implicit_bytes(s->implicit);
  if (s->plan) bytes += sizeof *s->plan + s->plan->bytes;
  for (int w = 0; s->workers && w < hb_pool_threads(s->pool); w++)
    bytes += sizeof *s->workers + s->workers[w].rod_work.bytes + s->workers[w].project_work.bytes;
  return bytes;
}

/* Which units have supports that move, which rods that are alike? */
static void look_at_supports(hb_stepper *s) {
  const hb_model *m = s->model;
  for (int k = 0; k < s->plan->unit_count; k++)
    s->plan->units[k].alike = hb_unit_is_alike(m, &s->plan->units[k]);
  for (int r = 0; r < m->rod_count; r++) {
    int unit = s->plan->unit_of[r];
    const hb_rod *rod = &m->rods[r];
    for (int k = rod->first_position; unit >= 0 && k < rod->first_position + rod->position_count; k++)
      if (hb_support_moves(m, &m->positions[k])) s->plan->units[unit].moving = true;
  }
}

/* Plan, workers. */
hb_status hb_stepper_use_lanes(hb_stepper *s, hb_error *err) {
  const hb_model *m = s->model;
  if (m->def->method.lanes == HB_LANES_OFF) return HB_OK;
  const bool portable = m->def->method.lanes == HB_LANES_PORTABLE;
  const hb_lane_kernels *once = hb_lane_kernels_for(false, portable);
  const hb_lane_kernels *kernels =
      hb_lane_kernels_for(m->def->method.precision == HB_PRECISION_SINGLE, portable);
  unsigned char *wanted = hb_alloc((size_t)m->rod_count, 1);
  if (!wanted) return hb_fail_memory(err, "rods in lanes");
  for (int r = 0; r < m->rod_count; r++) {
    if (!fits_lanes(s, &m->rods[r])) continue;
    wanted[r] = HB_WANTED | (s->active[r] ? HB_WANTED_LOADED : 0);
    if (kernels->single && !fits_floats(m, &m->rods[r])) wanted[r] |= HB_WANTED_DOUBLE;
  }
  hb_status status = hb_lane_plan_create(m, wanted, kernels, once, &s->plan, err);
  hb_free(wanted);
  if (!status && s->plan) {
    look_at_supports(s);
    status = create_workers(s, err);
  }
  return status;
}

/* One unit to the state. */
static void store_unit(void *context, int index, int worker) {
  hb_stepper *s = context;
  (void)worker;
  hb_unit_store(s->model, s->state, &s->plan->units[index]);
}

/* The other way. */
static void load_unit(void *context, int index, int worker) {
  hb_stepper *s = context;
  (void)worker;
  hb_unit_load(s->model, s->state, &s->plan->units[index]);
  s->plan->units[index].fresh = 2;
}

/* Lanes to state. */
void hb_stepper_store(hb_stepper *s) {
  if (!s->plan || s->state_current || !s->lanes_current) return;
  hb_pool_run(s->pool, s->plan->unit_count, store_unit, s);
  s->state_current = true;
}

/* A snapshot on its way. */
typedef struct snapshot {
  const hb_stepper *s;
  bool forces;
  hb_state *to;
} snapshot;

/* One unit of it. */
static void copy_unit(void *context, int index, int worker) {
  const snapshot *shot = context;
  (void)worker;
  hb_unit_store_measured(shot->s->model, shot->to, &shot->s->plan->units[index], shot->forces);
}

/* The arrays with one entry per slot, entries from .. to-1. */
static void copy_slots(const snapshot *shot, size_t from, size_t to) {
  const hb_state *state = shot->s->state;
  size_t vectors = 3 * (to - from) * sizeof(double);
  memcpy(shot->to->x + 3 * from, state->x + 3 * from, vectors);
  memcpy(shot->to->v + 3 * from, state->v + 3 * from, vectors);
  if (shot->forces) memcpy(shot->to->force + 3 * from, state->force + 3 * from, vectors);
  if (!shot->s->model->any_general) return;
  memcpy(shot->to->m1 + 3 * from, state->m1 + 3 * from, vectors);
  memcpy(shot->to->twist + from, state->twist + from, (to - from) * sizeof(double));
}

/* The short arrays are always in the state; the long ones come from the lanes where those are newer. */
void hb_stepper_snapshot(hb_stepper *s, bool forces, hb_state *to) {
  snapshot shot = {s, forces, to};
  for (int k = 0; k < hb_state_field_count; k++) {
    const hb_state_field *field = &hb_state_fields[k];
    double *target, *source;
    if (field->extent == HB_PER_SLOT || field->extent == HB_PER_GENERAL || field->extent == HB_PER_VISCOUS)
      continue;
    memcpy(&target, (char *)to + field->offset, sizeof target);
    memcpy(&source, (char *)s->state + field->offset, sizeof source);
    memcpy(target, source, hb_state_field_size(s->model, field) * sizeof(double));
  }
  if (!s->plan || s->state_current || !s->lanes_current) {
    copy_slots(&shot, 0, (size_t)s->model->nv);
    return;
  }
  hb_pool_run(s->pool, s->plan->unit_count, copy_unit, &shot);
  for (int r = 0; r < s->model->rod_count; r++) {
    size_t first = (size_t)s->model->rods[r].first;
    if (s->plan->unit_of[r] < 0) copy_slots(&shot, first, first + (size_t)s->model->rods[r].nv);
  }
}

/* Somebody holds the state to write to it. */
void hb_stepper_state_changed(hb_stepper *s) {
  hb_stepper_store(s);
  s->lanes_current = false;
}

/* State to lanes, if it is newer. */
static void load_lanes(hb_stepper *s) {
  if (s->lanes_current) return;
  hb_pool_run(s->pool, s->plan->unit_count, load_unit, s);
  s->lanes_current = true;
}

/* What a unit's step adds to the totals. */
static void add_tally(hb_stepper *s, const hb_unit *u, int step) {
  double *total = s->state->scalar;
  const double *tally = u->tallies[step];
  for (int k = 0; k < HB_S_COUNT; k++)
    if (k != HB_S_FOLD_SLOT) total[k] += tally[k];
  if (tally[HB_S_FOLDS] > 0) total[HB_S_FOLD_SLOT] = tally[HB_S_FOLD_SLOT];
  if (u->length_errors[step] > s->length_error) s->length_error = u->length_errors[step];
}

/* A block of steps of all units. */
typedef struct units_step {
  hb_stepper *s;
  double h;
  long from; /* steps done before */
  const hb_scheme *scheme;
} units_step;

/* One unit by a worker, all steps of the block. The pool is the worker's only where the unit is all that goes
 * on. A worker remembers its first failure: of the earliest step, then of the first unit. */
static void step_unit(const units_step *step, int index, int worker, bool alone) {
  hb_unit *u = &step->s->plan->units[index];
  hb_lane_worker *w = &step->s->workers[worker];
  w->stepper.pool = alone ? step->s->pool : NULL;
  for (int k = 0; k < step->s->block; k++) {
    hb_error err = {HB_OK, ""};
    if (w->failed >= 0 && k >= w->failed_step) return;
    u->tally = u->tallies[k];
    w->stepper.values = step->s->values + k * step->s->model->def->force_count;
    w->state.scalar = u->tally;
    double t = (double)(step->from + k + 1) * step->h;
    hb_status status = step->scheme->step_lanes(&w->stepper, u, t, step->h, step->scheme->step_rod, &err);
    u->length_errors[k] = u->length_error;
    if (!status && u->finite) continue;
    w->failed = index;
    w->failed_step = k;
    w->status = status;
    w->err = err;
    return;
  }
}

/* As the pool wants it: units that are not shared. */
static void step_small_unit(void *context, int index, int worker) {
  const units_step *step = context;
  if (step->s->plan->units[index].strip_count < HB_SHARED_STRIPS) step_unit(step, index, worker, false);
}

/* Workers before a step. */
static void ready_workers(hb_stepper *s) {
  for (int k = 0; k < hb_pool_threads(s->pool); k++) {
    hb_lane_worker *w = &s->workers[k];
    w->stepper = *s;
    w->state = *s->state;
    w->stepper.state = &w->state;
    w->failed = -1;
    w->err = (hb_error){HB_OK, ""};
    if (k == 0) continue;
    w->stepper.rod_work = w->rod_work;
    w->stepper.project_work = w->project_work;
    w->stepper.timed = false;
  }
}

/* Long rods one after the other, each by all threads; the others side by side. The earliest failure counts.
 */
static hb_status step_units(hb_stepper *s, double h, const hb_scheme *scheme, hb_error *err) {
  units_step step = {s, h, (long)s->state->scalar[HB_S_STEP], scheme};
  ready_workers(s);
  for (int k = 0; k < s->plan->unit_count; k++)
    if (s->plan->units[k].strip_count >= HB_SHARED_STRIPS) step_unit(&step, k, 0, true);
  hb_pool_run(s->pool, s->plan->unit_count, step_small_unit, &step);
  const hb_lane_worker *first = NULL;
  for (int k = 0; k < hb_pool_threads(s->pool); k++) {
    const hb_lane_worker *w = &s->workers[k];
    if (w->failed >= 0 && (!first || w->failed_step < first->failed_step ||
                           (w->failed_step == first->failed_step && w->failed < first->failed)))
      first = w;
  }
  memcpy(s->stage_seconds, s->workers->stepper.stage_seconds, sizeof s->stage_seconds);
  if (first) {
    s->failed_step = first->failed_step;
    s->failed_unit = first->failed;
    s->lanes_finite = first->status != HB_OK;
    if (err && first->status) *err = first->err;
    return first->status;
  }
  for (int k = 0; k < s->block; k++) {
    s->length_error = 0;
    for (int n = 0; n < s->plan->unit_count; n++) add_tally(s, &s->plan->units[n], k);
    if (s->length_error > s->worst_error) s->worst_error = s->length_error;
  }
  return HB_OK;
}

/* May several steps be taken at once? */
bool hb_stepper_may_block(const hb_stepper *s) {
  for (int r = 0; r < s->model->rod_count; r++)
    if (!s->plan || s->plan->unit_of[r] < 0) return false;
  return true;
}

/* Lanes first, then the others in their order. */
hb_status hb_step_rods(hb_stepper *s, double h, const hb_scheme *scheme, hb_error *err) {
  double t = (s->state->scalar[HB_S_STEP] + 1) * h;
  hb_status status = HB_OK;
  s->lanes_finite = true;
  s->length_error = s->worst_error = 0;
  s->failed_step = 0;
  s->failed_unit = -1;
  if (s->plan) {
    load_lanes(s);
    s->state_current = false;
    hb_stepper_look_at_forces(s, h);
    status = step_units(s, h, scheme, err);
  }
  for (int r = 0; !status && r < s->model->rod_count; r++)
    if (!s->plan || s->plan->unit_of[r] < 0) status = scheme->step_rod(s, &s->model->rods[r], t, h, err);
  if (s->length_error > s->worst_error) s->worst_error = s->length_error;
  return status;
}
