/* chunks.c: divides disks and pairs into chunks and gives them rows; implements chunks.h. */
#include "physics/system/halo.h"
#include "physics/neighbours/chunks.h"
#include "physics/contact/pairs.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"

/* Largest and smallest number of disks in a chunk, and number of chunks per thread. Chunks of this
 * size fit into the cache; each thread has several, so that few of its chunks must wait for other
 * threads. */
enum { CHUNK_MOST = 512, CHUNK_LEAST = 256, CHUNKS_PER_THREAD = 8 };

/* Windows (step/window.c): smallest number of free disks, most steps, and number of disks whose
 * data stay in the cache (8 MB). */
enum { WINDOW_LEAST = 20000, WINDOW_MOST = 16, WINDOW_DISKS = 16384 };

/* Computing costs of a pair with a wall segment, and of a disk without contacts, in units of the
 * cost of a pair of round bodies. */
enum { SEGMENT_COST = 4, DISK_COST = 1 };

static size_t rounded(size_t n) { return (n + CHUNK_STEP - 1) / CHUNK_STEP * CHUNK_STEP; }

/* The environment variable SLIPDISK_CHUNK sets the disks per chunk, and lets systems of four chunks
 * take windows, so that small systems try all that large ones do. 0: it is not set. */
static size_t asked_size(void) {
  const char *text = getenv("SLIPDISK_CHUNK");
  const unsigned long n = text ? strtoul(text, NULL, 10) : 0;
  return n && n <= CHUNK_MOST ? rounded(n) : 0;
}

/* Returns the number of disks per chunk for n disks per thread, a multiple of CHUNK_STEP. The last
 * chunk of a thread may have fewer disks. */
static size_t chunk_size(size_t n) {
  const size_t asked = asked_size();
  if (asked) return asked;
  size_t size = (n + CHUNKS_PER_THREAD - 1) / CHUNKS_PER_THREAD;
  if (size > CHUNK_MOST) size = CHUNK_MOST;
  if (size < CHUNK_LEAST) size = CHUNK_LEAST;
  size = rounded(size);
  assert(size >= CHUNK_STEP && size % CHUNK_STEP == 0);
  return size;
}

void chunks_free(chunks *c) {
  free(c->begin);
  free(c->of_disks);
  free(c->pair);
  free(c->segment);
  free(c->need_start);
  free(c->need);
  free(c->row);
  free(c->predicted);
  free(c->packed);
  free(c->boundary_first);
  free(c->boundary_last);
  *c = (chunks){0};
}

static sd_status reserve(chunks *c, size_t count, size_t n_free) {
  if (count <= c->capacity) return SD_OK;
  chunks_free(c);
  if (!memory_rows(10,
                   (memory_column[]){{&c->begin, count + 1, sizeof *c->begin},
                                     {&c->of_disks, n_free / CHUNK_STEP + 1, sizeof *c->of_disks},
                                     {&c->pair, count + 1, sizeof *c->pair},
                                     {&c->segment, count + 1, sizeof *c->segment},
                                     {&c->need_start, count + 1, sizeof *c->need_start},
                                     {&c->row, count, sizeof *c->row},
                                     {&c->predicted, count, sizeof *c->predicted},
                                     {&c->packed, count, sizeof *c->packed},
                                     {&c->boundary_first, count, sizeof *c->boundary_first},
                                     {&c->boundary_last, count, sizeof *c->boundary_last}}))
    return SD_ERROR_IO;
  c->capacity = count;
  return SD_OK;
}

/* Finds the first pair of each chunk, in the list of pairs of round bodies (rounded up to a whole
 * block) and in the list of pairs with wall segments. Pairs with ghosts belong to no chunk. */
static void find_pairs(chunks *c, const pairs *p) {
  for (size_t n = 0; n <= c->count; n++) {
    const size_t k = n < c->count ? pairs_from(p, 0, p->n_round, c->begin[n]) : p->n_round;
    const size_t whole = (k + PAIR_BLOCK - 1) / PAIR_BLOCK * PAIR_BLOCK;
    c->pair[n] = whole < p->first_ghost ? whole : p->first_ghost;
    c->segment[n] =
        n < c->count ? pairs_from(p, p->first_segment, p->count, c->begin[n]) : p->count;
    assert(c->pair[n] % PAIR_BLOCK == 0 && (n == 0 || c->pair[n - 1] <= c->pair[n]));
    assert(n == 0 || c->segment[n - 1] <= c->segment[n]);
  }
}

/* For each chunk of one thread, the chunks whose disks its pairs read, the chunk itself included.
 * Each thread fills one such list. */
typedef struct needs_share {
  uint32_t *need;
  size_t n, capacity;
} needs_share;

typedef struct needs_task {
  chunks *c;
  const pairs *p;
  size_t n_free;
  needs_share share[WORK_MAX_THREADS];
} needs_task;

static void add_need(needs_share *l, size_t chunk) {
  if (l->n == l->capacity) {
    l->capacity = 2 * l->capacity + 64;
    l->need = memory_grow(l->need, l->capacity, sizeof *l->need);
  }
  l->need[l->n++] = (uint32_t)chunk;
}

/* Adds to `mine` the chunks whose disks the pairs of chunk k read. found_for[j] is the last chunk
 * to whose list chunk j was added, so that j is not added twice to one list. */
static void find_needs_of(const needs_task *f, size_t k, size_t *found_for, needs_share *mine) {
  const chunks *c = f->c;
  const pairs *p = f->p;
  found_for[k] = k;
  add_need(mine, k);
  for (size_t at = c->pair[k]; at < c->pair[k + 1]; at++)
    for (int side = 0; side < 2; side++) {
      const int32_t slot = side ? p->b[at] : p->a[at];
      if (slot < 0 || (size_t)slot >= f->n_free) continue;
      const size_t seen = chunks_of_disk(c, (size_t)slot);
      if (found_for[seen] == k) continue;
      found_for[seen] = k;
      add_need(mine, seen);
    }
}

/* Finds which chunks the pairs of this thread's chunks read. At first need_start[k] is an index
 * into this thread's own list; join_needs then adds the number of entries of the threads before. */
static void needs_together(const team *t, void *with) {
  needs_task *f = with;
  const chunks *c = f->c;
  needs_share *mine = &f->share[t->rank];
  const size_t size = (size_t)t->size, rank = (size_t)t->rank;
  size_t *found_for = memory_new(c->count, sizeof *found_for);
  for (size_t k = 0; k < c->count; k++) found_for[k] = SIZE_MAX;
  for (size_t k = c->count * rank / size; k < c->count * (rank + 1) / size; k++) {
    c->need_start[k] = mine->n;
    find_needs_of(f, k, found_for, mine);
    assert(mine->need[c->need_start[k]] == k);
  }
  free(found_for);
}

/* Joins the lists of all threads. Each chunk's entries begin with the chunk itself; this shows
 * which thread's list they are in. */
static void join_needs(needs_task *f) {
  chunks *c = f->c;
  size_t n = 0, k = 0;
  for (size_t t = 0; t < WORK_MAX_THREADS; t++) n += f->share[t].n;
  if (n > c->need_capacity) {
    c->need_capacity = n + n / 2;
    c->need = memory_grow(c->need, c->need_capacity, sizeof *c->need);
  }
  n = 0;
  for (size_t t = 0; t < WORK_MAX_THREADS; t++) {
    const needs_share *l = &f->share[t];
    if (l->n) memcpy(c->need + n, l->need, l->n * sizeof *l->need);
    for (; k < c->count && c->need_start[k] < l->n && l->need[c->need_start[k]] == k; k++)
      c->need_start[k] += n;
    n += l->n;
  }
  assert(k == c->count);
  c->need_start[c->count] = n;
}

static void find_needs(const engine *e, chunks *c) {
  needs_task f = {.c = c, .p = &e->work.pairs, .n_free = e->state->n_free};
  pool_run(work_pool(e), needs_together, &f);
  join_needs(&f);
  for (size_t t = 0; t < WORK_MAX_THREADS; t++) free(f.share[t].need);
}

static int thread_of_chunk(const chunks *c, size_t k) {
  assert(k < c->count);
  int t = 0;
  while (k >= c->share[t + 1]) t++;
  return t;
}

static void find_boundary_first(chunks *c, int threads) {
  memset(c->boundary_first, 0, c->count);
  memset(c->boundary_last, 0, c->count);
  c->any_boundary_first = false;
  for (int t = 0; t < threads; t++)
    for (size_t k = c->share[t]; k < c->share[t + 1]; k++)
      for (size_t n = c->need_start[k]; n < c->need_start[k + 1]; n++)
        if (c->need[n] < c->share[t] || c->need[n] >= c->share[t + 1])
          c->any_boundary_first = c->boundary_first[c->need[n]] = true;
}

/* Returns the computing cost of all disks in lower slots than `disk`, including their pairs. */
static size_t cost_before(const pairs *p, size_t disk) {
  const size_t k = pairs_from(p, 0, p->n_round, disk),
               piece = pairs_from(p, p->first_segment, p->count, disk);
  return k + SEGMENT_COST * (piece - p->first_segment) + DISK_COST * disk;
}

/* Finds the first disk of each thread, so that the costs of all threads are about equal. The disks
 * of thread t are in slots disk[t] to disk[t + 1] - 1. */
static void share_disks(const pairs *p, size_t n_free, size_t threads, size_t *disk) {
  const size_t all = p->n_round + SEGMENT_COST * (p->count - p->first_segment) + DISK_COST * n_free;
  disk[0] = 0;
  for (size_t t = 1; t < threads; t++) {
    size_t low = disk[t - 1] / CHUNK_STEP, high = (n_free + CHUNK_STEP - 1) / CHUNK_STEP;
    while (low < high) {
      const size_t middle = low + (high - low) / 2;
      if (cost_before(p, CHUNK_STEP * middle) < all * t / threads)
        low = middle + 1;
      else
        high = middle;
    }
    disk[t] = CHUNK_STEP * low < n_free ? CHUNK_STEP * low : n_free;
  }
  disk[threads] = n_free;
  for (size_t t = 0; t < threads; t++)
    assert(disk[t] <= disk[t + 1] && (disk[t] % CHUNK_STEP == 0 || disk[t] == n_free));
}

static void cut_shares(chunks *c, const size_t *disk) {
  size_t k = 0;
  for (int t = 0; t < c->n_threads; t++) {
    c->share[t] = k;
    for (size_t d = disk[t]; d < disk[t + 1]; d += c->size, k++) {
      const size_t end = d + c->size < disk[t + 1] ? d + c->size : disk[t + 1];
      assert(k < c->count && d % CHUNK_STEP == 0 && end > d);
      c->begin[k] = d;
      for (size_t n = d / CHUNK_STEP; n * CHUNK_STEP < end; n++) c->of_disks[n] = (uint32_t)k;
    }
  }
  c->share[c->n_threads] = k;
  c->begin[k] = disk[c->n_threads];
  assert(k == c->count && c->begin[0] == 0);
}

/* Marks chunks with disks that are ghosts on other ranks as boundary_first, to be predicted before
 * all others, since the other ranks wait for the predicted coordinates of these disks. */
static void find_sent(const halo *h, chunks *c) {
  for (size_t k = 0; k < h->n_send; k++)
    c->boundary_first[chunks_of_disk(c, h->send_slot[k])] = true;
  c->any_boundary_first = true;
}

sd_status chunks_plan(engine *e) {
  work *w = &e->work;
  chunks *c = &w->chunks;
  const size_t n_free = e->state->n_free, threads = (size_t)w->n_threads;
  assert(threads >= 1 && threads <= WORK_MAX_THREADS);
  size_t disk[WORK_MAX_THREADS + 1], most = 0, count = 0;
  share_disks(&w->pairs, n_free, threads, disk);
  for (size_t t = 0; t < threads; t++)
    if (disk[t + 1] - disk[t] > most) most = disk[t + 1] - disk[t];
  const size_t size = chunk_size(threads > 1 ? most : CHUNKS_PER_THREAD * n_free);
  for (size_t t = 0; t < threads; t++) count += (disk[t + 1] - disk[t] + size - 1) / size;
  if (reserve(c, count ? count : 1, n_free) != SD_OK) return SD_ERROR_IO;
  c->size = size;
  c->count = count;
  const size_t asked = asked_size(), least = asked ? 4 * asked : WINDOW_LEAST;
  c->window = !e->halo && n_free >= least ? WINDOW_MOST : 1;
  c->n_threads = (int)threads;
  cut_shares(c, disk);
  assert(c->begin[count] == n_free && c->share[0] == 0 && c->share[threads] == count);
  find_pairs(c, &w->pairs);
  assert(c->pair[count] == w->pairs.first_ghost && c->segment[count] == w->pairs.count);
  find_needs(e, c);
  for (size_t k = 0; k < count; k++) c->predicted[k] = c->packed[k] = INT64_MIN;
  find_boundary_first(c, w->n_threads);
  if (e->halo) find_sent(e->halo, c);
  return SD_OK;
}

int chunks_thread_of_disk(const engine *e, size_t slot) {
  assert(slot < e->state->n_free);
  return thread_of_chunk(&e->work.chunks, chunks_of_disk(&e->work.chunks, slot));
}

int chunks_thread_of_pair(const engine *e, size_t pair) {
  const chunks *c = &e->work.chunks;
  assert(pair < e->work.pairs.count);
  if (pair >= e->work.pairs.first_ghost)
    return chunks_thread_of_disk(e, (size_t)e->work.pairs.a[pair]);
  int t = 0;
  while (pair >= c->pair[c->share[t + 1]]) t++;
  return t;
}

/* --- rows of chunks --------------------------------------------------------------------------- */

/* Pages of the table of packed bodies and force sums. A page is a range of rows with room for the
 * disks of one chunk. */
typedef struct page_list {
  /* [n] index of the last chunk that uses each page; SIZE_MAX: the page is never free again */
  size_t *until;
  size_t n;
} page_list;

/* Returns a page that is free from chunk k on, and reserves it up to chunk `until`; there are few
 * pages, so they are searched one by one. Rows that are kept to the end of the step (until =
 * SIZE_MAX) get a new page, since they may be written before the thread's first chunk is evaluated,
 * when all pages may be in use. */
static size_t take_page(page_list *l, size_t first, size_t k, size_t until) {
  size_t page = until == SIZE_MAX ? l->n : first;
  while (page < l->n && l->until[page] >= k) page++;
  if (page == l->n) l->n++;
  l->until[page] = until;
  return page;
}

/* Sets until[k] to the last chunk that reads the rows of chunk k; SIZE_MAX if chunk k keeps its
 * rows for the whole step. */
static void find_ends(chunks *c, size_t *until) {
  for (size_t k = 0; k < c->count; k++)
    until[k] = c->boundary_first[k] || c->boundary_last[k] ? SIZE_MAX : k;
  for (size_t k = 0; k < c->count; k++)
    for (size_t n = c->need_start[k]; n < c->need_start[k + 1]; n++)
      if (until[c->need[n]] < k) until[c->need[n]] = k;
}

static void give_rows(chunks *c, const size_t *until, page_list *pages) {
  for (size_t k = 0; k < c->count; k++) c->row[k] = SIZE_MAX;
  for (int t = 0; t < c->n_threads; t++) {
    const size_t first = pages->n; /* pages before this one are used by other threads at any time */
    for (size_t k = c->share[t]; k < c->share[t + 1]; k++)
      for (size_t n = c->need_start[k]; n < c->need_start[k + 1]; n++) {
        const size_t seen = c->need[n];
        if (seen < c->share[t] || seen >= c->share[t + 1] || c->row[seen] != SIZE_MAX) continue;
        assert(until[seen] >= k);
        c->row[seen] = c->size * take_page(pages, first, k, until[seen]);
      }
  }
}

static void give_own_rows(chunks *c, size_t n_free) {
  for (size_t k = 0; k < c->count; k++) c->row[k] = c->begin[k];
  c->rows = n_free;
}

/* Sets how far chunks with common pairs are apart, and how many steps may be taken at once: all
 * their chunks are to stay in the cache. */
static void plan_window(chunks *c) {
  c->reach = 0;
  for (size_t k = 0; k < c->count; k++)
    for (size_t n = c->need_start[k]; n < c->need_start[k + 1]; n++)
      if (c->need[n] > k && c->need[n] - k > c->reach) c->reach = c->need[n] - k;
  const size_t disks = CHUNKS_APART(c) * c->size; /* that a further step takes into the cache */
  const int64_t most = (int64_t)(WINDOW_DISKS / disks);
  if (c->window > most) c->window = most;
  if (!c->shares || c->window < 1) c->window = 1;
}

void chunks_plan_rows(chunks *c, size_t n_free) {
  size_t *until = memory_new(2 * c->count, sizeof *until);
  page_list pages = {until + c->count, 0};
  find_ends(c, until);
  give_rows(c, until, &pages);
  assert(pages.n <= c->count);
  for (size_t k = 0; k < c->count; k++)
    assert(c->row[k] != SIZE_MAX); /* every chunk has got rows, since its own pairs need them */
  c->rows = pages.n * c->size;
  c->shares = pages.n < c->count;
  if (!c->shares) give_own_rows(c, n_free);
  free(until);
  plan_window(c);
}
