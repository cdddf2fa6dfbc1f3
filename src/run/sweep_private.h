/* sweep_private.h: declarations shared by the source files of a sweep. */
#ifndef SLIPDISK_RUN_SWEEP_PRIVATE_H
#define SLIPDISK_RUN_SWEEP_PRIVATE_H

#include <stdbool.h>
#include <stdint.h>

#include "io/store/h5.h"
#include "run/sweep.h"

/* Returns the path FOLDER/points/NAME.ENDING of a point's file; the caller frees it. */
char *sweep_point_path(const sweep *s, size_t point, const char *ending);

/* Returns true if two completed decks are equal, apart from the title if any_title is true. Else
 * adds their differences to those in r. */
bool sweep_compare(sweep_result *r, const char *there, const char *here, bool any_title);
/* Adds a difference between decks that is not about the value of a key; why: a sentence. */
void sweep_differ(sweep_result *r, const char *why);
/* sweep_differences_text returns the first differences of r as text, joined by "; "; the caller
 * frees it. */
char *sweep_differences_text(const sweep_result *r);
void sweep_differences_free(sweep_result *r);

/* --- Table of results in memory --------------------------------------------------------------- */

typedef enum result_kind { RESULT_NUMBER, RESULT_INTEGER, RESULT_TEXT } result_kind;

/* Column of a table of results; it is added to the table with its first value. */
typedef struct result_column {
  char *name;
  result_kind kind;
  char *unit;
  const char *meaning; /* a static string, which is not freed */
  bool always;         /* true: keep the column, whatever the key `collect` says */
  double *number;      /* [number of rows] values; NAN: empty cell */
  int64_t *integer;    /* [number of rows] values; RESULT_EMPTY: empty cell */
  char **text;         /* [number of rows] values; NULL: empty cell */
} result_column;
#define RESULT_EMPTY INT64_MIN

typedef struct result_table {
  size_t n_rows, n_columns;
  result_column *columns;
} result_table;

/* Set one cell to a number, an integer or a text; if the table has no column of this name, one is
 * added. */
void result_table_number(result_table *s, size_t row, const char *name, const char *unit,
                         const char *meaning, double x);
void result_table_integer(result_table *s, size_t row, const char *name, const char *meaning,
                          int64_t x);
void result_table_text(result_table *s, size_t row, const char *name, const char *meaning,
                       const char *text);
/* Returns the column of this name; NULL: the table has none. */
result_column *result_table_find(const result_table *s, const char *name);
/* Marks all columns that exist now, so that result_table_collect does not remove them. */
void result_table_keep_all(result_table *s);
/* Removes the columns that are not marked and whose names match none of the n patterns (fnmatch);
 * warns of a pattern that matches no column. */
void result_table_collect(result_table *s, size_t n, const char *const *patterns,
                          sd_messages *messages);
void result_table_free(result_table *s);

/* Writes the table as CSV (RFC 4180): numbers with as many digits as are needed to restore them
 * exactly, empty cells where values are missing. *sum: receives the checksum of the file. */
sd_status result_table_write_csv(const result_table *s, const char *path, uint64_t *sum,
                                 sd_messages *messages);
/* Writes the columns as datasets of an HDF5 group; an empty cell of an integer column is stored as
 * -1. */
void result_table_write_h5(const result_table *s, h5_file *file, const char *group);

#endif
