/* Loops that do nothing but arithmetic or memory traffic, for one number type and vector width. bench_peak.c
 * includes this file once for each, so it has no guard; it takes KERNEL(name), which makes the names, REAL,
 * the number type, BYTES, those of a vector, and TARGET, the attributes that choose the instructions, and
 * undefines them at its end. */

typedef REAL KERNEL(vec) __attribute__((vector_size(BYTES)));

/* Multiply-adds in 12 chains, enough to hide their latency and still in registers: 24 operations per lane and
 * round. They fuse where the instruction set can (this file is compiled to allow it). */
TARGET static double KERNEL(fused)(long rounds, double factor, double term) {
  const KERNEL(vec) f = (KERNEL(vec)){0} + (REAL)factor, t = (KERNEL(vec)){0} + (REAL)term;
  KERNEL(vec)
  a = t, b = a + t, c = b + t, d = c + t, e = d + t, g = e + t, h = g + t, i = h + t, j = i + t, k = j + t,
  l = k + t, m = l + t;
  for (long round = 0; round < rounds; round++) {
    a = a * f + t, b = b * f + t, c = c * f + t, d = d * f + t, e = e * f + t, g = g * f + t;
    h = h * f + t, i = i * f + t, j = j * f + t, k = k * f + t, l = l * f + t, m = m * f + t;
  }
  a += b + c + d + e + g + h + i + j + k + l + m;
  return (double)a[0];
}

/* Six chains of multiplications beside six of additions: what code may reach that fuses nothing. 12
 * operations per lane and round. */
TARGET static double KERNEL(apart)(long rounds, double factor, double term) {
  const KERNEL(vec) f = (KERNEL(vec)){0} + (REAL)factor, t = (KERNEL(vec)){0} + (REAL)term;
  KERNEL(vec)
  a = t, b = a + t, c = b + t, d = c + t, e = d + t, g = e + t, h = g + t, i = h + t, j = i + t, k = j + t,
  l = k + t, m = l + t;
  for (long round = 0; round < rounds; round++) {
    a *= f, b *= f, c *= f, d *= f, e *= f, g *= f;
    h += t, i += t, j += t, k += t, l += t, m += t;
  }
  a += b + c + d + e + g + h + i + j + k + l + m;
  return (double)a[0];
}

#ifdef WITH_TRIAD
/* The triad x = y + factor * z over `bytes` bytes of each, a multiple of 4 vectors, `rounds` times. */
TARGET static double KERNEL(triad)(long rounds, size_t bytes, void *x, const void *y, const void *z,
                                   double factor) {
  const KERNEL(vec) f = (KERNEL(vec)){0} + (REAL)factor;
  KERNEL(vec) *to = x;
  const KERNEL(vec) *from = y, *more = z;
  for (long round = 0; round < rounds; round++) {
    for (size_t k = 0; k < bytes / BYTES; k += 4) {
      to[k] = from[k] + f * more[k];
      to[k + 1] = from[k + 1] + f * more[k + 1];
      to[k + 2] = from[k + 2] + f * more[k + 2];
      to[k + 3] = from[k + 3] + f * more[k + 3];
    }
    /* Every round really happens. */
    __asm__ volatile("" ::: "memory");
  }
  return (double)to[0][0];
}
#endif

#undef KERNEL
#undef REAL
#undef BYTES
#undef TARGET
