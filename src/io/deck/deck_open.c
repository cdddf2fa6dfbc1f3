/* deck_open.c: reads the text of a deck and makes its tree. See deck_tree.h. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/comm.h"
#include "base/limits.h"
#include "base/memory.h"
#include "io/deck/deck.h"
#include "io/deck/deck_tree.h"
#include "io/store/file.h"

/* Reads the standard input into *all, at most `most` + 1 bytes, and adds a final zero byte; *n:
 * number of bytes. */
static void read_input(size_t most, char **all, size_t *n) {
  size_t capacity = 0;
  for (int c = 0; c != EOF && *n <= most;) {
    if (*n + 1 >= capacity) *all = memory_grow(*all, capacity = 2 * capacity + LIMIT_LINE, 1);
    if ((c = getchar()) != EOF) (*all)[(*n)++] = (char)c;
    (*all)[*n] = 0;
  }
}

/* Returns a copy of the text on the standard input, which is read only once because a command may
 * load its deck several times. After an error returns NULL and writes the reason to `trouble`. */
static char *standard_input(char trouble[FILE_TROUBLE]) {
  static char *all;
  static size_t n;
  const size_t most = (size_t)LIMIT_DECK * LIMIT_MIB;
  if (!all) read_input(most, &all, &n);
  if (n > most)
    snprintf(trouble, FILE_TROUBLE, "it has more than %d MiB", LIMIT_DECK);
  else if (strlen(all) < n)
    snprintf(trouble, FILE_TROUBLE, "not a text (it holds a zero byte)");
  return n <= most && strlen(all) == n ? memory_text(all) : NULL;
}

char *deck_file_text(const char *path, sd_messages *messages, sd_status *status) {
  char *text, trouble[FILE_TROUBLE] = "no memory";
  if (strcmp(path, "-") == 0) {
    text = standard_input(trouble);
    *status = text ? SD_OK : SD_ERROR_USER;
    if (!text) sd_fail(messages, *status, "the standard input cannot be read: %s", trouble);
    return text;
  }
  *status = file_text(path, (uint64_t)LIMIT_DECK * LIMIT_MIB, &text, trouble);
  if (!text) {
    char *hint = file_hint(path);
    sd_fail(messages, *status, "%s: cannot be read: %s%s", path, trouble, hint);
    free(hint);
  }
  return text;
}

const char *deck_source(const char *path) { return strcmp(path, "-") == 0 ? "stdin" : path; }

/* --- tree ------------------------------------------------------------------------------------- */

/* Arguments of deck_open: text, settings, and the function that uses the tree. */
typedef struct task {
  const char *text;
  size_t n_settings;
  const deck_setting *settings;
  deck_use *use;
  void *user;
} task;

static sd_status open_and_use(deck *d, const task *t) {
  deck_text scanned = deck_scan(d, t->text, (deck_place){d->path, 1}, false);
  if (!scanned.broken) d->root = deck_parse(d, &scanned);
  if (!d->root) return SD_ERROR_USER;
  d->text = scanned.raw ? scanned.raw : t->text;
  for (size_t k = 0; k < t->n_settings; k++) deck_override(d, &t->settings[k]);
  return deck_check_files(d, d->root) ? t->use(d, t->user) : SD_ERROR_USER;
}

static sd_status no_memory(const deck *d, sd_messages *messages) {
  /* End the whole job, since the other ranks would wait forever */
  if (d->comm) comm_fail(d->comm, "out of memory for the deck");
  return sd_fail(messages, SD_ERROR_IO, "%s: out of memory", d->path);
}

sd_status deck_open(const char *text, const char *path, size_t n_settings,
                    const deck_setting *settings, deck_use *use, void *user,
                    sd_messages *messages) {
  deck *d = memory_new(1, sizeof *d);
  d->path = path;
  d->messages = messages;
  task t = {text, n_settings, settings, use, user};
  sd_status status;
  if (setjmp(d->out_of_memory) == 0)
    status = open_and_use(d, &t);
  else
    status = d->whole && *d->whole ? SD_ERROR_USER
             : d->lacks_told       ? SD_ERROR_IO
                                   : no_memory(d, messages);
  deck_report_rest(d);
  if (status != SD_OK) sd_model_free(d->model);
  deck_parse_free(d);
  deck_memory_free(d);
  sd_messages_free(d->found);
  free(d);
  return status;
}
