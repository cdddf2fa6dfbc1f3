/* waveforms.h: periodic motions u(t) = A f(w t + phi) with f(z + pi) = -f(z).
 *
 * A waveform is one row and one block of functions here, from which deck keys, checks,
 * documentation, the amplitude for a given acceleration, value and velocity follow. A new one needs
 * its number in sd_motion_kind (slipdisk/model.h), a row and its functions here, and the rows of
 * docs/deck.md that test_deck_reference asks for.
 *
 * The rows are read once; the functions for SIMD lanes are compiled once per LANE_WIDTH, after
 * base/lane.h.
 */
#ifndef MODEL_WAVEFORMS_H
#define MODEL_WAVEFORMS_H

#include <math.h>

#include "slipdisk/model.h"

/* Rows of the table MOTION_KINDS (motions.h). Rotated waves advance sine and cosine by a
 * rotation from step to step; phased waves are computed from the phase (PHASED_WAVES). */
#define ROTATED_WAVES(ROW)                                                                         \
  ROW(SD_MOTION_HARMONIC, harmonic, SIGNAL_WAVE, harmonic_amplitude, NULL,                         \
      "amplitude/acceleration* frequency/omega* phase ramp", "u = A sin(w t + phi) (eq. 20)")
#define PHASED_WAVES(ROW)                                                                          \
  ROW(SD_MOTION_PARABOLIC, parabolic, SIGNAL_WAVE, parabolic_amplitude, NULL,                      \
      "amplitude/acceleration* frequency/omega* phase ramp",                                       \
      "the same, each half wave replaced by a parabola (eq. 21)")                                  \
  ROW(SD_MOTION_TRIANGLE, triangle, SIGNAL_WAVE, NULL, NULL,                                       \
      "amplitude* frequency/omega* phase ramp",                                                    \
      "the same, each quarter a straight line: constant speed between -A and A")                   \
  ROW(SD_MOTION_SQUARE, square, SIGNAL_WAVE, square_amplitude, check_square,                       \
      "amplitude/acceleration* frequency/omega* rise* phase ramp",                                 \
      "rests at -A and A in turn, with smooth changes of sides")
#define WAVEFORMS(ROW) ROTATED_WAVES(ROW) PHASED_WAVES(ROW)

/* Deck keys that set a member of sd_motion. Columns: member and key, kind, range, unit, default,
 * meaning. */
#define WAVE_KEYS(KEY)                                                                             \
  KEY(phase, DECK_KEY_ANGLE, DECK_ANY, "rad", "0.0", "phase phi in sin(w t + phi)")                \
  KEY(rise, DECK_KEY_NUMBER, DECK_UP_TO_1, "-", "-",                                               \
      "square: share of half a period that a change of sides takes")

/* Number of constants of a waveform, which NAME_shape computes from the motion and the functions
 * for SIMD lanes below read. NAME_amplitude returns the amplitude A at which the largest
 * acceleration is a w^2. */
enum { WAVE_SHAPE = 3 };

static inline double harmonic_amplitude(const sd_motion *q, double a) { return (void)q, a; }
static inline void harmonic_shape(const sd_motion *q, double shape[WAVE_SHAPE]) {
  shape[0] = q->amplitude;
  shape[1] = q->amplitude * q->omega;
}

/* Parabolic wave u = 4A(z - z|z|) with z = (w t + phi)/pi in [-1, 1]: |u''| is 8A (w/pi)^2 at
 * all times. */
static inline double parabolic_amplitude(const sd_motion *q, double a) {
  return (void)q, a * M_PI * M_PI / 8;
}
static inline void parabolic_shape(const sd_motion *q, double shape[WAVE_SHAPE]) {
  shape[0] = 8.0 * q->amplitude;
  shape[1] = 4.0 * q->amplitude * (q->omega / M_PI);
}

/* Triangle wave: the speed is constant, 4 A per period; the acceleration is infinite at the
 * turning points. */
static inline void triangle_shape(const sd_motion *q, double shape[WAVE_SHAPE]) {
  shape[0] = 4.0 * q->amplitude;
  shape[1] = 2.0 * q->amplitude * (q->omega / M_PI);
}

/* Square wave: each change from one side to the other is u = A (15 q - 10 q^3 + 3 q^5)/8, q from
 * -1 to 1 in the time rise pi/w, so that velocity and acceleration are continuous. |u'| is at
 * most 15/8 A q', |u''| at most 5/sqrt(3) A q'^2, q' = 2 w/(pi rise). */
static inline double square_amplitude(const sd_motion *q, double a) {
  double per_rate = 0.5 * M_PI * q->rise;
  return a * per_rate * per_rate * sqrt(3.0) / 5.0;
}
static inline void square_shape(const sd_motion *q, double shape[WAVE_SHAPE]) {
  shape[0] = q->amplitude;
  shape[1] = 1.875 * q->amplitude * (2.0 * q->omega / (M_PI * q->rise));
  shape[2] = 4.0 / q->rise; /* dq/dt with the time t in periods */
}
/* Reports a rise that is out of range, or a change of sides that takes too few time steps. */
void check_square(const sd_model *model, size_t motion, sd_messages *messages);

#endif

/* --- value and velocity after t turns, over lanes --------------------------------------------- */

#ifdef LANE_WIDTH

/* Parabolic wave (eq. 21 of the paper) and its derivative (eq. 22) after t periods: with w = t
 * reduced to [-1/2, 1/2], u = 8 A w (1 - 2 |w|), u' = 4 A (omega/pi) (1 - 4 |w|). */
LANE_INLINE void LANE(parabolic)(LANE(real) t, const LANE(real) shape[WAVE_SHAPE], LANE(real) * u,
                                 LANE(real) * v) {
  LANE(real) w = t - LANE(nearest)(t), a = shape[0], b = shape[1];
  LANE(real) size = LANE(as_real)(LANE(as_bits)(w) & 0x7fffffffffffffffu);
  *u = w * (a - (2.0 * a) * size);
  *v = b - (4.0 * b) * size;
}

/* Position on a wave after t periods, relative to the nearest zero of the wave: distance x from
 * the zero in [0, 1/4] periods, sign bit of the wave, and whether the wave rises at that zero. */
typedef struct LANE(flank) {
  LANE(real) x;
  LANE(bits) side;
  LANE(mask) rises;
} LANE(flank);

/* Computes the position relative to the nearest zero of a wave after t periods. */
LANE_INLINE LANE(flank) LANE(flank_at)(LANE(real) t) {
  LANE(real) w = t - LANE(nearest)(t);
  LANE(real) size = LANE(as_real)(LANE(as_bits)(w) & 0x7fffffffffffffffu), rest = 0.5 - size;
  LANE(flank)
  f = {LANE(min)(size, rest), LANE(as_bits)(w) & 0x8000000000000000u, LANE(greater)(rest, size)};
  return f;
}

/* Returns a with its sign flipped if the bit `side` is set. */
LANE_INLINE LANE(real) LANE(signed_as)(LANE(bits) side, LANE(real) a) {
  return LANE(as_real)(LANE(as_bits)(a) ^ side);
}

/* Triangle wave: displacement u and velocity v after t periods. */
LANE_INLINE void LANE(triangle)(LANE(real) t, const LANE(real) shape[WAVE_SHAPE], LANE(real) * u,
                                LANE(real) * v) {
  LANE(flank) f = LANE(flank_at)(t);
  *u = LANE(signed_as)(f.side, f.x * shape[0]);
  *v = LANE(select)(f.rises, shape[1], -shape[1]);
}

/* Square wave with smooth changes of sides: displacement u and velocity v after t periods. */
LANE_INLINE void LANE(square)(LANE(real) t, const LANE(real) shape[WAVE_SHAPE], LANE(real) * u,
                              LANE(real) * v) {
  LANE(flank) f = LANE(flank_at)(t);
  LANE(real) q = LANE(min)(f.x * shape[2], LANE(splat)(1.0)), q2 = q * q, rest = 1.0 - q2;
  LANE(real) speed = shape[1] * (rest * rest);
  *u = LANE(signed_as)(f.side, shape[0] * (q * (15.0 + q2 * (3.0 * q2 - 10.0)) * 0.125));
  *v = LANE(select)(f.rises, speed, -speed);
}

/* Displacement u and velocity v after t periods of any waveform in PHASED_WAVES. */
LANE_INLINE void LANE(wave_at)(sd_motion_kind form, LANE(real) t,
                               const LANE(real) shape[WAVE_SHAPE], LANE(real) * u, LANE(real) * v) {
#define WAVE_CASE(kind, word, ...)                                                                 \
  case kind: LANE(word)(t, shape, u, v); return;
  switch (form) {
    PHASED_WAVES(WAVE_CASE)
    default: __builtin_unreachable(); /* callers pass only waveforms of PHASED_WAVES */
  }
#undef WAVE_CASE
}

#endif
