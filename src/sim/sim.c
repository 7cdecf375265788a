/* Life of a simulation: create, restore, ask, free. */
#include "sim/sim.h"

#include "base/memory.h"

#include <math.h>
#include <string.h>

const char *const hb_stage_names[HB_STAGE_COUNT] = {"twist", "elastic", "loads", "move", "project"};

/* The integrator that the scene names. */
static hb_status find_integrator(hb_sim *sim, hb_error *err) {
  const hb_method_def *method = &sim->model->def->method;
  const char *name = method->integrator ? method->integrator : "verlet";
  for (int k = 0; hb_integrators[k]; k++)
    if (strcmp(hb_integrators[k]->name, name) == 0) sim->integrator = hb_integrators[k];
  if (sim->integrator) return HB_OK;
  return hb_fail(err, HB_ERR_INPUT,
                 "method.integrator: \"%s\" is not known; symplectic-euler, verlet, "
                 "implicit and backward-euler are",
                 name);
}

/* Everything allocated here; stepping allocates nothing. */
hb_status hb_sim_create(const hb_model *model, hb_sim **out, hb_error *err) {
  *out = NULL;
  hb_sim *sim = hb_alloc(1, sizeof *sim);
  if (!sim) return hb_fail_memory(err, "simulation");
  sim->model = model;
  sim->lane_owner = &sim->stepper;
  hb_status status = find_integrator(sim, err);
  if (!status) status = hb_state_create(model, &sim->state, err);
  if (!status) status = hb_stepper_init(&sim->stepper, model, sim->state, hb_force_terms, err);
  double *const lent[3] = {sim->stepper.v_predicted, sim->stepper.v_old, sim->stepper.x_old};
  if (!status)
    status =
        hb_measure_init(&sim->measure, model, &sim->stepper.rod_work, &sim->stepper.project_work, lent, err);
  if (!status) status = hb_sim_start(sim, err);
  if (!status)
    status = sim->integrator->implicit ? hb_stepper_use_implicit(&sim->stepper, err)
                                       : hb_stepper_use_lanes(&sim->stepper, err);
  if (status) {
    hb_sim_free(sim);
    return status;
  }
  *out = sim;
  return HB_OK;
}

/* Frees all of it. */
void hb_sim_free(hb_sim *sim) {
  if (!sim) return;
  hb_stepper_release(&sim->stepper);
  hb_state_free(sim->state);
  hb_measure_release(&sim->measure);
  hb_free(sim);
}

/* What a caller may ask, each a line. */
const hb_model *hb_sim_model(const hb_sim *sim) { return sim->model; }
double hb_sim_time(const hb_sim *sim) { return sim->state->scalar[HB_S_TIME]; }
long hb_sim_steps(const hb_sim *sim) { return (long)sim->state->scalar[HB_S_STEP]; }

/* The state, to be written to. */
hb_state *hb_sim_state(hb_sim *sim) {
  hb_stepper_state_changed(&sim->stepper);
  return sim->state;
}

/* The state, to be read. What the lanes hold is a part of it: bringing it up to date changes nothing that a
 * caller can see. */
const hb_state *hb_sim_const_state(const hb_sim *sim) {
  hb_stepper_store(sim->lane_owner);
  return sim->state;
}

/* What measuring reads. */
void hb_sim_snapshot(const hb_sim *sim, bool forces, hb_state *to) {
  hb_stepper_snapshot(sim->lane_owner, forces, to);
}

/* How far the initial shape was moved. */
double hb_sim_initial_correction(const hb_sim *sim) { return sim->initial_correction; }

/* Steps until the duration is over. */
long hb_sim_total_steps(const hb_sim *sim) {
  const hb_method_def *method = &sim->model->def->method;
  return (long)ceil(method->duration / method->time_step - 1e-9);
}

/* State and workspaces; measuring borrows them. */
size_t hb_sim_memory(const hb_sim *sim) {
  return sizeof *sim + sizeof *sim->state + sim->state->count * sizeof(double) +
         hb_stepper_memory(&sim->stepper);
}

/* 0 switches the clocks off. */
void hb_sim_time_stages(hb_sim *sim, int every) { sim->time_every = every; }

/* Timed seconds, scaled to all steps taken. */
void hb_sim_stage_seconds(const hb_sim *sim, double seconds[HB_STAGE_COUNT]) {
  double scale = sim->steps_timed > 0 ? (double)sim->steps_taken / (double)sim->steps_timed : 0;
  for (int k = 0; k < HB_STAGE_COUNT; k++) seconds[k] = scale * sim->stepper.stage_seconds[k];
}

/* A saved block comes back. */
hb_status hb_sim_restore(hb_sim *sim, const double *block, size_t count, hb_error *err) {
  if (count != sim->state->count)
    return hb_fail(err, HB_ERR_INPUT,
                   "the saved state has %zu numbers, but this scene needs %zu: it is of another scene", count,
                   sim->state->count);
  memcpy(sim->state->block, block, count * sizeof *block);
  sim->stepper.lanes_current = false;
  sim->stepper.state_current = true;
  return HB_OK;
}
