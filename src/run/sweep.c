/* sweep.c: runs the points (single runs) of a sweep and reads their state from their files; see
 * sweep.h. sweep_table.c writes the tables. */
#include "run/sweep.h"

#include <assert.h>
#include <dirent.h>
#include <stdlib.h>
#include <string.h>

#include "base/limits.h"
#include "base/memory.h"
#include "base/message.h"
#include "base/text.h"
#include "io/results/checkpoint.h"
#include "io/store/file.h"
#include "io/store/folder.h"
#include "run/session.h"
#include "run/sweep_private.h"
#include "slipdisk/deck.h"

sd_status sweep_open(sweep *s, const char *deck, size_t n_overrides, const char *const *overrides,
                     const char *place, sd_messages *messages) {
  *s = (sweep){.folder = memory_text(place)};
  return deck_sweep_load(deck, n_overrides, overrides, &s->deck, messages);
}

void sweep_close(sweep *s) {
  deck_sweep_free(&s->deck);
  free(s->folder);
  *s = (sweep){0};
}

/* --- Checks of all points --------------------------------------------------------------------- */

/* Largest number of different mistakes that are reported. A mistake of the deck itself occurs at
 * every point of the sweep, a mistake in the path of a parameter for every value. */
enum { MOST_MISTAKES = 40 };

typedef struct mistake {
  char *text;
  /* path of the key and what is wrong with it, without its value; equal in messages that report
   * the same mistake */
  char *same;
  /* first point with this mistake, number of sets of parameter values that have it */
  size_t point, sets;
} mistake;

typedef struct mistakes {
  size_t n, more; /* more: number of further mistakes, which are not stored */
  mistake list[MOST_MISTAKES];
} mistakes;

static void note_mistake(mistakes *all, size_t point, const message *found) {
  const subject *about = &found->about;
  char *same =
      about->name ? format_text("%s: %s", about->name, found->wrong) : memory_text(found->text);
  size_t k = 0;
  while (k < all->n && strcmp(all->list[k].same, same) != 0) k++;
  if (k < all->n)
    all->list[k].sets++;
  else if (k < MOST_MISTAKES)
    all->list[all->n++] = (mistake){memory_text(found->text), memory_text(same), point, 1};
  else
    all->more++;
  free(same);
}

static void tell_mistakes(mistakes *all, const sweep *s, sd_messages *messages) {
  for (size_t k = 0; k < all->n; k++) {
    const mistake *m = &all->list[k];
    if (m->sets >= s->deck.n_sets)
      sd_fail(messages, SD_ERROR_USER, "%s", m->text);
    else if (m->sets == 1)
      sd_fail(messages, SD_ERROR_USER, "%s (point %zu, %s)", m->text, m->point,
              s->deck.points[m->point].name);
    else
      sd_fail(messages, SD_ERROR_USER, "%s (point %zu, %s, and others: %zu of %zu sets of values)",
              m->text, m->point, s->deck.points[m->point].name, m->sets, s->deck.n_sets);
    free(m->text);
    free(m->same);
  }
  if (all->more > 0)
    sd_fail(messages, SD_ERROR_USER, "%zu more mistakes of other points", all->more);
}

sd_status sweep_check(const sweep *s, sweep_visitor *visit, void *user, size_t *usable,
                      sd_messages *messages) {
  mistakes all = {0};
  sd_status status = SD_OK;
  unsigned char *seen = memory_new(s->deck.n_sets, 1);
  *usable = 0;
  for (size_t k = 0; k < s->deck.n_points && status != SD_ERROR_IO; k++) {
    size_t set = s->deck.points[k].set;
    if (seen[set]) continue;
    seen[set] = 1;
    sd_messages *mine = sd_messages_new();
    sd_model *model;
    sd_status one = deck_sweep_model(&s->deck, k, &model, mine);
    if (one == SD_OK && visit && visit(user, k, model)) model = NULL;
    *usable += one == SD_OK;
    if (one != SD_OK) status = one;
    for (size_t m = 0; one != SD_OK && m < sd_messages_count(mine); m++)
      note_mistake(&all, k, messages_at(mine, m));
    sd_model_free(model);
    sd_messages_free(mine);
  }
  free(seen);
  tell_mistakes(&all, s, messages);
  return status;
}

sd_status sweep_prepare(const sweep *s, sd_messages *messages) {
  char *points = format_text("%s/points", s->folder);
  sd_status status = file_make_folder(s->folder, messages);
  if (status == SD_OK) status = file_make_folder(points, messages);
  free(points);
  return status;
}

/* --- Functions for callers that run points ---------------------------------------------------- */

void sweep_note(const sweep *s, size_t point, const char *text) {
  char *path = sweep_point_path(s, point, ".failed");
  if (text)
    file_write_atomic(path, text, strlen(text), NULL);
  else if (file_exists(path))
    file_remove(-1, path);
  free(path);
}

void sweep_note_messages(const sweep *s, size_t point, const sd_messages *messages) {
  char *text = memory_text("");
  for (size_t k = 0; k < sd_messages_count(messages); k++)
    text = append_text(text, "%s\n", sd_messages_text(messages, k));
  sweep_note(s, point, text);
  free(text);
}

sd_status sweep_load(const sweep *s, size_t point, sd_model **model, char **result,
                     sd_messages *messages) {
  *model = NULL;
  *result = sweep_point_path(s, point, ".h5");
  return deck_sweep_model(&s->deck, point, model, messages);
}

/* --- Running points, one or several side by side ---------------------------------------------- */

typedef struct jobs jobs;

/* Point of the sweep that is being run. */
typedef struct runner {
  jobs *all;
  size_t k; /* index of the point in the list given to sweep_run */
  sd_model *model;
  char *result;
} runner;

struct jobs {
  const sweep *s;
  const size_t *points;
  const sweep_options *options;
  runner *runners;         /* [n] points to be run */
  session_member *members; /* [n] session (run with its files) of each point */
};

static void tell_progress(void *user, const session_progress *p) {
  const runner *r = user;
  const sweep_options *options = r->all->options;
  if (options->progress) options->progress(options->user, r->k, p);
}

/* Checks the existing result of a finished point, which is not run again. It is an error if the
 * result is damaged or was made with another deck. */
static sd_status leave_finished(const sweep *s, size_t point, sweep_status *status,
                                sd_messages *messages) {
  sweep_result r;
  sd_status looked = SD_OK;
  sweep_look(s, point, &r);
  *status = r.status;
  if (r.status == SWEEP_OTHER || r.status == SWEEP_DAMAGED)
    looked = sd_fail(messages, SD_ERROR_USER,
                     "%s/points/%s.h5 %s (%s); --force runs the point again, -o writes elsewhere",
                     s->folder, s->deck.points[point].name,
                     r.status == SWEEP_OTHER ? "is the result of another deck" : "cannot be read",
                     r.message);
  if (r.status == SWEEP_UNREADABLE) looked = sd_fail(messages, SD_ERROR_IO, "%s", r.message);
  sweep_result_free(&r);
  return looked;
}

/* Tries once to open the session (run with its files) of a point; *out stays NULL if nothing is to
 * be run. *again: set to true if another process may have taken the point in the meantime, so that
 * another try makes sense. */
static sd_status try_to_open(runner *r, session **out, int threads, sweep_status *status,
                             bool *again, sd_messages *messages) {
  const sweep *s = r->all->s;
  const sweep_options *options = r->all->options;
  size_t point = r->all->points[r->k];
  *again = false;
  *out = NULL;
  *status = sweep_peek(s, point);
  if (*status == SWEEP_DONE && !options->force) return leave_finished(s, point, status, messages);
  if (*status == SWEEP_RUNNING) return SD_OK;
  *status = SWEEP_WAITING;
  if (options->stop && *options->stop) return SD_INTERRUPTED;
  *status = SWEEP_FAILED;
  if (!r->model) {
    sd_status loaded = sweep_load(s, point, &r->model, &r->result, messages);
    if (loaded != SD_OK) return loaded;
  }
  session_options how = {.result = r->result,
                         .threads = threads,
                         .force = options->force,
                         .stop = options->stop,
                         .progress = tell_progress,
                         .user = r};
  sd_status opened = session_open(r->model, &how, out, messages);
  *again = opened == SD_ERROR_USER;
  if (opened == SD_INTERRUPTED) *status = SWEEP_WAITING;
  return opened;
}

/* Opens the session (run with its files) of a point; tries up to ATTEMPTS times. */
static sd_status open_point(runner *r, session **out, int threads, sweep_status *status,
                            sd_messages *messages) {
  enum { ATTEMPTS = 3 };
  for (int k = 1;; k++) {
    bool again;
    sd_status opened = try_to_open(r, out, threads, status, &again, messages);
    if (!again || k == ATTEMPTS) return opened;
    sd_messages_clear(messages);
  }
}

/* Ends a point: writes or removes the file NAME.failed, and reports to the caller. The point's
 * session must be closed already, if it had one. */
static void conclude(runner *r, sd_status ran, sweep_status status, sd_messages *messages) {
  const jobs *all = r->all;
  size_t point = all->points[r->k];
  if (status == SWEEP_DONE || status == SWEEP_STOPPED) sweep_note(all->s, point, NULL);
  if (status == SWEEP_FAILED) sweep_note_messages(all->s, point, messages);
  sweep_end end = {point, ran, status, messages};
  all->options->left(all->options->user, r->k, &end);
  sd_model_free(r->model);
  free(r->result);
  sd_messages_free(messages);
}

/* Called when the session of a point has ended; closes it and ends the point. */
static void left(void *user, size_t member) {
  const jobs *all = user;
  session_member *m = &all->members[member];
  session_close(m->session);
  conclude(&all->runners[member], m->status,
           m->status == SD_OK            ? SWEEP_DONE
           : m->status == SD_INTERRUPTED ? SWEEP_STOPPED
                                         : SWEEP_FAILED,
           m->messages);
}

void sweep_run(const sweep *s, size_t n, const size_t *points, const sweep_options *options) {
  jobs all = {.s = s,
              .points = points,
              .options = options,
              .runners = memory_new(n, sizeof *all.runners),
              .members = memory_new(n, sizeof *all.members)};
  size_t running = 0;
  for (size_t k = 0; k < n; k++) {
    sd_messages *messages = sd_messages_new();
    runner *r = &all.runners[running];
    *r = (runner){.all = &all, .k = k};
    session *opened = NULL;
    sweep_status status = SWEEP_FAILED;
    sd_status ran = open_point(r, &opened, n > 1 ? 1 : options->threads, &status, messages);
    if (opened)
      all.members[running++] = (session_member){.session = opened, .messages = messages};
    else
      conclude(r, ran, status, messages);
  }
  session_group_run(running, all.members, left, &all);
  free(all.runners);
  free(all.members);
}

/* --- Other contents of the folder, and refusals because of them ------------------------------- */

/* Name and number of a point, for a list sorted by names. */
typedef struct named {
  const char *name;
  size_t point;
} named;

static int by_name(const void *a, const void *b) {
  const named *p = a, *q = b;
  return strcmp(p->name, q->name);
}

/* Cuts `ending` off a name; returns false if the name does not end in it, or consists of it
 * alone. */
static bool take_ending(char *name, const char *ending) {
  size_t n = strlen(name), m = strlen(ending);
  if (n <= m || strcmp(name + n - m, ending) != 0) return false;
  name[n - m] = 0;
  return true;
}

/* Counts one file or folder in the folder of points by its name; cuts off the ending of the
 * name. */
static void sort_in(sweep_contents *c, char *name, const named *names, size_t n) {
  bool parts = take_ending(name, ".h5.parts"), result = !parts && take_ending(name, ".h5"),
       failure = !parts && !result && take_ending(name, ".failed");
  if (!parts && !result && !failure) return;
  named wanted = {name, 0}, *found = bsearch(&wanted, names, n, sizeof *names, by_name);
  if (found) {
    unsigned char *has = &c->has[found->point];
    c->known += !failure && *has == 0;
    *has |= (unsigned char)(parts ? SWEEP_HAS_PARTS : result ? SWEEP_HAS_RESULT : 0);
    return;
  }
  c->results += result;
  c->parts += parts;
  c->failures += failure;
  if (!c->example) c->example = memory_text(name);
}

void sweep_list(const sweep *s, sweep_contents *out) {
  size_t n = s->deck.n_points;
  char *path = format_text("%s/points", s->folder);
  named *names = memory_new(n, sizeof *names);
  *out = (sweep_contents){.has = memory_new(n, 1)};
  DIR *points = opendir(path); /* opendir returns NULL if the folder does not exist */
  for (size_t k = 0; k < n; k++) names[k] = (named){s->deck.points[k].name, k};
  qsort(names, n, sizeof *names, by_name);
  for (struct dirent *one; points && (one = readdir(points));) sort_in(out, one->d_name, names, n);
  if (points) closedir(points);
  free(names);
  free(path);
}

void sweep_contents_free(sweep_contents *c) {
  free(c->has);
  free(c->example);
  *c = (sweep_contents){0};
}

/* Appends a count, such as "9 results", to the text, after a comma if the text is not empty;
 * appends nothing if n = 0. what, many: the word for one and for several. */
static char *add_count(char *text, size_t n, const char *what, const char *many) {
  if (n == 0) return text;
  return append_text(text, "%s%zu %s%s", *text ? ", " : "", n, what, n == 1 ? "" : many);
}

static char *count_strangers(const sweep_contents *c) {
  char *text = add_count(memory_text(""), c->results, "result", "s");
  text = add_count(text, c->parts, "unfinished run", "s");
  return add_count(text, c->failures, "note of a failure", "s");
}

char *sweep_strangers_text(const sweep *s, const sweep_contents *c) {
  if (!c->example) return NULL;
  char *counts = count_strangers(c);
  char *text = format_text("%s has %s of points that this sweep does not have, such as %s",
                           s->folder, counts, c->example);
  free(counts);
  return text;
}

sd_status sweep_refuse_unknown_points(const sweep *s, const sweep_contents *c, const char *instead,
                                      sd_messages *messages) {
  if (c->known > 0 || c->results + c->parts == 0) return SD_OK;
  char *text = sweep_strangers_text(s, c);
  assert(text);
  sd_fail(messages, SD_ERROR_USER,
          "%s, and nothing of its own: %s; -o writes elsewhere, --mix lets them stay there", text,
          instead);
  free(text);
  return SD_ERROR_USER;
}

sd_status sweep_refuse_other_decks(const sweep *s, const sweep_tally *t, const char *instead,
                                   sd_messages *messages) {
  if (t->points == 0) return SD_OK;
  sd_fail(messages, SD_ERROR_USER,
          "%s%zu point%s in %s %s of another deck: %s. Is a -D missing? -o writes elsewhere, --mix "
          "leaves "
          "them as "
          "they are and goes on with the others, --force runs all again",
          t->sampled ? "at least " : "", t->points, t->points == 1 ? "" : "s", s->folder,
          t->points == 1 ? "is" : "are", instead);
  for (size_t k = 0; k < t->n; k++) {
    char *line = sweep_tally_text(t, k);
    sd_fail(messages, SD_ERROR_USER, "%s", line);
    free(line);
  }
  if (t->more > 0) sd_fail(messages, SD_ERROR_USER, "... and %zu more differences", t->more);
  return SD_ERROR_USER;
}

/* --- Status of a point, from the files in the folder ------------------------------------------ */

const char *const sweep_status_names[SWEEP_STATUSES] = {
    "waiting", "running", "stopped", "done", "failed", "damaged", "unreadable", "other deck"};

char *sweep_point_path(const sweep *s, size_t point, const char *ending) {
  return format_text("%s/points/%s%s", s->folder, s->deck.points[point].name, ending);
}

sweep_status sweep_peek(const sweep *s, size_t point) {
  char *result = sweep_point_path(s, point, ".h5"),
       *parts = sweep_point_path(s, point, ".h5.parts"),
       *failed = sweep_point_path(s, point, ".failed");
  sweep_status status = SWEEP_WAITING;
  /* A result without a folder of part files is finished. Both exist after a kill at the end of a
   * merge, before the folder was removed, and while a finished point is run again. Since the folder
   * is removed last, check for it first. */
  bool running = folder_is_locked(parts), begun = file_is_folder(parts);
  if (running)
    status = SWEEP_RUNNING;
  else if (file_exists(result) && !begun)
    status = SWEEP_DONE;
  else if (file_exists(failed))
    status = SWEEP_FAILED;
  else if (begun)
    status = SWEEP_STOPPED;
  free(result);
  free(parts);
  free(failed);
  return status;
}

/* Returns true if a result was made with the same text of the deck and the same overridden values
 * as the point has now. */
static bool same_text(const sweep *s, size_t point, const provenance *origin) {
  const sweep_point *p = &s->deck.points[point];
  const char *rest = origin->deck_overrides;
  if (strcmp(origin->deck_text, s->deck.deck_text) != 0) return false;
  for (size_t k = 0; k < s->deck.n_overrides + p->n_overrides; k++) {
    const char *text =
        k < s->deck.n_overrides ? s->deck.overrides[k] : p->overrides[k - s->deck.n_overrides];
    size_t n = strlen(text);
    if (strncmp(rest, text, n) != 0 || rest[n] != '\n') return false;
    rest += n + 1;
  }
  return !*rest;
}

/* Compares the deck with which a result or checkpoint was made with the deck of the point; if they
 * differ, sets r->status to SWEEP_OTHER and lists the differences in r. */
static void compare_decks(const sweep *s, size_t point, const provenance *origin, bool finished,
                          sweep_result *r) {
  /* If the texts of the decks are equal, and they name no other files, the point is the same. If
   * the texts differ, this may be due to comments, spelling or other points of the sweep: then
   * compare the completed decks. */
  if (!s->deck.reads_files && same_text(s, point, origin)) return;
  sd_model *model;
  sd_messages *mine = sd_messages_new();
  if (deck_sweep_model(&s->deck, point, &model, mine) != SD_OK) {
    for (size_t k = 0; k < sd_messages_count(mine); k++) sweep_differ(r, sd_messages_text(mine, k));
  } else if (sweep_compare(r, origin->deck_full, sd_model_deck(model)->full, finished) &&
             origin->inputs != 0 && origin->inputs != provenance_inputs(model)) {
    sweep_differ(r, "a file that the deck names, of disks or of a motion's table, has changed");
  }
  sd_model_free(model);
  sd_messages_free(mine);
  if (r->n_differences == 0) return;
  r->status = SWEEP_OTHER;
  r->message = sweep_differences_text(r);
}

/* --- Results and checkpoints ------------------------------------------------------------------ */

/* Recomputes the means of watched disks and of the series in the summary of a finished result, if
 * it was made with this deck (summary_renew). */
static void renew(const sweep *s, size_t point, const h5_file *file, sweep_result *r) {
  sd_model *model = NULL;
  sd_messages *mine = sd_messages_new();
  if (r->found.n_rotations + r->found.n_averages > 0 &&
      deck_sweep_model(&s->deck, point, &model, mine) == SD_OK)
    summary_renew(&r->found, model, file);
  sd_model_free(model);
  sd_messages_free(mine);
}

/* Sets doubts about the result, and the message about them, from the summary. */
static void tell_doubts(sweep_result *r) {
  for (size_t k = 0; k < DOUBT_KINDS; k++)
    if (r->found.doubts[k].text) r->doubts |= 1u << k;
  if (r->doubts) r->message = summary_doubts_text(&r->found);
}

/* Reads the summary of a finished point from its result. */
static void look_at_result(const sweep *s, size_t point, sweep_result *r) {
  char *path = sweep_point_path(s, point, ".h5");
  h5_file *file = NULL;
  provenance origin = {0};
  sd_messages *mine = sd_messages_new();
  sd_status status = h5_open(path, &file, mine);
  if (status == SD_OK) status = checkpoint_check_origin(file, path, mine);
  if (status == SD_OK) provenance_read(&origin, file);
  if (status == SD_OK) status = summary_read(&r->found, file, mine);
  if (status != SD_OK) {
    r->status = SWEEP_DAMAGED;
    r->message = memory_text(sd_messages_count(mine) > 0 ? sd_messages_text(mine, 0) : "");
  } else {
    r->has_found = true;
    compare_decks(s, point, &origin, true, r);
    if (r->status == SWEEP_DONE) renew(s, point, file, r);
    if (r->status == SWEEP_DONE) tell_doubts(r);
  }
  provenance_free(&origin);
  h5_close(file, NULL);
  sd_messages_free(mine);
  free(path);
}

/* Reads the summary from the newest checkpoint, if there is one; another process may remove it at
 * any time. */
static void look_at_checkpoint(const sweep *s, size_t point, sweep_result *r) {
  char *parts = sweep_point_path(s, point, ".h5.parts"), *path = NULL;
  int64_t *steps = NULL;
  size_t n = 0;
  h5_file *file = NULL;
  if (folder_checkpoints(parts, &steps, &n, NULL) == SD_OK && n > 0)
    path = folder_checkpoint(parts, steps[0]);
  if (path && h5_open_sealed(-1, path, &file, NULL, NULL) == SD_OK) {
    provenance origin = {0};
    r->has_found = summary_read(&r->found, file, NULL) == SD_OK;
    if (r->status != SWEEP_RUNNING) {
      provenance_read(&origin, file);
      compare_decks(s, point, &origin, false, r);
    }
    provenance_free(&origin);
  }
  h5_close(file, NULL);
  free(path);
  free(steps);
  free(parts);
}

/* Returns the reason why a point failed from the file NAME.failed, with its lines joined by "; ";
 * the caller frees it. */
static char *read_failure(const sweep *s, size_t point) {
  char *path = sweep_point_path(s, point, ".failed"), *text = memory_text("");
  unsigned char *bytes = NULL;
  size_t size = 0;
  if (file_exists(path)) file_read(path, LIMIT_MIB, &bytes, &size, NULL);
  for (size_t k = 0, n; k < size; k += n + 1) {
    const char *line = (const char *)bytes + k;
    const char *end = memchr(line, '\n', size - k);
    n = end ? (size_t)(end - line) : size - k;
    text = append_text(text, "%s%.*s", *text && n ? "; " : "", (int)n, line);
  }
  free(bytes);
  free(path);
  return text_clean(text);
}

/* Reads the result of a finished point. If that fails, but not because of what is in the file, the
 * point is not damaged; if all of the file can be read then, tries once more. */
static void look_twice(const sweep *s, size_t point, sweep_result *r) {
  look_at_result(s, point, r);
  if (r->status != SWEEP_DAMAGED) return;
  char *path = sweep_point_path(s, point, ".h5");
  sd_messages *why = sd_messages_new();
  const bool read = file_read_through(path, why) == SD_OK && !shortage_seen();
  sweep_result_free(r);
  *r = (sweep_result){.status = read ? SWEEP_DONE : SWEEP_UNREADABLE};
  if (read)
    look_at_result(s, point, r);
  else
    r->message = sd_messages_count(why) > 0 ? memory_text(sd_messages_text(why, 0))
                                            : format_text("no memory to read %s", path);
  sd_messages_free(why);
  free(path);
}

void sweep_look(const sweep *s, size_t point, sweep_result *r) {
  *r = (sweep_result){.status = sweep_peek(s, point)};
  if (r->status == SWEEP_DONE) look_twice(s, point, r);
  if (r->status == SWEEP_RUNNING || r->status == SWEEP_STOPPED || r->status == SWEEP_FAILED)
    look_at_checkpoint(s, point, r);
  if (r->status == SWEEP_FAILED) r->message = read_failure(s, point);
  if (!r->message) r->message = memory_text("");
}

void sweep_result_free(sweep_result *r) {
  summary_free(&r->found);
  sweep_differences_free(r);
  free(r->message);
  *r = (sweep_result){0};
}
