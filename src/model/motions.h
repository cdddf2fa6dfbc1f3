/* motions.h: the kinds of motion, the disks that motions prescribe, how far motions move bodies in
 * one step, and random streams. */
#ifndef SLIPDISK_MODEL_MOTIONS_H
#define SLIPDISK_MODEL_MOTIONS_H

#include <stdbool.h>
#include <stdint.h>

#include "model/model.h"
#include "model/waveforms.h"
#include "slipdisk/status.h"

/* --- kinds of motion -------------------------------------------------------------------------- */

/* One row each, from which deck, checks, signals and documentation follow.
 *
 * ROW(number, name in the deck, source, amplitude, check, keys in the deck, meaning): the source says how values come
 * about; keys as in deck_keys.h. Rows of periodic waves stand in waveforms.h.
 */

#define MOTION_KINDS(ROW)                                                                          \
  ROW(SD_MOTION_VELOCITY, velocity, SIGNAL_STEADY, NULL, NULL, "velocity* ramp", "u = v t")        \
  WAVEFORMS(ROW)                                                                                   \
  ROW(SD_MOTION_RANDOM, random, SIGNAL_RANDOM, harmonic_amplitude, check_random,                   \
      "amplitude/acceleration* frequency/omega* damping interval independent ramp",                \
      "u'' + 2 c w u' + w^2 u = white noise, of rms displacement A (eq. 52)")                      \
  ROW(SD_MOTION_TABLE, table, SIGNAL_TABLE, NULL, check_table,                                     \
      "file/times* columns values factor periodic ramp", "natural cubic spline through a table")   \
  ROW(SD_MOTION_LOAD, load, SIGNAL_FEEDBACK, NULL, NULL, "mass* force",                            \
      "wall, x or y: moves freely along the coordinate, under its weight, a force and the disks")  \
  ROW(SD_MOTION_SERVO, servo, SIGNAL_FEEDBACK, NULL, NULL, "force/pressure* speed* length",        \
      "wall, x or y: moves so that it exerts a given force on the disks")

typedef enum signal_source {
  SIGNAL_STEADY,
  SIGNAL_WAVE,
  SIGNAL_RANDOM,
  SIGNAL_TABLE,
  SIGNAL_FEEDBACK /* from the forces of the disks, step by step: never ahead, and not in lanes */
} signal_source;

typedef struct motion_kind {
  const char *name;
  signal_source source;
  /* A for the largest acceleration a omega^2; NULL: it has none */
  double (*amplitude)(const sd_motion *motion, double a);
  /* what sd_model_finish refuses; NULL: nothing of its own. Feedback: finish.h */
  void (*check)(const sd_motion *motion, double dt, const char *name, sd_messages *messages);
} motion_kind;

extern const motion_kind motion_kinds[SD_MOTION_KINDS];

static inline signal_source motion_source(const sd_motion *q) {
  return motion_kinds[q->kind].source;
}
static inline bool motion_is_wave(const sd_motion *q) { return motion_source(q) == SIGNAL_WAVE; }
static inline bool motion_is_feedback(const sd_motion *q) {
  return motion_source(q) == SIGNAL_FEEDBACK;
}

/* Tells what is refused: too few steps in a cycle, and what its kind refuses. name: as in model_motion_name. */
void motion_check(const sd_motion *motion, double dt, const char *name, sd_messages *messages);

/* Time after which it repeats, 0: never. */
double motion_period(const sd_motion *motion);
/* Amplitude of a wave, rms displacement of a random motion; infinite where neither is known. */
double motion_reach(const sd_motion *motion);
void motion_shape(const sd_motion *wave, double shape[WAVE_SHAPE]);
/* Its value a time after it was switched on, for estimates: a table straight between its rows, a ramp straight; 0 where the
 * disks or chance decide. */
double motion_at(const sd_motion *motion, double time);
/* Value with which it begins, without a ramp: three standard deviations where chance decides, 0 where the disks do. */
double motion_first(const sd_motion *motion);
/* The farthest that it goes in one step once it runs: 0 where the disks decide; three standard deviations where chance does. */
double motion_stride(const sd_motion *motion, double dt);

/* --- prescribed disks ------------------------------------------------------------------------- */

/* Marks the disks whose coordinates are all prescribed or locked as driven, and counts the free
 * ones. SD_ERROR_IO: there is no memory. */
sd_status model_find_driven(sd_model *model);
/* Coordinates that motions prescribe, of each disk that is held (rows.h): bits 1 << coordinate; to
 * be freed. NULL: there is no memory. */
unsigned char *model_moved(const sd_model *model);

/* --- how far motions move bodies in one step, known before the run ---------------------------- */

/* Part of limits.displacement from which on a body jumps: it goes farther than its velocities take it. */
#define STRIDES_JUMP 0.1

/* The distance of a wall's farthest given point from its pivot; 0 of round ones, which turn into themselves, and of disks. */
double strides_arm(const sd_model *model, uint32_t body);

/* A body, how far it goes in a step over the radius of the smallest free disk, and the motion that takes it
 * farthest. */
typedef struct body_stride {
  uint32_t body;
  size_t motion;
  double length;
} body_stride;

/* The body that goes farthest while its motions run together. False: none moves, or no memory (memory.h). */
bool strides_longest(const sd_model *model, body_stride *longest);
/* May a step take some prescribed body to the limit of displacement, or may it jump? Only then a run looks at them. */
bool strides_are_long(const sd_model *model);
/* The jump with which a motion begins, at the farthest point of the bodies it moves, over that radius; 0 of a surface and of
 * disks that turn. */
double strides_first_jump(const sd_model *model, size_t motion);

/* --- random streams --------------------------------------------------------------------------- */

/* index: of the disk, the wall, the group, or the first body of a list. */
enum { STREAM_DISK, STREAM_WALL, STREAM_GROUP, STREAM_LIST, STREAM_THINGS };
enum { STREAM_INDICES = 1 << 24, STREAM_ORDINALS = 16 };

/* ordinal: of the random motions on this coordinate of this thing, as they were given. */
static inline uint32_t stream_number(int thing, uint32_t index, unsigned ordinal, int coordinate) {
  return index << 8 | ordinal << 4 | (unsigned)coordinate << 2 | (unsigned)thing;
}

#endif
