/* deck_expression.h: arithmetic in the texts of a deck, such as "2 * R", "1/3 pi" or "sqrt(3) *
 * R", with named constants. */
#ifndef SLIPDISK_IO_DECK_EXPRESSION_H
#define SLIPDISK_IO_DECK_EXPRESSION_H

#include "io/deck/deck_tree.h"

/* Names that an expression may contain: only pi and functions; also the deck's constants; or any
 * name, with value 1, to test whether a text is arithmetic at all. */
typedef enum deck_names { DECK_NAMES_NONE, DECK_NAMES_CONSTANTS, DECK_NAMES_ANY } deck_names;

/* Evaluates a text. angle: the units deg and rad are allowed, not only inside a function.
 * Returns NULL on success, else the reason in the arena, "" if it was reported already. */
const char *deck_expression(deck *d, const char *text, deck_names names, bool angle, double *x);
/* Evaluates a text without constants, units of angles allowed; returns false, without a message,
 * if it is not arithmetic. */
bool deck_arithmetic(deck *d, const char *text, double *x);
/* Reads a value of the deck as a number; false: reported. An integer becomes a float in the
 * tree, arithmetic stays a text. angle: the units deg and rad are allowed. */
bool deck_value_number(deck *d, deck_node *node, bool angle, double *x);
/* Returns the length of the number at p, 0 if there is none; *real: it has a point or an
 * exponent. */
size_t deck_number_length(const char *p, bool *real);

/* Reads the group `constants` and reports all mistakes in it. */
void deck_read_constants(deck *d);
/* Returns true if the deck has a constant of this name. */
bool deck_has_constant(deck *d, const char *name);

#endif
