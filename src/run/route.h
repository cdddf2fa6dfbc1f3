/* route.h: sends rows of a state to other ranks and receives rows from them.
 *
 * Rows that stay on this rank are copied once, from column to column; all columns for another rank
 * go in one message. */
#ifndef SLIPDISK_RUN_ROUTE_H
#define SLIPDISK_RUN_ROUTE_H

#include <stddef.h>
#include <stdint.h>

#include "base/comm.h"

/* Exchange of rows between ranks: which rows go to which rank, and how many come. */
typedef struct route {
  const comm *comm;
  /* [number of ranks] number of rows that go to each rank, that come from each rank */
  int *to, *from;
  /* number of rows that go to and that come from all ranks, this one included */
  size_t n_send, n_receive;
  /* [n_send] indices of the rows to send, ordered by destination rank */
  uint32_t *row;
  size_t capacity_out, capacity_in; /* allocated sizes of the buffers `out` and `in`, bytes */
  char *out, *in;
} route;

/* Column to be sent (from) and column into which received rows go (to); NULL: no rows. */
typedef struct route_column {
  const void *from;
  void *to;
  size_t size; /* bytes per row */
} route_column;

/* Allocates n rows of zeros, which the caller frees. Without memory it ends the job, since the
 * other ranks would wait. */
void *route_allocate(const comm *c, size_t n, size_t size);

/* Sets up a route by which row number row[k] goes to rank[k], 0 <= k < n; row NULL: row number k.
 * SD_ERROR_IO: out of memory. Afterwards every rank must call route_count. */
sd_status route_new(route *r, const comm *c, size_t n, const uint32_t *row, const int *rank);
/* Collective: tells all ranks how many rows they will receive. */
void route_count(route *r);
void route_free(route *r);

/* Collective: sends n columns. Received rows, numbered k = 0, 1, ... rank by rank, go to rows
 * place[k] of the columns; place NULL: to rows k. A rank without memory ends the job
 * (comm_fail). */
sd_status route_columns(route *r, const route_column *column, size_t n, const uint32_t *place);
/* Collective: sends row k of a column with one row per received row back to the rank and row from
 * which row k came. A rank without memory ends the job. */
void route_send_back(const route *r, route_column column);
/* Merges the received rows into one ascending sequence; those from each rank already ascend by
 * `order`. place[k]: receives the position of row k in the sequence. */
void route_merge(const route *r, const uint32_t *order, uint32_t *place);

/* --- Directory: rows found by number on other ranks ------------------------------------------- */

/* Table with a row for each number 0, 1, ..., distributed over the ranks: each rank stores a range
 * of numbers. Functions are collective; a rank without memory ends the job. */
typedef struct directory {
  const comm *comm;
  /* count of numbers that a rank stores, first number that this rank stores, bytes of a row */
  size_t width, first, size;
  char *rows;
} directory;

/* Makes a distributed table with rows of `size` bytes, all zero, for the numbers 0 ... n - 1. */
void directory_new(directory *d, const comm *c, size_t n, size_t size);
void directory_free(directory *d);
/* Stores n rows in the table: rows[k] as the row of number[k]. */
void directory_put(directory *d, size_t n, const uint32_t *number, const void *rows);
/* Reads rows from the table: rows[k] receives the row of number[k], 0 <= k < n; a number may occur
 * many times. */
void directory_get(const directory *d, size_t n, const uint32_t *number, void *rows);

#endif
