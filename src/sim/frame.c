/* The measured moment: its field table and its memory. */
#include "hebra/sim.h"

#include "base/memory.h"

#include <string.h>

const hb_frame_field hb_frame_fields[] = {
#define HB_ROW(name, components, location, unit, text)                                                       \
  {#name, components, location, unit, text, offsetof(hb_frame, name)},
    HB_FRAME_FIELDS(HB_ROW)
#undef HB_ROW
};
const int hb_frame_field_count = (int)(sizeof hb_frame_fields / sizeof hb_frame_fields[0]);

#define BIT(name) HB_FIELD_BIT(name)
const hb_field_group hb_field_groups[] = {
    {"all", HB_FIELDS_ALL, "every field"},
    {"standard",
     BIT(position) | BIT(m1) | BIT(curvature) | BIT(twist) | BIT(twist_density) | BIT(tension) |
         BIT(twisting_moment) | BIT(reaction) | BIT(torque),
     "what pictures and plots are made of"},
    {"motion", BIT(position) | BIT(velocity) | BIT(energy_kinetic), "places and speeds"},
    {"frames", BIT(tangent) | BIT(m1) | BIT(m2) | BIT(bishop_u) | BIT(bishop_v) | BIT(theta),
     "directions of the edges"},
    {"strains",
     BIT(curvature_binormal) | BIT(curvature) | BIT(omega) | BIT(twist) | BIT(twist_density) | BIT(torsion) |
         BIT(strain),
     "how the rod is bent, twisted and stretched"},
    {"energies", BIT(energy_bending) | BIT(energy_twisting) | BIT(energy_kinetic) | BIT(energy_stretching),
     "shares of the energies"},
    {"forces",
     BIT(tension) | BIT(twisting_moment) | BIT(reaction) | BIT(torque) | BIT(internal_force) |
         BIT(internal_moment) | BIT(bending_moment),
     "what the rod and its supports bear"}};
#undef BIT
const int hb_field_group_count = (int)(sizeof hb_field_groups / sizeof hb_field_groups[0]);

/* Files in VTK's layout have points. */
uint64_t hb_fields_of(const hb_model *model) {
  uint64_t chosen = model->def->output.fields;
  return chosen ? (chosen & HB_FIELDS_ALL) | HB_FIELD_BIT(position) : HB_FIELDS_ALL;
}

/* One block for all arrays; the first field's pointer is the block. */
hb_status hb_frame_create(const hb_model *model, hb_frame **out, hb_error *err) {
  *out = NULL;
  size_t components = 0, nv = (size_t)model->nv;
  for (int k = 0; k < hb_frame_field_count; k++) components += (size_t)hb_frame_fields[k].components;
  hb_frame *frame = hb_alloc(1, sizeof *frame);
  double *block = hb_alloc(components * nv, sizeof *block);
  if (!frame || !block) {
    hb_free(frame);
    hb_free(block);
    return hb_fail_memory(err, "a frame of output");
  }
  for (int k = 0; k < hb_frame_field_count; k++) {
    memcpy((char *)frame + hb_frame_fields[k].offset, &block, sizeof block);
    block += (size_t)hb_frame_fields[k].components * nv;
  }
  *out = frame;
  return HB_OK;
}

/* Frees block and struct. */
void hb_frame_free(hb_frame *frame) {
  if (!frame) return;
  hb_free(frame->position);
  hb_free(frame);
}

/* Kinetic, bending and twisting energy of one rod: sums over its vertices. */
void hb_frame_rod_energy(const hb_model *model, const hb_frame *frame, int rod, double energy[3]) {
  const hb_rod *r = &model->rods[rod];
  energy[0] = energy[1] = energy[2] = 0;
  for (int i = r->first; i < r->first + r->nv; i++) {
    energy[0] += frame->energy_kinetic[i];
    energy[1] += frame->energy_bending[i];
    energy[2] += frame->energy_twisting[i];
  }
}

/* Sum over the edges. */
double hb_frame_rod_stretching(const hb_model *model, const hb_frame *frame, int rod) {
  const hb_rod *r = &model->rods[rod];
  double sum = 0;
  for (int k = r->first; k < r->first + r->nv; k++) sum += frame->energy_stretching[k];
  return sum;
}
