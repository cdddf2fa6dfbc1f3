/* simulation_private.h: parts of a simulation, for simulation_*.c, for code that advances several
 * simulations together, and for tests. */
#ifndef SLIPDISK_RUN_SIMULATION_PRIVATE_H
#define SLIPDISK_RUN_SIMULATION_PRIVATE_H

#include <stdatomic.h>
#include <stdbool.h>
#include <stdint.h>

#include "io/deck/deck.h"
#include "io/results/provenance.h"
#include "pack/settle.h"
#include "physics/system/work.h"
#include "run/ranks.h"
#include "slipdisk/simulation.h"

/* --- The lock of a simulation ----------------------------------------------------------------- */

/* Access that a call of slipdisk/simulation.h needs. Each call takes the lock of the simulation
 * (simulation_door): meanwhile, calls by other threads are refused, and its callbacks may only make
 * calls that leave the running call intact. */
typedef enum simulation_need {
  NEED_STATE, /* the state between two steps: allowed if no call is running, and in observers */
  NEED_CHANGE /* changes the simulation: allowed only if no call is running */
} simulation_need;

/* Lock of a simulation. */
typedef struct simulation_door {
  /* identity of the thread in a call, 0: none; plus DOOMED if it was freed in the call */
  atomic_uintptr_t holder;
  atomic_int readers; /* number of threads that are reading a number */
  bool observed;      /* true while an observer is called */
  /* true if the process was forked within a force field: its threads are missing, so the step
   * cannot end */
  bool broken;
} simulation_door;

/* Begins a call. Returns true if the call may go on; end it by simulation_leave with *outer.
 * Returns false if it is refused, with a message (messages may be NULL) that names the function
 * `call`. */
bool simulation_enter(sd_simulation *simulation, simulation_need need, const char *call,
                      bool *outer, sd_messages *messages);
/* Ends a call; frees the simulation if that was asked for during the call. */
void simulation_leave(sd_simulation *simulation, bool outer);

/* Begin and end reading a number, which callbacks may do, too. Returns false if another thread is
 * in a call. */
bool simulation_read_begin(const sd_simulation *simulation);
void simulation_read_end(const sd_simulation *simulation);

/* Kind of step that a simulation takes; both kinds give the same bits. */
typedef enum simulation_step {
  SIMULATION_SUITABLE, /* the step of small systems if it suits the model, else the general step */
  SIMULATION_GENERAL   /* the general step, for tests that compare the two */
} simulation_step;

typedef struct simulation_observer {
  int64_t every; /* number of steps between calls */
  sd_observer *call;
  void *user;
} simulation_observer;

struct sd_simulation {
  engine engine;
  simulation_door door;
  sd_model *owned; /* model owned by the simulation; NULL: the caller owns it */
  ranks *ranks;    /* ranks that share the simulation; NULL: one process */
  size_t n_observers;
  simulation_observer *observers;
};

/* Same as sd_simulation_new and sd_simulation_resume, with more choices. threads: for the general
 * step; the step of small systems has one thread. c: ranks that share the simulation and all call
 * this, each with its part of the model (ranks_load); state and order: taken over as by
 * ranks_spread. c NULL: one process, order is NULL. stop: see ranks_new. */
sd_status simulation_new(const sd_model *model, int threads, simulation_step step, const comm *c,
                         volatile sig_atomic_t *stop, sd_simulation **out, sd_messages *messages);
sd_status simulation_resume(const sd_model *model, sd_state *state, uint32_t *order, int threads,
                            simulation_step step, const comm *c, volatile sig_atomic_t *stop,
                            sd_simulation **out, sd_messages *messages);
/* Frees a simulation; no call of it may be running. */
void simulation_free(sd_simulation *simulation);
/* Collective: brings the state of each rank up to date. rows: only what rows of results need; the
 * sums of losses of bodies are then not updated. SD_ERROR_IO: out of memory. */
sd_status simulation_store(sd_simulation *simulation, bool rows, sd_messages *messages);
/* Same as sd_simulation_state and sd_simulation_finished, for use within a call. */
const sd_state *simulation_state(sd_simulation *simulation);
bool simulation_finished(const sd_simulation *simulation);
/* Returns true if the disks are distributed over several ranks. */
bool simulation_is_spread(const sd_simulation *simulation);
/* Collective: measures how near the disks are to rest. */
settle_measure simulation_rest(sd_simulation *simulation);
/* Returns the engine of this rank. */
engine *simulation_engine(sd_simulation *simulation);
const slot_table *simulation_slots(const sd_simulation *simulation);
/* Returns true if the simulation takes the step of small systems. */
bool simulation_is_small(const sd_simulation *simulation);

/* --- Observers -------------------------------------------------------------------------------- */
/* Returns the number of steps until an observer is due, at most `most`. */
int64_t observers_room(const sd_simulation *simulation, int64_t most);
/* Calls the observers that are due now. Returns the first status that is not SD_OK. */
sd_status observers_call(sd_simulation *simulation, sd_messages *messages);

/* --- Storing and cloning ---------------------------------------------------------------------- */
/* Loads the model from the deck that is stored in a checkpoint or result. c: ranks that share the
 * model (ranks_load), with the deck of rank 0; NULL: one process. */
sd_status simulation_model_of(const comm *c, const provenance *origin, sd_model **out,
                              sd_messages *messages);

/* Number of free disks per thread below which a further thread slows a run down. */
enum { SIMULATION_DISKS_PER_THREAD = 1000 };
/* Returns the number of threads that are worthwhile for this model, 1 ... most. */
int simulation_threads_for(const sd_model *model, int most);

#endif
