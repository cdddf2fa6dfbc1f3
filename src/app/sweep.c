/* sweep.c: slipdisk sweep DECK: arguments, and what a sweep's folder holds. It is run in sweep_run.c. */
#include <assert.h>
#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "app/app.h"
#include "app/sweep.h"
#include "io/file.h"

/* How long --table waits for another process that is writing the tables, s. */
static const double TABLE_PATIENCE = 600;
/* The largest number that --point takes. */
static const long MOST_POINT = 999999;

enum { FORCE = 256, QUIET, THREADS, STATUS, LIST, TABLE, COUNT, POINT, NO_LANES };

static int parse_number(const char *option, const char *text, long least, long most, long *out) {
  if (app_number(text, least, most, out)) return 0;
  return app_misuse("sweep", "%s %s is no whole number from %ld to %ld", option, text, least, most);
}

/* "17", or "16-23". */
static int parse_points(const char *text, sweep_command *c) {
  const char *dash = *text ? strchr(text + 1, '-') : NULL;
  char from[24];
  int status = 0;
  if (dash && (size_t)snprintf(from, sizeof from, "%.*s", (int)(dash - text), text) < sizeof from) {
    status = parse_number("--point", from, 0, MOST_POINT, &c->point);
    return status ? status : parse_number("--point: after", dash + 1, c->point, MOST_POINT, &c->last);
  }
  status = parse_number("--point", text, 0, MOST_POINT, &c->point);
  c->last = c->point;
  return status;
}

/* Returns 0, or the exit status of a mistake. */
static int parse(int argc, char **argv, sweep_command *c) {
  static const struct option options[] = {
      {"output", required_argument, NULL, 'o'},
      {"define", required_argument, NULL, 'D'},
      {"jobs", required_argument, NULL, 'j'},
      {"force", no_argument, NULL, FORCE},
      {"quiet", no_argument, NULL, QUIET},
      {"threads", required_argument, NULL, THREADS},
      {"status", no_argument, NULL, STATUS},
      {"list", no_argument, NULL, LIST},
      {"table", no_argument, NULL, TABLE},
      {"count", no_argument, NULL, COUNT},
      {"point", required_argument, NULL, POINT},
      {"no-lanes", no_argument, NULL, NO_LANES},
      {NULL, 0, NULL, 0},
  };
  opterr = 0;
  int status = 0;
  for (int k; status == 0 && (k = getopt_long(argc, argv, ":o:D:j:", options, NULL)) != -1;) {
    long n = 0;
    switch (k) {
      case 'o': c->output = optarg; break;
      case 'D': c->overrides[c->n_overrides++] = optarg; break;
      case 'j': status = parse_number("-j", optarg, 1, 4096, &c->workers); break;
      case FORCE: c->force = true; break;
      case QUIET: c->quiet = true; break;
      case STATUS: c->status = true; break;
      case LIST: c->list = true; break;
      case TABLE: c->table = true; break;
      case COUNT: c->count = true; break;
      case NO_LANES: c->no_lanes = true; break;
      case POINT: status = parse_points(optarg, c); break;
      case THREADS:
        status = parse_number("--threads", optarg, 1, 4096, &n);
        c->threads = (int)n;
        break;
      case ':': return app_misuse("sweep", "%s needs a value", argv[optind - 1]);
      default: return app_unknown_option("sweep", options, argv[optind - 1]);
    }
  }
  if (status != 0) return status;
  if (optind >= argc) return app_misuse("sweep", "no deck is given");
  if (optind + 1 < argc)
    return app_misuse("sweep", "one deck is expected, \"%s\" is a second", argv[optind + 1]);
  if (c->status + c->list + c->table + c->count + (c->point >= 0) > 1)
    return app_misuse("sweep", "--status, --list, --table, --count and --point exclude each other");
  if (c->point >= 0 && c->point == c->last && c->workers > 0)
    return app_misuse("sweep", "--point runs one point: -j has no meaning");
  c->deck = argv[optind];
  return 0;
}

const char *sweep_finding(const sweep_result *r, char *text, size_t size) {
  *text = 0;
  if (!r->has_found || r->found.n_rotations == 0) return text;
  const sd_rotation *first = &r->found.rotations[0];
  if (isfinite(first->omega))
    snprintf(text, size, "%s: Omega = %.4g +- %.2g%s", r->found.rotation_names[0], first->omega, first->error,
             first->converged ? "" : " *");
  return text;
}

/* --- what there is ----------------------------------------------------------------------------------------- */

/* True: with a star at an error bar. */
static bool print_point(const sweep *s, size_t k, const sweep_result *r) {
  char finding[200] = "", part[24] = "";
  if (r->has_found && r->status != SWEEP_DONE && r->status != SWEEP_OTHER && r->found.steps > 0)
    snprintf(part, sizeof part, " %.1f %%", 100.0 * (double)r->found.step / (double)r->found.steps);
  printf("%6zu  %-10s%-8s %s  %s\n", k, sweep_status_names[r->status], part, s->deck.points[k].name,
         *r->message ? r->message : sweep_finding(r, finding, sizeof finding));
  return !*r->message && strchr(finding, '*');
}

/* list: all points; else how many of each kind, and those that are neither done nor waiting. */
static sd_status print_points(const sweep *s, bool list, sd_messages *messages) {
  size_t count[SWEEP_STATUSES] = {0};
  bool stars = false;
  sd_status status = SD_OK;
  for (size_t k = 0; k < s->deck.n_points && status == SD_OK; k++) {
    sweep_result r;
    status = sweep_look(s, k, &r, messages);
    count[r.status]++;
    if (status == SD_OK && (list || (r.status != SWEEP_DONE && r.status != SWEEP_WAITING)))
      stars = print_point(s, k, &r) || stars;
    sweep_result_free(&r);
  }
  if (stars) printf("*: the error bar is not reliable yet\n");
  if (list || status != SD_OK) return status;
  printf("%s: %zu points", s->folder, s->deck.n_points);
  const char *before = ": ";
  for (size_t k = 0; k < SWEEP_STATUSES; k++) {
    if (count[k] == 0) continue;
    printf("%s%zu %s", before, count[k], sweep_status_names[k]);
    before = ", ";
  }
  printf("\n");
  return SD_OK;
}

/* --- one point --------------------------------------------------------------------------------------------- */

typedef struct note {
  const sweep *s;
  size_t point;
} note;

/* Why it failed; a point that another process runs has not failed. */
static void keep_note(void *user, const sd_messages *messages) {
  const note *n = user;
  if (sweep_peek(n->s, n->point) != SWEEP_RUNNING) sweep_note_messages(n->s, n->point, messages);
}

/* Is there anything to run? Tells of a finished result, and refuses one of another deck. */
static sd_status look_first(const sweep *s, size_t point, bool quiet, bool *done, sd_messages *messages) {
  sweep_result r;
  const char *name = s->deck.points[point].name;
  sd_status status = sweep_look(s, point, &r, messages);
  *done = r.status == SWEEP_DONE;
  if (status == SD_OK && *done && !quiet) fprintf(stderr, "point %zu, %s, is done already\n", point, name);
  if (status == SD_OK && (r.status == SWEEP_OTHER || r.status == SWEEP_DAMAGED))
    status =
        sd_fail(messages, SD_ERROR_USER, "point %zu, %s, is there already: %s: %s; --force runs it again",
                point, name, sweep_status_names[r.status], r.message);
  sweep_result_free(&r);
  return status;
}

static int run_one(const sweep *s, const sweep_command *c, sd_messages *messages) {
  size_t point = (size_t)c->point;
  note n = {s, point};
  bool done = false;
  char *result = NULL, *again = NULL;
  sd_model *model = NULL;
  sd_status status = sweep_prepare(s, messages);
  if (status == SD_OK && !c->force) status = look_first(s, point, c->quiet, &done, messages);
  if (status == SD_OK && !done) {
    status = sweep_load(s, point, &model, &result, messages);
    if (status != SD_OK) sweep_note_messages(s, point, messages);
  }
  if (status == SD_OK && !done && !(again = file_path("resume %s", result)))
    status = sd_fail(messages, SD_ERROR_IO, "no memory");
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
  free(again);
  return status;
}

/* --- command ----------------------------------------------------------------------------------------------- */

static sd_status write_table(const sweep *s, sd_messages *messages) {
  if (!file_is_folder(s->folder))
    return sd_fail(messages, SD_ERROR_USER, "there is no folder %s: no point has been run yet", s->folder);
  sd_status status = sweep_write_tables(s, TABLE_PATIENCE, messages);
  if (status == SD_OK) printf("%s/table.csv, table.h5, means.csv\n", s->folder);
  return status;
}

static int command(const sweep_command *c, const char *where, sd_messages *messages) {
  sweep s;
  int status = sweep_open(&s, c->deck, c->n_overrides, c->overrides, where, messages);
  if (status == SD_OK && c->point >= (long)s.deck.n_points)
    status = sd_fail(messages, SD_ERROR_USER, "--point %ld: the sweep has points 0 to %zu", c->point,
                     s.deck.n_points - 1);
  if (status == SD_OK && c->count)
    printf("%zu\n", s.deck.n_points);
  else if (status == SD_OK && (c->status || c->list))
    status = print_points(&s, c->list, messages);
  else if (status == SD_OK && c->table)
    status = write_table(&s, messages);
  sd_messages_print(messages, stderr);
  sd_messages_clear(messages);
  if (status == SD_OK && !c->count && !c->status && !c->list && !c->table)
    status = c->point >= 0 && c->point == c->last ? run_one(&s, c, messages) : sweep_run_all(&s, c);
  sweep_close(&s);
  return status;
}

int app_sweep(int argc, char **argv) {
  sweep_command c = {.point = -1, .overrides = calloc((size_t)argc + 1, sizeof *c.overrides)};
  sd_messages *messages = sd_messages_new();
  int status = c.overrides && messages ? parse(argc, argv, &c) : SD_ERROR_IO;
  char *where = NULL;
  if (status == 0) {
    assert(c.deck);
    where = c.output ? file_path("%s", c.output) : app_default_name(c.deck, "sweep");
    status = where ? command(&c, where, messages) : SD_ERROR_IO;
  }
  free(where);
  free(c.overrides);
  sd_messages_free(messages);
  return status;
}
