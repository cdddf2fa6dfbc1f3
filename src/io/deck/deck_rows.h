/* deck_rows.h: disks in columns: rows of the deck, a CSV file, an HDF5 dataset, a result, a LAMMPS data file.
 * See deck_rows.c, deck_result.c, deck_lammps.c. */
#ifndef SLIPDISK_IO_DECK_ROWS_H
#define SLIPDISK_IO_DECK_ROWS_H

#include "io/deck/deck_read.h"

/* What a column can hold: first numbers, then texts. */
enum {
  COLUMN_X,
  COLUMN_Y,
  COLUMN_THETA,
  COLUMN_VX,
  COLUMN_VY,
  COLUMN_OMEGA,
  COLUMN_RADIUS,
  COLUMN_MASS,
  COLUMN_DENSITY,
  COLUMN_INERTIA,
  COLUMN_FIXED,
  COLUMN_NUMBERS,
  COLUMN_NAME = COLUMN_NUMBERS,
  COLUMN_MATERIAL,
  COLUMN_GROUP,
  COLUMN_KINDS
};
extern const char *const deck_column_names[COLUMN_KINDS];
int deck_column(const char *name); /* -1: none */

typedef struct deck_columns {
  size_t n_columns, n_rows, capacity;
  int column[COLUMN_KINDS];
  const char *source[COLUMN_KINDS]; /* name in the file */
  double *number;                   /* [n_rows * n_columns], NAN where a text stands */
  const char **text; /* the same, NULL where a number stands; NULL when there is no text column */
  deck_place *place; /* [n_rows] */
  size_t all; /* disks of the file, where rows of it can be read by themselves; 0: they cannot */
  uint32_t *disk; /* [n_rows]: which disk of the file it is; NULL: in their order */

  /* of a result whose contacts are wanted */
  bool contacts;
  struct deck_result *result;
  size_t first;          /* disk of the model that row 0 became */
  const deck_node *file; /* for messages */
} deck_columns;

bool deck_columns_have(const deck_columns *table, int column);

/* Reads and pushes the entries of `disks`. deck_disks.c. */
void deck_read_single_disks(deck *d);
/* Reads an entry of disk_rows or disk_files, and pushes its disks: those of d->asked. deck_disks.c. */
deck_columns deck_read_table(deck *d, deck_node *node, const deck_table *table);

/* The key `columns` of a group of disk_rows or disk_files. */
void deck_columns_read(deck_group *g, deck_columns *table);
void deck_columns_from_rows(deck_group *g, deck_columns *table);
void deck_columns_from_file(deck_group *g, deck_columns *table);

/* What readers of files share. A column of the table, "radius" or "radius = name in the file"; false: reported
 * at node, or at place when that is NULL. A row, whose numbers and texts are then to be filled; false: there are too
 * many, reported at place. */
bool deck_columns_add(deck *d, deck_columns *table, const char *text, const deck_node *node,
                      deck_place place);
bool deck_columns_add_row(deck *d, deck_columns *table, deck_place place);
/* Room for so many rows, more than there are. */
void deck_columns_reserve(deck *d, deck_columns *table, size_t capacity);

/* deck_lammps.c */
void deck_lammps_read(deck_group *g, deck_node *file, deck_columns *table);
/* Edges of the box; false: reported. */
bool deck_lammps_box(deck *d, const deck_node *file, double lower[2], double upper[2]);

/* Formats in the order of the key's words; by the file's name, or because it is an HDF5 file. */
enum { DECK_CSV, DECK_HDF5, DECK_LAMMPS };
int deck_file_format(deck *d, const char *name);

/* Two columns of numbers of a CSV file, by name (for tables of motions); 0 rows: reported. */
size_t deck_csv_pair(deck *d, const deck_node *file, const char *const names[2], double **a,
                     double **b);

#endif
