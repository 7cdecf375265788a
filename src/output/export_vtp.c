/* VTK's XML files of poly data, which every ParaView reads: one polyline per rod, all fields as point data,
 * numbers appended raw. trajectory.pvd lists the files with their times. */
#include "output/export.h"

#include "base/memory.h"
#include "output/file.h"
#include "output/json.h"

#include <string.h>

/* Bytes of the appended block before its data: a 64-bit length. */
enum { PREFIX = 8 };

/* One array's entry in the header; moves *offset behind its data. */
static void entry(FILE *stream, const char *type, const char *name, int components, size_t bytes,
                  size_t *offset) {
  fprintf(stream,
          "        <DataArray type=\"%s\" Name=\"%s\" NumberOfComponents=\"%d\" format=\"appended\" "
          "offset=\"%zu\"/>\n",
          type, name, components, *offset);
  *offset += PREFIX + bytes;
}

/* Length and data of one array. */
static void block(FILE *stream, const void *data, size_t bytes) {
  uint64_t length = bytes;
  fwrite(&length, 1, sizeof length, stream);
  if (bytes > 0) fwrite(data, 1, bytes, stream);
}

/* The topology and constants, the same for all frames. */
typedef struct constants {
  int64_t *connectivity, *offsets, *rod;
  double *radius;
} constants;

/* Fills them; false without memory. */
static bool constants_make(const hb_trajectory_info *info, constants *c) {
  c->connectivity = hb_alloc((size_t)info->nv, sizeof *c->connectivity);
  c->offsets = hb_alloc((size_t)info->rod_count, sizeof *c->offsets);
  c->rod = hb_alloc((size_t)info->nv, sizeof *c->rod);
  c->radius = hb_alloc((size_t)info->nv, sizeof *c->radius);
  if (!c->connectivity || !c->offsets || !c->rod || !c->radius) return false;
  for (int r = 0; r < info->rod_count; r++) {
    c->offsets[r] = info->rods[r].first + info->rods[r].nv;
    for (int i = info->rods[r].first; i < info->rods[r].first + info->rods[r].nv; i++) {
      c->connectivity[i] = i;
      c->rod[i] = r;
      c->radius[i] = info->rods[r].radius;
    }
  }
  return true;
}

/* Frees them. */
static void constants_free(constants *c) {
  hb_free(c->connectivity);
  hb_free(c->offsets);
  hb_free(c->rod);
  hb_free(c->radius);
}

/* Rows without an edge repeat the row before, as in the trajectory file. */
static void fill_unused(const hb_trajectory_info *info, int components, double *values) {
  size_t c = (size_t)components;
  for (int r = 0; r < info->rod_count; r++) {
    size_t last = (size_t)(info->rods[r].first + info->rods[r].nv - 1);
    memcpy(values + last * c, values + (last - 1) * c, c * sizeof *values);
  }
}

/* How VTK calls the order of bytes here. */
static const char *byte_order(void) {
  const uint16_t one = 1;
  unsigned char low = 0;
  memcpy(&low, &one, 1);
  return low ? "LittleEndian" : "BigEndian";
}

/* Header with the place of every array. */
static void header(const hb_export_job *job, long frame, FILE *stream) {
  size_t nv = (size_t)job->info->nv, offset = 0;
  char time[32];
  hb_number_text(job->times[frame], time);
  fprintf(stream,
          "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"%s\" "
          "header_type=\"UInt64\">\n"
          "  <PolyData>\n    <FieldData>\n      <DataArray type=\"Float64\" Name=\"TimeValue\" "
          "NumberOfTuples=\"1\" "
          "format=\"ascii\">%s</DataArray>\n    </FieldData>\n"
          "    <Piece NumberOfPoints=\"%zu\" NumberOfVerts=\"0\" NumberOfLines=\"%d\" NumberOfStrips=\"0\" "
          "NumberOfPolys=\"0\">\n      <PointData>\n",
          byte_order(), time, nv, job->info->rod_count);
  for (int k = 1; k < hb_frame_field_count; k++) {
    int c = hb_frame_fields[k].components;
    if (job->held >> k & 1)
      entry(stream, "Float64", hb_frame_fields[k].name, c, nv * (size_t)c * sizeof(double), &offset);
  }
  entry(stream, "Int64", "rod", 1, nv * sizeof(int64_t), &offset);
  entry(stream, "Float64", "radius", 1, nv * sizeof(double), &offset);
  fputs("      </PointData>\n      <Points>\n", stream);
  entry(stream, "Float64", "position", 3, 3 * nv * sizeof(double), &offset);
  fputs("      </Points>\n      <Lines>\n", stream);
  entry(stream, "Int64", "connectivity", 1, nv * sizeof(int64_t), &offset);
  entry(stream, "Int64", "offsets", 1, (size_t)job->info->rod_count * sizeof(int64_t), &offset);
  fputs("      </Lines>\n    </Piece>\n  </PolyData>\n  <AppendedData encoding=\"raw\">\n   _", stream);
}

/* One frame's file. */
static hb_status frame_file(const hb_export_job *job, const constants *c, long frame, hb_error *err) {
  size_t nv = (size_t)job->info->nv;
  char *path = hb_file_join(job->directory, "trajectory_%06ld.vtp", frame);
  if (!path) return hb_fail_memory(err, "name of a file");
  hb_file file;
  hb_status status = hb_export_load(job, frame, err);
  if (status == HB_OK) status = hb_file_begin(path, &file, err);
  hb_free(path);
  if (status != HB_OK) return status;
  header(job, frame, file.stream);
  for (int k = 1; k < hb_frame_field_count; k++) {
    if (!(job->held >> k & 1)) continue;
    if (hb_frame_fields[k].location == HB_ON_EDGE)
      fill_unused(job->info, hb_frame_fields[k].components, job->fields[k]);
    block(file.stream, job->fields[k], nv * (size_t)hb_frame_fields[k].components * sizeof(double));
  }
  block(file.stream, c->rod, nv * sizeof *c->rod);
  block(file.stream, c->radius, nv * sizeof *c->radius);
  block(file.stream, job->fields[0], 3 * nv * sizeof(double));
  block(file.stream, c->connectivity, nv * sizeof *c->connectivity);
  block(file.stream, c->offsets, (size_t)job->info->rod_count * sizeof *c->offsets);
  fputs("\n  </AppendedData>\n</VTKFile>\n", file.stream);
  return hb_file_end(&file, true, false, err);
}

/* The list of all frames. */
static hb_status list_file(const hb_export_job *job, hb_error *err) {
  char *path = hb_file_join(job->directory, "trajectory.pvd");
  if (!path) return hb_fail_memory(err, "name of a file");
  hb_file file;
  hb_status status = hb_file_begin(path, &file, err);
  hb_free(path);
  if (status != HB_OK) return status;
  fprintf(file.stream,
          "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\" byte_order=\"%s\">\n  "
          "<Collection>\n",
          byte_order());
  for (long n = job->first; n <= job->last; n += job->stride) {
    char time[32];
    hb_number_text(job->times[n], time);
    fprintf(file.stream, "    <DataSet timestep=\"%s\" part=\"0\" file=\"trajectory_%06ld.vtp\"/>\n", time,
            n);
    if (job->stride > job->last - n) break;
  }
  fputs("  </Collection>\n</VTKFile>\n", file.stream);
  return hb_file_end(&file, true, false, err);
}

/* Frames first, so that the list never names a file that is not there. */
hb_status hb_export_vtp(const hb_export_job *job, hb_error *err) {
  constants c = {0};
  hb_status status = constants_make(job->info, &c) ? HB_OK : hb_fail_memory(err, "tables of the export");
  for (long n = job->first; status == HB_OK; n += job->stride) {
    status = frame_file(job, &c, n, err);
    if (job->stride > job->last - n) break;
  }
  constants_free(&c);
  if (status == HB_OK) status = list_file(job, err);
  return status;
}
