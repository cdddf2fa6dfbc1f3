/* simulation_door.h: who may enter a simulation. Every function of slipdisk/simulation.h comes through here: while a call is
 * under way other threads are refused, and its own callbacks may do what does not pull the ground from under it.
 */
#ifndef SLIPDISK_RUN_SIMULATION_DOOR_H
#define SLIPDISK_RUN_SIMULATION_DOOR_H

#include <stdatomic.h>
#include <stdbool.h>
#include <stdint.h>

#include "slipdisk/simulation.h"

/* What a call needs, and who may have it: */
typedef enum simulation_need {
  NEED_STATE, /* the state between two steps: free ones, and observers */
  NEED_CHANGE /* that no call is under way */
} simulation_need;

typedef struct simulation_door {
  atomic_uintptr_t holder; /* the thread in a call, 0: none; + DOOMED: it was freed meanwhile */
  atomic_int readers;      /* threads that read a number this moment */
  bool observed;           /* an observer is being called */
  bool broken;             /* a process that was forked in a force field has no threads to end the step */
} simulation_door;

/* True: the call may go on, and simulation_leave ends it with *outer. False: refused, which `messages` (may be NULL) say of the
 * function `call`. */
bool simulation_enter(sd_simulation *simulation, simulation_need need, const char *call, bool *outer,
                      sd_messages *messages);
/* May free the simulation. */
void simulation_leave(sd_simulation *simulation, bool outer);

/* For numbers, which callbacks may read, too. False: another thread is in a call. */
bool simulation_read_begin(const sd_simulation *simulation);
void simulation_read_end(const sd_simulation *simulation);

#endif
