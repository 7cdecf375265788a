#include "output/seal.h"

#include "base/memory.h"
#include "output/file.h"
#include "output/identity.h"

#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* Where the seal is looked for, and how much structure a trajectory may have. */
enum { SEARCHED = 1 << 16, MOST_STRUCTURE = 1 << 26, RANGES = (HB_SEAL_BYTES - 64) / 16 };

static const char seal_magic[16] = "hebra seal \x1a\n\r 1";

typedef struct seal {
  char magic[16];
  uint64_t at, file_size; /* where the seal lies and how long the file is, to notice files made over */
  uint64_t count;         /* ranges in use */
  uint64_t structure;     /* check sum of the bytes in the ranges */
  uint64_t own;           /* check sum of this struct with own = 0 */
  hb_seal_range range[RANGES];
} seal;

/* Check sum of the seal itself. */
static uint64_t own_hash(const seal *s) {
  seal copy = *s;
  copy.own = 0;
  return hb_hash_bytes(HB_HASH_START, &copy, sizeof copy);
}

/* Length of the file; 0 if unknown. */
static uint64_t length_of(int fd) {
  struct stat info;
  return fstat(fd, &info) == 0 && info.st_size > 0 ? (uint64_t)info.st_size : 0;
}

/* Adds a gap. */
bool hb_seal_leave_out(hb_seal_gaps *gaps, uint64_t from, uint64_t size) {
  if (size == 0) return true;
  if (gaps->count >= (int)(sizeof gaps->range / sizeof gaps->range[0])) return false;
  gaps->range[gaps->count++] = (hb_seal_range){from, size};
  return true;
}

/* Order by place. */
static int by_place(const void *a, const void *b) {
  const hb_seal_range *one = a, *two = b;
  return one->from < two->from ? -1 : one->from > two->from;
}

/* What lies between the gaps, into range (at most most of them); -1 if there are more. */
static int between(hb_seal_gaps *gaps, uint64_t length, hb_seal_range *range, int most) {
  uint64_t at = 0;
  int count = 0;
  qsort(gaps->range, (size_t)gaps->count, sizeof gaps->range[0], by_place);
  for (int k = 0; k <= gaps->count; k++) {
    uint64_t end = k < gaps->count ? gaps->range[k].from : length;
    if (end > at) {
      if (count == most) return -1;
      range[count++] = (hb_seal_range){at, end - at};
    }
    if (k < gaps->count && gaps->range[k].from + gaps->range[k].size > at)
      at = gaps->range[k].from + gaps->range[k].size;
  }
  return count;
}

/* Bytes of the ranges one behind the other. HB_ERR_IO also if they are more than a trajectory can have. */
static hb_status collect(int fd, const hb_seal_range *range, int count, unsigned char **bytes, size_t *size) {
  uint64_t total = 0, done = 0;
  *bytes = NULL;
  if (count < 0) return HB_ERR_IO;
  for (int k = 0; k < count; k++) {
    if (range[k].size > MOST_STRUCTURE) return HB_ERR_IO;
    total += range[k].size;
  }
  if (total > MOST_STRUCTURE) return HB_ERR_IO;
  *bytes = hb_alloc((size_t)total, 1);
  if (!*bytes) return HB_ERR_MEMORY;
  bool good = true;
  for (int k = 0; good && k < count; k++) {
    good = hb_file_get(fd, *bytes + done, (size_t)range[k].size, range[k].from);
    done += range[k].size;
  }
  *size = (size_t)total;
  if (good) return HB_OK;
  hb_free(*bytes);
  *bytes = NULL;
  return HB_ERR_IO;
}

/* Everything outside the gaps. */
hb_status hb_seal_snapshot(int fd, hb_seal_gaps *gaps, unsigned char **bytes, size_t *size) {
  hb_seal_range range[RANGES];
  return collect(fd, range, between(gaps, length_of(fd), range, RANGES), bytes, size);
}

/* Walks over the gaps, which hb_seal_snapshot has sorted. */
uint64_t hb_seal_place(const hb_seal_gaps *gaps, size_t index) {
  uint64_t at = 0, left = index;
  for (int k = 0; k < gaps->count; k++) {
    uint64_t from = gaps->range[k].from;
    if (from > at && left < from - at) return at + left;
    if (from > at) left -= from - at;
    if (from + gaps->range[k].size > at) at = from + gaps->range[k].size;
  }
  return at + left;
}

/* Fills and writes. */
hb_status hb_seal_write(int fd, hb_seal_gaps *gaps, uint64_t at) {
  seal *s = hb_alloc(1, sizeof *s);
  if (!s) return HB_ERR_MEMORY;
  size_t size = 0;
  unsigned char *bytes = NULL;
  memcpy(s->magic, seal_magic, sizeof s->magic);
  s->at = at;
  s->file_size = length_of(fd);
  int count = between(gaps, s->file_size, s->range, RANGES);
  hb_status status = collect(fd, s->range, count, &bytes, &size);
  if (status == HB_OK) {
    s->count = (uint64_t)count;
    s->structure = hb_hash_bytes(HB_HASH_START, bytes, size);
    s->own = own_hash(s);
    if (!hb_file_put(fd, s, sizeof *s, at)) status = HB_ERR_IO;
  }
  hb_free(bytes);
  hb_free(s);
  return status;
}

/* Finds the seal in the first bytes of the file; false if there is none. */
static bool find(int fd, uint64_t length, unsigned char *head, seal *s) {
  size_t size = length < SEARCHED ? (size_t)length : SEARCHED;
  if (!hb_file_get(fd, head, size, 0)) return false;
  for (size_t at = 0; at + sizeof seal_magic <= size; at++) {
    if (head[at] != 'h' || memcmp(head + at, seal_magic, sizeof seal_magic) != 0) continue;
    return length - at >= sizeof *s && hb_file_get(fd, s, sizeof *s, at) && s->at == at &&
           s->file_size == length;
  }
  return false;
}

/* Checks. A seal that is not whole is not trusted, and neither is the file. */
hb_status hb_seal_check(int fd, const char *name, hb_error *err) {
  uint64_t length = length_of(fd);
  unsigned char *head = hb_alloc(SEARCHED, 1), *bytes = NULL;
  seal *s = hb_alloc(1, sizeof *s);
  hb_status status = head && s ? HB_OK : hb_fail_memory(err, "check of a trajectory");
  if (status == HB_OK && find(fd, length, head, s)) {
    size_t size = 0;
    bool whole = s->own == own_hash(s) && s->count <= RANGES;
    hb_status got = whole ? collect(fd, s->range, (int)s->count, &bytes, &size) : HB_ERR_IO;
    if (got == HB_ERR_MEMORY)
      status = hb_fail_memory(err, "check of a trajectory");
    else if (got != HB_OK || s->structure != hb_hash_bytes(HB_HASH_START, bytes, size))
      status = hb_fail(err, HB_ERR_INPUT,
                       "%s: the trajectory is damaged: the check sum of its structure is wrong", name);
  }
  hb_free(bytes);
  hb_free(head);
  hb_free(s);
  return status;
}
