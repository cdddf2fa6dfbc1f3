/* place.c: see app.h. */
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/text.h"
#include "app/app.h"
#include "io/store/file.h"
#include "io/store/folder.h"

static bool ends_with(const char *text, size_t length, const char *tail) {
  size_t n = strlen(tail);
  return length > n && strncmp(text + length - n, tail, n) == 0;
}

sd_status place_find(place *p, const char *name, sd_messages *messages) {
  *p = (place){0};
  if (text_ends(name, ".cfg") && file_exists(name))
    return sd_fail(messages, SD_ERROR_USER, "%s is a deck; slipdisk run %s makes a result of it", name, name);
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
                   "%s is a folder: name a result, its folder RESULT.parts or a checkpoint in it", p->result);
  if (file_exists(p->result) || file_is_folder(p->folder)) return SD_OK;
  return sd_fail(messages, SD_ERROR_USER, "there is neither a result %s nor an unfinished run %s", p->result,
                 p->folder);
}

void place_free(place *p) {
  free(p->result);
  free(p->folder);
  free(p->checkpoint);
  *p = (place){0};
}

sd_status place_open_checkpoint(const place *p, h5_file **out, char **path, sd_messages *messages) {
  *out = NULL;
  *path = NULL;
  if (p->checkpoint) {
    *path = memory_text(p->checkpoint);
    return h5_open_sealed(-1, *path, out, NULL, messages);
  }
  /* A running process may remove a checkpoint between the listing and the opening: look again then. */
  for (int attempt = 0; attempt < 3; attempt++) {
    int64_t *steps;
    size_t n;
    sd_status status = folder_checkpoints(p->folder, &steps, &n, messages);
    sd_messages *why = sd_messages_new();
    for (size_t k = 0; status == SD_OK && k < n && !*path; k++) {
      char *candidate = folder_checkpoint(p->folder, steps[k]);
      /* one that vanished is no reason to step back */
      bool there = file_exists(candidate);
      if (there && h5_open_sealed(-1, candidate, out, NULL, why) == SD_OK)
        *path = candidate;
      else
        free(candidate);
    }
    for (size_t k = 0; *path && k < sd_messages_count(why); k++)
      sd_warn(messages, "%s; an older checkpoint is read: %s", sd_messages_text(why, k), *path);
    for (size_t k = 0; !*path && attempt == 2 && k < sd_messages_count(why); k++)
      sd_fail(messages, SD_ERROR_IO, "%s", sd_messages_text(why, k));
    sd_messages_free(why);
    free(steps);
    if (status != SD_OK || *path) return status;
  }
  return sd_fail(messages, SD_ERROR_IO, "%s has no checkpoint that can be read", p->folder);
}
