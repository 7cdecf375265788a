/* The matrices of small motions about an equilibrium, entry by entry, for other programs. */
#include "sim/sim.h"

#include "base/memory.h"
#include "hebra/modes.h"
#include "statics/vibration.h"

#include <string.h>

/* Supports stay where they are. */
static void stay(void *context, const hb_rod *rod, double t) {
  (void)context;
  (void)rod;
  (void)t;
}

/* Room for so many entries. */
static hb_status make(hb_matrix *m, long most, bool symmetric, hb_error *err) {
  m->symmetric = symmetric;
  m->row = hb_alloc((size_t)most, sizeof *m->row);
  m->column = hb_alloc((size_t)most, sizeof *m->column);
  m->value = hb_alloc((size_t)most, sizeof *m->value);
  return m->row && m->column && m->value ? HB_OK : hb_fail_memory(err, "entries of a matrix");
}

/* Frees it. */
static void unmake(hb_matrix *m) {
  hb_free(m->row);
  hb_free(m->column);
  hb_free(m->value);
  m->row = m->column = NULL;
  m->value = NULL;
}

/* One more entry; zeros are none. */
static void put(hb_matrix *m, int row, int column, double value) {
  if (value == 0) return;
  m->row[m->entries] = row;
  m->column[m->entries] = column;
  m->value[m->entries++] = value;
}

/* The same where there may be an entry already: of closed rods, whose last slot is the first. */
static void add_to(hb_matrix *m, int row, int column, double value) {
  int low = row > column ? row : column, left = row > column ? column : row;
  for (long k = 0; k < m->entries; k++)
    if (m->row[k] == low && m->column[k] == left) {
      m->value[k] += value;
      return;
    }
  put(m, low, left, value);
}

/* Numbers of a rod's unknowns in the whole, -1: held, or a multiplier. Adds them to the lists. */
static void number_unknowns(const hb_kkt *kkt, const hb_rod *rod, int *number, hb_matrices *out) {
  int beyond = kkt->closed ? HB_KKT_STRIDE : 0; /* columns behind the last */
  for (int k = 0; k < kkt->matrix.n + beyond; k++) {
    int i = k / HB_KKT_STRIDE, part = k % HB_KKT_STRIDE, other = hb_kkt_fold(kkt, k);
    number[k] = other == k ? -1 : number[other];
    if (other != k) continue;
    if (part == HB_KKT_MULTIPLIER || kkt->weight[k] == 0) continue;
    out->slot[out->K.rows] = rod->first + i;
    out->component[out->K.rows] = part == HB_KKT_TURN ? 3 : part;
    number[k] = out->K.rows++;
  }
}

/* Entries of the band: those of multipliers' rows are gradients, the others stiffness. */
static void sort_entries(const hb_statics *s, const hb_rod *rod, const int *number, hb_matrices *out) {
  const hb_kkt *kkt = &s->kkt;
  size_t width = (size_t)kkt->matrix.half + 1;
  int end = kkt->matrix.n + (kkt->closed ? HB_KKT_STRIDE : 0);
  for (int column = 0; column < end; column++)
    for (int k = 0; k < (int)width && column + k < end; k++) {
      int row = column + k;
      if (number[row] < 0 || number[column] < 0) continue;
      if (hb_kkt_fold(kkt, row) != row || hb_kkt_fold(kkt, column) != column)
        add_to(&out->K, number[row], number[column], kkt->matrix.a[width * (size_t)column + (size_t)k]);
      else
        put(&out->K, number[row], number[column], kkt->matrix.a[width * (size_t)column + (size_t)k]);
    }
  for (int j = 0; j + 1 < rod->nv; j++) {
    int row = HB_KKT_STRIDE * (j + 1) + HB_KKT_MULTIPLIER;
    long before = out->G.entries;
    for (int column = HB_KKT_STRIDE * j; column < row; column++)
      if (number[column] >= 0)
        put(&out->G, out->G.rows, number[column],
            kkt->matrix.a[width * (size_t)column + (size_t)(row - column)]);
    if (out->G.entries > before) out->edge[out->G.rows++] = rod->first + j;
  }
}

/* One rod at the equilibrium. */
static hb_status add_rod(hb_statics *s, const hb_rod *rod, double t, const hb_equilibrium *at, int *number,
                         double *mass, hb_matrices *out, hb_error *err) {
  s->kkt.augment = 0; /* the stiffness itself */
  hb_status status = hb_vibration_assemble(s, rod, t, at->multiplier + rod->first, err);
  if (status) return status;
  number_unknowns(&s->kkt, rod, number, out);
  (void)hb_vibration_masses(s, rod, mass);
  for (int k = 0; k < s->kkt.matrix.n; k++)
    if (number[k] >= 0 && hb_kkt_fold(&s->kkt, k) == k)
      put(&out->M, number[k], number[k], mass[k]);
    else if (number[k] >= 0)
      add_to(&out->M, number[k], number[k], mass[k]);
  sort_entries(s, rod, number, out);
  return HB_OK;
}

/* Rod after rod, each in its own block. */
hb_status hb_sim_find_matrices(hb_sim *sim, const hb_equilibrium *at, hb_matrices *out, hb_error *err) {
  const hb_model *m = sim->model;
  hb_statics s;
  memset(out, 0, sizeof *out);
  memset(&s, 0, sizeof s);
  (void)hb_sim_state(sim);
  long nv = m->nv;
  hb_status status = hb_statics_create(&s, m, sim->state, hb_force_terms, stay, NULL, err);
  if (!status) status = make(&out->M, 3 * nv, true, err);
  if (!status) status = make(&out->K, (long)HB_KKT_STRIDE * (HB_KKT_HALF + 1) * nv, true, err);
  if (!status) status = make(&out->G, 6 * nv, false, err);
  out->slot = hb_alloc(4 * (size_t)nv, sizeof *out->slot);
  out->component = hb_alloc(4 * (size_t)nv, sizeof *out->component);
  out->edge = hb_alloc((size_t)nv, sizeof *out->edge);
  size_t size = (size_t)HB_KKT_STRIDE * (size_t)(status ? 1 : s.kkt.capacity + 1);
  int *number = hb_alloc(size, sizeof *number);
  double *mass = hb_alloc(size, sizeof *mass);
  if (!status && (!out->slot || !out->component || !out->edge || !number || !mass))
    status = hb_fail_memory(err, "numbers of unknowns");
  for (int r = 0; !status && r < m->rod_count; r++)
    status = add_rod(&s, &m->rods[r], sim->state->scalar[HB_S_TIME], at, number, mass, out, err);
  out->M.rows = out->M.columns = out->K.columns = out->G.columns = out->K.rows;
  hb_free(number);
  hb_free(mass);
  hb_statics_free(&s);
  return status;
}

/* The arrays that it owns. */
void hb_matrices_free(hb_matrices *matrices) {
  if (!matrices) return;
  unmake(&matrices->M);
  unmake(&matrices->K);
  unmake(&matrices->G);
  hb_free(matrices->slot);
  hb_free(matrices->component);
  hb_free(matrices->edge);
  matrices->slot = matrices->component = matrices->edge = NULL;
}
