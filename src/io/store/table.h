/* table.h: rows that wait in memory until they are sealed into a part.
 *
 * A table has columns with one dataset each; row k of every column belongs together. The datasets stand at the
 * same paths in a part and in the finished file. The element paths end in "/value"; the first two columns are
 * step and time of the first element, and every other element of the table gets hard links to them, as H5MD
 * asks for.
 */
#ifndef SLIPDISK_IO_TABLE_H
#define SLIPDISK_IO_TABLE_H

#include "io/store/h5.h"
#include "measure/observable.h"

typedef struct table_column {
  char *path; /* of the dataset */
  sd_type type;
  int rank; /* of one row: 0, 1 or 2 */
  size_t dims[2];
  size_t width; /* elements in one row */
  char *unit, *meaning;
  unsigned char *data;
} table_column;

typedef struct table {
  table_column *columns;
  size_t n_columns, n_rows, capacity;
  bool compress;
} table;

void table_free(table *t);
/* Adds a column to a table without rows; rank 0: a number per row. The order of the calls is the order of the
 * columns. */
void table_add(table *t, const char *path, sd_type type, int rank, const size_t *dims,
               const char *unit, const char *meaning);
/* Columns step and time of the element at this path. */
void table_add_clock(table *t, const char *element);
/* The column of an observable in a group: of one thing a row (n = 0), or of n things. ending:
 * "/value" or "". */
void table_add_observable(table *t, const char *group, const observable *o, const char *ending,
                          size_t n);
/* Room for n more rows. SD_ERROR_IO: no memory. */
sd_status table_reserve(table *t, size_t n, sd_messages *messages);
/* Where the column's value in the row to be added stands; fill all columns, then table_commit. */
void *table_cell(table *t, size_t column);
void table_commit(table *t, size_t n);
/* Fills the clock in the row to be added; returns the number of the next column. */
size_t table_put_clock(table *t, int64_t step, double dt);
/* n elements of an observable, behind those of `index` others in the same cell. */
void table_put(table *t, size_t column, size_t index, const observable *o, const void *row,
               size_t n);
void table_clear(table *t); /* keeps the memory */
size_t table_bytes(const table *t);
/* Writes all rows (also none), units and links. */
void table_write(const table *t, h5_file *file);

/* As table_write, for rows that come later: empty datasets of n rows with units and links. */
void table_make(const table *t, h5_file *file, size_t n_rows);
/* Dimensions of a column's dataset with n rows; returns its rank. */
int table_shape(const table_column *c, size_t n_rows, size_t dims[H5_MAX_RANK]);

#endif
