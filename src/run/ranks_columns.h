/* ranks_columns.h: columns of a state that go from rank to rank.
 *
 * Of the whole few columns go at a time, and those whose rows are in a file (state_source) are read just then, so that rank 0 needs
 * memory for these only.
 */
#ifndef SLIPDISK_RUN_RANKS_COLUMNS_H
#define SLIPDISK_RUN_RANKS_COLUMNS_H

#include <stdbool.h>

#include "model/state.h"
#include "run/route.h"

enum { MOVING_MOST = 256, MOVING_NARROW = 4 };

typedef struct moving {
  route *route;
  const sd_state *from; /* NULL: no rows here */
  sd_state *to;         /* NULL: none come here */
  bool narrow;          /* from or to the whole; the same on all ranks */
  bool fresh;           /* from the whole, to new states: columns of zeros stay */
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
/* The same by way of a buffer. to: into the state; else out of it. */
size_t common_bytes(const sd_state *s);
void common_copy(const sd_state *s, char *buffer, bool to);

#endif
