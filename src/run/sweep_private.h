/* sweep_private.h: what the files of a sweep share. */
#ifndef SLIPDISK_RUN_SWEEP_PRIVATE_H
#define SLIPDISK_RUN_SWEEP_PRIVATE_H

#include <stdbool.h>
#include <stdint.h>

#include "io/store/h5.h"
#include "run/sweep.h"

/* FOLDER/points/NAME with this ending, to be freed. */
char *sweep_point_path(const sweep *s, size_t point, const char *ending);

/* True: two full decks say the same; any_title: but for the title, perhaps. Else the differences are added to those of r. */
bool sweep_compare(sweep_result *r, const char *there, const char *here, bool any_title);
/* Another difference than that of a key. */
void sweep_differ(sweep_result *r, const char *why);
/* The first of them, joined by "; ", to be freed. */
char *sweep_differences_text(const sweep_result *r);
void sweep_differences_free(sweep_result *r);

/* A table of results in memory, with columns that are made as they are met; written as CSV and HDF5. */

typedef enum result_kind { RESULT_NUMBER, RESULT_INTEGER, RESULT_TEXT } result_kind;

typedef struct result_column {
  char *name;
  result_kind kind;
  const char *unit, *meaning; /* static */
  bool always;                /* not subject to `collect` */
  double *number;             /* [rows], NAN: empty */
  int64_t *integer;           /* [rows], RESULT_EMPTY: empty */
  char **text;                /* [rows], NULL: empty */
} result_column;
#define RESULT_EMPTY INT64_MIN

typedef struct result_table {
  size_t n_rows, n_columns;
  result_column *columns;
} result_table;

/* Cells: the column is made when there is none of this name. */
void result_table_number(result_table *s, size_t row, const char *name, const char *unit,
                         const char *meaning, double x);
void result_table_integer(result_table *s, size_t row, const char *name, const char *meaning,
                          int64_t x);
void result_table_text(result_table *s, size_t row, const char *name, const char *meaning,
                       const char *text);
result_column *result_table_find(const result_table *s, const char *name); /* NULL: none */
/* The columns made so far are not subject to result_table_collect. */
void result_table_keep_all(result_table *s);
/* Removes columns that match none of the patterns (fnmatch) and need not stay; a pattern that matches nothing is a
 * warning. */
void result_table_collect(result_table *s, size_t n, const char *const *patterns,
                          sd_messages *messages);
void result_table_free(result_table *s);

/* As CSV (RFC 4180, numbers to the last bit, empty cells where nothing is known). */
sd_status result_table_write_csv(const result_table *s, const char *path, sd_messages *messages);
/* Writes the columns as datasets of a group. An empty integer is -1 there. */
void result_table_write_h5(const result_table *s, h5_file *file, const char *group);

#endif
