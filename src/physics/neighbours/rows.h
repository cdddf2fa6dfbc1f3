/* rows.h: tables that follow from a list of pairs: the contacts of each body, the rows in which
 * pairs read bodies and add forces, and the division among threads.
 */
#ifndef PHYSICS_ROWS_H
#define PHYSICS_ROWS_H

#include "physics/system/work.h"

/* Builds incidence lists, chunks, and rows of packed bodies and force sums for the present pairs.
 * Returns SD_ERROR_IO if memory runs out. */
sd_status pairs_list(engine *e);
void pairs_list_free(engine *e);
/* Sets the force sums of all bodies to zero, before forces are added. */
void pairs_clear_sums(engine *e);
/* Does the same except for the rows of free disks, which are cleared when the disks are packed. */
void pairs_clear_single(engine *e);
/* Adds up the forces of single contacts on each listed body in slots [begin, end), in the order of
 * pairs; for prescribed bodies those of the contacts on all ranks. */
void sums_add_listed(const engine *e, size_t begin, size_t end);

#endif
