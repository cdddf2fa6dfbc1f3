/* comm_job.c: communication between the ranks of an MPI job, or a single process without MPI; see
 * comm.h. The core library (slipdisk_core) does not contain this file. */
#include <assert.h>
#include <stdlib.h>

#include "base/comm_kind.h"
#include "base/memory.h"

#ifdef SD_HAVE_MPI
#include <time.h>

#include "base/comm_mpi.h"

/* NOLINTBEGIN(clang-analyzer-optin.mpi.*): the analyser takes MPI_Wait for the end of a request,
 * but not MPI_Test */

MPI_Comm comm_ranks;

static void end_all(const comm *c, int status) {
  (void)c;
  MPI_Abort(comm_ranks, status);
}

void comm_rest(long *ns) {
  *ns = *ns == 0 ? 20000 : *ns < 2500000 ? 2 * *ns : 5000000;
  struct timespec t = {.tv_nsec = *ns};
  nanosleep(&t, NULL);
}

void comm_await(MPI_Request *request) {
  int done = 0;
  for (long ns = 0; MPI_Test(request, &done, MPI_STATUS_IGNORE), !done;) comm_rest(&ns);
}

static int max(const comm *c, int value) {
  (void)c;
  int most = value;
  MPI_Request request;
  MPI_Iallreduce(&value, &most, 1, MPI_INT, MPI_MAX, comm_ranks, &request);
  comm_await(&request);
  return most;
}

/* Broadcasts in blocks of 16 MiB, since MPI counts with an int. */
static void share(const comm *c, void *data, size_t bytes) {
  (void)c;
  const size_t most = (size_t)1 << 24;
  for (size_t at = 0; at < bytes; at += most) {
    MPI_Request request;
    MPI_Ibcast((char *)data + at, (int)(bytes - at < most ? bytes - at : most), MPI_BYTE, 0,
               comm_ranks, &request);
    comm_await(&request);
  }
}

static unsigned any(const comm *c, unsigned bits) {
  (void)c;
  unsigned all = bits;
  MPI_Allreduce(&bits, &all, 1, MPI_UNSIGNED, MPI_BOR, comm_ranks);
  return all;
}

static double largest(const comm *c, double value) {
  (void)c;
  double all = value;
  MPI_Allreduce(&value, &all, 1, MPI_DOUBLE, MPI_MAX, comm_ranks);
  return all;
}

static void add(const comm *c, int64_t *values, size_t n) {
  (void)c;
  MPI_Allreduce(MPI_IN_PLACE, values, (int)n, MPI_INT64_T, MPI_SUM, comm_ranks);
}

static MPI_Datatype row_of(size_t size) {
  MPI_Datatype row;
  assert(size > 0 && size < 1u << 20);
  MPI_Type_contiguous((int)size, MPI_BYTE, &row);
  MPI_Type_commit(&row);
  return row;
}

static void exchange(const comm *c, const void *send, const int *to, void *receive, const int *from,
                     size_t size) {
  MPI_Datatype row = row_of(size);
  int *out = comm_starts(c, to), *in = comm_starts(c, from);
  MPI_Alltoallv(send, to, out, row, receive, from, in, row, comm_ranks);
  free(out);
  free(in);
  MPI_Type_free(&row);
}

static void gather(const comm *c, const void *send, void *receive, const int *counts, size_t size) {
  MPI_Datatype row = row_of(size);
  int *in = comm_starts(c, counts);
  MPI_Allgatherv(send, counts[c->rank], row, receive, counts, in, row, comm_ranks);
  free(in);
  MPI_Type_free(&row);
}

/* --- persistent messages ---------------------------------------------------------------------- */

typedef struct mpi_links {
  comm_links base;
  MPI_Datatype row;
  MPI_Request *request;
  int n;
} mpi_links;

static comm_links *links_new(const comm *c, const void *send, const int *to, void *receive,
                             const int *from, size_t size) {
  enum { TAG = 1 }; /* MPI tag of persistent messages; comm_queue.c uses tag 0 */
  mpi_links *l = memory_new(1, sizeof *l);
  l->base.comm = c;
  l->request = memory_new(2 * (size_t)c->size, sizeof *l->request);
  l->row = row_of(size);
  const char *out = send;
  char *in = receive;
  for (int k = 0; k < c->size; k++) {
    assert(k != c->rank || (to[k] == 0 && from[k] == 0));
    if (from[k] > 0) MPI_Recv_init(in, from[k], l->row, k, TAG, comm_ranks, &l->request[l->n++]);
    if (to[k] > 0) MPI_Send_init(out, to[k], l->row, k, TAG, comm_ranks, &l->request[l->n++]);
    in += size * (size_t)from[k];
    out += size * (size_t)to[k];
  }
  return &l->base;
}

static mpi_links *mpi_of(comm_links *l) { return (mpi_links *)(void *)l; }

static void links_start(comm_links *l) { MPI_Startall(mpi_of(l)->n, mpi_of(l)->request); }

static void links_progress(comm_links *l) {
  int all_done;
  MPI_Testall(mpi_of(l)->n, mpi_of(l)->request, &all_done, MPI_STATUSES_IGNORE);
}

static void links_wait(comm_links *l) {
  MPI_Waitall(mpi_of(l)->n, mpi_of(l)->request, MPI_STATUSES_IGNORE);
}

static void links_free(comm_links *links) {
  mpi_links *l = mpi_of(links);
  for (int k = 0; k < l->n; k++) MPI_Request_free(&l->request[k]);
  MPI_Type_free(&l->row);
  free(l->request);
  free(l);
}

/* --- table of the MPI functions --------------------------------------------------------------- */

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
                               .links_progress = links_progress,
                               .links_wait = links_wait,
                               .links_free = links_free};

static sd_status start_mpi(const comm **world, sd_messages *messages) {
  static comm job = {.kind = &kind};
  int given;
  *world = NULL;
  if (MPI_Init_thread(NULL, NULL, MPI_THREAD_FUNNELED, &given) != MPI_SUCCESS)
    return sd_fail(messages, SD_ERROR_IO, "MPI does not start");
  if (given < MPI_THREAD_FUNNELED) {
    MPI_Finalize();
    return sd_fail(messages, SD_ERROR_IO, "this MPI does not allow threads (MPI_THREAD_FUNNELED)");
  }
  MPI_Comm_dup(MPI_COMM_WORLD, &comm_ranks);
  MPI_Comm_rank(comm_ranks, &job.rank);
  MPI_Comm_size(comm_ranks, &job.size);
  if (job.size > 1) *world = &job;
  return SD_OK;
}

static void finish_mpi(void) {
  MPI_Comm_free(&comm_ranks);
  MPI_Finalize();
}

/* NOLINTEND(clang-analyzer-optin.mpi.*) */

#else

static sd_status start_mpi(const comm **job, sd_messages *messages) {
  (void)messages;
  *job = NULL;
  return SD_OK;
}
static void finish_mpi(void) {}

#endif

/* --- start and end of the job ----------------------------------------------------------------- */

static const comm *world;
static bool begun;

/* Returns the number of processes that a launcher has started according to its environment
 * variable, and sets *name to the name of that variable. Returns 0 if no such variable is set;
 * *name is then of no use. */
static int launched(const char **name) {
  static const char *const names[] = {"OMPI_COMM_WORLD_SIZE", "PMI_SIZE"};
  for (size_t k = 0; k < sizeof names / sizeof *names; k++) {
    const char *text = getenv(*name = names[k]);
    if (text) return (int)strtol(text, NULL, 10);
  }
  return 0;
}

static sd_status check_launcher(sd_messages *messages) {
  const char *name;
  int count = launched(&name);
  if (world || count <= 1) return SD_OK;
#ifdef SD_HAVE_MPI
  const char *built = "for another MPI than the one that started it";
#else
  const char *built = "without MPI";
#endif
  return sd_fail(messages, SD_ERROR_USER,
                 "%s = %d: so many processes were started together, but this program was built %s "
                 "and cannot find "
                 "the others; expected one process, or a build with -DSLIPDISK_MPI=ON",
                 name, count, built);
}

sd_status comm_begin(sd_messages *messages) {
  assert(!begun);
  sd_status status = start_mpi(&world, messages);
  if (status != SD_OK) return status;
  status = check_launcher(messages);
  begun = true;
  if (status != SD_OK) comm_end();
  return status;
}

void comm_end(void) {
  if (!begun) return;
  /* This call is a barrier in which ranks sleep; MPI_Finalize alone would spin while it waits. */
  comm_max(world, 0);
  finish_mpi();
  begun = false;
  world = NULL;
}

const comm *comm_world(void) { return world; }
