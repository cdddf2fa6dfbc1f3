/* buckets.h: sorts items by bucket (cell of a grid, clump, group, rank) with a counting sort, and
 * merges ascending sequences of keys. */
#ifndef SLIPDISK_BASE_BUCKETS_H
#define SLIPDISK_BASE_BUCKETS_H

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/math.h"

/* Items 0 to n - 1 sorted by bucket; those of one bucket ascend. */
typedef struct buckets {
  uint32_t *start; /* [number of buckets + 1] index in `item` of each bucket's first item */
  uint32_t *item;
} buckets;

/* Returns the bucket of an item; an item whose bucket does not exist is left out. */
typedef size_t bucket_of(const void *with, size_t item);

/* Sorts n items into n_buckets buckets; calls `of` twice for each item. Returns false if memory
 * runs out; *b is empty then. Free it with buckets_free. */
bool buckets_new(buckets *b, size_t n, size_t n_buckets, bucket_of *of, const void *with);
void buckets_free(buckets *b);

/* Returns the index, along a line of n grid cells, of the cell at x, or of the cell nearest to x if
 * x is outside the grid. x: distance from the lower end of the grid, in cell widths. */
static inline size_t cell_nearest(double x, size_t n) {
  return x > 0.0 ? (size_t)math_min(x, (double)(n - 1)) : 0;
}

/* Merges several ascending sequences ("runs") of keys, by a binary heap of their current
 * keys.
 *
 *   runs_new(&r, n); for each run: runs_add(&r, run, its first key);
 *   while (r.n > 0) { run = runs_least(&r); ...; runs_step(&r, its next key) or runs_end(&r); }
 *
 * runs_free releases the heap.
 */

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
