/* vexp.h: the exponential function on vectors of LANE_WIDTH doubles; included once per LANE_WIDTH
 * after base/lane.h.
 *
 * Only basic operations are used, in a fixed order, as in vmath.h. exp(x) = 2^n exp(r), |r| <= ln
 * 2/2, with ln 2 in two parts (Cody & Waite) and Taylor's polynomial for exp(r), whose remainder is
 * below 5e-18. The error is about one unit in the last place.
 */

/* Returns exp(x) for x <= 0; for x < -700 it returns exp(-700). */
LANE_INLINE LANE(real) LANE(exponential)(LANE(real) x) {
  x = LANE(max)(x, LANE(splat)(-700.0));
  LANE(real) n = LANE(nearest)(x * 1.44269504088896340736);
  LANE(real) r = (x - n * 0x1.62e42feep-1) - n * 0x1.a39ef35793c76p-33;
  LANE(real) p = r * (1.0 / 6227020800.0) + 1.0 / 479001600.0;
  p = p * r + 1.0 / 39916800.0;
  p = p * r + 1.0 / 3628800.0;
  p = p * r + 1.0 / 362880.0;
  p = p * r + 1.0 / 40320.0;
  p = p * r + 1.0 / 5040.0;
  p = p * r + 1.0 / 720.0;
  p = p * r + 1.0 / 120.0;
  p = p * r + 1.0 / 24.0;
  p = p * r + 1.0 / 6.0;
  p = p * r + 0.5;
  p = 1.0 + (r + r * r * p);
  LANE(bits)
  /* The low bits of the double n + 1.5 2^52 hold the integer n, to which the bias 1023 of the
   * exponent is added. */
  power = (LANE(as_bits)(n + 0x1.8p52) + 1023u) << 52;
  return p * LANE(as_real)(power);
}
