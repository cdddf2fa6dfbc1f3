/* deck_container.c: the group `container`: a box, a bed, a hopper or a drum, made of walls. See deck.h. */
#include "io/deck_read.h"

void deck_read_container(deck *d) { (void)d; }
void deck_container_walls(deck *d) { (void)d; }
