/* Frames and checkpoints beside the run: the run hands over copies of its state, a thread does the rest. */
#include "output/writer.h"

#include "base/clock.h"
#include "base/memory.h"
#include "base/queue.h"

#include <stdatomic.h>

/* Places for copies of the state: one is written while the other is filled. Where copies are small there are
 * more, because frames then follow one another faster than a thread can be woken. */
#define SLOTS_LEAST 2
#define SLOTS_MOST 64
#define SLOTS_BYTES (1u << 20)

/* A copy of the state and what to make of it. */
typedef struct slot {
  hb_state *state;
  bool frame, checkpoint; /* checkpoint: the copy is whole */
  bool forces;            /* it holds forces */
} slot;

struct hb_recorder {
  const hb_model *model;
  hb_record_plan plan;
  slot slots[SLOTS_MOST];
  hb_queue *queue;
  uint64_t fields;        /* measured in every frame */
  double last_checkpoint; /* handed over */
  int last_frame;         /* slot of the last frame handed over, -1: none yet */
  /* Of the thread that writes, to be read by others after waiting. */
  hb_measure *measure;
  long frames;        /* measured and given to the writer, if there is one */
  double seconds;     /* of processor, of its thread */
  hb_error err;       /* settled before failed is set, never changed after */
  atomic_bool failed; /* nothing more is written */
};

/* Measures, gives to the writer, shows. */
static hb_status write_frame(hb_recorder *r, const hb_state *state) {
  hb_measure_state(r->measure, state, r->plan.frame);
  hb_status status = r->plan.writer ? hb_writer_collect(r->plan.writer, r->plan.frame, &r->err) : HB_OK;
  if (status) return status;
  r->frames++;
  if (r->plan.seen) r->plan.seen(r->plan.context, r->plan.frame);
  return HB_OK;
}

/* Is a checkpoint asked for, or is it time? Asked where the copy is made: a checkpoint needs all of it. */
static bool checkpoint_due(hb_recorder *r, bool asked) {
  if (!r->plan.checkpoint) return false;
  double now = hb_clock_now();
  if (!asked && now - r->last_checkpoint < r->plan.checkpoint_seconds) return false;
  r->last_checkpoint = now;
  return true;
}

/* What is done with each slot, in order; nothing after a failure. Frames that came in the meantime are
 * written together with this one; a checkpoint counts frames, so they are in the file before. */
static void record(void *context, int index) {
  hb_recorder *r = context;
  const slot *s = &r->slots[index];
  if (atomic_load(&r->failed)) return;
  hb_status status = s->frame ? write_frame(r, s->state) : HB_OK;
  if (!status && r->plan.writer && (s->checkpoint || !hb_queue_more(r->queue)))
    status = hb_writer_flush(r->plan.writer, &r->err);
  if (!status && s->checkpoint)
    status = hb_checkpoint_write_state(r->plan.checkpoint, r->model, s->state, r->frames, &r->err);
  if (status) atomic_store(&r->failed, true);
  if (r->plan.threaded) r->seconds = hb_clock_thread();
}

/* How many places for copies. */
static int slot_count(const hb_state *state) {
  size_t fit = SLOTS_BYTES / (state->count * sizeof(double));
  return fit < SLOTS_LEAST ? SLOTS_LEAST : fit > SLOTS_MOST ? SLOTS_MOST : (int)fit;
}

/* Slots, measure, queue. */
hb_status hb_recorder_create(const hb_model *model, const hb_record_plan *plan, hb_recorder **out,
                             hb_error *err) {
  *out = NULL;
  hb_recorder *r = hb_alloc(1, sizeof *r);
  if (!r) return hb_fail_memory(err, "recorder of a run");
  r->model = model;
  r->plan = *plan;
  r->frames = plan->frames;
  r->last_checkpoint = hb_clock_now();
  r->last_frame = -1;
  r->fields = plan->fields | (plan->writer ? hb_fields_of(model) : 0);
  hb_status status = hb_measure_create(model, &r->measure, err);
  if (!status) hb_measure_choose(r->measure, r->fields);
  if (!status) status = hb_state_create(model, &r->slots[0].state, err);
  int slots = plan->threaded && !status ? slot_count(r->slots[0].state) : 1;
  for (int k = 1; !status && k < slots; k++) status = hb_state_create(model, &r->slots[k].state, err);
  if (!status) status = hb_queue_create(slots, plan->threaded, record, r, "writer of a run", &r->queue, err);
  if (status)
    hb_recorder_free(r);
  else
    *out = r;
  return status;
}

/* The thread ends when it has written everything. */
void hb_recorder_free(hb_recorder *r) {
  if (!r) return;
  hb_queue_free(r->queue);
  for (int k = 0; k < SLOTS_MOST; k++) hb_state_free(r->slots[k].state);
  hb_measure_free(r->measure);
  hb_free(r);
}

/* Hands over a copy. */
static hb_status hand_over(hb_recorder *r, const hb_sim *sim, bool frame, bool checkpoint, hb_error *err) {
  hb_status status = hb_recorder_check(r, err);
  if (status) return status;
  int index = hb_queue_take(r->queue);
  slot *s = &r->slots[index];
  s->frame = frame;
  s->checkpoint = checkpoint_due(r, checkpoint);
  s->forces = s->checkpoint || (r->fields & HB_FIELDS_OF_FORCES);
  if (s->checkpoint)
    hb_state_copy(s->state, hb_sim_const_state(sim));
  else
    hb_sim_snapshot(sim, s->forces, s->state);
  if (frame) r->last_frame = index;
  hb_queue_give(r->queue);
  return hb_recorder_check(r, err); /* without a thread it has been written */
}

/* Frame, perhaps checkpoint. */
hb_status hb_recorder_add(hb_recorder *r, const hb_sim *sim, bool checkpoint, hb_error *err) {
  return hand_over(r, sim, true, checkpoint, err);
}

/* Checkpoint. */
hb_status hb_recorder_checkpoint(hb_recorder *r, const hb_sim *sim, hb_error *err) {
  return hand_over(r, sim, false, true, err);
}

/* The sentence of the first failure. */
hb_status hb_recorder_check(const hb_recorder *r, hb_error *err) {
  if (!atomic_load(&r->failed)) return HB_OK;
  if (err) *err = r->err;
  return r->err.status;
}

/* Nothing under way. */
hb_status hb_recorder_wait(hb_recorder *r, hb_error *err) {
  hb_queue_wait(r->queue);
  return hb_recorder_check(r, err);
}

/* Those in the file; after a failure fewer may be there than were measured. */
long hb_recorder_frames(const hb_recorder *r) {
  return r->plan.writer ? hb_writer_frames(r->plan.writer) : r->frames;
}

/* Its copy lies where it was written from: at most a checkpoint has been handed over since. */
void hb_recorder_complete(hb_recorder *r) {
  if (r->last_frame < 0) return;
  const slot *s = &r->slots[r->last_frame];
  hb_measure_choose(r->measure, s->forces ? HB_FIELDS_ALL : HB_FIELDS_ALL & ~HB_FIELDS_OF_FORCES);
  hb_measure_state(r->measure, s->state, r->plan.frame);
  hb_measure_choose(r->measure, r->fields);
}

/* Of its thread. */
double hb_recorder_seconds(const hb_recorder *r) { return r->seconds; }
