/* feedback.h: walls whose motion depends on the contact forces: loads and servos (docs/physics.md,
 * section 6).
 *
 * Their motion depends on the dynamics, so it cannot be computed ahead: before the forces of a step
 * are evaluated, each wall moves to its pose at t + dt, which follows from the forces at t in the
 * state. The work that it does on the disks is booked like that of prescribed bodies; its own
 * energy is not part of the budget.
 */
#ifndef PHYSICS_FEEDBACK_H
#define PHYSICS_FEEDBACK_H

#include "physics/system/work.h"

/* One running load or servo, which moves one wall along one coordinate. */
typedef struct feedback {
  size_t motion;      /* index of the motion in the model */
  uint32_t slot;      /* slot of the wall */
  int coordinate;     /* SD_X or SD_Y */
  double *at, *speed; /* position and velocity of the wall, in the state */
  /* force by contacts, and pose without running motions, in the state */
  const double *force, *base;
  const int32_t *image;       /* image count of the wall along the coordinate, in the state */
  double moved, force_before; /* displacement in the last step, and the force before it */
} feedback;

/* All running loads and servos. */
typedef struct feedbacks {
  size_t count;
  feedback *item; /* room for all loads and servos of the model */
  /* Weight of the latest force in the exponential average that servos use: 1 - exp(-dt/period). */
  double smoothing;
} feedbacks;

/* Allocates the list, which is empty until feedback_list is called. */
void feedback_new(const engine *e, feedbacks *all);
void feedback_free(feedbacks *all);
/* Lists the running loads and servos, from the state. */
void feedback_list(engine *e, feedbacks *all);

/* Begins motion k, which was switched on: its wall starts at rest from its present position. */
void feedback_begin(engine *e, size_t k);
/* Ends motion k, which was switched off: its wall stays at its present position. */
void feedback_end(engine *e, size_t k);

/* Moves the walls to their poses at step state->step + 1, with predicted velocities. mine: its
 * `stale` may be set, and it gets events for walls that must be wrapped. */
void feedback_pose(engine *e, feedbacks *all, thread_work *mine);
/* True if the next step of the walls would make the neighbour list stale. The state is not
 * changed. */
bool feedback_outruns(const engine *e, const feedbacks *all);
/* Corrects the velocities of loads, with the forces after the step. Returns the sum over all walls
 * of (force before + force after) times displacement, twice the work done on them by contacts. */
double feedback_correct(engine *e, feedbacks *all);

#endif
