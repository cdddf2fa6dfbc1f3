/* rows.h: what follows from a list of pairs: contacts of each body, where pairs see bodies and add their forces, shares of
 * threads.
 */
#ifndef PHYSICS_ROWS_H
#define PHYSICS_ROWS_H

#include "physics/system/work.h"

/* Incidence, rows and shares of the present pairs. */
sd_status pairs_list(engine *e);
void pairs_list_free(engine *e);
/* Before forces are added: nothing acts on any body. */
void pairs_clear_sums(engine *e);
/* The same but for the rows of free disks, which are cleared when they are seated. */
void pairs_clear_single(engine *e);
/* Of the listed bodies in slots [begin, end): adds up what stands one by one, in the order of the pairs; of prescribed ones of
 * all ranks. */
void sums_add_listed(const engine *e, size_t begin, size_t end);

#endif
