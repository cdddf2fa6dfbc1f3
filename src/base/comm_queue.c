/* comm_queue.c: implements comm_queue.h.
 *
 * Ranks exchange messages with rank 0 only. A message is one 64-bit integer, a task number or one
 * of the codes below; all have the same tag, so that they arrive in order:
 *
 * - A rank sends ASK, and rank 0 answers with a task or NONE.
 * - A rank sends LEAVE when it wants no more tasks (comm_queue_end).
 * - Any rank sends STOP to rank 0, also after LEAVE, and rank 0 sends it on to the others.
 * - When all ranks have left, rank 0 sends END, and each rank answers with END.
 *
 * Both sides send END last, and a barrier follows, so that no message of one queue arrives in the
 * next one.
 */
#include "base/comm_queue.h"

#include <assert.h>
#include <stdlib.h>

#include "base/comm.h"
#include "base/memory.h"
#ifdef SD_HAVE_MPI
#include "base/comm_mpi.h"
#endif

static int rank(void) { return comm_rank(comm_world()); }
static int ranks(void) { return comm_size(comm_world()); }

enum { NONE = -1, STOP = -2, ASK = -3, LEAVE = -4, END = -5 };

/* Send buffers for each target rank, one per kind of message, so that messages of all kinds can be
 * on their way at the same time. */
enum { ANSWER, SIGNAL, FAREWELL, PLACES };

#ifdef SD_HAVE_MPI
/* NOLINTBEGIN(clang-analyzer-optin.mpi.*): the analyser takes MPI_Wait for the end of a request,
 * but not MPI_Test */

typedef struct comm_letters {
  struct {
    int64_t word;
    MPI_Request request;
  } to[PLACES];
} letters;

static void begin_letters(comm_queue *q) {
  q->letters = memory_new((size_t)ranks(), sizeof *q->letters);
  for (int k = 0; k < ranks(); k++)
    for (int place = 0; place < PLACES; place++) q->letters[k].to[place].request = MPI_REQUEST_NULL;
}

static void post(comm_queue *q, int to, int place, int64_t word) {
  comm_await(&q->letters[to].to[place].request);
  q->letters[to].to[place].word = word;
  MPI_Isend(&q->letters[to].to[place].word, 1, MPI_INT64_T, to, 0, comm_ranks,
            &q->letters[to].to[place].request);
}

static void end_letters(comm_queue *q) {
  for (int k = 0; k < ranks(); k++)
    for (int place = 0; place < PLACES; place++) comm_await(&q->letters[k].to[place].request);
  free(q->letters);
  q->letters = NULL;
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

/* NOLINTEND(clang-analyzer-optin.mpi.*) */
#else
static void begin_letters(comm_queue *q) { (void)q; }
static void post(comm_queue *q, int to, int place, int64_t word) {
  (void)q, (void)to, (void)place, (void)word;
}
static void end_letters(comm_queue *q) { (void)q; }
static bool receive(int *from, int64_t *word) {
  *from = 0;
  *word = NONE;
  return false;
}
static void comm_rest(long *ns) { (void)ns; }
#endif

void comm_queue_begin(comm_queue *q, int64_t n, volatile sig_atomic_t *stop) {
  assert(n >= 0);
  *q = (comm_queue){.n = n, .stop = stop};
  if (ranks() > 1) begin_letters(q);
}

/* Stops this rank, sets the stop flag of the caller, and sends STOP to rank 0 (from rank 0: to all
 * other ranks). */
static void halt(comm_queue *q) {
  if (q->stopped) return;
  q->stopped = true;
  if (q->stop) *q->stop = 1;
  if (q->ended) return;
  if (rank() > 0) post(q, 0, SIGNAL, STOP);
  for (int to = 1; rank() == 0 && to < ranks(); to++) post(q, to, SIGNAL, STOP);
}

static void look_for_stop(comm_queue *q) {
  if (q->stop && *q->stop) halt(q);
}

static int64_t take(comm_queue *q) { return q->stopped || q->next >= q->n ? NONE : q->next++; }

/* Handles a message (`word`) from another rank; called on rank 0 only. */
static void hear(comm_queue *q, int from, int64_t word) {
  switch (word) {
    case ASK: post(q, from, ANSWER, take(q)); break;
    case STOP: halt(q); break;
    case LEAVE: q->away++; break;
    default: assert(word == END); q->away--;
  }
}

void comm_serve(comm_queue *q) {
  look_for_stop(q);
  if (ranks() == 1) return;
  int from;
  int64_t word;
  while (receive(&from, &word)) {
    if (rank() == 0) {
      hear(q, from, word);
    } else {
      assert(word == STOP);
      halt(q);
    }
  }
}

/* Waits for a message of rank 0 other than STOP and returns it; a STOP that arrives first is
 * handled. Called on the other ranks only. */
static int64_t root_word(comm_queue *q) {
  int from;
  int64_t word;
  for (long ns = 0;; comm_rest(&ns)) {
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
  if (rank() == 0) return take(q);
  post(q, 0, ANSWER, ASK);
  int64_t task = root_word(q);
  /* A task that arrived after a stop is not started. */
  return q->stopped ? -1 : task;
}

void comm_queue_end(comm_queue *q) {
  look_for_stop(q);
  if (ranks() == 1) return;
  if (rank() > 0) {
    post(q, 0, FAREWELL, LEAVE);
    int64_t word = root_word(q);
    assert(word == END);
    q->ended = true;
    post(q, 0, FAREWELL, word);
  } else {
    for (long ns = 0; comm_serve(q), q->away < ranks() - 1;) comm_rest(&ns);
    q->ended = true;
    for (int to = 1; to < ranks(); to++) post(q, to, FAREWELL, END);
    for (long ns = 0; comm_serve(q), q->away > 0;) comm_rest(&ns);
  }
  end_letters(q);
  /* Barrier: no rank starts the next queue while rank 0 still waits for END messages. */
  comm_max(comm_world(), 0);
}
