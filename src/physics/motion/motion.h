/* motion.h: prescribed motions of disks and walls, and walls whose motion depends on the contact
 * forces (loads, servos). The public header of physics/motion.
 *
 * A motion adds a signal u(t), a displacement as a function of time, to one coordinate of its
 * bodies. Signals do not depend on the dynamics, so they are computed for MOTION_BATCH steps ahead
 * (a batch). Vector lanes hold consecutive steps of one system, or the same step of several
 * systems.
 */
#ifndef PHYSICS_MOTION_H
#define PHYSICS_MOTION_H

#include "model/motions.h"
#include "physics/system/work.h"

enum { MOTION_BATCH = 64 };

/* --- one system ------------------------------------------------------------------------------- */

/* One prescribed coordinate of a body, and its values at the steps computed ahead. */
typedef struct prescribed {
  uint32_t slot;  /* slot of the body; (number of bodies) + k for clump k */
  int coordinate; /* SD_X, SD_Y, SD_THETA or SD_SURFACE */
  /* first index and number of the signals that are added to it, in motions.terms */
  size_t first, count;
  double *at, *speed; /* pointers to the coordinate and its velocity in the state */
  /* pointer to the contact force (for an angle: torque) along the coordinate, in the state */
  const double *force;
  /* Value of the coordinate after the last step; *at may differ, since the predictor moves free
   * disks before motion_pose sets the prescribed coordinates. */
  double last;
  /* displacement in the last step, and contact force before that step */
  double moved, force_before;
  double speed_before; /* velocity before the last step */
  double low, high;    /* smallest and largest of the values computed ahead */
  double value[MOTION_BATCH], velocity[MOTION_BATCH];
} prescribed;

/* Allocates the tables of the model's motions; which motions run follows from the state.
 * SD_ERROR_IO: no memory for tables with one row per body; SD_ERROR_USER: no spline can be put
 * through the values of a tabulated motion. */
sd_status motion_new(engine *e, sd_messages *messages);
void motion_free(engine *e);

/* Starts the loads and servos that run at step 0; the forces of step 0 must be known. */
void motion_begin_run(engine *e);
/* Begins phase state->phase: switches motions on and off. If a motion is switched off, its
 * displacement is added to the base pose of its bodies, so that they stay where they are. */
void motion_begin_phase(engine *e);
/* Rebuilds the lists of running motions from the state; to be called after a state has been
 * loaded. */
void motion_resume(engine *e);
/* Discards the values computed ahead; to be called after other code has advanced the state, with
 * the same motions running. */
void motion_reload(engine *e);
/* Copies displacements and velocities of the oscillators of random motions to the state, as of the
 * last completed step. */
void motion_store(engine *e);

/* Sets the velocities of prescribed coordinates at step 0. Loads and servos begin at rest. */
void motion_first_speeds(engine *e);
/* Sets the base pose of a disk that is held from now on, so that it and the motions that run and
 * name it give its present place. Call motion_resume or motion_begin_phase afterwards. SD_ERROR_IO:
 * no memory. */
sd_status motion_take_over(engine *e, uint32_t disk);
/* Changes of constants of motions between two steps, so that no body jumps: call motion_values
 * with the old model and motion_rescale with the motions of the new one; build the work of the
 * new model; call motion_continue with the old values. The motions of both models differ in
 * constants only.
 *
 * motion_values: sets *at to the displacements u of all running motions at the present step,
 * which the caller frees; 0 for loads and servos. motion_rescale: multiplies the state of random
 * motions by the ratio of the amplitudes. motion_continue: adds the change of u to the base
 * poses, and sets the velocities of prescribed bodies. SD_ERROR_IO: no memory. */
sd_status motion_values(engine *e, double **at);
void motion_rescale(engine *e, const sd_motion *next);
sd_status motion_continue(engine *e, const double *before);

/* Sets the prescribed coordinates of disks and walls, and their velocities, to their values at step
 * state->step + 1. To be called after motion_pose_clumps, which does so for clumps, and after the
 * disks of the clumps have been placed. */
void motion_pose(engine *e, thread_work *mine);
/* Sets the prescribed coordinates of clumps, and their velocities, to their values at step
 * state->step + 1; to be called before motion_pose. */
void motion_pose_clumps(engine *e);
/* Adds the work of prescribed bodies in this step to the energy budget, by the trapezoidal rule:
 * the contact forces must be those at the end of the step. Corrects the velocities of loads. */
void motion_work(engine *e);
/* Recomputes the values ahead of a body after its angle or position has been wrapped. */
void motion_wrapped(engine *e, uint32_t slot);

/* Computes the next MOTION_BATCH steps if the present ones are used up. Returns true if no
 * prescribed body can make the neighbour list stale or leave its range in these steps; to pose the
 * bodies it then suffices to copy value[motion_index] and velocity[motion_index]. */
bool motion_ahead(engine *e);
/* Returns the index of step state->step + 1 in the arrays of values computed ahead. */
int64_t motion_index(const engine *e);
/* Returns the array of prescribed coordinates, and its length in *n; owned by the engine. */
prescribed *motion_prescribed(engine *e, size_t *n);

/* True if the poses that motions prescribe for the next step would make the neighbour list stale.
 * The state is not changed. */
bool motion_outruns(engine *e);
/* True if any motion is running. */
bool motion_runs(const engine *e);
/* Bits that tell which coordinates the running motions move. */
enum {
  MOVES_WALLS = 1, /* the pose of a wall */
  MOVES_SURFACES = 2,
  MOVES_DISKS = 4, /* driven disks */
  MOVES_FREE = 8,  /* a coordinate of a free disk */
  MOVES_CLUMPS = 16,
  MOVES_BY_FORCE = 32 /* a wall under a load or servo, whose velocity motion_work changes */
};
unsigned motion_moves(const engine *e);
/* Finds the prescribed body that moved farthest beyond the displacement limit in the last step
 * (step/step.h), and sets *slot to its slot. Returns its displacement divided by the radius of the
 * smallest disk, or by its own radius if it is a free disk with a prescribed coordinate; 0: no body
 * was beyond the limit. */
double motion_fastest(const engine *e, size_t *slot);

/* --- several systems -------------------------------------------------------------------------- */

/* Prescribed poses of several similar systems, computed side by side for MOTION_BATCH steps ahead,
 * with the same bits as if each system computed them by itself. The systems have the same bodies
 * and the same running motions, each running for the same number of steps; all else, also the step
 * number, may differ. Boxes are open; there are no loads, servos, or free disks with a prescribed
 * coordinate. */
typedef struct pose_batch pose_batch;

enum { POSE_X, POSE_Y, POSE_THETA, POSE_VX, POSE_VY, POSE_OMEGA, POSES };
/* number of steps held in a pose_batch: those computed ahead, and the step before them */
enum { POSE_STEPS = MOTION_BATCH + 1 };

/* Returns a new pose_batch for n <= width systems, which stay the property of the caller. Vector
 * lanes from n on repeat system 0. */
pose_batch *pose_batch_new(size_t width, size_t n, engine *const *systems);
void pose_batch_free(pose_batch *b);
/* Loads running motions, oscillators and poses from the states of the systems; motion_store must
 * have been called for each system before. */
void pose_batch_load(pose_batch *b);
/* Copies the oscillators of random motions to the states, as of state->step, like motion_store; the
 * systems can then continue one by one. */
void pose_batch_store(pose_batch *b);
/* Computes the next MOTION_BATCH steps if step state->step + 1 is not computed yet. Returns the
 * number of steps from there on whose poses are ready, at most up to the last step before an angle
 * of some system leaves its range. 0: the next step must be made by the general step function, one
 * system at a time, and pose_batch_load must be called after it. */
int64_t pose_batch_ahead(pose_batch *b);
/* Returns the step of system 0 that has index 0 in pose_batch_poses: step state->step + 1 has the
 * index state->step + 1 - pose_batch_first(b). */
int64_t pose_batch_first(const pose_batch *b);
/* Returns the poses of the prescribed bodies, [slot - first prescribed
 * slot][POSES][POSE_STEPS][width]; step pose_batch_first(b) + k has index k. The array is owned by
 * b. */
const double *pose_batch_poses(const pose_batch *b);

#endif
