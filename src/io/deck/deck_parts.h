/* deck_parts.h: the last file of disks of a deck, where it is large enough to be read in parts. */
#ifndef SLIPDISK_IO_DECK_PARTS_H
#define SLIPDISK_IO_DECK_PARTS_H

#include "io/deck/deck_rows.h"

/* For a run that ranks share: looks through this entry of disk_files, puts a sample of its disks into the model, and the rest into
 * model->tiles. False: it is to be read as a whole. */
bool deck_parts_begin(deck *d, size_t entry);
/* The same file, read as a whole: what it says of its disks is told in model->tiles, too. */
void deck_parts_note(deck *d, size_t entry, const deck_columns *table);
/* Its contacts, of the model whose file is read in parts: sums what they say, and tells how many have no partner in the model, and the
 * first such. False: there is something wrong with them. */
bool deck_parts_contacts(deck *d, size_t *lost, uint32_t *first);
/* The same sum, where all are here. */
void deck_parts_note_contacts(deck *d, const struct deck_result *all);
/* model_bears for all disks of the file. False: no, or it cannot be read again. */
bool deck_parts_bear(sd_model *model, sd_step_limit *limit);

#endif
