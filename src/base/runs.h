/* runs.h: merges several ascending sequences ("runs") of keys, by a binary heap of their current
 * keys.
 *
 *   runs_new(&r, n); for each run: runs_add(&r, run, its first key);
 *   while (r.n > 0) { run = runs_least(&r); ...; runs_step(&r, its next key) or runs_end(&r); }
 *
 * runs_free releases the heap.
 */
#ifndef SLIPDISK_BASE_RUNS_H
#define SLIPDISK_BASE_RUNS_H

#include <stddef.h>
#include <stdint.h>

typedef struct runs_head {
  int64_t key;
  size_t run;
} runs_head;

typedef struct runs {
  runs_head *heap;
  size_t n; /* number of sequences that have not ended */
} runs;

/* Creates an empty heap for up to n sequences. */
void runs_new(runs *r, size_t n);
void runs_free(runs *r);
void runs_add(runs *r, size_t run, int64_t key);
/* Returns the number of the sequence with the smallest current key; among equal keys the lowest
 * number. */
static inline size_t runs_least(const runs *r) { return r->heap[0].run; }
/* Both functions act on the sequence that runs_least returns: runs_step replaces its current key by
 * its next one, runs_end removes the sequence from the heap. */
void runs_step(runs *r, int64_t key);
void runs_end(runs *r);

#endif
