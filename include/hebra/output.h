/* hebra/output.h - trajectories: HDF5 in VTKHDF layout, checkpoints, exports. */
#ifndef HEBRA_OUTPUT_H
#define HEBRA_OUTPUT_H

#include "hebra/sim.h"

#ifdef __cplusplus
extern "C" {
#endif

/* ---- writing
 * ------------------------------------------------------------------------------------------------ */
typedef struct hb_writer hb_writer;

/* Creates path (replacing an older file only once the new one is sound). frame_count: frames that are
 * planned. Which fields it holds, and in which precision, is in the model's scene (hb_output_def). */
hb_status hb_writer_create(const char *path, const hb_model *model, long frame_count, hb_writer **out,
                           hb_error *err);
/* Opens an existing trajectory to go on after its first `keep` frames (restart). It must belong to the same
 * run: the number it holds is that of the scene (hb_scene_def.run, or made from the scene's text);
 * HB_ERR_INPUT if not. */
hb_status hb_writer_continue(const char *path, const hb_model *model, long frame_count, long keep,
                             hb_writer **out, hb_error *err);
/* Appends one frame; after the call the file on disk can be opened and shows it, whatever happens next. */
hb_status hb_writer_add(hb_writer *writer, const hb_frame *frame, hb_error *err);
hb_status hb_writer_close(hb_writer *writer, hb_error *err); /* also frees; NULL is allowed */

/* ---- checkpoints
 * -------------------------------------------------------------------------------------------- */
/* Written to a temporary name and renamed: there is always one sound checkpoint. frames: frames in the
 * trajectory so far. Holds the number of the run, the scene's source text, the overrides applied, and the
 * state block. */
hb_status hb_checkpoint_write(const char *path, const hb_sim *sim, long frames, hb_error *err);
/* The same of a copy of the state. */
hb_status hb_checkpoint_write_state(const char *path, const hb_model *model, const hb_state *state,
                                    long frames, hb_error *err);
typedef struct hb_checkpoint {
  char *source;   /* scene text with overrides applied */
  char *base_dir; /* directory of the scene file */
  double *block;
  size_t count;
  long frames;
  uint64_t
      run; /* number of the run: to be put into hb_scene_def.run before the model of the restart is made */
} hb_checkpoint;
hb_status hb_checkpoint_read(const char *path, hb_checkpoint *out, hb_error *err);
void hb_checkpoint_free(hb_checkpoint *checkpoint);

/* ---- recording: frames and checkpoints of a run, beside it
 * ---------------------------------------------- */
/* What a recorder works with; all of it is borrowed and must outlive it. */
typedef struct hb_record_plan {
  hb_writer *writer;      /* NULL: no trajectory. Nobody else uses it between create and hb_recorder_wait */
  hb_frame *frame;        /* takes every measured frame; to be read after hb_recorder_wait only */
  long frames;            /* in the trajectory so far */
  const char *checkpoint; /* path; NULL: no checkpoints */
  double checkpoint_seconds; /* wall time between two; 0: one with every frame */
  bool threaded;             /* measure and write on a thread of its own, else in the call */
  uint64_t fields;           /* what `seen` looks at beyond the fields of the trajectory, 0: nothing */
  /* Called with every frame, in order, on the thread that writes; NULL: nobody looks.
   */
  void (*seen)(void *context, const hb_frame *frame);
  void *context;
} hb_record_plan;
typedef struct hb_recorder hb_recorder;
/* With a thread, the calls below copy what the fields are measured from (where a checkpoint is due the whole
 * state) and return at once (or when a place for the copy is free); the files get the same bytes in the same
 * order. What goes wrong in the thread ends the recording there, and
 * comes back as status and sentence from every later call. Memory is allocated here only, but for what a
 * checkpoint needs: copies of the state (2; up to 64 where they are small, 1 MiB) and the workspace of a
 * measure. HB_ERR_MEMORY also if there is no thread. */
hb_status hb_recorder_create(const hb_model *model, const hb_record_plan *plan, hb_recorder **out,
                             hb_error *err);
/* A frame of the simulation as it is now, and a checkpoint if it is time or asked for. */
hb_status hb_recorder_add(hb_recorder *recorder, const hb_sim *sim, bool checkpoint, hb_error *err);
/* Only a checkpoint. */
hb_status hb_recorder_checkpoint(hb_recorder *recorder, const hb_sim *sim, hb_error *err);
/* Has something gone wrong so far? Costs next to nothing. */
hb_status hb_recorder_check(const hb_recorder *recorder, hb_error *err);
/* Waits until everything is written. */
hb_status hb_recorder_wait(hb_recorder *recorder, hb_error *err);
long hb_recorder_frames(const hb_recorder *recorder); /* in the trajectory, after hb_recorder_wait */
/* After hb_recorder_wait: measures the last frame that was handed over once more, with every field that can
 * be measured from the copy, into plan.frame: tension, reaction and internal_force only if they or a
 * checkpoint were asked for. Does nothing if there was no frame. */
void hb_recorder_complete(hb_recorder *recorder);
/* Seconds of processor that measuring and writing have taken on their thread so far, after hb_recorder_wait;
 * 0 without a thread. */
double hb_recorder_seconds(const hb_recorder *recorder);
void hb_recorder_free(hb_recorder *recorder); /* waits; NULL is allowed */

/* ---- reading
 * ------------------------------------------------------------------------------------------------ */
typedef struct hb_reader hb_reader;
typedef struct hb_reader_rod {
  const char *name;
  int first, nv;
  bool closed; /* the last vertex is the first */
  double radius;
} hb_reader_rod;
typedef struct hb_trajectory_info {
  const char *title, *source, *version;
  long frames;
  int nv, rod_count;
  const hb_reader_rod *rods;
} hb_trajectory_info;
/* Opens a finished, running or killed run's trajectory. Every malformed file gives a sentence, never a crash.
 */
hb_status hb_reader_open(const char *path, hb_reader **out, hb_error *err);
const hb_trajectory_info *hb_reader_info(const hb_reader *reader);
/* Set of the fields that the trajectory holds, as HB_FIELD_BIT. */
uint64_t hb_reader_fields(const hb_reader *reader);
/* name: a field of hb_frame_fields; out gets components * nv doubles. HB_ERR_INPUT also for a field that the
 * run was told not to write. */
hb_status hb_reader_field(hb_reader *reader, const char *name, long frame, double *out, hb_error *err);
/* One scalar of hb_frame over all frames: time, step, kinetic, bending, twisting, gravity, work_loads, ... as
 * named there; vectors as momentum_x ... ; out gets `frames` doubles. */
hb_status hb_reader_series(hb_reader *reader, const char *name, double *out, hb_error *err);
void hb_reader_close(hb_reader *reader);

/* ---- exports
 * ------------------------------------------------------------------------------------------------ */
/* format: "csv" (one table per rod and one of scalars), "vtp" (series with a .pvd). Files go to directory. */
hb_status hb_export(hb_reader *reader, const char *format, const char *directory, long first, long last,
                    long stride, hb_error *err);

#ifdef __cplusplus
}
#endif
#endif
