/* ranks_failure.h: what ranks say when one of them cannot go on. */
#ifndef RUN_RANKS_FAILURE_H
#define RUN_RANKS_FAILURE_H

#include "slipdisk/status.h"

/* Collective. Rank 0 gets the messages of all ranks into `messages` (NULL: the others), each once. failed: this rank's status.
 * Returns the status of the first rank that has failed. */
sd_status ranks_tell_failure(sd_status failed, const sd_messages *own, sd_messages *messages);

#endif
