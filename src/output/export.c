#include "output/export.h"

#include "base/memory.h"
#include "output/file.h"

#include <string.h>

/* All fields of one frame. */
hb_status hb_export_load(const hb_export_job *job, long frame, hb_error *err) {
  hb_status status = HB_OK;
  for (int k = 0; status == HB_OK && k < hb_frame_field_count; k++)
    if (job->held >> k & 1)
      status = hb_reader_field(job->reader, hb_frame_fields[k].name, frame, job->fields[k], err);
  return status;
}

/* Buffers for times and fields. */
static hb_status buffers(hb_export_job *job, hb_error *err) {
  size_t nv = (size_t)job->info->nv;
  job->times = hb_alloc((size_t)job->info->frames, sizeof *job->times);
  job->fields = hb_alloc((size_t)hb_frame_field_count, sizeof *job->fields);
  bool good = job->times && job->fields;
  for (int k = 0; good && k < hb_frame_field_count; k++) {
    if (!(job->held >> k & 1)) continue;
    job->fields[k] = hb_alloc(nv, (size_t)hb_frame_fields[k].components * sizeof(double));
    good = job->fields[k] != NULL;
  }
  if (!good) return hb_fail_memory(err, "one frame for the export");
  return hb_reader_series(job->reader, "time", job->times, err);
}

/* Checks the range, prepares, hands over to the format. */
hb_status hb_export(hb_reader *reader, const char *format, const char *directory, long first, long last,
                    long stride, hb_error *err) {
  hb_export_job job = {.reader = reader,
                       .info = hb_reader_info(reader),
                       .directory = directory,
                       .held = hb_reader_fields(reader)};
  long frames = job.info->frames;
  bool csv = strcmp(format, "csv") == 0, vtp = strcmp(format, "vtp") == 0;
  if (!csv && !vtp)
    return hb_fail(err, HB_ERR_INPUT, "export: there is no format \"%s\", allowed are csv and vtp", format);
  if (frames == 0) return hb_fail(err, HB_ERR_INPUT, "export: the trajectory holds no frame yet");
  if (first < 0 || last < first || last >= frames || stride < 1)
    return hb_fail(
        err, HB_ERR_INPUT,
        "export: frames %ld to %ld in steps of %ld were asked for, allowed are 0 to %ld, upwards, in steps "
        "of at least 1",
        first, last, stride, frames - 1);
  job.first = first;
  job.last = last;
  job.stride = stride;
  hb_status status = hb_file_directory(directory, err);
  if (status == HB_OK) status = buffers(&job, err);
  if (status == HB_OK) status = csv ? hb_export_csv(&job, err) : hb_export_vtp(&job, err);
  for (int k = 0; job.fields && k < hb_frame_field_count; k++) hb_free(job.fields[k]);
  hb_free(job.fields);
  hb_free(job.times);
  return status;
}
