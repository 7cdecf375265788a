/* What this machine can do: arithmetic of one core and bandwidth of the levels of memory, measured. */
#include "base/clock.h"
#include "base/memory.h"
#include "cli/bench.h"

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

/* One trial takes about this long, in seconds; the best of many counts: short ones find moments in which
 * nobody else has the core. */
#define TRIAL 0.001
#define TRIALS 60
#define LINE 64

/* Double precision. */
#define WITH_TRIAD
#define KERNEL(name) plain_##name
#define REAL double
#define BYTES 16
#define TARGET
#include "cli/bench_kernels.h"
#if defined(__x86_64__)
#define KERNEL(name) avx2_##name
#define REAL double
#define BYTES 32
#define TARGET __attribute__((target("avx2,fma")))
#include "cli/bench_kernels.h"
#define KERNEL(name) avx512_##name
#define REAL double
#define BYTES 64
#define TARGET __attribute__((target("avx512f")))
#include "cli/bench_kernels.h"
#endif
#undef WITH_TRIAD

/* Single precision. */
#define KERNEL(name) plain_single_##name
#define REAL float
#define BYTES 16
#define TARGET
#include "cli/bench_kernels.h"
#if defined(__x86_64__)
#define KERNEL(name) avx2_single_##name
#define REAL float
#define BYTES 32
#define TARGET __attribute__((target("avx2,fma")))
#include "cli/bench_kernels.h"
#define KERNEL(name) avx512_single_##name
#define REAL float
#define BYTES 64
#define TARGET __attribute__((target("avx512f")))
#include "cli/bench_kernels.h"
#endif

typedef double arithmetic(long rounds, double factor, double term);
typedef double traffic(long rounds, size_t bytes, void *x, const void *y, const void *z, double factor);

/* The loops of one instruction set; double precision first, then single. */
typedef struct kernels {
  const char *isa;
  int bytes;
  arithmetic *fused[2], *apart[2];
  traffic *triad;
} kernels;

static const kernels all_kernels[] = {
#if defined(__x86_64__)
    {"avx512", 64, {avx512_fused, avx512_single_fused}, {avx512_apart, avx512_single_apart}, avx512_triad},
    {"avx2", 32, {avx2_fused, avx2_single_fused}, {avx2_apart, avx2_single_apart}, avx2_triad},
#endif
    {"portable", 16, {plain_fused, plain_single_fused}, {plain_apart, plain_single_apart}, plain_triad}};

/* Can this machine run them? */
static bool runs(const kernels *k) {
#if defined(__x86_64__)
  if (strcmp(k->isa, "avx512") == 0) return __builtin_cpu_supports("avx512f");
  if (strcmp(k->isa, "avx2") == 0) return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
#endif
  (void)k;
  return true;
}

/* Highest rate of a loop, in GFlop/s. `operations` per round. */
static double rate(arithmetic *loop, double operations) {
  /* Not known to the compiler, and such that nothing grows. */
  const volatile double factor = 0.999999, term = 1e-6;
  volatile double sink = 0;
  double best = 0;
  long rounds = 1000;
  for (int trial = 0; trial < TRIALS; trial++) {
    double started = hb_clock_now();
    sink = sink + loop(rounds, factor, term);
    double seconds = hb_clock_now() - started;
    if (seconds < TRIAL / 4) {
      rounds *= seconds > 0 && seconds > TRIAL / 100 ? (long)(TRIAL / seconds) + 1 : 10;
      trial = -1;
      continue;
    }
    if (operations * (double)rounds / seconds > best) best = operations * (double)rounds / seconds;
  }
  return 1e-9 * best;
}

/* Arithmetic: of the instruction sets that run here, the fastest. */
static void measure_arithmetic(cli_bench_machine *m) {
  for (size_t k = 0; k < sizeof all_kernels / sizeof all_kernels[0]; k++) {
    const kernels *set = &all_kernels[k];
    if (!runs(set)) continue;
    if (!m->isa) m->isa = set->isa;
    for (int single = 0; single < 2; single++) {
      double lanes = single ? set->bytes / 4 : set->bytes / 8;
      double fused = rate(set->fused[single], 24 * lanes), apart = rate(set->apart[single], 12 * lanes);
      if (!single && fused > m->fused[0]) m->isa = set->isa;
      if (fused > m->fused[single]) m->fused[single] = fused;
      if (apart > m->apart[single]) m->apart[single] = apart;
    }
  }
}

/* Highest bandwidth of the triad over three arrays of `bytes` in all, in GB/s, each byte counted that has to
 * come or go: 3 per 3 in the first cache; behind it a line that is written has to come first, 4 per 3. */
static double bandwidth(const kernels *set, size_t bytes, bool first, void *room) {
  const volatile double factor = 0.999999;
  volatile double sink = 0;
  size_t third = bytes / 3 / (4 * LINE) * (4 * LINE);
  char *x = room, *y = x + third, *z = y + third;
  double best = 0, moved = (double)third * (first ? 3 : 4);
  long rounds = 1;
  for (int trial = 0; trial < TRIALS; trial++) {
    double started = hb_clock_now();
    sink = sink + set->triad(rounds, third, x, y, z, factor);
    double seconds = hb_clock_now() - started;
    if (seconds < TRIAL / 4) {
      rounds *= 2;
      trial = -1;
      continue;
    }
    if (moved * (double)rounds / seconds > best) best = moved * (double)rounds / seconds;
  }
  return 1e-9 * best;
}

/* First line of a file, without its end; false if there is none. */
static bool read_line(const char *path, char *line, int size) {
  FILE *file = fopen(path, "r");
  bool read = file && fgets(line, size, file);
  if (file) fclose(file);
  if (read) line[strcspn(line, "\n")] = 0;
  return read;
}

/* Bytes of a cache as the system says, else a usual size. Linux knows better than sysconf, which on some
 * machines gives the caches of all cores together. */
static size_t cache_size(int level) {
  const size_t usual[3] = {32 << 10, 512 << 10, 8 << 20};
  for (int index = 0; index < 8; index++) {
    char path[96], type[16] = "", unit = 0;
    long size = 0;
    int found = 0;
    snprintf(path, sizeof path, "/sys/devices/system/cpu/cpu0/cache/index%d/level", index);
    if (!read_line(path, type, sizeof type) || atoi(type) != level + 1) continue;
    snprintf(path, sizeof path, "/sys/devices/system/cpu/cpu0/cache/index%d/type", index);
    if (!read_line(path, type, sizeof type) || strcmp(type, "Instruction") == 0) continue;
    snprintf(path, sizeof path, "/sys/devices/system/cpu/cpu0/cache/index%d/size", index);
    if (read_line(path, type, sizeof type)) found = sscanf(type, "%ld%c", &size, &unit);
    if (found == 2 && size > 0) return (size_t)size << (unit == 'M' ? 20 : 10);
  }
  long said = 0;
#if defined(_SC_LEVEL1_DCACHE_SIZE) && defined(_SC_LEVEL2_CACHE_SIZE) && defined(_SC_LEVEL3_CACHE_SIZE)
  const int ask[3] = {_SC_LEVEL1_DCACHE_SIZE, _SC_LEVEL2_CACHE_SIZE, _SC_LEVEL3_CACHE_SIZE};
  said = sysconf(ask[level]);
#endif
  return said > 0 ? (size_t)said : usual[level];
}

/* Bandwidths of the three caches, each half full, and of memory. */
static hb_status measure_memory(cli_bench_machine *m, hb_error *err) {
  const kernels *set = all_kernels;
  while (strcmp(set->isa, m->isa) != 0) set++;
  size_t largest = 4 * m->size[2];
  if (largest < 64u << 20) largest = 64u << 20;
  if (largest > 512u << 20) largest = 512u << 20;
  char *block = hb_alloc(largest + LINE, 1);
  if (!block) return hb_fail_memory(err, "measuring the memory");
  char *room = block + (LINE - (uintptr_t)block % LINE) % LINE;
  memset(room, 0, largest); /* its pages are there from now on */
  for (int level = 0; level < CLI_BENCH_LEVELS; level++) {
    size_t bytes = level < 3 ? m->size[level] / 2 : largest;
    if (bytes > largest) bytes = largest;
    m->bandwidth[level] = bandwidth(set, bytes, level == 0, room);
  }
  hb_free(block);
  return HB_OK;
}

/* Name of the processor, "unknown" where the system does not say. */
static void find_name(char *name, size_t size) {
  char line[512];
  snprintf(name, size, "unknown");
  FILE *file = fopen("/proc/cpuinfo", "r");
  if (!file) return;
  while (fgets(line, sizeof line, file)) {
    char *colon = strchr(line, ':');
    if (strncmp(line, "model name", 10) != 0 || !colon) continue;
    line[strcspn(line, "\n")] = 0;
    snprintf(name, size, "%s", colon + 1 + (colon[1] == ' '));
    break;
  }
  fclose(file);
}

/* Everything about the machine. */
hb_status cli_bench_measure_machine(cli_bench_machine *m, hb_error *err) {
  *m = (cli_bench_machine){.isa = NULL};
  find_name(m->name, sizeof m->name);
  m->processors = (int)sysconf(_SC_NPROCESSORS_ONLN);
  for (int level = 0; level < 3; level++) m->size[level] = cache_size(level);
  double started = hb_clock_now(), used = (double)clock();
  measure_arithmetic(m);
  used = ((double)clock() - used) / (double)CLOCKS_PER_SEC;
  m->core_share = used / (hb_clock_now() - started);
  return measure_memory(m, err);
}
