/* motion.h: prescribed motions of disks and walls, and walls whose motion depends on the disks. The door of this room.
 *
 * A motion adds a signal u(t) to one coordinate of its bodies. Signals do not depend on the dynamics, so they are
 * computed MOTION_BATCH steps ahead: steps along the lanes for one system, one system per lane for several.
 */
#ifndef PHYSICS_MOTION_H
#define PHYSICS_MOTION_H

#include "model/motions.h"
#include "physics/system/work.h"

enum { MOTION_BATCH = 64 };

/* --- one system -------------------------------------------------------------------------------------- */

/* A prescribed coordinate: the signals that are added to it, and its values over the batch. */
typedef struct prescribed {
  uint32_t slot;
  int coordinate;
  size_t first, count; /* in the list of terms */
  double *at, *speed;  /* in the state */
  const double *force; /* of the contacts, in the state */
  double last; /* after the last step: the predictor moves free disks before they are posed */
  double moved, force_before; /* by the last step */
  double speed_before;        /* that it began with */
  double low, high;           /* least and largest value of the batch */
  double value[MOTION_BATCH], velocity[MOTION_BATCH];
} prescribed;

/* Tables for the model's motions; what is running follows from the state. SD_ERROR_IO: there is
 * no memory for those by body; SD_ERROR_USER: no curve goes through a table. */
sd_status motion_new(engine *e, sd_messages *messages);
void motion_free(engine *e);

/* The forces of step 0 are known now: loads and servos that run begin with them. */
void motion_begin_run(engine *e);
/* A phase begins (state->phase): switches motions on and off, freezing what they displaced into
 * the base. */
void motion_begin_phase(engine *e);
/* The lists of running motions, from the state; called after loading a state. */
void motion_resume(engine *e);
/* The state went on by other means while the same motions run: what was computed ahead is forgotten. */
void motion_reload(engine *e);
/* Brings the oscillators in the state to the step that is completed. */
void motion_store(engine *e);

/* Sets the velocities of prescribed coordinates at step 0. Servos and loads begin at rest. */
void motion_first_speeds(engine *e);
/* Sets every prescribed coordinate and its velocity to their values at step state->step + 1; of clumps before that, so that
 * their disks can be placed. */
void motion_pose(engine *e, thread_work *mine);
void motion_pose_clumps(engine *e);
/* Books the work that the prescribed bodies did in this step: trapezoid of the contact forces, which must be new.
 * Loads get their velocities. */
void motion_work(engine *e);
/* The turn or image of a body changed: the values computed ahead follow. */
void motion_wrapped(engine *e, uint32_t slot);

/* Computes ahead when the batch is used up. True: in this batch no prescribed body can make the lists stale
 * or leave its range, so posing is nothing but copying value[motion_index] and velocity. */
bool motion_ahead(engine *e);
/* Of the next step in the batch. */
int64_t motion_index(const engine *e);
prescribed *motion_prescribed(engine *e, size_t *n);

/* Would the next step's poses make the lists stale? Changes nothing. */
bool motion_outruns(engine *e);
/* Does any motion run? */
bool motion_runs(const engine *e);
/* True when some wall has a running motion. */
bool motion_moves_walls(const engine *e);
/* Does a motion that runs prescribe a coordinate of a free disk? */
bool motion_drives_free(const engine *e);
/* The prescribed body that moved too far in the step just taken (step/speed.h), its slot, and how far over the radius of the
 * smallest disk, or its own where it is free along others; 0: none did. motion_work flags it as fast. */
double motion_fastest(const engine *e, size_t *slot);
/* Does motion_work change prescribed bodies? */
bool motion_corrects(const engine *e);

/* --- several systems --------------------------------------------------------------------------------- */

/* Prescribed poses of several alike systems, bit for bit as each computes them by itself. They have the same bodies and
 * the same running motions, each for the same number of steps; all else, the step included, may differ. Boxes are
 * open; there are no loads, servos, or free disks with a prescribed coordinate. */
typedef struct pose_batch pose_batch;

enum { POSE_X, POSE_Y, POSE_THETA, POSE_VX, POSE_VY, POSE_OMEGA, POSES };
enum { POSE_STEPS = MOTION_BATCH + 1 }; /* the step before the batch, and the batch */

/* Lanes beyond n <= width repeat system 0. */
pose_batch *pose_batch_new(size_t width, size_t n, engine *const *systems);
void pose_batch_free(pose_batch *b);
/* Takes running motions, oscillators and poses from the states, where motion_store has brought them. */
void pose_batch_load(pose_batch *b);
/* Brings oscillators in the states to state->step, as motion_store does; the systems can go on by themselves. */
void pose_batch_store(pose_batch *b);
/* Computes ahead when the batch is used up, so that the step after state->step is in it. Returns how many steps are
 * ready from there, up to the last one before an angle of some lane leaves its range; 0: the next step needs the
 * general path, and pose_batch_load after it. */
int64_t pose_batch_ahead(pose_batch *b);
/* Step state->step + 1 of system 0 has the index k = state->step + 1 - first. */
int64_t pose_batch_first(const pose_batch *b);
/* [slots from the first prescribed one][POSES][POSE_STEPS][width]: step first + k has index k. */
const double *pose_batch_poses(const pose_batch *b);

#endif
