/* stored.c: finds and opens the files of a run by the name that the user gives; see stored.h. */
#include "run/stored.h"

#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/text.h"
#include "io/results/checkpoint.h"
#include "io/store/file.h"
#include "io/store/folder.h"
#include "model/model.h"
#include "slipdisk/deck.h"

static bool ends_with(const char *text, size_t length, const char *tail) {
  size_t n = strlen(tail);
  return length > n && strncmp(text + length - n, tail, n) == 0;
}

sd_status place_refuse_deck(const char *name, sd_messages *messages) {
  if (h5_kind_of(name) != FILE_DECK || !file_exists(name)) return SD_OK;
  return sd_fail(messages, SD_ERROR_USER, "%s is a deck; slipdisk run %s makes a result of it",
                 name, name);
}

sd_status place_find(place *p, const char *name, sd_messages *messages) {
  *p = (place){0};
  sd_status status = place_refuse_deck(name, messages);
  if (status != SD_OK) return status;
  size_t length = strlen(name), tail = strlen(".parts");
  while (length > 1 && name[length - 1] == '/') length--;
  const char *slash = NULL;
  for (size_t k = 0; k < length; k++)
    if (name[k] == '/') slash = name + k;
  if (ends_with(name, length, ".parts")) {
    p->result = format_text("%.*s", (int)(length - tail), name);
  } else if (slash && ends_with(name, (size_t)(slash - name), ".parts")) {
    p->result = format_text("%.*s", (int)((size_t)(slash - name) - tail), name);
    p->checkpoint = memory_text(name);
  } else {
    p->result = format_text("%.*s", (int)length, name);
  }
  p->folder = format_text("%s.parts", p->result);
  if (file_is_folder(p->result) && !file_is_folder(p->folder))
    return sd_fail(messages, SD_ERROR_USER,
                   "%s is a folder: name a result, its folder RESULT.parts or a checkpoint in it",
                   p->result);
  if (file_exists(p->result) || file_is_folder(p->folder)) return SD_OK;
  char *hint = file_hint(p->result);
  sd_fail(messages, SD_ERROR_USER, "there is neither a result %s nor an unfinished run %s%s",
          p->result, p->folder, hint);
  free(hint);
  return SD_ERROR_USER;
}

void place_free(place *p) {
  free(p->result);
  free(p->folder);
  free(p->checkpoint);
  *p = (place){0};
}

sd_status place_check_finished(const place *p, sd_messages *messages) {
  h5_file *file = NULL;
  sd_status status = h5_open(p->result, &file, messages);
  if (status == SD_OK) status = checkpoint_check_origin(file, p->result, messages);
  if (status == SD_OK && checkpoint_get_parts(file) >= 0)
    status = sd_fail(messages, SD_ERROR_USER,
                     "%s is a checkpoint away from its folder RESULT.parts: a run goes on only "
                     "with the parts that are there",
                     p->result);
  h5_close(file, NULL);
  return status;
}

sd_status place_open_checkpoint(const place *p, h5_file **out, char **path, sd_messages *messages) {
  *out = NULL;
  *path = NULL;
  if (p->checkpoint) {
    *path = memory_text(p->checkpoint);
    return h5_open_sealed(-1, *path, out, NULL, messages);
  }
  /* Another process that continues the run may remove a checkpoint after it was listed and before
   * it is opened; then list the folder again. */
  for (int attempt = 0; attempt < 3; attempt++) {
    int64_t *steps;
    size_t n;
    sd_status status = folder_checkpoints(p->folder, &steps, &n, messages);
    sd_messages *why = sd_messages_new();
    for (size_t k = 0; status == SD_OK && k < n && !*path; k++) {
      char *candidate = folder_checkpoint(p->folder, steps[k]);
      /* Skip a checkpoint without a warning if it has vanished since it was listed. */
      bool there = file_exists(candidate);
      if (there && h5_open_sealed(-1, candidate, out, NULL, why) == SD_OK)
        *path = candidate;
      else
        free(candidate);
    }
    for (size_t k = 0; *path && k < sd_messages_count(why); k++)
      sd_warn(messages, "%s; an older checkpoint is read: %s", sd_messages_text(why, k), *path);
    if (!*path && attempt == 2) messages_append(messages, SD_ERROR_IO, why);
    sd_messages_free(why);
    free(steps);
    if (status != SD_OK || *path) return status;
  }
  return sd_fail(messages, SD_ERROR_IO, "%s has no checkpoint that can be read", p->folder);
}

void stored_tell_missing(const place *p, int64_t parts, sd_messages *messages) {
  for (int64_t k = 1; k <= parts; k++) {
    char *path = folder_part(p->folder, k);
    if (!file_exists(path))
      sd_warn(messages, "%s is missing: the run cannot go on from this checkpoint", path);
    free(path);
  }
}

/* Opens the frames of the checkpoint `base` and of the part files 1 ... `parts` of the run. Part
 * files that are missing are left out with a warning. */
static sd_status open_parts(frames *f, const place *p, const char *base, int64_t parts,
                            sd_messages *messages) {
  char **list = memory_new(parts > 0 ? (size_t)parts : 0, sizeof *list);
  size_t n = 0;
  for (int64_t k = 1; k <= parts; k++) {
    char *path = folder_part(p->folder, k);
    if (file_exists(path)) {
      list[n++] = path;
    } else {
      sd_warn(messages, "%s is missing: its frames are left out", path);
      free(path);
    }
  }
  const sd_status status =
      frames_open(f, base, n, (const char *const *)list, sd_deck_load_text, messages);
  for (size_t k = 0; k < n; k++) free(list[k]);
  free(list);
  return status;
}

/* Opens the frames of an unfinished run. *alone: true if the user named a single part file; then
 * its frames are all. */
static sd_status open_unfinished(frames *f, place *p, bool *alone, sd_messages *messages) {
  char *part = NULL, *base = NULL;
  if (p->checkpoint && frames_is_part(p->checkpoint)) {
    part = p->checkpoint;
    /* Read the data that do not change during the run from the newest checkpoint */
    p->checkpoint = NULL;
  }
  bool named = p->checkpoint;
  h5_file *file = NULL;
  sd_status status = place_open_checkpoint(p, &file, &base, messages);
  int64_t parts = status == SD_OK ? checkpoint_get_parts(file) : 0;
  h5_close(file, NULL);
  *alone = part;
  if (status == SD_OK && part)
    status = frames_open(f, base, 1, (const char *const *)&part, sd_deck_load_text, messages);
  else if (status == SD_OK)
    status = open_parts(f, p, base, named ? 0 : parts, messages);
  free(part);
  free(base);
  return status;
}

sd_status stored_open(frames *f, const char *name, bool *alone, sd_messages *messages) {
  place p;
  *alone = false;
  sd_status status = place_find(&p, name, messages);
  const char *result = p.result;
  if (status == SD_OK && file_exists(result) && !p.checkpoint && !file_is_folder(name))
    status = frames_open(f, result, 1, &result, sd_deck_load_text, messages);
  else if (status == SD_OK)
    status = open_unfinished(f, &p, alone, messages);
  place_free(&p);
  return status;
}

sd_status stored_count(const frames *f, bool alone, size_t *count, sd_messages *messages) {
  frame_entry newest = {.step = -1};
  sd_status status = f->n > 0 ? frames_entry(f, f->n - 1, &newest, messages) : SD_OK;
  *count = f->n + !(alone || newest.step == f->state_step);
  return status;
}
