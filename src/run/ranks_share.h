/* ranks_share.h: what a rank writes of a checkpoint; see ranks.h. */
#ifndef SLIPDISK_RUN_RANKS_SHARE_H
#define SLIPDISK_RUN_RANKS_SHARE_H

#include <stdbool.h>

#include "base/comm.h"
#include "io/results/record.h"
#include "io/results/summary.h"
#include "model/state.h"
#include "physics/system/work.h"
#include "run/route.h"

/* The share at `path` of a checkpoint, contacts and motions stored. sum: of its seal. */
sd_status ranks_write_share(const engine *part, const char *path, int64_t *sum,
                            sd_messages *messages);
/* Adds frame `frame` and contacts of moment `moment_number` of the next part, as `what` says, to the rows of this rank. */
sd_status ranks_sample_share(const engine *part, unsigned what, int64_t frame,
                             int64_t moment_number, record *rows, sd_messages *messages);
/* Collective: sums of all ranks to `all` of rank 0 (the others: NULL). */
void ranks_gather_sums(const comm *c, int64_t sum, int64_t *all);

/* Collective: closed contacts that each rank counts. */
size_t ranks_count_contacts(const engine *part);
/* Collective: over the disks and contacts of all ranks, without rounding; contacts are stored. Of a
 * rank alone: of its state. */
summary_sums ranks_summary_sums(const engine *part);

/* --- columns of a state that go from rank to rank --------------------------------------------- */

enum { MOVING_MOST = 256, MOVING_NARROW = 4 };

typedef struct moving {
  route *route;
  const sd_state *from;
  sd_state *to;
  /* one rank may have all rows, and `to` is new: a few columns at a time, and none that is zero on
   * all ranks; the same on all ranks */
  bool narrow;
  size_t n;
  const sd_field *field[MOVING_MOST];
  size_t size[MOVING_MOST]; /* bytes of a row */
} moving;

/* Chooses columns that have a row for each free disk (bodies: for each body), or closed contact of m->to. */
void moving_disks(moving *m, const sd_model *model, bool bodies);
void moving_contacts(moving *m);
/* Collective: as route_columns. */
sd_status moving_send(const moving *m, const uint32_t *place);

/* Rows of prescribed bodies, motions, the run: every rank has them. */
void common_take(const sd_state *from, sd_state *to);

#endif
