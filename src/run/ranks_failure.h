/* ranks_failure.h: what ranks say when one of them cannot go on. */
#ifndef RUN_RANKS_FAILURE_H
#define RUN_RANKS_FAILURE_H

#include "base/comm.h"

/* Collective, with a status on which all ranks agree. Rank 0 (the others: messages NULL) gets the
 * warnings of its own list, which every rank has alike, and after a failure the errors of all
 * ranks, equal ones once. The list is empty then. Returns the status. */
sd_status ranks_tell(const comm *c, sd_status status, sd_messages *own, sd_messages *messages);

#endif
