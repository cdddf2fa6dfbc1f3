/* window.h: several steps of a large system at once (a window), chunk by chunk while a chunk is in
 * the cache, with the same bits as one step after the other. */
#ifndef PHYSICS_WINDOW_H
#define PHYSICS_WINDOW_H

#include "physics/system/work.h"

/* Returns how many of the next `most` steps can be taken as a window; 1: none, call step_once.
 * Called by one thread, after step_begin. */
int64_t window_steps(engine *e, int64_t most);
/* Takes n > 1 steps, as many as window_steps has returned. Returns false if something came up that
 * only single steps can handle; nothing has changed then, and window_steps returns 1 for the next
 * n steps. */
bool window_run(engine *e, int64_t n);
void window_free(window *v);

#endif
