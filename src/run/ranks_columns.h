/* ranks_columns.h: columns of a state that go from rank to rank. */
#ifndef SLIPDISK_RUN_RANKS_COLUMNS_H
#define SLIPDISK_RUN_RANKS_COLUMNS_H

#include <stdbool.h>

#include "model/state.h"
#include "run/route.h"

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
