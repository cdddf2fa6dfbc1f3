/* engine.h: creation and destruction of the work of a system (work.h), from model and state. */
#ifndef PHYSICS_ENGINE_H
#define PHYSICS_ENGINE_H

#include "physics/system/work.h"

/* Fills the state of step 0 from the model: poses, slots, and the contacts that a packing brings
 * along. Returns SD_ERROR_IO if memory runs out. */
sd_status engine_fill_state(const sd_model *model, sd_state *state);
/* Fill parts of the state of step 0, for a rank that has only some of the free disks: prescribed
 * bodies and motions; Gear's higher derivatives of the disk in one slot; n contacts. Returns
 * SD_ERROR_IO if memory for contacts runs out. */
void engine_fill_prescribed(const sd_model *model, sd_state *state);
void engine_fill_derivatives(sd_state *state, size_t slot,
                             const double derivatives[SD_DERIVATIVES]);
sd_status engine_fill_contacts(sd_state *state, size_t n, const sd_contact_memory *contacts);
/* Fills the columns of one disk in the given slot; number: its body number. */
void engine_fill_disk(sd_state *state, const sd_disk *disk, uint32_t number, uint32_t slot);
/* Appends a contact; the state must have capacity for it. */
void engine_fill_contact(sd_state *state, const sd_contact_memory *contact);

/* Builds all work of e->model and e->state (both set, the rest zero), including the lists; contacts
 * are loaded from the state. Returns an error status with a message, else SD_OK; engine_free
 * releases the work in either case. */
sd_status engine_build(engine *e, int threads, sd_messages *messages);
void engine_free(engine *e);
/* Refills the table of slots after the disks of the state were reordered. */
void engine_find_slots(engine *e);
/* Returns the Verlet margin of the first lists, a length; neighbours_tune adapts that of later
 * lists. */
double engine_first_skin(const sd_model *model);

/* Evaluates step 0, once the motions of the first phase run: contacts that touch begin (lambda_ref
 * = lambda), those that a packing brings along continue; accelerations follow from the forces, and
 * the initial energy is stored. Contacts of the packing that do not touch are dropped, with a
 * warning. Collective; all ranks get the same status. */
sd_status engine_start(engine *e, sd_messages *messages);

/* Rebuilds the lists between steps, after disks were moved, added or removed. With several ranks
 * each disk is sent to the rank that owns its position. Collective; all ranks get the same
 * status. */
sd_status engine_renew(engine *e, sd_messages *messages);

#endif
