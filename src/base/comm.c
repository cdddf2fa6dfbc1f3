/* comm.c: ranks over MPI, or one rank; see comm.h.
 *
 * Ranks talk to rank 0 only, in words of 64 bits, all with one tag, so that they arrive in order:
 *
 *   to rank 0:    ASK -> a task or NONE        STOP, LEAVE (in comm_queue_end, STOP may follow), END (last)
 *   from rank 0:  STOP                         END (all have left) -> END
 *
 * Both last words are END, and a barrier follows, so that none of a queue's words meets the next queue.
 */
#ifndef _GNU_SOURCE
#define _GNU_SOURCE
#endif
#include <assert.h>
#include <stdlib.h>
#include <time.h>

#include "base/comm.h"
#ifdef SD_HAVE_MPI
#include "base/comm_mpi.h"
#include "base/memory.h"
#endif

enum { NONE = -1, STOP = -2, ASK = -3, LEAVE = -4, END = -5 };

static struct {
  bool begun;
  int rank, size;
  void (*tell)(const char *why);
} comm = {.size = 1};

int comm_rank(void) { return comm.rank; }
int comm_size(void) { return comm.size; }

/* Sleeps longer and longer, from 20 us to 5 ms. */
static void rest(long *ns) {
  *ns = *ns == 0 ? 20000 : *ns < 2500000 ? 2 * *ns : 5000000;
  struct timespec t = {.tv_nsec = *ns};
  nanosleep(&t, NULL);
}

/* A launcher that started several processes tells each of them how many; else 0 and no name. */
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
  if (comm.size > 1 || count <= 1) return SD_OK;
#ifdef SD_HAVE_MPI
  const char *built = "for another MPI than the one that started it";
#else
  const char *built = "without MPI";
#endif
  return sd_fail(
      messages, SD_ERROR_USER,
      "%s = %d: so many processes were started together, but this program was built %s and cannot find "
      "the others; expected one process, or a build with -DSLIPDISK_MPI=ON",
      name, count, built);
}

/* --- over MPI ------------------------------------------------------------------------------------- */
#ifdef SD_HAVE_MPI
/* NOLINTBEGIN(clang-analyzer-optin.mpi.*): the analyser takes MPI_Wait for the end of a request, but not MPI_Test */

/* Words that may be under way from one rank to another at the same time; each needs a place of its own. */
enum { ANSWER, SIGNAL, FAREWELL, PLACES };

typedef struct letter {
  int64_t word;
  MPI_Request request;
} letter;

MPI_Comm comm_ranks;
static letter (*letters)[PLACES];

static sd_status start(sd_messages *messages) {
  int given;
  if (MPI_Init_thread(NULL, NULL, MPI_THREAD_FUNNELED, &given) != MPI_SUCCESS)
    return sd_fail(messages, SD_ERROR_IO, "MPI does not start");
  if (given < MPI_THREAD_FUNNELED) {
    MPI_Finalize();
    return sd_fail(messages, SD_ERROR_IO, "this MPI does not allow threads (MPI_THREAD_FUNNELED)");
  }
  MPI_Comm_dup(MPI_COMM_WORLD, &comm_ranks);
  MPI_Comm_rank(comm_ranks, &comm.rank);
  MPI_Comm_size(comm_ranks, &comm.size);
  letters = memory_new((size_t)comm.size, sizeof *letters);
  for (int k = 0; k < comm.size; k++)
    for (int place = 0; place < PLACES; place++) letters[k][place].request = MPI_REQUEST_NULL;
  return SD_OK;
}

static void finish(void) {
  free(letters);
  letters = NULL;
  MPI_Comm_free(&comm_ranks);
  MPI_Finalize();
}

static void await(MPI_Request *request) {
  int done = 0;
  for (long ns = 0; MPI_Test(request, &done, MPI_STATUS_IGNORE), !done;) rest(&ns);
}

static void post(int to, int place, int64_t word) {
  letter *l = &letters[to][place];
  await(&l->request);
  l->word = word;
  MPI_Isend(&l->word, 1, MPI_INT64_T, to, 0, comm_ranks, &l->request);
}

static void settle_post(void) {
  for (int k = 0; k < comm.size; k++)
    for (int place = 0; place < PLACES; place++) await(&letters[k][place].request);
}

static bool receive(int *from, int64_t *word) {
  int there;
  MPI_Status status;
  MPI_Iprobe(MPI_ANY_SOURCE, 0, comm_ranks, &there, &status);
  if (!there) return false;
  *from = status.MPI_SOURCE;
  MPI_Recv(word, 1, MPI_INT64_T, *from, 0, comm_ranks, MPI_STATUS_IGNORE);
  return true;
}

static int largest(int value) {
  int most = value;
  MPI_Request request;
  MPI_Iallreduce(&value, &most, 1, MPI_INT, MPI_MAX, comm_ranks, &request);
  await(&request);
  return most;
}

/* In pieces, since MPI counts with an int. */
static void share(unsigned char *data, size_t bytes) {
  const size_t most = (size_t)1 << 24;
  for (size_t at = 0; at < bytes; at += most) {
    MPI_Request request;
    MPI_Ibcast(data + at, (int)(bytes - at < most ? bytes - at : most), MPI_BYTE, 0, comm_ranks, &request);
    await(&request);
  }
}

static void end_all(int status) { MPI_Abort(comm_ranks, status); }

/* NOLINTEND(clang-analyzer-optin.mpi.*) */

/* --- one rank ------------------------------------------------------------------------------------- */
#else

enum { ANSWER, SIGNAL, FAREWELL };

static sd_status start(sd_messages *messages) {
  (void)messages;
  return SD_OK;
}
static void finish(void) {}
static void post(int to, int place, int64_t word) { (void)to, (void)place, (void)word; }
static void settle_post(void) {}
static bool receive(int *from, int64_t *word) {
  *from = 0;
  *word = NONE;
  return false;
}
static int largest(int value) { return value; }
static void share(unsigned char *data, size_t bytes) { (void)data, (void)bytes; }
static void end_all(int status) { (void)status; }

#endif

/* --- ranks ---------------------------------------------------------------------------------------- */

sd_status comm_begin(sd_messages *messages) {
  assert(!comm.begun);
  sd_status status = start(messages);
  if (status != SD_OK) return status;
  status = check_launcher(messages);
  comm.begun = true;
  if (status != SD_OK) comm_end();
  return status;
}

void comm_end(void) {
  if (!comm.begun) return;
  comm_max(0); /* MPI_Finalize would spin */
  finish();
  comm.begun = false;
  comm.rank = 0;
  comm.size = 1;
}

int comm_max(int value) { return comm.size > 1 ? largest(value) : value; }

void comm_share(void *data, size_t bytes) {
  if (comm.size > 1) share(data, bytes);
}

void comm_abort(int status) {
  if (comm.size > 1) end_all(status);
}

void comm_on_fail(void (*tell)(const char *why)) { comm.tell = tell; }

void comm_fail(const char *why) {
  if (comm.size > 1 && comm.tell) comm.tell(why);
  comm_abort(SD_ERROR_IO);
}

/* --- queue ---------------------------------------------------------------------------------------- */

void comm_queue_begin(comm_queue *q, int64_t n, volatile sig_atomic_t *stop) {
  assert(n >= 0);
  *q = (comm_queue){.n = n, .stop = stop};
}

/* Stops this rank, and passes the stop on. */
static void halt(comm_queue *q) {
  if (q->stopped) return;
  q->stopped = true;
  if (q->stop) *q->stop = 1;
  if (q->ended) return;
  if (comm.rank > 0) post(0, SIGNAL, STOP);
  for (int to = 1; comm.rank == 0 && to < comm.size; to++) post(to, SIGNAL, STOP);
}

static void look_for_stop(comm_queue *q) {
  if (q->stop && *q->stop) halt(q);
}

static int64_t take(comm_queue *q) { return q->stopped || q->next >= q->n ? NONE : q->next++; }

/* Rank 0: what the others say. */
static void hear(comm_queue *q, int from, int64_t word) {
  switch (word) {
    case ASK: post(from, ANSWER, take(q)); break;
    case STOP: halt(q); break;
    case LEAVE: q->away++; break;
    default: assert(word == END); q->away--;
  }
}

void comm_serve(comm_queue *q) {
  look_for_stop(q);
  if (comm.size == 1) return;
  int from;
  int64_t word;
  while (receive(&from, &word)) {
    if (comm.rank == 0) {
      hear(q, from, word);
    } else {
      assert(word == STOP);
      halt(q);
    }
  }
}

/* Others than rank 0: its next word that is no STOP. */
static int64_t root_word(comm_queue *q) {
  int from;
  int64_t word;
  for (long ns = 0;; rest(&ns)) {
    look_for_stop(q);
    while (receive(&from, &word)) {
      if (word != STOP) return word;
      halt(q);
    }
  }
}

int64_t comm_next(comm_queue *q) {
  comm_serve(q);
  if (q->stopped) return -1;
  if (comm.rank == 0) return take(q);
  post(0, ANSWER, ASK);
  int64_t task = root_word(q);
  /* a task that was under way when the stop came is not begun */
  return q->stopped ? -1 : task;
}

void comm_queue_end(comm_queue *q) {
  look_for_stop(q);
  if (comm.size == 1) return;
  if (comm.rank > 0) {
    post(0, FAREWELL, LEAVE);
    int64_t word = root_word(q);
    assert(word == END);
    q->ended = true;
    post(0, FAREWELL, word);
  } else {
    for (long ns = 0; comm_serve(q), q->away < comm.size - 1;) rest(&ns);
    q->ended = true;
    for (int to = 1; to < comm.size; to++) post(to, FAREWELL, END);
    for (long ns = 0; comm_serve(q), q->away > 0;) rest(&ns);
  }
  settle_post();
  comm_max(0); /* nobody begins the next queue while rank 0 still waits for the END of others in this one */
}
