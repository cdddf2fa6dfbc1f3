/* deck_parts.h: the last file of disks of a deck, if it is large enough to be read in parts. */
#ifndef SLIPDISK_IO_DECK_PARTS_H
#define SLIPDISK_IO_DECK_PARTS_H

#include "io/deck/deck_rows.h"

/* Collective, for a run on several ranks: each rank reads some of the disks of this entry of
 * disk_files into model->mine, and the disks are away (model->tiles). Returns false if the file
 * must be read as a whole. */
bool deck_parts_begin(deck *d, size_t entry);
/* Notes in model->tiles the checksum and bounds of the disks of such a file after it was read as
 * a whole. */
void deck_parts_note(deck *d, size_t entry, const deck_columns *table);
/* Collective. Reads contacts of that file, some on each rank, into model->mine, and adds up
 * their checksum. *lost: number of contacts whose partner is not in the model; *first: the wall
 * of the first of them. Returns false if contacts are damaged. */
bool deck_parts_contacts(deck *d, size_t *lost, uint32_t *first);
/* Computes the same checksum when all contacts are in this process. */
void deck_parts_note_contacts(deck *d, const struct deck_result *all);

#endif
