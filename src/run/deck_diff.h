/* deck_diff.h: compares two completed decks. The differences are listed in the message that refuses
 * to continue a run with another deck. */
#ifndef SLIPDISK_RUN_DECK_DIFF_H
#define SLIPDISK_RUN_DECK_DIFF_H

#include <stdbool.h>

#include "slipdisk/status.h"

/* Returns true if two completed decks are the same except for `checkpoint`, the interval between
 * checkpoints. */
bool deck_same(const char *before, const char *now);

/* Adds an error for each line that only one of the decks has, about 20 at most. */
void deck_diff(const char *before, const char *now, sd_messages *messages);

#endif
