/* Why a step failed: what can be told from the model alone. */
#include "cli/advice.h"

#include "base/memory.h"
#include "math/rotation.h"
#include "output/report.h"
#include "time/stepper.h"

#include <stdio.h>

/* Places of all prescribed vertices of a rod at time t into x. */
static void place(const hb_model *m, const hb_rod *rod, double t, double *x) {
  for (int n = rod->first_position; n < rod->first_position + rod->position_count; n++) {
    const hb_position_support *p = &m->positions[n];
    const double still[3] = {0, 0, 0};
    double rate[3] = {0, 0, 0};
    hb_support_at(m, p, t, x + 3 * (p->tangent ? p->base : p->slot), still, x + 3 * p->slot, rate);
  }
}

/* True if x, y and z of a vertex are prescribed. */
static bool pinned(const hb_model *m, int k) {
  return m->inv_mass[3 * k] == 0 && m->inv_mass[3 * k + 1] == 0 && m->inv_mass[3 * k + 2] == 0;
}

/* Neighbouring pinned vertices of a rod that the rod cannot join. */
static void tell_reach(const hb_model *m, const hb_rod *rod, double t, const double *x) {
  int last = -1;
  for (int k = rod->first; k < rod->first + rod->nv; k++) {
    if (!pinned(m, k)) continue;
    double length = last < 0 ? 0 : m->arc[k] - m->arc[last];
    double distance = last < 0 ? 0 : hb_v3_norm(hb_v3_sub(hb_v3_load(x + 3 * k), hb_v3_load(x + 3 * last)));
    if (distance > length * (1 + 1e-9))
      fprintf(stderr,
              "hebra run: rod %s: at t = %.9g the supports hold vertices %d and %d %.9g apart, but the rod "
              "between "
              "them is only %.9g long\n",
              rod->name, t, last - rod->first, k - rod->first, distance, length);
    last = k;
  }
}

/* Both causes. */
void cli_advice(const hb_sim *sim) {
  const hb_model *m = hb_sim_model(sim);
  char text[HB_REPORT_SENTENCE];
  double t = (double)(hb_sim_steps(sim) + 1) * m->def->method.time_step;
  double *x = hb_alloc(3 * (size_t)m->nv, sizeof *x);
  if (hb_report_step_warning(m, text)) fprintf(stderr, "hebra run: %s\n", text);
  for (int r = 0; x && r < m->rod_count; r++) {
    place(m, &m->rods[r], t, x);
    tell_reach(m, &m->rods[r], t, x);
  }
  hb_free(x);
}
