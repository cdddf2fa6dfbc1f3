/* simulation_private.h: the parts of sd_simulation_advance, for those who advance several simulations together. */
#ifndef SLIPDISK_RUN_SIMULATION_PRIVATE_H
#define SLIPDISK_RUN_SIMULATION_PRIVATE_H

#include "physics/system/work.h"
#include "slipdisk/simulation.h"

engine *simulation_engine(sd_simulation *simulation);
/* Steps until something is looked at or done between steps. Not for a finished simulation. */
int64_t simulation_room(const engine *e);
/* After steps since `from`, simulation_room at most: what is due is done, and the next phase begins. */
sd_status simulation_pause(engine *e, int64_t from, sd_messages *messages);

/* Below this many free disks a thread costs more than it does. */
enum { SIMULATION_DISKS_PER_THREAD = 1000 };
/* Threads that are worth while for this model, 1 ... most. */
int simulation_threads_for(const sd_model *model, int most);

#endif
