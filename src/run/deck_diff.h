/* deck_diff.h: do two full decks say the same, and which lines differ, for the message that refuses to continue another deck. */
#ifndef SLIPDISK_RUN_DECK_DIFF_H
#define SLIPDISK_RUN_DECK_DIFF_H

#include <stdbool.h>

#include "slipdisk/status.h"

/* Two full decks are the same but for `checkpoint`, which only says how often a run is saved. */
bool deck_same(const char *before, const char *now);

/* Adds one error per line that only one of the texts has, at most about 20. */
void deck_diff(const char *before, const char *now, sd_messages *messages);

#endif
