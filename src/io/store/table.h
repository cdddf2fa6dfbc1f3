/* table.h: a table of results, whose rows are held in memory until they are written into a part
 * (file with some rows of a run's results).
 *
 * Each column of a table is one dataset; rows k of all columns belong together. The datasets have
 * the same paths in a part and in the finished file. Paths of H5MD elements end in "/value". The
 * first two columns are step and time of the first element; every other element of the table gets
 * hard links to them, as H5MD requires.
 */
#ifndef SLIPDISK_IO_TABLE_H
#define SLIPDISK_IO_TABLE_H

#include "io/store/h5.h"
#include "measure/observable.h"

/* A column of a table. */
typedef struct table_column {
  char *path;           /* path of the dataset */
  sd_type type;         /* type of the elements */
  int rank;             /* rank of one row: 0, 1 or 2 */
  size_t dims[2];       /* dimensions of one row; 1 beyond its rank */
  size_t width;         /* number of elements in one row */
  char *unit, *meaning; /* attributes `unit` and `description` of the dataset */
  unsigned char *data;  /* [capacity] values of the column, row by row */
} table_column;

/* A table: its columns, and the number of rows that they hold. */
typedef struct table {
  table_column *columns;
  size_t n_columns, n_rows, capacity;
  bool compress; /* true if the datasets are written compressed */
} table;

/* Frees the columns of a table; the table is empty afterwards. */
void table_free(table *t);
/* Adds a column to a table that has no rows yet. dims[rank]: dimensions of one row; rank 0: a
 * number per row. Columns are numbered in the order of these calls. */
void table_add(table *t, const char *path, sd_type type, int rank, const size_t *dims,
               const char *unit, const char *meaning);
/* Adds the columns step and time of the H5MD element at this path. */
void table_add_clock(table *t, const char *element);
/* Adds the column of a measured quantity (observable) in a group: for one object per row (n = 0) or
 * for n objects per row. ending: end of the dataset's path, "/value" or "". */
void table_add_observable(table *t, const char *group, const observable *o, const char *ending,
                          size_t n);
/* Makes room for n more rows. Returns SD_ERROR_IO if there is no memory. */
sd_status table_reserve(table *t, size_t n, sd_messages *messages);
/* Returns the address of a column's value in the row to be added. All columns are filled, then
 * table_commit is called. */
void *table_cell(table *t, size_t column);
/* Adds the n rows that were filled to the table. */
void table_commit(table *t, size_t n);
/* Fills step and time in the row to be added; returns the number of the next column. */
size_t table_put_clock(table *t, int64_t step, double dt);
/* Stores the n elements of a quantity (observable) of the struct `row` in a cell of the row to be
 * added, behind the elements of the `index` objects before it. */
void table_put(table *t, size_t column, size_t index, const observable *o, const void *row,
               size_t n);
/* Removes all rows; the memory is kept. */
void table_clear(table *t);
/* Returns the number of bytes of all rows. */
size_t table_bytes(const table *t);
/* Writes the datasets of all columns with their rows, of which there may be none, their units, and
 * the links to step and time. */
void table_write(const table *t, h5_file *file);

/* Makes the datasets of all columns for n_rows rows, which are written later, with units and the
 * links to step and time. */
void table_make(const table *t, h5_file *file, size_t n_rows);
/* Computes dims[], the dimensions of a column's dataset with n_rows rows; returns its rank. */
int table_shape(const table_column *c, size_t n_rows, size_t dims[H5_MAX_RANK]);

#endif
