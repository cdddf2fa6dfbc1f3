/* deck_bounds.c: where the disks belong. See deck.h. */
#include "io/deck_read.h"

void deck_read_bounds(deck *d) { (void)d; }
