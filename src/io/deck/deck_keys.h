/* deck_keys.h: the tables of all keys that a deck may have.
 *
 * Unknown keys, ranges, defaults, the echo and docs/deck.md all follow these tables; a test compares
 * docs/deck.md with them in both directions.
 */
#ifndef SLIPDISK_IO_DECK_KEYS_H
#define SLIPDISK_IO_DECK_KEYS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>

#include "slipdisk/model.h"

typedef enum deck_kind {
  DECK_KEY_BOOL,
  DECK_KEY_INTEGER,
  DECK_KEY_NUMBER,
  DECK_KEY_ANGLE, /* a number of radians, or "0.04 pi", "7.2 deg" */
  DECK_KEY_TEXT,
  DECK_KEY_CHOICE,
  DECK_KEY_NUMBERS,     /* list of numbers */
  DECK_KEY_POINTS,      /* list of (x, y) */
  DECK_KEY_NAMES,       /* one text or a list of them */
  DECK_KEY_BODIES,      /* one name or number, or a list of them */
  DECK_KEY_COORDINATES, /* "x", "y", "theta" or a list of them */
  DECK_KEY_ROWS,        /* list of lists of values */
  DECK_KEY_VALUES,      /* list of values of any kind */
  DECK_KEY_GROUP,
  DECK_KEY_GROUPS /* list of groups */
} deck_kind;

typedef enum deck_range {
  DECK_ANY,
  DECK_POSITIVE,
  DECK_NOT_NEGATIVE,
  DECK_AT_LEAST_1,
  DECK_UP_TO_1
} deck_range;

/* initial: the default as it would stand in a deck; "required"; "-": absent unless given; or "(words)" where
 * it depends on other keys. */
typedef struct deck_key {
  const char *name;
  deck_kind kind;
  deck_range range;
  const char *unit;
  const char *initial;
  const char *choices; /* of a choice: the words, with a space between */
  const char *meaning;
} deck_key;

typedef struct deck_table {
  const char *name; /* as in the deck: "motions", "measure.sliding" */
  const char *meaning;
  bool one; /* { } and not a list of them */
  size_t n;
  const deck_key *key;
} deck_table;

extern const deck_table deck_top, deck_gravity, deck_box, deck_materials, deck_pairs, deck_container,
    deck_disks, deck_disk_rows, deck_disk_files, deck_packings, deck_bounds, deck_forces, deck_locks,
    deck_walls, deck_motions, deck_phases, deck_settle, deck_compress, deck_output, deck_measure,
    deck_sliding, deck_until, deck_limits, deck_sweeps, deck_sweep_parameters;
extern const deck_table *const deck_tables[];
extern const size_t deck_table_count;

/* What each kind of motion, wall, container, packing and size distribution reads besides the keys that all of them have. A key with a star must be
 * given; keys joined with / are alternatives, of which exactly one (with a star) must be given. */
typedef struct deck_shape {
  const char *name;
  int kind;
  const char *keys;
  const char *meaning;
} deck_shape;

enum { DECK_MOTION_FIXED = SD_MOTION_KINDS };
extern const deck_shape deck_motion_kinds[];
extern const size_t deck_motion_kind_count;
extern const deck_shape deck_wall_kinds[];
extern const size_t deck_wall_kind_count;
extern const deck_shape deck_container_kinds[], deck_packing_kinds[], deck_size_kinds[];
extern const size_t deck_container_kind_count, deck_packing_kind_count, deck_size_kind_count;

const deck_key *deck_key_find(const deck_table *table, const char *name);
const char *deck_kind_text(deck_kind kind);
const char *deck_range_text(deck_range range);
bool deck_in_range(deck_range range, double x);
/* Words for the range in which x, which is out of it, is expected. */
const char *deck_expected(deck_range range, double x);

/* The candidate nearest to word in edit distance, NULL when none is near enough to be meant. */
typedef struct deck_guess {
  const char *word, *best;
  size_t distance;
} deck_guess;
deck_guess deck_guess_start(const char *word);
void deck_guess_add(deck_guess *guess, const char *candidate);

/* All tables as Markdown, the way docs/deck.md shows them. */
void deck_keys_print(FILE *out);

#endif
