/* deck_diff.h: which lines of two texts differ, for the message that refuses to continue another deck. */
#ifndef SLIPDISK_RUN_DECK_DIFF_H
#define SLIPDISK_RUN_DECK_DIFF_H

#include "slipdisk/status.h"

/* Adds one error per line that only one of the texts has, at most about 20. */
void deck_diff(const char *before, const char *now, sd_messages *messages);

#endif
