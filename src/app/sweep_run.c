/* sweep_run.c: runs the points of a sweep.
 *
 * With -j N each point is run by a process of its own: what goes wrong in one, even a crash, does not touch the others.
 * Workers tell how far they are and what went wrong through shared memory, all else through the folder. Without -j
 * points are run one after the other here, or shared among the ranks of an MPI job.
 *
 * Ctrl-C and its like go to all workers, which stop at checkpoints. A signal may come at any moment: a worker
 * inherits app_stop, so one that came before the fork stops it too, and one that comes after is passed on. A
 * worker whose parent is gone gets SIGTERM from the kernel.
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
#include "io/file.h"

/* Between tables while points are run: at least so long, and a multiple of what the last ones took. */
static const double TABLE_SECONDS = 15, TABLE_SHARE = 20;
/* How long the last tables wait for another process that is writing them. */
static const double PATIENCE = 600, PATIENCE_STOPPED = 10;

/* What a worker tells. */
typedef struct slot {
  volatile double fraction; /* of its steps */
  volatile double began;    /* fraction at its first report; negative: none yet */
  char text[1000];          /* its messages, a line each; to be read when it has ended */
} slot;

typedef struct worker {
  pid_t pid; /* 0: idle */
  size_t point;
  double started;
} worker;

/* What became of a point in this call. SKIPPED: another process was running it when its turn came. */
typedef enum attempt { UNTRIED, SKIPPED, TRIED } attempt;

typedef struct crew {
  const sweep *s;
  const sweep_command *c;
  int64_t *steps;       /* [n_points] */
  unsigned char *tried; /* [n_points], an attempt */
  size_t done, failed, refused, elsewhere, left;
  int worst; /* exit status */
  double began, tabled, table_cost, drawn;
  double steps_total, steps_done; /* of the points that this call runs */
  bool terminal, line_open, stars;
  size_t n_workers;
  worker *workers;
  slot *slots; /* [n_workers], shared */
  comm_queue queue;
} crew;

static double now_seconds(void) {
  struct timespec t;
  clock_gettime(CLOCK_MONOTONIC, &t);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static void worsen(crew *w, int status) {
  if (w->worst < status) w->worst = status;
}

/* --- screen ------------------------------------------------------------------------------------------------ */

static void clear_line(crew *w) {
  if (w->line_open) fputs("\r\033[K", stderr);
  w->line_open = false;
}

/* The lines of a worker, further in. */
static void tell_lines(const char *text) {
  for (size_t n; *text; text += n + (text[n] == '\n')) {
    n = strcspn(text, "\n");
    fprintf(stderr, "    %.*s\n", (int)n, text);
  }
}

static const char *short_duration(double seconds, char *text, size_t size) {
  if (seconds >= 60) return report_duration(seconds, text, size);
  snprintf(text, size, "%.1f s", seconds);
  return text;
}

/* A line that stays. text: what was said by the one that ran the point. */
static void tell(crew *w, size_t point, const sweep_result *r, const char *text, double seconds) {
  char finding[200], duration[40];
  bool bad = r->status >= SWEEP_FAILED;
  if (w->c->quiet && !bad) return;
  clear_line(w);
  fprintf(stderr, "[%zu/%zu] point %zu, %s: ", w->done + w->failed + w->refused, w->s->deck.n_points, point,
          w->s->deck.points[point].name);
  if (r->status == SWEEP_DONE) {
    sweep_finding(r, finding, sizeof finding);
    w->stars = w->stars || strchr(finding, '*');
    fprintf(stderr, "%s  (%s)\n", *finding ? finding : "done",
            short_duration(seconds, duration, sizeof duration));
    tell_lines(text);
  } else if (bad) {
    fprintf(stderr, "%s: %s%s\n", sweep_status_names[r->status], r->message,
            r->status > SWEEP_FAILED ? "; --force runs the point again" : "");
  } else {
    fprintf(stderr, "%s\n", sweep_status_names[r->status]);
  }
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

/* Those in between are left to another process that is writing them. */
static void make_tables(crew *w, bool last) {
  double start = now_seconds();
  if (!last && start - w->tabled < fmax(TABLE_SECONDS, TABLE_SHARE * w->table_cost)) return;
  sd_messages *messages = sd_messages_new();
  sd_status status = sweep_write_tables(w->s, !last ? 0 : app_stop ? PATIENCE_STOPPED : PATIENCE, messages);
  if (last || status == SD_ERROR_IO) {
    clear_line(w);
    sd_messages_print(messages, stderr);
    worsen(w, status);
  }
  sd_messages_free(messages);
  w->tabled = now_seconds();
  w->table_cost = w->tabled - start;
}

/* A point has been left: what does the folder say? status, text: of the process or call that ran it. */
static void account(crew *w, size_t point, sd_status status, const char *text, const slot *ran,
                    double seconds) {
  sweep_result r;
  sd_status looked = sweep_look(w->s, point, &r, NULL);
  if ((r.status == SWEEP_WAITING || r.status == SWEEP_STOPPED) && status != SD_INTERRUPTED) {
    /* not even the reason could be kept */
    r.status = SWEEP_FAILED;
    free(r.message);
    r.message = file_path("%.*s", (int)strcspn(text, "\n"), text);
  }
  double part = 1 - fmax(ran->began, 0);
  w->tried[point] = r.status == SWEEP_RUNNING ? SKIPPED : TRIED;
  w->done += r.status == SWEEP_DONE;
  w->failed += r.status == SWEEP_FAILED;
  w->refused += r.status > SWEEP_FAILED;
  if (r.status == SWEEP_FAILED) worsen(w, SD_ERROR_NUMERIC);
  if (r.status > SWEEP_FAILED) worsen(w, SD_ERROR_USER);
  if (status == SD_ERROR_IO || looked != SD_OK) worsen(w, SD_ERROR_IO);
  if (r.status == SWEEP_RUNNING)
    w->steps_total -= (double)w->steps[point];
  else
    w->steps_done += part * (double)w->steps[point];
  if (r.message) tell(w, point, &r, text, seconds);
  sweep_result_free(&r);
  make_tables(w, false);
}

/* Another process runs this point, or has finished it since the list was made. */
static bool is_taken(crew *w, size_t point) {
  sweep_status status = sweep_peek(w->s, point);
  bool finished = status == SWEEP_DONE && !w->c->force;
  if (!finished && status != SWEEP_RUNNING) return false;
  w->tried[point] = finished ? TRIED : SKIPPED;
  w->done += finished;
  w->steps_total -= (double)w->steps[point];
  return true;
}

/* A line each, "error: " or "warning: " before it, as many as there is room for. */
static void write_messages(const sd_messages *messages, char *text, size_t size) {
  *text = 0;
  FILE *out = fmemopen(text, size - 1, "w");
  if (!out) return;
  sd_messages_print(messages, out);
  fclose(out);
  text[size - 1] = 0;
}

/* --- processes --------------------------------------------------------------------------------------------- */

static void tell_parent(void *user, const session_progress *p) {
  slot *mine = user;
  mine->fraction = p->expected > 0 ? (double)p->step / (double)p->expected : 0;
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
  sd_status status = messages ? sweep_run(w->s, point, &options, &what, messages) : SD_ERROR_IO;
  write_messages(messages, mine->text, sizeof mine->text);
  _exit((int)status);
}

/* False with errno: no process could be started. */
static bool start(crew *w, size_t k, size_t point) {
  w->slots[k] = (slot){.began = -1};
  fflush(NULL);
  pid_t parent = getpid(), pid = fork();
  if (pid == 0) work(w, point, &w->slots[k], parent);
  if (pid < 0) return false;
  w->workers[k] = (worker){pid, point, now_seconds()};
  return true;
}

static bool is_status(int status) {
  return status == SD_OK || status == SD_ERROR_USER || status == SD_ERROR_NUMERIC || status == SD_ERROR_IO ||
         status == SD_INTERRUPTED;
}

static void finish(crew *w, size_t k, int ended) {
  worker *one = &w->workers[k];
  slot *mine = &w->slots[k];
  sd_status status = SD_ERROR_NUMERIC;
  char died[200] = "";
  if (WIFEXITED(ended) && is_status(WEXITSTATUS(ended)))
    status = (sd_status)WEXITSTATUS(ended);
  else if (WIFSIGNALED(ended) && app_stop)
    status = SD_INTERRUPTED;
  else if (WIFSIGNALED(ended))
    snprintf(died, sizeof died, "the process that ran it was ended by signal %d (%s)", WTERMSIG(ended),
             strsignal(WTERMSIG(ended)));
  else
    snprintf(died, sizeof died, "the process that ran it ended with status %d", WEXITSTATUS(ended));
  if (*died) sweep_note(w->s, one->point, died);
  one->pid = 0;
  account(w, one->point, status, *died ? died : mine->text, mine, now_seconds() - one->started);
}

/* Takes up workers that have ended; how many did. */
static size_t reap(crew *w) {
  size_t n = 0;
  for (size_t k = 0; k < w->n_workers; k++) {
    int ended;
    if (w->workers[k].pid == 0 || waitpid(w->workers[k].pid, &ended, WNOHANG) != w->workers[k].pid) continue;
    finish(w, k, ended);
    n++;
  }
  return n;
}

static size_t count_running(const crew *w) {
  size_t n = 0;
  for (size_t k = 0; k < w->n_workers; k++) n += w->workers[k].pid != 0;
  return n;
}

static void pass_stop_on(crew *w, bool *told) {
  for (size_t k = 0; k < w->n_workers && !*told; k++)
    if (w->workers[k].pid > 0) kill(w->workers[k].pid, SIGTERM);
  *told = true;
}

/* Gives work to whoever is idle. Returns errno when no process can be started. */
static int start_idle(crew *w, const size_t *todo, size_t n, size_t *next) {
  for (size_t k = 0; k < w->n_workers; k++) {
    if (w->workers[k].pid != 0) continue;
    while (*next < n && is_taken(w, todo[*next])) ++*next;
    if (*next >= n || app_stop) return 0;
    if (!start(w, k, todo[*next])) return errno;
    ++*next;
  }
  return 0;
}

static void run_workers(crew *w, const size_t *todo, size_t n) {
  size_t next = 0;
  bool told_to_stop = false;
  long pause = 1000000; /* ns; grows to 20 ms while nothing happens */
  do {
    int error = app_stop ? 0 : start_idle(w, todo, n, &next);
    if (error && count_running(w) == 0) {
      clear_line(w);
      fprintf(stderr, "error: cannot start a process: %s\n", strerror(error));
      worsen(w, SD_ERROR_IO);
      return;
    }
    if (app_stop) pass_stop_on(w, &told_to_stop);
    draw(w);
    pause = reap(w) > 0 ? 1000000 : pause < 10000000 ? 2 * pause : 20000000;
    if (count_running(w) > 0) nanosleep(&(struct timespec){.tv_nsec = pause}, NULL);
  } while (count_running(w) > 0 || (next < n && !app_stop));
}

/* --- here, or in ranks ------------------------------------------------------------------------------------- */

static void serve(void *user, const session_progress *p) {
  crew *w = user;
  comm_serve(&w->queue);
  tell_parent(&w->slots[0], p);
  if (comm_size() == 1) draw(w);
}

static void run_queue(crew *w, const size_t *todo, size_t n) {
  comm_queue_begin(&w->queue, (int64_t)n, &app_stop);
  for (int64_t k; (k = comm_next(&w->queue)) >= 0;) {
    if (comm_size() == 1 && is_taken(w, todo[k])) continue;
    sweep_options options = {
        .threads = w->c->threads, .force = w->c->force, .stop = &app_stop, .progress = serve, .user = w};
    sd_messages *messages = sd_messages_new();
    sweep_status what;
    slot *mine = &w->slots[0];
    *mine = (slot){.began = -1};
    w->workers[0] = (worker){1, todo[k], now_seconds()};
    bool was_done = !w->c->force && sweep_peek(w->s, todo[k]) == SWEEP_DONE;
    sd_status status = messages ? sweep_run(w->s, todo[k], &options, &what, messages) : SD_ERROR_IO;
    write_messages(messages, mine->text, sizeof mine->text);
    w->workers[0].pid = 0;
    if (!was_done || status != SD_OK)
      account(w, todo[k], status, mine->text, mine, now_seconds() - w->workers[0].started);
    sd_messages_free(messages);
  }
  comm_queue_end(&w->queue);
}

/* --- all points -------------------------------------------------------------------------------------------- */

/* Points to be run, in order; those that are done are counted, and those that are refused told. */
static size_t find_todo(crew *w, size_t *todo) {
  size_t n = 0;
  for (size_t k = 0; k < w->s->deck.n_points; k++) {
    sweep_result r = {.status = SWEEP_WAITING};
    if (!w->c->force) sweep_look(w->s, k, &r, NULL);
    if (r.status == SWEEP_DONE) {
      w->done++;
    } else if (r.status > SWEEP_FAILED) {
      w->refused++;
      worsen(w, SD_ERROR_USER);
      tell(w, k, &r, "", 0);
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

/* Points that another process was running and has left unfinished since. */
static size_t find_abandoned(crew *w, size_t *todo) {
  size_t n = 0;
  for (size_t k = 0; k < w->s->deck.n_points; k++) {
    sweep_status status = w->tried[k] == SKIPPED ? sweep_peek(w->s, k) : SWEEP_DONE;
    if (status != SWEEP_WAITING && status != SWEEP_STOPPED) continue;
    w->steps_total += (double)w->steps[k];
    todo[n++] = k;
  }
  return n;
}

/* What the folder says in the end, also of what others did. When a signal came first, what was to be run (again) and
 * was not is left. */
static void count_all(crew *w) {
  w->done = w->failed = w->elsewhere = w->left = 0;
  for (size_t k = 0; k < w->s->deck.n_points; k++) {
    sweep_status status = sweep_peek(w->s, k);
    bool untried = app_stop && w->tried[k] == UNTRIED && (status == SWEEP_FAILED || w->c->force);
    if (status == SWEEP_RUNNING)
      w->elsewhere++;
    else if (status == SWEEP_WAITING || status == SWEEP_STOPPED || untried)
      w->left++;
    else if (status == SWEEP_FAILED)
      w->failed++;
    else
      w->done++;
  }
  /* refused ones have results, too */
  w->done -= w->done < w->refused ? w->done : w->refused;
  if (w->failed > 0) worsen(w, SD_ERROR_NUMERIC);
}

static void tell_end(crew *w) {
  clear_line(w);
  if (w->c->quiet) return;
  if (w->stars) fprintf(stderr, "*: the error bar is not reliable yet\n");
  fprintf(stderr, "%zu of %zu points done", w->done, w->s->deck.n_points);
  if (w->failed) fprintf(stderr, ", %zu failed", w->failed);
  if (w->refused) fprintf(stderr, ", %zu with a result that is not this deck's", w->refused);
  if (w->elsewhere) fprintf(stderr, ", %zu run by another process", w->elsewhere);
  fprintf(stderr, "; table: %s/table.csv\n", w->s->folder);
  if (w->left && w->worst != SD_ERROR_IO)
    fprintf(stderr, "stopped, everything is saved: give the command again to continue\n");
}

static int run_all(crew *w, size_t *todo) {
  bool first = comm_rank() == 0;
  size_t n = comm_size() > 1 ? take_all(w, todo) : find_todo(w, todo);
  if (first && !w->c->quiet)
    fprintf(stderr, "%s: %zu points, %zu done\n", w->s->folder, w->s->deck.n_points, w->done);
  do {
    if (w->c->workers > 0)
      run_workers(w, todo, n);
    else
      run_queue(w, todo, n);
    n = comm_size() > 1 || app_stop || w->worst == SD_ERROR_IO ? 0 : find_abandoned(w, todo);
  } while (n > 0);
  /* one rank judges: the others may see the files of their neighbours late */
  if (!first) return w->worst;
  make_tables(w, true);
  count_all(w);
  tell_end(w);
  return w->left > 0 && w->worst != SD_ERROR_IO ? SD_INTERRUPTED : w->worst;
}

/* Mistakes of some points do not keep the others from being run. */
static int check(crew *w) {
  sd_messages *messages = sd_messages_new();
  size_t usable = 0;
  int status = sweep_survey(w->s, w->steps, &usable, messages);
  if (comm_rank() == 0) {
    if (!w->c->quiet || status != SD_OK) sd_messages_print(messages, stderr);
    if (status != SD_OK && usable > 0)
      fprintf(stderr, "points with these mistakes will fail; %zu of %zu sets of values are run\n", usable,
              w->s->deck.n_sets);
  }
  sd_messages_free(messages);
  return usable > 0 ? SD_OK : status;
}

static int prepare_and_run(crew *w, size_t *todo) {
  int status = check(w);
  if (status != SD_OK) return status;
  sd_messages *messages = sd_messages_new();
  status = sweep_prepare(w->s, messages);
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
  w.tried = calloc(s->deck.n_points + 1, 1);
  size_t *todo = calloc(s->deck.n_points + 1, sizeof *todo);
  w.slots =
      mmap(NULL, w.n_workers * sizeof *w.slots, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  if (w.workers && w.steps && w.tried && todo && w.slots != MAP_FAILED) {
    status = prepare_and_run(&w, todo);
  } else {
    fprintf(stderr, "error: no memory for the sweep\n");
    status = SD_ERROR_IO;
    if (comm_size() > 1) comm_abort(status); /* the others would wait */
  }
  if (w.slots != MAP_FAILED) munmap(w.slots, w.n_workers * sizeof *w.slots);
  free(w.workers);
  free(w.steps);
  free(w.tried);
  free(todo);
  if (c->workers == 0) {
    status = comm_max(status);
    comm_end();
  }
  return status;
}
