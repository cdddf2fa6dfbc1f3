/* text.c: see text.h. */
#include "base/text.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/limits.h"
#include "base/shortage.h"

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
  char *out = malloc(4 * (length < most ? length : most) + 8), *to = out;
  if (!out) shortage_note();
  if (!out) return NULL;
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

char *format_text(const char *format, ...) {
  va_list args;
  va_start(args, format);
  int n = vsnprintf(NULL, 0, format, args);
  va_end(args);
  char *text = n < 0 ? NULL : malloc((size_t)n + 1);
  if (!text) shortage_note();
  if (!text) return NULL;
  va_start(args, format);
  vsnprintf(text, (size_t)n + 1, format, args);
  va_end(args);
  return text;
}

char *append_text(char *text, const char *format, ...) {
  if (!text) return NULL;
  va_list args;
  va_start(args, format);
  int n = vsnprintf(NULL, 0, format, args);
  va_end(args);
  size_t length = strlen(text);
  char *longer = n < 0 ? NULL : realloc(text, length + (size_t)n + 1);
  if (!longer) {
    shortage_note();
    free(text);
    return NULL;
  }
  va_start(args, format);
  vsnprintf(longer + length, (size_t)n + 1, format, args);
  va_end(args);
  return longer;
}

bool text_ends(const char *text, const char *ending) {
  size_t n = strlen(text), m = strlen(ending);
  return n > m && strcmp(text + n - m, ending) == 0;
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
