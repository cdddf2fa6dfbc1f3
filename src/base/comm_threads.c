/* comm_threads.c: implements comm.h for ranks that are threads of this process.
 *
 * Every collective function has the same four steps: each rank stores a pointer to its data where
 * the other ranks see it; all wait; each rank reads the data of the others; all wait.
 */
#include "base/comm.h"

#include <assert.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>

#include "base/comm_kind.h"
#include "base/memory.h"

typedef struct meeting {
  pthread_mutex_t lock;
  pthread_cond_t complete;
  int here;
  unsigned round;
  const void **shown; /* [ranks] pointer to the data of each rank, set by this rank */
} meeting;

typedef struct thread_rank {
  comm base;
  meeting *at;
  void (*task)(const comm *c, void *with);
  void *with;
} thread_rank;

static meeting *meeting_of(const comm *c) { return ((const thread_rank *)(const void *)c)->at; }

static void wait_for_all(const comm *c) {
  meeting *m = meeting_of(c);
  pthread_mutex_lock(&m->lock);
  const unsigned round = m->round;
  if (++m->here == c->size) {
    m->here = 0;
    m->round++;
    pthread_cond_broadcast(&m->complete);
  }
  while (m->round == round) pthread_cond_wait(&m->complete, &m->lock);
  pthread_mutex_unlock(&m->lock);
}

/* Makes `data` visible to the other ranks and waits for them. Returns the array of all ranks'
 * pointers [ranks], valid until this rank calls wait_for_all. */
static const void *const *show(const comm *c, const void *data) {
  meeting *m = meeting_of(c);
  m->shown[c->rank] = data;
  wait_for_all(c);
  return m->shown;
}

static void end_all(const comm *c, int status) {
  (void)c, (void)status;
  memory_lacks(0);
}

static void share(const comm *c, void *data, size_t bytes) {
  const void *const *all = show(c, data);
  if (c->rank > 0 && bytes > 0) memcpy(data, all[0], bytes);
  wait_for_all(c);
}

static unsigned any(const comm *c, unsigned bits) {
  const void *const *all = show(c, &bits);
  unsigned of_all = 0;
  for (int q = 0; q < c->size; q++) of_all |= *(const unsigned *)all[q];
  wait_for_all(c);
  return of_all;
}

static double largest(const comm *c, double value) {
  const void *const *all = show(c, &value);
  double most = value;
  for (int q = 0; q < c->size; q++)
    if (*(const double *)all[q] > most) most = *(const double *)all[q];
  wait_for_all(c);
  return most;
}

/* Returns the largest value over all ranks; it is compared as a double, which holds every int
 * exactly. */
static int max(const comm *c, int value) { return (int)largest(c, value); }

static void add(const comm *c, int64_t *values, size_t n) {
  int64_t *mine = memory_copy(values, n * sizeof *values);
  const void *const *all = show(c, mine);
  for (int q = 0; q < c->size; q++)
    for (size_t k = 0; q != c->rank && k < n; k++)
      values[k] = (int64_t)((uint64_t)values[k] + (uint64_t)((const int64_t *)all[q])[k]);
  wait_for_all(c);
  free(mine);
}

/* --- exchange of rows ------------------------------------------------------------------------- */

typedef struct parcel {
  const char *rows;
  /* [ranks] number of rows for each rank, and index of the first of them in `rows` */
  const int *counts, *starts;
} parcel;

/* Copies the rows that are meant for this rank from the buffers (parcels) of all ranks to
 * `receive`. from: [ranks] numbers of rows. */
static void take(const comm *c, const void *const *all, char *receive, const int *from,
                 size_t size) {
  for (int q = 0; q < c->size; q++) {
    const parcel *p = all[q];
    const size_t n = (size_t)from[q] * size;
    assert(p->counts[c->rank] == from[q]);
    if (n > 0) memcpy(receive, p->rows + (size_t)p->starts[c->rank] * size, n);
    receive += n;
  }
}

static void exchange(const comm *c, const void *send, const int *to, void *receive, const int *from,
                     size_t size) {
  int *starts = comm_starts(c, to);
  const parcel mine = {send, to, starts};
  take(c, show(c, &mine), receive, from, size);
  wait_for_all(c);
  free(starts);
}

static void gather(const comm *c, const void *send, void *receive, const int *counts, size_t size) {
  const void *const *all = show(c, send);
  char *at = receive;
  for (int q = 0; q < c->size; q++) {
    const size_t n = (size_t)counts[q] * size;
    if (n > 0) memcpy(at, all[q], n);
    at += n;
  }
  wait_for_all(c);
}

/* --- persistent messages ---------------------------------------------------------------------- */

typedef struct thread_links {
  comm_links base;
  parcel mine;
  char *receive;
  int *to, *from, *starts;
  size_t size;
} thread_links;

static comm_links *links_new(const comm *c, const void *send, const int *to, void *receive,
                             const int *from, size_t size) {
  const size_t bytes = (size_t)c->size * sizeof *to;
  thread_links *l = memory_new(1, sizeof *l);
  l->base.comm = c;
  l->receive = receive;
  l->to = memory_copy(to, bytes);
  l->from = memory_copy(from, bytes);
  l->starts = comm_starts(c, to);
  l->mine = (parcel){send, l->to, l->starts};
  l->size = size;
  return &l->base;
}

/* Does nothing: links_wait copies the rows, and until then the caller may not touch the buffers. */
static void links_start(comm_links *l) { (void)l; }

static void links_wait(comm_links *links) {
  thread_links *l = (thread_links *)(void *)links;
  const comm *c = links->comm;
  take(c, show(c, &l->mine), l->receive, l->from, l->size);
  wait_for_all(c);
}

static void links_free(comm_links *links) {
  thread_links *l = (thread_links *)(void *)links;
  free(l->to);
  free(l->from);
  free(l->starts);
  free(l);
}

/* --- start of the threads --------------------------------------------------------------------- */

static const comm_kind kind = {.end = end_all,
                               .max = max,
                               .share = share,
                               .any = any,
                               .largest = largest,
                               .add = add,
                               .exchange = exchange,
                               .gather = gather,
                               .links_new = links_new,
                               .links_start = links_start,
                               .links_progress = links_start,
                               .links_wait = links_wait,
                               .links_free = links_free};

static void *run(void *with) {
  thread_rank *r = with;
  r->task(&r->base, r->with);
  return NULL;
}

void comm_threads_run(int n, void (*task)(const comm *c, void *with), void *with) {
  meeting at = {.shown = memory_new((size_t)n, sizeof *at.shown)};
  thread_rank *rank = memory_new((size_t)n, sizeof *rank);
  pthread_t *thread = memory_new((size_t)n, sizeof *thread);
  if (n == 1) task(NULL, with);
  pthread_mutex_init(&at.lock, NULL);
  pthread_cond_init(&at.complete, NULL);
  for (int q = 0; n > 1 && q < n; q++) {
    rank[q] = (thread_rank){.base = {&kind, q, n}, .at = &at, .task = task, .with = with};
    if (pthread_create(&thread[q], NULL, run, &rank[q]) != 0) memory_lacks(0);
  }
  for (int q = 0; n > 1 && q < n; q++) pthread_join(thread[q], NULL);
  pthread_cond_destroy(&at.complete);
  pthread_mutex_destroy(&at.lock);
  free(thread);
  free(rank);
  free(at.shown);
}
