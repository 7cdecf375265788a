/* What the export formats share: which frames, and where the files go. */
#ifndef HB_OUTPUT_EXPORT_H
#define HB_OUTPUT_EXPORT_H

#include "hebra/output.h"

typedef struct hb_export_job {
  hb_reader *reader;
  const hb_trajectory_info *info;
  const char *directory;
  long first, last, stride; /* last included */
  double *times;            /* of every frame of the trajectory */
  uint64_t held;            /* fields of the trajectory, as HB_FIELD_BIT */
  double **fields;          /* one buffer per entry of hb_frame_fields, filled by hb_export_load */
} hb_export_job;

/* Reads all fields of a frame into job->fields. */
hb_status hb_export_load(const hb_export_job *job, long frame, hb_error *err);

/* One table of scalars and one per rod. */
hb_status hb_export_csv(const hb_export_job *job, hb_error *err);
/* One .vtp per frame and a .pvd that lists them with their times. */
hb_status hb_export_vtp(const hb_export_job *job, hb_error *err);

#endif
