/* contacts.h: the records of contacts between steps: rare events, and conversion from and to the
 * state. */
#ifndef PHYSICS_CONTACTS_H
#define PHYSICS_CONTACTS_H

#include "model/advice.h"
#include "physics/system/work.h"

/* Handles the rare events of a step: books the energy that contacts dropped when they opened,
 * renews reference directions, wraps angles and positions, notes a disk that is too fast. Runs on
 * one thread; the order does not depend on the number of threads. Returns SD_ERROR_NUMERIC if an
 * overlap is beyond the limit, SD_ERROR_IO if memory runs out. */
sd_status contacts_events(engine *e, sd_messages *messages);

/* Returns true if there are events to handle, or memory for them ran out. */
static inline bool contacts_any_event(const work *w) {
  for (int t = 0; t < w->n_threads; t++) {
    const event_list *events = &w->threads[t].events, *returns = &w->threads[t].returns;
    if (events->count || returns->count || events->failed || returns->failed || w->threads[t].fast)
      return true;
  }
  return false;
}

/* Exchanges the poses of ghosts between steps, then updates the reference values of contacts with
 * ghosts that waited for them. Collective. Returns SD_ERROR_IO if memory runs out. */
sd_status contacts_follow(engine *e);

/* Checks the pairs of disks in the lists before the first step. *deepest: the largest overlap among
 * pairs that are not contacts already at the start (see advice_overlap). Returns SD_ERROR_USER if a
 * pair overlaps by more than max_overlap. */
sd_status contacts_check_start(const engine *e, first_overlap *deepest, sd_messages *messages);
/* Ends the closed contacts of the free disks and ghosts with gone[slot] set, in the order of pairs
 * in the whole system; a rebuild of the lists uses the same order. Returns SD_ERROR_IO if memory
 * runs out. */
sd_status contacts_end(engine *e, const bool *gone);

/* Returns the number of closed contacts that this rank counts (halo_counts). */
size_t contacts_count(const engine *e);
/* contacts_store writes the closed contacts of the pairs to the state's columns, and updates the
 * sums of losses of the bodies; returns SD_ERROR_IO if memory runs out. */
sd_status contacts_store(engine *e);
/* contacts_store_rows does the same without the sums of losses (energy.h), for callers that only
 * read contacts. contacts_load copies stored contacts to the pairs, which must be open; a stored
 * contact that is no candidate is left out. */
sd_status contacts_store_rows(engine *e);
void contacts_load(engine *e);
/* Restore contacts that come from a file: contacts_recall before the evaluation of step 0,
 * contacts_remember after it. Contacts with a carried force (SD_FORCE_CARRIED) get the file's
 * record back; forces must then be summed again (SWEEP_SUM). Others keep whether they slide, which
 * selects the friction limit; a rolling spring that the file does not have begins relaxed. */
void contacts_recall(engine *e);
void contacts_remember(engine *e);

#endif
