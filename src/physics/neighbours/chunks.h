/* chunks.h: divides the free disks into chunks of consecutive slots, and the chunks among the
 * threads. The step treats one chunk after the other, so that the data of a disk are still in the
 * cache when predictor, pair forces and corrector need them.
 *
 * The pairs of a chunk are those whose first disk (a) belongs to it, rounded to whole blocks. A
 * disk is complete, and can be corrected, once the pairs of its chunk have been evaluated: all its
 * other partners have smaller slots.
 */
#ifndef PHYSICS_CHUNKS_H
#define PHYSICS_CHUNKS_H

#include "physics/system/work.h"

/* Chunks begin at slots that are multiples of this number. */
enum { CHUNK_STEP = 8 };

/* Divides disks and pairs into chunks, from the present lists. Returns SD_ERROR_IO if memory runs
 * out. */
sd_status chunks_plan(engine *e);
void chunks_free(chunks *c);
/* Returns the chunk of the free disk in this slot. */
static inline size_t chunks_of_disk(const chunks *c, size_t slot) {
  return c->of_disks[slot / CHUNK_STEP];
}
/* Return the thread that evaluates this pair, and the thread that integrates this free disk. */
int chunks_thread_of_pair(const engine *e, size_t pair);
int chunks_thread_of_disk(const engine *e, size_t slot);
/* Marks the chunk of this disk as boundary_last: another thread evaluates some contacts of the
 * disk, so the chunk is corrected after all threads have evaluated theirs. */
static inline void chunks_put_off(chunks *c, size_t slot) {
  c->boundary_last[chunks_of_disk(c, slot)] = true;
}
/* Assigns rows of packed bodies and force sums to the chunks; call it after the last
 * chunks_put_off. A later chunk of the same thread takes over the rows of a chunk that no further
 * pair reads, so that they stay in the cache. Chunks whose rows other threads read or write keep
 * rows of their own. */
void chunks_plan_rows(chunks *c, size_t n_free);

#endif
