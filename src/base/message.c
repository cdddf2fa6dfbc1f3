/* message.c: implements the list of messages of slipdisk/status.h and message.h. */
#include "base/message.h"

#include <assert.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include "base/limits.h"
#include "base/memory.h"
#include "base/text.h"

struct sd_messages {
  size_t count, capacity, errors, warnings;
  size_t more;  /* number of messages that were counted but not kept */
  bool starved; /* true: NO_MEMORY stands behind the list */
  message *list;
};

static char no_memory[] = "no memory";
static const message NO_MEMORY = {.kind = SD_ERROR_IO, .wrong = no_memory, .text = no_memory};

sd_messages *sd_messages_new(void) { return memory_new(1, sizeof(sd_messages)); }

static void subject_free(subject about) {
  free(about.place);
  free(about.name);
  free(about.value);
}

void sd_messages_clear(sd_messages *m) {
  for (size_t k = 0; m && k < m->count; k++) {
    subject_free(m->list[k].about);
    free(m->list[k].wrong);
    free(m->list[k].text);
  }
  if (!m) return;
  m->count = m->errors = m->warnings = m->more = 0;
  m->starved = false;
}

void sd_messages_free(sd_messages *m) {
  if (!m) return;
  sd_messages_clear(m);
  free(m->list);
  free(m);
}

subject about_path(const char *format, ...) {
  va_list args;
  va_start(args, format);
  const subject about = {.kind = SUBJECT_PATH, .name = format_text_v(format, args)};
  va_end(args);
  return about;
}

subject about_value(subject about, const char *format, ...) {
  va_list args;
  va_start(args, format);
  about.value = format_text_v(format, args);
  va_end(args);
  return about;
}

/* Control characters become \xHH in the text, so that a text from a file cannot send commands to
 * the terminal. */
static void add(sd_messages *m, sd_status kind, subject about, const char *format, va_list args) {
  if (m && (kind == SD_OK ? m->warnings++ : m->errors++) < LIMIT_MESSAGES) {
    if (m->count == m->capacity) {
      m->list = memory_grow(m->list, 2 * m->capacity + 8, sizeof *m->list);
      m->capacity = 2 * m->capacity + 8;
    }
    char *wrong = format_text_v(format, args), *whole = memory_text("");
    if (about.place) whole = append_text(whole, "%s: ", about.place);
    if (about.name) whole = append_text(whole, "%s", about.name);
    if (about.value) whole = append_text(whole, " = %s", about.value);
    whole = append_text(whole, "%s%s", about.name ? ": " : "", wrong);
    const message one = {kind, about, wrong, text_escaped(whole, LIMIT_LINE)};
    m->list[m->count++] = one;
    free(whole);
    return;
  }
  if (m) m->more++;
  subject_free(about);
}

sd_status fail_about(sd_messages *m, subject about, const char *format, ...) {
  va_list args;
  va_start(args, format);
  add(m, SD_ERROR_USER, about, format, args);
  va_end(args);
  return SD_ERROR_USER;
}

sd_status sd_fail(sd_messages *m, sd_status kind, const char *format, ...) {
  va_list args;
  va_start(args, format);
  add(m, kind, (subject){0}, format, args);
  va_end(args);
  return kind;
}

sd_status fail_memory(sd_messages *m) {
  if (m && !m->starved) m->errors++;
  if (m) m->starved = true;
  return SD_ERROR_IO;
}

void sd_warn(sd_messages *m, const char *format, ...) {
  va_list args;
  va_start(args, format);
  add(m, SD_OK, (subject){0}, format, args);
  va_end(args);
}

size_t sd_messages_errors(const sd_messages *m) { return m ? m->errors : 0; }
size_t sd_messages_count(const sd_messages *m) { return m ? m->count + m->starved : 0; }

const message *messages_at(const sd_messages *m, size_t k) {
  assert(k < sd_messages_count(m));
  return k < m->count ? &m->list[k] : &NO_MEMORY;
}

const char *sd_messages_text(const sd_messages *m, size_t k) { return messages_at(m, k)->text; }
sd_status sd_messages_kind(const sd_messages *m, size_t k) { return messages_at(m, k)->kind; }

bool messages_have(const sd_messages *m, const char *text) {
  for (size_t k = 0; k < sd_messages_count(m); k++)
    if (strcmp(sd_messages_text(m, k), text) == 0) return true;
  return false;
}

void messages_append(sd_messages *to, sd_status kind, const sd_messages *from) {
  for (size_t k = 0; k < sd_messages_count(from); k++)
    sd_fail(to, kind, "%s", sd_messages_text(from, k));
}

sd_status sd_messages_status(const sd_messages *m) {
  for (size_t k = 0; k < sd_messages_count(m); k++)
    if (messages_at(m, k)->kind != SD_OK) return messages_at(m, k)->kind;
  return SD_OK;
}

void sd_messages_print(const sd_messages *m, FILE *out) {
  for (size_t k = 0; k < sd_messages_count(m); k++)
    fprintf(out, "%s: %s\n", messages_at(m, k)->kind == SD_OK ? "warning" : "error",
            messages_at(m, k)->text);
  if (m && m->more > 0) fprintf(out, "... and %zu more\n", m->more);
}

void sd_free(void *memory) { free(memory); }

const char *sd_version(void) { return SD_VERSION; }
