#include "output/identity.h"

#include <string.h>

/* FNV-1a. */
uint64_t hb_hash_bytes(uint64_t hash, const void *data, size_t size) {
  const unsigned char *bytes = data;
  for (size_t k = 0; k < size; k++) hash = (hash ^ bytes[k]) * 1099511628211u;
  return hash;
}

/* Rods and time step of a scene that was built in a program. */
static uint64_t of_numbers(const hb_scene_def *def) {
  uint64_t hash = hb_hash_bytes(HB_HASH_START, &def->method.time_step, sizeof def->method.time_step);
  for (int r = 0; r < def->rod_count; r++) {
    const hb_rod_def *rod = &def->rods[r];
    size_t nv = rod->nv > 0 ? (size_t)rod->nv : 0;
    if (rod->name) hash = hb_hash_bytes(hash, rod->name, strlen(rod->name) + 1);
    if (rod->rest) hash = hb_hash_bytes(hash, rod->rest, 3 * nv * sizeof *rod->rest);
    if (rod->initial) hash = hb_hash_bytes(hash, rod->initial, 3 * nv * sizeof *rod->initial);
    if (rod->mass) hash = hb_hash_bytes(hash, rod->mass, nv * sizeof *rod->mass);
  }
  return hash;
}

/* The definition's own number goes first: a run that goes on, perhaps longer, stays the same run. */
uint64_t hb_run_identity(const hb_model *model) {
  const hb_scene_def *def = model->def;
  uint64_t number = def->run;
  if (number == 0 && def->source) number = hb_hash_bytes(HB_HASH_START, def->source, strlen(def->source));
  if (number == 0) number = of_numbers(def);
  return number ? number : 1;
}
