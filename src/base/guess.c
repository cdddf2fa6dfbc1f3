/* guess.c: see guess.h. */
#include "base/guess.h"

#include <ctype.h>
#include <stdint.h>
#include <string.h>

enum { LONGEST_WORD = 63 };

static size_t min(size_t a, size_t b) { return a < b ? a : b; }

/* Insertions, deletions, replacements and swaps of neighbours. */
static size_t edit_distance(const char *a, const char *b) {
  size_t m = strlen(a), n = strlen(b), row[3][LONGEST_WORD + 1];
  if (m > LONGEST_WORD || n > LONGEST_WORD) return SIZE_MAX;
  for (size_t j = 0; j <= n; j++) row[0][j] = j;
  for (size_t i = 1; i <= m; i++) {
    size_t *now = row[i % 3], *up = row[(i + 2) % 3], *up2 = row[(i + 1) % 3];
    now[0] = i;
    for (size_t j = 1; j <= n; j++) {
      size_t same = tolower((unsigned char)a[i - 1]) == tolower((unsigned char)b[j - 1]) ? 0 : 1;
      now[j] = min(min(up[j] + 1, now[j - 1] + 1), up[j - 1] + same);
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
        now[j] = min(now[j], up2[j - 2] + 1);
    }
  }
  return row[m % 3][n];
}

guess guess_start(const char *word) { return (guess){word, NULL, SIZE_MAX}; }

void guess_add(guess *g, const char *candidate) {
  if (!candidate) return;
  size_t distance = edit_distance(g->word, candidate), n = strlen(g->word);
  /* "centre" for "center", "kn" for "k_n"; but not any word for any other */
  size_t allowed = n <= 2 ? 1 : n <= 5 ? 2 : 3;
  if (distance >= strlen(candidate) || distance > allowed || distance >= g->distance) return;
  g->distance = distance;
  g->best = candidate;
}
