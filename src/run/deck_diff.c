/* deck_diff.c: see deck_diff.h. Lines are taken off while they agree; where they do not, the nearest place at
 * which they agree again is looked for. Full decks list their keys in a fixed order, so that is enough. */
#include "run/deck_diff.h"

#include <string.h>

enum { WINDOW = 200, MOST = 20 };

static size_t length_of(const char *line) { return strcspn(line, "\n"); }

/* How often a run is saved is not part of what is run. */
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

/* Without the remark that a value is the default: it makes no difference who wrote it. */
static size_t said(const char *line) {
  static const char remark[] = "  # default";
  size_t n = length_of(line), tail = sizeof remark - 1;
  return n >= tail && strncmp(line + n - tail, remark, tail) == 0 ? n - tail : n;
}

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

/* Lines skipped in a and in b until they agree again; the sum is the least. */
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
