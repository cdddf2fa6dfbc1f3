/* sweep.c: the subcommand `slipdisk sweep DECK`: its arguments, its lists and tables of points, and
 * the run of a single point. sweep_run.c runs all points of a sweep. */
#include <assert.h>
#include <limits.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "app/app.h"
#include "app/sweep/sweep.h"
#include "base/memory.h"
#include "base/text.h"
#include "io/store/file.h"

/* Longest time in s that the option --table waits while another process writes the same tables. */
static const double TABLE_PATIENCE = 600;
static const option_limits whole = {1, 4096, " is no whole number from 1 to 4096"};
static const option_row rows[] = {
    {"output", 'o', OPTION_PATH, offsetof(sweep_command, output), NULL, "FOLDER",
     "where the results go; by default NAME.sweep for a deck NAME.cfg"},
    {"define", 'D', OPTION_LIST, offsetof(sweep_command, overrides), NULL, "PATH=VALUE",
     "set a key of the deck, as in -D gravity.tilt=0.1; may be repeated"},
    {"jobs", 'j', OPTION_NUMBER, offsetof(sweep_command, workers), &whole, "N", "points at a time"},
    {"threads", 0, OPTION_NUMBER, offsetof(sweep_command, threads), &whole, "N",
     "threads of each point"},
    {"quiet", 'q', OPTION_FLAG, offsetof(sweep_command, quiet), NULL, NULL,
     "errors and warnings only"},
    {"force", 0, OPTION_FLAG, offsetof(sweep_command, force), NULL, NULL,
     "run finished points again"},
    {"skip", 0, OPTION_FLAG, offsetof(sweep_command, skip), NULL, NULL,
     "mistakes of some points do not keep the others from being run"},
    {"mix", 0, OPTION_FLAG, offsetof(sweep_command, mix), NULL, NULL,
     "go on when points in the folder belong to another deck or sweep"},
    {"no-lanes", 0, OPTION_FLAG, offsetof(sweep_command, no_lanes), NULL, NULL,
     "run alike points of few disks one by one and not side by side in vectors, to the same "
     "results"},
    {"no-wait", 0, OPTION_FLAG, offsetof(sweep_command, no_wait), NULL, NULL,
     "leave points that other processes run to them, and end with status 6"},
    {"point", 0, OPTION_TEXT, offsetof(sweep_command, range), NULL, "K[-L]",
     "run these points only"},
    {"status", 0, OPTION_FLAG, offsetof(sweep_command, status), NULL, NULL, "tell how far it is"},
    {"list", 0, OPTION_FLAG, offsetof(sweep_command, list), NULL, NULL,
     "tell all points, with their numbers"},
    {"json", 0, OPTION_FLAG, offsetof(sweep_command, json), NULL, NULL,
     "--status or --list of all points, for programs"},
    {"count", 0, OPTION_FLAG, offsetof(sweep_command, count), NULL, NULL,
     "tell how many points there are"},
    {"table", 0, OPTION_FLAG, offsetof(sweep_command, table), NULL, NULL,
     "write the table of what is there"},
    CONFINED_OPTION,
};
const command_line app_sweep_line = {
    .name = "sweep",
    .n = sizeof rows / sizeof *rows,
    .rows = rows,
    .operand = OPERAND_DECK,
    .offset = offsetof(sweep_command, deck),
    .operands = "DECK",
    .summary = "Runs all points of the deck's group `sweep`, and writes a table of the results",
    .more = "Given again it continues; points that failed are tried again. Under mpirun (in a "
            "build with "
            "MPI) the ranks\n"
            "share the points. A DECK of - is the standard input.\n",
    .examples = "slipdisk sweep sweep.cfg --list\n"
                "slipdisk sweep sweep.cfg -j 2           # makes sweep.sweep/, with means.csv\n"
                "slipdisk sweep sweep.cfg --status\n"};

static int parse(int argc, char **argv, sweep_command *c) {
  int mistake = options_parse(&app_sweep_line, argc, argv, c);
  if (!mistake && c->status + c->list + c->table + c->count + (c->range != NULL) > 1)
    return app_misuse("sweep", "--status, --list, --table, --count and --point exclude each other");
  if (!mistake && c->json && !c->status && !c->list)
    return app_misuse("sweep", "--json belongs to --status or --list");
  return mistake;
}

/* Reads the value of the option --point, such as "17" or "16-23". A range may end beyond the last
 * point, since job arrays often come in blocks of equal size. */
static int parse_range(const sweep *s, sweep_command *c) {
  long last = (long)s->deck.n_points - 1;
  const char *text = c->range, *dash = text ? strchr(text, '-') : NULL;
  char from[24];
  if (!text) return 0;
  bool good =
      dash ? (size_t)snprintf(from, sizeof from, "%.*s", (int)(dash - text), text) < sizeof from &&
                 options_number(from, 0, last, &c->point) &&
                 options_number(dash + 1, c->point, LONG_MAX, &c->last)
           : options_number(text, 0, last, &c->point);
  if (!good)
    return app_misuse("sweep", "--point %s: expected K or K-L, points of this sweep are 0 to %ld",
                      text, last);
  if (!dash) c->last = c->point;
  if (c->point == c->last && c->workers > 0)
    return app_misuse("sweep", "--point runs one point: -j has no meaning");
  if (c->last > last && !c->quiet)
    fprintf(stderr, "--point %s: %ld is the last point of this sweep\n", text, last);
  if (c->last > last) c->last = last;
  return 0;
}

/* --- state of the points ---------------------------------------------------------------------- */

/* Prints a line about a sweep point (one run). Returns true if the line has an asterisk, which
 * marks an error bar as not reliable. */
static bool print_point(const sweep *s, size_t k, const sweep_result *r) {
  char finding[200] = "", part[24] = "";
  bool told = r->status == SWEEP_DONE || !*r->message;
  if (r->has_found && r->status != SWEEP_DONE && r->status != SWEEP_OTHER && r->found.steps > 0)
    snprintf(part, sizeof part, " %.1f %%", 100.0 * (double)r->found.step / (double)r->found.steps);
  if (told) sweep_finding(r, finding, sizeof finding);
  printf("%6zu  %-10s%-8s %s  %s%s%s\n", k, sweep_status_names[r->status], part,
         s->deck.points[k].name, finding, *finding && *r->message ? "; " : "", r->message);
  return strchr(finding, '*');
}

/* Prints how the decks with which existing results were made differ from this deck, each difference
 * once. */
static void print_tally(const sweep_tally *t) {
  for (size_t k = 0; k < t->n; k++) {
    char *line = sweep_tally_text(t, k);
    printf("other deck: %s\n", line);
    free(line);
  }
  if (t->more > 0) printf("other deck: ... and %zu more differences\n", t->more);
}

static void print_counts(const sweep *s, const size_t *count) {
  const char *before = ": ";
  printf("%s: %zu points", s->folder, s->deck.n_points);
  for (size_t k = 0; k < SWEEP_STATUSES; k++) {
    if (count[k] == 0) continue;
    printf("%s%zu %s", before, count[k], sweep_status_names[k]);
    before = ", ";
  }
  printf("\n");
}

/* Prints the points of the sweep. list true: all points; false: the number of points of each
 * status, and only those points that have something to report: not those that are finished without
 * doubts, not begun, or made with another deck. */
static void print_points(const sweep *s, bool list) {
  size_t count[SWEEP_STATUSES] = {0}, doubted[DOUBT_KINDS] = {0};
  bool stars = false;
  sweep_tally others = {0};
  for (size_t k = 0; k < s->deck.n_points; k++) {
    sweep_result r;
    sweep_look(s, k, &r);
    count[r.status]++;
    sweep_count_doubts(r.doubts, doubted);
    bool plain = (r.status == SWEEP_DONE && !r.doubts) || r.status == SWEEP_WAITING ||
                 r.status == SWEEP_OTHER;
    if (list || !plain) stars = print_point(s, k, &r) || stars;
    sweep_tally_add(&others, &r);
    sweep_result_free(&r);
  }
  if (stars) printf("*: the error bar is not reliable yet\n");
  if (!list) print_counts(s, count);
  sweep_show_doubts(stdout, doubted);
  print_tally(&others);
  sweep_show_strangers(stdout, s);
  sweep_tally_free(&others);
}

/* --- one point -------------------------------------------------------------------------------- */

typedef struct note {
  const sweep *s;
  size_t point;
} note;

/* Stores the reason why the run of a point failed. If another process is running the point, that is
 * not a failure. */
static void keep_note(void *user, const sd_messages *messages) {
  const note *n = user;
  if (sweep_peek(n->s, n->point) != SWEEP_RUNNING) sweep_note_messages(n->s, n->point, messages);
}

/* Reads the state of a point from its files. *done: true if the point is finished; the function
 * then returns SD_DOUBTFUL if the result is perhaps not reliable. SD_ERROR_USER: the result is
 * damaged or was made with another deck. */
static sd_status look_first(const sweep *s, size_t point, bool quiet, bool *done,
                            sd_messages *messages) {
  sweep_result r;
  const char *name = s->deck.points[point].name;
  sweep_look(s, point, &r);
  *done = r.status == SWEEP_DONE;
  sd_status status = *done && r.doubts ? SD_DOUBTFUL : SD_OK;
  if (*done && !quiet) fprintf(stderr, "point %zu, %s, is done already\n", point, name);
  if (r.status == SWEEP_UNREADABLE)
    status = sd_fail(messages, SD_ERROR_IO, "point %zu, %s: %s", point, name, r.message);
  if (r.status == SWEEP_OTHER || r.status == SWEEP_DAMAGED)
    status = sd_fail(messages, SD_ERROR_USER,
                     "point %zu, %s, is there already: %s: %s; --force runs it again", point, name,
                     sweep_status_names[r.status], r.message);
  sweep_result_free(&r);
  return status;
}

/* Waits while another process runs a point. Returns false if it does and the option --no-wait is
 * given. */
static bool wait_for_point(const sweep *s, const sweep_command *c, size_t point) {
  const char *name = s->deck.points[point].name;
  for (bool told = c->quiet; sweep_peek(s, point) == SWEEP_RUNNING; told = true) {
    if (c->no_wait) {
      app_line(stderr, "point %zu, %s, is left to another process, which runs it", point, name);
      return false;
    }
    if (!told)
      app_line(stderr, "waiting for point %zu, %s, which another process runs", point, name);
    nanosleep(&(struct timespec){.tv_nsec = 100000000}, NULL);
  }
  return true;
}

static int run_one(const sweep *s, const sweep_command *c, sd_messages *messages) {
  size_t point = (size_t)c->point;
  note n = {s, point};
  bool done = false;
  char *result = NULL, *again = NULL;
  sd_model *model = NULL;
  sd_status status = sweep_prepare(s, messages);
  if (status == SD_OK && !wait_for_point(s, c, point)) return APP_ELSEWHERE;
  if (status == SD_OK) status = sweep_guard(s, c, point, point + 1, messages);
  if (status == SD_OK && !c->force) status = look_first(s, point, c->quiet, &done, messages);
  if (status == SD_OK && !done) {
    status = sweep_load(s, point, &model, &result, messages);
    if (status != SD_OK) sweep_note_messages(s, point, messages);
  }
  if (status == SD_OK && !done) {
    again = format_text("resume %s", result);
    drive_options drive = {.result = result,
                           .again = again,
                           .threads = c->threads,
                           .force = c->force,
                           .quiet = c->quiet,
                           .failed = keep_note,
                           .user = &n};
    status = drive_run(model, &drive, messages);
    if (status == SD_OK || status == SD_DOUBTFUL || status == SD_INTERRUPTED)
      sweep_note(s, point, NULL);
  } else {
    sd_messages_print(messages, stderr);
  }
  sd_model_free(model);
  free(result);
  free(again);
  return status;
}

/* --- command ---------------------------------------------------------------------------------- */

static sd_status write_table(const sweep *s, bool mix, sd_messages *messages) {
  sweep_contents there;
  size_t count[SWEEP_STATUSES] = {0};
  if (!file_is_folder(s->folder))
    return sd_fail(messages, SD_ERROR_USER, "there is no folder %s: no point has been run yet",
                   s->folder);
  sweep_list(s, &there);
  sd_status status =
      mix ? SD_OK : sweep_refuse_unknown_points(s, &there, "no table is written", messages);
  if (status == SD_OK) status = sweep_write_tables(s, TABLE_PATIENCE, mix, count, messages);
  if (status == SD_OK) {
    app_line(stdout, "%s/table.csv, table.h5, means.csv", s->folder);
    print_counts(s, count);
    sweep_show_strangers(stdout, s);
  }
  sweep_contents_free(&there);
  return status;
}

/* Reports the mistakes in the decks of all points, also for --count and --list, since the user is
 * about to run them. */
static sd_status check_points(const sweep *s, sd_messages *messages) {
  size_t usable;
  return sweep_check(s, NULL, NULL, &usable, messages);
}

/* Does what the options --table, --status, --list or --count ask for, without running points. */
static sd_status tell(const sweep *s, const sweep_command *c, sd_messages *messages) {
  sd_status status = SD_OK, told = SD_OK;
  if (c->table) return write_table(s, c->mix, messages);
  if (!c->status && !c->skip) status = check_points(s, messages);
  if ((c->status || c->list) && c->json)
    told = sweep_print_json(s);
  else if (c->status || c->list)
    print_points(s, !c->status);
  else if (status == SD_OK)
    printf("%zu\n", s->deck.n_points);
  return status == SD_OK ? told : status;
}

static int command(sweep_command *c, const char *where, sd_messages *messages) {
  sweep s;
  bool only_tell = c->count || c->status || c->list || c->table;
  if (!only_tell) app_catch_signals();
  int status = sweep_open(&s, c->deck, c->overrides.n, c->overrides.item, where, messages);
  if (status == SD_OK) status = parse_range(&s, c);
  if (status == SD_OK && only_tell) status = tell(&s, c, messages);
  sd_messages_print(messages, stderr);
  sd_messages_clear(messages);
  if (status == SD_OK && !only_tell)
    status = c->point >= 0 && c->point == c->last ? run_one(&s, c, messages) : sweep_run_all(&s, c);
  sweep_close(&s);
  return status;
}

int app_sweep(int argc, char **argv) {
  sweep_command c = {.point = -1};
  sd_messages *messages = sd_messages_new();
  int status = parse(argc, argv, &c);
  char *where = NULL;
  if (status == 0) {
    assert(c.deck);
    where = c.output ? memory_text(c.output) : app_default_name(c.deck, "sweep");
    status = command(&c, where, messages);
  }
  free(where);
  free(c.overrides.item);
  sd_messages_free(messages);
  return status;
}
