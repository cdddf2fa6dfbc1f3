/* exact_sum.h: sums of doubles without rounding, so that the result depends neither on the order of
 * the terms nor on how they are split into partial sums.
 *
 * A sum is one long integer made of limbs (digits) of 32 bits, in units of the smallest subnormal
 * number (R. Neal, arXiv:1505.05571). A limb is stored in 64 bits, so that carries are propagated
 * only every EXACT_ADDS additions. All members are integers: sums of several processes are combined
 * by adding their members, after exact_sum_carry. Zeroed memory is an empty sum.
 */
#ifndef BASE_EXACT_SUM_H
#define BASE_EXACT_SUM_H

#include <stddef.h>
#include <stdint.h>
#include <string.h>

enum { EXACT_LIMBS = 67, EXACT_ADDS = 1024 };

typedef struct exact_sum {
  int64_t limb[EXACT_LIMBS];
  int64_t adds; /* number of additions since carries were last propagated */
  /* numbers of added terms that are NaN, that are infinite of either sign, and that are
   * +infinity */
  int64_t nan, infinite, infinite_up;
} exact_sum;

/* Propagates carries, so that each limb but the last is in [0, 2^32). */
void exact_sum_carry(exact_sum *s);
void exact_sum_special(exact_sum *s, double x);
/* Adds the sum `other` to s. */
void exact_sum_merge(exact_sum *s, const exact_sum *other);
/* Returns the double nearest to the sum, ties to even; +0 for a zero sum. NaN and infinities
 * propagate as in ordinary addition. */
double exact_sum_value(const exact_sum *s);

/* Adds x exactly. Uses integer operations only, so the rounding mode and the flushing of subnormal
 * numbers have no effect. */
static inline void exact_sum_add(exact_sum *s, double x) {
  uint64_t bits;
  memcpy(&bits, &x, sizeof bits);
  if (bits << 1 == 0) return;
  const unsigned exponent = bits >> 52 & 2047;
  if (exponent == 2047) {
    exact_sum_special(s, x);
    return;
  }
  /* x is `mantissa` times 2^power, in units of the smallest subnormal number. The lowest 32 bits of
   * the shifted mantissa go to limb[0], the rest, with the sign, to limb[1]. */
  const unsigned power = exponent ? exponent - 1 : 0, shift = power % 32;
  const uint64_t size = (bits & ((UINT64_C(1) << 52) - 1)) | (uint64_t)(exponent != 0) << 52;
  const int64_t sign = (int64_t)(bits >> 63), mantissa = ((int64_t)size ^ -sign) + sign;
  int64_t *limb = s->limb + power / 32;
  limb[0] += (int64_t)((uint64_t)mantissa << shift & UINT32_MAX);
  limb[1] += mantissa >> (32 - shift);
  if (++s->adds == EXACT_ADDS) exact_sum_carry(s);
}

#endif
