/* drive.c: a run as the user sees it: signals, progress, the final tables, the exit status. */
#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <math.h>
#include <sched.h>
#include <signal.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "app/app.h"
#include "app/view/view.h"
#include "base/team.h"
#include "base/comm.h"
#include "base/text.h"
#include "io/store/file.h"
#include "model/model.h"
#include "run/ranks.h"
#include "run/session.h"
#include "run/simulation_private.h"

/* --- progress --------------------------------------------------------------------------------- */

typedef struct teller {
  FILE *screen; /* Output stream for progress lines; NULL: no progress lines (--quiet) */
  bool terminal, line_open;
  FILE *log;
  /* Clock readings, s: at the start of the run, and at the last progress line written to the log
   * or to a screen that cannot redraw */
  double began, told_at;
  live *page; /* Page in a browser; NULL: none */
} teller;

/* Shortest and longest time between progress lines in the log or on a screen that cannot redraw,
 * s. The time is a quarter of that since the start, within these limits. */
static const double PLAIN_FIRST = 3, PLAIN_LAST = 60;

/* Appends a value and its goal, such as "  unbalanced 0.02 of 0.001"; appends nothing if goal is
 * 0. */
static void add_goal(char *text, size_t size, const char *what, double value, double goal) {
  size_t n = strlen(text);
  if (goal > 0 && isfinite(value))
    snprintf(text + n, size - n, "  %s %.2g of %.2g", what, value, goal);
}

/* Writes the progress line. If a phase may settle early, the time left is an upper bound. While
 * disks wait for their release (rain), the time left is not known, because steps take longer with
 * every released disk. */
static void describe(const session_progress *p, char *text, size_t size) {
  char left[40], rate[40] = "-", goal[120] = "", done[40] = "", steps[80];
  bool ended = !p->at_most && p->step >= p->expected, early = p->expected < p->steps;
  /* True: the number of steps is only an upper bound */
  bool bound = !ended && (p->at_most || (p->goal && !early));
  if (p->rate >= 1e6)
    snprintf(rate, sizeof rate, "%.3gM", p->rate * 1e-6);
  else if (p->rate >= 1e3)
    snprintf(rate, sizeof rate, "%.3gk", p->rate * 1e-3);
  else if (p->rate > 0)
    snprintf(rate, sizeof rate, "%.3g", p->rate);
  if (ended && early)
    snprintf(steps, sizeof steps, "step %" PRId64 ", the last (of at most %" PRId64 ")", p->step,
             p->steps);
  else if (bound)
    snprintf(steps, sizeof steps, "step %" PRId64 " of at most %" PRId64, p->step, p->steps);
  else if (early)
    snprintf(steps, sizeof steps, "step %" PRId64 " of about %" PRId64 " (at most %" PRId64 ")",
             p->step, p->expected, p->steps);
  else
    snprintf(steps, sizeof steps, "step %" PRId64 "/%" PRId64, p->step, p->steps);
  if (!bound)
    snprintf(done, sizeof done, "  %.1f %%",
             100.0 * (double)p->step / (double)(p->expected > 0 ? p->expected : 1));
  if (p->waiting > 0) snprintf(goal, sizeof goal, "  %" PRId64 " disks wait", p->waiting);
  if (p->rest && p->waiting == 0) {
    add_goal(goal, sizeof goal, "kinetic", p->rest->kinetic, p->rest->kinetic_goal);
    add_goal(goal, sizeof goal, "unbalanced", p->rest->unbalanced, p->rest->unbalanced_goal);
  }
  if (p->goal) add_goal(goal, sizeof goal, "error", p->goal->error, p->goal->goal);
  report_duration(p->waiting > 0 ? NAN : p->seconds_left, left, sizeof left);
  snprintf(text, size, "%s%s%s  time %.6g%s  %s steps/s  ETA %s%s%s  residual %.1e", p->phase,
           *p->phase ? ": " : "", steps, p->time, done, rate, bound && *left != '?' ? "< " : "",
           left, goal, p->energy->residual);
}

static void end_line(teller *t) {
  if (t->line_open) fputc('\n', t->screen);
  t->line_open = false;
}

static void show(void *user, const session_progress *p) {
  teller *t = user;
  char text[400];
  describe(p, text, sizeof text);
  if (t->screen && t->terminal) {
    report_status_line(t->screen, text);
    t->line_open = true;
  }
  double now = clock_seconds();
  double wait = fmin(fmax((now - t->began) / 4, PLAIN_FIRST), PLAIN_LAST);
  if (!p->new_phase && p->step < p->expected && now - t->told_at < wait) return;
  t->told_at = now;
  if (t->screen && !t->terminal) fprintf(t->screen, "%s\n", text);
  if (t->log) {
    fprintf(t->log, "%s\n", text);
    fflush(t->log);
  }
}

/* --- run -------------------------------------------------------------------------------------- */

/* Prints errors and warnings to stderr, even with --quiet, and to the log. */
static void tell_messages(teller *t, const sd_messages *messages) {
  if (sd_messages_count(messages) == 0) return;
  if (t->screen) end_line(t);
  sd_messages_print(messages, stderr);
  if (t->log) sd_messages_print(messages, t->log);
}

static void tell_result(FILE *out, const session *s, const char *result) {
  const summary *found = session_summary(s);
  if (!found) return;
  report_summary(out, found);
  report_cost(out, found, session_provenance(s));
  app_line(out, "result: %s (%.3g MB)", result, (double)file_size(result) / 1e6);
}

static void tell_stop(teller *t, const drive_options *options, const session *s) {
  if (t->screen) end_line(t);
  const summary *found = session_summary(s);
  FILE *outs[2] = {t->screen, t->log};
  for (int k = 0; k < 2; k++) {
    if (!outs[k]) continue;
    if (found)
      fprintf(outs[k],
              "stopped at step %" PRId64 " %s %" PRId64 " (%.1f %%), everything is saved\n",
              found->step, report_of(found), found->steps,
              100.0 * (double)found->step / (double)(found->steps > 0 ? found->steps : 1));
    else
      fprintf(outs[k], "stopped, everything is saved\n");
    app_line(outs[k], "continue with: slipdisk %s", options->again);
  }
}

static void tell_start(teller *t, const drive_options *options, const sd_model *model,
                       const session *s) {
  FILE *outs[2] = {t->screen, t->log};
  for (int k = 0; k < 2; k++) {
    if (!outs[k]) continue;
    if (session_was_finished(s))
      app_line(outs[k], "%s is finished already", options->result);
    else if (session_began(s) > 0)
      app_line(outs[k], "continuing %s from step %" PRId64, options->result, session_began(s));
    else
      app_line(outs[k], "writing %s", options->result);
    const provenance *origin = session_provenance(s);
    if (options->verbose)
      app_line(outs[k],
               "slipdisk %s (%s), %s, %" PRId64 " rank%s of %" PRId64
               " thread%s, %zu disks (%zu free), %zu walls, %zu motions, dt %g",
               origin->version, origin->revision, origin->cpu_path, origin->ranks,
               origin->ranks == 1 ? "" : "s", origin->threads, origin->threads == 1 ? "" : "s",
               model->n_disks, model->n_free, model->n_walls, model->n_motions, model->dt);
    fflush(outs[k]);
  }
}

/* Prints how evenly the work was distributed over the ranks. */
static void tell_balance(teller *t, const session *s) {
  FILE *outs[2] = {t->screen, t->log};
  if (!session_ranks(s)) return;
  const ranks_balance b = ranks_balance_of(session_ranks(s));
  char busy[160] = "";
  if (!isnan(b.excess))
    snprintf(busy, sizeof busy,
             "; in the end each had %" PRId64 " to %" PRId64
             ", and the busiest worked %.0f %% longer than the mean",
             b.least, b.most, 100.0 * b.excess);
  for (int k = 0; k < 2; k++)
    if (outs[k] && b.cuts > 0)
      app_line(outs[k], "the ranks shared out the disks %" PRId64 " time%s%s", b.cuts,
               b.cuts == 1 ? "" : "s", busy);
}

/* Opens the page in the browser that shows the run. If that fails, warns, and the run goes on
 * without it. */
static void open_page(teller *t, const sd_model *model, const char *result) {
  sd_messages *why = sd_messages_new();
  if (live_open(model, result, &t->page, why) == SD_OK)
    fprintf(stderr, "live: %s\n", live_address(t->page));
  for (size_t k = 0; k < sd_messages_count(why); k++)
    fprintf(stderr, "warning: %s; the run goes on without\n", sd_messages_text(why, k));
  sd_messages_free(why);
}

static void look(void *user, sd_simulation *simulation) {
  teller *t = user;
  if (t->page) live_look(t->page, simulation);
}

/* Warns of each reason to doubt the result that the summary has. Returns true if there is one. */
static bool warn_of_doubts(const session *s, sd_messages *messages) {
  const summary *found = session_summary(s);
  for (size_t k = 0; found && k < DOUBT_KINDS; k++)
    if (found->doubts[k].text) sd_warn(messages, "in doubt: %s", found->doubts[k].text);
  return found && summary_doubts(found) > 0;
}

/* Returns the number of cores that this process may use; 0: not known. */
static int cores(void) {
  cpu_set_t set;
  return sched_getaffinity(0, sizeof set, &set) == 0 ? CPU_COUNT(&set) : 0;
}

/* Warns if there are more threads than cores, since threads that share a core delay all others at
 * every step, and if there are more threads than are useful for this number of disks. */
static void warn_of_threads(const sd_model *model, int asked, sd_messages *messages) {
  int most = cores(), best = simulation_threads_for(model, asked);
  if (asked > most && most > 0)
    sd_warn(messages,
            "--threads %d: this process may use %d core%s, and threads that share a core can make "
            "a run a "
            "hundred times slower; give --threads %d, or leave it out",
            asked, most, most == 1 ? "" : "s", best < most ? best : most);
  else if (asked > best)
    sd_warn(messages,
            "--threads %d: a thread costs more than it does with fewer than %d free disks, here "
            "are %zu; "
            "give --threads %d, or leave it out",
            asked, SIMULATION_DISKS_PER_THREAD, model->n_free, best);
}

/* Checks the memory that the run needs, and the free space for its result. With several ranks the
 * memory is not checked: rank 0 does not know how much the other ranks' machines have. */
static sd_status check_size(const sd_model *model, const char *result, sd_messages *messages) {
  result_size size;
  size_find(&size, model);
  if (!comm_world() && size_refuse(model, &size, messages) != SD_OK) return SD_ERROR_IO;
  const char *slash = strrchr(result, '/');
  char *folder = slash ? format_text("%.*s", (int)(slash - result) + 1, result) : format_text(".");
  size_warn(&size, folder, messages);
  free(folder);
  return SD_OK;
}

/* Session (run with its files) that is going on, NULL: none; and command line that continues it.
 * Both are for drive_describe_saved. */
static const session *_Atomic running;
static const char *_Atomic continues_with;

int drive_describe_saved(char *text, size_t size) {
  const session *s = running;
  const int64_t step = s ? session_saved(s) : -1;
  *text = 0;
  if (step <= 0) return 0;
  const int n = snprintf(text, size,
                         "; everything until step %" PRId64 " is saved, continue with: slipdisk %s",
                         step, continues_with);
  return n < 0 ? 0 : n < (int)size ? n : (int)size - 1;
}

/* Runs a session, unless `status`, the outcome of the preparations, is an error. Prints start,
 * progress and result. Returns the exit status. */
static int run_session(const sd_model *model, const drive_options *options, teller *t,
                       sd_status status, sd_messages *messages) {
  const bool leads = comm_rank(comm_world()) == 0;
  session_options how = {.result = options->result,
                         .threads = (int)options->threads,
                         .force = options->force,
                         .stop = &app_stop,
                         .comm = comm_world(),
                         .progress = leads ? show : NULL,
                         .look = options->live ? look : NULL,
                         .user = t};
  session *s;
  if (leads && status == SD_OK) {
    sd_model_advise(model, messages);
    status = check_size(model, options->result, messages);
    warn_of_threads(model, (int)options->threads, messages);
  }
  status = comm_wait(comm_world(), status);
  if (status == SD_OK) status = session_open(model, &how, &s, messages);
  if (leads) tell_messages(t, messages);
  if (status == SD_INTERRUPTED && t->screen) app_tell_no_start();
  if (status != SD_OK) {
    if (leads && options->failed && status != SD_INTERRUPTED)
      options->failed(options->user, messages);
    return status;
  }
  continues_with = options->again;
  running = s;
  if (leads) tell_start(t, options, model, s);
  if (options->live && !session_was_finished(s)) open_page(t, model, options->result);
  sd_messages *later = sd_messages_new();
  status = session_run(s, later);
  live_close(t->page);
  bool in_doubt = leads && status == SD_OK && !session_was_finished(s) && warn_of_doubts(s, later);
  if (leads) tell_messages(t, later);
  if (leads && status != SD_OK && status != SD_INTERRUPTED && options->failed)
    options->failed(options->user, later);
  sd_messages_free(later);
  if (status == SD_INTERRUPTED && leads) tell_stop(t, options, s);
  if (status == SD_OK && t->screen) {
    end_line(t);
    tell_result(stdout, s, options->result);
  }
  if (status == SD_OK && t->log) tell_result(t->log, s, options->result);
  if (options->verbose && leads) tell_balance(t, s);
  running = NULL;
  session_close(s);
  return in_doubt ? SD_DOUBTFUL : status;
}

/* Opens the log file for appending; refuses a symbolic link as its path. */
static int open_log(teller *t, const char *path) {
  int fd = file_open_at(AT_FDCWD, path, O_WRONLY | O_APPEND | O_CREAT | O_NOFOLLOW | O_NONBLOCK);
  if (fd >= 0 && (t->log = fdopen(fd, "a"))) return SD_OK;
  bool link = fd < 0 && errno == ELOOP;
  app_line(stderr, "error: cannot write %s: %s", path,
           link ? "it is a symbolic link" : file_error_text(errno));
  if (fd >= 0) close(fd);
  return link ? SD_ERROR_USER : SD_ERROR_IO;
}

static void tell_end(const char *why) {
  app_line(stderr, "error: rank %d: %s; the job ends", comm_rank(comm_world()), why);
}

int drive_begin(const drive_options *options, sd_messages *messages) {
  int status = comm_begin(messages);
  comm_on_fail(tell_end);
  if (status == SD_OK && comm_world() && options->live)
    status = sd_fail(
        messages, SD_ERROR_USER,
        "--live shows the disks of one process; expected a run without mpirun, or without --live");
  if (status != SD_OK && comm_rank(comm_world()) == 0) sd_messages_print(messages, stderr);
  /* A signal must not end one rank at once, since the other ranks would wait for it for ever. */
  if (comm_world()) app_begin_saving();
  return status;
}

int drive_agree(int status, sd_messages *messages) {
  int first = status;
  comm_broadcast(comm_world(), &first, sizeof first);
  if (status != SD_OK && (comm_rank(comm_world()) == 0 || first == SD_OK))
    sd_messages_print(messages, stderr);
  if (comm_rank(comm_world()) > 0) sd_messages_clear(messages);
  return comm_max(comm_world(), status);
}

int drive_run(const sd_model *model, const drive_options *options, sd_messages *messages) {
  const bool leads = comm_rank(comm_world()) == 0;
  int status = SD_OK;
  app_begin_saving();
  double now = clock_seconds();
  teller t = {.screen = options->quiet || !leads ? NULL : stderr,
              .terminal = report_redraws(stderr),
              .began = now,
              .told_at = now};
  if (options->log && leads) status = open_log(&t, options->log);
  status = run_session(model, options, &t, status, messages);
  if (t.log) fclose(t.log);
  comm_broadcast(comm_world(), &status, sizeof status);
  return status;
}

/* --- signals that stop a run ------------------------------------------------------------------ */

volatile sig_atomic_t app_stop;
static volatile sig_atomic_t begun;

void app_tell_no_start(void) {
  static const char text[] = "stopped before the first step: there was nothing new to save\n";
  ssize_t told = write(STDERR_FILENO, text, sizeof text - 1);
  (void)told; /* An error of this write cannot be reported. */
}

/* Signal handler. Until app_begin_saving is called, there is nothing to save, and the handler ends
 * the process at once. Afterwards it only sets app_stop. */
static void ask_stop(int number) {
  if (begun) {
    app_stop = number;
    return;
  }
  app_tell_no_start();
  _exit(SD_INTERRUPTED);
}

void app_catch_signals(void) {
  struct sigaction action = {.sa_handler = ask_stop, .sa_flags = SA_RESTART};
  sigemptyset(&action.sa_mask);
  /* Batch systems send XCPU, USR1, USR2 and TERM before they kill a job. ALRM is caught too: an
   * alarm set by the caller survives exec. */
  const int stops[] = {SIGINT, SIGTERM, SIGUSR1, SIGUSR2, SIGXCPU, SIGALRM};
  for (size_t k = 0; k < sizeof stops / sizeof *stops; k++) sigaction(stops[k], &action, NULL);
  /* A closed terminal stops a run like Ctrl-C, but not under nohup, which ignores SIGHUP. */
  struct sigaction before;
  if (sigaction(SIGHUP, NULL, &before) == 0 && before.sa_handler != SIG_IGN)
    sigaction(SIGHUP, &action, NULL);
  /* Exceeding a file-size limit, or writing to a closed pipe, shall make write fail and not end the
   * process. */
  struct sigaction ignore = {.sa_handler = SIG_IGN};
  sigemptyset(&ignore.sa_mask);
  sigaction(SIGXFSZ, &ignore, NULL);
  sigaction(SIGPIPE, &ignore, NULL);
}

void app_begin_saving(void) { begun = 1; }
