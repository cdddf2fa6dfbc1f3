/* route.h: rows of a state that go to other ranks, and rows that come.
 *
 * Rows that stay here are copied once, from column to column; all columns of the others go in one message to each rank.
 */
#ifndef SLIPDISK_RUN_ROUTE_H
#define SLIPDISK_RUN_ROUTE_H

#include <stddef.h>
#include <stdint.h>

#include "base/comm.h"

typedef struct route {
  const comm *comm;
  int *to, *from;                   /* rows to and from each rank */
  size_t n_send, n_receive;         /* of all ranks, with this one */
  uint32_t *row;                    /* [n_send] of a column, those to rank 0 first */
  size_t capacity_out, capacity_in; /* bytes of the buffers */
  char *out, *in;
} route;

/* A column here, and where its rows go to; NULL: no rows. */
typedef struct route_column {
  const void *from;
  void *to;
  size_t size; /* bytes of a row */
} route_column;

/* n rows that are all zero, to be freed. Without memory the job ends: the other ranks would wait.
 * */
void *route_room(const comm *c, size_t n, size_t size);

/* Row row[k] goes to rank[k]; row NULL: row k. SD_ERROR_IO: no memory.
 * Then, on every rank, route_count. */
sd_status route_new(route *r, const comm *c, size_t n, const uint32_t *row, const int *rank);
void route_count(route *r);
void route_free(route *r);

/* Collective. Rows that come, numbered rank by rank, go to rows place[k] of the columns; place NULL: rows k. Without memory the job ends
 * (comm_fail). */
sd_status route_columns(route *r, const route_column *column, size_t n, const uint32_t *place);
/* Collective: row k of those that came goes back to where it came from, to the row that it was
 * there. Without memory the job ends. */
void route_answer(const route *r, route_column column);
/* The rows of each rank come in ascending order: place[k] is where row k stands among all. */
void route_merge(const route *r, const uint32_t *order, uint32_t *place);

/* Rows by number, spread over the ranks: each keeps those of a strip of numbers.
 * Functions are collective; without memory the job ends. */

typedef struct directory {
  const comm *comm;
  size_t width, first, size; /* numbers of a strip; of this rank's; bytes of a row */
  char *rows;
} directory;

/* Rows of `size` bytes, all zero, for numbers below n. */
void directory_new(directory *d, const comm *c, size_t n, size_t size);
void directory_free(directory *d);
/* Notes n rows. */
void directory_put(directory *d, size_t n, const uint32_t *number, const void *rows);
/* The rows of n numbers, which may be asked for many times. */
void directory_get(const directory *d, size_t n, const uint32_t *number, void *rows);

#endif
