/* sweep_workers.c: processes that run the groups of a sweep, for -j; see sweep_run.c. */
#include <errno.h>
#include <math.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include "base/clock.h"
#include "app/app.h"
#include "app/sweep/sweep_scheduler.h"

static void tell_parent(void *user, size_t k, const session_progress *p) {
  const worker *me = user;
  sweep_tell(&me->cells[k], p);
}

static void tell_left(void *user, size_t k, const sweep_end *end) {
  const worker *me = user;
  sweep_tell_left(&me->cells[k], end);
}

/* In the worker; never returns. */
static void work(const scheduler *w, worker *me, pid_t parent) {
  prctl(PR_SET_PDEATHSIG, SIGTERM);
  if (getppid() != parent) _exit(SD_INTERRUPTED);
  sweep_options options = {.threads = (int)w->c->threads,
                           .force = w->c->force,
                           .stop = &app_stop,
                           .progress = tell_parent,
                           .left = tell_left,
                           .user = me};
  sweep_run(w->s, me->n, me->points, &options);
  _exit(SD_OK);
}

/* False with errno: no process could be started. */
static bool start(scheduler *w, worker *one, size_t n) {
  sweep_assign(one, n);
  fflush(NULL);
  pid_t parent = getpid(), pid = fork();
  if (pid == 0) work(w, one, parent);
  if (pid > 0) one->pid = pid;
  return pid > 0;
}

/* Points of which it has said that it left them. */
static size_t hear(scheduler *w, worker *one) {
  size_t n = 0;
  for (size_t i = 0; i < one->n; i++) {
    int left = one->told[i] ? 0 : atomic_load(&one->cells[i].left);
    if (left == 0) continue;
    one->told[i] = true;
    sweep_account(w, one->points[i], (sd_status)(left - 1), one->cells[i].text, &one->cells[i],
                  clock_seconds() - one->started);
    n++;
  }
  return n;
}

/* How it died; "" when it ended by itself, with *status. */
static void describe_end(int ended, sd_status *status, char *text, size_t size) {
  *text = 0;
  *status = SD_ERROR_NUMERIC;
  int code = WIFEXITED(ended) ? WEXITSTATUS(ended) : -1;
  if (code == SD_OK || code == SD_INTERRUPTED)
    *status = (sd_status)code;
  else if (code == SD_ERROR_IO) /* memory_lacks has told of it */
    *status = SD_ERROR_IO;
  else if (WIFSIGNALED(ended) && app_stop)
    *status = SD_INTERRUPTED;
  else if (WIFSIGNALED(ended))
    snprintf(text, size, "was ended by signal %d (%s)", WTERMSIG(ended), strsignal(WTERMSIG(ended)));
  else
    snprintf(text, size, "ended with status %d", code);
}

/* Which point of a group is to blame is not known: each is run again, by itself. */
static void try_again(scheduler *w, const worker *one, const char *how) {
  size_t n = 0;
  for (size_t i = 0; i < one->n; i++) {
    if (one->told[i]) continue;
    const cell *mine = &one->cells[i];
    size_t point = one->points[i];
    double steps = (double)w->steps[point];
    w->tried[point] = CRASHED;
    w->steps_done += (mine->fraction - fmax(mine->began, 0)) * steps;
    w->steps_total -= (1 - mine->fraction + fmax(mine->began, 0)) * steps;
    n++;
  }
  sweep_clear_line(w);
  fprintf(stderr, "warning: the process that ran %zu points side by side %s; they are run again one by one\n",
          n, how);
}

static void finish(scheduler *w, worker *one, int ended) {
  char how[200], text[300] = "";
  sd_status status;
  size_t missing = 0;
  hear(w, one);
  one->pid = 0;
  for (size_t i = 0; i < one->n; i++) missing += !one->told[i];
  if (missing == 0) return;
  describe_end(ended, &status, how, sizeof how);
  if (status == SD_ERROR_IO) snprintf(text, sizeof text, "no memory");
  if (*how && one->n > 1) {
    try_again(w, one, how);
    return;
  }
  if (*how) snprintf(text, sizeof text, "the process that ran it %s", how);
  for (size_t i = 0; i < one->n; i++) {
    if (one->told[i]) continue;
    size_t point = one->points[i];
    /* it may have ended after its result was complete */
    bool done = sweep_peek(w->s, point) == SWEEP_DONE;
    if (*text && !done) sweep_note(w->s, point, text);
    sweep_account(w, point, done ? SD_OK : status, done ? "" : text, &one->cells[i],
                  clock_seconds() - one->started);
  }
}

/* Takes up what workers have left, and those who have ended; how many points and workers. */
static size_t reap(scheduler *w) {
  size_t n = 0;
  for (size_t k = 0; k < w->n_workers; k++) {
    worker *one = &w->workers[k];
    int ended;
    if (one->pid == 0) continue;
    if (waitpid(one->pid, &ended, WNOHANG) == one->pid) {
      finish(w, one, ended);
      n++;
    } else {
      n += hear(w, one);
    }
  }
  return n;
}

static size_t count_running(const scheduler *w) {
  size_t n = 0;
  for (size_t k = 0; k < w->n_workers; k++) n += w->workers[k].pid != 0;
  return n;
}

static void pass_stop_on(scheduler *w, bool *told) {
  for (size_t k = 0; k < w->n_workers && !*told; k++)
    if (w->workers[k].pid > 0) kill(w->workers[k].pid, SIGTERM);
  *told = true;
}

/* Gives work to whoever is idle, until there is none: *more. Returns errno when no process can be started; the points
 * then wait with their worker. */
static int start_idle(scheduler *w, bool *more) {
  for (size_t k = 0; k < w->n_workers && !app_stop; k++) {
    worker *one = &w->workers[k];
    if (one->pid != 0) continue;
    if (one->waiting == 0 && *more) {
      one->waiting = sweep_next(w, one->points);
      *more = one->waiting > 0;
    }
    if (one->waiting == 0) continue;
    if (!start(w, one, one->waiting)) return errno;
    one->waiting = 0;
  }
  return 0;
}

void sweep_run_workers(scheduler *w) {
  bool more = true, told_to_stop = false;
  int error;
  long pause = 1000000; /* ns; grows to 20 ms while nothing happens */
  do {
    error = app_stop ? 0 : start_idle(w, &more);
    if (error && count_running(w) == 0) {
      sweep_clear_line(w);
      fprintf(stderr, "error: cannot start a process: %s\n", strerror(error));
      sweep_worsen(w, SD_ERROR_IO);
      return;
    }
    if (app_stop) pass_stop_on(w, &told_to_stop);
    sweep_draw(w);
    pause = reap(w) > 0 ? 1000000 : pause < 10000000 ? 2 * pause : 20000000;
    if (count_running(w) > 0) nanosleep(&(struct timespec){.tv_nsec = pause}, NULL);
  } while (count_running(w) > 0 || ((more || error) && !app_stop));
}
