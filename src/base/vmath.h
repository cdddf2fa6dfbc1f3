/* vmath.h: sine and cosine of vectors of LANE_WIDTH doubles; included once per LANE_WIDTH after
 * base/lane.h.
 *
 * Only basic operations are used, in a fixed order, so that the values depend neither on the width
 * of the vectors nor on the C library. The polynomials are the classical minimax ones on [-pi/4,
 * pi/4] (as in Cody & Waite, Software Manual for the Elementary Functions). The error is about one
 * unit in the last place.
 */

/* Computes sin and cos of 2 pi t, for |t| < 2^50. */
LANE_INLINE void LANE(sine_cosine)(LANE(real) t, LANE(real) * sine, LANE(real) * cosine) {
  t = t - LANE(nearest)(t);              /* t without full turns, in [-1/2, 1/2] */
  LANE(real) q = LANE(nearest)(t * 4.0); /* number of quarter turns nearest to t, -2 ... 2 */
  LANE(real) y = (t - q * 0.25) * 6.283185307179586476925; /* remaining angle, in [-pi/4, pi/4] */
  LANE(real) z = y * y;
  LANE(real) s = z * 1.58969099521155010221e-10 + -2.50507602534068634195e-08;
  s = s * z + 2.75573137070700676789e-06;
  s = s * z + -1.98412698298579493134e-04;
  s = s * z + 8.33333333332248946124e-03;
  s = s * z + -1.66666666666666324348e-01;
  s = y + y * (z * s);
  LANE(real) c = z * -1.13596475577881948265e-11 + 2.08757232129817482790e-09;
  c = c * z + -2.75573143513906633035e-07;
  c = c * z + 2.48015872894767294178e-05;
  c = c * z + -1.38888888888741095749e-03;
  c = c * z + 4.16666666666666019037e-02;
  c = 1.0 - (z * 0.5 - z * z * c);
  /* Result (sine, cosine) for q = 0: (s, c); 1: (c, -s); -1: (-c, s); +-2: (-s, -c). */
  LANE(mask) one = LANE(equal)(q, LANE(splat)(1.0)), less_one = LANE(equal)(q, LANE(splat)(-1.0));
  LANE(mask) two = LANE(equal)(q, LANE(splat)(2.0)) | LANE(equal)(q, LANE(splat)(-2.0));
  LANE(mask) swap = one | less_one;
  LANE(mask) flip_sine = less_one | two;
  LANE(mask) flip_cosine = one | two;
  LANE(real) a = LANE(select)(swap, c, s), b = LANE(select)(swap, s, c);
  *sine = LANE(select)(flip_sine, -a, a);
  *cosine = LANE(select)(flip_cosine, -b, b);
}
