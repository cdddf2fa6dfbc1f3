/* loop.h: the loop of steps, and what is done between them, of one engine: a whole system, or the
 * part of one rank of several. Functions that return a status are collective but for loop_build
 * and loop_rebuild: all ranks call alike, and get the same. */
#ifndef RUN_LOOP_H
#define RUN_LOOP_H

#include "physics/system/work.h"

/* The last phase is over. */
bool loop_finished(const engine *e);
/* Work, and the rows of a small system, whose step has one thread; and both made anew, after
 * bodies or the kind of the step have changed: contacts and motions stand in the state. Of a rank
 * alone. */
sd_status loop_build(engine *e, bool small, int threads, sd_messages *messages);
sd_status loop_rebuild(engine *e, bool small, sd_messages *messages);
void loop_release(engine *e);
/* state->phase is new: motions are switched. */
void loop_begin_phase(engine *e);
/* Step 0, once the first phase has begun. */
sd_status loop_start(engine *e, sd_messages *messages);
/* Steps until something is looked at or done between steps. Not when it is finished. */
int64_t loop_room(const engine *e);
/* After steps since `from`, loop_room at most: what is due is done, and the next phase begins. */
sd_status loop_pause(engine *e, int64_t from, sd_messages *messages);
/* n steps at most, no more than loop_room, and the pause. state->step tells how many; fewer after
 * a failure or a stop. */
sd_status loop_advance(engine *e, int64_t n, sd_messages *messages);

#endif
