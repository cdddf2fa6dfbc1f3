/* contacts.h: contact memory between passes: rare events, and the way to and from the state. */
#ifndef PHYSICS_CONTACTS_H
#define PHYSICS_CONTACTS_H

#include "model/advice.h"
#include "physics/system/work.h"

/* After a commit: books what contacts dropped when they opened, hands memory on where a disk passes from
 * one piece of a wall to the next, renews reference directions, brings angles and positions back into
 * range, notes a disk that is too fast. Serial; the order does not depend on the threads. SD_ERROR_NUMERIC: overlap
 * beyond the limit. */
sd_status contacts_events(engine *e, sd_messages *messages);

/* Is there anything for it to do? Lost memory counts. */
static inline bool contacts_any_event(const work *w) {
  for (int t = 0; t < w->n_threads; t++) {
    const event_list *events = &w->threads[t].events, *returns = &w->threads[t].returns;
    if (events->count || returns->count || events->failed || returns->failed || w->threads[t].fast)
      return true;
  }
  return false;
}

/* Collective, between steps: poses of ghosts, and the references of contacts with them that wait for these. SD_ERROR_IO: no
 * memory. */
sd_status contacts_follow(engine *e);

/* Pairs of disks of the lists, before the first step: deepest of those that the run does not begin with as contacts (advice_overlap).
 * SD_ERROR_USER: one overlaps by more than max_overlap. */
sd_status contacts_check_start(const engine *e, first_overlap *deepest, sd_messages *messages);
/* Closed contacts of free disks in these slots (and ghosts) end, in the order that the pairs of the whole have, as those of disks that are out of
 * play do where lists are made. SD_ERROR_IO: no memory. */
sd_status contacts_end(engine *e, const bool *gone);

/* Closed contacts that count here, see halo_counts. */
size_t contacts_count(const engine *e);
/* Closed contacts from the live pairs into the state's columns, and back into empty pairs; what is stored and
 * no candidate is left out. */
sd_status contacts_store(engine *e);
/* The same for what only reads contacts: sums of losses of bodies (energy.h) stay as they were. */
sd_status contacts_store_rows(engine *e);
void contacts_load(engine *e);
/* Contacts that a file brings, before and after the evaluation of step 0. Contacts whose force is
 * carried (SD_FORCE_CARRIED) get the file's record back; sum their forces again then (SWEEP_SUM).
 * The others keep their sliding state and its friction limit; a rolling spring that the file lacks
 * begins relaxed. */
void contacts_recall(engine *e);
void contacts_remember(engine *e);

#endif
