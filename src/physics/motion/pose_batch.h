/* pose_batch.h: signals u(t) and prescribed coordinates of several similar systems side by side.
 * pose_batch.c allocates and loads them, kernel_pose_batch.c computes them.
 *
 * Arrays of SIGNAL_LANES numbers have one number per system; lanes beyond the width of the
 * machine's vectors are not used.
 */
#ifndef PHYSICS_POSE_BATCH_H
#define PHYSICS_POSE_BATCH_H

#include "physics/motion/motion_kernels.h"

enum { SIGNAL_LANES = 8 };

/* Signal u(t) of one motion in all systems. */
struct lanes_signal {
  /* Constants of the signal, one per system. Those of a wave have the names of the members of
   * struct wave. */
  _Alignas(64) double rate[SIGNAL_LANES], rate_high[SIGNAL_LANES], rate_low[SIGNAL_LANES],
      offset[SIGNAL_LANES];
  double shape[WAVE_SHAPE][SIGNAL_LANES];
  double sine[2 * WAVE_FINE][SIGNAL_LANES], cosine[2 * WAVE_FINE][SIGNAL_LANES];
  double dt[SIGNAL_LANES], ramp[SIGNAL_LANES];
  /* only for random motions: time h between random steps, and 1/h */
  double h[SIGNAL_LANES], per_h[SIGNAL_LANES];
  /* only for constant velocity: velocity, and displacement per step */
  double velocity[SIGNAL_LANES], per_step[SIGNAL_LANES];
  /* Exact phase of a wave at its anchor, in turns, and sine and cosine of this phase. */
  double turns[SIGNAL_LANES], anchor_sine[SIGNAL_LANES], anchor_cosine[SIGNAL_LANES];
  int64_t anchor; /* number of steps from the motion's start to the anchor; -1: not computed */
  signal_source source;
  sd_motion_kind form;
  size_t motion;       /* index of the motion in the model */
  int64_t interval;    /* only for random motions: number of time steps between random steps */
  double per_interval; /* 1/interval */
  /* ramped: the signal has a fade-in in some system; runs: the motion is switched on */
  bool ramped, runs;
  /* Number and list of coordinates that only this signal moves and that have no offset from
   * wrapping: their poses are written while the signal is computed. */
  size_t n_alone;
  lanes_pose **alone;
  bool shared;        /* true if some coordinate is the sum of this and other signals */
  oscillators *draws; /* oscillators of a random motion, one per system */
  /* Values at the steps computed ahead: `stride` numbers per step, one per system. */
  bool posed; /* true if the poses of `alone` have been written */
  /* displacement, velocity and rounding error of u, as in signal_values; low is NULL if u is
   * exact */
  const double *u, *v, *low;
  size_t stride;
  double *rows[3]; /* memory for u, v and low, used with a stride of the machine's vector width */
};

/* One prescribed coordinate in all systems. */
struct lanes_pose {
  /* offset from wrapping, and pose without running motions; value = sum of signals - off + base */
  _Alignas(64) double off[SIGNAL_LANES], base[SIGNAL_LANES];
  /* true if the offset `off` is not 0 in some system */
  bool turned;
  uint32_t slot;
  int coordinate;
  const lanes_signal **signals; /* signals that are added to the coordinate */
  size_t n_signals;
  /* values and velocities: `stride` numbers per step (one per system), from the first step ahead
   * on */
  double *value, *velocity;
  size_t stride;
};

#endif
