/* sweep_differences.c: the keys in which the finished points of a sweep differ from its deck. */
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/text.h"
#include "io/deck/deck.h"
#include "run/sweep_private.h"

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
  if (strcmp(there, here) == 0) return true;
  if (*there && deck_compare(there, here, any_title, keep, r)) return r->n_differences == 0;
  add(r, "its deck cannot be compared with this one", NULL, NULL);
  return false;
}

void sweep_differ(sweep_result *r, const char *why) { add(r, why, NULL, NULL); }

static char *text_of(const sweep_difference *d) {
  return deck_difference_text(d->path, d->there, d->here);
}

char *sweep_differences_text(const sweep_result *r) {
  enum { TOLD = 4 };
  char *text = memory_text("");
  for (size_t k = 0; k < r->n_differences && k < TOLD; k++) {
    char *one = text_of(&r->differences[k]);
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
  return append_text(text_of(&line->first), "%s (%zu point%s)",
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
