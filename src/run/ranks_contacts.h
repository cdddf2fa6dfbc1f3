/* ranks_contacts.h: contacts that come along with a large file (model/tiles.h), to the ranks that have their disks. */
#ifndef SLIPDISK_RUN_RANKS_CONTACTS_H
#define SLIPDISK_RUN_RANKS_CONTACTS_H

#include "base/comm.h"
#include "model/model.h"
#include "slipdisk/state.h"

/* Collective: gives the parts of all ranks, which have their disks and no contacts yet, those of the file of model->tiles. SD_ERROR_IO, on
 * any rank: it cannot be read, or has changed. Without memory the job ends. */
sd_status ranks_contacts_take(const comm *c, const sd_model *model, sd_state *part, sd_messages *messages);

#endif
