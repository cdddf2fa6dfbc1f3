/* deck_parts.h: the last file of disks of a deck, where it is large enough to be read in parts. */
#ifndef SLIPDISK_IO_DECK_PARTS_H
#define SLIPDISK_IO_DECK_PARTS_H

#include "io/deck/deck_rows.h"

/* Collective, of a run that ranks share: each rank reads some of the disks of this entry of
 * disk_files into model->mine, and they are away (model->tiles). False: it is to be read as a
 * whole. */
bool deck_parts_begin(deck *d, size_t entry);
/* The same file, read as a whole: what it says of its disks is told in model->tiles, too. */
void deck_parts_note(deck *d, size_t entry, const deck_columns *table);
/* Collective. Contacts of that file, of which each rank reads some into model->mine: sums what they
 * say, and tells how many have no partner in the model, and the wall of the first such. False:
 * there is something wrong with them. */
bool deck_parts_contacts(deck *d, size_t *lost, uint32_t *first);
/* The same sum, where all are here. */
void deck_parts_note_contacts(deck *d, const struct deck_result *all);

#endif
