/* comm_queue.h: a queue of tasks that the ranks of a job share.
 *
 * Tasks 0 ... n-1 go to whoever asks next. Rank 0 holds the counter and works like the others: it
 * answers them in comm_serve, which every rank calls a few times a second while it works on a
 * task. So a rank waits for its next task for as long as rank 0 goes without comm_serve; tasks
 * should take longer than that.
 *
 *     comm_queue queue;
 *     comm_queue_begin(&queue, n, &stop);
 * for (int64_t task; (task = comm_next(&queue)) >= 0;) { work on it, comm_serve(&queue) now and
 * then }
 *     comm_queue_end(&queue);
 *
 * Stopping. When *stop becomes true on a rank (a signal), it gets no other task, and the others
 * hear of it in comm_serve, comm_next or comm_queue_end, which set their *stop to 1: a signal to
 * one rank stops the whole job.
 *
 * Invariants: no task is given out twice, and all are given out when no rank stops and some rank
 * asks until there is none; after comm_queue_end no message is under way. Waits sleep, they do
 * not spin. When a rank dies the launcher has to end the others (mpirun does, srun with
 * --kill-on-bad-exit).
 */
#ifndef BASE_COMM_QUEUE_H
#define BASE_COMM_QUEUE_H

#include <signal.h>
#include <stdbool.h>
#include <stdint.h>

typedef struct comm_queue {
  int64_t n, next;             /* next: on rank 0 */
  volatile sig_atomic_t *stop; /* the caller's */
  bool stopped;                /* this rank gets no more tasks */
  bool ended;                  /* nothing more is sent but the answer to END */
  int away;                    /* rank 0: how many of the others are in comm_queue_end */
  struct comm_letters *letters;
} comm_queue;

/* Every rank of comm_world calls it, with the same n. stop may be NULL. One queue at a time. */
void comm_queue_begin(comm_queue *q, int64_t n, volatile sig_atomic_t *stop);
/* The next task, or -1 when there is none or the job is to stop. */
int64_t comm_next(comm_queue *q);
/* Never waits. Rank 0 answers those who ask; a stop is passed on. */
void comm_serve(comm_queue *q);
/* Every rank calls it when it takes no more tasks, for whatever reason. Returns when all are
 * here; till then rank 0 gives tasks to those who still ask, and a stop is still passed on. */
void comm_queue_end(comm_queue *q);

#endif
