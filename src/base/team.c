/* team.c: implements team.h. */
#include "base/team.h"

#include <assert.h>
#include <pthread.h>
#include <sched.h>
#include <stdalign.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdlib.h>
#include <time.h>
#include <unistd.h>

#include "base/memory.h"

/* Times of the barrier, s. A thread that waits spins first, then sleeps. On free cores the threads
 * of a step arrive within LONG_SPIN of each other. If a wait takes longer than SHORT_WAIT, the late
 * thread probably has no core, and a spinning thread may occupy the core it needs: waiting threads
 * then spin for SHORT_SPIN only, until CALM waits in a row were short. With more threads than cores
 * they always spin for SHORT_SPIN. They never yield: that would give other processes with work of
 * their own a whole time slice. */
static const double LONG_SPIN = 200e-6, SHORT_SPIN = 2e-6, SHORT_WAIT = 300e-6;
enum { SPINS_PER_LOOK = 16, CALM = 2, LINE = 64 };

typedef struct member {
  alignas(LINE) team team;
  int calm; /* number of waits in a row shorter than SHORT_WAIT, at most CALM */
} member;

struct pool {
  int size, started;
  unsigned forks; /* value of the counter `forks` (below) when the threads were started */
  bool helping; /* true while the other threads wait for tasks; only the leader (rank 0) uses it */
  bool crowded; /* true: there are more threads than cores */
  int depth;    /* nesting depth of the tasks that are running */
  team_task *task;
  void *with;
  pthread_t *thread; /* [started] the threads, except the leader */
  member *member;    /* [size] data of each thread */
  pthread_mutex_t lock;
  pthread_cond_t woken;
  /* state of the barrier: number of threads that have arrived, number of barriers passed, number of
   * sleeping threads */
  alignas(LINE) atomic_int arrived;
  alignas(LINE) atomic_uint round;
  atomic_int sleepers;
};

/* --- detection of fork ------------------------------------------------------------------------ */

/* Number of forks between the first process and this one. If it differs from the number stored in a
 * pool, the pool's threads stayed in a parent process. */
static atomic_uint forks;
static pthread_once_t counting = PTHREAD_ONCE_INIT;
static void count_fork(void) { atomic_fetch_add(&forks, 1); }
static void count_forks(void) { pthread_atfork(NULL, NULL, count_fork); }

bool pool_forked(const pool *c) {
  return c && c->size > 1 && c->forks != atomic_load_explicit(&forks, memory_order_relaxed);
}

/* --- barrier ---------------------------------------------------------------------------------- */

static bool spin(const pool *c, unsigned round, double began, double most) {
  do {
    for (int k = 0; k < SPINS_PER_LOOK; k++) {
      if (atomic_load_explicit(&c->round, memory_order_acquire) != round) return true;
      team_pause();
    }
  } while (clock_seconds() - began < most);
  return false;
}

/* Sleeps until the barrier has left this round. No wake-up is lost: either this thread sees the new
 * round, or the last thread to arrive sees the sleeper and wakes it. */
static void sleep_until(pool *c, unsigned round) {
  pthread_mutex_lock(&c->lock);
  atomic_fetch_add(&c->sleepers, 1);
  while (atomic_load(&c->round) == round) pthread_cond_wait(&c->woken, &c->lock);
  atomic_fetch_sub(&c->sleepers, 1);
  pthread_mutex_unlock(&c->lock);
}

static void wake(pool *c) {
  pthread_mutex_lock(&c->lock);
  pthread_cond_broadcast(&c->woken);
  pthread_mutex_unlock(&c->lock);
}

void team_wait_all(const team *t) {
  pool *c = t->pool;
  const unsigned round = atomic_load_explicit(&c->round, memory_order_relaxed);
  assert(t->size == c->size);
  if (pool_forked(c))
    /* The process was forked within a task: the other threads are missing, and the result is not
     * used. */
    return;
  if (atomic_fetch_add_explicit(&c->arrived, 1, memory_order_acq_rel) + 1 == c->size) {
    atomic_store_explicit(&c->arrived, 0, memory_order_relaxed);
    atomic_store(&c->round, round + 1);
    if (atomic_load(&c->sleepers) > 0) wake(c);
    return;
  }
  int *calm = &c->member[t->rank].calm;
  const double began = clock_seconds();
  if (!spin(c, round, began, *calm < CALM || c->crowded ? SHORT_SPIN : LONG_SPIN)) {
    sleep_until(c, round);
    if (clock_seconds() - began > SHORT_WAIT) *calm = 0;
  }
  if (*calm < CALM) ++*calm;
}

/* --- tasks ------------------------------------------------------------------------------------ */

void team_help(const team *t) {
  const pool *c = t->pool;
  assert(t->rank > 0);
  for (;;) {
    team_wait(t);
    if (!c->task) return;
    c->task(t, c->with);
    team_wait(t);
  }
}

void team_lead(const team *t) {
  assert(t->rank == 0);
  if (t->size > 1) t->pool->helping = true;
}

void team_release(const team *t) {
  if (t->size == 1) return;
  t->pool->helping = false;
  t->pool->task = NULL;
  team_wait(t);
}

static void start_threads(pool *c, int threads);

void pool_run(pool *c, team_task *task, void *with) {
  if (pool_forked(c) && c->depth == 0) start_threads(c, c->size);
  if (pool_forked(c) || !c || !c->helping || c->size == 1) {
    task(&(team){.size = 1}, with);
    return;
  }
  c->helping = false;
  c->depth++;
  c->task = task;
  c->with = with;
  team_wait(&c->member[0].team);
  task(&c->member[0].team, with);
  team_wait(&c->member[0].team);
  c->depth--;
  c->helping = true;
}

/* --- threads ---------------------------------------------------------------------------------- */

/* Returns the number of cores that this process may use. */
static int cores(void) {
#ifdef __linux__
  cpu_set_t set;
  CPU_ZERO(&set);
  if (sched_getaffinity(0, sizeof set, &set) == 0) return CPU_COUNT(&set);
#endif
  const long all = sysconf(_SC_NPROCESSORS_ONLN);
  return all > 0 ? (int)all : 1;
}

static void *help(void *with) {
  const team *t = with;
  pool *c = t->pool;
  pthread_mutex_lock(&c->lock); /* Wait until all threads have been started. */
  pthread_mutex_unlock(&c->lock);
  team_help(t);
  return NULL;
}

/* Starts threads until there are `threads` of them, the caller included, or as many as the system
 * grants. */
static void start_threads(pool *c, int threads) {
  pthread_once(&counting, count_forks);
  c->forks = atomic_load(&forks);
  c->started = 0;
  atomic_store(&c->arrived, 0);
  atomic_store(&c->sleepers, 0);
  pthread_mutex_init(&c->lock, NULL);
  pthread_cond_init(&c->woken, NULL);
  pthread_mutex_lock(&c->lock);
  while (c->started + 1 < threads) {
    team *t = &c->member[c->started + 1].team;
    *t = (team){.rank = c->started + 1, .pool = c};
    if (pthread_create(&c->thread[c->started], NULL, help, t) != 0) break;
    c->started++;
  }
  c->size = c->started + 1;
  c->crowded = c->size > cores();
  c->member[0].team.pool = c;
  for (int k = 0; k < c->size; k++) c->member[k].team.size = c->size;
  pthread_mutex_unlock(&c->lock);
}

pool *pool_new(int threads) {
  assert(threads > 0);
  pool *c = memory_lines(sizeof *c);
  c->thread = memory_new((size_t)threads, sizeof *c->thread);
  c->member = memory_lines((size_t)threads * sizeof *c->member);
  c->helping = true;
  start_threads(c, threads);
  return c;
}

void pool_free(pool *c) {
  if (!c) return;
  assert(c->thread && c->member);
  if (!pool_forked(c)) {
    assert(c->helping);
    if (c->size > 1) team_release(&c->member[0].team);
    for (int k = 0; k < c->started; k++) pthread_join(c->thread[k], NULL);
    pthread_mutex_destroy(&c->lock);
    pthread_cond_destroy(&c->woken);
  }
  free(c->thread);
  free(c->member);
  free(c);
}

int pool_most(void) {
  const char *asked = getenv("OMP_NUM_THREADS");
  const int n = asked ? atoi(asked) : 0;
  return n > 0 ? n : cores();
}

void pool_run_once(size_t items, team_task *task, void *with) {
  enum { FEW = 1024 }; /* number of items below which starting threads does not pay */
  pool *c = items > FEW ? pool_new(pool_most()) : NULL;
  pool_run(c, task, with);
  pool_free(c);
}

/* --- the clock -------------------------------------------------------------------------------- */

double clock_seconds(void) {
  struct timespec t;
  clock_gettime(CLOCK_MONOTONIC, &t);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}
