/* sheet.h: a table of results in memory, with columns that are made as they are met; written as CSV and HDF5. */
#ifndef SLIPDISK_RUN_SHEET_H
#define SLIPDISK_RUN_SHEET_H

#include <stdbool.h>
#include <stdint.h>

#include "io/store/h5.h"

typedef enum sheet_kind { SHEET_NUMBER, SHEET_INTEGER, SHEET_TEXT } sheet_kind;

typedef struct sheet_column {
  char *name;
  sheet_kind kind;
  const char *unit, *meaning; /* static */
  bool always;                /* not subject to `collect` */
  double *number;             /* [rows], NAN: empty */
  int64_t *integer;           /* [rows], SHEET_EMPTY: empty */
  char **text;                /* [rows], NULL: empty */
} sheet_column;
#define SHEET_EMPTY INT64_MIN

typedef struct sheet {
  size_t n_rows, n_columns;
  sheet_column *columns;
  bool failed; /* no memory */
} sheet;

/* Cells: the column is made when there is none of this name. */
void sheet_number(sheet *s, size_t row, const char *name, const char *unit, const char *meaning, double x);
void sheet_integer(sheet *s, size_t row, const char *name, const char *meaning, int64_t x);
void sheet_text(sheet *s, size_t row, const char *name, const char *meaning, const char *text);
sheet_column *sheet_find(const sheet *s, const char *name); /* NULL: none */
/* The columns made so far are not subject to sheet_collect. */
void sheet_keep_all(sheet *s);
/* Removes columns that match none of the patterns (fnmatch) and need not stay; a pattern that matches nothing is a
 * warning. */
void sheet_collect(sheet *s, size_t n, const char *const *patterns, sd_messages *messages);
void sheet_free(sheet *s);

/* As CSV (RFC 4180, numbers to the last bit, empty cells where nothing is known). */
sd_status sheet_write_csv(const sheet *s, const char *path, sd_messages *messages);
/* As datasets of a group. An empty integer is -1 there. False: no memory. */
bool sheet_write_h5(const sheet *s, h5_file *file, const char *group);

#endif
