/* motion.h: prescribed motions of disks and walls, and walls whose motion depends on the disks
 * (loads, servos). The public header of physics/motion.
 *
 * A motion adds a signal u(t) to one coordinate of its bodies. Signals do not depend on the
 * dynamics, so they are computed MOTION_BATCH steps ahead. Vector lanes hold consecutive steps of
 * one system, or the same step of several systems.
 */
#ifndef PHYSICS_MOTION_H
#define PHYSICS_MOTION_H

#include "model/motions.h"
#include "physics/system/work.h"

enum { MOTION_BATCH = 64 };

/* --- one system ------------------------------------------------------------------------------- */

/* One prescribed coordinate of a body: its signals, and its values over the batch. */
typedef struct prescribed {
  uint32_t slot;       /* slot of the body, or (number of bodies) + clump */
  int coordinate;      /* SD_X, SD_Y, SD_THETA or SD_SURFACE */
  size_t first, count; /* range of its signals in motions.terms */
  double *at, *speed;  /* coordinate and velocity, in the state */
  const double *force; /* force or torque by contacts along the coordinate, in the state */
  /* Value after the last step; *at may differ, since the predictor moves free disks before they are
   * posed. */
  double last;
  double moved, force_before; /* displacement in the last step, and the force before it */
  double speed_before;        /* velocity before the last step */
  double low, high;           /* smallest and largest value in the batch */
  double value[MOTION_BATCH], velocity[MOTION_BATCH];
} prescribed;

/* Allocates the tables of the model's motions; which motions run follows from the state.
 * SD_ERROR_IO: no memory for tables by body; SD_ERROR_USER: the values of a table admit no
 * spline. */
sd_status motion_new(engine *e, sd_messages *messages);
void motion_free(engine *e);

/* Starts the loads and servos that run at step 0; the forces of step 0 must be known. */
void motion_begin_run(engine *e);
/* Begins phase state->phase: switches motions on and off; the displacement of a motion that is
 * switched off is added to the base pose. */
void motion_begin_phase(engine *e);
/* Rebuilds the lists of running motions from the state; to be called after a state has been
 * loaded. */
void motion_resume(engine *e);
/* Discards the values computed ahead; to be called after other code has advanced the state, with
 * the same motions running. */
void motion_reload(engine *e);
/* Stores the oscillators of random motions in the state, as of the last completed step. */
void motion_store(engine *e);

/* Sets the velocities of prescribed coordinates at step 0. Loads and servos begin at rest. */
void motion_first_speeds(engine *e);
/* motion_pose sets all prescribed coordinates of bodies, and their velocities, to their values at
 * step state->step + 1. motion_pose_clumps does so for clumps; it is called first, so that their
 * disks can be placed. */
void motion_pose(engine *e, thread_work *mine);
void motion_pose_clumps(engine *e);
/* Books the work of prescribed bodies in this step, as trapezoid of the contact forces, which must
 * be those at its end. Corrects the velocities of loads. */
void motion_work(engine *e);
/* Updates the values computed ahead after the turn or image count of a body has changed. */
void motion_wrapped(engine *e, uint32_t slot);

/* Computes the next batch if the present one is used up. Returns true if no prescribed body can
 * make the neighbour list stale or leave its range in this batch; to pose the bodies it then
 * suffices to copy value[motion_index] and velocity[motion_index]. */
bool motion_ahead(engine *e);
/* Returns the index in the batch of step state->step + 1. */
int64_t motion_index(const engine *e);
/* Returns the array of prescribed coordinates, and its length in *n; owned by the engine. */
prescribed *motion_prescribed(engine *e, size_t *n);

/* True if the poses of the next step would make the neighbour list stale. The state is not
 * changed. */
bool motion_outruns(engine *e);
/* True if any motion is running. */
bool motion_runs(const engine *e);
/* True if some wall has a running motion; motions of its surface do not count. */
bool motion_moves_walls(const engine *e);
/* True if a running motion prescribes a coordinate of a free disk. */
bool motion_drives_free(const engine *e);
/* Finds the prescribed body that moved farthest beyond the displacement limit in the last step
 * (step/step.h). Returns its displacement over the radius of the smallest disk, or over its own
 * radius if it is a free disk with a prescribed coordinate, and its slot in *slot; 0: none was
 * beyond. */
double motion_fastest(const engine *e, size_t *slot);
/* True if motion_work changes the velocities of walls, that is if loads or servos run. */
bool motion_corrects(const engine *e);

/* --- several systems -------------------------------------------------------------------------- */

/* Prescribed poses of several similar systems, with the same bits as if each computed them by
 * itself. The systems have the same bodies and the same running motions, each running for the same
 * number of steps; all else, also the step number, may differ. Boxes are open; there are no loads,
 * servos, or free disks with a prescribed coordinate. */
typedef struct pose_batch pose_batch;

enum { POSE_X, POSE_Y, POSE_THETA, POSE_VX, POSE_VY, POSE_OMEGA, POSES };
/* steps in a pose_batch: the batch, and the step before it */
enum { POSE_STEPS = MOTION_BATCH + 1 };

/* Returns a new batch for n <= width systems, which the caller keeps owning; lanes from n on repeat
 * system 0. */
pose_batch *pose_batch_new(size_t width, size_t n, engine *const *systems);
void pose_batch_free(pose_batch *b);
/* Loads running motions, oscillators and poses from the states; motion_store must have been
 * called. */
void pose_batch_load(pose_batch *b);
/* Stores the oscillators in the states, as of state->step, like motion_store; the systems can then
 * continue by themselves. */
void pose_batch_store(pose_batch *b);
/* Computes the next batch if step state->step + 1 is not in the present one. Returns the number of
 * steps that are ready from there on, up to the last one before an angle of some lane leaves its
 * range. 0: the next step must be made in the general way, and pose_batch_load must be called after
 * it. */
int64_t pose_batch_ahead(pose_batch *b);
/* Returns the step of system 0 with index 0 in the batch: step state->step + 1 has the index
 * state->step + 1 - pose_batch_first(b). */
int64_t pose_batch_first(const pose_batch *b);
/* Returns the poses [slot - first prescribed slot][POSES][POSE_STEPS][width]; step
 * pose_batch_first(b) + k has index k. Owned by the batch. */
const double *pose_batch_poses(const pose_batch *b);

#endif
