/* limits.h: upper bounds of what is read from files and the command line. docs/deck.md states these
 * numbers.
 *
 * They are larger than any sensible input, and keep time and memory bounded whatever a file
 * holds.
 */
#ifndef SLIPDISK_BASE_LIMITS_H
#define SLIPDISK_BASE_LIMITS_H

/* Fuzz builds define a smaller number, so that their inputs reach the limit. */
#ifndef SD_LIMIT_DISKS
#define SD_LIMIT_DISKS 200000000
#endif

enum {
  LIMIT_MIB = 1 << 20,
  LIMIT_DECK = 16,        /* MiB of a deck, with all files that it includes */
  LIMIT_TABLE = 1024,     /* MiB of a CSV file or a LAMMPS data file */
  LIMIT_CHUNK = 64,       /* MiB of a chunk of an HDF5 dataset */
  LIMIT_EXPANSION = 1100, /* bytes of an HDF5 dataset per byte that is stored (compression ratio) */
  LIMIT_TEXT = 64,        /* MiB of a text in an HDF5 file */
  LIMIT_DEPTH = 40,       /* nesting depth of brackets, and steps of a key's path */
  LIMIT_INCLUDE_DEPTH = 8, /* nesting depth of @include */
  LIMIT_INCLUDES = 1000,   /* included files in all */
  LIMIT_KEYS = 256,        /* keys of one group */
  LIMIT_ENTRIES = 10000,   /* entries of a list of groups other than disks */
  LIMIT_MATERIALS = 1000,
  LIMIT_PHASES = 1000,
  LIMIT_COLUMNS = 1000, /* columns of a CSV file */
  LIMIT_DISKS = SD_LIMIT_DISKS,
  LIMIT_TABLE_ROWS = 10000000, /* rows of the table of a motion */
  LIMIT_LINKS = 1000000,       /* names listed in an HDF5 file */
  LIMIT_GROUPS = 16,           /* nesting depth of groups in an HDF5 file */
  LIMIT_QUOTE = 80,            /* bytes of a text that a message quotes, and of a key */
  LIMIT_LINE = 8192,           /* bytes of a message */
  LIMIT_DECK_ERRORS = 100,     /* errors of a deck that are reported; the rest is only counted */
  LIMIT_MESSAGES = 1000        /* messages that are kept, errors and warnings each */
};

/* Largest magnitude of a number that is accepted; the smallest, except 0, is the inverse. Products
 * of three such numbers are finite. */
#define LIMIT_NUMBER 1e100

#endif
