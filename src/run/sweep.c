/* sweep.c: see sweep.h. The tables are written by sweep_table.c. */
#include "run/sweep.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "io/file.h"
#include "io/folder.h"
#include "run/deck_diff.h"

const char *const sweep_status_names[SWEEP_STATUSES] = {"waiting", "running", "stopped",
                                                        "done",    "failed",  "other deck"};

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

static bool told_already(const sd_messages *messages, const char *text) {
  for (size_t k = 0; k < sd_messages_count(messages); k++)
    if (strcmp(sd_messages_text(messages, k), text) == 0) return true;
  return false;
}

/* Mistakes of the deck itself come with every point: each is told once. */
static void merge_messages(sd_messages *to, const sd_messages *from) {
  for (size_t k = 0; k < sd_messages_count(from); k++) {
    const char *text = sd_messages_text(from, k);
    if (!told_already(to, text)) sd_fail(to, SD_ERROR_USER, "%s", text);
  }
}

sd_status sweep_check(const sweep *s, size_t *usable, int64_t *steps, sd_messages *messages) {
  sd_status status = SD_OK;
  *usable = 0;
  for (size_t k = 0; k < s->deck.n_points; k++) {
    const sweep_point *p = &s->deck.points[k];
    if (k > 0 && p->set == p[-1].set) {
      if (steps) steps[k] = steps[k - 1];
      continue;
    }
    sd_messages *mine = sd_messages_new();
    sd_model *model;
    sd_status one = deck_sweep_model(&s->deck, k, &model, mine);
    if (steps) steps[k] = one == SD_OK ? sd_model_steps(model) : 0;
    if (one == SD_OK)
      ++*usable;
    else
      status = one;
    if (one != SD_OK) merge_messages(messages, mine);
    sd_model_free(model);
    sd_messages_free(mine);
  }
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
    /* during the merge, and after a kill in it, both are there for a moment: the result counts */
    if (file_exists(result))
      status = SWEEP_DONE;
    else if (folder_is_locked(parts))
      status = SWEEP_RUNNING;
    else if (file_exists(failed))
      status = SWEEP_FAILED;
    else if (file_is_folder(parts))
      status = SWEEP_STOPPED;
  }
  free(result);
  free(parts);
  free(failed);
  return status;
}

/* The deck and overrides that a point would be run with are those of the file, or at least say the same. */
static sd_status compare_deck(const sweep *s, size_t point, const provenance *origin, bool *same,
                              sd_messages *messages) {
  const sweep_point *p = &s->deck.points[point];
  const char *rest = origin->deck_overrides;
  *same = strcmp(origin->deck_text, s->deck.deck_text) == 0;
  for (size_t k = 0; *same && k < s->deck.n_overrides + p->n_overrides; k++) {
    const char *text = k < s->deck.n_overrides ? s->deck.overrides[k] : p->overrides[k - s->deck.n_overrides];
    size_t n = strlen(text);
    *same = strncmp(rest, text, n) == 0 && rest[n] == '\n';
    rest += *same ? n + 1 : 0;
  }
  if (*same && !*rest) return SD_OK;
  /* another sweep block, comments, other words for the same: the full deck decides */
  sd_model *model;
  sd_messages *mine = sd_messages_new();
  *same = deck_sweep_model(&s->deck, point, &model, mine) == SD_OK &&
          deck_same(origin->deck_full, model->deck_full);
  if (!*same && model && messages) deck_diff(origin->deck_full, model->deck_full, messages);
  sd_model_free(model);
  sd_messages_free(mine);
  return SD_OK;
}

/* Reads a finished result. */
static sd_status look_at_result(const sweep *s, size_t point, sweep_result *r, sd_messages *messages) {
  char *path = point_path(s, point, ".h5");
  if (!path) return no_memory(messages);
  h5_file *file = NULL;
  provenance origin = {0};
  bool same = false;
  sd_status status = h5_open(path, &file, messages);
  if (status == SD_OK) status = provenance_read(&origin, file, messages);
  if (status == SD_OK) status = compare_deck(s, point, &origin, &same, NULL);
  if (status == SD_OK && !same) r->status = SWEEP_OTHER;
  if (status == SD_OK) {
    status = summary_read(&r->found, file, messages);
    r->has_found = status == SD_OK;
  }
  provenance_free(&origin);
  h5_close(file, NULL);
  free(path);
  return status;
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
  r->message = r->status == SWEEP_FAILED ? read_failure(s, point) : file_path("%s", "");
  if (r->has_found && r->found.energy.scale > 0)
    r->residual = r->found.energy.residual / r->found.energy.scale;
  return status == SD_OK && !r->message ? no_memory(messages) : status;
}

void sweep_result_free(sweep_result *r) {
  summary_free(&r->found);
  free(r->message);
  *r = (sweep_result){0};
}

/* --- running ----------------------------------------------------------------------------------------------- */

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

static sd_status run_session(const sd_model *model, const char *result, const sweep_options *options,
                             sd_messages *messages) {
  session_options how = {.result = result,
                         .threads = options->threads,
                         .force = options->force,
                         .stop = options->stop,
                         .progress = options->progress,
                         .user = options->user};
  session *run;
  sd_status status = session_open(model, &how, &run, messages);
  if (status == SD_OK) {
    status = session_run(run, messages);
    session_close(run);
  }
  return status;
}

/* A finished result stays, unless it belongs to another deck: that is a mistake. */
static sd_status leave_finished(const sweep *s, size_t point, sweep_status *status, sd_messages *messages) {
  sweep_result r;
  sd_status looked = sweep_look(s, point, &r, messages);
  *status = r.status;
  sweep_result_free(&r);
  if (looked != SD_OK || *status != SWEEP_OTHER) return looked;
  return sd_fail(
      messages, SD_ERROR_USER,
      "%s/points/%s.h5 is the result of another deck; --force runs the point again, -o writes elsewhere",
      s->folder, s->deck.points[point].name);
}

sd_status sweep_run(const sweep *s, size_t point, const sweep_options *options, sweep_status *status,
                    sd_messages *messages) {
  *status = sweep_peek(s, point);
  if (*status == SWEEP_DONE && !options->force) return leave_finished(s, point, status, messages);
  if (*status == SWEEP_RUNNING) return SD_OK;
  char *result;
  sd_model *model;
  sd_status ran = sweep_load(s, point, &model, &result, messages);
  if (ran == SD_OK) ran = run_session(model, result, options, messages);
  sd_model_free(model);
  free(result);
  *status = ran == SD_OK ? SWEEP_DONE : ran == SD_INTERRUPTED ? SWEEP_STOPPED : SWEEP_FAILED;
  if (*status != SWEEP_FAILED) {
    sweep_note(s, point, NULL);
  } else if (sweep_peek(s, point) == SWEEP_RUNNING) {
    *status = SWEEP_RUNNING; /* another process was faster */
    ran = SD_OK;
  } else {
    sweep_note_messages(s, point, messages);
  }
  return ran;
}
