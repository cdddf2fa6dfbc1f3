/* ranks_share.h: writes a rank's share of checkpoints and results, and sums over ranks; see
 * ranks.h. */
#ifndef SLIPDISK_RUN_RANKS_SHARE_H
#define SLIPDISK_RUN_RANKS_SHARE_H

#include <stdbool.h>

#include "base/comm.h"
#include "io/results/record.h"
#include "io/results/summary.h"
#include "model/state.h"
#include "physics/system/work.h"
#include "run/route.h"

/* Writes this rank's share of a checkpoint to `path`; contacts and motions must be stored. sum:
 * receives the checksum in its seal. */
sd_status ranks_write_share(const engine *part, const char *path, int64_t *sum,
                            sd_messages *messages);
/* Adds to `rows` this rank's disks in frame number `frame` and its contacts in contact table number
 * `moment_number` of the next part, as the bits of `what` say. */
sd_status ranks_sample_share(const engine *part, unsigned what, int64_t frame,
                             int64_t moment_number, record *rows, sd_messages *messages);
/* Collective: collects one checksum of each rank. all: [comm_size()] on rank 0, NULL on the
 * others. */
void ranks_gather_sums(const comm *c, int64_t sum, int64_t *all);

/* Collective: returns the number of closed contacts of all ranks. */
size_t ranks_count_contacts(const engine *part);
/* Collective: returns the exact sums over the disks and contacts of all ranks; contacts must be
 * stored. In one process, sums over its state. */
summary_sums ranks_summary_sums(const engine *part);

/* --- Columns of a state that are sent from rank to rank --------------------------------------- */

/* largest number of columns; number of columns sent at a time if narrow */
enum { MOVING_MOST = 256, MOVING_NARROW = 4 };

/* Columns to be sent, and the states between which they are copied. */
typedef struct moving {
  route *route;
  const sd_state *from;
  sd_state *to;
  /* send only MOVING_NARROW columns at a time, and none that is zero on all ranks, because one rank
   * may have all rows; `to` must be new, with all columns zero. The same on all ranks. */
  bool narrow;
  size_t n;
  const sd_field *field[MOVING_MOST];
  size_t size[MOVING_MOST]; /* bytes of a row of each column */
} moving;

/* moving_disks adds the columns that have a row for each free disk (bodies: only those with a row
 * for each body); moving_contacts adds those with a row for each closed contact of m->to. */
void moving_disks(moving *m, const sd_model *model, bool bodies);
void moving_contacts(moving *m);
/* Collective: sends the chosen columns. place: as in route_columns. */
sd_status moving_send(const moving *m, const uint32_t *place);

/* Copies what every rank has: rows of prescribed bodies, motions, numbers of the run. */
void common_take(const sd_state *from, sd_state *to);

#endif
