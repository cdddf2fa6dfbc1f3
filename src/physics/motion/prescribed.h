/* prescribed.h: access of pose_batch.c to the motions of one system (motion.c). */
#ifndef PHYSICS_PRESCRIBED_H
#define PHYSICS_PRESCRIBED_H

#include "physics/motion/motion.h"
#include "physics/motion/signals.h"

/* Returns the signals of the model's motions; owned by the engine. */
signals *motion_signals(const engine *e);
/* Returns the index of the motion whose signal is term t of a prescribed coordinate. */
size_t motion_term(const engine *e, const prescribed *p, size_t t);
/* Sets *off (turn or image shift) and *base (base pose) of a coordinate: its value is the sum of
 * its signals - *off + *base. */
void motion_offset(const engine *e, uint32_t slot, int coordinate, double *off, double *base);
/* True if a coordinate is in its range: angles in [-4, 4] rad, positions in the box, displacements
 * of a surface within half of body_surface_turn. */
bool motion_in_range(const engine *e, int coordinate, double at);

#endif
