/* subnormal.h: makes numbers below 1e-308 count as zero while a system is advanced.
 *
 * The derivatives of a disk at rest decay until they are subnormal, and arithmetic on subnormal
 * numbers is many times slower. Results must have the same bits everywhere, so every thread that
 * advances a system works in this mode. Where there is none (WebAssembly), Gear's integrator does
 * it by LANE(normal).
 */
#ifndef BASE_SUBNORMAL_H
#define BASE_SUBNORMAL_H

#include <stdint.h>
#if defined(__SSE2__)
#include <immintrin.h>
#endif

/* Makes the processor treat subnormal numbers as zero. Returns the previous mode, for
 * subnormal_restore. */
static inline uint64_t subnormal_off(void) {
#if defined(__SSE2__)
  const unsigned before = _mm_getcsr();
  /* Set two bits of the control register MXCSR: flush results to zero; denormal operands are
   * zero. */
  _mm_setcsr(before | 0x8040u);
  return before;
#elif defined(__aarch64__)
  uint64_t before;
  __asm__ volatile("mrs %0, fpcr" : "=r"(before));
  __asm__ volatile("msr fpcr, %0" : : "r"(before | UINT64_C(1) << 24)); /* flush to zero */
  return before;
#else
  return 0;
#endif
}

static inline void subnormal_restore(uint64_t before) {
#if defined(__SSE2__)
  _mm_setcsr((unsigned)before);
#elif defined(__aarch64__)
  __asm__ volatile("msr fpcr, %0" : : "r"(before));
#else
  (void)before;
#endif
}

#endif
