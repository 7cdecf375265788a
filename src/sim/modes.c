/* Modes of a simulation at an equilibrium: the search of the statics room rod by rod, brought into one list.
 */
#include "sim/sim.h"

#include "base/memory.h"
#include "hebra/modes.h"
#include "statics/vibration.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Supports stay where they are. */
static void stay(void *context, const hb_rod *rod, double t) {
  (void)context;
  (void)rod;
  (void)t;
}

/* The workspace of statics on the state of sim. */
static hb_status begin(hb_sim *sim, hb_statics *s, hb_error *err) {
  (void)hb_sim_state(sim); /* rods may be elsewhere in lanes */
  memset(s, 0, sizeof *s);
  return hb_statics_create(s, sim->model, sim->state, hb_force_terms, stay, NULL, err);
}

/* Of a vibration, and of a mode that grows. */
double hb_mode_omega(const hb_mode *mode) { return hb_mode_kind(mode) == 0 ? 0 : sqrt(fabs(mode->square)); }

/* To its own resolution. */
int hb_mode_kind(const hb_mode *mode) {
  return mode->square < -mode->resolution ? -1 : mode->square > mode->resolution;
}

/* Copies one found mode, its largest displacement positive. room: 4 doubles per vertex. */
static void copy_mode(const hb_vibration *v, int found, double *room, hb_mode *out) {
  const double *a = v->vector + (size_t)v->size * (size_t)found;
  int nv = v->rod->nv;
  double largest = 0;
  for (int i = 0; i < nv; i++)
    for (int c = 0; c < 3; c++)
      if (fabs(a[HB_KKT_STRIDE * i + c]) > 1.000001 * fabs(largest)) largest = a[HB_KKT_STRIDE * i + c];
  double sign = largest < 0 ? -1 : 1;
  *out = (hb_mode){.rod = v->rod->index,
                   .square = v->square[found],
                   .resolution = hb_vibration_resolution(v, found),
                   .error = v->error[found],
                   .shape = room,
                   .turn = room + 3 * nv};
  for (int i = 0; i < nv; i++) {
    for (int c = 0; c < 3; c++) out->shape[3 * i + c] = sign * a[HB_KKT_STRIDE * i + c];
    out->turn[i] = i + 1 < nv && v->statics->kkt.unknown[i] ? sign * a[HB_KKT_STRIDE * i + HB_KKT_TURN] : 0;
  }
}

/* By omega^2, then by rod. */
static int by_square(const void *left, const void *right) {
  const hb_mode *a = left, *b = right;
  if (a->square != b->square) return a->square < b->square ? -1 : 1;
  return (a->rod > b->rod) - (a->rod < b->rod);
}

/* How many of a rod's modes the equilibrium is left by. Where all that were looked for are such there may be
 * more: the inertia knows. */
static int count_unstable(hb_vibration *v, int looked_for) {
  int count = 0;
  double blurred = 0;
  for (int k = 0; k < v->found; k++) {
    blurred = hb_vibration_resolution(v, v->order[k]);
    if (!(v->square[v->order[k]] < -blurred)) return count;
    count++;
  }
  return count < looked_for || count == v->freedom ? count : hb_vibration_count(v, -blurred);
}

/* The lowest modes of one rod behind those that are there already; the `count` lowest of all are kept. */
static hb_status add_rod(hb_statics *s, const hb_rod *rod, double t, const hb_equilibrium *at, int count,
                         double *rooms, hb_modes *out, hb_error *err) {
  hb_vibration v;
  hb_status status = hb_vibration_begin(&v, s, rod, t, at->multiplier + rod->first, at->residual, count, err);
  if (!status) status = hb_vibration_find(&v, count, err);
  if (!status) {
    out->freedom += v.freedom;
    out->unstable += count_unstable(&v, count);
    out->solves += v.solves;
    out->factorisations += v.factorisations;
    int most = v.found < count ? v.found : count;
    for (int k = 0; k < most; k++) {
      hb_mode mode;
      double *room = rooms;
      if (out->count == count) { /* takes the place of the highest, or has none */
        if (v.square[v.order[k]] >= out->mode[count - 1].square) break;
        room = out->mode[--out->count].shape;
      } else
        room += (size_t)out->count * 4 * (size_t)(s->kkt.capacity);
      copy_mode(&v, v.order[k], room, &mode);
      out->mode[out->count++] = mode;
      qsort(out->mode, (size_t)out->count, sizeof *out->mode, by_square);
    }
  }
  hb_vibration_end(&v);
  return status;
}

/* Rod after rod. */
hb_status hb_sim_find_modes(hb_sim *sim, const hb_equilibrium *at, int count, hb_modes *out, hb_error *err) {
  const hb_model *m = sim->model;
  hb_statics s;
  memset(out, 0, sizeof *out);
  if (count < 1) return hb_fail(err, HB_ERR_INPUT, "%d modes are asked for; at least 1 is allowed", count);
  long freedom = 0;
  for (int k = 0; k < 3 * m->nv; k++) freedom += m->inv_mass[k] != 0;
  if (count > freedom) count = freedom > 0 ? (int)freedom : 1;
  hb_status status = begin(sim, &s, err);
  if (!status) {
    out->block = hb_alloc((size_t)count * 4 * (size_t)s.kkt.capacity, sizeof *out->block);
    out->mode = hb_alloc((size_t)count, sizeof *out->mode);
    if (!out->block || !out->mode) status = hb_fail_memory(err, "modes");
  }
  for (int r = 0; !status && r < m->rod_count; r++)
    status = add_rod(&s, &m->rods[r], sim->state->scalar[HB_S_TIME], at, count, out->block, out, err);
  for (int k = 0; !status && k < out->count; k++) out->rigid += hb_mode_kind(&out->mode[k]) == 0;
  hb_statics_free(&s);
  return status;
}

/* The arrays that it owns. */
void hb_modes_free(hb_modes *modes) {
  if (!modes) return;
  hb_free(modes->block);
  hb_free(modes->mode);
  modes->block = NULL;
  modes->mode = NULL;
  modes->count = 0;
}

/* Displaces the rod: lengths come right by what costs least energy, as in a search for an equilibrium. */
static hb_status displace(hb_statics *s, const hb_rod *rod, double t, const hb_equilibrium *at,
                          const hb_mode *mode, double factor, hb_error *err) {
  hb_equilibrium costs;
  double change;
  memset(&costs, 0, sizeof costs);
  hb_status status = hb_vibration_assemble(s, rod, t, at->multiplier + rod->first, err);
  if (status) return status;
  double scale = 0; /* of the largest stiffness: the matrix must be safe to factor, no more */
  for (int k = 0; k < s->kkt.matrix.n; k++)
    if (s->kkt.weight[k] > 0)
      scale =
          fmax(scale, fabs(s->kkt.matrix.a[(size_t)(s->kkt.matrix.half + 1) * (size_t)k]) / s->kkt.weight[k]);
  if (hb_statics_factor(s, rod, 1e-12 * scale, false, &costs) < 0)
    return hb_fail(err, HB_ERR_NUMERIC, "rod %s: the lengths cannot be kept", rod->name);
  for (int i = 0; i < rod->nv; i++) {
    double *d = s->direction + HB_KKT_STRIDE * i;
    for (int c = 0; c < 3; c++) d[c] = factor * mode->shape[3 * i + c];
    d[HB_KKT_MULTIPLIER] = 0;
    d[HB_KKT_TURN] = factor * mode->turn[i];
  }
  memcpy(s->multiplier + rod->first, at->multiplier + rod->first, (size_t)rod->nv * sizeof(double));
  hb_statics_keep(s, rod);
  if (factor == 0 || hb_statics_try(s, rod, t, 1, &change)) return HB_OK;
  return hb_fail(
      err, HB_ERR_INPUT,
      "rod %s: its lengths cannot be restored so far from the equilibrium; a smaller amplitude is needed",
      rod->name);
}

/* The state is put back from a copy. */
hb_status hb_sim_measure_mode(hb_sim *sim, const hb_equilibrium *at, const hb_mode *mode, double amplitude,
                              double phase, hb_frame *frame, hb_error *err) {
  const hb_rod *rod = &sim->model->rods[mode->rod];
  hb_statics s;
  hb_state *kept = NULL;
  double largest = 0, omega = hb_mode_omega(mode), t = sim->state->scalar[HB_S_TIME];
  for (int i = 0; i < rod->nv; i++) {
    const double *d = mode->shape + 3 * i;
    largest = fmax(largest, sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]));
  }
  if (!(largest > 0)) return hb_fail(err, HB_ERR_INPUT, "the mode has no shape");
  hb_status status = begin(sim, &s, err);
  if (!status) status = hb_state_create(sim->model, &kept, err);
  if (!status) {
    hb_state_copy(kept, sim->state);
    double factor = amplitude / largest;
    status = displace(&s, rod, t, at, mode, factor * cos(phase), err);
    for (int k = 0; hb_mode_kind(mode) > 0 && k < 3 * rod->nv; k++)
      sim->state->v[3 * rod->first + k] = -factor * omega * sin(phase) * mode->shape[k];
    sim->state->scalar[HB_S_TIME] = phase / (hb_mode_kind(mode) > 0 ? omega : 6.283185307179586);
    if (!status) hb_sim_measure(sim, frame);
    frame->balance = 0;
    hb_state_copy(sim->state, kept);
  }
  hb_state_free(kept);
  hb_statics_free(&s);
  return status;
}
