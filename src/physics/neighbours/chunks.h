/* chunks.h: free disks in chunks of neighbouring slots, which the step goes through one after the other, so that what
 * predictor, pairs and corrector want of a disk is still in the cache; and which thread goes through which.
 *
 * The pairs of a chunk are those whose first disk stands in it, to whole blocks. A disk is complete, and can be
 * corrected, when the pairs of its chunk are through: all its others stand before.
 */
#ifndef PHYSICS_CHUNKS_H
#define PHYSICS_CHUNKS_H

#include "physics/system/work.h"

/* Chunks begin at multiples of so many disks. */
enum { CHUNK_STEP = 8 };

/* From the present pairs. SD_ERROR_IO without memory. */
sd_status chunks_plan(engine *e);
void chunks_free(chunks *c);
/* In which chunk is this free disk? */
static inline size_t chunks_of_disk(const chunks *c, size_t slot) {
  return c->of_disks[slot / CHUNK_STEP];
}
/* Which thread takes this pair, and which this free disk. */
int chunks_thread_of_pair(const engine *e, size_t pair);
int chunks_thread_of_disk(const engine *e, size_t slot);
/* The disk has contacts in the share of another thread: its chunk is corrected when all are through. */
static inline void chunks_put_off(chunks *c, size_t slot) {
  c->boundary_last[chunks_of_disk(c, slot)] = true;
}
/* When nothing more is put off: rows of packed bodies and sums. Those of a chunk are taken over by a later one of the same thread once no pair wants
 * them, so that they need not leave the cache; what other threads read or push keeps its own. */
void chunks_plan_rows(chunks *c, size_t n_free);

#endif
