/* team.h: the threads that advance one simulation together, all in the same code.
 *
 * Work is shared by contiguous ranges, and each loop writes only its own indices, so results do not depend
 * on the number of threads. A team of one costs nothing.
 *
 * A pool has threads that help: they wait for tasks that the leader, the thread which made the pool or holds its simulation,
 * gives to all with pool_run. Within a long task the leader can go on alone, and give shorter tasks while the others help:
 *
 *     if (t->rank == 0) { team_lead(t); ... pool_run(pool, ...) ... team_release(t); } else team_help(t);
 *
 * Threads that wait look for some microseconds, then sleep (team.c).
 */
#ifndef BASE_TEAM_H
#define BASE_TEAM_H

#include <stdbool.h>
#include <stddef.h>

typedef struct pool pool;

typedef struct team {
  int rank, size;
  pool *pool; /* of more than one */
} team;

typedef void team_task(const team *t, void *with);

/* A pool has so many threads, with the one that calls, or fewer if the system gives no more. It
 * is never NULL. */
pool *pool_new(int threads);
/* Waits until the threads have ended. A child of fork has none to wait for. */
void pool_free(pool *c);
/* All threads do the task, each with its rank; returns when all are through. Without a pool, or while its threads are at work
 * on another task, the caller does it alone. */
void pool_run(pool *c, team_task *task, void *with);
/* Does the task with threads of its own, as many as there may be, if there are enough items for
 * them. */
void pool_run_once(size_t items, team_task *task, void *with);
/* True: this process was forked from the one that made its threads, and they are not here. pool_run then starts them anew. */
bool pool_forked(const pool *c);
/* How many threads this process may use at once: OMP_NUM_THREADS, else its cores. */
int pool_most(void);

void team_lead(const team *t);
void team_release(const team *t);
void team_help(const team *t);

void team_wait_all(const team *t);
/* Waits for the whole team; what was written before is seen after. */
static inline void team_wait(const team *t) {
  if (t->size > 1) team_wait_all(t);
}

/* This thread's part [*begin, *end) of n items, in multiples of 8 so that vectors are not split. */
static inline void team_share(const team *t, size_t n, size_t *begin, size_t *end) {
  if (t->size == 1) {
    *begin = 0;
    *end = n;
    return;
  }
  size_t blocks = (n + 7) / 8, size = (size_t)t->size, rank = (size_t)t->rank;
  *begin = blocks * rank / size * 8;
  *end = blocks * (rank + 1) / size * 8;
  if (*begin > n) *begin = n;
  if (*end > n) *end = n;
}

#endif
