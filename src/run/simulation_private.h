/* simulation_private.h: parts of a simulation, for what advances several of them together, and for tests. */
#ifndef SLIPDISK_RUN_SIMULATION_PRIVATE_H
#define SLIPDISK_RUN_SIMULATION_PRIVATE_H

#include "slipdisk/simulation.h"

typedef struct engine engine; /* physics/system/work.h */

/* Which step a simulation takes; both give the same bits. */
typedef enum simulation_step {
  SIMULATION_SUITABLE, /* that of small systems where it suits the model, else the general one */
  SIMULATION_GENERAL   /* the general one, for tests that compare the two */
} simulation_step;

/* sd_simulation_new and sd_simulation_resume with a choice. threads: of the general step; that of small systems has one. */
sd_status simulation_new(const sd_model *model, int threads, simulation_step step, sd_simulation **out,
                         sd_messages *messages);
sd_status simulation_resume(const sd_model *model, sd_state *state, int threads, simulation_step step,
                            sd_simulation **out, sd_messages *messages);
engine *simulation_engine(sd_simulation *simulation);
bool simulation_is_small(const sd_simulation *simulation); /* takes the step of small systems */
/* Steps until something is looked at or done between steps. Not for a finished simulation. */
int64_t simulation_room(const engine *e);
/* After steps since `from`, simulation_room at most: what is due is done, and the next phase begins. */
sd_status simulation_pause(engine *e, int64_t from, sd_messages *messages);

/* Below this many free disks a thread costs more than it does. */
enum { SIMULATION_DISKS_PER_THREAD = 1000 };
/* Threads that are worth while for this model, 1 ... most. */
int simulation_threads_for(const sd_model *model, int most);

#endif
