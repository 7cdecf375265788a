/* Checkpoints: one small binary file, replaced as a whole.
 *
 * Layout, numbers in the machine's own order: the 8 bytes "HEBRACP2"; the header below; the source text; the
 * base directory; the state block; and the FNV-1a hash of everything before it. */
#include "hebra/output.h"

#include "base/memory.h"
#include "output/file.h"
#include "output/identity.h"

#include <errno.h>
#include <limits.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static const char magic[8] = {'H', 'E', 'B', 'R', 'A', 'C', 'P', '2'};

typedef struct header {
  uint64_t order;        /* byte_order as a number: tells a machine of the other byte order */
  uint64_t run;          /* number of the run */
  uint64_t frames;       /* frames in the trajectory */
  uint64_t source, base; /* bytes of the two texts, without terminator */
  uint64_t count;        /* doubles in the block */
} header;
static const uint64_t byte_order = 0x0102030405060708u;

/* Directory of a scene file as an absolute path where the system knows one; to be freed. A relative one would
 * be wrong when the restart happens elsewhere. */
static char *base_of(const char *path) {
  const char *slash = path ? strrchr(path, '/') : NULL;
  size_t length = slash ? (size_t)(slash - path) : 0;
  if (slash == path && slash) return hb_strdup("/");
  if (slash && path[0] == '/') return hb_strndup(path, length);
  char here[4096];
  if (!getcwd(here, sizeof here)) return slash ? hb_strndup(path, length) : hb_strdup(".");
  return slash ? hb_file_join(here, "%.*s", (int)length, path) : hb_strdup(here);
}

/* One piece, with the running hash. */
static bool put(FILE *stream, uint64_t *hash, const void *data, size_t size) {
  *hash = hb_hash_bytes(*hash, data, size);
  return size == 0 || fwrite(data, 1, size, stream) == size;
}

/* Writes under a temporary name, forces it to the disk, renames. */
hb_status hb_checkpoint_write_state(const char *path, const hb_model *model, const hb_state *state,
                                    long frames, hb_error *err) {
  const hb_scene_def *def = model->def;
  const char *source = def->source ? def->source : "";
  char *base = base_of(def->path);
  if (!base) return hb_fail_memory(err, "checkpoint");
  header head = {byte_order,     hb_run_identity(model), (uint64_t)frames,
                 strlen(source), strlen(base),           state->count};
  hb_file file;
  hb_status status = hb_file_begin(path, &file, err);
  if (status == HB_OK) {
    uint64_t hash = HB_HASH_START, sum = 0;
    bool good = put(file.stream, &hash, magic, sizeof magic) && put(file.stream, &hash, &head, sizeof head);
    good = good && put(file.stream, &hash, source, head.source) && put(file.stream, &hash, base, head.base);
    good = good && put(file.stream, &hash, state->block, state->count * sizeof *state->block);
    sum = hash;
    if (good) put(file.stream, &hash, &sum, sizeof sum); /* a failure shows when the stream is flushed */
    status = hb_file_end(&file, true, true, err);
  }
  hb_free(base);
  return status;
}

/* Of a simulation as it is now. */
hb_status hb_checkpoint_write(const char *path, const hb_sim *sim, long frames, hb_error *err) {
  return hb_checkpoint_write_state(path, hb_sim_model(sim), hb_sim_const_state(sim), frames, err);
}

/* Whole file into memory; *size gets its bytes. */
static hb_status load(const char *path, char **bytes, size_t *size, hb_error *err) {
  struct stat info;
  *bytes = NULL;
  FILE *stream = fopen(path, "rb");
  if (!stream) return hb_fail(err, HB_ERR_INPUT, "%s: cannot be opened: %s", path, strerror(errno));
  hb_status status = HB_OK;
  if (fstat(fileno(stream), &info) != 0 || !S_ISREG(info.st_mode))
    status = hb_fail(err, HB_ERR_IO, "%s: is no checkpoint, expected a file written by hebra run", path);
  if (status == HB_OK) {
    *size = (size_t)info.st_size;
    *bytes = hb_alloc(*size, 1);
    if (!*bytes)
      status = hb_fail_memory(err, "checkpoint");
    else if (fread(*bytes, 1, *size, stream) != *size)
      status =
          hb_fail(err, HB_ERR_IO, "%s: cannot be read: %s", path, strerror(ferror(stream) ? errno : EIO));
  }
  fclose(stream);
  if (status == HB_OK) return HB_OK;
  hb_free(*bytes);
  *bytes = NULL;
  return status;
}

/* Lengths and hash; on success the pieces lie as the header says. */
static hb_status check(const char *path, const char *bytes, size_t size, header *head, hb_error *err) {
  const size_t fixed = sizeof magic + sizeof *head + sizeof(uint64_t);
  if (size < sizeof magic || memcmp(bytes, magic, sizeof magic - 1) != 0)
    return hb_fail(err, HB_ERR_INPUT, "%s: is no checkpoint, expected a file written by hebra run", path);
  if (bytes[sizeof magic - 1] != magic[sizeof magic - 1])
    return hb_fail(
        err, HB_ERR_INPUT, "%s: is a checkpoint of another layout ('%c'), this program reads '%c'", path,
        bytes[sizeof magic - 1] > 32 && bytes[sizeof magic - 1] < 127 ? bytes[sizeof magic - 1] : '?',
        magic[sizeof magic - 1]);
  if (size < fixed)
    return hb_fail(err, HB_ERR_INPUT,
                   "%s: the checkpoint is cut off, it has %zu bytes, expected at least %zu", path, size,
                   fixed);
  memcpy(head, bytes + sizeof magic, sizeof *head);
  if (head->order != byte_order)
    return hb_fail(err, HB_ERR_INPUT,
                   "%s: the checkpoint is damaged or comes from a machine of another byte order", path);
  uint64_t room = size - fixed;
  bool fits = head->source <= room && head->base <= room - head->source;
  fits = fits && head->count == (room - head->source - head->base) / sizeof(double) &&
         (room - head->source - head->base) % sizeof(double) == 0 && head->frames <= LONG_MAX;
  if (!fits)
    return hb_fail(err, HB_ERR_INPUT,
                   "%s: the checkpoint is cut off or damaged, its %zu bytes do not match its header", path,
                   size);
  uint64_t sum = 0;
  memcpy(&sum, bytes + size - sizeof sum, sizeof sum);
  if (sum == hb_hash_bytes(HB_HASH_START, bytes, size - sizeof sum)) return HB_OK;
  return hb_fail(err, HB_ERR_INPUT, "%s: the checkpoint is damaged, its check sum is wrong", path);
}

/* Reads and checks. */
hb_status hb_checkpoint_read(const char *path, hb_checkpoint *out, hb_error *err) {
  char *bytes = NULL;
  size_t size = 0;
  header head = {0};
  memset(out, 0, sizeof *out);
  hb_status status = load(path, &bytes, &size, err);
  if (status == HB_OK) status = check(path, bytes, size, &head, err);
  if (status == HB_OK) {
    const char *at = bytes + sizeof magic + sizeof head;
    out->run = head.run;
    out->frames = (long)head.frames;
    out->count = (size_t)head.count;
    out->source = hb_strndup(at, (size_t)head.source);
    out->base_dir = hb_strndup(at + head.source, (size_t)head.base);
    out->block = hb_alloc(out->count, sizeof *out->block);
    if (out->source && out->base_dir && out->block)
      memcpy(out->block, at + head.source + head.base, out->count * sizeof *out->block);
    else
      status = hb_fail_memory(err, "checkpoint");
  }
  hb_free(bytes);
  if (status != HB_OK) hb_checkpoint_free(out);
  return status;
}

/* Frees the contents, not the struct. */
void hb_checkpoint_free(hb_checkpoint *checkpoint) {
  hb_free(checkpoint->source);
  hb_free(checkpoint->base_dir);
  hb_free(checkpoint->block);
  memset(checkpoint, 0, sizeof *checkpoint);
}
