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
  bool frame, checkpoint; /* checkpoint: also if it is not time yet */
} slot;

struct hb_recorder {
  const hb_model *model;
  hb_record_plan plan;
  slot slots[SLOTS_MOST];
  hb_queue *queue;
  /* Of the thread that writes, to be read by others after waiting. */
  hb_measure *measure;
  long frames; /* measured and given to the writer, if there is one */
  double last_checkpoint;
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

/* Is a checkpoint asked for, or is it time? */
static bool checkpoint_due(hb_recorder *r, const slot *s) {
  if (!r->plan.checkpoint) return false;
  double now = hb_clock_now();
  if (!s->checkpoint && now - r->last_checkpoint < r->plan.checkpoint_seconds) return false;
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
  bool due = !status && checkpoint_due(r, s);
  if (!status && r->plan.writer && (due || !hb_queue_more(r->queue)))
    status = hb_writer_flush(r->plan.writer, &r->err);
  if (!status && due)
    status = hb_checkpoint_write_state(r->plan.checkpoint, r->model, s->state, r->frames, &r->err);
  if (status) atomic_store(&r->failed, true);
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
  hb_status status = hb_measure_create(model, &r->measure, err);
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
  slot *s = &r->slots[hb_queue_take(r->queue)];
  hb_state_copy(s->state, hb_sim_const_state(sim));
  s->frame = frame;
  s->checkpoint = checkpoint;
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
