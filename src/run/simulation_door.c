/* simulation_door.c: see simulation_door.h. */
#include "run/simulation_door.h"

#include <sched.h>

#include "physics/system/fields.h"
#include "run/simulation_private.h"

enum { DOOMED = 1 };

/* Its address stands for this thread. */
static _Thread_local int thread_mark;
static uintptr_t me(void) { return (uintptr_t)&thread_mark; }

static simulation_door *door_of(const sd_simulation *sim) {
  return &((sd_simulation *)(uintptr_t)sim)->door; /* reading a number does not change the system */
}

static bool in_force(const sd_simulation *sim) { return sim->engine.fields && sim->engine.fields->calling; }

static bool refuse(const char *call, const char *why, sd_messages *messages) {
  sd_fail(messages, SD_ERROR_USER, "%s: %s", call, why);
  return false;
}

bool simulation_enter(sd_simulation *sim, simulation_need need, const char *call, bool *outer,
                      sd_messages *messages) {
  simulation_door *d = &sim->door;
  uintptr_t holder = 0;
  *outer = atomic_compare_exchange_strong(&d->holder, &holder, me());
  if (!*outer && (holder & ~(uintptr_t)DOOMED) != me())
    return refuse(call, "another thread is in a call of this simulation", messages);
  while (*outer && atomic_load(&d->readers) > 0) sched_yield();
  const char *why = in_force(sim)                        ? "not within a force field: its step is being made"
                    : d->observed && need == NEED_CHANGE ? "not within an observer, which only reads"
                    : d->broken ? "the process was forked within a force field: its step was not ended"
                                : NULL;
  if (!why) return true;
  simulation_leave(sim, *outer);
  return refuse(call, why, messages);
}

void simulation_leave(sd_simulation *sim, bool outer) {
  if (outer && atomic_exchange(&sim->door.holder, 0) & DOOMED) simulation_free(sim);
}

void sd_simulation_free(sd_simulation *sim) {
  if (sim && (atomic_fetch_or(&sim->door.holder, DOOMED) & ~(uintptr_t)DOOMED) == 0) simulation_free(sim);
}

bool simulation_read_begin(const sd_simulation *sim) {
  simulation_door *d = door_of(sim);
  atomic_fetch_add(&d->readers, 1);
  const uintptr_t holder = atomic_load(&d->holder) & ~(uintptr_t)DOOMED;
  if (holder == 0 || holder == me()) return true;
  atomic_fetch_sub(&d->readers, 1);
  return false;
}

void simulation_read_end(const sd_simulation *sim) { atomic_fetch_sub(&door_of(sim)->readers, 1); }
