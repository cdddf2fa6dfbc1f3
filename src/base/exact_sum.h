/* exact_sum.h: sums of doubles without rounding, so that they do not depend on the order, nor on how they are split.
 *
 * The sum is an integer of limbs of 32 bits in units of the smallest subnormal number (R. Neal, arXiv:1505.05571). A limb
 * is kept in 64 bits: carries are taken only every EXACT_ADDS additions. The members are integers alone: sums of several
 * processes are added up by adding these, after exact_sum_carry. Zeroed memory is an empty sum.
 */
#ifndef BASE_EXACT_SUM_H
#define BASE_EXACT_SUM_H

#include <stddef.h>
#include <stdint.h>
#include <string.h>

enum { EXACT_LIMBS = 67, EXACT_ADDS = 1024 };

typedef struct exact_sum {
  int64_t limb[EXACT_LIMBS];
  int64_t adds; /* since carries were taken */
  int64_t nan, infinite,
      infinite_up; /* how many of the terms are; infinite_up: of these, positive */
} exact_sum;

/* Each limb but the last in [0, 2^32). */
void exact_sum_carry(exact_sum *s);
void exact_sum_special(exact_sum *s, double x);
/* Adds another sum. */
void exact_sum_merge(exact_sum *s, const exact_sum *other);
/* To the nearest double, ties to even; +0 where it is zero. */
double exact_sum_value(const exact_sum *s);

/* In any mode of rounding and of subnormal numbers. */
static inline void exact_sum_add(exact_sum *s, double x) {
  uint64_t bits;
  memcpy(&bits, &x, sizeof bits);
  if (bits << 1 == 0) return;
  const unsigned exponent = bits >> 52 & 2047;
  if (exponent == 2047) {
    exact_sum_special(s, x);
    return;
  }
  /* x = mantissa 2^place of the units; of the mantissa, with its sign, 32 bits and the rest */
  const unsigned place = exponent ? exponent - 1 : 0, shift = place % 32;
  const uint64_t size = (bits & ((UINT64_C(1) << 52) - 1)) | (uint64_t)(exponent != 0) << 52;
  const int64_t sign = (int64_t)(bits >> 63), mantissa = ((int64_t)size ^ -sign) + sign;
  int64_t *limb = s->limb + place / 32;
  limb[0] += (int64_t)((uint64_t)mantissa << shift & UINT32_MAX);
  limb[1] += mantissa >> (32 - shift);
  if (++s->adds == EXACT_ADDS) exact_sum_carry(s);
}

#endif
