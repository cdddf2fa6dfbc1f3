/* signal_pass.h: steps of the computation of signals that waveforms and random motions share;
 * included once per LANE_WIDTH after base/lane.h.
 *
 * Vector lanes hold consecutive steps of one system, or one step of several systems; both use this
 * code and give the same bits. A value depends only on the motion's constants and on the number of
 * steps since its start, so the steps computed ahead may begin at any step.
 */

/* Returns the phase of a wave in turns after `at` steps. Full turns are removed, except those in
 * `offset`, the initial phase. The frequency in turns per step is high + low; high has so few
 * digits that its product with `at` is exact if `at` is 64 times a number up to 2^27. */
LANE_INLINE LANE(real)
    LANE(turns)(LANE(real) high, LANE(real) low, LANE(real) offset, LANE(real) at) {
  LANE(real) t = high * at;
  return ((t - LANE(nearest)(t)) + low * at) + offset;
}

/* Rotates the phasor (*sine, *cosine) by an angle with sine s and cosine c. */
LANE_INLINE void LANE(rotate)(LANE(real) * sine, LANE(real) * cosine, LANE(real) s, LANE(real) c) {
  LANE(real) turned = *sine * c + *cosine * s;
  *cosine = *cosine * c - *sine * s;
  *sine = turned;
}

/* Sine and cosine of the phase of a harmonic signal: multiplied by the amplitude of u (sine_u,
 * cosine_u), and by that of u' (sine_v, cosine_v). */
typedef struct LANE(phasor) {
  LANE(real) sine_u, cosine_u, sine_v, cosine_v;
} LANE(phasor);

LANE_INLINE LANE(phasor)
    LANE(phasor_of)(LANE(real) sine, LANE(real) cosine, LANE(real) scale_u, LANE(real) scale_v) {
  LANE(phasor) a = {sine * scale_u, cosine * scale_u, sine * scale_v, cosine * scale_v};
  return a;
}

/* Rotates the phasor by an angle with sine s and cosine c, and sets *u and *v to the harmonic
 * signal and its time derivative there. */
LANE_INLINE void LANE(phasor_at)(const LANE(phasor) * a, LANE(real) s, LANE(real) c, LANE(real) * u,
                                 LANE(real) * v) {
  *u = a->sine_u * c + a->cosine_u * s;
  *v = a->cosine_v * c - a->sine_v * s;
}

/* Coefficients of a cubic (u) and of its time derivative (v), as polynomials in z = time/h. The
 * cubic connects two random steps a time h apart, and matches displacement and velocity at both. */
typedef struct LANE(cubic) {
  LANE(real) u[4], v[3];
} LANE(cubic);

LANE_INLINE LANE(cubic) LANE(cubic_between)(LANE(real) u0, LANE(real) v0, LANE(real) u1,
                                            LANE(real) v1, LANE(real) h, LANE(real) per_h) {
  LANE(real) rise = u1 - u0, a = h * v0 - rise, c = rise - h * v1;
  LANE(real) second = c - (a + a), third = a - c;
  LANE(cubic)
  p = {{u0, h * v0, second, third}, {v0, (second + second) * per_h, (3.0 * third) * per_h}};
  return p;
}

/* Evaluates the cubic and its derivative at z = (time since the first of the two random
 * steps)/h. */
LANE_INLINE void LANE(cubic_at)(const LANE(cubic) * p, LANE(real) z, LANE(real) * u,
                                LANE(real) * v) {
  *u = p->u[0] + z * (p->u[1] + z * (p->u[2] + z * p->u[3]));
  *v = p->v[0] + z * (p->v[1] + z * p->v[2]);
}

/* Fades a signal in: multiplies u by r(s) = 6 s^5 - 15 s^4 + 10 s^3, with s = t/ramp, and sets v to
 * the derivative of the product. For s >= 1, and without a ramp (s infinite), u and v stay as they
 * are. Returns r. */
LANE_INLINE LANE(real) LANE(fade)(LANE(real) t, LANE(real) ramp, LANE(real) * u, LANE(real) * v) {
  LANE(real) one = LANE(splat)(1.0), s = t / ramp, rest = s - 1.0;
  LANE(mask) fading = LANE(greater)(one, s);
  LANE(real) r = s * s * s * (s * (6.0 * s - 15.0) + 10.0), dr = 30.0 * s * s * rest * rest / ramp;
  *v = LANE(select)(fading, *v * r + *u * dr, *v);
  *u = LANE(select)(fading, *u * r, *u);
  return LANE(select)(fading, r, one);
}

/* Returns the rounding error of the number product = c * at (Dekker's algorithm): the exact product
 * is `product` plus the returned number. */
LANE_INLINE LANE(real) LANE(product_rest)(LANE(real) c, LANE(real) at, LANE(real) product) {
  LANE(real) p = c * 134217729.0, q = at * 134217729.0;
  LANE(real) c_high = p - (p - c), at_high = q - (q - at);
  LANE(real) c_low = c - c_high, at_low = at - at_high;
  return ((c_high * at_high - product) + (c_high * at_low + c_low * at_high)) + c_low * at_low;
}
