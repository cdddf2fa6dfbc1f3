/* sweep.c: see sweep.h. Points are run in sweep_points.c, the tables are written by sweep_table.c. */
#include "run/sweep.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "io/file.h"
#include "io/folder.h"
#include "run/deck_diff.h"

const char *const sweep_status_names[SWEEP_STATUSES] = {"waiting", "running", "stopped",   "done",
                                                        "failed",  "damaged", "other deck"};

static sd_status no_memory(sd_messages *messages) {
  return sd_fail(messages, SD_ERROR_IO, "no memory for the sweep");
}

sd_status sweep_open(sweep *s, const char *deck, size_t n_overrides, const char *const *overrides,
                     const char *place, sd_messages *messages) {
  *s = (sweep){.folder = file_path("%s", place)};
  if (!s->folder) return no_memory(messages);
  return deck_sweep_load(deck, n_overrides, overrides, &s->deck, messages);
}

void sweep_close(sweep *s) {
  deck_sweep_free(&s->deck);
  free(s->folder);
  *s = (sweep){0};
}

/* --- checks ------------------------------------------------------------------------------------------------ */

/* Mistakes of the deck itself come with every point, and those of a path with every value. */
enum { MOST_MISTAKES = 40 };

typedef struct mistake {
  char *text;
  size_t point, sets; /* the first that makes it, and how many do */
} mistake;

typedef struct mistakes {
  size_t n, more; /* more: not kept */
  mistake list[MOST_MISTAKES];
} mistakes;

/* Cuts "file:line: path = value: what is wrong" up; false: it has another form. */
static bool cut(const char *text, const char **path, size_t *n, const char **wrong) {
  const char *equals = strstr(text, " = ");
  if (!equals) return false;
  for (*path = equals; *path > text && (*path)[-1] != ' ';) --*path;
  *n = (size_t)(equals - *path);
  *wrong = strrchr(equals, ':');
  return *wrong != NULL;
}

/* The same is wrong with the same path, whatever the value. */
static bool same_mistake(const char *a, const char *b) {
  const char *path, *other, *wrong, *amiss;
  size_t n, m;
  if (!cut(a, &path, &n, &wrong) || !cut(b, &other, &m, &amiss)) return strcmp(a, b) == 0;
  return n == m && strncmp(path, other, n) == 0 && strcmp(wrong, amiss) == 0;
}

static void note_mistake(mistakes *all, size_t point, const char *text) {
  for (size_t k = 0; k < all->n; k++)
    if (same_mistake(all->list[k].text, text)) {
      all->list[k].sets++;
      return;
    }
  char *copy = all->n < MOST_MISTAKES ? file_path("%s", text) : NULL;
  if (copy)
    all->list[all->n++] = (mistake){copy, point, 1};
  else
    all->more++;
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
      sd_fail(messages, SD_ERROR_USER, "%s (point %zu, %s, and others: %zu of %zu sets of values)", m->text,
              m->point, s->deck.points[m->point].name, m->sets, s->deck.n_sets);
    free(m->text);
  }
  if (all->more > 0) sd_fail(messages, SD_ERROR_USER, "%zu more mistakes of other points", all->more);
}

sd_status sweep_check(const sweep *s, sweep_visitor *visit, void *user, size_t *usable,
                      sd_messages *messages) {
  mistakes all = {0};
  sd_status status = SD_OK;
  unsigned char *seen = calloc(s->deck.n_sets + 1, 1);
  *usable = 0;
  if (!seen) return no_memory(messages);
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
      note_mistake(&all, k, sd_messages_text(mine, m));
    sd_model_free(model);
    sd_messages_free(mine);
  }
  free(seen);
  tell_mistakes(&all, s, messages);
  return status;
}

sd_status sweep_prepare(const sweep *s, sd_messages *messages) {
  char *points = file_path("%s/points", s->folder);
  sd_status status = points ? file_make_folder(s->folder, messages) : no_memory(messages);
  if (status == SD_OK) status = file_make_folder(points, messages);
  free(points);
  return status;
}

/* --- what is there ----------------------------------------------------------------------------------------- */

static char *point_path(const sweep *s, size_t point, const char *ending) {
  return file_path("%s/points/%s%s", s->folder, s->deck.points[point].name, ending);
}

sweep_status sweep_peek(const sweep *s, size_t point) {
  char *result = point_path(s, point, ".h5"), *parts = point_path(s, point, ".h5.parts"),
       *failed = point_path(s, point, ".failed");
  sweep_status status = SWEEP_WAITING;
  if (result && parts && failed) {
    /* A result without parts is finished. Both are there at the end of the merge, after a kill there (the parts
     * have to go), and when a finished point is run again. The parts vanish last, so they are looked for first. */
    bool running = folder_is_locked(parts), begun = file_is_folder(parts);
    if (running)
      status = SWEEP_RUNNING;
    else if (file_exists(result) && !begun)
      status = SWEEP_DONE;
    else if (file_exists(failed))
      status = SWEEP_FAILED;
    else if (begun)
      status = SWEEP_STOPPED;
  }
  free(result);
  free(parts);
  free(failed);
  return status;
}

static bool same_text(const sweep *s, size_t point, const provenance *origin) {
  const sweep_point *p = &s->deck.points[point];
  const char *rest = origin->deck_overrides;
  if (strcmp(origin->deck_text, s->deck.deck_text) != 0) return false;
  for (size_t k = 0; k < s->deck.n_overrides + p->n_overrides; k++) {
    const char *text = k < s->deck.n_overrides ? s->deck.overrides[k] : p->overrides[k - s->deck.n_overrides];
    size_t n = strlen(text);
    if (strncmp(rest, text, n) != 0 || rest[n] != '\n') return false;
    rest += n + 1;
  }
  return !*rest;
}

static char *join(const sd_messages *messages, size_t most) {
  char *text = file_path("%s", "");
  for (size_t k = 0; text && k < sd_messages_count(messages) && k < most; k++) {
    char *longer = file_path("%s%s%s", text, k ? "; " : "", sd_messages_text(messages, k));
    free(text);
    text = longer;
  }
  return text;
}

/* What a result says and what the point would be run with; NULL: they are the same. To be freed. */
static char *deck_difference(const sweep *s, size_t point, const provenance *origin) {
  enum { LINES = 4 };
  /* what stands in other files is not in the text; the rest of the sweep, comments and other words for the same
   * are: there the full deck decides */
  if (!s->deck.reads_files && same_text(s, point, origin)) return NULL;
  sd_model *model;
  sd_messages *mine = sd_messages_new();
  char *text = NULL;
  if (deck_sweep_model(&s->deck, point, &model, mine) != SD_OK) {
    text = join(mine, LINES);
  } else if (!deck_same(origin->deck_full, model->deck_full)) {
    deck_diff(origin->deck_full, model->deck_full, mine);
    text = join(mine, LINES);
  } else if (origin->inputs != 0 && origin->inputs != provenance_inputs(model)) {
    text = file_path("a file that the deck names, of disks or of a motion's table, has changed");
  }
  sd_model_free(model);
  sd_messages_free(mine);
  return text;
}

/* Reads a finished result. */
static sd_status look_at_result(const sweep *s, size_t point, sweep_result *r, sd_messages *messages) {
  char *path = point_path(s, point, ".h5");
  if (!path) return no_memory(messages);
  h5_file *file = NULL;
  provenance origin = {0};
  sd_messages *mine = sd_messages_new();
  sd_status status = h5_open(path, &file, mine);
  if (status == SD_OK) status = provenance_read(&origin, file, mine);
  if (status == SD_OK) status = summary_read(&r->found, file, mine);
  if (status != SD_OK) {
    r->status = SWEEP_DAMAGED;
    r->message = join(mine, 1);
  } else {
    r->has_found = true;
    r->message = deck_difference(s, point, &origin);
    if (r->message) r->status = SWEEP_OTHER;
  }
  provenance_free(&origin);
  h5_close(file, NULL);
  sd_messages_free(mine);
  free(path);
  return SD_OK;
}

/* Reads the newest checkpoint; without one there is nothing to tell, and it may vanish while we look. */
static void look_at_checkpoint(const sweep *s, size_t point, sweep_result *r) {
  char *parts = point_path(s, point, ".h5.parts"), *path = NULL;
  int64_t *steps = NULL;
  size_t n = 0;
  h5_file *file = NULL;
  if (parts && folder_checkpoints(parts, &steps, &n, NULL) == SD_OK && n > 0)
    path = folder_checkpoint(parts, steps[0]);
  if (path && h5_open_sealed(path, &file, NULL) == SD_OK)
    r->has_found = summary_read(&r->found, file, NULL) == SD_OK;
  h5_close(file, NULL);
  free(path);
  free(steps);
  free(parts);
}

static char *read_failure(const sweep *s, size_t point) {
  char *path = point_path(s, point, ".failed"), *text = NULL;
  unsigned char *bytes = NULL;
  size_t size = 0;
  if (path && file_exists(path) && file_read(path, SIZE_MAX, &bytes, &size, NULL) == SD_OK) {
    while (size > 0 && bytes[size - 1] == '\n') size--;
    for (size_t k = 0; k < size; k++)
      if (bytes[k] == '\n') bytes[k] = ';';
    text = file_path("%.*s", (int)size, (const char *)bytes);
  }
  free(bytes);
  free(path);
  return text ? text : file_path("%s", "");
}

sd_status sweep_look(const sweep *s, size_t point, sweep_result *r, sd_messages *messages) {
  *r = (sweep_result){.status = sweep_peek(s, point), .residual = NAN};
  sd_status status = SD_OK;
  if (r->status == SWEEP_DONE) status = look_at_result(s, point, r, messages);
  if (r->status == SWEEP_RUNNING || r->status == SWEEP_STOPPED || r->status == SWEEP_FAILED)
    look_at_checkpoint(s, point, r);
  if (r->status == SWEEP_FAILED) r->message = read_failure(s, point);
  if (!r->message) r->message = file_path("%s", "");
  if (r->has_found && r->found.energy.scale > 0)
    r->residual = r->found.energy.residual / r->found.energy.scale;
  return status == SD_OK && !r->message ? no_memory(messages) : status;
}

void sweep_result_free(sweep_result *r) {
  summary_free(&r->found);
  free(r->message);
  *r = (sweep_result){0};
}

/* --- for those who run points ------------------------------------------------------------------------------ */

void sweep_note(const sweep *s, size_t point, const char *text) {
  char *path = point_path(s, point, ".failed");
  file_piece piece = {text, text ? strlen(text) : 0};
  if (path && text)
    file_write_atomic(path, 1, &piece, NULL);
  else if (path && file_exists(path))
    file_remove(path, NULL);
  free(path);
}

void sweep_note_messages(const sweep *s, size_t point, const sd_messages *messages) {
  char *text = file_path("%s", "");
  for (size_t k = 0; text && k < sd_messages_count(messages); k++) {
    char *longer = file_path("%s%s\n", text, sd_messages_text(messages, k));
    free(text);
    text = longer;
  }
  if (text) sweep_note(s, point, text);
  free(text);
}

sd_status sweep_load(const sweep *s, size_t point, sd_model **model, char **result, sd_messages *messages) {
  *model = NULL;
  *result = point_path(s, point, ".h5");
  return *result ? deck_sweep_model(&s->deck, point, model, messages) : no_memory(messages);
}
