/* chunks.h: divides the free disks into chunks of consecutive slots, and the chunks among the
 * threads. The step treats one chunk after the other, so that the data of a disk are still in the
 * cache when predictor, pair forces and corrector need them.
 *
 * The pairs of a chunk are those whose first disk (a, in the lower slot) belongs to it, rounded to
 * whole blocks. Contacts in which a disk is the second one belong to lower slots, that is, to the
 * same chunk or earlier ones. So all forces on a disk are known, and it can be corrected, once the
 * pairs of its chunk have been evaluated.
 */
#ifndef PHYSICS_CHUNKS_H
#define PHYSICS_CHUNKS_H

#include "physics/system/work.h"

/* Chunks begin at slots that are multiples of this number. */
enum { CHUNK_STEP = 8 };

/* Divides disks and pairs into chunks, after a new list of pairs was built. Returns SD_ERROR_IO if
 * memory runs out. */
sd_status chunks_plan(engine *e);
void chunks_free(chunks *c);
/* Smallest distance of two chunks that take different steps of a window at the same time: one
 * handles the disks up to `reach` chunks further on, and contacts whose events are due are as far
 * behind. */
#define CHUNKS_APART(c) (2 * (c)->reach + 1)
/* Returns the chunk of the free disk in this slot. */
static inline size_t chunks_of_disk(const chunks *c, size_t slot) {
  return c->of_disks[slot / CHUNK_STEP];
}
/* chunks_thread_of_pair returns the thread that evaluates this pair, chunks_thread_of_disk the
 * thread that integrates the free disk in this slot. */
int chunks_thread_of_pair(const engine *e, size_t pair);
int chunks_thread_of_disk(const engine *e, size_t slot);
/* Marks the chunk of the disk in this slot as boundary_last. It is for a disk with contacts that
 * another thread evaluates: its chunk is corrected after all threads have evaluated their pairs. */
static inline void chunks_mark_boundary_last(chunks *c, size_t slot) {
  c->boundary_last[chunks_of_disk(c, slot)] = true;
}
/* Assigns rows in the tables of packed bodies (the data that pairs read of a body) and of force
 * sums to the chunks; call it after the last chunks_mark_boundary_last. When no further pair
 * reads the rows of a chunk, a later chunk of the same thread reuses them, so that they stay in
 * the cache. Chunks whose rows other threads read or write keep their rows. */
void chunks_plan_rows(chunks *c, size_t n_free);

#endif
