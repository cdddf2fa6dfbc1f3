/* deck_read.h: functions that read values of keys (getters); they follow the key tables.
 *
 * A getter reports an error (wrong type or range, missing key) and then returns a harmless value,
 * so that reading goes on and finds the next error. Values that were left out are put into the tree
 * with their default, so that deck_echo prints a complete deck afterwards. */
#ifndef SLIPDISK_IO_DECK_READ_H
#define SLIPDISK_IO_DECK_READ_H

#include "base/text.h"
#include "io/deck/deck_expression.h"
#include "io/deck/deck_values.h"
#include "model/keys.h"
#include "slipdisk/model.h"

/* A group of the deck that is being read, with the table of the keys that it may have. */
typedef struct deck_group {
  deck *d;
  deck_node *node;
  const deck_table *table;
  void *members; /* Struct that deck_fill has filled; NULL before */
} deck_group;

/* Reports an error about a key of the group; the key may be missing, as in deck_fail_child. */
void deck_fail_key(const deck_group *g, const char *key, const char *format, ...) SD_PRINTF(3, 4);

/* Begins to read the group `node`, sets *g, and reports keys that the table lacks. Returns false if
 * node is not a group (reported). */
bool deck_enter(deck *d, deck_node *node, const deck_table *table, deck_group *g);
/* Begins to read the top-level group that has the name of the table; adds it, empty, if the deck
 * lacks it. Returns false if it is not a group (reported). */
bool deck_enter_one(deck *d, const deck_table *table, deck_group *g);
/* Begins to read the next entry of the top-level list that has the name of the table. *k: number of
 * entries read so far, 0 before the first call. Returns false at the end of the list, or if it is
 * not a list of groups (reported). */
bool deck_next(deck *d, const deck_table *table, size_t *k, deck_group *g);
/* Returns the list of groups that `parent` has under this key; NULL: no such key, or not a list
 * (reported). */
deck_node *deck_groups(deck *d, deck_node *parent, const char *key);

bool deck_given(const deck_group *g, const char *key); /* True if the user wrote the key */
/* Returns the node of a key; NULL: none */
deck_node *deck_get(const deck_group *g, const char *key);

bool deck_bool(deck_group *g, const char *key);
int64_t deck_integer(deck_group *g, const char *key);
/* Returns the value of a key as a number, angles in rad; NAN if the key is left out and has no
 * default, or if its value is wrong (reported). */
double deck_number(deck_group *g, const char *key);
/* Returns the value of a key as a text; NULL if the key is left out and has no default, or if its
 * value is wrong (reported). */
const char *deck_text_of(deck_group *g, const char *key);
/* Returns the enum value of the word that the deck gives for a key; -1: left out, or wrong
 * (reported). */
int deck_choice(deck_group *g, const char *key);
/* Reads two numbers, given as a list; false: left out, or wrong (reported) */
bool deck_pair(deck_group *g, const char *key, double pair[2]);

/* The functions deck_default_* add a key that was left out, with a default that depends on other
 * keys. They do nothing if the key is there. After deck_fill, deck_default_number also sets the
 * member of the key. */
void deck_default_bool(deck_group *g, const char *key, bool value);
void deck_default_integer(deck_group *g, const char *key, int64_t value);
void deck_default_number(deck_group *g, const char *key, double value);
void deck_default_text(deck_group *g, const char *key, const char *value);
void deck_default_pair(deck_group *g, const char *key, const double pair[2]);
deck_node *deck_default_list(deck_group *g, const char *key);

/* deck_each_count returns the number of elements of a list, deck_each returns element k. A value
 * that is not a list counts as a list of one element. */
size_t deck_each_count(const deck_node *node);
deck_node *deck_each(deck_node *node, size_t k);

/* Returns the kind (of wall, packing, motion, ...) that the deck gives for this key, after checking
 * that the group has the keys of that kind; NULL: left out, or wrong (reported). */
const deck_shape *deck_shape_of(deck_group *g, const char *key);
/* Returns true if a group of this kind may have the key. A key that no kind in chooser->words lists
 * is allowed for all kinds. chooser: the key that selects the kind. */
bool deck_reads(const deck_key *chooser, const deck_shape *kind, const char *key);
/* Returns which of the alternative keys of the table, such as mass and density, is given; NULL:
 * none, reported as "missing: expected ...". */
const char *deck_one_of(deck_group *g, const char *expected);
/* Reads all keys of the group that set a member of the struct `members`. Keys that select a kind
 * are read first; of the keys that kinds list, only those of the selected kind are read. The caller
 * must add defaults that depend on other keys before, except numbers. A key that is left out and
 * has no default leaves its member unchanged. Returns false if a kind is missing or wrong
 * (reported). */
bool deck_fill(deck_group *g, void *members);

/* Returns a hint if the word, which is no key of the table, is another program's name of such a
 * key; NULL: no hint. In deck_keys.c. */
const char *deck_other_word(deck *d, const deck_table *table, const char *word);
/* The same for a word that is no value of the choice. In deck_keys.c. */
const char *deck_other_value(deck *d, const deck_key *choice, const char *word);

/* Warns if a tilt written as a bare number exceeds a right angle: degrees may have been meant. */
void deck_warn_tilt(const deck *d, double tilt, deck_place place, sd_messages *messages);

/* Tables of all groups that a deck may have, with their keys.
 *
 * Unknown keys, ranges, defaults, the echo and docs/deck.md follow the rows of these tables
 * (model/keys.h); a test compares docs/deck.md with them in both directions. Tables whose keys set
 * members of the model are in model/keys.h; those below are for bodies, motions and sweeps. */

extern const deck_table deck_materials, deck_pairs, deck_disks, deck_disk_rows, deck_disk_files,
    deck_packings, deck_packing_clump, deck_clumps, deck_forces, deck_locks, deck_walls,
    deck_motions, deck_sweeps, deck_sweep_parameters;
extern const deck_table *const deck_tables[];
extern const size_t deck_table_count;

const char *deck_kind_text(deck_kind kind);
/* Returns true if the list contains the word; a list looks like "points* pivot" or
 * "mass/density". */
bool deck_listed(const char *list, const char *word);
/* Returns true if a group of the deck may have only one of these two keys, as mass and density. */
bool deck_keys_exclude(const char *a, const char *b);

/* Returns true if the keys of this name in all tables are of type bool (flag = true), or numbers or
 * lists of numbers (flag = false); false if no table has the key. */
bool deck_names_kind(const char *name, bool flag);

#endif
