/* engine.h: creates and frees an engine, one system (model and state) with the data that steps need
 * (work.h). */
#ifndef PHYSICS_ENGINE_H
#define PHYSICS_ENGINE_H

#include "model/start.h"
#include "slipdisk/model.h"
#include "physics/system/work.h"

/* Fills the state of step 0 from the model: slots and poses of bodies, and the contacts of the
 * input packing, if any. Returns SD_ERROR_IO if memory runs out. */
sd_status engine_fill_state(const sd_model *model, sd_state *state);
/* Fill parts of the state of step 0, for a rank that has only some of the free disks.
 * engine_fill_prescribed: prescribed bodies and motions; engine_fill_derivatives: higher
 * derivatives of the disk in one slot, for Gear's integrator; engine_fill_contacts: n contacts,
 * returns SD_ERROR_IO if memory runs out. */
void engine_fill_prescribed(const sd_model *model, sd_state *state);
void engine_fill_derivatives(sd_state *state, size_t slot,
                             const double derivatives[SD_DERIVATIVES]);
sd_status engine_fill_contacts(sd_state *state, size_t n, const sd_contact_memory *contacts);
/* Fills the columns of one disk in the given slot. number: number of the body in the model. */
void engine_fill_disk(sd_state *state, const sd_disk *disk, uint32_t number, uint32_t slot);
/* Appends a contact; the state must have capacity for it. */
void engine_fill_contact(sd_state *state, const sd_contact_memory *contact);

/* Builds all members of e->work, including the neighbour lists, from e->model and e->state;
 * contacts are loaded from the state. model and state must be set, all other members zero. Returns
 * an error status with a message if it fails. engine_free frees the work in either case. */
sd_status engine_build(engine *e, int threads, sd_messages *messages);
void engine_free(engine *e);
/* Returns false after engine_free. */
bool engine_is_built(const engine *e);
/* Refills the table of slots by body number, after the disks of the state were reordered. */
void engine_find_slots(engine *e);
/* Returns the Verlet margin (a length) of the first neighbour lists; neighbours_tune adapts it for
 * later lists. */
double engine_first_skin(const sd_model *model);

/* Evaluates step 0, when the motions of the first phase have been started: new contacts begin
 * (lambda_ref = lambda), contacts of the input packing continue or, if they do not touch, are
 * dropped with a warning. Accelerations follow from the forces, and the initial energy is stored.
 * Collective; all ranks get the same status. */
sd_status engine_start(engine *e, sd_messages *messages);

/* Rebuilds the neighbour lists between steps, after disks were moved, added or removed. With
 * several ranks each disk first moves to the rank whose domain it is in. Collective; all ranks get
 * the same status. */
sd_status engine_renew(engine *e, sd_messages *messages);
/* Take the constants of contact laws, and of motions, anew from the model, after they were changed
 * between two steps. engine_renew_laws returns false, without a change that matters, if lists or
 * columns depend on the change: build all anew then. */
bool engine_renew_laws(engine *e);
sd_status engine_renew_motions(engine *e, sd_messages *messages);

#endif
