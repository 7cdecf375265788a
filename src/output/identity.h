/* Which run a file belongs to. */
#ifndef HB_OUTPUT_IDENTITY_H
#define HB_OUTPUT_IDENTITY_H

#include "hebra/model.h"

#define HB_HASH_START 14695981039346656037u

/* FNV-1a, 64 bit, going on from hash. */
uint64_t hb_hash_bytes(uint64_t hash, const void *data, size_t size);

/* Number of the run: that in the definition if there is one, else made from the text of the scene, or, where
 * there is no text, from its rods and its time step. Never 0. */
uint64_t hb_run_identity(const hb_model *model);

#endif
