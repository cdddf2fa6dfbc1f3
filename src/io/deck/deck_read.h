/* deck_read.h: typed getters that follow the key tables.
 *
 * A getter reports what is wrong (type, range, missing) and then returns a harmless value, so that reading
 * goes on and finds the next mistake. Values that were left out are put into the tree with their default;
 * what deck_echo prints afterwards is complete.
 */
#ifndef SLIPDISK_IO_DECK_READ_H
#define SLIPDISK_IO_DECK_READ_H

#include "base/text.h"
#include "io/deck/deck_expression.h"
#include "io/deck/deck_keys.h"
#include "io/deck/deck_values.h"

/* A group that is being read, with the table of its keys. */
typedef struct deck_group {
  deck *d;
  deck_node *node;
  const deck_table *table;
} deck_group;

/* deck_fail_child of a group that is being read. */
void deck_fail_key(const deck_group *g, const char *key, const char *format, ...) SD_PRINTF(3, 4);

/* Begins to read a group: node must be one, and have no key outside the table. False: reported. */
bool deck_enter(deck *d, deck_node *node, const deck_table *table, deck_group *g);
/* The group that the table names, at the top of the deck, made empty when it is not there; false
 * when it is something else (reported). */
bool deck_enter_one(deck *d, const deck_table *table, deck_group *g);
/* Begins to read the entries of the list that the table names, at the top of the deck, one after
 * the other: *k is how many were met, 0 at first. False: there are no more, or it is no list of
 * groups (reported). */
bool deck_next(deck *d, const deck_table *table, size_t *k, deck_group *g);
/* The list of groups parent.key; NULL when there is none. */
deck_node *deck_groups(deck *d, deck_node *parent, const char *key);

bool deck_given(const deck_group *g, const char *key);     /* written by the user */
deck_node *deck_get(const deck_group *g, const char *key); /* NULL: not there */

bool deck_bool(deck_group *g, const char *key);
int64_t deck_integer(deck_group *g, const char *key);
double deck_number(deck_group *g,
                   const char *key); /* also angles; NAN when left out and without default */
const char *deck_text_of(deck_group *g,
                         const char *key);       /* NULL when left out and without default */
int deck_choice(deck_group *g, const char *key); /* value of the word; -1: left out, or reported */
bool deck_pair(deck_group *g, const char *key,
               double pair[2]); /* two numbers; false: left out, or reported */

/* Put a value in that was left out: for defaults that depend on other keys. No-ops when it is there. */
void deck_default_bool(deck_group *g, const char *key, bool value);
void deck_default_integer(deck_group *g, const char *key, int64_t value);
void deck_default_number(deck_group *g, const char *key, double value);
void deck_default_text(deck_group *g, const char *key, const char *value);
void deck_default_pair(deck_group *g, const char *key, const double pair[2]);
deck_node *deck_default_list(deck_group *g, const char *key);

/* The elements of a list, or the one value itself. */
size_t deck_each_count(const deck_node *node);
deck_node *deck_each(deck_node *node, size_t k);

/* The kind that the key chooses, the keys of the group checked against it; NULL: left out, or reported. */
const deck_shape *deck_shape_of(deck_group *g, const char *key);
/* Does this kind read the key? Keys that no kind names are read by all. */
bool deck_reads(const deck_key *chooser, const deck_shape *kind, const char *key);
/* Which of the table's alternatives is given; NULL: none, reported as "missing: expected ...". */
const char *deck_one_of(deck_group *g, const char *expected);
/* Reads all keys that set a member of the struct. Kinds are chosen first, and their own keys read only where the kind
 * has them. Defaults that depend on other keys are put in before. False: a kind is missing (reported). */
bool deck_fill(deck_group *g, void *members);

/* Hint for a key that the table lacks and another program has; NULL: none. deck_keys.c. */
const char *deck_other_word(deck *d, const deck_table *table, const char *word);

/* A tilt written as a number that is beyond a right angle: degrees may have been meant. */
void deck_warn_tilt(const deck *d, double tilt, deck_place place, sd_messages *messages);

#endif
