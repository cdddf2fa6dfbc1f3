/* route.h: sends rows of a state to other ranks and receives rows from them.
 *
 * Rows that stay on this rank are copied once, from column to column; all columns for another
 * rank go in one message. */
#ifndef SLIPDISK_RUN_ROUTE_H
#define SLIPDISK_RUN_ROUTE_H

#include <stddef.h>
#include <stdint.h>

#include "base/comm.h"

/* Rows that go to each rank and come from it. */
typedef struct route {
  const comm *comm;
  int *to, *from;                   /* number of rows to and from each rank */
  size_t n_send, n_receive;         /* rows to and from all ranks, this one included */
  uint32_t *row;                    /* [n_send] indices of the rows to send, ordered by rank */
  size_t capacity_out, capacity_in; /* capacities of the buffers, bytes */
  char *out, *in;
} route;

/* Source and destination of a column; NULL: no rows. */
typedef struct route_column {
  const void *from;
  void *to;
  size_t size; /* bytes of a row */
} route_column;

/* Allocates n rows of zeros, which the caller frees. Ends the job if there is no memory, since the
 * other ranks would wait. */
void *route_room(const comm *c, size_t n, size_t size);

/* Sets up a route on which row row[k] goes to rank[k]; row NULL: row k. SD_ERROR_IO: out of memory.
 * Every rank must then call route_count. */
sd_status route_new(route *r, const comm *c, size_t n, const uint32_t *row, const int *rank);
/* Collective: exchanges the numbers of rows between ranks. */
void route_count(route *r);
void route_free(route *r);

/* Collective: sends n columns. Received rows, numbered rank by rank, go to rows place[k] of the
 * columns; place NULL: rows k. A rank without memory ends the job (comm_fail). */
sd_status route_columns(route *r, const route_column *column, size_t n, const uint32_t *place);
/* Collective: sends row k of a column of received rows back to the rank and row from which it came.
 * A rank without memory ends the job. */
void route_answer(const route *r, route_column column);
/* Merges the received rows, which ascend by `order` within each rank: place[k] becomes the position
 * of row k in the ascending order of all. */
void route_merge(const route *r, const uint32_t *order, uint32_t *place);

/* --- Directory: rows found by number on other ranks ------------------------------------------- */

/* Table of rows by number, distributed over the ranks: each rank stores a range of numbers.
 * Functions are collective; a rank without memory ends the job. */
typedef struct directory {
  const comm *comm;
  size_t width, first, size; /* numbers per rank, first number of this rank, bytes of a row */
  char *rows;
} directory;

/* Makes a directory with rows of `size` bytes, all zero, for numbers below n. */
void directory_new(directory *d, const comm *c, size_t n, size_t size);
void directory_free(directory *d);
/* Stores n rows by their numbers. */
void directory_put(directory *d, size_t n, const uint32_t *number, const void *rows);
/* Reads the rows of n numbers; a number may occur many times. */
void directory_get(const directory *d, size_t n, const uint32_t *number, void *rows);

#endif
