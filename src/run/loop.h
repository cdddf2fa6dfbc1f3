/* loop.h: the loop over steps and the work between steps for one engine, which holds a whole
 * system or the domain of one of several ranks. All functions that return a status, except
 * loop_build and loop_rebuild, are collective: every rank must call them with the same
 * arguments, and gets the same status. */
#ifndef RUN_LOOP_H
#define RUN_LOOP_H

#include "physics/system/work.h"

/* Returns true if the last phase is over. */
bool loop_finished(const engine *e);
/* loop_build allocates lists and buffers of the engine; small: true for systems of few bodies in
 * SIMD lanes, which have one thread. loop_rebuild frees and builds them again after a change of the
 * bodies or of `small`; contacts and motions must have been stored in the state before. Neither is
 * collective. */
sd_status loop_build(engine *e, bool small, int threads, sd_messages *messages);
sd_status loop_rebuild(engine *e, bool small, sd_messages *messages);
/* Frees lists, buffers and SIMD lanes of the engine. */
void loop_release(engine *e);
/* Begins the phase number state->phase: prepares relaxation and box, holds and releases disks,
 * switches motions on and off. */
sd_status loop_begin_phase(engine *e, sd_messages *messages);
/* Does the work that comes once, at step 0, after the first phase has begun: releases disks of rain
 * that are due, computes forces and energies, begins to measure. */
sd_status loop_start(engine *e, sd_messages *messages);
/* Returns the number of steps until the next check or action between steps, at least 1. The run
 * must not be finished. */
int64_t loop_steps_left(const engine *e);
/* Does the work between steps that is due after the steps from `from` to the present one (at most
 * loop_steps_left of them), and begins the next phase if this one is over. */
sd_status loop_pause(engine *e, int64_t from, sd_messages *messages);
/* Takes up to n steps, n <= loop_steps_left, and then calls loop_pause. After a failure or a
 * stop fewer than n steps were taken; state->step is the step reached. */
sd_status loop_advance(engine *e, int64_t n, sd_messages *messages);

#endif
