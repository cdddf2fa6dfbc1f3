/* subnormal.h: makes numbers below 1e-308 count as zero while a system is advanced.
 *
 * The derivatives of a disk at rest decay until they are subnormal, and arithmetic on subnormal
 * numbers is many times slower. Results must have the same bits everywhere, so every thread that
 * advances a system works in this mode.
 */
#ifndef BASE_SUBNORMAL_H
#define BASE_SUBNORMAL_H

#if defined(__SSE2__)
#include <immintrin.h>
#endif

/* Makes the processor treat subnormal numbers as zero. Returns the previous mode, for
 * subnormal_restore. */
static inline unsigned subnormal_off(void) {
#if defined(__SSE2__)
  unsigned before = _mm_getcsr();
  /* Set two bits of the control register MXCSR: flush results to zero; denormal operands are
   * zero. */
  _mm_setcsr(before | 0x8040u);
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
