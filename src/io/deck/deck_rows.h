/* deck_rows.h: tables of disks: rows of the deck, a CSV file, an HDF5 dataset, a result, a
 * LAMMPS data file or a LAMMPS dump. See deck_rows.c, deck_result.c, deck_lammps.c. */
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
int deck_column(const char *name); /* Returns COLUMN_* for a name of a column; -1: no such name */

typedef struct deck_columns {
  size_t n_columns, n_rows, capacity;
  int column[COLUMN_KINDS];
  const char *source[COLUMN_KINDS]; /* [n_columns]: name of each column in the file */
  /* [n_columns]: arithmetic with this name, such as "0.5 * Diameter"; NULL: the value itself */
  const char *formula[COLUMN_KINDS];
  double *number; /* [n_rows * n_columns], row by row; NAN in columns of texts */
  /* [n_rows * n_columns], row by row; NULL in columns of numbers. The pointer is NULL without
   * columns of texts */
  const char **text;
  deck_place *place; /* [n_rows]: source location of the row */
  size_t all; /* Number of disks in the file, if single rows of the file can be read; else 0 */
  /* [n_rows]: number of each disk in the file; NULL: rows are in the file's order */
  uint32_t *disk;

  /* For results of runs. contacts: true to take over the contacts; result: the state that was
   * read */
  bool contacts;
  struct deck_result *result;
  size_t first;          /* Number that the disk of row 0 has in the model */
  const deck_node *file; /* Node of the deck with the name of the file, for messages */
} deck_columns;

bool deck_columns_have(const deck_columns *table, int column);

/* Reads the entries of `disks` and adds them to the model. In deck_disks.c. */
void deck_read_single_disks(deck *d);
/* Reads an entry of disk_rows or disk_files and adds the disks that d->asked selects to the model.
 * In deck_disks.c. */
deck_columns deck_read_table(deck *d, deck_node *node, const deck_table *table);

/* Reads the key `columns` of a group of disk_rows or disk_files. */
void deck_columns_read(deck_group *g, deck_columns *table);
void deck_columns_from_rows(deck_group *g, deck_columns *table);
void deck_columns_from_file(deck_group *g, deck_columns *table);

/* The functions below serve all readers of files.
 *
 * deck_columns_resolve splits the texts behind "radius =" that are no name of a column in the file,
 * but arithmetic with one, into both. there: returns true if the file has this column. */
typedef bool deck_column_there(void *file, const char *name);
void deck_columns_resolve(deck_group *g, deck_columns *table, deck_column_there *there, void *file);
/* Returns the value of column c of a row for this value in the file, from which it may follow by
 * arithmetic; NAN after an error, reported at place. */
double deck_columns_value(deck *d, const deck_columns *table, size_t c, double value,
                          deck_place place);
/* Returns the entry of the key `columns` for a column of disks that stands in a file as `name`,
 * such as "radius = 0.5 * diameter"; NULL: programs do not give it this name. */
const char *deck_columns_hint(deck *d, int column, const char *name);
/* deck_columns_add adds a column, "radius" or "radius = NAME IN THE FILE"; false after an error,
 * reported at node, or at place if node is NULL. deck_columns_add_row adds a row, whose numbers and
 * texts the caller fills in; false if there are too many rows, reported at place. */
bool deck_columns_add(deck *d, deck_columns *table, const char *text, const deck_node *node,
                      deck_place place);
bool deck_columns_add_row(deck *d, deck_columns *table, deck_place place);
/* Allocates memory for `capacity` rows, which must not be less than the number of rows in use. */
void deck_columns_reserve(deck *d, deck_columns *table, size_t capacity);

/* Reads the disks of a LAMMPS data file, or of a frame of a LAMMPS dump. In deck_lammps.c. */
void deck_lammps_read(deck_group *g, deck_node *file, deck_columns *table);
/* Returns the edges of the box in the header of a LAMMPS data file, or in the frame of a dump at
 * this step (-1: the last frame; both edges are the same where it is not periodic); false after
 * an error, which is reported. */
bool deck_lammps_box(deck *d, const deck_node *file, int64_t step, double lower[2],
                     double upper[2]);

/* File formats, in the order of the words of the key `format`. deck_file_format finds the format of
 * a file from its name; it is DECK_HDF5 whenever the content is HDF5. */
enum { DECK_CSV, DECK_HDF5, DECK_LAMMPS };
int deck_file_format(deck *d, const char *name);

/* Reads two columns of numbers, selected by their names, of a CSV file (for tables of motions).
 * Returns the number of rows, 0 after an error, which is reported. The arrays are in the arena. */
size_t deck_csv_pair(deck *d, const deck_node *file, const char *const names[2], double **a,
                     double **b);

/* --- the last file of disks of a deck, if it is large enough to be read in parts -------------- */

/* Collective, for a run on several ranks. Reads a large file, the last entry of disk_files, in
 * parts: each rank stores some of its disks in model->mine, and model->tiles describes the
 * distribution. Returns false if the file must be read as a whole instead. */
bool deck_parts_begin(deck *d, size_t entry);
/* Stores the checksum and the bounds of the disks of a large file in model->tiles, after every rank
 * has read the file as a whole. */
void deck_parts_note(deck *d, size_t entry, const deck_columns *table);
/* Collective. Reads the contacts of a file whose disks were read in parts: each rank stores some of
 * the contacts in model->mine. Also computes their checksum. *lost: number of contacts whose wall
 * is not in the model; *first: body number in the file of the wall of the first one. Returns false
 * if the contacts are damaged. */
bool deck_parts_contacts(deck *d, size_t *lost, uint32_t *first);
/* Computes the checksum of deck_parts_contacts when all contacts were read by one process. */
void deck_parts_note_contacts(deck *d, const struct deck_result *all);

#endif
