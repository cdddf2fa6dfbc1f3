/* ranks_contacts.h: contacts that come along with a large file (model/tiles.h). */
#ifndef SLIPDISK_RUN_RANKS_CONTACTS_H
#define SLIPDISK_RUN_RANKS_CONTACTS_H

#include "base/comm.h"
#include "model/model.h"
#include "slipdisk/state.h"

/* Collective: each rank reads as many of the contacts in the file of model->tiles into its state,
 * wherever their disks are. SD_ERROR_IO, on any rank: it cannot be read, or has changed. Without
 * memory the job ends. */
sd_status ranks_contacts_read(const comm *c, const sd_model *model, sd_state *state, sd_messages *messages);

#endif
