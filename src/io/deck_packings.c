/* deck_packings.c: disks from generators. See deck.h. */
#include "io/deck_read.h"

void deck_read_packings(deck *d) { (void)d; }
