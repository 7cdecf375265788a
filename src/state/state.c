#include "hebra/state.h"

#include "base/memory.h"

#include <string.h>

const hb_state_field hb_state_fields[] = {
#define HB_ROW(name, extent, components, text) {#name, extent, components, text, offsetof(hb_state, name)},
    HB_STATE_FIELDS(HB_ROW)
#undef HB_ROW
};
const int hb_state_field_count = (int)(sizeof hb_state_fields / sizeof hb_state_fields[0]);

/* Entries of a field: how often it occurs times its components. */
size_t hb_state_field_size(const hb_model *model, const hb_state_field *field) {
  size_t n = 0;
  switch (field->extent) {
  case HB_PER_MODEL: n = 1; break;
  case HB_PER_SLOT: n = (size_t)model->nv; break;
  case HB_PER_GENERAL: n = model->any_general ? (size_t)model->nv : 0; break;
  case HB_PER_VISCOUS: n = model->any_viscosity ? (size_t)model->nv : 0; break;
  case HB_PER_PANEL: n = (size_t)model->panel_count; break;
  case HB_PER_SPAN: n = (size_t)model->span_count; break;
  case HB_PER_ROD: n = (size_t)model->rod_count; break;
  case HB_PER_FRAME: n = (size_t)model->frame_count; break;
  }
  return n * (size_t)field->components;
}

/* One block; the pointers of the fields go into it one behind the other. */
hb_status hb_state_create(const hb_model *model, hb_state **out, hb_error *err) {
  *out = NULL;
  size_t count = 0;
  for (int k = 0; k < hb_state_field_count; k++) count += hb_state_field_size(model, &hb_state_fields[k]);
  hb_state *state = hb_alloc(1, sizeof *state);
  double *block = hb_alloc(count, sizeof *block);
  if (!state || !block) {
    hb_free(state);
    hb_free(block);
    return hb_fail_memory(err, "state of the simulation");
  }
  state->block = block;
  state->count = count;
  for (int k = 0; k < hb_state_field_count; k++) {
    memcpy((char *)state + hb_state_fields[k].offset, &block, sizeof block);
    block += hb_state_field_size(model, &hb_state_fields[k]);
  }
  *out = state;
  return HB_OK;
}

/* Frees block and struct. */
void hb_state_free(hb_state *state) {
  if (!state) return;
  hb_free(state->block);
  hb_free(state);
}

/* Copies the block between states of one model. */
void hb_state_copy(hb_state *to, const hb_state *from) {
  memcpy(to->block, from->block, from->count * sizeof *from->block);
}

/* Copies what belongs to one rod, field by field; the running totals belong to none. */
void hb_state_copy_rod(const hb_model *m, const hb_rod *rod, hb_state *to, const hb_state *from) {
  const hb_span *spans = m->spans + rod->first_span;
  int panels = 0;
  for (int s = 0; s < rod->span_count; s++) panels += spans[s].panel_count;
  for (int k = 0; k < hb_state_field_count; k++) {
    const hb_state_field *field = &hb_state_fields[k];
    int first = 0, count = 0;
    switch (field->extent) {
    case HB_PER_MODEL: break;
    case HB_PER_SLOT: first = rod->first, count = rod->nv; break;
    case HB_PER_GENERAL: first = rod->first, count = m->any_general ? rod->nv : 0; break;
    case HB_PER_VISCOUS: first = rod->first, count = m->any_viscosity ? rod->nv : 0; break;
    case HB_PER_PANEL: first = rod->span_count > 0 ? spans[0].first_panel : 0, count = panels; break;
    case HB_PER_SPAN: first = rod->first_span, count = rod->span_count; break;
    case HB_PER_ROD: first = rod->index, count = 1; break;
    case HB_PER_FRAME: first = rod->first_frame, count = rod->frame_count; break;
    }
    double *target;
    const double *source;
    memcpy(&target, (const char *)to + field->offset, sizeof target);
    memcpy(&source, (const char *)from + field->offset, sizeof source);
    size_t at = (size_t)first * (size_t)field->components, size = (size_t)count * (size_t)field->components;
    if (size > 0) memcpy(target + at, source + at, size * sizeof *target);
  }
}

/* FNV-1a, 64 bit, over the bytes of the block. */
uint64_t hb_state_hash(const hb_state *state) {
  uint64_t hash = 14695981039346656037u;
  const unsigned char *bytes = (const unsigned char *)state->block;
  for (size_t k = 0; k < state->count * sizeof *state->block; k++) hash = (hash ^ bytes[k]) * 1099511628211u;
  return hash;
}
