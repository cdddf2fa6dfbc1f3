/* text.c: implements text.h. */
#include "base/text.h"

#include <ctype.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include "base/limits.h"
#include "base/memory.h"

size_t text_step(const char *p) {
  const unsigned char *b = (const unsigned char *)p;
  if (b[0] < 0x80) return b[0] >= 0x20 && b[0] != 0x7f;
  size_t n = b[0] >= 0xf0 ? 4 : b[0] >= 0xe0 ? 3 : 2;
  if (b[0] < 0xc2 || b[0] > 0xf4) return 0;
  for (size_t k = 1; k < n; k++)
    if ((b[k] & 0xc0) != 0x80) return 0;
  bool control = b[0] == 0xc2 && b[1] < 0xa0;
  bool overlong = (b[0] == 0xe0 && b[1] < 0xa0) || (b[0] == 0xf0 && b[1] < 0x90);
  bool surrogate = b[0] == 0xed && b[1] >= 0xa0, beyond = b[0] == 0xf4 && b[1] >= 0x90;
  return control || overlong || surrogate || beyond ? 0 : n;
}

static size_t step_or_blank(const char *p) { return *p == '\n' || *p == '\t' ? 1 : text_step(p); }

bool text_printable(const char *text) {
  for (size_t n; *text; text += n)
    if ((n = step_or_blank(text)) == 0) return false;
  return true;
}

char *text_clean(char *text) {
  for (char *p = text; p && *p;) {
    size_t n = step_or_blank(p);
    if (n == 0) *p = '?';
    p += n ? n : 1;
  }
  return text;
}

size_t text_quoted(const char *text, size_t n) {
  if (n <= LIMIT_QUOTE) return n;
  n = LIMIT_QUOTE;
  while (n > 0 && ((unsigned char)text[n] & 0xc0) == 0x80) n--;
  return n;
}

char *text_escaped(const char *text, size_t most) {
  size_t length = strlen(text);
  char *out = memory_new(4 * (length < most ? length : most) + 8, 1), *to = out;
  for (const char *p = text; *p;) {
    size_t n = text_step(p);
    if ((size_t)(p - text) + (n ? n : 1) > most) {
      to += sprintf(to, "...");
      break;
    }
    if (n > 0)
      memcpy(to, p, n);
    else
      sprintf(to, "\\x%02x", (unsigned)(unsigned char)*p);
    to += n ? n : 4;
    p += n ? n : 1;
  }
  *to = 0;
  return out;
}

/* Formats a text and writes it behind the first `length` bytes of `text`, which is reallocated;
 * text may be NULL if length is 0. Returns the new address. */
static char *format_behind(char *text, size_t length, const char *format, va_list args) {
  va_list again;
  va_copy(again, args);
  int n = vsnprintf(NULL, 0, format, args);
  text = memory_grow(text, length + (size_t)(n > 0 ? n : 0) + 1, 1);
  /* vsnprintf fails on a character that it cannot convert; the text then ends here */
  text[length] = 0;
  if (n > 0) vsnprintf(text + length, (size_t)n + 1, format, again);
  va_end(again);
  return text;
}

char *format_text_v(const char *format, va_list args) {
  return format_behind(NULL, 0, format, args);
}

char *format_text(const char *format, ...) {
  va_list args;
  va_start(args, format);
  char *text = format_text_v(format, args);
  va_end(args);
  return text;
}

char *append_text(char *text, const char *format, ...) {
  if (!text) return NULL;
  va_list args;
  va_start(args, format);
  text = format_behind(text, strlen(text), format, args);
  va_end(args);
  return text;
}

bool text_ends(const char *text, const char *ending) {
  size_t n = strlen(text), m = strlen(ending);
  return n > m && strcmp(text + n - m, ending) == 0;
}

const char **text_lines(char *text, size_t *n) {
  size_t lines = 1;
  for (const char *c = text; *c; c++) lines += *c == '\n';
  const char **list = memory_new(lines, sizeof *list);
  *n = 0;
  for (char *rest = NULL, *line = strtok_r(text, "\n", &rest); line;
       line = strtok_r(NULL, "\n", &rest))
    list[(*n)++] = line;
  return list;
}

void text_cell(FILE *out, const char *text) {
  if (!strpbrk(text, ",\"\r\n")) {
    fputs(text, out);
    return;
  }
  fputc('"', out);
  for (const char *c = text; *c; c++) fprintf(out, *c == '"' ? "\"\"" : "%c", *c);
  fputc('"', out);
}

enum { LONGEST_WORD = 63 };

static size_t min(size_t a, size_t b) { return a < b ? a : b; }

/* Returns the number of insertions, deletions, replacements and swaps of adjacent characters that
 * turn a into b (edit distance); SIZE_MAX for words longer than LONGEST_WORD. Upper and lower case
 * count as equal, except in swaps. */
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
  /* Accept "centre" for "center" or "kn" for "k_n", but not a word with little in common. */
  size_t allowed = n <= 2 ? 1 : n <= 5 ? 2 : 3;
  if (distance >= strlen(candidate) || distance > allowed || distance >= g->distance) return;
  g->distance = distance;
  g->best = candidate;
}
