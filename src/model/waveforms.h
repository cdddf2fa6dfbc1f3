/* waveforms.h: periodic motions u(t) = A f(w t + phi), f(z + pi) = -f(z).
 *
 * A waveform is one row and one block of text here: deck keys, checks, documentation, amplitude for a given
 * acceleration, value and velocity. A new one needs its number in sd_motion_kind (slipdisk/model.h), a row and its
 * text here, and the rows of docs/deck.md that test_deck_reference asks for.
 *
 * The rows are read once; the text over lanes once per LANE_WIDTH, after base/lane.h.
 */
#ifndef MODEL_WAVEFORMS_H
#define MODEL_WAVEFORMS_H

#include <math.h>

#include "slipdisk/model.h"

/* Rows of motion_kinds.h. Rotated: sine and cosine go from step to step by a rotation. Phased: a function of the phase. */
#define ROTATED_WAVES(ROW)                                                                                   \
  ROW(SD_MOTION_HARMONIC, harmonic, SIGNAL_WAVE, harmonic_amplitude, NULL,                                   \
      "amplitude/acceleration* frequency/omega* phase ramp", "u = A sin(w t + phi) (eq. 20)")
#define PHASED_WAVES(ROW)                                                                                    \
  ROW(SD_MOTION_PARABOLIC, parabolic, SIGNAL_WAVE, parabolic_amplitude, NULL,                                \
      "amplitude/acceleration* frequency/omega* phase ramp",                                                 \
      "the same, each half wave replaced by a parabola (eq. 21)")
#define WAVEFORMS(ROW) ROTATED_WAVES(ROW) PHASED_WAVES(ROW)

/* Keys of the deck that set a member of sd_motion: member and key, kind, range, unit, default, meaning. */
#define WAVE_KEYS(KEY) KEY(phase, DECK_KEY_ANGLE, DECK_ANY, "rad", "0.0", "phase phi in sin(w t + phi)")

/* A for the largest acceleration a w^2; the numbers that the text below wants. */
enum { WAVE_SHAPE = 3 };

static inline double harmonic_amplitude(const sd_motion *q, double a) { return (void)q, a; }
static inline void harmonic_shape(const sd_motion *q, double shape[WAVE_SHAPE]) {
  shape[0] = q->amplitude;
  shape[1] = q->amplitude * q->omega;
}

/* u = 4A(z - z|z|), z = (w t + phi)/pi: u'' is 8A (w/pi)^2 in size at all times. */
static inline double parabolic_amplitude(const sd_motion *q, double a) {
  return (void)q, a * M_PI * M_PI / 8;
}
static inline void parabolic_shape(const sd_motion *q, double shape[WAVE_SHAPE]) {
  shape[0] = 8.0 * q->amplitude;
  shape[1] = 4.0 * q->amplitude * (q->omega / M_PI);
}

#endif

/* --- value and velocity after t turns, over lanes -------------------------------------------------------- */

#ifdef LANE_WIDTH

/* eq. 21 and its derivative (22): with w in [-1/2, 1/2], u = 8 A w (1 - 2 |w|), u' = 4 A (omega/pi) (1 - 4 |w|). */
LANE_INLINE void LANE(parabolic)(LANE(real) t, const LANE(real) shape[WAVE_SHAPE], LANE(real) * u,
                                 LANE(real) * v) {
  LANE(real) w = t - LANE(nearest)(t), a = shape[0], b = shape[1];
  LANE(real) size = LANE(as_real)(LANE(as_bits)(w) & 0x7fffffffffffffffu);
  *u = w * (a - (2.0 * a) * size);
  *v = b - (4.0 * b) * size;
}

/* Of any phased form. */
LANE_INLINE void LANE(wave_at)(sd_motion_kind form, LANE(real) t, const LANE(real) shape[WAVE_SHAPE],
                               LANE(real) * u, LANE(real) * v) {
#define WAVE_CASE(kind, word, ...)                                                                           \
  case kind: LANE(word)(t, shape, u, v); return;
  switch (form) {
    PHASED_WAVES(WAVE_CASE)
    default: __builtin_unreachable(); /* kernels switch over the forms */
  }
#undef WAVE_CASE
}

#endif
