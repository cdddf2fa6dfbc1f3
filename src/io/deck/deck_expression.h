/* deck_expression.h: arithmetic in the texts of a deck: "2 * R", "1/3 pi", "sqrt(3) * R", with its named constants. */
#ifndef SLIPDISK_IO_DECK_EXPRESSION_H
#define SLIPDISK_IO_DECK_EXPRESSION_H

#include "io/deck/deck_tree.h"

/* Names in an expression: pi and functions only; the deck's constants too; or any, which stand for 1: is it arithmetic
 * at all? */
typedef enum deck_names { DECK_NAMES_NONE, DECK_NAMES_CONSTANTS, DECK_NAMES_ANY } deck_names;

/* The value of a text. angle: deg and rad may stand in it, not only inside a function. NULL: good; else why not, in the
 * arena, "" when that was reported before. */
const char *deck_expression(deck *d, const char *text, deck_names names, bool angle, double *x);
/* The same without words. */
bool deck_arithmetic(deck *d, const char *text, double *x);
/* A value of the deck as a number; an integer turns into a float in the tree, arithmetic stays a text. angle: deg and rad may
 * stand in it. */
bool deck_value_number(deck *d, deck_node *node, bool angle, double *x);
/* Length of the number at p, 0 when it is none; *real: it has a point or an exponent. */
size_t deck_number_length(const char *p, bool *real);

/* Reads the group `constants`; all mistakes in it are reported. */
void deck_read_constants(deck *d);
/* Has the deck a constant of this name? */
bool deck_has_constant(deck *d, const char *name);

#endif
