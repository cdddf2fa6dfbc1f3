/* message.c: a growing list of lines; see slipdisk/status.h. */
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include "slipdisk/status.h"

typedef struct line {
  sd_status kind; /* SD_OK: a warning */
  char *text;
} line;

struct sd_messages {
  size_t count, capacity, errors;
  line *lines;
};

sd_messages *sd_messages_new(void) { return calloc(1, sizeof(sd_messages)); }

void sd_messages_clear(sd_messages *m) {
  for (size_t k = 0; m && k < m->count; k++) free(m->lines[k].text);
  if (m) m->count = m->errors = 0;
}

void sd_messages_free(sd_messages *m) {
  if (!m) return;
  sd_messages_clear(m);
  free(m->lines);
  free(m);
}

/* When memory is exhausted the line is lost but the count of errors is not. */
static void add(sd_messages *m, sd_status kind, const char *format, va_list args) {
  if (!m) return;
  if (kind != SD_OK) m->errors++;
  if (m->count == m->capacity) {
    size_t capacity = m->capacity ? 2 * m->capacity : 8;
    line *lines = realloc(m->lines, capacity * sizeof *lines);
    if (!lines) return;
    m->lines = lines;
    m->capacity = capacity;
  }
  va_list again;
  va_copy(again, args);
  int length = vsnprintf(NULL, 0, format, again);
  va_end(again);
  char *text = length < 0 ? NULL : malloc((size_t)length + 1);
  if (!text) return;
  vsnprintf(text, (size_t)length + 1, format, args);
  m->lines[m->count++] = (line){kind, text};
}

sd_status sd_fail(sd_messages *m, sd_status kind, const char *format, ...) {
  va_list args;
  va_start(args, format);
  add(m, kind, format, args);
  va_end(args);
  return kind;
}

void sd_warn(sd_messages *m, const char *format, ...) {
  va_list args;
  va_start(args, format);
  add(m, SD_OK, format, args);
  va_end(args);
}

size_t sd_messages_errors(const sd_messages *m) { return m ? m->errors : 0; }
size_t sd_messages_count(const sd_messages *m) { return m ? m->count : 0; }
const char *sd_messages_text(const sd_messages *m, size_t k) { return m->lines[k].text; }

sd_status sd_messages_status(const sd_messages *m) {
  for (size_t k = 0; m && k < m->count; k++)
    if (m->lines[k].kind != SD_OK) return m->lines[k].kind;
  return SD_OK;
}

void sd_messages_print(const sd_messages *m, FILE *out) {
  for (size_t k = 0; m && k < m->count; k++)
    fprintf(out, "%s: %s\n", m->lines[k].kind == SD_OK ? "warning" : "error", m->lines[k].text);
}
