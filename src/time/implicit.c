/* Implicit schemes over all rods: workspace, threads, totals. Rods are solved one by one, each by one thread,
 * so a run has the same bits for any number of threads. */
#include "time/implicit.h"

#include "base/memory.h"
#include "time/integrators.h"

#include <math.h>
#include <string.h>

/* Vertices in all below which a step is too short to be shared. */
#define SHARED_VERTICES 200

/* The arrays of all rods in one block. */
static hb_status create_arrays(hb_implicit *im, const hb_model *m, hb_error *err) {
  size_t n = (size_t)m->nv, viscous = m->any_viscosity ? 4 * n : 0, q = 3 * (size_t)m->position_count;
  struct {
    double **array;
    size_t count;
  } arrays[] = {{&im->start.x, 3 * n},
                {&im->start.v, 3 * n},
                {&im->start.a, 3 * n},
                {&im->middle.x, 3 * n},
                {&im->middle.v, 3 * n},
                {&im->middle.a, 3 * n},
                {&im->end.x, 3 * n},
                {&im->end.v, 3 * n},
                {&im->end.a, 3 * n},
                {&im->reach, 3 * n},
                {&im->speed, 3 * n},
                {&im->now, 3 * n},
                {&im->moved, 3 * n},
                {&im->given, 3 * n},
                {&im->balance, 3 * n},
                {&im->load_old, 3 * n},
                {&im->lambda, n},
                {&im->pull, n},
                {&im->omega_start, viscous},
                {&im->omega_now, viscous},
                {&im->rate_start, viscous},
                {&im->rate_middle, viscous},
                {&im->rate_end, viscous},
                {&im->reaction, q},
                {&im->reaction_old, q},
                {&im->torque_old, (size_t)m->frame_count},
                {&im->totals, HB_S_COUNT * (size_t)m->rod_count},
                {&im->length_error, (size_t)m->rod_count}};
  size_t total = 0, count = sizeof arrays / sizeof arrays[0];
  for (size_t k = 0; k < count; k++) total += arrays[k].count;
  im->block = hb_alloc(total, sizeof *im->block);
  if (!im->block) return hb_fail_memory(err, "workspace of the implicit scheme");
  double *next = im->block;
  for (size_t k = 0; k < count; k++) {
    *arrays[k].array = next;
    next += arrays[k].count;
  }
  im->bytes = total * sizeof *im->block;
  hb_status status = hb_state_create(m, &im->begin, err);
  if (!status) status = hb_state_create(m, &im->kept, err);
  if (!status) im->bytes += 2 * im->kept->count * sizeof(double);
  return status;
}

/* Workspaces of one thread. */
static hb_status create_marcher(hb_implicit *im, hb_marcher *w, const hb_model *m, int longest,
                                hb_error *err) {
  hb_status status = hb_rod_work_create(m, &w->rod_work, err);
  if (!status) status = hb_project_work_create(m, &w->project_work, err);
  if (!status) status = hb_kkt_create(longest, &w->kkt, err);
  bool closed = false;
  for (int r = 0; r < m->rod_count; r++) closed = closed || m->rods[r].closed;
  if (!status && closed) status = hb_kkt_add_border(&w->kkt, err);
  if (status) return status;
  size_t unknowns = (size_t)(HB_KKT_STRIDE * longest + HB_KKT_HALF), drag = 9 * (size_t)longest;
  w->kkt.slim = true;
  w->direction = hb_alloc(unknowns, sizeof *w->direction);
  w->drag = hb_alloc(drag, sizeof *w->drag);
  if (!w->direction || !w->drag) return hb_fail_memory(err, "workspace of the implicit scheme");
  im->bytes += sizeof *w + w->rod_work.bytes + w->project_work.bytes + w->kkt.bytes +
               (unknowns + drag) * sizeof(double);
  return HB_OK;
}

/* Threads that a run is worth. */
static int useful_threads(const hb_model *m) {
  int threads = m->def->method.threads > 0 ? m->def->method.threads : hb_processors();
  if (m->nv < SHARED_VERTICES) return 1;
  return threads < m->rod_count ? threads : m->rod_count;
}

/* All of it; what was made is freed with the stepper, also after a failure. */
hb_status hb_stepper_use_implicit(hb_stepper *s, hb_error *err) {
  const hb_model *m = s->model;
  int longest = 0, threads = useful_threads(m);
  for (int r = 0; r < m->rod_count; r++)
    if (m->rods[r].nv > longest) longest = m->rods[r].nv;
  hb_implicit *im = s->implicit = hb_alloc(1, sizeof *im);
  if (!im) return hb_fail_memory(err, "workspace of the implicit scheme");
  hb_status status = create_arrays(im, m, err);
  if (!status && threads > 1) status = hb_pool_create(threads, &im->pool, err);
  if (status) return status;
  threads = hb_pool_threads(im->pool);
  im->marchers = hb_alloc((size_t)threads, sizeof *im->marchers);
  if (!im->marchers) return hb_fail_memory(err, "workspace of the implicit scheme");
  for (int w = 0; !status && w < threads; w++) status = create_marcher(im, &im->marchers[w], m, longest, err);
  return status;
}

/* Frees it; NULL and halves are allowed. */
void hb_implicit_free(hb_implicit *im) {
  if (!im) return;
  for (int w = 0; im->marchers && w < hb_pool_threads(im->pool); w++) {
    hb_rod_work_free(&im->marchers[w].rod_work);
    hb_project_work_free(&im->marchers[w].project_work);
    hb_kkt_free(&im->marchers[w].kkt);
    hb_free(im->marchers[w].direction);
    hb_free(im->marchers[w].drag);
  }
  hb_free(im->marchers);
  hb_pool_free(im->pool);
  hb_state_free(im->begin);
  hb_state_free(im->kept);
  hb_free(im->block);
  hb_free(im);
}

/* Arrays, states, workspaces. */
size_t hb_implicit_bytes(const hb_implicit *im) { return im ? im->bytes : 0; }

/* One step of all rods. */
typedef struct rods_step {
  hb_stepper *s;
  double t, h;
} rods_step;

/* One rod by one thread: its totals go to a place of their own. Of several failures of a thread the first
 * rod's counts. */
static void step_rod(void *context, int index, int worker) {
  const rods_step *step = context;
  hb_implicit *im = step->s->implicit;
  hb_marcher *w = &im->marchers[worker];
  const hb_rod *rod = &step->s->model->rods[index];
  hb_error err = {HB_OK, ""};
  memset(w->totals, 0, sizeof w->totals);
  hb_status status = hb_march_rod(w, rod, step->t, step->h, &err);
  memcpy(im->totals + HB_S_COUNT * index, w->totals, sizeof w->totals);
  im->length_error[index] = hb_project_length_error(step->s->model, rod, step->s->state->x);
  if (!status || w->failed >= 0) return;
  w->failed = index;
  w->status = status;
  w->err = err;
}

/* Threads before a step: the run's stepper and state, with workspaces and totals of their own. */
static void ready_marchers(hb_stepper *s) {
  hb_implicit *im = s->implicit;
  for (int k = 0; k < hb_pool_threads(im->pool); k++) {
    hb_marcher *w = &im->marchers[k];
    w->stepper = *s;
    w->state = *s->state;
    w->state.scalar = w->totals;
    w->stepper.state = &w->state;
    w->stepper.rod_work = w->rod_work;
    w->stepper.project_work = w->project_work;
    w->stepper.timed = s->timed && k == 0;
    w->failed = -1;
  }
}

/* All rods; totals are added in the order of the rods. */
static hb_status step_all(hb_stepper *s, double h, bool second_order, hb_error *err) {
  hb_implicit *im = s->implicit;
  rods_step step = {s, (s->state->scalar[HB_S_STEP] + 1) * h, h};
  im->second_order = second_order;
  s->lanes_finite = true;
  s->length_error = s->worst_error = 0;
  s->failed_step = 0;
  s->failed_unit = -1;
  ready_marchers(s);
  hb_pool_run(im->pool, s->model->rod_count, step_rod, &step);
  const hb_marcher *first = NULL;
  for (int k = 0; k < hb_pool_threads(im->pool); k++) {
    const hb_marcher *w = &im->marchers[k];
    if (w->failed >= 0 && (!first || w->failed < first->failed)) first = w;
  }
  memcpy(s->stage_seconds, im->marchers->stepper.stage_seconds, sizeof s->stage_seconds);
  for (int r = 0; r < s->model->rod_count; r++) {
    for (int k = 0; k < HB_S_COUNT; k++)
      if (k != HB_S_FOLD_SLOT) s->state->scalar[k] += im->totals[HB_S_COUNT * r + k];
    s->length_error = fmax(s->length_error, im->length_error[r]);
  }
  s->worst_error = s->length_error;
  if (first && err) *err = first->err;
  return first ? first->status : HB_OK;
}

/* TR-BDF2. */
static hb_status step_implicit(hb_stepper *s, double h, hb_error *err) { return step_all(s, h, true, err); }

/* Backward Euler. */
static hb_status step_euler(hb_stepper *s, double h, hb_error *err) { return step_all(s, h, false, err); }

const hb_integrator hb_integrator_implicit = {
    "implicit", "TR-BDF2 with exact lengths: second order, stable at any step, hardly damps",
    2,          false,
    true,       step_implicit};
const hb_integrator hb_integrator_backward_euler = {
    "backward-euler", "backward Euler with exact lengths: stable at any step, damps", 1, false, true,
    step_euler};
