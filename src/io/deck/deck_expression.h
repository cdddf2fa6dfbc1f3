/* deck_expression.h: arithmetic in the texts of a deck, such as "2 * R", "1/3 pi" or "sqrt(3) *
 * R", with named constants. */
#ifndef SLIPDISK_IO_DECK_EXPRESSION_H
#define SLIPDISK_IO_DECK_EXPRESSION_H

#include "io/deck/deck_tree.h"

/* Names that an expression may contain. NONE: only pi and functions; CONSTANTS: also the deck's
 * constants; ANY: any name, with value 1, to test whether a text is arithmetic at all. */
typedef enum deck_names { DECK_NAMES_NONE, DECK_NAMES_CONSTANTS, DECK_NAMES_ANY } deck_names;

/* Evaluates a text. angle: the units deg and rad are allowed everywhere, not only inside a
 * function. Returns NULL on success, else an error message in the arena, "" if the error was
 * reported already. */
const char *deck_expression(deck *d, const char *text, deck_names names, bool angle, double *x);
/* Gives a value to a name at the beginning of `text` that is no constant and no function. rate:
 * true inside of rate( ). Returns the number of bytes that the name takes, 0: no such name; *wrong:
 * receives an error message, if the name is one. */
typedef size_t deck_lookup(void *user, const char *text, bool rate, double *x, const char **wrong);
/* Evaluates a text with the deck's constants, the names that `lookup` knows, and rate(SUM), which
 * is per_rate times SUM. Returns NULL on success, else an error message (see deck_expression). */
const char *deck_expression_with(deck *d, const char *text, deck_lookup *lookup, void *user,
                                 double per_rate, double *x);
/* Reads a text like deck_expression_with, with value 1 for names that `lookup` does not know and
 * without a check of values, to find the names in it. Returns NULL, or an error of its form. */
const char *deck_expression_names(deck *d, const char *text, deck_lookup *lookup, void *user);
/* Evaluates a text in which units of angles, but no constants, are allowed. Returns false, without
 * a message, if the text is not arithmetic. */
bool deck_arithmetic(deck *d, const char *text, double *x);
/* Reads a value of the deck as a number. Returns false after an error, which is reported. An
 * integer in the tree becomes a float; an arithmetic text stays a text. angle: the units deg and
 * rad are allowed. */
bool deck_value_number(deck *d, deck_node *node, bool angle, double *x);
/* Returns the length in bytes of the number at p, 0 if there is none. *real: set to true if the
 * number has a point or an exponent. */
size_t deck_number_length(const char *p, bool *real);

/* Reads the group `constants` and reports all mistakes in it. */
void deck_read_constants(deck *d);
/* Reports constants that only a setting (-D) has and that no expression has used so far. */
void deck_check_constants(deck *d);
/* Returns true if the deck has a constant of this name. */
bool deck_has_constant(deck *d, const char *name);

#endif
