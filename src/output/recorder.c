/* Frames and checkpoints beside the run: the run hands over copies of its state, a thread does the rest. */
#include "hebra/output.h"

#include "base/clock.h"
#include "base/memory.h"
#include "base/queue.h"

#include <stdatomic.h>

/* One copy is being written while the run fills the other. */
#define SLOTS 2

/* A copy of the state and what to make of it. */
typedef struct slot {
  hb_state *state;
  bool frame, checkpoint; /* checkpoint: also if it is not time yet */
} slot;

struct hb_recorder {
  const hb_model *model;
  hb_record_plan plan;
  slot slots[SLOTS];
  hb_queue *queue;
  /* Of the thread that writes, to be read by others after waiting. */
  hb_measure *measure;
  long frames;
  double last_checkpoint;
  hb_error err;       /* settled before failed is set, never changed after */
  atomic_bool failed; /* nothing more is written */
};

/* A measured and written frame. */
static hb_status write_frame(hb_recorder *r, const hb_state *state) {
  hb_measure_state(r->measure, state, r->plan.frame);
  hb_status status = r->plan.writer ? hb_writer_add(r->plan.writer, r->plan.frame, &r->err) : HB_OK;
  if (status) return status;
  r->frames++;
  if (r->plan.seen) r->plan.seen(r->plan.context, r->plan.frame);
  return HB_OK;
}

/* A checkpoint, if it is asked for or time. */
static hb_status write_checkpoint(hb_recorder *r, const slot *s) {
  if (!r->plan.checkpoint) return HB_OK;
  double now = hb_clock_now();
  if (!s->checkpoint && now - r->last_checkpoint < r->plan.checkpoint_seconds) return HB_OK;
  r->last_checkpoint = now;
  return hb_checkpoint_write_state(r->plan.checkpoint, r->model, s->state, r->frames, &r->err);
}

/* What is done with each slot, in order; nothing after a failure. */
static void record(void *context, int index) {
  hb_recorder *r = context;
  const slot *s = &r->slots[index];
  if (atomic_load(&r->failed)) return;
  hb_status status = s->frame ? write_frame(r, s->state) : HB_OK;
  if (!status) status = write_checkpoint(r, s);
  if (status) atomic_store(&r->failed, true);
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
  int slots = plan->threaded ? SLOTS : 1;
  hb_status status = hb_measure_create(model, &r->measure, err);
  for (int k = 0; !status && k < slots; k++) status = hb_state_create(model, &r->slots[k].state, err);
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
  for (int k = 0; k < SLOTS; k++) hb_state_free(r->slots[k].state);
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

/* Written frames, those before the recorder included. */
long hb_recorder_frames(const hb_recorder *r) { return r->frames; }
