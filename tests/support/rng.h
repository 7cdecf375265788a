/* Random numbers for tests: counter-based, so that a case can be named by (seed, counter) and repeated alone,
 * and the same on every machine and compiler. */
#ifndef HB_TEST_RNG_H
#define HB_TEST_RNG_H

#include <math.h>
#include <stdint.h>

typedef struct rng {
  uint64_t seed, counter;
} rng;

/* Starts the sequence that belongs to seed. */
static inline rng rng_start(uint64_t seed) {
  rng r = {seed, 0};
  return r;
}

/* Stirs the bits of a word: two rounds of multiply and fold. */
static inline uint64_t rng_stir(uint64_t word) {
  word = (word ^ (word >> 32)) * UINT64_C(0xD6E8FEB86659FD93);
  word = (word ^ (word >> 29)) * UINT64_C(0xA0761D6478BD642F);
  return word ^ (word >> 32);
}

/* 64 random bits. */
static inline uint64_t rng_bits(rng *r) {
  uint64_t count = ++r->counter;
  return rng_stir(rng_stir(r->seed + UINT64_C(0x9E3779B97F4A7C15)) + count * UINT64_C(0x9E3779B97F4A7C15));
}

/* Uniform in [low, high). */
static inline double rng_uniform(rng *r, double low, double high) {
  return low + (high - low) * (double)(rng_bits(r) >> 11) * 0x1p-53;
}

/* Uniform integer in [low, high], both included. */
static inline int rng_int(rng *r, int low, int high) {
  uint64_t span = (uint64_t)((int64_t)high - low + 1);
  return (int)(low + (int64_t)(rng_bits(r) % span));
}

/* Normal with mean 0 and variance 1. */
static inline double rng_normal(rng *r) {
  double u = 1.0 - rng_uniform(r, 0.0, 1.0), angle = rng_uniform(r, 0.0, 6.283185307179586);
  return sqrt(-2.0 * log(u)) * cos(angle);
}

/* Direction uniform on the unit sphere. */
static inline void rng_direction(rng *r, double out[3]) {
  double length;
  do {
    for (int k = 0; k < 3; k++) out[k] = rng_uniform(r, -1.0, 1.0);
    length = sqrt(out[0] * out[0] + out[1] * out[1] + out[2] * out[2]);
  } while (length > 1.0 || length < 0.1);
  for (int k = 0; k < 3; k++) out[k] /= length;
}

#endif
