/* pose_batch.h: signals and prescribed coordinates of several similar systems side by side.
 * pose_batch.c stores them, kernel_pose_batch.c computes them.
 *
 * Arrays of SIGNAL_LANES numbers have one per system; lanes beyond the width of the machine's
 * vectors are not used.
 */
#ifndef PHYSICS_POSE_BATCH_H
#define PHYSICS_POSE_BATCH_H

#include "physics/motion/motion_kernels.h"

enum { SIGNAL_LANES = 8 };

/* One motion's signal in all systems. */
struct lanes_signal {
  /* Constants of the signal. Those of a wave are as in struct wave, by lane. */
  _Alignas(64) double rate[SIGNAL_LANES], rate_high[SIGNAL_LANES], rate_low[SIGNAL_LANES],
      offset[SIGNAL_LANES];
  double shape[WAVE_SHAPE][SIGNAL_LANES];
  double sine[2 * WAVE_FINE][SIGNAL_LANES], cosine[2 * WAVE_FINE][SIGNAL_LANES];
  double dt[SIGNAL_LANES], ramp[SIGNAL_LANES];
  double h[SIGNAL_LANES], per_h[SIGNAL_LANES]; /* random motion: time between draws, and 1/h */
  double velocity[SIGNAL_LANES], per_step[SIGNAL_LANES]; /* constant velocity, and velocity * dt */
  /* Phase of a wave at its anchor, in turns, with its sine and cosine. */
  double turns[SIGNAL_LANES], anchor_sine[SIGNAL_LANES], anchor_cosine[SIGNAL_LANES];
  int64_t anchor; /* steps from the motion's start to the anchor; -1: not computed */
  signal_source source;
  sd_motion_kind form;
  size_t motion;       /* index of the motion in the model */
  int64_t interval;    /* random motion: number of steps between draws */
  double per_interval; /* 1/interval */
  bool ramped, runs;   /* fades in in some system; is running */
  /* Coordinates without turn and image shift that only this signal moves: their poses are written
   * while the signal is computed. */
  size_t n_alone;
  lanes_pose **alone;
  bool shared;        /* true if a coordinate is summed from this and other signals */
  oscillators *draws; /* oscillators of a random motion, one per system */
  /* Values over the batch: rows of `stride` numbers, one row per step. */
  bool posed;                /* true if the poses of `alone` have been written */
  const double *u, *v, *low; /* see signal_values; low is NULL if u is exact */
  size_t stride;
  double *rows[3]; /* memory for u, v and low, with the width of the machine's vectors as stride */
};

/* One prescribed coordinate in all systems. */
struct lanes_pose {
  _Alignas(64) double off[SIGNAL_LANES], base[SIGNAL_LANES]; /* see motion_offset */
  /* true if `off` is not 0 in some lane */
  bool turned;
  uint32_t slot;
  int coordinate;
  const lanes_signal **signals; /* signals that are added to it */
  size_t n_signals;
  /* rows of `stride` numbers, one per step, from the batch's first step on */
  double *value, *velocity;
  size_t stride;
};

#endif
