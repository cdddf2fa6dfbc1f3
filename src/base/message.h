/* message.h: errors that carry their subject as data; see slipdisk/status.h. */
#ifndef SLIPDISK_BASE_MESSAGE_H
#define SLIPDISK_BASE_MESSAGE_H

#include <stdbool.h>
#include <stddef.h>

#include "slipdisk/status.h"

typedef enum subject_kind {
  SUBJECT_NONE,
  SUBJECT_BODY, /* a disk, wall or clump, by its body number */
  SUBJECT_MOTION,
  SUBJECT_PATH /* a key or group of a deck */
} subject_kind;

/* Subject of a message. It owns its texts until fail_about takes them over. */
typedef struct subject {
  subject_kind kind;
  size_t number; /* number of the body or motion */
  char *place;   /* file and line, such as "a.cfg:3"; NULL: not known */
  char *name;    /* name of the body or motion, such as "disk 3", or path of the key; may be NULL */
  char *value;   /* value of the key; NULL: not shown */
} subject;

/* Returns a subject with this path, such as "phases[0].cell", formatted as by printf. */
subject about_path(const char *format, ...) SD_PRINTF(1, 2);
/* Returns the subject with a value of its key, formatted as by printf. */
subject about_value(subject about, const char *format, ...) SD_PRINTF(2, 3);

/* Adds an error of the user with its subject; its text is "place: name = value: " and the formatted
 * text. Takes over the texts of the subject. Returns SD_ERROR_USER. */
sd_status fail_about(sd_messages *m, subject about, const char *format, ...) SD_PRINTF(3, 4);

/* Adds the error "no memory" without allocating, once. Returns SD_ERROR_IO. */
sd_status fail_memory(sd_messages *m);

typedef struct message {
  sd_status kind; /* status of an error; SD_OK: a warning */
  subject about;
  char *wrong; /* text without the subject */
  char *text;  /* text as it is shown */
} message;

/* Returns message k, 0 <= k < sd_messages_count, which the list owns. */
const message *messages_at(const sd_messages *m, size_t k);
/* True if a message of the list, which may be NULL, has this text. */
bool messages_have(const sd_messages *m, const char *text);
/* Adds the texts of all messages of a list, which may be NULL, to another as messages of one kind;
 * SD_OK: as warnings. */
void messages_append(sd_messages *to, sd_status kind, const sd_messages *from);

#endif
