/* buckets.c: implements buckets.h. */
#include "base/buckets.h"

#include <assert.h>
#include <stdbool.h>
#include <stdlib.h>

#include "base/memory.h"

bool buckets_new(buckets *b, size_t n, size_t n_buckets, bucket_of *of, const void *with) {
  size_t k;
  if (!memory_rows(2, (memory_column[]){{&b->start, n_buckets + 1, sizeof *b->start},
                                        {&b->item, n, sizeof *b->item}}))
    return false;
  for (size_t i = 0; i < n; i++)
    if ((k = of(with, i)) < n_buckets) b->start[k]++;
  for (k = 0; k < n_buckets; k++) b->start[k + 1] += b->start[k];
  /* start[k] is the end of bucket k here, and its begin when all its items are in place */
  for (size_t i = n; i-- > 0;)
    if ((k = of(with, i)) < n_buckets) b->item[--b->start[k]] = (uint32_t)i;
  return true;
}

void buckets_free(buckets *b) {
  free(b->start);
  free(b->item);
  *b = (buckets){0};
}

/* --- merging of ascending sequences ----------------------------------------------------------- */

void runs_new(runs *r, size_t n) { *r = (runs){.heap = memory_new(n, sizeof *r->heap)}; }

void runs_free(runs *r) {
  free(r->heap);
  *r = (runs){0};
}

static bool before(runs_head p, runs_head q) {
  return p.key < q.key || (p.key == q.key && p.run < q.run);
}

void runs_add(runs *r, size_t run, int64_t key) {
  const runs_head head = {key, run};
  size_t k = r->n++;
  for (; k > 0 && before(head, r->heap[(k - 1) / 2]); k = (k - 1) / 2)
    r->heap[k] = r->heap[(k - 1) / 2];
  r->heap[k] = head;
}

/* Inserts `head` at the root of the heap and moves it down until the heap is in order. */
static void sink(runs *r, runs_head head) {
  size_t k = 0, next;
  while ((next = 2 * k + 1) < r->n) {
    if (next + 1 < r->n && before(r->heap[next + 1], r->heap[next])) next++;
    if (!before(r->heap[next], head)) break;
    r->heap[k] = r->heap[next];
    k = next;
  }
  r->heap[k] = head;
}

void runs_step(runs *r, int64_t key) {
  assert(r->n > 0);
  sink(r, (runs_head){key, r->heap[0].run});
}

void runs_end(runs *r) {
  assert(r->n > 0);
  r->n--;
  if (r->n > 0) sink(r, r->heap[r->n]);
}
