/* sweep_run.c: runs the points of a sweep.
 *
 * Points go in groups whose systems are advanced side by side. With -j N each group is run by a process
 * of its own (sweep_workers.c): what goes wrong in one, even a crash, does not touch the others. Without
 * -j groups are run one after the other here, or shared among the ranks of an MPI job. All else goes
 * through the folder.
 *
 * Ctrl-C and its like go to all workers, which stop at checkpoints. A signal may come at any moment: before the
 * folder is touched it ends the process (drive.c); a worker inherits app_stop, so one that came before the fork
 * stops it too, and one that comes after is passed on. A worker whose parent is gone gets SIGTERM from the kernel.
 */
#include <math.h>
#include <stdlib.h>
#include <sys/mman.h>
#include <unistd.h>

#include "app/app.h"
#include "app/sweep/sweep_scheduler.h"
#include "base/clock.h"
#include "base/comm.h"
#include "base/memory.h"
#include "run/ensemble.h"

/* --- here, or in ranks ------------------------------------------------------------------------------------- */

static void serve(void *user, size_t k, const session_progress *p) {
  scheduler *w = user;
  if (comm_world()) comm_serve(&w->queue);
  sweep_tell(&w->workers[0].cells[k], p);
  if (!comm_world()) sweep_draw(w);
}

static void leave(void *user, size_t k, const sweep_end *end) {
  scheduler *w = user;
  worker *me = &w->workers[0];
  cell *mine = &me->cells[k];
  sweep_tell_left(mine, end);
  me->told[k] = true;
  if (comm_world()) comm_serve(&w->queue);
  sweep_account(w, end->point, end->ran, mine->text, mine, clock_seconds() - me->started);
}

static void run_here(scheduler *w, size_t n) {
  worker *me = &w->workers[0];
  sweep_options options = {.threads = (int)w->c->threads,
                           .force = w->c->force,
                           .stop = &app_stop,
                           .progress = serve,
                           .left = leave,
                           .user = w};
  sweep_assign(me, n);
  me->pid = 1;
  sweep_run(w->s, n, me->points, &options);
  me->pid = 0;
}

static void run_one_after_the_other(scheduler *w) {
  for (size_t n; !app_stop && (n = sweep_next(w, w->workers[0].points)) > 0;) run_here(w, n);
}

static void run_ranks(scheduler *w) {
  comm_queue_begin(&w->queue, (int64_t)w->groups.n, &app_stop);
  for (int64_t k; (k = comm_next(&w->queue)) >= 0;) {
    size_t n = sweep_sift(w, w->groups.list[k], w->workers[0].points);
    if (n > 0) run_here(w, n);
  }
  comm_queue_end(&w->queue);
}

/* --- all points -------------------------------------------------------------------------------------------- */

/* Nothing is to be run in this folder; of find_todo. */
static const size_t REFUSED = SIZE_MAX;

static size_t refuse(const sd_messages *messages) {
  sd_messages_print(messages, stderr);
  return REFUSED;
}

/* Points to be run, in order; those that are done are counted, and damaged ones told. Those of another deck stop everything,
 * unless they are let be. */
static size_t find_todo(scheduler *w, size_t *todo, sd_messages *messages) {
  size_t n = 0;
  sweep_tally others = {0};
  if (sweep_guard(w->s, w->c, w->first, w->end, messages) != SD_OK) return refuse(messages);
  for (size_t k = w->first; k < w->end && !app_stop; k++) {
    sweep_result r = {.status = SWEEP_WAITING};
    if (!w->c->force) sweep_look(w->s, k, &r);
    if (r.status == SWEEP_DONE) {
      sweep_remember(w, k, &r);
    } else if (r.status > SWEEP_FAILED) {
      sweep_remember(w, k, &r);
      sweep_worsen(w, SD_ERROR_USER);
      if (r.status == SWEEP_DAMAGED || w->c->mix) sweep_show(w, k, &r, "", 0);
      if (!w->c->mix) sweep_tally_add(&others, &r);
    } else {
      todo[n++] = k;
      w->steps_total += (double)w->steps[k];
    }
    sweep_result_free(&r);
  }
  sd_status status = sweep_refuse_others(w->s, &others, "nothing is run", messages);
  sweep_tally_free(&others);
  return status == SD_OK ? n : refuse(messages);
}

/* Ranks must agree on the list, and the folder may change between their looks at it: the first one looks. */
static size_t agree_on_todo(scheduler *w, size_t *todo) {
  size_t places = w->s->deck.n_points + 1;
  sd_messages *messages = sd_messages_new();
  if (comm_rank(comm_world()) == 0) todo[places - 1] = find_todo(w, todo, messages);
  sd_messages_free(messages);
  comm_share(comm_world(), todo, places * sizeof *todo);
  return todo[places - 1];
}

/* Points that another process was running and has left unfinished since, and those of groups that crashed. */
static size_t find_abandoned(scheduler *w, size_t *todo) {
  size_t n = 0;
  for (size_t k = w->first; k < w->end; k++) {
    sweep_status status = w->tried[k] == SKIPPED ? sweep_peek(w->s, k) : SWEEP_DONE;
    if (status != SWEEP_WAITING && status != SWEEP_STOPPED && w->tried[k] != CRASHED) continue;
    w->steps_total += (double)w->steps[k];
    todo[n++] = k;
  }
  return n;
}

/* The status of a point in the end. Results that this process has read are not read again; a failure whose reason could
 * not be stored is known to this process alone. After a signal, points that were not run (again) are waiting. */
static sweep_status final_status(scheduler *w, size_t k) {
  int seen = (int)w->seen[k] - 1; /* negative: it was not looked at */
  sweep_status now = sweep_peek(w->s, k);
  if (now == SWEEP_RUNNING) return now;
  if (app_stop && w->tried[k] == UNTRIED && (now == SWEEP_FAILED || w->c->force))
    return SWEEP_WAITING;
  if (seen == SWEEP_OTHER || seen == SWEEP_DAMAGED) return (sweep_status)seen;
  if ((now == SWEEP_WAITING || now == SWEEP_STOPPED) && seen == SWEEP_FAILED) return SWEEP_FAILED;
  if (now != SWEEP_DONE || seen == SWEEP_DONE) return now;
  sweep_result r;
  sweep_look(w->s, k, &r);
  now = r.status;
  w->doubts[k] = (unsigned char)r.doubts;
  sweep_result_free(&r);
  return now;
}

/* Counts all points by the folder, also those that other processes ran. */
static void count_all(scheduler *w) {
  size_t count[SWEEP_STATUSES] = {0};
  for (size_t k = w->first; k < w->end; k++) {
    sweep_status status = final_status(w, k);
    count[status]++;
    if (status != SWEEP_DONE) continue;
    sweep_count_doubts(w->doubts[k], w->doubted);
    w->in_doubt = w->in_doubt || w->doubts[k];
  }
  w->done = count[SWEEP_DONE];
  w->failed = count[SWEEP_FAILED];
  w->other = count[SWEEP_OTHER];
  w->damaged = count[SWEEP_DAMAGED];
  w->elsewhere = count[SWEEP_RUNNING];
  w->left = count[SWEEP_WAITING] + count[SWEEP_STOPPED];
  if (w->failed > 0) sweep_worsen(w, SD_ERROR_NUMERIC);
}

static size_t count_workers(const scheduler *w) {
  return w->c->workers > 0 ? w->n_workers : (size_t)comm_size(comm_world());
}

static void run_round(scheduler *w, const size_t *todo, size_t n) {
  sweep_groups_free(&w->groups);
  sweep_groups_make(&w->groups, w, todo, n, count_workers(w));
  if (w->round++ == 0 && comm_rank(comm_world()) == 0 && !w->c->quiet) sweep_show_start(w);
  if (w->c->workers > 0)
    sweep_run_workers(w);
  else if (comm_world())
    run_ranks(w);
  else
    run_one_after_the_other(w);
}

static int run_all(scheduler *w, size_t *todo) {
  size_t n = agree_on_todo(w, todo);
  if (n == REFUSED) return SD_ERROR_USER;
  do {
    run_round(w, todo, n);
    n = comm_world() || app_stop || w->worst == SD_ERROR_IO ? 0 : find_abandoned(w, todo);
  } while (n > 0);
  /* one rank judges: the others may see the files of their neighbours late */
  if (comm_rank(comm_world()) != 0) return w->worst;
  sweep_make_tables(w, true);
  count_all(w);
  sweep_show_end(w);
  return w->left > 0 && w->worst != SD_ERROR_IO ? SD_INTERRUPTED : w->worst;
}

/* Mistakes of some points keep the others from being run, unless these are to be skipped. */
static int check(scheduler *w) {
  sd_messages *messages = sd_messages_new();
  size_t usable = 0;
  const size_t all = w->end - w->first, workers = w->n_workers < all ? w->n_workers : all;
  int status = sweep_precheck(w->s, workers, w->steps, w->kinds, &usable, messages);
  if (comm_rank(comm_world()) == 0) {
    if (!w->c->quiet || status != SD_OK) sd_messages_print(messages, stderr);
    if (status != SD_OK && usable > 0)
      fprintf(
          stderr,
          w->c->skip
              ? "points with these mistakes will fail; %zu of %zu sets of values are run\n"
              : "nothing is run: %zu of %zu sets of values have no mistakes, --skip runs them\n",
          usable, w->s->deck.n_sets);
  }
  sd_messages_free(messages);
  return usable > 0 && w->c->skip ? SD_OK : status;
}

static int prepare_and_run(scheduler *w, size_t *todo) {
  int status = check(w);
  if (status != SD_OK) return status;
  app_begin_saving();
  sd_messages *messages = sd_messages_new();
  status = sweep_prepare(w->s, messages);
  sd_messages_print(messages, stderr);
  sd_messages_free(messages);
  if (status != SD_OK && comm_world()) comm_abort(comm_world(), status);
  return status == SD_OK ? run_all(w, todo) : status;
}

static void make_scheduler(scheduler *w) {
  size_t n_points = w->s->deck.n_points;
  size_t places = w->n_workers * w->width;
  w->workers = memory_new(w->n_workers, sizeof *w->workers);
  w->steps = memory_new(n_points, sizeof *w->steps);
  w->kinds = memory_new(n_points, sizeof *w->kinds);
  w->tried = memory_new(n_points, 1);
  w->seen = memory_new(n_points, 1);
  w->doubts = memory_new(n_points, 1);
  w->points = memory_new(places, sizeof *w->points);
  w->told = memory_new(places, sizeof *w->told);
  w->cells = mmap(NULL, places * sizeof *w->cells, PROT_READ | PROT_WRITE,
                  MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  if (w->cells == MAP_FAILED) memory_lacks(places * sizeof *w->cells);
  for (size_t k = 0; k < w->n_workers; k++)
    w->workers[k] = (worker){.points = w->points + k * w->width,
                             .told = w->told + k * w->width,
                             .cells = w->cells + k * w->width};
}

static void free_scheduler(scheduler *w) {
  munmap(w->cells, w->n_workers * w->width * sizeof *w->cells);
  free(w->workers);
  free(w->steps);
  free(w->kinds);
  free(w->tried);
  free(w->seen);
  free(w->doubts);
  free(w->points);
  free(w->told);
  sweep_groups_free(&w->groups);
}

/* Lanes are for systems of one thread. */
static size_t choose_width(const sweep_command *c) {
  size_t width = ensemble_width();
  return c->no_lanes || c->threads > 1 || width < 1 ? 1 : width;
}

int sweep_run_all(const sweep *s, const sweep_command *c) {
  sd_messages *messages = sd_messages_new();
  int status = c->workers > 0 ? SD_OK : comm_begin(messages);
  sd_messages_print(messages, stderr);
  sd_messages_free(messages);
  if (status != SD_OK) return status;
  if (comm_world()) app_begin_saving(); /* a rank that is gone would be waited for */
  scheduler w = {.s = s,
                 .c = c,
                 .end = s->deck.n_points,
                 .width = choose_width(c),
                 .n_workers = c->workers > 0 ? (size_t)c->workers : 1,
                 .terminal = isatty(STDERR_FILENO)};
  if (sweep_is_part(c)) {
    w.first = (size_t)c->point;
    if ((size_t)c->last < w.end) w.end = (size_t)c->last + 1;
  }
  w.began = w.tabled = clock_seconds();
  size_t *todo = memory_new(s->deck.n_points + 1, sizeof *todo);
  make_scheduler(&w);
  status = prepare_and_run(&w, todo);
  free_scheduler(&w);
  free(todo);
  if (c->workers == 0) {
    status = comm_max(comm_world(), status);
    comm_share(comm_world(), &w.in_doubt, sizeof w.in_doubt);
    comm_end();
  }
  return status == SD_OK && w.in_doubt ? SD_DOUBTFUL : status;
}
