/* sweep_workers.c: makes groups of points, chooses the order in which they run, and starts the
 * processes that run them (-j). See sweep_run.c. */
#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include "app/app.h"
#include "app/sweep/sweep.h"
#include "base/team.h"
#include "base/memory.h"
#include "base/text.h"

/* --- groups ----------------------------------------------------------------------------------- */

/* The points of a group run side by side in SIMD lanes. A group takes about as long as its longest
 * point, whatever the number of its points. So points of one kind are sorted by length and put into
 * groups as large as the SIMD width allows; if workers would be idle, the largest groups are halved
 * until each worker has one. */

typedef struct entry {
  /* Number of the first point of the same kind; for a point that runs alone: its own number */
  size_t kind;
  int64_t steps;
  size_t point;
} entry;

/* Compares entries for qsort: by kind (in order of appearance), then longest first, then by
 * number. */
static int compare(const void *a, const void *b) {
  const entry *p = a, *q = b;
  if (p->kind != q->kind) return p->kind < q->kind ? -1 : 1;
  if (p->steps != q->steps) return p->steps > q->steps ? -1 : 1;
  return p->point < q->point ? -1 : p->point > q->point;
}

static void sort(entry *entries, const scheduler *w, const size_t *points, size_t n,
                 size_t *begins) {
  for (size_t k = 0; k < n; k++) {
    size_t point = points[k];
    int kind = w->kinds[point];
    bool alone = kind == SWEEP_ALONE || w->tried[point] == CRASHED;
    if (!alone && begins[kind] == SIZE_MAX) begins[kind] = point;
    entries[k] = (entry){alone ? point : begins[kind], w->steps[point], point};
  }
  qsort(entries, n, sizeof *entries, compare);
}

static void halve(sweep_groups *g, size_t k) {
  for (size_t j = g->n; j > k + 1; j--) g->list[j] = g->list[j - 1];
  sweep_group *one = &g->list[k];
  size_t half = (one->n + 1) / 2;
  g->list[k + 1] = (sweep_group){.first = one->first + half, .n = one->n - half};
  one->n = half;
  g->n++;
}

static size_t largest(const sweep_groups *g) {
  size_t best = 0;
  for (size_t k = 1; k < g->n; k++)
    if (g->list[k].n > g->list[best].n) best = k;
  return best;
}

void sweep_groups_make(sweep_groups *g, const scheduler *w, const size_t *points, size_t n,
                       size_t workers) {
  size_t n_kinds = w->s->deck.n_sets;
  entry *entries = memory_new(n, sizeof *entries);
  size_t *begins = memory_new(n_kinds, sizeof *begins);
  *g = (sweep_groups){.order = memory_new(n, sizeof *g->order),
                      .list = memory_new(n + 1, sizeof *g->list),
                      .capacity = n + 1};
  for (size_t k = 0; k < n_kinds; k++) begins[k] = SIZE_MAX;
  sort(entries, w, points, n, begins);
  for (size_t k = 0; k < n; k++) {
    g->order[k] = entries[k].point;
    bool same = k > 0 && entries[k].kind == entries[k - 1].kind;
    if (!same || g->list[g->n - 1].n >= w->width) g->list[g->n++] = (sweep_group){.first = k};
    g->list[g->n - 1].n++;
  }
  for (size_t k; g->n > 0 && g->n < workers && (k = largest(g), g->list[k].n > 1);) halve(g, k);
  free(entries);
  free(begins);
}

void sweep_groups_put_off(sweep_groups *g, sweep_group one) {
  if (g->n == g->capacity) {
    g->capacity *= 2;
    g->list = memory_grow(g->list, g->capacity, sizeof *g->list);
  }
  one.late = true;
  g->list[g->n++] = one;
}

void sweep_groups_free(sweep_groups *g) {
  free(g->order);
  free(g->list);
  *g = (sweep_groups){0};
}

static void tell_parent(void *user, size_t k, const session_progress *p) {
  const worker *me = user;
  sweep_tell(&me->cells[k], p);
}

static void tell_left(void *user, size_t k, const sweep_end *end) {
  const worker *me = user;
  sweep_tell_left(&me->cells[k], end);
}

/* Runs the points of a worker, in the process of this worker. Never returns. */
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

/* Starts a process that runs n points of a worker. Returns false, with errno, if that fails. */
static bool start(scheduler *w, worker *one, size_t n) {
  sweep_assign(one, n);
  fflush(NULL);
  pid_t parent = getpid(), pid = fork();
  if (pid == 0) work(w, one, parent);
  if (pid > 0) one->pid = pid;
  return pid > 0;
}

/* Counts and shows the points that a worker has reported as ended. Returns their number. */
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

/* Writes into `text` how a process died; "" if it ended by itself. *status: its status. */
static void describe_end(int ended, sd_status *status, char *text, size_t size) {
  *text = 0;
  *status = SD_ERROR_NUMERIC;
  int code = WIFEXITED(ended) ? WEXITSTATUS(ended) : -1;
  if (code == SD_OK || code == SD_INTERRUPTED)
    *status = (sd_status)code;
  else if (code == SD_ERROR_IO) /* the process has printed the reason (memory_lacks) */
    *status = SD_ERROR_IO;
  else if (WIFSIGNALED(ended) && app_stop)
    *status = SD_INTERRUPTED;
  else if (WIFSIGNALED(ended))
    snprintf(text, size, "was ended by signal %d (%s)", WTERMSIG(ended),
             strsignal(WTERMSIG(ended)));
  else
    snprintf(text, size, "ended with status %d", code);
}

/* Marks the points of a crashed group that have not ended as CRASHED: it is not known which of them
 * caused the crash, so that each is run again alone. */
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
  fprintf(
      stderr,
      "warning: the process that ran %zu points side by side %s; they are run again one by one\n",
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
    /* The process may have died after it had completed the result of the point. */
    bool done = sweep_peek(w->s, point) == SWEEP_DONE;
    if (*text && !done) sweep_note(w->s, point, text);
    sweep_account(w, point, done ? SD_OK : status, done ? "" : text, &one->cells[i],
                  clock_seconds() - one->started);
  }
}

/* Counts and shows points that have ended, and collects processes that have ended. Returns the
 * number of both together. */
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

/* Starts a process for each idle worker while groups are left; *more: set to false when no group is
 * left. Returns errno if a process cannot be started; its points then wait in the worker
 * (worker.waiting). */
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
  /* Pause between checks of the workers, ns; grows to 20 ms while nothing happens */
  long pause = 1000000;
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

/* --- order of the points, and their outcomes -------------------------------------------------- */

/* Shortest time between two writes of the tables while points run: TABLE_SECONDS in s, and
 * TABLE_SHARE times the duration of the last write. */
static const double TABLE_SECONDS = 15, TABLE_SHARE = 20;
/* Longest time in s that the tables written at the end wait for another process that is writing
 * them. PATIENCE: usually; PATIENCE_STOPPED: after a stop signal. */
static const double PATIENCE = 600, PATIENCE_STOPPED = 10;

void sweep_worsen(scheduler *w, int status) {
  if (w->worst < status) w->worst = status;
}

/* --- results ---------------------------------------------------------------------------------- */

/* Writes the tables. Unless `last` is true, they are left out if another process is writing
 * them. */
void sweep_make_tables(scheduler *w, bool last) {
  double start = clock_seconds();
  size_t count[SWEEP_STATUSES] = {0};
  /* Other processes run the other points if --point is given; the user then writes the tables with
   * --table. */
  if (sweep_is_part(w->c)) return;
  if (!last && start - w->tabled < fmax(TABLE_SECONDS, TABLE_SHARE * w->table_cost)) return;
  sd_messages *messages = sd_messages_new();
  sd_status status = sweep_write_tables(w->s,
                                        !last      ? 0
                                        : app_stop ? PATIENCE_STOPPED
                                                   : PATIENCE,
                                        true, count, messages);
  if (last || status == SD_ERROR_IO) {
    sweep_clear_line(w);
    sd_messages_print(messages, stderr);
    sweep_worsen(w, status);
  }
  w->no_table = status != SD_OK;
  sd_messages_free(messages);
  w->tabled = clock_seconds();
  w->table_cost = w->tabled - start;
}

/* Counts a point by its status r->status, as read from the folder, and stores its doubts. */
void sweep_remember(scheduler *w, size_t point, const sweep_result *r) {
  w->seen[point] = (unsigned char)(1 + r->status);
  w->doubts[point] = (unsigned char)r->doubts;
  w->done += r->status == SWEEP_DONE;
  w->failed += r->status == SWEEP_FAILED;
  w->other += r->status == SWEEP_OTHER;
  w->damaged += r->status == SWEEP_DAMAGED;
  w->unreadable += r->status == SWEEP_UNREADABLE;
}

void sweep_account(scheduler *w, size_t point, sd_status status, const char *text, const cell *ran,
                   double seconds) {
  sweep_result r;
  sweep_look(w->s, point, &r);
  if ((r.status == SWEEP_WAITING || r.status == SWEEP_STOPPED) && status != SD_INTERRUPTED) {
    /* The point failed, but its files do not show it: not even the reason could be stored. */
    r.status = SWEEP_FAILED;
    free(r.message);
    static const char prefix[] = "error: ";
    if (strncmp(text, prefix, sizeof prefix - 1) == 0) text += sizeof prefix - 1;
    r.message = format_text("%.*s", (int)strcspn(text, "\n"), text);
  }
  double spared = fmax(ran->began, 0);
  w->tried[point] = r.status == SWEEP_RUNNING ? SKIPPED : TRIED;
  sweep_remember(w, point, &r);
  if (r.status == SWEEP_FAILED) sweep_worsen(w, SD_ERROR_NUMERIC);
  if (r.status > SWEEP_FAILED)
    sweep_worsen(w, r.status == SWEEP_UNREADABLE ? SD_ERROR_IO : SD_ERROR_USER);
  if (status == SD_ERROR_IO) sweep_worsen(w, SD_ERROR_IO);
  if (r.status == SWEEP_RUNNING)
    w->steps_total -= (double)w->steps[point];
  else
    w->steps_done += (1 - spared) * (double)w->steps[point];
  w->steps_total -= spared * (double)w->steps[point];
  if (r.message) sweep_show(w, point, &r, text, seconds);
  sweep_result_free(&r);
  sweep_make_tables(w, false);
}

/* Returns true if another process runs this point, or has finished it since the list of points was
 * made; then also stores that in w->tried, and subtracts the point's steps from the steps of this
 * process. */
static bool is_taken(scheduler *w, size_t point) {
  sweep_status status = sweep_peek(w->s, point);
  bool finished = status == SWEEP_DONE && !w->c->force;
  if (!finished && status != SWEEP_RUNNING) return false;
  w->tried[point] = finished ? TRIED : SKIPPED;
  w->done += finished;
  w->steps_total -= (double)w->steps[point];
  return true;
}

/* Writes messages into text[size], one per line, each after "error: " or "warning: "; as many as
 * fit. */
static void write_messages(const sd_messages *messages, char *text, size_t size) {
  *text = 0;
  FILE *out = fmemopen(text, size - 1, "w");
  if (!out) return;
  sd_messages_print(messages, out);
  fclose(out);
  text[size - 1] = 0;
}

/* --- assignment of points --------------------------------------------------------------------- */

/* Fills points[] with the points of the group that are still to be run, and returns their
 * number. */
size_t sweep_sift(scheduler *w, sweep_group one, size_t *points) {
  size_t n = 0;
  for (size_t k = 0; k < one.n; k++) {
    size_t point = w->groups.order[one.first + k];
    if (!is_taken(w, point)) points[n++] = point;
  }
  return n;
}

size_t sweep_next(scheduler *w, size_t *points) {
  sweep_groups *g = &w->groups;
  while (g->next < g->n) {
    sweep_group one = g->list[g->next++];
    /* Another process is running a point of this group and will take the others, too: move the
     * group to the end of the list. */
    bool begun = false;
    for (size_t k = 0; one.n > 1 && !one.late && k < one.n; k++)
      begun = begun || sweep_peek(w->s, g->order[one.first + k]) == SWEEP_RUNNING;
    if (begun) {
      sweep_groups_put_off(g, one);
      continue;
    }
    size_t n = sweep_sift(w, one, points);
    if (n > 0) return n;
  }
  return 0;
}

void sweep_tell(cell *mine, const session_progress *p) {
  mine->fraction = p->expected > 0 ? (double)p->step / (double)p->expected : 0;
  if (mine->began < 0) mine->began = mine->fraction;
}

void sweep_tell_left(cell *mine, const sweep_end *end) {
  write_messages(end->messages, mine->text, sizeof mine->text);
  atomic_store(&mine->left, 1 + (int)end->ran);
}

void sweep_assign(worker *one, size_t n) {
  one->n = n;
  one->started = clock_seconds();
  for (size_t i = 0; i < n; i++) {
    one->told[i] = false;
    one->cells[i].fraction = 0;
    one->cells[i].began = -1;
    one->cells[i].text[0] = 0;
    atomic_store(&one->cells[i].left, 0);
  }
}
