/* comm_queue.h: distributes tasks among the ranks of a job, one task at a time.
 *
 * Each of the tasks 0 ... n-1 goes to the rank that asks next. Rank 0 holds the counter of tasks
 * and works like the others: it answers requests in comm_serve, which every rank calls a few times
 * a second while it works on a task. A rank thus waits for its next task until rank 0 calls
 * comm_serve again; tasks should take longer than that.
 *
 *     comm_queue queue;
 *     comm_queue_begin(&queue, n, &stop);
 *     for (int64_t task; (task = comm_next(&queue)) >= 0;) {
 *       work on it, and call comm_serve(&queue) now and then
 *     }
 *     comm_queue_end(&queue);
 *
 * Stopping. When *stop becomes true on a rank (by a signal handler), this rank gets no further
 * task, and the others learn of it in comm_serve, comm_next or comm_queue_end, which set their
 * *stop to 1: a signal to one rank stops the whole job.
 *
 * Invariants: no task is given out twice; all tasks are given out if no rank stops and some rank
 * asks until there are none left; after comm_queue_end no message is on its way. Ranks that wait
 * sleep and do not spin. When a rank dies the launcher has to end the others (mpirun does, srun
 * with --kill-on-bad-exit).
 */
#ifndef BASE_COMM_QUEUE_H
#define BASE_COMM_QUEUE_H

#include <signal.h>
#include <stdbool.h>
#include <stdint.h>

typedef struct comm_queue {
  int64_t n, next; /* number of tasks; number of the next task to give out (on rank 0 only) */
  volatile sig_atomic_t *stop; /* pointer to the caller's stop flag; may be NULL */
  bool stopped;                /* true: this rank gets no more tasks */
  bool ended; /* true: this rank sends nothing more, except the answer to an END message */
  int away;   /* on rank 0: number of other ranks that have called comm_queue_end */
  struct comm_letters *letters;
} comm_queue;

/* Starts a queue of n tasks; there may be one queue at a time. Every rank of comm_world calls it,
 * with the same n. stop: flag of the caller (see above), may be NULL. */
void comm_queue_begin(comm_queue *q, int64_t n, volatile sig_atomic_t *stop);
/* Returns the number of the next task, or -1 if there is none or the job is to stop. */
int64_t comm_next(comm_queue *q);
/* Handles the messages that have arrived, without waiting: rank 0 answers requests for tasks, and a
 * stop is passed on to other ranks. */
void comm_serve(comm_queue *q);
/* Ends the use of the queue on this rank; every rank calls it when it takes no more tasks, for any
 * reason. Returns when all ranks have called it; until then rank 0 still gives out tasks to ranks
 * that ask, and a stop is still passed on. */
void comm_queue_end(comm_queue *q);

#endif
