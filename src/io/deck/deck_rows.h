/* deck_rows.h: tables of disks: rows of the deck, a CSV file, an HDF5 dataset, a result or a
 * LAMMPS data file. See deck_rows.c, deck_result.c, deck_lammps.c. */
#ifndef SLIPDISK_IO_DECK_ROWS_H
#define SLIPDISK_IO_DECK_ROWS_H

#include "io/deck/deck_read.h"

/* Properties of a disk that a column can hold: first numbers, then texts. */
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
int deck_column(const char *name); /* Returns COLUMN_* of a name; -1: none */

typedef struct deck_columns {
  size_t n_columns, n_rows, capacity;
  int column[COLUMN_KINDS];
  const char *source[COLUMN_KINDS]; /* Name of the column in the file */
  double *number;                   /* [n_rows * n_columns], NAN for columns of texts */
  /* [n_rows * n_columns], NULL for columns of numbers; NULL pointer without text columns */
  const char **text;
  deck_place *place; /* [n_rows]: source location of the row */
  size_t all; /* Number of disks in the file, if single rows of it can be read; 0: they cannot */
  uint32_t *disk; /* [n_rows]: number of the disk in the file; NULL: rows are in the file's order */

  /* Set for results of runs: whether contacts are wanted, and the state that was read */
  bool contacts;
  struct deck_result *result;
  size_t first;          /* Number of the disk of the model that row 0 became */
  const deck_node *file; /* Node with the file's name, for messages */
} deck_columns;

bool deck_columns_have(const deck_columns *table, int column);

/* Reads the entries of `disks` and adds them to the model. In deck_disks.c. */
void deck_read_single_disks(deck *d);
/* Reads an entry of disk_rows or disk_files and adds its disks, those of d->asked, to the model.
 * In deck_disks.c. */
deck_columns deck_read_table(deck *d, deck_node *node, const deck_table *table);

/* Reads the key `columns` of a group of disk_rows or disk_files. */
void deck_columns_read(deck_group *g, deck_columns *table);
void deck_columns_from_rows(deck_group *g, deck_columns *table);
void deck_columns_from_file(deck_group *g, deck_columns *table);

/* Shared by the readers of files. deck_columns_add adds a column, "radius" or "radius = name in
 * the file"; false: reported at node, or at place when node is NULL. deck_columns_add_row adds a
 * row, whose numbers and texts the caller fills in; false: too many rows, reported at place. */
bool deck_columns_add(deck *d, deck_columns *table, const char *text, const deck_node *node,
                      deck_place place);
bool deck_columns_add_row(deck *d, deck_columns *table, deck_place place);
/* Allocates space for `capacity` rows, which must be more than there are. */
void deck_columns_reserve(deck *d, deck_columns *table, size_t capacity);

/* deck_lammps.c */
void deck_lammps_read(deck_group *g, deck_node *file, deck_columns *table);
/* Returns the edges of the box in a LAMMPS file; false: reported. */
bool deck_lammps_box(deck *d, const deck_node *file, double lower[2], double upper[2]);

/* File formats in the order of the words of the key `format`. deck_file_format chooses by the
 * file's name, or DECK_HDF5 if the content is HDF5. */
enum { DECK_CSV, DECK_HDF5, DECK_LAMMPS };
int deck_file_format(deck *d, const char *name);

/* Reads two columns of numbers of a CSV file by name (for tables of motions); returns the number
 * of rows, 0 after a mistake (reported). The arrays are in the arena. */
size_t deck_csv_pair(deck *d, const deck_node *file, const char *const names[2], double **a,
                     double **b);

/* --- the last file of disks of a deck, if it is large enough to be read in parts -------------- */

/* Collective, for a run on several ranks: each rank reads some of the disks of this entry of
 * disk_files into model->mine, and the disks are away (model->tiles). Returns false if the file
 * must be read as a whole. */
bool deck_parts_begin(deck *d, size_t entry);
/* Notes in model->tiles the checksum and bounds of the disks of such a file after it was read as
 * a whole. */
void deck_parts_note(deck *d, size_t entry, const deck_columns *table);
/* Collective. Reads contacts of that file, some on each rank, into model->mine, and adds up
 * their checksum. *lost: number of contacts whose partner is not in the model; *first: the wall
 * of the first of them. Returns false if contacts are damaged. */
bool deck_parts_contacts(deck *d, size_t *lost, uint32_t *first);
/* Computes the same checksum when all contacts are in this process. */
void deck_parts_note_contacts(deck *d, const struct deck_result *all);

#endif
