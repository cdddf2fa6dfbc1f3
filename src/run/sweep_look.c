/* sweep_look.c: what the folder knows of a point; see sweep.h. */
#include <stdlib.h>
#include <string.h>

#include "base/limits.h"
#include "base/memory.h"
#include "base/text.h"
#include "io/results/checkpoint.h"
#include "io/store/file.h"
#include "io/store/folder.h"
#include "run/sweep_private.h"
#include "slipdisk/deck.h"

const char *const sweep_status_names[SWEEP_STATUSES] = {"waiting", "running", "stopped",   "done",
                                                        "failed",  "damaged", "other deck"};

char *sweep_point_path(const sweep *s, size_t point, const char *ending) {
  return format_text("%s/points/%s%s", s->folder, s->deck.points[point].name, ending);
}

sweep_status sweep_peek(const sweep *s, size_t point) {
  char *result = sweep_point_path(s, point, ".h5"),
       *parts = sweep_point_path(s, point, ".h5.parts"),
       *failed = sweep_point_path(s, point, ".failed");
  sweep_status status = SWEEP_WAITING;
  /* A result without parts is finished. Both are there at the end of the merge, after a kill
   * there (the parts have to go), and when a finished point is run again. The parts vanish last,
   * so they are looked for first. */
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

/* Does what lies there belong to another deck than what the point would be run with? Then r says so. */
static void compare_decks(const sweep *s, size_t point, const provenance *origin, bool finished,
                          sweep_result *r) {
  /* what stands in other files is not in the text; the rest of the sweep, comments and other words for the same
   * are: there the full deck decides */
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

/* --- results and checkpoints -------------------------------------------------------------------------------- */

/* Of a result that is finished, and this deck's. */
static void renew(const sweep *s, size_t point, const h5_file *file, sweep_result *r) {
  sd_model *model = NULL;
  sd_messages *mine = sd_messages_new();
  if (r->found.n_rotations > 0 && deck_sweep_model(&s->deck, point, &model, mine) == SD_OK)
    summary_renew(&r->found, model, file);
  sd_model_free(model);
  sd_messages_free(mine);
}

static void tell_doubts(sweep_result *r) {
  for (size_t k = 0; k < DOUBT_KINDS; k++)
    if (r->found.doubts[k].text) r->doubts |= 1u << k;
  if (r->doubts) r->message = summary_doubts_text(&r->found);
}

/* Reads a finished result. */
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

/* Reads the newest checkpoint; without one there is nothing to tell, and it may vanish while we look. */
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

/* Its lines, joined by "; ". */
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

void sweep_look(const sweep *s, size_t point, sweep_result *r) {
  *r = (sweep_result){.status = sweep_peek(s, point)};
  if (r->status == SWEEP_DONE) look_at_result(s, point, r);
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
