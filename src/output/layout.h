/* Where everything lies in a trajectory file: VTKHDF 2.0 temporal PolyData plus the group /hebra.
 *
 * Crash safety rests on one property: after creation nothing in the file moves. All data sets are laid out at
 * full size for the planned number of frames (as holes, which take no disk space), so that a frame is only
 * raw numbers at known places. What makes it valid is written last: the attribute NSteps, 8 bytes, and after
 * it the length of Steps/Values. Steps/Values is the one data set whose length follows the frames, because
 * VTK's reader copies all of it into an array of NSteps numbers; it has a single chunk that is allocated at
 * creation, so only its length changes. */
#ifndef HB_OUTPUT_LAYOUT_H
#define HB_OUTPUT_LAYOUT_H

#include "hebra/sim.h"
#include "output/disk.h"
#include "output/h5.h"
#include "output/series.h"

#define HB_LAYOUT_VERSION 1
#define HB_LAYOUT_STEPS "VTKHDF/Steps"
#define HB_LAYOUT_COUNT "NSteps"
#define HB_LAYOUT_VALUES "VTKHDF/Steps/Values"
#define HB_LAYOUT_RUN "run"             /* attribute of /hebra: number of the run, 16 hexadecimal digits */
#define HB_LAYOUT_MAX_FRAMES 500000000L /* one chunk of HDF5 stays below 4 GiB */

/* Path of the data set of a field or series, without leading slash. */
void hb_layout_field_path(const hb_frame_field *field, char *text, size_t size);
void hb_layout_series_path(const hb_series *series, char *text, size_t size);

/* Lays the empty file that disk has open out for capacity frames, with none in it, everything on its way to
 * disk, and leaves it open in *out. path: for the sentences. On failure *out is -1. */
hb_status hb_layout_create(hb_disk *disk, const char *path, const hb_model *model, long capacity, hid_t *out,
                           hb_error *err);

/* Type of the fields in trajectories of a model. */
hid_t hb_layout_type(const hb_model *model);

/* Places of the raw numbers in an open file: one entry per field that it holds, then one per series, then
 * Steps/Values. */
typedef struct hb_layout_map {
  long capacity;
  int count;
  uint64_t *at;     /* byte where frame 0 lies */
  uint64_t *stride; /* bytes per frame */
} hb_layout_map;
/* Finds and checks them. HB_ERR_INPUT if the file's layout is not the one above (another version, repacked).
 */
hb_status hb_layout_locate(hid_t file, const char *path, const hb_model *model, hb_layout_map *out,
                           hb_error *err);
void hb_layout_map_free(hb_layout_map *map);

/* What says how many frames are valid: the attribute NSteps and the length of Steps/Values. */
typedef struct hb_layout_count {
  hid_t file, group, attribute, values;
} hb_layout_count;
bool hb_layout_count_open(hid_t file, hb_layout_count *out); /* false on failure, nothing is left open */
bool hb_layout_count_close(hb_layout_count *count);          /* not the file; closing twice is allowed */
/* Makes the first `frames` frames valid where `before` were, and flushes. False on failure. */
bool hb_layout_set_frames(const hb_layout_count *count, long before, long frames);

#endif
