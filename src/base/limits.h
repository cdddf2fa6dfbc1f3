/* limits.h: upper bounds on what is read from files and from the command line. docs/deck.md states
 * these numbers.
 *
 * They are larger than any sensible input, and keep time and memory bounded whatever a file holds.
 */
#ifndef SLIPDISK_BASE_LIMITS_H
#define SLIPDISK_BASE_LIMITS_H

/* Builds for fuzzing define a smaller limit, so that generated inputs reach it. */
#ifndef SD_LIMIT_DISKS
#define SD_LIMIT_DISKS 200000000
#endif

enum {
  LIMIT_MIB = 1 << 20,
  LIMIT_DECK = 16, /* largest size of a deck (input file), with all files that it includes, MiB */
  LIMIT_TABLE = 1024, /* largest size of a CSV file or a LAMMPS data file, MiB */
  LIMIT_CHUNK = 64,   /* largest size of a chunk of an HDF5 dataset, MiB */
  /* largest compression ratio: bytes of an HDF5 dataset per byte in the file */
  LIMIT_EXPANSION = 1100,
  LIMIT_TEXT = 64, /* largest size of a text in an HDF5 file, MiB */
  /* largest nesting depth of brackets in a deck, and largest number of steps in a key's path */
  LIMIT_DEPTH = 40,
  LIMIT_INCLUDE_DEPTH = 8, /* largest nesting depth of @include in a deck */
  LIMIT_INCLUDES = 1000,   /* largest number of files that a deck includes in all */
  LIMIT_KEYS = 256,        /* largest number of keys in one group of a deck */
  /* largest number of entries of a list in a deck (walls, motions), except disks */
  LIMIT_ENTRIES = 10000,
  LIMIT_MATERIALS = 1000,
  LIMIT_PHASES = 1000,
  LIMIT_COLUMNS = 1000, /* largest number of columns in a CSV file */
  LIMIT_DISKS = SD_LIMIT_DISKS,
  LIMIT_TABLE_ROWS = 10000000, /* largest number of rows in the table of a tabulated motion */
  LIMIT_LINKS = 1000000,       /* largest number of names that are listed in an HDF5 file */
  LIMIT_GROUPS = 16,           /* largest nesting depth of groups in an HDF5 file */
  LIMIT_QUOTE = 80,  /* largest number of bytes of a text that a message quotes, and of a key */
  LIMIT_LINE = 8192, /* largest number of bytes of a message */
  /* largest number of a deck's errors that are reported; further ones are only counted */
  LIMIT_DECK_ERRORS = 100,
  /* largest number of messages that are kept, of errors and of warnings each */
  LIMIT_MESSAGES = 1000
};

/* Largest magnitude of a number that is accepted; the smallest one, except 0, is its inverse.
 * Products of three such numbers are finite. */
#define LIMIT_NUMBER 1e100

#endif
