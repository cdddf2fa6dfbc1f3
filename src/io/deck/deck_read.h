/* deck_read.h: typed getters that follow the key tables.
 *
 * A getter reports a mistake (type, range, missing) and then returns a harmless value, so that
 * reading goes on and finds the next mistake. Values that were left out are put into the tree
 * with their default, so that deck_echo prints a complete deck afterwards. */
#ifndef SLIPDISK_IO_DECK_READ_H
#define SLIPDISK_IO_DECK_READ_H

#include "base/text.h"
#include "io/deck/deck_expression.h"
#include "io/deck/deck_values.h"
#include "model/keys.h"
#include "model/model.h"

/* A group that is being read, with the table of its keys. */
typedef struct deck_group {
  deck *d;
  deck_node *node;
  const deck_table *table;
} deck_group;

/* Reports an error about a key of the group, as deck_fail_child does. */
void deck_fail_key(const deck_group *g, const char *key, const char *format, ...) SD_PRINTF(3, 4);

/* Begins to read a group. Returns false if node is not a group (reported); reports keys that the
 * table lacks. */
bool deck_enter(deck *d, deck_node *node, const deck_table *table, deck_group *g);
/* Begins to read the top-level group that the table names, which is added empty if missing;
 * false if it is not a group (reported). */
bool deck_enter_one(deck *d, const deck_table *table, deck_group *g);
/* Begins to read the next entry of the top-level list that the table names. *k counts the
 * entries so far; set it to 0 before the first call. Returns false at the end, or if it is not a
 * list of groups (reported). */
bool deck_next(deck *d, const deck_table *table, size_t *k, deck_group *g);
/* Returns the list of groups parent.key; NULL if it is missing or not a list (reported). */
deck_node *deck_groups(deck *d, deck_node *parent, const char *key);

bool deck_given(const deck_group *g, const char *key);     /* True if the user wrote the key */
deck_node *deck_get(const deck_group *g, const char *key); /* NULL: not there */

bool deck_bool(deck_group *g, const char *key);
int64_t deck_integer(deck_group *g, const char *key);
/* Returns a number, or an angle in rad; NAN if it is left out without default, or wrong. */
double deck_number(deck_group *g, const char *key);
/* Returns a text; NULL if it is left out without default, or wrong. */
const char *deck_text_of(deck_group *g, const char *key);
/* Returns the value of the word that a choice names; -1: left out, or wrong (reported). */
int deck_choice(deck_group *g, const char *key);
/* Reads two numbers; false: left out, or wrong (reported) */
bool deck_pair(deck_group *g, const char *key, double pair[2]);

/* Put a value in for a key that was left out: for defaults that depend on other keys. They do
 * nothing if the key is there. */
void deck_default_bool(deck_group *g, const char *key, bool value);
void deck_default_integer(deck_group *g, const char *key, int64_t value);
void deck_default_number(deck_group *g, const char *key, double value);
void deck_default_text(deck_group *g, const char *key, const char *value);
void deck_default_pair(deck_group *g, const char *key, const double pair[2]);
deck_node *deck_default_list(deck_group *g, const char *key);

/* Give access to the elements of a list; a value that is not a list counts as its own single
 * element. */
size_t deck_each_count(const deck_node *node);
deck_node *deck_each(deck_node *node, size_t k);

/* Returns the kind that the key chooses, after checking the keys of the group against it; NULL:
 * left out, or wrong (reported). */
const deck_shape *deck_shape_of(deck_group *g, const char *key);
/* Returns true if this kind reads the key. All kinds read keys that no kind names. */
bool deck_reads(const deck_key *chooser, const deck_shape *kind, const char *key);
/* Returns the alternative of the table that is given; NULL: none, reported as "missing: expected
 * ...". */
const char *deck_one_of(deck_group *g, const char *expected);
/* Reads all keys that set a member of the struct `members`. Kinds are chosen first; a key that
 * kinds name is read only if the chosen kind has it. Callers put in defaults that depend on
 * other keys before. Returns false if a kind is missing or wrong (reported). */
bool deck_fill(deck_group *g, void *members);

/* Returns a hint for a word that the table lacks and another program uses as a key; NULL: none.
 * In deck_keys.c. */
const char *deck_other_word(deck *d, const deck_table *table, const char *word);

/* Warns if a tilt written as a bare number exceeds a right angle: degrees may have been meant. */
void deck_warn_tilt(const deck *d, double tilt, deck_place place, sd_messages *messages);

/* All groups that a deck may have, with their keys.
 *
 * Unknown keys, ranges, defaults, the echo and docs/deck.md follow the rows (model/keys.h); a
 * test compares docs/deck.md with them in both directions. Groups that set members of the model
 * are in model/keys.h; the groups here are those of bodies, motions and sweeps. */

extern const deck_table deck_materials, deck_pairs, deck_container, deck_disks, deck_disk_rows,
    deck_disk_files, deck_packings, deck_packing_clump, deck_clumps, deck_forces, deck_locks,
    deck_walls, deck_motions, deck_sweeps, deck_sweep_parameters;
extern const deck_table *const deck_tables[];
extern const size_t deck_table_count;

enum { DECK_MOTION_FIXED = SD_MOTION_KINDS };
extern const deck_shape deck_motion_kinds[];

const char *deck_kind_text(deck_kind kind);
/* Returns true if the word is in a list such as "points* pivot" or "mass/density". */
bool deck_listed(const char *list, const char *word);
/* Returns true if some group allows only one of these two keys. */
bool deck_keys_exclude(const char *a, const char *b);

/* Returns true if every key of this name, in any group, is a flag; with flag = false: if every
 * one is a number or a list of numbers. */
bool deck_names_kind(const char *name, bool flag);

#endif
