/* ranks_order.h: the order that all disks have in the whole, when each rank has some. */
#ifndef SLIPDISK_RUN_RANKS_ORDER_H
#define SLIPDISK_RUN_RANKS_ORDER_H

#include "base/comm.h"
#include "model/model.h"
#include "model/state.h"

/* Collective. Puts the free disks of this rank into the order of order_disks; order[n_free]: their slots in the whole, which ascend. Contacts
 * stay as they are. Places are sorted where they are and sent to ranks that number them, strip by strip; the numbers come back.
 * Without memory the job ends. */
sd_status ranks_order(const comm *c, const sd_model *model, sd_state *part, uint32_t *order);

#endif
