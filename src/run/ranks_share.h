/* ranks_share.h: what a rank writes of a checkpoint; see ranks.h. */
#ifndef SLIPDISK_RUN_RANKS_SHARE_H
#define SLIPDISK_RUN_RANKS_SHARE_H

#include "base/comm.h"
#include "io/results/record_share.h"
#include "io/results/summary.h"
#include "physics/system/work.h"

/* The share at `path` of a checkpoint, contacts and motions stored. sum: of its seal. */
sd_status ranks_write_share(const engine *part, const char *path, int64_t *sum, sd_messages *messages);
/* Adds frame `frame` and contacts of moment `moment_number` of the next part, as `what` says, to the rows of this rank. */
sd_status ranks_sample_share(const engine *part, unsigned what, int64_t frame, int64_t moment_number,
                             record_share *rows, sd_messages *messages);
/* Collective: sums of all ranks to `all` of rank 0 (the others: NULL). */
void ranks_gather_sums(const comm *c, int64_t sum, int64_t *all);

/* Collective: closed contacts that each rank counts. */
size_t ranks_count_contacts(const engine *part);
/* Collective: over the disks and contacts of all ranks, without rounding; contacts are stored. Of a
 * rank alone: of its state. */
summary_sums ranks_summary_sums(const engine *part);

#endif
