/* motion.h: prescribed motions: the coordinates that signals (signals.h) are added to; and the walls whose motion
 * depends on the disks (feedback.h), which are switched and placed here too.
 *
 * Signals do not depend on the dynamics, so they are computed MOTION_BATCH steps ahead, over lanes.
 */
#ifndef PHYSICS_MOTION_H
#define PHYSICS_MOTION_H

#include "physics/motion/signals.h"
#include "physics/system/work.h"

/* A prescribed coordinate: the signals that are added to it, and its values over the batch. */
typedef struct placed {
  uint32_t slot;
  int coordinate;
  size_t first, count;        /* in the list of terms */
  double *at, *speed;         /* in the state */
  const double *force;        /* of the contacts, in the state */
  double last;                /* after the last step: the predictor moves free disks before they are placed */
  double moved, force_before; /* by the last step */
  double low, high;           /* least and largest value of the batch */
  double value[MOTION_BATCH], velocity[MOTION_BATCH];
} placed;

/* Tables for the model's motions; what is running follows from the state. */
sd_status motion_new(engine *e, sd_messages *messages);
void motion_free(engine *e);

/* A phase begins (state->phase): switches motions on and off, freezing what they displaced into the base. */
sd_status motion_begin_phase(engine *e);
/* The lists of running motions, from the state; called after loading a state. */
sd_status motion_resume(engine *e);
/* The state went on by other means while the same motions run: what was computed ahead is forgotten. */
void motion_reload(engine *e);
/* Sets every prescribed coordinate and its velocity to their values at step state->step + 1. */
void motion_place(engine *e, thread_work *mine);
/* Books the work that the placed bodies did in this step: trapezoid of the contact forces, which must be new.
 * Loads get their velocities. */
void motion_work(engine *e);
/* Computes ahead when the batch is used up. True: in this batch no prescribed body can make the lists stale
 * or leave its range, so placing is nothing but copying value[motion_index] and velocity. */
bool motion_ahead(engine *e);
/* Of the next step in the batch. */
int64_t motion_index(const engine *e);
placed *motion_places(engine *e, size_t *n);
/* The motion whose signal is term t of a place. */
size_t motion_term(const engine *e, const placed *p, size_t t);
/* What is taken off the sum of a coordinate's signals (turn or image), and what is added then. */
void motion_offset(const engine *e, uint32_t slot, int coordinate, double *off, double *base);
signals *motion_signals(const engine *e);
/* Turns stay within half of 8 rad, positions within the box. */
bool motion_in_range(const engine *e, int coordinate, double at);
/* The turn or image of a body changed: the values computed ahead follow. */
void motion_came_back(engine *e, uint32_t slot);
/* Brings the oscillators in the state to the step that is completed. */
void motion_store(engine *e);
/* True when some wall has a running motion. */
bool motion_moves_walls(const engine *e);
/* Does a motion that runs prescribe a coordinate of a free disk? */
bool motion_drives_free(const engine *e);
/* Does motion_work change prescribed bodies? */
bool motion_corrects(const engine *e);

#endif
