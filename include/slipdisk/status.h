/* status.h: status codes, the list of messages to which calls add, and memory.
 *
 * Every public function that can fail returns an sd_status and adds one line per problem to an
 * sd_messages list, so that a deck with five mistakes reports five lines. The library neither
 * prints nor exits; only the program does (src/app). Values of sd_status are exit statuses of the
 * program.
 */
#ifndef SLIPDISK_STATUS_H
#define SLIPDISK_STATUS_H

#include <stddef.h>
#include <stdio.h>

#if defined(__GNUC__)
#define SD_API __attribute__((visibility("default")))
#define SD_PRINTF(fmt, args) __attribute__((format(printf, fmt, args)))
#else
#define SD_API
#define SD_PRINTF(fmt, args)
#endif

#include "slipdisk/version.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Outcome of a call, and exit status of the program. */
typedef enum sd_status {
  SD_OK = 0,            /* success */
  SD_ERROR_USER = 2,    /* a mistake in the deck, an input file, the command line or an argument */
  SD_ERROR_NUMERIC = 3, /* a value is not finite, or an overlap is beyond the allowed limit */
  SD_ERROR_IO = 4,      /* disk full, no permission, damaged file, no memory for large arrays */
  SD_DOUBTFUL = 5, /* the run finished, but its result is beyond a limit of the deck (sd_limits) */
  SD_INTERRUPTED = 75 /* a signal stopped the run after a checkpoint; run again to continue */
} sd_status;

/* List of errors and warnings, in the order in which they were added. */
typedef struct sd_messages sd_messages;

/* Returns an empty list, never NULL. The caller frees it with sd_messages_free. */
SD_API sd_messages *sd_messages_new(void);
/* Frees a list of messages; NULL is allowed. */
SD_API void sd_messages_free(sd_messages *m);

/* Adds an error with a text as printf would write it, and returns `kind`, so that a caller can
 * write `return sd_fail(m, SD_ERROR_IO, ...)`. If m is NULL it only returns `kind`. */
SD_API sd_status sd_fail(sd_messages *m, sd_status kind, const char *format, ...) SD_PRINTF(3, 4);
/* Adds a warning with a text as printf would write it; warnings change no status. */
SD_API void sd_warn(sd_messages *m, const char *format, ...) SD_PRINTF(2, 3);

/* Returns the number of errors added to the list, including those beyond the 1000 that are kept.
 * m may be NULL: 0. */
SD_API size_t sd_messages_errors(const sd_messages *m);
/* Returns the number of messages that are kept, errors and warnings. m may be NULL: 0. */
SD_API size_t sd_messages_count(const sd_messages *m);
/* Returns the text of message k, 0 <= k < sd_messages_count, without a newline. The list owns
 * it. */
SD_API const char *sd_messages_text(const sd_messages *m, size_t k);
/* Returns the kind of error of message k, 0 <= k < sd_messages_count; SD_OK: it is a warning. */
SD_API sd_status sd_messages_kind(const sd_messages *m, size_t k);
/* Returns the kind of the first error in the list; SD_OK: there is no error. */
SD_API sd_status sd_messages_status(const sd_messages *m);
/* Removes all messages from the list. */
SD_API void sd_messages_clear(sd_messages *m);
/* Writes one line per message to `out`, with "error: " or "warning: " in front, and then the
 * number of messages that were not kept. */
SD_API void sd_messages_print(const sd_messages *m, FILE *out);

/* Handler that the library calls when it has no memory for `bytes` bytes of a small object (a text,
 * a struct, a list of messages); such allocations cannot report failure. It is called once, in the
 * thread whose allocation failed. It must not return: it may write a line and leave by _exit, but
 * not allocate. Large arrays, with a row per disk, contact, pair or row of output, need no handler:
 * their functions return SD_ERROR_IO, or what their comment says. Nor do functions that only make
 * something new: sd_deck_load, sd_deck_load_text, sd_simulation_new, _clone, _load, _load_memory
 * and _measure return SD_ERROR_IO with the message "no memory", and sd_model_advise adds that
 * message; what they had begun is not freed. */
typedef void sd_memory_handler(size_t bytes);
/* Sets the handler for all threads. NULL, the default, writes a line to the standard error output
 * and calls abort(). */
SD_API void sd_on_no_memory(sd_memory_handler *handler);

/* Frees memory that a function of this library returned, if the comment of that function says
 * so. */
SD_API void sd_free(void *memory);
/* Returns the version of the library that is linked, like "0.4.0"; SD_VERSION is the version of
 * the headers. */
SD_API const char *sd_version(void);

#ifdef __cplusplus
}
#endif

#endif
