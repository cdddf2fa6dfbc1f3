/* feedback.h: walls that move as the disks push them: loads and servos (physics.md 6).
 *
 * Their way depends on the dynamics, so nothing is computed ahead: before the forces of a step are evaluated each
 * wall goes to its pose at t + dt with what it knows of the forces at t, which the state holds. The work that it
 * does on the disks is booked as that of prescribed bodies is; its own energy is no part of the budget.
 */
#ifndef PHYSICS_FEEDBACK_H
#define PHYSICS_FEEDBACK_H

#include "physics/system/work.h"

/* One running motion of such a wall. */
typedef struct feedback {
  size_t motion;
  uint32_t slot;
  int coordinate;
  double *at, *speed;         /* in the state */
  const double *force, *base; /* in the state: of the contacts; pose without running motions */
  const int32_t *image;
  double moved, force_before; /* by the last step */
} feedback;

typedef struct feedbacks {
  size_t count;
  feedback *item; /* [motions of these kinds] */
  double
      smoothing; /* share of a step in the force that a servo has measured: 1 - exp(-dt/period) */
} feedbacks;

void feedback_new(const engine *e, feedbacks *all);
void feedback_free(feedbacks *all);
/* The list of those that run, from the state. */
void feedback_list(engine *e, feedbacks *all);

/* Motion k was switched on: its wall begins at rest where it is. */
void feedback_begin(engine *e, size_t k);
/* Motion k was switched off: its wall stays where it is. */
void feedback_end(engine *e, size_t k);

/* Moves the walls to step state->step + 1; velocities are predicted. */
void feedback_pose(engine *e, feedbacks *all, thread_work *mine);
/* Would the walls leave the lists in the next step? Changes nothing. */
bool feedback_outruns(const engine *e, const feedbacks *all);
/* The forces of that step are known: corrects the velocities of loads; returns the sum of (force before + force)
 * times way over all walls. */
double feedback_correct(engine *e, feedbacks *all);

#endif
