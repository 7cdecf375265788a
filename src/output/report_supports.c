/* What reports say of the supports and the windings of a rod. */
#include "output/report_parts.h"

#include "math/rotation.h"

/* Above so many vertices the writhe, whose cost grows with their square, is left out. */
#define LINK_VERTICES 4000

/* Is a coordinate of the vertex prescribed? */
static bool held(const hb_model *model, int slot) {
  const double *mass = model->inv_mass + 3 * slot;
  return mass[0] == 0 || mass[1] == 0 || mass[2] == 0;
}

/* Forces on prescribed vertices. */
static void reactions(hb_json *json, const hb_model *model, const hb_rod *rod, const hb_frame *frame) {
  hb_json_array(json, "reactions");
  for (int k = rod->first; k < rod->first + rod->nv; k++) {
    if (!held(model, k)) continue;
    hb_json_object(json, NULL);
    hb_json_integer(json, "vertex", k - rod->first);
    hb_json_vector(json, "force", frame->reaction + 3 * k, 3);
    hb_json_object_end(json);
  }
  hb_json_array_end(json);
}

/* Torques on prescribed frames. */
static void torques(hb_json *json, const hb_model *model, const hb_rod *rod, const hb_frame *frame) {
  hb_json_array(json, "torques");
  for (int k = rod->first_frame; k < rod->first_frame + rod->frame_count; k++) {
    int slot = model->frames[k].slot;
    hb_json_object(json, NULL);
    hb_json_integer(json, "edge", slot - rod->first);
    hb_json_number(json, "torque", frame->torque[slot]);
    hb_json_object_end(json);
  }
  hb_json_array_end(json);
}

/* Prescribed vertices from .. to (slots), one behind the other, and the frames beside them: as one support.
 */
static void one_support(hb_json *json, const hb_model *model, const hb_rod *rod, const hb_frame *frame,
                        int from, int to) {
  hb_v3 point = {0, 0, 0}, force = {0, 0, 0}, moment = {0, 0, 0};
  double vector[3];
  for (int k = from; k <= to; k++)
    point = hb_v3_axpy(point, 1.0 / (to - from + 1), hb_v3_load(frame->position + 3 * k));
  for (int k = from; k <= to; k++) {
    hb_v3 f = hb_v3_load(frame->reaction + 3 * k);
    force = hb_v3_add(force, f);
    moment = hb_v3_add(moment, hb_v3_cross(hb_v3_sub(hb_v3_load(frame->position + 3 * k), point), f));
  }
  for (int n = rod->first_frame; n < rod->first_frame + rod->frame_count; n++) {
    int j = model->frames[n].slot;
    if (j >= from - 1 && j <= to)
      moment = hb_v3_axpy(moment, frame->torque[j], hb_v3_load(frame->tangent + 3 * j));
  }
  hb_json_object(json, NULL);
  hb_json_integer(json, "first_vertex", from - rod->first);
  hb_json_integer(json, "last_vertex", to - rod->first);
  hb_v3_store(vector, point);
  hb_json_vector(json, "point", vector, 3);
  hb_v3_store(vector, force);
  hb_json_vector(json, "force", vector, 3);
  hb_v3_store(vector, moment);
  hb_json_vector(json, "moment", vector, 3);
  hb_json_object_end(json);
}

/* Vertex by vertex, frame by frame, and support by support. */
void hb_report_supports(hb_json *json, const hb_model *model, const hb_rod *rod, const hb_frame *frame) {
  int last = rod->first + rod->nv - 1;
  if (!(frame->fields & HB_FIELD_BIT(reaction))) return;
  reactions(json, model, rod, frame);
  torques(json, model, rod, frame);
  hb_json_array(json, "supports");
  for (int k = rod->first; k <= last; k++) {
    int from = k;
    if (!held(model, k)) continue;
    while (k < last && held(model, k + 1)) k++;
    one_support(json, model, rod, frame, from, k);
  }
  hb_json_array_end(json);
}

/* Twist, writhe, link. */
hb_status hb_report_link(hb_json *json, const char *key, const hb_model *model, const hb_rod *rod,
                         const hb_frame *frame, hb_error *err) {
  hb_link link;
  if (!hb_link_defined(model, rod->index) || rod->nv > LINK_VERTICES) return HB_OK;
  hb_status status = hb_frame_link(model, frame, rod->index, &link, err);
  if (status) return status;
  hb_json_object(json, key);
  hb_json_number(json, "linking_number", link.twist + link.writhe);
  hb_json_number(json, "twist", link.twist);
  hb_json_number(json, "writhe", link.writhe);
  hb_json_number(json, "closing", link.closing);
  hb_json_number(json, "whole", link.link);
  hb_json_number(json, "error", link.error);
  hb_json_object_end(json);
  return HB_OK;
}
