/* message.c: a growing list of lines; see slipdisk/status.h. */
#include <assert.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "base/limits.h"
#include "base/text.h"
#include "slipdisk/status.h"

typedef struct line {
  sd_status kind; /* SD_OK: a warning */
  char *text;
} line;

struct sd_messages {
  size_t count, capacity, errors, warnings;
  size_t more; /* lines beyond those that are kept */
  line *lines;
  line first[8]; /* room that is there from the start */
};

/* Stands for lines for which there is no memory. */
static char lost[] = "no memory: a message was lost";

sd_messages *sd_messages_new(void) {
  sd_messages *m = calloc(1, sizeof *m);
  if (!m) return NULL;
  m->lines = m->first;
  m->capacity = sizeof m->first / sizeof *m->first;
  return m;
}

static void free_text(line *l) {
  if (l->text != lost) free(l->text);
}

void sd_messages_clear(sd_messages *m) {
  for (size_t k = 0; m && k < m->count; k++) free_text(&m->lines[k]);
  if (m) m->count = m->errors = m->warnings = m->more = 0;
}

void sd_messages_free(sd_messages *m) {
  if (!m) return;
  sd_messages_clear(m);
  if (m->lines != m->first) free(m->lines);
  free(m);
}

static bool grow(sd_messages *m) {
  size_t capacity = 2 * m->capacity;
  line *lines = malloc(capacity * sizeof *lines);
  if (!lines) return false;
  memcpy(lines, m->lines, m->count * sizeof *lines);
  if (m->lines != m->first) free(m->lines);
  m->lines = lines;
  m->capacity = capacity;
  return true;
}

/* Control characters are shown as \xHH, so that no text from a file reaches the terminal as a command. */
static char *words(const char *format, va_list args) {
  char *text = malloc(LIMIT_LINE + 2);
  int length = text ? vsnprintf(text, LIMIT_LINE + 2, format, args) : -1;
  char *shown = length < 0 ? NULL : text_escaped(text, LIMIT_LINE);
  free(text);
  return shown;
}

/* When memory is exhausted the text is lost, but neither the count of errors nor their kinds are. */
static void add(sd_messages *m, sd_status kind, const char *format, va_list args) {
  if (!m) return;
  size_t alike = kind == SD_OK ? m->warnings++ : m->errors++;
  if (alike >= LIMIT_MESSAGES) {
    m->more++;
    return;
  }
  if (m->count == m->capacity && !grow(m)) {
    line *last = &m->lines[m->count - 1];
    free_text(last);
    *last = (line){kind == SD_OK ? last->kind : kind, lost};
    return;
  }
  char *text = words(format, args);
  assert(m->count < m->capacity);
  m->lines[m->count++] = (line){kind, text ? text : lost};
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
const char *sd_messages_text(const sd_messages *m, size_t k) {
  assert(k < m->count);
  return m->lines[k].text;
}

sd_status sd_messages_kind(const sd_messages *m, size_t k) {
  assert(k < m->count);
  return m->lines[k].kind;
}

sd_status sd_messages_status(const sd_messages *m) {
  for (size_t k = 0; m && k < m->count; k++)
    if (m->lines[k].kind != SD_OK) return m->lines[k].kind;
  return SD_OK;
}

void sd_messages_print(const sd_messages *m, FILE *out) {
  for (size_t k = 0; m && k < m->count; k++)
    fprintf(out, "%s: %s\n", m->lines[k].kind == SD_OK ? "warning" : "error", m->lines[k].text);
  if (m && m->more > 0) fprintf(out, "... and %zu more\n", m->more);
}

void sd_free(void *memory) { free(memory); }

const char *sd_version(void) { return SD_VERSION; }
