/* pose_batch.h: one signal, and one prescribed coordinate, of several alike systems side by side: pose_batch.c keeps
 * them, kernel_pose_batch.c computes them.
 *
 * Numbers by lane; lanes beyond the width of the machine's vectors are not used.
 */
#ifndef PHYSICS_POSE_BATCH_H
#define PHYSICS_POSE_BATCH_H

#include "physics/motion/motion_kernels.h"

enum { SIGNAL_LANES = 8 };

struct lanes_signal {
  /* constants; those of wave by lane */
  _Alignas(64) double rate[SIGNAL_LANES], rate_high[SIGNAL_LANES], rate_low[SIGNAL_LANES],
      offset[SIGNAL_LANES];
  double shape[WAVE_SHAPE][SIGNAL_LANES];
  double sine[2 * WAVE_FINE][SIGNAL_LANES], cosine[2 * WAVE_FINE][SIGNAL_LANES];
  double dt[SIGNAL_LANES], ramp[SIGNAL_LANES];
  double h[SIGNAL_LANES], per_h[SIGNAL_LANES];           /* random: time between draws */
  double velocity[SIGNAL_LANES], per_step[SIGNAL_LANES]; /* constant velocity, also times dt */
  double turns[SIGNAL_LANES], anchor_sine[SIGNAL_LANES], anchor_cosine[SIGNAL_LANES];
  int64_t anchor; /* of these three: steps since the beginning; -1: none yet */
  signal_source source;
  sd_motion_kind form;
  size_t motion;
  int64_t interval;
  double per_interval;
  bool ramped, runs;
  size_t
      n_alone; /* coordinates that it moves alone, at no turns or images: it writes their poses at once */
  lanes_pose **alone;
  bool shared;        /* some coordinate is summed from its rows */
  oscillators *draws; /* random */
  /* of the batch: rows of `stride` numbers; low is NULL where nothing is lost to rounding */
  bool posed; /* the coordinates that it moves alone are done */
  const double *u, *v, *low;
  size_t stride;
  double *rows[3]; /* u, v, low, of the machine's width */
};

struct lanes_pose {
  _Alignas(64) double off[SIGNAL_LANES], base[SIGNAL_LANES];
  bool turned; /* some `off` is not 0 */
  uint32_t slot;
  int coordinate;
  const lanes_signal **signals;
  size_t n_signals;
  double *value, *velocity; /* of the batch's first step */
  size_t stride;
};

#endif
