/* message.c: implements the list of messages of slipdisk/status.h. */
#include <assert.h>
#include <stdarg.h>
#include <stdlib.h>

#include "base/limits.h"
#include "base/memory.h"
#include "base/text.h"
#include "slipdisk/status.h"

typedef struct line {
  sd_status kind; /* status of an error; SD_OK: a warning */
  char *text;
} line;

struct sd_messages {
  size_t count, capacity, errors, warnings;
  size_t more; /* number of messages that were counted but not kept */
  line *lines;
};

sd_messages *sd_messages_new(void) { return memory_new(1, sizeof(sd_messages)); }

void sd_messages_clear(sd_messages *m) {
  for (size_t k = 0; m && k < m->count; k++) free(m->lines[k].text);
  if (m) m->count = m->errors = m->warnings = m->more = 0;
}

void sd_messages_free(sd_messages *m) {
  if (!m) return;
  sd_messages_clear(m);
  free(m->lines);
  free(m);
}

/* Formats a message. Control characters become \xHH, so that a text from a file cannot send
 * commands to the terminal. */
static char *words(const char *format, va_list args) {
  char text[LIMIT_LINE + 2];
  return vsnprintf(text, sizeof text, format, args) < 0 ? memory_text("")
                                                        : text_escaped(text, LIMIT_LINE);
}

static void add(sd_messages *m, sd_status kind, const char *format, va_list args) {
  if (!m) return;
  size_t alike = kind == SD_OK ? m->warnings++ : m->errors++;
  if (alike >= LIMIT_MESSAGES) {
    m->more++;
    return;
  }
  if (m->count == m->capacity) {
    m->capacity = 2 * m->capacity + 8;
    m->lines = memory_grow(m->lines, m->capacity, sizeof *m->lines);
  }
  m->lines[m->count++] = (line){kind, words(format, args)};
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
