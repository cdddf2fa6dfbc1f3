/* team.h: the threads that advance one simulation together, all running the same code.
 *
 * Work is divided into contiguous ranges, and each loop writes only its own indices, so results do
 * not depend on the number of threads. A team of one thread has no overhead.
 *
 * The threads of a pool wait for tasks, which the leader (the thread that made the pool or holds
 * its simulation) gives to all of them with pool_run. Within a long task the leader can work on
 * alone and give shorter tasks while the others wait in team_help:
 *
 *     if (t->rank == 0) { team_lead(t); ... pool_run(pool, ...) ... team_release(t); } else
 * team_help(t);
 *
 * Threads that wait spin for some microseconds, then sleep (team.c).
 */
#ifndef BASE_TEAM_H
#define BASE_TEAM_H

#include <stdbool.h>
#include <stddef.h>

typedef struct pool pool;

typedef struct team {
  int rank, size;
  pool *pool; /* pool of threads; NULL in a team of one */
} team;

typedef void team_task(const team *t, void *with);

/* Creates a pool of `threads` threads, the caller included, or of fewer if the system does not
 * grant them. Never returns NULL. */
pool *pool_new(int threads);
/* Ends the threads, waits for them and frees the pool. In a forked child there are no threads to
 * wait for. */
void pool_free(pool *c);
/* Runs the task on all threads, each with its rank in the team; returns when all have finished. If
 * the pool is NULL or is already running a task, the caller runs the task alone. */
void pool_run(pool *c, team_task *task, void *with);
/* Runs the task with a temporary pool of pool_most() threads. With few items (1024 or less) the
 * caller runs it alone. */
void pool_run_once(size_t items, team_task *task, void *with);
/* Returns true if this process was forked from the one that started the pool's threads, so that the
 * threads do not exist here. pool_run then starts them anew. */
bool pool_forked(const pool *c);
/* Returns how many threads this process may use at once: OMP_NUM_THREADS if set, else the number of
 * its cores. */
int pool_most(void);

void team_lead(const team *t);
void team_release(const team *t);
void team_help(const team *t);

/* Lets the processor rest for a moment in a loop that waits. */
static inline void team_pause(void) {
#if defined(__x86_64__) || defined(__i386__)
  __builtin_ia32_pause();
#endif
}

void team_wait_all(const team *t);
/* Barrier: waits until all threads of the team have called it. Writes before the barrier are
 * visible to all threads after it. */
static inline void team_wait(const team *t) {
  if (t->size > 1) team_wait_all(t);
}

/* Sets [*begin, *end) to this thread's range of n items. Bounds are multiples of 8 (the last one is
 * n), so that vectors are not split. */
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

/* --- a monotonic clock, for progress reports and for measuring run times ---------------------- */

/* Returns the time in seconds since an arbitrary fixed moment; it never goes backwards. */
double clock_seconds(void);

#endif
