/* lanes_motion.h: prescribed poses of several alike systems over the next steps, side by side: one system per lane.
 *
 * Values are those that motion.c computes for each system by itself, bit for bit. The systems have the same bodies
 * and the same running motions, and each of these runs for the same number of steps; everything else, the step
 * itself included, may differ. Boxes are open. Loads and servos do not come
 * here, nor free disks with a prescribed coordinate.
 */
#ifndef PHYSICS_LANES_MOTION_H
#define PHYSICS_LANES_MOTION_H

#include "physics/system/work.h"

typedef struct lanes_motion lanes_motion;

enum { POSE_X, POSE_Y, POSE_THETA, POSE_VX, POSE_VY, POSE_OMEGA, POSES };

/* So many steps stand in the scene: the one before the batch, and the batch. */
enum { SCENE_STEPS = 65 };

/* Lanes beyond n <= width repeat system 0. SD_ERROR_IO: no memory, *out is NULL. */
sd_status lanes_motion_new(size_t width, size_t n, engine *const *systems, lanes_motion **out);
void lanes_motion_free(lanes_motion *m);

/* Takes running motions, oscillators and poses from the states, where motion_store has brought them. The batch
 * is empty then. */
void lanes_motion_load(lanes_motion *m);
/* Brings oscillators in the states to state->step, as motion_store does; the systems can go on by themselves. */
void lanes_motion_store(lanes_motion *m);

/* Computes ahead when the batch is used up, so that the step after state->step is in it. Returns how many steps are
 * ready from there, up to the last one before an angle of some lane leaves its range; 0: the next step needs the
 * general path, and lanes_motion_load after it. */
int64_t lanes_motion_ahead(lanes_motion *m);
/* Step state->step + 1 of system 0 has the index k = state->step + 1 - first. */
int64_t lanes_motion_first(const lanes_motion *m);
/* Prescribed poses [slots from the first prescribed one][POSES][SCENE_STEPS][width]: step first + k has index k. */
const double *lanes_motion_scene(const lanes_motion *m);

#endif
