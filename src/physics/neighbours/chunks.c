/* chunks.c: see chunks.h. */
#include "physics/neighbours/chunks.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

/* Disks per chunk: few enough for the cache, and several chunks for every thread, so that few of them have to wait for
 * other threads. */
enum { CHUNK_MOST = 2048, CHUNK_LEAST = 256, CHUNKS_PER_THREAD = 8 };

/* A piece of a straight wall costs as much as this many round pairs; a disk without any, too. */
enum { SEGMENT_COST = 4, DISK_COST = 1 };

static size_t rounded(size_t n) { return (n + CHUNK_STEP - 1) / CHUNK_STEP * CHUNK_STEP; }

/* Of a share of n disks, the last chunk may be smaller; all shares have room for as many. */
static size_t chunk_size(size_t n) {
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
  c->begin = malloc((count + 1) * sizeof *c->begin);
  c->of_disks = malloc((n_free / CHUNK_STEP + 1) * sizeof *c->of_disks);
  c->pair = malloc((count + 1) * sizeof *c->pair);
  c->segment = malloc((count + 1) * sizeof *c->segment);
  c->need_start = malloc((count + 1) * sizeof *c->need_start);
  c->row = malloc(count * sizeof *c->row);
  c->predicted = malloc(count * sizeof *c->predicted);
  c->packed = malloc(count * sizeof *c->packed);
  c->boundary_first = malloc(count);
  c->boundary_last = malloc(count);
  bool all = c->begin && c->of_disks && c->pair && c->segment && c->need_start && c->row && c->predicted &&
             c->packed && c->boundary_first && c->boundary_last;
  c->capacity = all ? count : 0;
  return all ? SD_OK : SD_ERROR_IO;
}

/* Where the pairs of each chunk begin; round ones to whole blocks. */
static void find_pairs(chunks *c, const pairs *p) {
  size_t k = 0, piece = p->first_segment;
  for (size_t n = 0; n <= c->count; n++) {
    const int32_t first = (int32_t)c->begin[n];
    while (k < p->n_round && (n == c->count || p->a[k] < first)) k++;
    while (piece < p->count && (n == c->count || p->a[piece] < first)) piece++;
    size_t whole = (k + PAIR_BLOCK - 1) / PAIR_BLOCK * PAIR_BLOCK;
    c->pair[n] = whole < p->first_segment ? whole : p->first_segment;
    c->segment[n] = piece;
    assert(c->pair[n] % PAIR_BLOCK == 0 && (n == 0 || c->pair[n - 1] <= c->pair[n]));
    assert(n == 0 || c->segment[n - 1] <= piece);
  }
}

static sd_status add_need(chunks *c, size_t *n, uint32_t chunk) {
  assert(chunk < c->count);
  if (*n == c->need_capacity) {
    size_t capacity = 2 * *n + 4 * c->count + 16;
    uint32_t *more = realloc(c->need, capacity * sizeof *more);
    if (!more) return SD_ERROR_IO;
    c->need = more;
    c->need_capacity = capacity;
  }
  c->need[(*n)++] = chunk;
  return SD_OK;
}

/* Chunks that the pairs of each one read; itself always. */
static sd_status find_needs(chunks *c, const pairs *p, size_t n_free) {
  size_t n = 0;
  int64_t *found_for = c->packed;
  for (size_t k = 0; k < c->count; k++) found_for[k] = -1;
  for (size_t k = 0; k < c->count; k++) {
    c->need_start[k] = n;
    found_for[k] = (int64_t)k;
    if (add_need(c, &n, (uint32_t)k) != SD_OK) return SD_ERROR_IO;
    for (size_t at = c->pair[k]; at < c->pair[k + 1]; at++)
      for (int side = 0; side < 2; side++) {
        int32_t slot = side ? p->b[at] : p->a[at];
        if (slot < 0 || (size_t)slot >= n_free || found_for[chunks_of_disk(c, (size_t)slot)] == (int64_t)k)
          continue;
        size_t seen = chunks_of_disk(c, (size_t)slot);
        found_for[seen] = (int64_t)k;
        if (add_need(c, &n, (uint32_t)seen) != SD_OK) return SD_ERROR_IO;
      }
    assert(n > c->need_start[k] && c->need[c->need_start[k]] == k);
  }
  c->need_start[c->count] = n;
  assert(n <= c->need_capacity);
  return SD_OK;
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

/* Where the share of each thread begins, so that all cost the same. */
static void share_disks(const pairs *p, size_t n_free, size_t threads, size_t *disk) {
  const size_t all = p->n_round + SEGMENT_COST * (p->count - p->first_segment) + DISK_COST * n_free;
  size_t k = 0, piece = p->first_segment, t = 1;
  disk[0] = 0;
  for (size_t d = 0; d < n_free; d += CHUNK_STEP) {
    while (k < p->n_round && p->a[k] < (int32_t)d) k++;
    while (piece < p->count && p->a[piece] < (int32_t)d) piece++;
    const size_t cost = k + SEGMENT_COST * (piece - p->first_segment) + DISK_COST * d;
    while (t < threads && cost >= all * t / threads) disk[t++] = d;
  }
  while (t <= threads) disk[t++] = n_free;
  for (t = 0; t < threads; t++)
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
  c->n_threads = w->n_threads;
  cut_shares(c, disk);
  assert(c->begin[count] == n_free && c->share[0] == 0 && c->share[threads] == count);
  find_pairs(c, &w->pairs);
  assert(c->pair[count] == w->pairs.first_segment && c->segment[count] == w->pairs.count);
  if (find_needs(c, &w->pairs, n_free) != SD_OK) return SD_ERROR_IO;
  for (size_t k = 0; k < count; k++) c->predicted[k] = c->packed[k] = INT64_MIN;
  find_boundary_first(c, w->n_threads);
  return SD_OK;
}

int chunks_thread_of_disk(const engine *e, size_t slot) {
  assert(slot < e->state->n_free);
  return thread_of_chunk(&e->work.chunks, chunks_of_disk(&e->work.chunks, slot));
}

int chunks_thread_of_pair(const engine *e, size_t pair) {
  const chunks *c = &e->work.chunks;
  assert(pair < e->work.pairs.count);
  if (pair >= e->work.pairs.first_segment) return chunks_thread_of_disk(e, (size_t)e->work.pairs.a[pair]);
  int t = 0;
  while (pair >= c->pair[c->share[t + 1]]) t++;
  return t;
}

/* --- rows -------------------------------------------------------------------------------------------- */

/* Rows for as many disks as a chunk has. */
typedef struct page_list {
  size_t *until; /* of each: after which chunk it is free */
  size_t n;
} page_list;

/* A page that is free from chunk k on; they are few. What is kept gets a new one: it may be seated before the share
 * begins, when earlier chunks still want all others. */
static size_t take_page(page_list *l, size_t first, size_t k, size_t until) {
  size_t page = until == SIZE_MAX ? l->n : first;
  while (page < l->n && l->until[page] >= k) page++;
  if (page == l->n) l->n++;
  l->until[page] = until;
  return page;
}

/* Last chunk of its share that reads the rows of each; SIZE_MAX where they are kept. */
static void find_ends(chunks *c, size_t *until) {
  for (size_t k = 0; k < c->count; k++) until[k] = c->boundary_first[k] || c->boundary_last[k] ? SIZE_MAX : k;
  for (size_t k = 0; k < c->count; k++)
    for (size_t n = c->need_start[k]; n < c->need_start[k + 1]; n++)
      if (until[c->need[n]] < k) until[c->need[n]] = k;
}

static void give_rows(chunks *c, const size_t *until, page_list *pages) {
  for (size_t k = 0; k < c->count; k++) c->row[k] = SIZE_MAX;
  for (int t = 0; t < c->n_threads; t++) {
    const size_t first = pages->n; /* those of other shares are in use at any time */
    for (size_t k = c->share[t]; k < c->share[t + 1]; k++)
      for (size_t n = c->need_start[k]; n < c->need_start[k + 1]; n++) {
        const size_t seen = c->need[n];
        if (seen < c->share[t] || seen >= c->share[t + 1] || c->row[seen] != SIZE_MAX) continue;
        assert(until[seen] >= k);
        c->row[seen] = c->size * take_page(pages, first, k, until[seen]);
      }
  }
}

sd_status chunks_plan_rows(chunks *c, size_t n_free) {
  size_t *until = malloc((2 * c->count + 1) * sizeof *until);
  if (!until) return SD_ERROR_IO;
  page_list pages = {until + c->count, 0};
  find_ends(c, until);
  give_rows(c, until, &pages);
  assert(pages.n <= c->count);
  for (size_t k = 0; k < c->count; k++) assert(c->row[k] != SIZE_MAX); /* each is read by its own pairs */
  c->rows = pages.n * c->size;
  c->shares = pages.n < c->count;
  if (!c->shares) {
    for (size_t k = 0; k < c->count; k++) c->row[k] = c->begin[k];
    c->rows = n_free;
  }
  free(until);
  return SD_OK;
}
