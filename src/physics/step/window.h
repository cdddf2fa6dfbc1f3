/* window.h: several steps of a large system at once (a window), chunk by chunk while a chunk is in
 * the cache, with the same bits as one step after the other. */
#ifndef PHYSICS_WINDOW_H
#define PHYSICS_WINDOW_H

#include "base/team.h"
#include "physics/system/work.h"

/* Returns how many of the next `most` steps can be taken as a window; 1: none, call step_once.
 * Every thread of the team calls it and gets the same number, that of the first thread's `most`.
 * To be called after step_begin. */
int64_t window_steps(engine *e, const team *t, int64_t most);
/* Takes n > 1 steps, as many as window_steps has returned; every thread of the team calls it.
 * Returns false if something came up that only single steps can handle; nothing has changed then,
 * and window_steps returns 1 for the next n steps. */
bool window_run(engine *e, const team *t, int64_t n);
void window_free(window *v);

#endif
