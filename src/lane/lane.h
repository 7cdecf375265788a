/* Numbers in lanes: one source for every width, precision and instruction set.
 *
 * A file that defines HB_LANE_SINGLE gets lanes of floats, else of doubles. The compiler splits a vector that
 * is wider than the machine's registers, so every instruction set gives the same bits: each operation on a
 * lane is one rounded operation, and nothing is contracted. */
#ifndef HB_LANE_LANE_H
#define HB_LANE_LANE_H

#include <stdbool.h>
#include <stdint.h>

#include "lane/strip.h"

#include <math.h>
#if defined(__AVX2__) && defined(__FMA__)
#define HB_LANE_FUSED
#endif
#if defined(__AVX2__) || defined(__SSE2__)
#include <immintrin.h>
#endif

#ifdef HB_LANE_SINGLE
typedef float hb_real;
typedef int32_t hb_lane_int;
#define HB_LANES HB_LANES_SINGLE
#else
typedef double hb_real;
typedef int64_t hb_lane_int;
#define HB_LANES HB_LANES_DOUBLE
#endif

#define INLINED static inline __attribute__((always_inline))
#define R(constant) ((hb_real)(constant))

typedef hb_real lanes __attribute__((vector_size(HB_LANES * sizeof(hb_real))));
typedef hb_lane_int lane_mask __attribute__((vector_size(HB_LANES * sizeof(hb_real))));

/* A vector in space in every lane. */
typedef struct v3 {
  lanes x, y, z;
} v3;

/* The same number in every lane. */
INLINED lanes all(hb_real a) { return a - (lanes){0}; }

/* Zero in every lane. */
INLINED lanes none(void) { return all(0); }

/* a where the mask is set, else b. */
INLINED lanes choose(lane_mask m, lanes a, lanes b) {
#if defined(__AVX2__) && defined(HB_LANE_SINGLE)
  return (lanes)_mm256_blendv_ps((__m256)b, (__m256)a, (__m256)m);
#elif defined(__AVX2__)
  return (lanes)_mm256_blendv_pd((__m256d)b, (__m256d)a, (__m256d)m);
#else
  return (lanes)((m & (lane_mask)a) | (~m & (lane_mask)b));
#endif
}
/* a where the mask is set, else 0. */
INLINED lanes only(lane_mask m, lanes a) { return (lanes)(m & (lane_mask)a); }

/* Is any lane of the mask set? */
INLINED bool any(lane_mask m) {
  hb_lane_int r = 0;
  for (int l = 0; l < HB_LANES; l++) r |= m[l];
  return r != 0;
}

/* The larger of two numbers, the smaller one; b where one is not a number. */
INLINED lanes larger(lanes a, lanes b) {
#if defined(__AVX2__) && defined(HB_LANE_SINGLE)
  return (lanes)_mm256_max_ps((__m256)a, (__m256)b);
#elif defined(__AVX2__)
  return (lanes)_mm256_max_pd((__m256d)a, (__m256d)b);
#else
  return choose(a > b, a, b);
#endif
}

/* The same with <. */
INLINED lanes smaller(lanes a, lanes b) {
#if defined(__AVX2__) && defined(HB_LANE_SINGLE)
  return (lanes)_mm256_min_ps((__m256)a, (__m256)b);
#elif defined(__AVX2__)
  return (lanes)_mm256_min_pd((__m256d)a, (__m256d)b);
#else
  return choose(a < b, a, b);
#endif
}

/* |a|: without its sign bit. */
INLINED lanes size_of(lanes a) {
  const lane_mask sign = (lane_mask)(R(-0.0) - (lanes){0});
  return (lanes)((lane_mask)a & ~sign);
}

/* Square roots, one rounding each. */
INLINED lanes root(lanes a) {
#if defined(__AVX2__) && defined(HB_LANE_SINGLE)
  return (lanes)_mm256_sqrt_ps((__m256)a);
#elif defined(__AVX2__)
  return (lanes)_mm256_sqrt_pd((__m256d)a);
#elif defined(__SSE2__) && defined(HB_LANE_SINGLE)
  union {
    lanes all;
    __m128 part[HB_LANES / 4];
  } u = {.all = a};
  for (int k = 0; k < HB_LANES / 4; k++) u.part[k] = _mm_sqrt_ps(u.part[k]);
  return u.all;
#elif defined(__SSE2__)
  union {
    lanes all;
    __m128d part[HB_LANES / 2];
  } u = {.all = a};
  for (int k = 0; k < HB_LANES / 2; k++) u.part[k] = _mm_sqrt_pd(u.part[k]);
  return u.all;
#else
  for (int l = 0; l < HB_LANES; l++) a[l] = (hb_real)sqrt((double)a[l]);
  return a;
#endif
}

/* Each lane gets its left neighbour's number, the first one `first`. */
INLINED lanes up(lanes a, hb_real first) {
#if defined(__clang__) && HB_LANES == 4
  lanes r = __builtin_shufflevector(a, a, 3, 0, 1, 2);
#elif defined(__clang__)
  lanes r = __builtin_shufflevector(a, a, 7, 0, 1, 2, 3, 4, 5, 6);
#elif HB_LANES == 4
  lanes r = __builtin_shuffle(a, (lane_mask){3, 0, 1, 2});
#else
  lanes r = __builtin_shuffle(a, (lane_mask){7, 0, 1, 2, 3, 4, 5, 6});
#endif
  lane_mask here = {-1};
  return choose(here, all(first), r);
}

/* Each lane gets its right neighbour's number, the last one `last`. */
INLINED lanes down(lanes a, hb_real last) {
#if defined(__clang__) && HB_LANES == 4
  lanes r = __builtin_shufflevector(a, a, 1, 2, 3, 0);
#elif defined(__clang__)
  lanes r = __builtin_shufflevector(a, a, 1, 2, 3, 4, 5, 6, 7, 0);
#elif HB_LANES == 4
  lanes r = __builtin_shuffle(a, (lane_mask){1, 2, 3, 0});
#else
  lanes r = __builtin_shuffle(a, (lane_mask){1, 2, 3, 4, 5, 6, 7, 0});
#endif
  lane_mask here = {0};
  here[HB_LANES - 1] = -1;
  return choose(here, all(last), r);
}

#ifdef HB_LANE_FUSED
/* a b + c with one rounding. */
INLINED lanes fused(lanes a, lanes b, lanes c) {
#ifdef HB_LANE_SINGLE
  return (lanes)_mm256_fmadd_ps((__m256)a, (__m256)b, (__m256)c);
#else
  return (lanes)_mm256_fmadd_pd((__m256d)a, (__m256d)b, (__m256d)c);
#endif
}
#else
/* a b + c with one rounding: what libm gives is the same, where the processor has no such instruction.
 * Inlined it would multiply the time to compile the kernels, and is no faster. */
static __attribute__((noinline, unused)) lanes fused(lanes a, lanes b, lanes c) {
  for (int l = 0; l < HB_LANES; l++)
#ifdef HB_LANE_SINGLE
    c[l] = fmaf(a[l], b[l], c[l]);
#else
    c[l] = fma(a[l], b[l], c[l]);
#endif
  return c;
}
#endif

/* a b - c, the same way. */
INLINED lanes fused_less(lanes a, lanes b, lanes c) { return fused(a, b, -c); }

/* c - a b. */
INLINED lanes less_fused(lanes c, lanes a, lanes b) { return fused(-a, b, c); }

/* The polynomial with these coefficients, highest power first, at q. Horner's rule waits for itself; this
 * does not: even and odd powers apart, in q^2. */
INLINED lanes polynomial(const double *coefficients, int count, lanes q) {
  lanes square = q * q, one = all((hb_real)coefficients[0]), two = all((hb_real)coefficients[1]);
  for (int k = 2; k + 1 < count; k += 2) {
    one = fused(one, square, all((hb_real)coefficients[k]));
    two = fused(two, square, all((hb_real)coefficients[k + 1]));
  }
  if (count % 2 == 0) return fused(one, q, two);
  return fused(one, square, fused(two, q, all((hb_real)coefficients[count - 1])));
}

/* Vectors: the algebra of math/vec3.h in lanes, with products fused into the sums. */
INLINED v3 v3_load(const lanes *p) { return (v3){p[0], p[1], p[2]}; }
INLINED void v3_store(lanes *p, v3 a) {
  p[0] = a.x;
  p[1] = a.y;
  p[2] = a.z;
}

/* (0, 0, 0). */
INLINED v3 v3_zero(void) { return (v3){none(), none(), none()}; }
INLINED v3 v3_add(v3 a, v3 b) { return (v3){a.x + b.x, a.y + b.y, a.z + b.z}; }
INLINED v3 v3_sub(v3 a, v3 b) { return (v3){a.x - b.x, a.y - b.y, a.z - b.z}; }
INLINED v3 v3_scale(lanes s, v3 a) { return (v3){s * a.x, s * a.y, s * a.z}; }
INLINED v3 v3_axpy(v3 a, lanes s, v3 b) {
  return (v3){fused(s, b.x, a.x), fused(s, b.y, a.y), fused(s, b.z, a.z)};
}

/* a - s b. */
INLINED v3 v3_less(v3 a, lanes s, v3 b) {
  return (v3){less_fused(a.x, s, b.x), less_fused(a.y, s, b.y), less_fused(a.z, s, b.z)};
}

/* a . b. */
INLINED lanes v3_dot(v3 a, v3 b) { return fused(a.x, b.x, fused(a.y, b.y, a.z * b.z)); }
INLINED v3 v3_cross(v3 a, v3 b) {
  return (v3){fused_less(a.y, b.z, a.z * b.y), fused_less(a.z, b.x, a.x * b.z),
              fused_less(a.x, b.y, a.y * b.x)};
}

/* a where the mask is set, else b. */
INLINED v3 v3_choose(lane_mask m, v3 a, v3 b) {
  return (v3){choose(m, a.x, b.x), choose(m, a.y, b.y), choose(m, a.z, b.z)};
}

/* a where the mask is set, else 0. */
INLINED v3 v3_only(lane_mask m, v3 a) { return (v3){only(m, a.x), only(m, a.y), only(m, a.z)}; }

#endif
