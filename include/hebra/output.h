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
 * planned. */
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

/* ---- reading
 * ------------------------------------------------------------------------------------------------ */
typedef struct hb_reader hb_reader;
typedef struct hb_reader_rod {
  const char *name;
  int first, nv;
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
/* name: a field of hb_frame_fields; out gets components * nv doubles. */
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
