/* Passes over the strips of a unit, and what they find. */
#include "time/journey.h"

#include <string.h>

/* May lengths be off by so much that 1/|e| needs a root? (docs/theory, 10.4) */
static bool coarse_lengths(const hb_journey *j) {
  const hb_method_def *method = &j->s->model->def->method;
  return method->length_tolerance_kind != HB_TOLERANCE_RELATIVE ||
         method->length_tolerance > (j->k->single ? 1e-4 : 5e-9);
}

/* One pass over one strip. */
static void do_pass(const hb_journey *j, hb_strip *s, hb_pass which) {
  double half = 0.5 * j->h;
  switch (which) {
  case ADVANCE: j->k->advance(s, j->along ? half : j->h, j->h, j->along); break;
  case ELIMINATE: j->k->eliminate(s, j->along); break;
  case SPREAD: j->k->spread(s, j->along, 1 / j->h); break;
  case RATES: j->k->eliminate_rates(s, half, 1 / j->h); break;
  case SPREAD_RATES: j->k->spread_rates(s); break;
  case TRANSPORT: j->k->transport(s, coarse_lengths(j)); break;
  case FLEX: j->k->flex(s, coarse_lengths(j)); break;
  case ELASTIC: j->k->elastic(s, coarse_lengths(j)); break;
  case CARRY: j->k->carry(s, coarse_lengths(j)); break;
  case FIRST_LOOK: j->k->look(s, true); break;
  case LOOK: j->k->look(s, false); break;
  case SOLVE_TURNS: j->k->solve_turns(s); break;
  case TURN: j->k->turn(s); break;
  case GENERAL: j->k->general(s); break;
  case LOADS: j->k->loads(s, j->h, j->along); break;
  case SUM_UP: j->k->sum_up(s); break;
  }
}

/* A pass as the pool wants it. */
typedef struct pass_task {
  const hb_journey *j;
  hb_pass which;
} pass_task;

/* One strip of it. */
static void pass_strip(void *context, int index, int worker) {
  const pass_task *task = context;
  (void)worker;
  do_pass(task->j, &task->j->u->strips[index], task->which);
}

/* One pass over all strips; by all threads where the unit has many and the threads have nothing else to do.
 */
void hb_journey_pass(const hb_journey *j, hb_pass which) {
  pass_task task = {j, which};
  hb_pool_run(j->u->strip_count >= HB_SHARED_STRIPS ? j->s->pool : NULL, j->u->strip_count, pass_strip,
              &task);
}

/* A strip's record in every lane. */
void hb_journey_set(hb_unit *u, size_t record, double value) {
  for (int g = 0; g < u->strip_count; g++) {
    void *array;
    memcpy(&array, (char *)&u->strips[g] + record, sizeof array);
    for (int l = 0; l < u->strips[g].lanes; l++) hb_strip_set(&u->strips[g], array, 0, l, value);
  }
}

/* Largest of a record over the lanes of a rod in pieces, or in one lane of a bundle; not-a-number stays. */
double hb_journey_largest(const hb_unit *u, size_t record, int lane) {
  double worst = 0;
  if (!u->pieces) {
    void *array;
    memcpy(&array, (const char *)u->strips + record, sizeof array);
    return hb_strip_get(u->strips, array, 0, lane);
  }
  for (int g = 0; g < u->strip_count; g++) {
    void *array;
    memcpy(&array, (const char *)&u->strips[g] + record, sizeof array);
    for (int l = 0; l < u->strips[g].lanes; l++) {
      double value = hb_strip_get(&u->strips[g], array, 0, l);
      if (!(value <= worst)) worst = value;
      if (worst != worst) return worst;
    }
  }
  return worst;
}

/* Had all rows of a rod sound pivots? */
bool hb_journey_full(const hb_unit *u, int lane) {
  for (int g = 0; g < u->strip_count; g++)
    for (int l = u->pieces ? 0 : lane; l < (u->pieces ? u->strips[g].lanes : lane + 1); l++)
      if (!(hb_strip_get(&u->strips[g], u->strips[g].full, 0, l) > 0)) return false;
  return true;
}
