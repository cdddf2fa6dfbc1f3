/* contacts.h: contacts between steps: rare events (contacts that begin or end, angles and positions
 * that must be wrapped), and the copy of contact records to and from the state. */
#ifndef PHYSICS_CONTACTS_H
#define PHYSICS_CONTACTS_H

#include "model/advice.h"
#include "physics/system/work.h"

/* Handles the rare events of a step: adds the energy lost in contacts that opened to the energy
 * balance, renews reference directions of contacts, wraps angles and positions, and notes the
 * fastest disk if one exceeds the displacement limit. Runs on one thread, in an order that does not
 * depend on the number of threads. Returns SD_ERROR_NUMERIC if an overlap is beyond the limit,
 * SD_ERROR_IO if memory runs out. */
sd_status contacts_events(engine *e, sd_messages *messages);

/* Parts of contacts_events, for windows (window.h). contacts_sort_events sorts the events that one
 * thread has noted. contacts_pair_event handles the event of a
 * contact, with statuses as those of contacts_events. contacts_wrap wraps the angle of body i into
 * [-4, 4] and its position into the box, and adjusts lambda_ref of its contacts so that their
 * tangential displacements do not change; i: slot, or number of bodies + k for clump k. */
void contacts_sort_events(const engine *e, thread_work *mine);
sd_status contacts_pair_event(engine *e, const event *v, sd_messages *messages);
void contacts_wrap(engine *e, uint32_t i);

/* Returns true if there are rare events to handle, or if memory for some of them ran out. */
static inline bool contacts_any_event(const work *w) {
  for (int t = 0; t < w->n_threads; t++) {
    const event_list *events = &w->threads[t].events, *returns = &w->threads[t].returns;
    if (events->count || returns->count || events->failed || returns->failed || w->threads[t].fast)
      return true;
  }
  return false;
}

/* Updates the poses of ghosts between steps, then the reference values of contacts with ghosts,
 * whose change had to wait for these poses. Collective. Returns SD_ERROR_IO if memory runs out. */
sd_status contacts_update_ghosts(engine *e);

/* Checks pairs of disks before the first step. *deepest: the largest overlap (relative to the
 * smaller radius) among pairs that are not contacts of the input packing; it is used for advice to
 * the user (advice_overlap). Returns SD_ERROR_USER with a message if a pair overlaps by more than
 * max_overlap. */
sd_status contacts_check_start(const engine *e, first_overlap *deepest, sd_messages *messages);
/* Ends the closed contacts of all free disks and ghosts for which gone[slot] is true, in the order
 * of the pairs' global slots; a rebuild of the lists ends contacts in the same order. Returns
 * SD_ERROR_IO if memory runs out. */
sd_status contacts_end(engine *e, const bool *gone);

/* Returns the number of closed contacts that this rank counts; a contact across two ranks is
 * counted by one of them (halo_counts). */
size_t contacts_count(const engine *e);
/* Copies the records of closed contacts to the state's columns, and updates the sums of energy
 * losses of the bodies in the state. Returns SD_ERROR_IO if memory runs out. */
sd_status contacts_store(engine *e);
/* contacts_store_rows copies only the records, without the sums of losses (energy.h), for callers
 * that only read contacts. contacts_load copies the stored contacts back to the pairs, all of which
 * must be open; a stored contact whose bodies are too far apart to be a candidate is left out. */
sd_status contacts_store_rows(engine *e);
void contacts_load(engine *e);
/* Restore contacts that come from a file: call contacts_restore_before before contacts are
 * evaluated for step 0, contacts_restore_after after it. A contact whose force is to be taken
 * from the file (SD_FORCE_CARRIED) gets the file's record back; forces must then be summed again
 * (CHUNKS_SUM). Any other contact keeps only whether it slides, which selects the static or
 * kinetic friction limit. If the file has no rolling spring for a contact, the spring begins
 * without deformation. */
void contacts_restore_before(engine *e);
void contacts_restore_after(engine *e);

#endif
