/* simulation_private.h: parts of a simulation, for what advances several of them together, for simulation_*.c, and for tests. */
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

/* The door of a simulation. Every function of slipdisk/simulation.h comes through here: while a call
 * is under way other threads are refused, and its own callbacks may do what does not pull the ground
 * from under it. */

/* A call needs the state, or that it is alone. */
typedef enum simulation_need {
  NEED_STATE, /* the state between two steps: free ones, and observers */
  NEED_CHANGE /* that no call is under way */
} simulation_need;

typedef struct simulation_door {
  atomic_uintptr_t holder; /* the thread in a call, 0: none; + DOOMED: it was freed meanwhile */
  atomic_int readers;      /* threads that read a number this moment */
  bool observed;           /* an observer is being called */
  bool broken; /* a process that was forked in a force field has no threads to end the step */
} simulation_door;

/* True: the call may go on, and simulation_leave ends it with *outer. False: refused, which `messages` (may be NULL) say of the
 * function `call`. */
bool simulation_enter(sd_simulation *simulation, simulation_need need, const char *call,
                      bool *outer, sd_messages *messages);
/* May free the simulation. */
void simulation_leave(sd_simulation *simulation, bool outer);

/* For numbers, which callbacks may read, too. False: another thread is in a call. */
bool simulation_read_begin(const sd_simulation *simulation);
void simulation_read_end(const sd_simulation *simulation);

/* Which step a simulation takes; both give the same bits. */
typedef enum simulation_step {
  SIMULATION_SUITABLE, /* that of small systems where it suits the model, else the general one */
  SIMULATION_GENERAL   /* the general one, for tests that compare the two */
} simulation_step;

typedef struct simulation_observer {
  int64_t every; /* steps */
  sd_observer *call;
  void *user;
} simulation_observer;

struct sd_simulation {
  engine engine;
  simulation_door door;
  sd_model *owned; /* model of its own; NULL: the caller's */
  ranks *ranks;    /* that share its steps; NULL: this process alone */
  size_t n_observers;
  simulation_observer *observers;
};

/* sd_simulation_new and sd_simulation_resume with a choice. threads: of the general step; that of
 * small systems has one. c: its ranks share the steps of the general step; all call, each with its
 * part of the model (ranks_load); state and order: as ranks_spread
 * takes them over; NULL: alone, order is NULL. stop: see ranks_new. */
sd_status simulation_new(const sd_model *model, int threads, simulation_step step, const comm *c,
                         volatile sig_atomic_t *stop, sd_simulation **out, sd_messages *messages);
sd_status simulation_resume(const sd_model *model, sd_state *state, uint32_t *order, int threads,
                            simulation_step step, const comm *c, volatile sig_atomic_t *stop,
                            sd_simulation **out, sd_messages *messages);
/* sd_simulation_free while no call is under way. */
void simulation_free(sd_simulation *simulation);
/* Brings the state of each rank up to date, all of it or for rows of results: then sums of losses
 * of bodies are older. Collective. SD_ERROR_IO: no memory. */
sd_status simulation_store(sd_simulation *simulation, bool rows, sd_messages *messages);
/* sd_simulation_state and sd_simulation_finished within a call. */
const sd_state *simulation_state(sd_simulation *simulation);
bool simulation_finished(const sd_simulation *simulation);
/* Other ranks have disks of it, too. */
bool simulation_is_spread(const sd_simulation *simulation);
/* How near its disks are to rest, also of a spread one. */
settle_measure simulation_rest(sd_simulation *simulation);
/* The engine of this rank. */
engine *simulation_engine(sd_simulation *simulation);
const slot_table *simulation_slots(const sd_simulation *simulation);
bool simulation_is_small(const sd_simulation *simulation); /* takes the step of small systems */

/* --- simulation_extend.c ----------------------------------------------------------------------------- */
/* Steps until an observer is due, `most` at most. */
int64_t observers_room(const sd_simulation *simulation, int64_t most);
/* Calls those that are due now. */
sd_status observers_call(sd_simulation *simulation, sd_messages *messages);

/* --- Storing and cloning ------------------------------------------------------------------------- */
/* The model of the deck that a checkpoint or a result holds. c: of ranks that share it
 * (ranks_load), and the deck is that of rank 0; NULL: of one process. */
sd_status simulation_model_of(const comm *c, const provenance *origin, sd_model **out,
                              sd_messages *messages);

/* Below this many free disks a thread costs more than it does. */
enum { SIMULATION_DISKS_PER_THREAD = 1000 };
/* Threads that are worth while for this model, 1 ... most. */
int simulation_threads_for(const sd_model *model, int most);

#endif
