/* deck_diff.c: compares the texts of two completed decks line by line; see deck_diff.h. Equal lines
 * are skipped; at a difference the nearest pair of lines is searched at which the decks agree
 * again. That suffices, because completed decks list their keys in a fixed order. */
#include "run/deck_diff.h"

#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/text.h"
#include "io/deck/deck.h"
#include "run/sweep_private.h"

enum { WINDOW = 200, MOST = 20 };

static size_t length_of(const char *line) { return strcspn(line, "\n"); }

/* Skips the line with the checkpoint interval, which does not affect the result of a run. */
static const char *past_ignored(const char *line) {
  static const char ignored[] = "checkpoint = ";
  while (strncmp(line, ignored, sizeof ignored - 1) == 0) {
    line += length_of(line);
    if (*line) line++;
  }
  return line;
}

static const char *next_of(const char *line) {
  line += length_of(line);
  return past_ignored(*line ? line + 1 : line);
}

/* Returns the length of the line without the remark that its value is the default, since a deck may
 * also give that value explicitly. */
static size_t said(const char *line) {
  static const char remark[] = "  # default";
  size_t n = length_of(line), tail = sizeof remark - 1;
  return n >= tail && strncmp(line + n - tail, remark, tail) == 0 ? n - tail : n;
}

/* Returns true if two lines are equal apart from the remark that a value is the default; false at
 * the end of a text. */
static bool same(const char *a, const char *b) {
  size_t n = said(a);
  return *a && *b && n == said(b) && strncmp(a, b, n) == 0;
}

bool deck_same(const char *before, const char *now) {
  before = past_ignored(before);
  now = past_ignored(now);
  while (same(before, now)) {
    before = next_of(before);
    now = next_of(now);
  }
  return !*before && !*now;
}

/* Finds how many lines to skip in a and in b until the two texts agree again, with the smallest
 * possible sum of both numbers. */
static void resynchronise(const char *a, const char *b, int *skip_a, int *skip_b) {
  *skip_a = *skip_b = WINDOW;
  const char *at_a = a;
  for (int i = 0; i < WINDOW && i < *skip_a + *skip_b && *at_a; i++, at_a = next_of(at_a)) {
    const char *at_b = b;
    for (int j = 0; i + j < *skip_a + *skip_b && j < WINDOW && *at_b; j++, at_b = next_of(at_b))
      if (same(at_a, at_b)) {
        *skip_a = i;
        *skip_b = j;
        break;
      }
  }
}

/* Adds an error message for each of `count` lines, until MOST messages were added. Returns the line
 * after them. */
static const char *tell(const char *line, int count, const char *whose, int *told,
                        sd_messages *messages) {
  for (int k = 0; k < count && *line; k++, line = next_of(line)) {
    size_t blank = strspn(line, " \t");
    if ((*told)++ < MOST)
      sd_fail(messages, SD_ERROR_USER, "%s: %.*s", whose,
              (int)(length_of(line) - (blank < length_of(line) ? blank : 0)),
              line + (blank < length_of(line) ? blank : 0));
  }
  return line;
}

void deck_diff(const char *before, const char *now, sd_messages *messages) {
  int told = 0;
  before = past_ignored(before);
  now = past_ignored(now);
  while (*before || *now) {
    if (same(before, now)) {
      before = next_of(before);
      now = next_of(now);
      continue;
    }
    int skip_before, skip_now;
    resynchronise(before, now, &skip_before, &skip_now);
    before = tell(before, skip_before, "it has", &told, messages);
    now = tell(now, skip_now, "this deck has", &told, messages);
  }
  if (told > MOST) sd_fail(messages, SD_ERROR_USER, "... and %d more lines", told - MOST);
}

/* --- Differences between the keys of two decks, for points of a sweep ------------------------- */

/* Largest number of differences stored for one point of a sweep, and for all points together. */
enum { MOST_KEPT = 20, MOST_TOLD = 20 };

/* Adds a difference of key `path`: its values there and here; NULL: that deck does not have the
 * key. */
static void add(sweep_result *r, const char *path, const char *there, const char *here) {
  r->differences = memory_grow(r->differences, r->n_differences + 1, sizeof *r->differences);
  r->differences[r->n_differences++] =
      (sweep_difference){memory_text(path), memory_text(there), memory_text(here)};
}

/* --- One point -------------------------------------------------------------------------------- */

static void keep(void *user, const char *path, const char *there, const char *here) {
  sweep_result *r = user;
  if (r->n_differences < MOST_KEPT) add(r, path, there, here);
}

bool sweep_compare(sweep_result *r, const char *there, const char *here, bool any_title) {
  if (deck_same(there, here)) return true;
  if (*there && deck_compare(there, here, any_title, keep, r)) return r->n_differences == 0;
  add(r, "its deck cannot be compared with this one", NULL, NULL);
  return false;
}

void sweep_differ(sweep_result *r, const char *why) { add(r, why, NULL, NULL); }

/* Returns a difference as text, such as "gravity.tilt: 0.1 there, 0.2 here"; the caller frees
 * it. */
static char *words(const sweep_difference *d) {
  if (!d->there && !d->here) return memory_text(d->path);
  if (!d->there) return format_text("%s: not there, %s here", d->path, d->here);
  if (!d->here) return format_text("%s: %s there, not here", d->path, d->there);
  return format_text("%s: %s there, %s here", d->path, d->there, d->here);
}

char *sweep_differences_text(const sweep_result *r) {
  enum { TOLD = 4 };
  char *text = memory_text("");
  for (size_t k = 0; k < r->n_differences && k < TOLD; k++) {
    char *one = words(&r->differences[k]);
    text = append_text(text, "%s%s", k ? "; " : "", one);
    free(one);
  }
  return r->n_differences <= TOLD ? text
                                  : append_text(text, "; and %zu more", r->n_differences - TOLD);
}

void sweep_differences_free(sweep_result *r) {
  for (size_t k = 0; k < r->n_differences; k++) {
    free(r->differences[k].path);
    free(r->differences[k].there);
    free(r->differences[k].here);
  }
  free(r->differences);
  r->differences = NULL;
  r->n_differences = 0;
}

/* --- Many points ------------------------------------------------------------------------------ */

static bool same_text(const char *a, const char *b) { return a && b ? strcmp(a, b) == 0 : a == b; }

/* Counts a difference of a point in the tally: in the line of this difference, or in a new line,
 * which takes over the contents of d. */
static void count(sweep_tally *t, sweep_difference *d) {
  for (size_t k = 0; k < t->n; k++) {
    sweep_tally_line *line = &t->list[k];
    if (strcmp(line->first.path, d->path) != 0) continue;
    line->points++;
    line->varies = line->varies || !same_text(line->first.there, d->there) ||
                   !same_text(line->first.here, d->here);
    return;
  }
  if (t->n == MOST_TOLD) {
    t->more++;
    return;
  }
  t->list = memory_grow(t->list, t->n + 1, sizeof *t->list);
  t->list[t->n++] = (sweep_tally_line){.first = *d, .points = 1};
  *d = (sweep_difference){0}; /* the tally owns the strings now */
}

void sweep_tally_add(sweep_tally *t, sweep_result *r) {
  if (r->status != SWEEP_OTHER) return;
  t->points++;
  for (size_t k = 0; k < r->n_differences; k++) count(t, &r->differences[k]);
  sweep_differences_free(r);
}

char *sweep_tally_text(const sweep_tally *t, size_t k) {
  const sweep_tally_line *line = &t->list[k];
  return append_text(words(&line->first), "%s (%zu point%s)",
                     line->varies ? ", and other values" : "", line->points,
                     line->points == 1 ? "" : "s");
}

void sweep_tally_free(sweep_tally *t) {
  for (size_t k = 0; k < t->n; k++) {
    free(t->list[k].first.path);
    free(t->list[k].first.there);
    free(t->list[k].first.here);
  }
  free(t->list);
  *t = (sweep_tally){0};
}
