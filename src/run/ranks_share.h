/* ranks_share.h: writes the file of one rank (share) for checkpoints and results, and adds up sums
 * over ranks; see ranks.h. */
#ifndef SLIPDISK_RUN_RANKS_SHARE_H
#define SLIPDISK_RUN_RANKS_SHARE_H

#include <stdbool.h>

#include "base/comm.h"
#include "io/results/record.h"
#include "io/results/summary.h"
#include "model/state.h"
#include "physics/system/work.h"
#include "run/route.h"

/* Writes this rank's disks and contacts to its own file (share) of a checkpoint, `path`; contacts
 * and motions must have been stored in the state. sum: receives the checksum of the file. */
sd_status ranks_write_share(const engine *part, const char *path, int64_t *sum,
                            sd_messages *messages);
/* Adds this rank's disks and contacts to `rows`, as parts of frame number `frame` and of contact
 * table number `moment_number` in the next part file. what: bits that select frames, contacts or
 * both. */
sd_status ranks_sample_share(const engine *part, unsigned what, int64_t frame,
                             int64_t moment_number, record *rows, sd_messages *messages);
/* Collective: collects one file checksum from each rank. all: [comm_size()] on rank 0, NULL on the
 * others. */
void ranks_gather_sums(const comm *c, int64_t sum, int64_t *all);

/* Collective: returns the number of closed contacts of all ranks together. */
size_t ranks_count_contacts(const engine *part);
/* Collective: returns the exact sums over the disks and contacts of all ranks; contacts must have
 * been stored. In a run in one process: the sums over its state. */
summary_sums ranks_summary_sums(const engine *part);

/* --- Columns of a state that are sent from rank to rank --------------------------------------- */

/* largest number of columns; number of columns sent at a time if `narrow` is true */
enum { MOVING_MOST = 256, MOVING_NARROW = 4 };

/* Columns of a state to be sent to other ranks, and the states from which and into which they are
 * copied. */
typedef struct moving {
  route *route;
  const sd_state *from;
  sd_state *to;
  /* true: send MOVING_NARROW columns at a time, and leave out columns that are zero on all ranks;
   * saves memory where one rank may have all rows. `to` must then be a new state, with all columns
   * zero. The value must be the same on all ranks. */
  bool narrow;
  size_t n;
  const sd_field *field[MOVING_MOST];
  size_t size[MOVING_MOST]; /* [n] bytes per row of each column */
} moving;

/* moving_disks adds the columns that have a row for each free disk (bodies true: only columns that
 * have a row for every body); moving_contacts adds the columns that have a row for each closed
 * contact of m->to. */
void moving_disks(moving *m, const sd_model *model, bool bodies);
void moving_contacts(moving *m);
/* Collective: sends the columns of m. place: rows at which the received rows are stored, as for
 * route_columns. */
sd_status moving_send(const moving *m, const uint32_t *place);

/* Copies the data that all ranks have alike: rows of prescribed bodies, motions, numbers of the
 * run. */
bool common_take(const sd_state *from, sd_state *to);

#endif
