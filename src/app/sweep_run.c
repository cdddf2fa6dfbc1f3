/* sweep_run.c: runs the points of a sweep.
 *
 * With -j N each point is run by a process of its own: what goes wrong in one, even a crash, does not touch the others.
 * Workers tell how far they are through shared memory, all else through the folder. Without -j points are run one after
 * the other here, or shared among the ranks of an MPI job. Ctrl-C and its like go to all workers; they stop
 * at checkpoints.
 */
#ifndef _GNU_SOURCE
#define _GNU_SOURCE
#endif
#include <errno.h>
#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include "app/app.h"
#include "app/sweep.h"
#include "base/comm.h"

static const double TABLE_SECONDS = 15; /* between tables while points are run */

/* What a worker tells while it runs. */
typedef struct slot {
  volatile double fraction; /* of its steps */
  volatile double began;    /* fraction at its first report; negative: none yet */
} slot;

typedef struct worker {
  pid_t pid; /* 0: idle */
  size_t point;
  double started;
} worker;

typedef struct crew {
  const sweep *s;
  const sweep_command *c;
  int64_t *steps; /* [n_points] */
  size_t done, failed, elsewhere, stopped, finished_here;
  int worst; /* exit status */
  double began, tabled, drawn;
  double steps_total, steps_done; /* of the points that this call runs */
  bool terminal, line_open;
  size_t n_workers;
  worker *workers;
  slot *slots; /* [n_workers], shared */
  comm_queue *queue;
} crew;

static double now_seconds(void) {
  struct timespec t;
  clock_gettime(CLOCK_MONOTONIC, &t);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* --- screen ------------------------------------------------------------------------------------------------ */

static void clear_line(crew *w) {
  if (w->line_open) fputs("\r\033[K", stderr);
  w->line_open = false;
}

/* A line that stays. */
static void tell(crew *w, size_t point, const sweep_result *r, double seconds) {
  char finding[200], duration[40];
  bool bad = r->status == SWEEP_FAILED || r->status == SWEEP_OTHER;
  if (w->c->quiet && !bad) return;
  clear_line(w);
  fprintf(stderr, "[%zu/%zu] point %zu, %s: ", w->done + w->failed, w->s->deck.n_points, point,
          w->s->deck.points[point].name);
  if (r->status == SWEEP_DONE)
    fprintf(stderr, "%s  (%s)\n", sweep_finding(r, finding, sizeof finding),
            report_duration(seconds, duration, sizeof duration));
  else
    fprintf(stderr, "%s%s%s\n", sweep_status_names[r->status], bad ? ": " : "",
            r->status == SWEEP_OTHER ? "a result of another deck is there; --force runs the point again"
                                     : r->message);
}

/* The line at the bottom of a terminal. */
static void draw(crew *w) {
  double now = now_seconds(), progressed = w->steps_done, left = NAN;
  if (!w->terminal || w->c->quiet || now - w->drawn < 0.5) return;
  w->drawn = now;
  char text[400], duration[40];
  int n = snprintf(text, sizeof text, "%zu of %zu done", w->done, w->s->deck.n_points);
  if (w->failed) n += snprintf(text + n, sizeof text - (size_t)n, ", %zu failed", w->failed);
  for (size_t k = 0; k < w->n_workers; k++) {
    if (w->workers[k].pid == 0) continue;
    double part = w->slots[k].fraction, since = fmax(w->slots[k].began, 0);
    progressed += (part - since) * (double)w->steps[w->workers[k].point];
    if ((size_t)n + 60 < sizeof text)
      n += snprintf(text + n, sizeof text - (size_t)n, "  #%zu %.0f %%", w->workers[k].point, 100 * part);
  }
  if (progressed > 0) left = (w->steps_total - progressed) / progressed * (now - w->began);
  snprintf(text + n, sizeof text - (size_t)n, "  ETA %s", report_duration(left, duration, sizeof duration));
  struct winsize window;
  int width = ioctl(STDERR_FILENO, TIOCGWINSZ, &window) == 0 && window.ws_col > 0 ? window.ws_col - 1 : 100;
  fprintf(stderr, "\r\033[K%.*s", width, text);
  fflush(stderr);
  w->line_open = true;
}

/* --- results ----------------------------------------------------------------------------------------------- */

static void make_tables(crew *w, bool always) {
  double now = now_seconds();
  if (!always && now - w->tabled < TABLE_SECONDS) return;
  sd_messages *messages = sd_messages_new();
  sd_status status = sweep_write_tables(w->s, messages);
  if (always || status != SD_OK) {
    clear_line(w);
    sd_messages_print(messages, stderr);
  }
  if (status != SD_OK && w->worst < (int)status) w->worst = status;
  sd_messages_free(messages);
  w->tabled = now_seconds();
}

/* A point has been left: what does the folder say? status: of the process or call that ran it. */
static void account(crew *w, size_t point, sd_status status, double seconds) {
  sweep_result r;
  sd_status looked = sweep_look(w->s, point, &r, NULL);
  switch (r.status) {
    case SWEEP_DONE: w->done++; break;
    case SWEEP_RUNNING: w->elsewhere++; break;
    case SWEEP_WAITING:
    case SWEEP_STOPPED: w->stopped++; break;
    default:
      w->failed++;
      if (w->worst < SD_ERROR_NUMERIC) w->worst = SD_ERROR_NUMERIC;
  }
  w->finished_here += r.status == SWEEP_DONE;
  w->steps_done += (double)w->steps[point];
  if (status == SD_ERROR_IO || looked != SD_OK) w->worst = SD_ERROR_IO;
  tell(w, point, &r, seconds);
  sweep_result_free(&r);
  make_tables(w, false);
}

/* --- processes --------------------------------------------------------------------------------------------- */

static void tell_parent(void *user, const session_progress *p) {
  slot *mine = user;
  mine->fraction = p->steps > 0 ? (double)p->step / (double)p->steps : 0;
  if (mine->began < 0) mine->began = mine->fraction;
}

/* In the worker; never returns. */
static void work(const crew *w, size_t point, slot *mine, pid_t parent) {
  prctl(PR_SET_PDEATHSIG, SIGTERM);
  if (getppid() != parent) _exit(SD_INTERRUPTED);
  sweep_options options = {.threads = w->c->threads,
                           .force = w->c->force,
                           .stop = &app_stop,
                           .progress = tell_parent,
                           .user = mine};
  sd_messages *messages = sd_messages_new();
  sweep_status what;
  _exit((int)sweep_run(w->s, point, &options, &what, messages));
}

/* False: no process could be started. */
static bool start(crew *w, size_t k, size_t point) {
  w->slots[k].fraction = 0;
  w->slots[k].began = -1;
  fflush(NULL);
  pid_t parent = getpid(), pid = fork();
  if (pid == 0) work(w, point, &w->slots[k], parent);
  if (pid < 0) return false;
  w->workers[k] = (worker){pid, point, now_seconds()};
  return true;
}

static void finish(crew *w, worker *one, int ended) {
  char text[120];
  size_t point = one->point;
  sd_status status = WIFEXITED(ended) ? (sd_status)WEXITSTATUS(ended) : SD_ERROR_NUMERIC;
  if (WIFSIGNALED(ended) && !app_stop) {
    snprintf(text, sizeof text, "the process that ran it was ended by signal %d (%s)\n", WTERMSIG(ended),
             strsignal(WTERMSIG(ended)));
    sweep_note(w->s, point, text);
  }
  one->pid = 0;
  account(w, point, status, now_seconds() - one->started);
}

/* Takes up workers that have ended; the number still running. */
static size_t reap(crew *w) {
  size_t running = 0;
  for (size_t k = 0; k < w->n_workers; k++) {
    worker *one = &w->workers[k];
    int ended;
    if (one->pid == 0) continue;
    if (waitpid(one->pid, &ended, WNOHANG) == one->pid)
      finish(w, one, ended);
    else
      running++;
  }
  return running;
}

static void run_workers(crew *w, const size_t *todo, size_t n) {
  size_t next = 0, running = 0;
  bool told_to_stop = false;
  do {
    for (size_t k = 0; k < w->n_workers && next < n && !app_stop; k++)
      if (w->workers[k].pid == 0 && start(w, k, todo[next])) next++;
    size_t before = running;
    running = reap(w);
    if (next < n && running == 0 && before == 0 && !app_stop) {
      fprintf(stderr, "error: cannot start a process: %s\n", strerror(errno));
      w->worst = SD_ERROR_IO;
      return;
    }
    if (app_stop && !told_to_stop) {
      for (size_t k = 0; k < w->n_workers; k++)
        if (w->workers[k].pid > 0) kill(w->workers[k].pid, SIGTERM);
      told_to_stop = true;
    }
    draw(w);
    if (running > 0) nanosleep(&(struct timespec){.tv_nsec = 2000000}, NULL);
  } while (running > 0 || (next < n && !app_stop));
}

/* --- here, or in ranks ------------------------------------------------------------------------------------- */

static void serve(void *user, const session_progress *p) {
  crew *w = user;
  comm_serve(w->queue);
  w->slots[0].fraction = p->steps > 0 ? (double)p->step / (double)p->steps : 0;
  if (w->slots[0].began < 0) w->slots[0].began = w->slots[0].fraction;
  if (comm_size() == 1) draw(w);
}

static void run_queue(crew *w, const size_t *todo, size_t n) {
  comm_queue queue;
  comm_queue_begin(&queue, (int64_t)n, &app_stop);
  w->queue = &queue;
  for (int64_t k; (k = comm_next(&queue)) >= 0;) {
    sweep_options options = {
        .threads = w->c->threads, .force = w->c->force, .stop = &app_stop, .progress = serve, .user = w};
    sd_messages *messages = sd_messages_new();
    sweep_status what;
    w->workers[0] = (worker){1, todo[k], now_seconds()};
    w->slots[0] = (slot){0, -1};
    bool was_done = !w->c->force && sweep_peek(w->s, todo[k]) == SWEEP_DONE;
    sd_status status = sweep_run(w->s, todo[k], &options, &what, messages);
    w->workers[0].pid = 0;
    if (!was_done || status != SD_OK) account(w, todo[k], status, now_seconds() - w->workers[0].started);
    sd_messages_free(messages);
  }
  comm_queue_end(&queue);
}

/* --- all points -------------------------------------------------------------------------------------------- */

/* Points to be run, in order; those that are done are counted, and those of another deck told. */
static size_t find_todo(crew *w, size_t *todo) {
  size_t n = 0;
  for (size_t k = 0; k < w->s->deck.n_points; k++) {
    sweep_result r = {.status = SWEEP_WAITING};
    if (!w->c->force) sweep_look(w->s, k, &r, NULL);
    if (r.status == SWEEP_DONE) {
      w->done++;
    } else if (r.status == SWEEP_OTHER) {
      w->failed++;
      w->worst = SD_ERROR_USER;
      if (comm_rank() == 0) tell(w, k, &r, 0);
    } else {
      todo[n++] = k;
      w->steps_total += (double)w->steps[k];
    }
    sweep_result_free(&r);
  }
  return n;
}

/* Ranks must agree on the list, and the folder may change between their looks at it: each skips what is done when
 * its turn comes. */
static size_t take_all(crew *w, size_t *todo) {
  for (size_t k = 0; k < w->s->deck.n_points; k++) {
    todo[k] = k;
    w->done += !w->c->force && sweep_peek(w->s, k) == SWEEP_DONE;
  }
  return w->s->deck.n_points;
}

static void tell_end(crew *w) {
  clear_line(w);
  if (w->c->quiet) return;
  fprintf(stderr, "%zu of %zu points done", w->done, w->s->deck.n_points);
  if (w->failed) fprintf(stderr, ", %zu failed", w->failed);
  if (w->elsewhere) fprintf(stderr, ", %zu run by another process", w->elsewhere);
  fprintf(stderr, "; table: %s/table.csv\n", w->s->folder);
  if (app_stop) fprintf(stderr, "stopped, everything is saved: give the command again to continue\n");
}

static int run_all(crew *w, size_t *todo) {
  bool first = comm_rank() == 0;
  size_t n = comm_size() > 1 ? take_all(w, todo) : find_todo(w, todo);
  if (first && !w->c->quiet)
    fprintf(stderr, "%s: %zu points, %zu done\n", w->s->folder, w->s->deck.n_points, w->done);
  if (w->c->workers > 0)
    run_workers(w, todo, n);
  else
    run_queue(w, todo, n);
  /* ranks count what they did themselves: the folder knows the rest */
  if (comm_size() > 1 && first) {
    w->done = w->failed = w->elsewhere = 0;
    for (size_t k = 0; k < w->s->deck.n_points; k++) {
      sweep_status status = sweep_peek(w->s, k);
      w->done += status == SWEEP_DONE;
      w->failed += status == SWEEP_FAILED;
    }
  }
  if (first) make_tables(w, true);
  if (first) tell_end(w);
  if (app_stop || w->stopped) return SD_INTERRUPTED;
  return w->worst;
}

/* Mistakes of some points do not keep the others from being run. */
static int check(const sweep *s, int64_t *steps) {
  sd_messages *messages = sd_messages_new();
  size_t usable;
  int status = sweep_check(s, &usable, steps, messages);
  if (comm_rank() == 0) {
    sd_messages_print(messages, stderr);
    if (status != SD_OK && usable > 0)
      fprintf(stderr, "the points with these mistakes will fail; %zu of %zu sets of values are run\n", usable,
              s->deck.n_sets);
  }
  sd_messages_free(messages);
  return usable > 0 ? SD_OK : status;
}

static int prepare_and_run(crew *w, size_t *todo) {
  const sweep *s = w->s;
  int status = check(s, w->steps);
  if (status != SD_OK) return status;
  sd_messages *messages = sd_messages_new();
  status = sweep_prepare(s, messages);
  sd_messages_print(messages, stderr);
  sd_messages_free(messages);
  if (status != SD_OK && comm_size() > 1) comm_abort(status);
  return status == SD_OK ? run_all(w, todo) : status;
}

int sweep_run_all(const sweep *s, const sweep_command *c) {
  app_catch_signals();
  sd_messages *messages = sd_messages_new();
  int status = c->workers > 0 ? SD_OK : comm_begin(messages);
  sd_messages_print(messages, stderr);
  sd_messages_free(messages);
  if (status != SD_OK) return status;
  crew w = {.s = s,
            .c = c,
            .n_workers = c->workers > 0 ? (size_t)c->workers : 1,
            .terminal = isatty(STDERR_FILENO)};
  w.began = w.tabled = now_seconds();
  w.workers = calloc(w.n_workers, sizeof *w.workers);
  w.steps = calloc(s->deck.n_points + 1, sizeof *w.steps);
  size_t *todo = calloc(s->deck.n_points + 1, sizeof *todo);
  w.slots =
      mmap(NULL, w.n_workers * sizeof *w.slots, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  status = SD_ERROR_IO;
  if (w.workers && w.steps && todo && w.slots != MAP_FAILED) status = prepare_and_run(&w, todo);
  if (w.slots != MAP_FAILED) munmap(w.slots, w.n_workers * sizeof *w.slots);
  free(w.workers);
  free(w.steps);
  free(todo);
  if (c->workers == 0) {
    status = comm_max(status);
    comm_end();
  }
  return status;
}

/* --- one point --------------------------------------------------------------------------------------------- */

typedef struct note {
  const sweep *s;
  size_t point;
} note;

static void keep_note(void *user, const sd_messages *messages) {
  const note *n = user;
  if (sweep_peek(n->s, n->point) != SWEEP_RUNNING) sweep_note_messages(n->s, n->point, messages);
}

int sweep_run_one(const sweep *s, const sweep_command *c) {
  size_t point = (size_t)c->point;
  note n = {s, point};
  sd_messages *messages = sd_messages_new();
  char *result = NULL, again[40];
  sd_model *model = NULL;
  snprintf(again, sizeof again, "sweep ... --point %zu", point);
  sd_status status = sweep_prepare(s, messages);
  sweep_result r = {0};
  if (status == SD_OK && !c->force) status = sweep_look(s, point, &r, messages);
  bool done = status == SD_OK && !c->force && r.status == SWEEP_DONE;
  sweep_result_free(&r);
  if (status == SD_OK && !done) {
    status = sweep_load(s, point, &model, &result, messages);
    if (status != SD_OK) sweep_note_messages(s, point, messages);
  }
  if (done && !c->quiet)
    fprintf(stderr, "point %zu, %s, is done already\n", point, s->deck.points[point].name);
  if (status == SD_OK && !done) {
    drive_options drive = {.result = result,
                           .again = again,
                           .threads = c->threads,
                           .force = c->force,
                           .quiet = c->quiet,
                           .failed = keep_note,
                           .user = &n};
    status = drive_run(model, &drive, messages);
    if (status == SD_OK || status == SD_INTERRUPTED) sweep_note(s, point, NULL);
  } else {
    sd_messages_print(messages, stderr);
  }
  sd_model_free(model);
  free(result);
  sd_messages_free(messages);
  return status;
}
