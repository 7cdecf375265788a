/* Which modes there are, and the proof that none was missed (docs/theory, 14.2, 14.4). */
#include "statics/vibration.h"

#include "base/memory.h"
#include "math/vec3.h"

#include <float.h>
#include <math.h>
#include <string.h>

/* Stiffness that unbalanced forces may feign, in units of residual/(edge length * rod length). */
#define UNBALANCED 30
/* Steps of one run beyond three for each mode, and at most. */
enum { STEPS_MORE = 40, STEPS_MOST = 240, RUNS_MOST = 200 };
/* omega^2 that are closer than this part of themselves, or of the scale, count as one for the search. */
#define APART 1e-6
/* What holds a frame that nothing holds, as a part of what its neighbours hold it with; and what of that is
 * round-off, when all frames turn together. */
#define HOLD 1e-10
#define FREE 1e-13

/* Turns have none. */
long hb_vibration_masses(const hb_statics *s, const hb_rod *rod, double *mass) {
  const hb_model *m = s->model;
  long count = 0;
  memset(mass, 0, (size_t)s->kkt.matrix.n * sizeof *mass);
  for (int i = 0; i < rod->nv; i++)
    for (int c = 0; c < 3; c++) {
      if (s->kkt.weight[HB_KKT_STRIDE * i + c] == 0) continue;
      mass[HB_KKT_STRIDE * i + c] = m->mass[rod->first + i];
      if (!rod->closed || i + 1 < rod->nv) count++; /* the last slot is the first vertex */
    }
  return count;
}

/* Can all frames be turned at once for nothing? So it is where the section is round and no frame is held, if
 * the rod is straight at rest. */
static bool frames_free(hb_kkt *kkt, const hb_rod *rod) {
  double *turns = kkt->scratch, *torque = kkt->right, sum = 0, size = 0;
  if (rod->closed_form || rod->frame_count > 0) return false;
  memset(turns, 0, (size_t)kkt->matrix.n * sizeof *turns);
  for (int j = 0; j + 1 < rod->nv; j++) turns[HB_KKT_STRIDE * j + HB_KKT_TURN] = kkt->unknown[j];
  if (rod->closed) turns[HB_KKT_STRIDE * (rod->nv - 1) + HB_KKT_TURN] = turns[HB_KKT_TURN];
  hb_kkt_multiply(kkt, turns, torque);
  for (int k = HB_KKT_TURN; k < kkt->matrix.n; k += HB_KKT_STRIDE) {
    sum += turns[k] * torque[k];
    size += fabs(kkt->matrix.a[(size_t)(kkt->matrix.half + 1) * (size_t)k]);
  }
  return !(fabs(sum) > FREE * size);
}

/* Frames that turn for nothing would make the matrix singular, since they have no mass: one is held. Where
 * they do not, none is: a frame turns with a rod that moves rigidly. */
hb_status hb_vibration_assemble(hb_statics *s, const hb_rod *rod, double t, const double *multiplier,
                                hb_error *err) {
  hb_kkt_begin(&s->kkt, s->model, rod);
  hb_status status = hb_statics_evaluate(s, rod, t, err);
  if (status) return status;
  hb_kkt_assemble(&s->kkt, s->model, rod, s->state, &s->rod_work, t, multiplier, NULL);
  if (frames_free(&s->kkt, rod)) {
    double *at = s->kkt.matrix.a + (size_t)(s->kkt.matrix.half + 1) * HB_KKT_TURN;
    at[0] += HOLD * at[0];
  }
  return HB_OK;
}

/* Bending, loads and tensions over the mass, and the round-off of the largest stiffness over its mass. */
static void find_scales(hb_vibration *v, const double *multiplier, double residual) {
  const hb_model *m = v->statics->model;
  const hb_rod *rod = v->rod;
  double B = 0, load = 0, pull = 0, mass = 0, shortest = rod->length, length = rod->length, stretching = 0;
  for (int k = rod->first; k + 1 < rod->first + rod->nv; k++) {
    B = fmax(B, fmax(m->B[3 * k], m->B[3 * k + 2]));
    double strain =
        rod->extensible ? hb_stretch_strain(m, k, v->statics->rod_work.inv_length[k - rod->first]) : 0;
    pull = fmax(pull, 2 * fabs(multiplier[k - rod->first]) + fabs(m->stretching[k] * strain));
    stretching = fmax(stretching, m->stretching[k]);
    shortest = fmin(shortest, m->rest_length[k]);
  }
  for (int k = rod->first; k < rod->first + rod->nv; k++) {
    load += hb_v3_norm(hb_v3_load(v->statics->state->load + 3 * k));
    mass += m->mass[k];
  }
  double unit = fmax(B / (length * length), fmax(load, pull));
  if (!(unit > 0)) unit = stretching;
  v->scale = unit > 0 ? unit / (length * mass) : 1;
  v->stray = UNBALANCED * residual / (shortest * length);
  const hb_band *K = &v->statics->kkt.matrix;
  v->round_off = 0;
  for (int k = 0; k < v->size; k++)
    if (v->mass[k] > 0)
      v->round_off =
          fmax(v->round_off, 4 * DBL_EPSILON * fabs(K->a[(size_t)(K->half + 1) * (size_t)k]) / v->mass[k]);
}

/* One block for all arrays of numbers. */
static hb_status allocate(hb_vibration *v, int count, hb_error *err) {
  size_t n = (size_t)v->size;
  long steps = 3L * count + STEPS_MORE;
  if (steps > STEPS_MOST) steps = STEPS_MOST;
  if (steps > v->freedom) steps = v->freedom;
  v->steps_room = (int)steps;
  long room = count + 2 * steps;
  v->room = room < v->freedom ? (int)room : (int)v->freedom;
  size_t s = (size_t)v->steps_room, r = (size_t)v->room;
  v->block = hb_alloc(n * (r + s + 2) + s * s + 6 * s + 2 * r + 2, sizeof *v->block);
  v->order = hb_alloc(r + 1, sizeof *v->order);
  if (!v->block || !v->order) return hb_fail_memory(err, "vectors of the modes");
  v->vector = v->block;
  v->trial = v->vector + n * r;
  v->basis = v->trial + n; /* steps + 1 vectors, then steps^2 numbers */
  v->diagonal = v->basis + n * (s + 1) + s * s;
  v->beside = v->diagonal + s;
  v->ritz = v->beside + s; /* 2 steps */
  v->square = v->ritz + 2 * s;
  v->error = v->square + r;
  return HB_OK;
}

/* Places for everything; no search yet. */
hb_status hb_vibration_begin(hb_vibration *v, hb_statics *statics, const hb_rod *rod, double t,
                             const double *multiplier, double residual, int count, hb_error *err) {
  memset(v, 0, sizeof *v);
  v->statics = statics;
  v->rod = rod;
  hb_status status = hb_vibration_assemble(statics, rod, t, multiplier, err);
  if (status) return status;
  v->size = statics->kkt.matrix.n;
  v->mass = hb_alloc((size_t)v->size, sizeof *v->mass);
  if (!v->mass) return hb_fail_memory(err, "masses of the modes");
  v->freedom = hb_vibration_masses(statics, rod, v->mass) - statics->kkt.constraints;
  if (v->freedom < 0) v->freedom = 0;
  find_scales(v, multiplier, residual);
  return allocate(v, count, err);
}

/* Also after a failed begin. */
void hb_vibration_end(hb_vibration *v) {
  hb_free(v->block);
  hb_free(v->order);
  hb_free(v->mass);
}

/* The metric of the factors is the mass here. */
int hb_vibration_count(hb_vibration *v, double square) {
  hb_kkt *kkt = &v->statics->kkt;
  double *kept = kkt->weight;
  kkt->weight = v->mass;
  int below = hb_kkt_factor(kkt, -square);
  kkt->weight = kept;
  v->factorisations++;
  return below;
}

/* Sizes of the terms that the energy of the mode is the sum of. */
double hb_vibration_resolution(const hb_vibration *v, int found) {
  const hb_kkt *kkt = &v->statics->kkt;
  const double *a = v->vector + (size_t)v->size * (size_t)found;
  size_t width = (size_t)kkt->matrix.half + 1;
  double sum = 0, metric = 0;
  for (int j = 0; j < v->size; j++) {
    const double *column = kkt->matrix.a + width * (size_t)j;
    double part = 0.5 * fabs(column[0] * a[j]);
    for (int k = 1; k < (int)width && j + k < v->size; k++) part += fabs(column[k] * a[j + k]);
    sum += 2 * fabs(a[j]) * part;
    metric += kkt->weight[j] * a[j] * a[j];
  }
  return 32 * DBL_EPSILON * sum + v->stray * metric;
}

/* How far apart two omega^2 are told apart. */
static double apart(const hb_vibration *v, double square) {
  return APART * (fabs(square) + v->scale) + 10 * v->round_off;
}

/* omega^2 between the first `lower` found ones and the others; not a number if they are too close. */
static double between(const hb_vibration *v, int lower) {
  if (lower == 0) return -HUGE_VAL;
  double below = v->square[v->order[lower - 1]];
  if (lower == v->found) return below + 2 * apart(v, below);
  double above = v->square[v->order[lower]];
  return above - below > apart(v, above) ? 0.5 * (above + below) : (double)NAN;
}

/* The longest run of lowest found modes in which none is missing. The number of those missing below a place
 * only grows with the place. */
static int proven(hb_vibration *v) {
  int sure = 0, doubtful = v->found + 1;
  while (doubtful - sure > 1) {
    int middle = (sure + doubtful) / 2, at = middle;
    while (at < doubtful && isnan(between(v, at))) at++;
    if (at == doubtful) { /* nothing to ask about from here on: look below */
      for (at = middle - 1; at > sure && isnan(between(v, at));) at--;
      if (at == sure) break;
    }
    if (hb_vibration_count(v, between(v, at)) == at)
      sure = at;
    else
      doubtful = at;
  }
  return sure;
}

/* Where to look next: among those that are missing. */
static double next_shift(const hb_vibration *v, int sure, double lowest, int fruitless) {
  double away = pow(8, fruitless);
  if (sure == 0) return lowest * (1 + 0.37 * fruitless);
  if (sure < v->found) return between(v, sure) + 3.7 * fruitless * apart(v, v->square[v->order[sure - 1]]);
  double last = v->square[v->order[sure - 1]], before = v->square[v->order[sure > 6 ? sure - 7 : 0]];
  return last + away * fmax(0.2 * (last - before), fmax(20 * apart(v, last), v->scale));
}

/* Forgets the highest ones where the next run may need their places. */
static void make_room(hb_vibration *v) {
  while (v->found > 0 && v->room - v->found < v->steps_room && v->freedom > v->room) {
    int last = v->order[--v->found], moved = v->found; /* the place that is given up is the last one */
    if (last == moved) continue;
    size_t n = (size_t)v->size;
    memcpy(v->vector + n * (size_t)last, v->vector + n * (size_t)moved, n * sizeof *v->vector);
    v->square[last] = v->square[moved];
    v->error[last] = v->error[moved];
    for (int k = 0; k < v->found; k++)
      if (v->order[k] == moved) v->order[k] = last;
  }
}

/* Below all modes. A negative count: the lengths leave no room; none below anything: frames are not where
 * their energy is least. */
static hb_status find_lowest(hb_vibration *v, double *lowest, hb_error *err) {
  *lowest = -v->scale;
  for (int attempt = 0; attempt < 60; attempt++, *lowest *= 8) {
    int below = hb_vibration_count(v, *lowest);
    if (below == 0) return HB_OK;
    if (below < 0)
      return hb_fail(err, HB_ERR_NUMERIC, "rod %s: the lengths cannot be kept: its supports leave it no room",
                     v->rod->name);
  }
  return hb_fail(err, HB_ERR_NUMERIC, "rod %s: its material frames are not in stable equilibrium",
                 v->rod->name);
}

/* Modes of the same frequency stand together. */
static void tidy(hb_vibration *v) {
  for (int from = 0; from < v->found;) {
    int to = from + 1;
    double first = v->square[v->order[from]];
    while (to < v->found && v->square[v->order[to]] - first <= 1e-8 * (fabs(first) + v->scale) + v->round_off)
      to++;
    hb_vibration_align(v, from, to);
    from = to;
  }
}

/* Runs until the proof is there. */
hb_status hb_vibration_find(hb_vibration *v, int count, hb_error *err) {
  int wanted = count < v->freedom ? count : (int)v->freedom, sure = 0, fruitless = 0;
  double lowest;
  if (wanted == 0) return HB_OK;
  hb_status status = find_lowest(v, &lowest, err);
  if (status) return status;
  double shift = lowest;
  for (int run = 0; run < RUNS_MOST; run++) {
    make_room(v);
    int more = wanted - sure,
        fresh = hb_vibration_lanczos(v, shift, more < v->steps_room ? more : v->steps_room);
    fruitless = fresh > 0 ? 0 : fruitless + 1;
    sure = proven(v);
    if (sure >= wanted) {
      tidy(v);
      return HB_OK;
    }
    if (fruitless == 8) break;
    shift = next_shift(v, sure, lowest, fruitless);
  }
  return hb_fail(err, HB_ERR_NUMERIC,
                 "rod %s: of the %d lowest modes only %d are certain; some are missing above omega^2 = %.9g",
                 v->rod->name, wanted, sure, sure > 0 ? v->square[v->order[sure - 1]] : lowest);
}
