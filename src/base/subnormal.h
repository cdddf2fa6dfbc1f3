/* subnormal.h: numbers below 1e-308 count as zero while a system is advanced.
 *
 * The derivatives of a disk at rest decay until they are subnormal, and arithmetic on those is many times
 * slower. Part of the rule of bits: every thread that advances a system does so in this mode.
 */
#ifndef BASE_SUBNORMAL_H
#define BASE_SUBNORMAL_H

#if defined(__SSE2__)
#include <immintrin.h>
#endif

/* Switches the mode on; returns what subnormal_restore wants. */
static inline unsigned subnormal_off(void) {
#if defined(__SSE2__)
  unsigned before = _mm_getcsr();
  _mm_setcsr(before | 0x8040u); /* flush to zero, denormals are zero */
  return before;
#else
  return 0;
#endif
}

static inline void subnormal_restore(unsigned before) {
#if defined(__SSE2__)
  _mm_setcsr(before);
#else
  (void)before;
#endif
}

#endif
