/* exact_sum.c: implements exact_sum.h. */
#include "base/exact_sum.h"

#include <math.h>

enum { LAST = EXACT_LIMBS - 1 };

void exact_sum_carry(exact_sum *s) {
  int64_t carry = 0;
  for (int k = 0; k < LAST; k++) {
    const int64_t limb = s->limb[k] + carry;
    s->limb[k] = limb & UINT32_MAX;
    carry = limb >> 32;
  }
  s->limb[LAST] += carry;
  s->adds = 0;
}

void exact_sum_special(exact_sum *s, double x) {
  if (isnan(x)) {
    s->nan++;
    return;
  }
  s->infinite++;
  s->infinite_up += x > 0.0;
}

void exact_sum_merge(exact_sum *s, const exact_sum *other) {
  exact_sum more = *other;
  exact_sum_carry(&more);
  exact_sum_carry(s);
  for (int k = 0; k < EXACT_LIMBS; k++) s->limb[k] += more.limb[k];
  s->adds = 1;
  s->nan += more.nan;
  s->infinite += more.infinite;
  s->infinite_up += more.infinite_up;
}

/* Returns 64 bits of the sum, from bit number `place` upwards. The sum must be positive, with its
 * carries propagated. */
static uint64_t window(const exact_sum *s, int place) {
  const int k = place / 32, shift = place % 32;
  uint64_t found = (uint64_t)s->limb[k] >> shift;
  if (k < LAST) found |= (uint64_t)s->limb[k + 1] << (32 - shift);
  if (k + 1 < LAST && shift > 0) found |= (uint64_t)s->limb[k + 2] << (64 - shift);
  return found;
}

/* Returns nonzero if any bit below bit number `place` is set. */
static int any_below(const exact_sum *s, int place) {
  for (int k = 0; k < place / 32; k++)
    if (s->limb[k]) return 1;
  return (s->limb[place / 32] & ((INT64_C(1) << place % 32) - 1)) != 0;
}

/* Returns the bit pattern of the double that is nearest to a positive sum; infinity on overflow.
 * Carries must be propagated. top: index of the highest limb that is not 0. */
static uint64_t rounded(const exact_sum *s, int top) {
  int place = 32 * top; /* bit number of the lowest bit that the mantissa holds */
  for (uint64_t left = (uint64_t)s->limb[top]; left > 1; left >>= 1) place++;
  place = place > 52 ? place - 52 : 0;
  uint64_t mantissa = window(s, place);
  const int half = place > 0 && (window(s, place - 1) & 1);
  mantissa += half && ((mantissa & 1) || any_below(s, place - 1));
  /* The sum of shifted exponent and mantissa also adds the mantissa's leading 1, if the number is
   * normal, to the exponent. */
  const uint64_t bits = ((uint64_t)place << 52) + mantissa, infinite = UINT64_C(2047) << 52;
  return bits < infinite ? bits : infinite;
}

double exact_sum_value(const exact_sum *s) {
  if (s->nan || (s->infinite_up && s->infinite_up < s->infinite)) return NAN;
  if (s->infinite) return s->infinite_up ? HUGE_VAL : -HUGE_VAL;
  exact_sum t = *s;
  exact_sum_carry(&t);
  const int negative = t.limb[LAST] < 0;
  for (int k = 0; negative && k < EXACT_LIMBS; k++) t.limb[k] = -t.limb[k];
  if (negative) exact_sum_carry(&t);
  int top = LAST;
  while (top >= 0 && t.limb[top] == 0) top--;
  if (top < 0) return 0.0;
  const uint64_t bits = rounded(&t, top) | (uint64_t)negative << 63;
  double value;
  memcpy(&value, &bits, sizeof value);
  return value;
}
