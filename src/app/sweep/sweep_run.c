/* sweep_run.c: runs the points of a sweep.
 *
 * Points run in groups, whose systems are advanced side by side. With -j N each group has a
 * process of its own (sweep_workers.c), so that a failure or even a crash of one group does not
 * touch the others. Without -j this process runs the groups one after the other, or the ranks of
 * an MPI job share them. Everything else is exchanged through files in the folder.
 *
 * Ctrl-C and other signals go to all workers, which stop at checkpoints. A signal may come at any
 * moment: before the folder is touched it ends the process (drive.c); a worker inherits app_stop,
 * so a signal before the fork stops it, too, and a later one is passed on. A worker whose parent
 * has died gets SIGTERM from the kernel. */
#include <math.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <time.h>
#include <unistd.h>

#include "app/app.h"
#include "app/sweep/sweep.h"
#include "base/team.h"
#include "base/comm.h"
#include "base/memory.h"
#include "base/message.h"
#include "model/advice.h"
#include "model/state.h"
#include "run/ensemble.h"

/* --- groups in this process or in MPI ranks --------------------------------------------------- */

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

/* --- all points ------------------------------------------------------------------------------- */

/* Return value of find_todo: this sweep must not run points in its folder. */
static const size_t REFUSED = SIZE_MAX;

static size_t refuse(const sd_messages *messages) {
  sd_messages_print(messages, stderr);
  return REFUSED;
}

/* Fills todo[] with the numbers of the points to be run, ascending, and returns how many they are.
 * Counts finished points and shows damaged ones. Returns REFUSED if some points were made with
 * another deck, unless --mix is given. */
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
      sweep_worsen(w, r.status == SWEEP_UNREADABLE ? SD_ERROR_IO : SD_ERROR_USER);
      if (r.status != SWEEP_OTHER || w->c->mix) sweep_show(w, k, &r, "", 0);
      if (!w->c->mix) sweep_tally_add(&others, &r);
    } else {
      todo[n++] = k;
      w->steps_total += (double)w->steps[k];
    }
    sweep_result_free(&r);
  }
  sd_status status = sweep_refuse_other_decks(w->s, &others, "nothing is run", messages);
  sweep_tally_free(&others);
  return status == SD_OK ? n : refuse(messages);
}

/* Returns the list of points to be run, on all ranks as found by rank 0: it must be the same on
 * all, and the folder may change while they read it. */
static size_t agree_on_todo(scheduler *w, size_t *todo) {
  size_t places = w->s->deck.n_points + 1;
  sd_messages *messages = sd_messages_new();
  if (comm_rank(comm_world()) == 0) todo[places - 1] = find_todo(w, todo, messages);
  sd_messages_free(messages);
  comm_broadcast(comm_world(), todo, places * sizeof *todo);
  return todo[places - 1];
}

/* --- points of other processes ---------------------------------------------------------------- */

/* Work that is left after a round. run: number of points to be run here; held: number of points
 * that other processes are running. */
typedef struct rest {
  size_t run, held;
} rest;

/* Fills todo[] with points that another process was running but left unfinished, and with points of
 * groups that crashed, and held[] with those that other processes are still running. */
static rest find_rest(scheduler *w, size_t *todo, size_t *held) {
  rest left = {0};
  for (size_t k = w->first; k < w->end; k++) {
    sweep_status status = w->tried[k] == SKIPPED ? sweep_peek(w->s, k) : SWEEP_DONE;
    if (status == SWEEP_RUNNING) held[left.held++] = k;
    if (status != SWEEP_WAITING && status != SWEEP_STOPPED && w->tried[k] != CRASHED) continue;
    if (w->tried[k] == SKIPPED) w->tried[k] = UNTRIED;
    w->steps_total += (double)w->steps[k];
    todo[left.run++] = k;
  }
  return left;
}

/* Tells rank 0 which points any rank has left to other processes; the others forget them. */
static void agree_on_skipped(scheduler *w) {
  const size_t n = comm_world() ? w->s->deck.n_points : 0;
  int64_t *skipped = memory_new(n, sizeof *skipped);
  for (size_t k = 0; k < n; k++) skipped[k] = w->tried[k] == SKIPPED;
  comm_add(comm_world(), skipped, n);
  for (size_t k = 0; k < n; k++)
    if (skipped[k] > 0) w->tried[k] = comm_rank(comm_world()) == 0 ? SKIPPED : UNTRIED;
  free(skipped);
}

/* Collective. Waits for points that other processes are running, until one of them is left
 * unfinished, and then takes it up; not with the option --no-wait. Fills todo[] with the points of
 * the next round and returns how many they are; 0: there is no other round. */
static size_t wait_for_others(scheduler *w, size_t *todo) {
  enum { STOPPED = 1, BROKEN = 2 };
  const long longest = 500000000;
  size_t *held = memory_new(w->s->deck.n_points, sizeof *held), told = 0;
  rest left = {0};
  agree_on_skipped(w);
  for (long pause = 10000000;; pause = pause < longest / 2 ? 2 * pause : longest) {
    if (comm_rank(comm_world()) == 0) left = find_rest(w, todo, held);
    comm_broadcast(comm_world(), &left, sizeof left);
    const unsigned why =
        comm_or(comm_world(), (app_stop ? STOPPED : 0) | (w->worst == SD_ERROR_IO ? BROKEN : 0));
    if (why & STOPPED) app_stop = SIGTERM; /* on all ranks */
    if (why) left = (rest){0};
    if (left.run > 0 || left.held == 0 || w->c->no_wait) break;
    if (left.held != told && comm_rank(comm_world()) == 0) sweep_show_held(w, left.held, held);
    told = left.held;
    nanosleep(&(struct timespec){.tv_nsec = pause}, NULL);
  }
  comm_broadcast(comm_world(), todo, left.run * sizeof *todo);
  free(held);
  return left.run;
}

/* Returns the final status of a point from its files; a result that this process has read already
 * is not read again. If a point failed here and the reason could not be stored, it counts as failed
 * all the same. After a stop signal, points that were not run in this call and would have been run
 * (again) count as waiting. */
static sweep_status final_status(scheduler *w, size_t k) {
  /* Status when the files of the point were last read; negative: they were not read */
  int seen = (int)w->seen[k] - 1;
  sweep_status now = sweep_peek(w->s, k);
  if (now == SWEEP_RUNNING) return now;
  if (app_stop && w->tried[k] == UNTRIED && (now == SWEEP_FAILED || w->c->force))
    return SWEEP_WAITING;
  if (seen > SWEEP_FAILED) return (sweep_status)seen;
  if ((now == SWEEP_WAITING || now == SWEEP_STOPPED) && seen == SWEEP_FAILED) return SWEEP_FAILED;
  if (now != SWEEP_DONE || seen == SWEEP_DONE) return now;
  sweep_result r;
  sweep_look(w->s, k, &r);
  now = r.status;
  w->doubts[k] = (unsigned char)r.doubts;
  sweep_result_free(&r);
  return now;
}

/* Counts all points by their state in the folder, including points that other processes ran. */
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
  w->unreadable = count[SWEEP_UNREADABLE];
  w->elsewhere = count[SWEEP_RUNNING];
  w->left = count[SWEEP_WAITING] + count[SWEEP_STOPPED];
  if (w->failed > 0) sweep_worsen(w, SD_ERROR_NUMERIC);
  if (w->other + w->damaged > 0) sweep_worsen(w, SD_ERROR_USER);
  if (w->unreadable > 0) sweep_worsen(w, SD_ERROR_IO);
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
    n = wait_for_others(w, todo);
  } while (n > 0);
  /* Only rank 0 counts the points: on a shared file system the other ranks may see new files
   * late. */
  if (comm_rank(comm_world()) != 0) return w->worst;
  /* The tables are made last, so that they have all points that are counted as done. */
  count_all(w);
  sweep_make_tables(w, true);
  sweep_show_end(w);
  if (w->worst == SD_ERROR_IO) return w->worst;
  if (w->left > 0 || (w->elsewhere > 0 && app_stop)) return SD_INTERRUPTED;
  return w->elsewhere > 0 && w->worst == SD_OK ? APP_ELSEWHERE : w->worst;
}

/* Checks all points before the sweep begins. Mistakes in some points stop the sweep, unless --skip
 * is given. */
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

/* Returns the largest number of points in a group; 1 with the option --no-lanes, or with several
 * threads, since systems in SIMD lanes are computed by one thread. */
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
  /* A signal must not end one rank at once, since the other ranks would wait for it for ever. */
  if (comm_world()) app_begin_saving();
  scheduler w = {.s = s,
                 .c = c,
                 .end = s->deck.n_points,
                 .width = choose_width(c),
                 .n_workers = c->workers > 0 ? (size_t)c->workers : 1,
                 .terminal = report_redraws(stderr)};
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
    comm_broadcast(comm_world(), &w.in_doubt, sizeof w.in_doubt);
    comm_end();
  }
  return status == SD_OK && w.in_doubt ? SD_DOUBTFUL : status;
}

/* --- checks before any point runs: mistakes, lengths, memory, columns of the table ------------ */

/* Largest number of kinds of systems that are told apart in one sweep; points of further kinds run
 * alone. */
enum { MOST_KINDS = 64 };
/* Number of points not selected by --point of which the deck is compared with this one. */
enum { SAMPLE = 8 };

/* Result of one check that gives advice, over all points of the sweep. */
typedef struct advice {
  /* Number of sets of parameter values with a warning from this check; number of the point with the
   * worst warning */
  size_t n, point;
  double worst;
  char *warning;
} advice;

/* Memory that the points of a sweep need, bytes. */
typedef struct needs {
  /* Smallest lower bound of the memory of any point; largest estimate of the memory of any point */
  double least, most;
  size_t largest; /* Number of the point with the largest estimate */
  /* Number of sets of parameter values for which one process has not enough memory */
  size_t refused;
  size_t first; /* First point for which one process has not enough memory */
  char *why;    /* Message about point `first` */
} needs;

typedef struct precheck {
  const sweep *s;
  int64_t *steps;
  int *kinds;
  int n_kinds;
  sd_model *models[MOST_KINDS]; /* For each kind of system the first model of this kind */
  advice *advice;               /* [advice_count] results of the checks that give advice */
  needs needs;
  /* [n_collect]: true if the pattern of `collect` matches a column of some point */
  bool *collected;
} precheck;

/* --- points ----------------------------------------------------------------------------------- */

/* Finds the kind to which a model belongs; a new kind begins if it matches none. *kind =
 * SWEEP_ALONE: the model cannot share SIMD lanes. Returns true if the model is now stored as the
 * first of its kind. */
static bool find_kind(precheck *v, sd_model *model, int *kind) {
  *kind = SWEEP_ALONE;
  if (!ensemble_takes(model)) return false;
  for (*kind = 0; *kind < v->n_kinds; ++*kind)
    if (ensemble_alike(v->models[*kind], model)) return false;
  if (v->n_kinds == MOST_KINDS) {
    *kind = SWEEP_ALONE;
    return false;
  }
  v->models[v->n_kinds++] = model;
  return true;
}

/* Runs all checks that give advice on the model of a point. For each check only the warning about
 * the worst point is stored. */
static void look_at_advice(precheck *v, size_t point, const sd_model *model) {
  for (size_t k = 0; k < advice_count; k++) {
    advice *a = &v->advice[k];
    sd_messages *mine = sd_messages_new();
    double bad = advice_checks[k](model, mine);
    if (bad > 0 && (a->n++ == 0 || bad > a->worst)) {
      free(a->warning);
      *a = (advice){a->n, point, bad, memory_text(sd_messages_text(mine, 0))};
    }
    sd_messages_free(mine);
  }
}

static void look_at_memory(needs *n, size_t point, const sd_model *model) {
  const double usual = size_memory(model);
  sd_messages *mine = sd_messages_new();
  n->least = fmin(n->least, state_least_bytes(model));
  if (usual > n->most) {
    n->most = usual;
    n->largest = point;
  }
  if (state_refuse(model, mine) != SD_OK && n->refused++ == 0) {
    n->first = point;
    n->why = memory_text(sd_messages_text(mine, 0));
  }
  sd_messages_free(mine);
}

static bool visit(void *user, size_t point, sd_model *model) {
  precheck *v = user;
  v->steps[point] = sd_model_steps(model);
  look_at_advice(v, point, model);
  look_at_memory(&v->needs, point, model);
  sweep_columns(v->s, point, model, v->collected);
  return find_kind(v, model, &v->kinds[point]);
}

/* Adds the stored warnings about the points to the messages. all: true if no point has mistakes. */
static void conclude(const precheck *v, bool all, sd_messages *messages) {
  const deck_sweep *d = &v->s->deck;
  if (!d->written)
    sd_warn(messages, "%s: there is no group sweep: one point, \"%s\", is the deck as it stands",
            d->deck_path, d->points[0].name);
  for (size_t k = 0; k < advice_count; k++) {
    const advice *a = &v->advice[k];
    if (a->warning && !messages_have(messages, a->warning))
      sd_warn(messages, "%s (point %zu, %s%s; %zu of %zu sets of values)", a->warning, a->point,
              d->points[a->point].name, a->n > 1 ? ", the worst" : "", a->n, d->n_sets);
  }
  for (size_t k = 0; all && k < d->n_collect; k++)
    if (!v->collected[k])
      sd_warn(messages, "collect: \"%s\" will be no column of the table", d->collect[k]);
}

/* Checks that points that run side by side fit into the memory of the machine together. Returns
 * SD_ERROR_IO if they do not; only warns if the estimate, but not the lower bound, is too large. */
static sd_status conclude_memory(const needs *n, const sweep *s, size_t workers,
                                 sd_messages *messages) {
  const deck_sweep *d = &s->deck;
  char need[40], there[40];
  if (n->refused > 0)
    return sd_fail(messages, SD_ERROR_IO, "%s (point %zu, %s; %zu of %zu sets of values)", n->why,
                   n->first, d->points[n->first].name, n->refused, d->n_sets);
  size_t side_by_side = 0;
  for (size_t k = 0; k < d->n_points && side_by_side < workers; k++) {
    const sweep_status there_is = sweep_peek(s, k);
    side_by_side += there_is != SWEEP_DONE && there_is != SWEEP_RUNNING;
  }
  if (side_by_side < 2) return SD_OK;
  const double limit = memory_limit(side_by_side);
  if (n->most <= limit) return SD_OK;
  size_t fewer = side_by_side;
  while (fewer > 1 && n->most > memory_limit(fewer)) fewer--;
  size_text(limit, there, sizeof there);
  if (n->least > limit)
    return sd_fail(
        messages, SD_ERROR_IO,
        "-j %zu: each point needs at least %s of memory, and each of %zu processes can have %s; "
        "expected -j %zu at most",
        workers, size_text(n->least, need, sizeof need), side_by_side, there, fewer);
  sd_warn(messages,
          "-j %zu: point %zu, %s, needs about %s of memory, and each of %zu processes can have %s: "
          "they may "
          "be killed; expected -j %zu at most",
          workers, n->largest, d->points[n->largest].name, size_text(n->most, need, sizeof need),
          side_by_side, there, fewer);
  return SD_OK;
}

sd_status sweep_precheck(const sweep *s, size_t workers, int64_t *steps, int *kinds, size_t *usable,
                         sd_messages *messages) {
  precheck v = {.s = s,
                .steps = steps,
                .kinds = kinds,
                .needs.least = HUGE_VAL,
                .collected = memory_new(s->deck.n_collect, sizeof *v.collected),
                .advice = memory_new(advice_count, sizeof *v.advice)};
  size_t *first = memory_new(s->deck.n_sets, sizeof *first);
  for (size_t k = 0; k < s->deck.n_sets; k++) first[k] = SIZE_MAX;
  for (size_t k = 0; k < s->deck.n_points; k++) {
    steps[k] = 0;
    kinds[k] = SWEEP_ALONE;
  }
  sd_status status = sweep_check(s, visit, &v, usable, messages);
  /* All points of a set of parameter values have the same length and kind as its first point, which
   * was visited. */
  for (size_t k = 0; k < s->deck.n_points; k++) {
    size_t *mine = &first[s->deck.points[k].set];
    if (*mine == SIZE_MAX) *mine = k;
    steps[k] = steps[*mine];
    kinds[k] = kinds[*mine];
  }
  conclude(&v, status == SD_OK, messages);
  *usable -= v.needs.refused;
  const sd_status room = conclude_memory(&v.needs, s, workers, messages);
  /* The points of all workers together need too much memory */
  if (room != SD_OK && v.needs.refused == 0) *usable = 0;
  if (status == SD_OK) status = room;
  free(v.needs.why);
  for (int k = 0; k < v.n_kinds; k++) sd_model_free(v.models[k]);
  for (size_t k = 0; k < advice_count; k++) free(v.advice[k].warning);
  free(v.advice);
  free(v.collected);
  free(first);
  return status;
}

/* --- checks of the folder --------------------------------------------------------------------- */

/* Returns an error if a sample of the points with files shows any made with another deck. Points
 * first ... end - 1 are not sampled. */
static sd_status look_at_sample(const sweep *s, const sweep_contents *there, size_t first,
                                size_t end, sd_messages *messages) {
  sweep_tally others = {0};
  size_t n = 0, met = 0;
  for (size_t k = 0; k < s->deck.n_points; k++) n += there->has[k] && (k < first || k >= end);
  size_t every = n / SAMPLE + 1;
  others.sampled = every > 1 || n < there->known;
  for (size_t k = 0; k < s->deck.n_points; k++) {
    if (!there->has[k] || (k >= first && k < end) || met++ % every != 0) continue;
    sweep_result r;
    sweep_look(s, k, &r);
    sweep_tally_add(&others, &r);
    sweep_result_free(&r);
  }
  sd_status status = sweep_refuse_other_decks(s, &others, "nothing is run", messages);
  sweep_tally_free(&others);
  return status;
}

sd_status sweep_guard(const sweep *s, const sweep_command *c, size_t first, size_t end,
                      sd_messages *messages) {
  sweep_contents there;
  if (c->mix) return SD_OK;
  sweep_list(s, &there);
  sd_status status = sweep_refuse_unknown_points(s, &there, "nothing is run", messages);
  if (status == SD_OK && !c->force) status = look_at_sample(s, &there, first, end, messages);
  sweep_contents_free(&there);
  return status;
}
