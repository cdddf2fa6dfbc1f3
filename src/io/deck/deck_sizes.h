/* deck_sizes.h: the radii of a packing, as its entry of the deck gives them. */
#ifndef SLIPDISK_IO_DECK_SIZES_H
#define SLIPDISK_IO_DECK_SIZES_H

#include "io/deck/deck_read.h"
#include "pack/sizes.h"

/* Completes a distribution whose keys are read: its limits, and the radii and weights of a list. Reports what is wrong. */
void deck_finish_sizes(deck_group *g, sizes *s);

#endif
