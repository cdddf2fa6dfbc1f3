/* engine.h: building the work of a system from model and state, and throwing it away. */
#ifndef PHYSICS_ENGINE_H
#define PHYSICS_ENGINE_H

#include "physics/system/work.h"

/* Fills the state of step 0 from the model: poses, slots, and the contacts that the packing brings along.
 * SD_ERROR_IO: no memory for these. */
sd_status engine_fill_state(const sd_model *model, sd_state *state);
/* Parts of it, for a rank whose state has some of the free disks only: prescribed bodies and
 * motions; Gear's derivatives of a slot; contacts. SD_ERROR_IO: no memory. */
void engine_fill_prescribed(const sd_model *model, sd_state *state);
void engine_fill_derivatives(sd_state *state, size_t slot,
                             const double derivatives[SD_DERIVATIVES]);
sd_status engine_fill_contacts(sd_state *state, size_t n, const sd_contact_memory *contacts);
/* The columns of one disk, in its slot. */
void engine_fill_disk(sd_state *state, const sd_disk *disk, uint32_t number, uint32_t slot);
/* The next contact; there is room for it. */
void engine_fill_contact(sd_state *state, const sd_contact_memory *contact);

/* Work for e->model and e->state (both set, the rest zero), up to the lists; contacts come from the state. */
sd_status engine_build(engine *e, int threads, sd_messages *messages);
void engine_free(engine *e);
/* Where the disks of the state stand, when it has them in another order. */
void engine_find_slots(engine *e);
/* Skin of the first lists, by which they reach further than contacts; later ones:
 * neighbours_tune. */
double engine_first_skin(const sd_model *model);

/* At step 0, once the first phase's motions run: contacts that are closed at the start begin
 * (lambda* = lambda) or, where the packing brings them along, go on; accelerations follow from
 * the forces, and the energy is noted. Contacts of the packing that do not touch are dropped,
 * with a warning. Collective; all ranks get the same status. */
sd_status engine_start(engine *e, sd_messages *messages);

/* New lists between steps, after disks were put elsewhere, have set out or are gone. Where ranks
 * share them each disk goes to its rank. Collective; all ranks get the same status. */
sd_status engine_renew(engine *e, sd_messages *messages);

#endif
