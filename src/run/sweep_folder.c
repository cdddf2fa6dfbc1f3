/* sweep_folder.c: what else lies in a sweep's folder, and when it is a reason to do nothing; see sweep.h. */
#include <assert.h>
#include <dirent.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/text.h"
#include "run/sweep_private.h"

/* Points in the order of their names. */
typedef struct named {
  const char *name;
  size_t point;
} named;

static int by_name(const void *a, const void *b) {
  const named *p = a, *q = b;
  return strcmp(p->name, q->name);
}

static bool take_ending(char *name, const char *ending) {
  size_t n = strlen(name), m = strlen(ending);
  if (n <= m || strcmp(name + n - m, ending) != 0) return false;
  name[n - m] = 0;
  return true;
}

/* An entry of the folder of points; its name is cut. */
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
  DIR *folder = opendir(path); /* NULL: nothing is there */
  for (size_t k = 0; k < n; k++) names[k] = (named){s->deck.points[k].name, k};
  qsort(names, n, sizeof *names, by_name);
  for (struct dirent *one; folder && (one = readdir(folder));) sort_in(out, one->d_name, names, n);
  if (folder) closedir(folder);
  free(names);
  free(path);
}

void sweep_contents_free(sweep_contents *c) {
  free(c->has);
  free(c->example);
  *c = (sweep_contents){0};
}

/* "9 results, 1 unfinished run" */
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
  char *text = format_text("%s has %s of points that this sweep does not have, such as %s", s->folder, counts,
                           c->example);
  free(counts);
  return text;
}

sd_status sweep_refuse_strangers(const sweep *s, const sweep_contents *c, const char *instead,
                                 sd_messages *messages) {
  if (c->known > 0 || c->results + c->parts == 0) return SD_OK;
  char *text = sweep_strangers_text(s, c);
  assert(text);
  sd_fail(messages, SD_ERROR_USER,
          "%s, and nothing of its own: %s; -o writes elsewhere, --mix lets them stay there", text, instead);
  free(text);
  return SD_ERROR_USER;
}

sd_status sweep_refuse_others(const sweep *s, const sweep_tally *t, const char *instead,
                              sd_messages *messages) {
  if (t->points == 0) return SD_OK;
  sd_fail(messages, SD_ERROR_USER,
          "%s%zu point%s in %s %s of another deck: %s. Is a -D missing? -o writes elsewhere, --mix leaves "
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
