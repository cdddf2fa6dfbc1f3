/* loop.h: the loop over steps and the work between steps for one engine, which holds a whole
 * system or the domain of one of several ranks. Functions that return a status are collective,
 * except loop_build and loop_rebuild: all ranks call them with the same arguments and get the
 * same status. */
#ifndef RUN_LOOP_H
#define RUN_LOOP_H

#include "physics/system/work.h"

/* Returns true if the last phase is over. */
bool loop_finished(const engine *e);
/* loop_build builds the work of the engine, and the rows of the lanes if it takes the step of small
 * systems (small), which has one thread. loop_rebuild frees and builds both again after a change of
 * the bodies or of the kind of step; contacts and motions must be stored in the state. Both act on
 * the engine of one rank. */
sd_status loop_build(engine *e, bool small, int threads, sd_messages *messages);
sd_status loop_rebuild(engine *e, bool small, sd_messages *messages);
/* Frees the work of the engine and its lanes. */
void loop_release(engine *e);
/* Begins the phase state->phase: prepares the relaxer and the box, switches motions on and off. */
void loop_begin_phase(engine *e);
/* Does what is done once at step 0, after the first phase has begun: releases rain that is due,
 * computes forces and energies, begins to measure. */
sd_status loop_start(engine *e, sd_messages *messages);
/* Returns the number of steps until the next check or action between steps, at least 1. The run
 * must not be finished. */
int64_t loop_room(const engine *e);
/* Does what is due after steps taken since step `from` (at most loop_room of them), and begins the
 * next phase if this one is over. */
sd_status loop_pause(engine *e, int64_t from, sd_messages *messages);
/* Takes up to n <= loop_room steps and calls loop_pause. state->step tells how many steps were
 * taken: fewer than n after a failure or a stop. */
sd_status loop_advance(engine *e, int64_t n, sd_messages *messages);

#endif
