/* motions.h: the kinds of prescribed motion, the disks that motions prescribe, displacements of
 * bodies in one step, and numbers of random streams. */
#ifndef SLIPDISK_MODEL_MOTIONS_H
#define SLIPDISK_MODEL_MOTIONS_H

#include <stdbool.h>
#include <stdint.h>

#include "slipdisk/model.h"
#include "model/waveforms.h"
#include "slipdisk/status.h"

/* --- kinds of motion -------------------------------------------------------------------------- */

/* Table of the kinds of motion, one row per kind; deck keys, checks, signals and documentation
 * follow from it.
 *
 * ROW(number, name in the deck, source, amplitude, check, keys in the deck, meaning): source is the
 * method by which values are computed; keys are as in deck_shape (keys.h). waveforms.h has the rows
 * of periodic waves.
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

/* Method by which the values of a motion are computed. */
typedef enum signal_source {
  SIGNAL_STEADY,
  SIGNAL_WAVE,
  SIGNAL_RANDOM,
  SIGNAL_TABLE,
  /* Computed from the contact forces at each step, so that values cannot be computed ahead; not
   * available to small systems that run side by side in SIMD lanes. */
  SIGNAL_FEEDBACK
} signal_source;

typedef struct motion_kind {
  const char *name;
  signal_source source;
  /* Returns the amplitude A at which the largest acceleration is a omega^2; NULL: this kind of
   * motion cannot be given by an acceleration. */
  double (*amplitude)(const sd_motion *motion, double a);
  /* Reports errors in the parameters of this kind; NULL: it has no checks of its own. Loads and
   * servos are checked by loads_check (model.h). */
  void (*check)(const sd_model *model, size_t motion, sd_messages *messages);
} motion_kind;

extern const motion_kind motion_kinds[SD_MOTION_KINDS];

static inline signal_source motion_source(const sd_motion *q) {
  return motion_kinds[q->kind].source;
}
static inline bool motion_is_wave(const sd_motion *q) { return motion_source(q) == SIGNAL_WAVE; }
static inline bool motion_is_feedback(const sd_motion *q) {
  return motion_source(q) == SIGNAL_FEEDBACK;
}

/* Reports errors of a motion: fewer than 4 time steps per cycle of a wave, or wrong parameters
 * of its kind. */
void motion_check(const sd_model *model, size_t motion, sd_messages *messages);

/* Period of a motion, time; 0: not periodic. */
double motion_period(const sd_motion *motion);
/* Amplitude of a periodic wave, or rms displacement of a random motion; infinite for other
 * motions. */
double motion_amplitude(const sd_motion *motion);
/* Computes the constants shape[] of a wave, which are arguments of its functions in waveforms.h. */
void motion_shape(const sd_motion *wave, double shape[WAVE_SHAPE]);
/* Estimates the displacement at `time` after the motion was switched on, with linear
 * interpolation between rows of a table and a linear ramp; 0 for random motions, loads and
 * servos. */
double motion_at(const sd_motion *motion, double time);
/* Displacement with which a motion begins: 0 with a ramp; random motion: three standard
 * deviations; loads and servos: 0. */
double motion_first(const sd_motion *motion);
/* Largest displacement in one step of a motion that is on; random motion: three standard
 * deviations; load: 0. */
double motion_stride(const sd_motion *motion, double dt);

/* --- prescribed disks ------------------------------------------------------------------------- */

/* Marks the disks whose coordinates are all prescribed or locked as driven, and counts the free
 * ones. If none is free, some become free with all coordinates locked, so that contacts are
 * evaluated. SD_ERROR_IO: out of memory. */
sd_status model_find_driven(sd_model *model);
/* Makes a disk one that can be held and released, unless it is: sets `holds`, and `held` if it is
 * fixed or moved; it is not driven then. moved: which coordinates motions prescribe, as in
 * model_moved. */
void model_make_holdable(sd_model *model, uint32_t disk, unsigned moved);
/* Returns which coordinates motions prescribe, for each disk that all ranks store: bits 1 <<
 * coordinate. The caller frees the array. NULL: out of memory. */
unsigned char *model_moved(const sd_model *model);

/* --- displacements of bodies in one step, estimated before the run ---------------------------- */

/* A prescribed body jumps if in one step it moves farther than its velocity accounts for, by
 * more than this fraction of limits.displacement. */
#define STRIDES_JUMP 0.1

/* Distance from a wall's pivot to its farthest point; 0 for circles, which turn into themselves,
 * and for disks. */
double strides_arm(const sd_model *model, uint32_t body);

/* The body that moves farthest in a step, the motion that contributes most to this, and the
 * distance moved divided by the radius of the smallest free disk. */
typedef struct body_stride {
  uint32_t body;
  size_t motion;
  double length;
} body_stride;

/* Finds the body that moves farthest in one step if all its motions are switched on. False: no
 * body moves, or out of memory (shortage_note in memory.h). */
bool strides_longest(const sd_model *model, body_stride *longest);
/* True if a prescribed body may jump or exceed limits.displacement in a step, or has a motion of
 * kind load or servo; only in this case a run checks the steps of prescribed bodies. */
bool strides_are_long(const sd_model *model);
/* Displacement with which a motion begins, at the farthest point of the bodies that it moves,
 * divided by the radius of the smallest free disk; 0 for moving surfaces and for disks that
 * turn. */
double strides_first_jump(const sd_model *model, size_t motion);

/* --- random streams --------------------------------------------------------------------------- */

/* Kind of body that a random stream moves, part of the number of the stream. Another part is the
 * index: the number of the disk, the wall, the group, or of the first body in a list. */
enum { STREAM_DISK, STREAM_WALL, STREAM_GROUP, STREAM_LIST, STREAM_THINGS };
enum { STREAM_INDICES = 1 << 24, STREAM_ORDINALS = 16 };

/* Returns the number of a random stream. thing: STREAM_DISK ...; ordinal: number of earlier
 * random motions of the same coordinate and bodies. */
static inline uint32_t stream_number(int thing, uint32_t index, unsigned ordinal, int coordinate) {
  return index << 8 | ordinal << 4 | (unsigned)coordinate << 2 | (unsigned)thing;
}

#endif
