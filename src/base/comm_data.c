/* comm_data.c: see comm_data.h. */
#include "base/comm_data.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "base/comm.h"
#include "base/memory.h"

#ifdef SD_HAVE_MPI
#include "base/comm_mpi.h"

struct comm_links {
  MPI_Datatype row;
  MPI_Request *request;
  int n;
};

static MPI_Datatype row_of(size_t size) {
  MPI_Datatype row;
  assert(size > 0 && size < 1u << 20);
  MPI_Type_contiguous((int)size, MPI_BYTE, &row);
  MPI_Type_commit(&row);
  return row;
}

/* Where the rows of each rank begin. */
static int *starts_of(const int *counts) {
  int *starts = memory_new((size_t)comm_size(), sizeof *starts);
  for (int k = 0, at = 0; k < comm_size(); at += counts[k++]) starts[k] = at;
  return starts;
}

static unsigned any_of(unsigned bits) {
  unsigned all = bits;
  MPI_Allreduce(&bits, &all, 1, MPI_UNSIGNED, MPI_BOR, comm_ranks);
  return all;
}

static double reduce(double value, MPI_Op how) {
  double all = value;
  MPI_Allreduce(&value, &all, 1, MPI_DOUBLE, how, comm_ranks);
  return all;
}

static void add_integers(int64_t *values, size_t n) {
  MPI_Allreduce(MPI_IN_PLACE, values, (int)n, MPI_INT64_T, MPI_SUM, comm_ranks);
}

static void exchange(const void *send, const int *to, void *receive, const int *from, size_t size) {
  MPI_Datatype row = row_of(size);
  int *out = starts_of(to), *in = starts_of(from);
  MPI_Alltoallv(send, to, out, row, receive, from, in, row, comm_ranks);
  free(out);
  free(in);
  MPI_Type_free(&row);
}

static void gather(const void *send, void *receive, const int *counts, size_t size) {
  MPI_Datatype row = row_of(size);
  int *in = starts_of(counts);
  MPI_Allgatherv(send, counts[comm_rank()], row, receive, counts, in, row, comm_ranks);
  free(in);
  MPI_Type_free(&row);
}

comm_links *comm_links_new(const void *send, const int *to, void *receive, const int *from, size_t size) {
  enum { TAG = 1 }; /* 0: the queue of comm.c */
  comm_links *l = memory_new(1, sizeof *l);
  l->request = memory_new(2 * (size_t)comm_size(), sizeof *l->request);
  l->row = row_of(size);
  const char *out = send;
  char *in = receive;
  for (int k = 0; k < comm_size(); k++) {
    assert(k != comm_rank() || (to[k] == 0 && from[k] == 0));
    if (from[k] > 0) MPI_Recv_init(in, from[k], l->row, k, TAG, comm_ranks, &l->request[l->n++]);
    if (to[k] > 0) MPI_Send_init(out, to[k], l->row, k, TAG, comm_ranks, &l->request[l->n++]);
    in += size * (size_t)from[k];
    out += size * (size_t)to[k];
  }
  return l;
}

void comm_links_start(comm_links *l) { MPI_Startall(l->n, l->request); }

void comm_links_progress(comm_links *l) {
  int all_done;
  MPI_Testall(l->n, l->request, &all_done, MPI_STATUSES_IGNORE);
}

void comm_links_wait(comm_links *l) { MPI_Waitall(l->n, l->request, MPI_STATUSES_IGNORE); }

void comm_links_free(comm_links *l) {
  if (!l) return;
  for (int k = 0; k < l->n; k++) MPI_Request_free(&l->request[k]);
  MPI_Type_free(&l->row);
  free(l->request);
  free(l);
}

#else

struct comm_links {
  int nothing;
};

static unsigned any_of(unsigned bits) { return bits; }
enum { MPI_MAX, MPI_SUM };
static double reduce(double value, int how) { return (void)how, value; }
static void add_integers(int64_t *values, size_t n) { (void)values, (void)n; }
static void exchange(const void *send, const int *to, void *receive, const int *from, size_t size) {
  (void)send, (void)to, (void)receive, (void)from, (void)size;
}
static void gather(const void *send, void *receive, const int *counts, size_t size) {
  (void)send, (void)receive, (void)counts, (void)size;
}
comm_links *comm_links_new(const void *send, const int *to, void *receive, const int *from, size_t size) {
  (void)send, (void)to, (void)receive, (void)from, (void)size;
  return NULL;
}
void comm_links_start(comm_links *l) { (void)l; }
void comm_links_progress(comm_links *l) { (void)l; }
void comm_links_wait(comm_links *l) { (void)l; }
void comm_links_free(comm_links *l) { (void)l; }

#endif

unsigned comm_or(unsigned bits) { return comm_size() > 1 ? any_of(bits) : bits; }
double comm_largest(double value) { return comm_size() > 1 ? reduce(value, MPI_MAX) : value; }
double comm_total(double value) { return comm_size() > 1 ? reduce(value, MPI_SUM) : value; }

void comm_total_exact(exact_sum *sums, size_t n) {
  enum { MEMBERS = sizeof *sums / sizeof(int64_t) };
  for (size_t k = 0; k < n; k++) exact_sum_carry(&sums[k]);
  if (comm_size() > 1) add_integers((int64_t *)(void *)sums, n * MEMBERS);
}

void comm_add(int64_t *values, size_t n) {
  if (comm_size() > 1) add_integers(values, n);
}

void comm_exchange(const void *send, const int *to, void *receive, const int *from, size_t size) {
  if (comm_size() > 1)
    exchange(send, to, receive, from, size);
  else if (to[0] > 0)
    memcpy(receive, send, size * (size_t)to[0]);
}

void comm_counts(const int *to, int *from) {
  int *ones = memory_new((size_t)comm_size(), sizeof *ones);
  for (int k = 0; k < comm_size(); k++) ones[k] = 1;
  comm_exchange(to, ones, from, ones, sizeof *to);
  free(ones);
}

void comm_gather(const void *send, void *receive, const int *counts, size_t size) {
  if (comm_size() > 1)
    gather(send, receive, counts, size);
  else if (counts[0] > 0)
    memcpy(receive, send, size * (size_t)counts[0]);
}

void comm_gather_counts(int mine, int *counts) {
  int *same = memory_new((size_t)comm_size(), sizeof *same);
  for (int k = 0; k < comm_size(); k++) same[k] = mine;
  comm_counts(same, counts);
  free(same);
}
