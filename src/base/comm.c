/* comm.c: checks arguments, and passes each call of comm.h to its implementation for MPI processes
 * or for threads as ranks (comm_kind.h). */
#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "base/comm_kind.h"
#include "base/memory.h"

static void (*tell)(const char *why);

int comm_rank(const comm *c) { return c ? c->rank : 0; }
int comm_size(const comm *c) { return c ? c->size : 1; }

void comm_abort(const comm *c, int status) {
  if (c) c->kind->end(c, status);
}

void comm_on_fail(void (*call)(const char *why)) { tell = call; }

void comm_fail(const comm *c, const char *why) {
  if (c && tell) tell(why);
  comm_abort(c, SD_ERROR_IO);
}

/* --- check that all ranks make the same call -------------------------------------------------- */

#ifdef SD_CHECK
static _Thread_local const char *here = "";

void comm_at(const char *place) { here = place; }

/* Returns the FNV-1a hash of a text. */
static uint64_t hash_of(const char *text) {
  uint64_t hash = UINT64_C(0xcbf29ce484222325);
  for (; *text; text++) hash = (hash ^ (unsigned char)*text) * UINT64_C(0x100000001b3);
  return hash;
}

/* Checks that all ranks are at the same collective call, by a hash of its source location. If a
 * rank is at another call than this one, the job ends. */
static void meet(const comm *c) {
  const uint64_t mine = hash_of(here);
  int *ones = memory_new((size_t)c->size, sizeof *ones);
  uint64_t *all = memory_new((size_t)c->size, sizeof *all);
  for (int q = 0; q < c->size; q++) ones[q] = 1;
  c->kind->gather(c, &mine, all, ones, sizeof mine);
  for (int q = 0; q < c->size; q++)
    if (all[q] != mine) comm_fail(c, here);
  free(ones);
  free(all);
}
#else
static void meet(const comm *c) { (void)c; }
#endif

/* --- reductions and broadcasts ---------------------------------------------------------------- */

int comm_max(const comm *c, int value) {
  if (!c) return value;
  meet(c);
  return c->kind->max(c, value);
}

void comm_broadcast(const comm *c, void *data, size_t bytes) {
  if (!c) return;
  meet(c);
  c->kind->share(c, data, bytes);
}

char *comm_text(const comm *c, const char *text) {
  const bool mine = comm_rank(c) == 0;
  uint64_t bytes[1] = {mine ? strlen(text) + 1 : 0};
  comm_broadcast(c, bytes, sizeof bytes);
  char *same = mine ? memory_text(text) : memory_new((size_t)bytes[0], 1);
  comm_broadcast(c, same, (size_t)bytes[0]);
  return same;
}

unsigned comm_or(const comm *c, unsigned bits) {
  if (!c) return bits;
  meet(c);
  return c->kind->any(c, bits);
}

sd_status comm_agree(const comm *c, sd_status status) {
  return c ? (sd_status)(int)comm_largest(c, (double)status) : status;
}

sd_status comm_wait(const comm *c, sd_status status) { return (sd_status)comm_max(c, (int)status); }

bool comm_all_well(const comm *c, sd_status status) { return comm_or(c, status != SD_OK) == 0; }

double comm_largest(const comm *c, double value) {
  if (!c) return value;
  meet(c);
  return c->kind->largest(c, value);
}

/* Returns the sum over all ranks. Every rank adds the values in the order of ranks, so that all
 * ranks get the same bits. */
double comm_total(const comm *c, double value) {
  if (!c) return value;
  double *all = memory_new((size_t)c->size, sizeof *all), sum = 0.0;
  comm_gather_one(c, &value, all, sizeof value);
  for (int q = 0; q < c->size; q++) sum += all[q];
  free(all);
  return sum;
}

void comm_total_exact(const comm *c, exact_sum *sums, size_t n) {
  enum { MEMBERS = sizeof *sums / sizeof(int64_t) };
  if (!c) return;
  for (size_t k = 0; k < n; k++) exact_sum_carry(&sums[k]);
  comm_add(c, (int64_t *)(void *)sums, n * MEMBERS);
}

void comm_add(const comm *c, int64_t *values, size_t n) {
  if (!c) return;
  meet(c);
  c->kind->add(c, values, n);
}

/* --- exchange of rows ------------------------------------------------------------------------- */

int *comm_starts(const comm *c, const int *counts) {
  int *starts = memory_new((size_t)c->size, sizeof *starts);
  for (int k = 0, at = 0; k < c->size; at += counts[k++]) starts[k] = at;
  return starts;
}

void comm_exchange(const comm *c, const void *send, const int *to, void *receive, const int *from,
                   size_t size) {
  if (c) {
    meet(c);
    c->kind->exchange(c, send, to, receive, from, size);
  } else if (to[0] > 0) {
    memcpy(receive, send, size * (size_t)to[0]);
  }
}

static int *ones_of(const comm *c) {
  int *ones = memory_new((size_t)comm_size(c), sizeof *ones);
  for (int k = 0; k < comm_size(c); k++) ones[k] = 1;
  return ones;
}

void comm_counts(const comm *c, const int *to, int *from) {
  int *ones = ones_of(c);
  comm_exchange(c, to, ones, from, ones, sizeof *to);
  free(ones);
}

void comm_gather(const comm *c, const void *send, void *receive, const int *counts, size_t size) {
  if (c) {
    meet(c);
    c->kind->gather(c, send, receive, counts, size);
  } else if (counts[0] > 0) {
    memcpy(receive, send, size * (size_t)counts[0]);
  }
}

void comm_gather_one(const comm *c, const void *send, void *receive, size_t size) {
  int *ones = ones_of(c);
  comm_gather(c, send, receive, ones, size);
  free(ones);
}

void comm_gather_counts(const comm *c, int mine, int *counts) {
  comm_gather_one(c, &mine, counts, sizeof mine);
}

/* --- persistent messages ---------------------------------------------------------------------- */

comm_links *comm_links_new(const comm *c, const void *send, const int *to, void *receive,
                           const int *from, size_t size) {
  return c ? c->kind->links_new(c, send, to, receive, from, size) : NULL;
}
void comm_links_start(comm_links *l) {
  if (l) l->comm->kind->links_start(l);
}
void comm_links_progress(comm_links *l) {
  if (l) l->comm->kind->links_progress(l);
}
void comm_links_wait(comm_links *l) {
  if (l) l->comm->kind->links_wait(l);
}
void comm_links_free(comm_links *l) {
  if (l) l->comm->kind->links_free(l);
}
