/* comm.h: the ranks of a parallel job, and a queue of tasks that they share.
 *
 * A build with -DSLIPDISK_MPI=ON runs over MPI; any other has one rank and the same functions. Only base/comm*.c
 * sees mpi.h. All calls come from the thread that called comm_begin; a process that forks workers does so
 * before comm_begin, or does not call it.
 *
 * The queue. Tasks 0 ... n-1 go to whoever asks next. Rank 0 holds the counter and works like the others: it
 * answers them in comm_serve, which every rank calls a few times a second while it works on a task. So a rank
 * waits for its next task for as long as rank 0 goes without comm_serve; tasks should take longer than that.
 *
 *     comm_queue queue;
 *     comm_queue_begin(&queue, n, &stop);
 *     for (int64_t task; (task = comm_next(&queue)) >= 0;) { work on it, comm_serve(&queue) now and then }
 *     comm_queue_end(&queue);
 *
 * Stopping. When *stop becomes true on a rank (a signal), it gets no other task, and the others hear of it in
 * comm_serve, comm_next or comm_queue_end, which set their *stop to 1: a signal to one rank stops the whole job.
 *
 * Invariants: no task is given out twice, and all are given out when nobody stops and some rank asks until there
 * is none; after comm_queue_end no message is under way. Waits sleep, they do not spin. When a rank dies the
 * launcher has to end the others (mpirun does, srun with --kill-on-bad-exit).
 */
#ifndef BASE_COMM_H
#define BASE_COMM_H

#include <signal.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "slipdisk/status.h"

/* Starts MPI; one rank when no launcher started the program. Before it and after comm_end there is one rank, too.
 * SD_ERROR_USER: a launcher started several processes that do not know of each other, since this is a build
 * without MPI or for another MPI. SD_ERROR_IO: MPI does not start. */
sd_status comm_begin(sd_messages *messages);
/* Waits for all ranks. Does nothing when comm_begin was not called or failed. */
void comm_end(void);

int comm_rank(void);
int comm_size(void);
/* The largest value of all ranks, on all ranks; every rank must call it. It serves as a barrier as well. */
int comm_max(int value);
/* What rank 0 has at data, on all ranks; every rank must call it with the same size. */
void comm_share(void *data, size_t bytes);
/* Ends the processes of all ranks at once with this exit status, after an error that leaves the others waiting
 * for ever. With one rank it does nothing: to end the process is the caller's affair. */
void comm_abort(int status);
/* The same with SD_ERROR_IO, after what comm_on_fail was given has told why. */
void comm_fail(const char *why);
void comm_on_fail(void (*tell)(const char *why));

typedef struct comm_queue {
  int64_t n, next;             /* next: on rank 0 */
  volatile sig_atomic_t *stop; /* the caller's */
  bool stopped;                /* this rank gets no more tasks */
  bool ended;                  /* nothing more is sent but the answer to END */
  int away;                    /* rank 0: how many of the others are in comm_queue_end */
} comm_queue;

/* Every rank calls it, with the same n. stop may be NULL. One queue at a time. */
void comm_queue_begin(comm_queue *q, int64_t n, volatile sig_atomic_t *stop);
/* The next task, or -1 when there is none or the job is to stop. */
int64_t comm_next(comm_queue *q);
/* Never waits. Rank 0 answers those who ask; a stop is passed on. */
void comm_serve(comm_queue *q);
/* Every rank calls it when it takes no more tasks, for whatever reason. Returns when all are here; till then
 * rank 0 gives tasks to those who still ask, and a stop is still passed on. */
void comm_queue_end(comm_queue *q);

#endif
