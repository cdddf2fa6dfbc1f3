/* runs.h: several ascending runs of keys, read as one: a binary heap of their heads.
 *
 *   runs_new(&r, n); for each run: runs_add(&r, run, its first key);
 *   while (r.n > 0) { run = runs_least(&r); ...; runs_step(&r, its next key) or runs_end(&r); }
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
  size_t n; /* runs that have not ended */
} runs;

/* Makes room for n runs. */
void runs_new(runs *r, size_t n);
void runs_free(runs *r);
void runs_add(runs *r, size_t run, int64_t key);
/* The run with the least key; of equal ones the lowest run. */
static inline size_t runs_least(const runs *r) { return r->heap[0].run; }
/* That run goes on with this key, or is over. */
void runs_step(runs *r, int64_t key);
void runs_end(runs *r);

#endif
