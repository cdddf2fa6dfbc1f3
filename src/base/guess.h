/* guess.h: the nearest of some words to one that was mistyped, by edit distance. */
#ifndef SLIPDISK_BASE_GUESS_H
#define SLIPDISK_BASE_GUESS_H

#include <stddef.h>

/* best: NULL when no candidate is near enough to be meant. */
typedef struct guess {
  const char *word, *best;
  size_t distance;
} guess;

guess guess_start(const char *word);
void guess_add(guess *g, const char *candidate); /* NULL: none */

#endif
