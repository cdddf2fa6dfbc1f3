/* simulation_private.h: internals of a simulation, for simulation_*.c, for code that advances
 * several simulations together, and for tests. */
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

/* Kind of access that a function of slipdisk/simulation.h needs. Each call of such a function takes
 * the lock of the simulation (simulation_lock). While it is taken, calls by other threads are
 * refused, and callbacks of the running call may call only functions that do not disturb it. */
typedef enum simulation_need {
  /* reads the state between two steps: allowed if no call is running, and in observers */
  NEED_STATE,
  NEED_CHANGE /* changes the simulation: allowed only if no call is running */
} simulation_need;

/* Lock of a simulation against calls by several threads, and by callbacks. */
typedef struct simulation_lock {
  /* number that identifies the thread whose call is running, 0: none; plus DOOMED if the simulation
   * was freed during the call */
  atomic_uintptr_t holder;
  /* number of threads that are reading a single value (simulation_read_begin) */
  atomic_int readers;
  bool observed; /* true while an observer is being called */
  /* true: the process was forked while a force function was called, and the step can never end,
   * because the child process lacks the other threads */
  bool broken;
} simulation_lock;

/* Begins a call of a public function. Returns true if the call is allowed; end it by
 * simulation_leave with *outer. Returns false if it is refused, after an error message that names
 * the function `call` (messages may be NULL). */
bool simulation_enter(sd_simulation *simulation, simulation_need need, const char *call,
                      bool *outer, sd_messages *messages);
/* Ends a call of a public function; frees the simulation if a callback has asked for that during
 * the call. */
void simulation_leave(sd_simulation *simulation, bool outer);

/* simulation_read_begin and simulation_read_end enclose the reading of a single value; callbacks
 * may do so, too. simulation_read_begin returns false if another thread's call is running. */
bool simulation_read_begin(const sd_simulation *simulation);
void simulation_read_end(const sd_simulation *simulation);

/* Kind of step that a simulation takes; both kinds give the same bits. */
typedef enum simulation_step {
  /* the step for small systems if it can handle the model, else the general step */
  SIMULATION_SUITABLE,
  SIMULATION_GENERAL /* the general step in any case, for tests that compare the two */
} simulation_step;

typedef struct simulation_observer {
  int64_t every; /* number of steps between two calls of the observer */
  sd_observer *call;
  void *user;
} simulation_observer;

struct sd_simulation {
  engine engine;
  simulation_lock door;
  sd_model *owned; /* model that the simulation frees; NULL: the caller owns the model */
  ranks *ranks;    /* ranks that share the simulation; NULL: one process */
  size_t n_observers;
  simulation_observer *observers;
};

/* Same as sd_simulation_new and sd_simulation_resume, with more choices. threads: number of threads
 * of the general step; the step for small systems has one. c: ranks that share the simulation; each
 * calls this function with its own part of the model (ranks_load); state and order are taken over
 * as by ranks_spread. c NULL: one process; then order is NULL. stop: as for ranks_new. */
sd_status simulation_new(const sd_model *model, int threads, simulation_step step, const comm *c,
                         volatile sig_atomic_t *stop, sd_simulation **out, sd_messages *messages);
sd_status simulation_resume(const sd_model *model, sd_state *state, uint32_t *order, int threads,
                            simulation_step step, const comm *c, volatile sig_atomic_t *stop,
                            sd_simulation **out, sd_messages *messages);
/* Frees a simulation; no call of a public function may be running. */
void simulation_free(sd_simulation *simulation);
/* Collective: stores the data that the engine has in its own arrays in the state of each rank.
 * rows: only the part needed to write rows of results; sums of the losses of bodies are then not
 * updated. SD_ERROR_IO: out of memory. */
sd_status simulation_store(sd_simulation *simulation, bool rows, sd_messages *messages);
/* Same as sd_simulation_state and sd_simulation_finished, but do not take the lock, for use within
 * a call. */
const sd_state *simulation_state(sd_simulation *simulation);
bool simulation_finished(const sd_simulation *simulation);
/* Returns true if the disks are distributed over several ranks. */
bool simulation_is_spread(const sd_simulation *simulation);
/* Collective: measures how near to rest the disks are. */
settle_measure simulation_rest(sd_simulation *simulation);
/* Returns the engine of this rank. */
engine *simulation_engine(sd_simulation *simulation);
const slot_table *simulation_slots(const sd_simulation *simulation);
/* Returns true if the simulation uses the step for small systems. */
bool simulation_is_small(const sd_simulation *simulation);

/* --- Changes between steps -------------------------------------------------------------------- */

/* Stores contacts and motions in the state, which then has all data from which lists and buffers
 * can be rebuilt. */
sd_status simulation_store_all(sd_simulation *simulation, sd_messages *messages);
/* Returns a copy of the model without the contacts and time derivatives with which the run began:
 * they were needed only at step 0. NULL: no memory. */
sd_model *simulation_model_copy(const sd_model *model, sd_messages *messages);
/* Makes *now, a shallow copy of `model` with disks of its own, which the caller frees. They are at
 * their present positions, NAN if they are not in play; new ones, which the engine does not have
 * yet, where the model places them. */
sd_status simulation_present(const engine *e, const sd_model *model, sd_model *now,
                             sd_messages *messages);
/* Refuses overlaps beyond max_overlap, and equal centres, of disks with fresh[number], fresh:
 * [n_disks], with any body. now: made by simulation_present. */
sd_status simulation_check_overlaps(const engine *e, const sd_model *now, const bool *fresh,
                                    sd_messages *messages);

/* --- Observers -------------------------------------------------------------------------------- */
/* Returns the number of steps until the next call of an observer, at most `most`. */
int64_t observers_steps_left(const sd_simulation *simulation, int64_t most);
/* Calls the observers that are due at this step. Returns the first status that is not SD_OK. */
sd_status observers_call(sd_simulation *simulation, sd_messages *messages);

/* --- Storing and cloning ---------------------------------------------------------------------- */
/* Loads the model from the deck that is stored in a checkpoint or result. c: ranks that share the
 * model, each with some of the disks (ranks_load); the deck of rank 0 counts; NULL: one process. */
sd_status simulation_model_of(const comm *c, const provenance *origin, sd_model **out,
                              sd_messages *messages);

/* Number of free disks per thread below which one more thread makes a run slower. */
enum { SIMULATION_DISKS_PER_THREAD = 1000 };
/* Returns the number of threads for which a run of this model is fastest, 1 ... most. */
int simulation_threads_for(const sd_model *model, int most);

#endif
