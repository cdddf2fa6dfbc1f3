/* keys.h: tables of the keys of an input deck. A row describes one key: name, type, range, unit,
 * default, allowed words, meaning, and the member of the model that it sets.
 *
 * The defaults of a new model, the checks of a finished one, the deck reader, its output of the
 * completed deck and docs/deck.md all follow from these rows. Rows that set members of the model
 * are in src/model (keys.c, laws.h), rows that only decks have in io/deck/deck_keys.c.
 * tools/deck_docs.py updates docs/deck.md.
 */
#ifndef SLIPDISK_MODEL_KEYS_H
#define SLIPDISK_MODEL_KEYS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "slipdisk/status.h"

typedef enum deck_kind {
  DECK_KEY_BOOL,
  DECK_KEY_INTEGER,
  DECK_KEY_NUMBER,
  DECK_KEY_ANGLE, /* number in radians, or text like "0.04 pi", "7.2 deg" */
  DECK_KEY_TEXT,
  DECK_KEY_CHOICE,
  DECK_KEY_NUMBERS,     /* list of numbers */
  DECK_KEY_POINTS,      /* list of (x, y) */
  DECK_KEY_NAMES,       /* one text or a list of them */
  DECK_KEY_BODIES,      /* one body, by name or number, or a list of bodies */
  DECK_KEY_COORDINATES, /* one of "x", "y", "theta", or a list of them */
  DECK_KEY_ROWS,        /* table of values: a list of rows, each of them a list */
  DECK_KEY_VALUES,      /* list of values of any kind */
  DECK_KEY_GROUP,       /* one group of keys: { ... } */
  DECK_KEY_GROUPS       /* list of groups */
} deck_kind;

typedef enum deck_range {
  DECK_ANY,
  DECK_POSITIVE,
  DECK_NOT_NEGATIVE,
  DECK_AT_LEAST_1,
  DECK_UP_TO_1
} deck_range;

/* A word that a key accepts as its value. If the word is a kind (of wall, packing, motion, law),
 * `keys` lists the keys that this kind reads besides those that all kinds have: a key marked *
 * must be given; of keys joined by / one may be given, exactly one if marked *. A list of words
 * ends with the name NULL. */
typedef struct deck_shape {
  const char *name;
  int kind; /* value of the enum for which the word stands */
  const char *keys;
  const char *meaning;
} deck_shape;

/* Type of the struct member that a key sets. */
typedef enum deck_target {
  DECK_SETS_NOTHING, /* no member: special code reads the key */
  DECK_SETS_NUMBER,
  DECK_SETS_PAIR, /* two numbers: double [2] */
  DECK_SETS_INTEGER,
  DECK_SETS_UNSIGNED, /* unsigned integer: uint64_t */
  DECK_SETS_BOOL,
  DECK_SETS_OFF, /* bool that stores the opposite of the key */
  DECK_SETS_TEXT,
  DECK_SETS_ENUM
} deck_target;

/* A key of the input deck. `initial` is its default as written in a deck; "required" if the key
 * must be given; "-" if it is absent unless given; or "(words)" if the default depends on other
 * keys. */
typedef struct deck_key {
  const char *name;
  deck_kind kind;
  deck_range range;
  const char *unit;
  const char *initial;
  const deck_shape *words; /* accepted words of a choice; else NULL */
  const char *meaning;
  size_t offset; /* offset of the member in its struct; its type (the macro SETS gives both) */
  deck_target target;
  const char *member; /* name of the member; NULL: the key sets none */
} deck_key;

typedef struct deck_table {
  const char *name; /* name of the group in the deck, like "motions", "measure.sliding" */
  const char *meaning;
  bool one; /* true: one group { }; false: a list of groups */
  size_t n;
  const deck_key *key;
  const char *either;            /* mutually exclusive keys: "mass/density"; NULL: none */
  const struct deck_table *more; /* another table whose keys are appended to this one; NULL: none */
} deck_table;

/* Tables of deck keys that set members of the model. */
extern const deck_table deck_top, deck_gravity, deck_box, deck_bounds, deck_limits, deck_phases,
    deck_settle, deck_compress, deck_cell, deck_bond, deck_output, deck_measure, deck_sliding,
    deck_until;

/* --- macros for rows: {name, type, default, words, meaning, member} --------------------------- */

#define COUNT(a) (sizeof(a) / sizeof *(a))
#define KEY_TYPE(type, r, u) .kind = type, .range = r, .unit = u
#define BOOL KEY_TYPE(DECK_KEY_BOOL, DECK_ANY, "-")
#define TEXT KEY_TYPE(DECK_KEY_TEXT, DECK_ANY, "-")
#define NAMES KEY_TYPE(DECK_KEY_NAMES, DECK_ANY, "-")
#define BODIES KEY_TYPE(DECK_KEY_BODIES, DECK_ANY, "-")
#define COORDINATES KEY_TYPE(DECK_KEY_COORDINATES, DECK_ANY, "-")
#define CHOICE KEY_TYPE(DECK_KEY_CHOICE, DECK_ANY, "-")
#define GROUP KEY_TYPE(DECK_KEY_GROUP, DECK_ANY, "-")
#define GROUPS KEY_TYPE(DECK_KEY_GROUPS, DECK_ANY, "-")
#define NUMBER(range, unit) KEY_TYPE(DECK_KEY_NUMBER, range, unit)
#define ANGLE(unit) KEY_TYPE(DECK_KEY_ANGLE, DECK_ANY, unit)
#define INTEGER(range, unit) KEY_TYPE(DECK_KEY_INTEGER, range, unit)
#define NUMBERS(range, unit) KEY_TYPE(DECK_KEY_NUMBERS, range, unit)
#define POINTS KEY_TYPE(DECK_KEY_POINTS, DECK_ANY, "length")
#define ROWS KEY_TYPE(DECK_KEY_ROWS, DECK_ANY, "-")
#define VALUES KEY_TYPE(DECK_KEY_VALUES, DECK_ANY, "-")
#define TABLE(id, name, one, meaning, keys) TABLE_EITHER(id, name, one, meaning, keys, NULL)
#define TABLE_EITHER(id, name, one, meaning, keys, either)                                         \
  const deck_table id = {name, meaning, one, COUNT(keys), keys, either, NULL}
#define TABLE_WITH(id, name, one, meaning, keys, more)                                             \
  const deck_table id = {name, meaning, one, COUNT(keys), keys, NULL, &(more)}
#define WORD(name, value)                                                                          \
  { name, value, NULL, NULL }
#define LAST_WORD                                                                                  \
  { NULL, 0, NULL, NULL }

#define SETS(type, member)                                                                         \
  offsetof(type, member),                           \
      _Generic(((type *)NULL)->member,              \
               double: DECK_SETS_NUMBER,            \
               double *: DECK_SETS_PAIR,            \
               int64_t: DECK_SETS_INTEGER,          \
               uint64_t: DECK_SETS_UNSIGNED,         \
               bool: DECK_SETS_BOOL,                \
               char *: DECK_SETS_TEXT,              \
               const char *: DECK_SETS_TEXT,        \
               default: DECK_SETS_ENUM), #member

#define SETS_OFF(type, member) offsetof(type, member), DECK_SETS_OFF, #member

/* --- functions of rows ------------------------------------------------------------------------ */

/* Returns the key at index k of a table, counting on into the tables appended to it; NULL: k is
 * beyond the last. */
const deck_key *deck_key_at(const deck_table *table, size_t k);
/* Returns the key with this name; NULL: the table has no such key. */
const deck_key *deck_key_find(const deck_table *table, const char *name);
/* Returns the range as text for messages, like "> 0"; "" for any number. */
const char *deck_range_text(deck_range range);
/* True if x lies in the range and its magnitude within [1/LIMIT_NUMBER, LIMIT_NUMBER]; 0 is
 * allowed if the range includes it. */
bool deck_in_range(deck_range range, double x);
/* Returns the expected range as text, for a message about a value x outside the range. The text
 * gives the limits of magnitude if x is too large or too small. */
const char *deck_expected(deck_range range, double x);

/* Returns the member that the key sets as a number: a flag is 0 or 1 and a choice the value of its
 * enumerator. The key must set one number (not a pair or a text). */
double deck_key_value(const deck_key *key, const void *members);
/* Sets the member to a number that means the same as in deck_key_value. Returns false, without a
 * change, if the member cannot hold it: no whole number, no value of a word, a pair or a text. */
bool deck_key_store(const deck_key *key, void *members, double value);
/* Sets the members of a new struct to the defaults of the keys in a table, if these are plain
 * values. */
void deck_key_defaults(const deck_table *table, void *members);
/* Reports an error for each member of the wrong sign, as "place.key = value"; place: name of the
 * group in the deck. A 0 is accepted for keys that may be absent and have no default. */
void deck_key_check(const deck_table *table, const void *members, const char *place,
                    sd_messages *messages);

#endif
