/* prescribed.h: what pose_batch.c asks of the motions of one system (motion.c). */
#ifndef PHYSICS_PRESCRIBED_H
#define PHYSICS_PRESCRIBED_H

#include "physics/motion/motion.h"
#include "physics/motion/signals.h"

signals *motion_signals(const engine *e);
/* The motion whose signal is term t of a coordinate. */
size_t motion_term(const engine *e, const prescribed *p, size_t t);
/* Offset taken off the sum of a coordinate's signals (turn or image), and the base that is added then. */
void motion_offset(const engine *e, uint32_t slot, int coordinate, double *off, double *base);
/* Turns stay within half of 8 rad, positions within the box. */
bool motion_in_range(const engine *e, int coordinate, double at);

#endif
