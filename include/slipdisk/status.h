/* status.h: what a call returns, and the list of messages it leaves behind.
 *
 * Every public function that can fail returns an sd_status and adds one line per problem to an
 * sd_messages list, so that a deck with five mistakes reports five lines. Nothing below app/ prints
 * or exits. The values of sd_status are the exit status of the program.
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

typedef enum sd_status {
  SD_OK = 0,
  SD_ERROR_USER = 2,    /* deck, input file or command line */
  SD_ERROR_NUMERIC = 3, /* not finite, overlap beyond the limit */
  SD_ERROR_IO = 4,      /* disk full, no permission, damaged file */
  SD_DOUBTFUL = 5,      /* finished, but the result is beyond a limit of the deck (sd_limits) */
  SD_INTERRUPTED = 75   /* stopped by a signal after a checkpoint; run again to continue */
} sd_status;

typedef struct sd_messages sd_messages;

/* An empty list. Free with sd_messages_free (NULL is allowed). */
SD_API sd_messages *sd_messages_new(void);
SD_API void sd_messages_free(sd_messages *m);

/* Adds one message and returns its kind, so that `return sd_fail(m, SD_ERROR_IO, ...)` reads well.
 * m may be NULL: then only the status is returned. */
SD_API sd_status sd_fail(sd_messages *m, sd_status kind, const char *format, ...) SD_PRINTF(3, 4);
/* Adds a warning: it is printed, and changes no status. */
SD_API void sd_warn(sd_messages *m, const char *format, ...) SD_PRINTF(2, 3);

SD_API size_t sd_messages_errors(const sd_messages *m); /* number of errors added */
SD_API size_t sd_messages_count(const sd_messages *m);  /* errors and warnings */
SD_API const char *sd_messages_text(const sd_messages *m,
                                    size_t k); /* k-th line, without newline */
SD_API sd_status sd_messages_kind(const sd_messages *m,
                                  size_t k); /* of the k-th; SD_OK: a warning */
/* Worst kind added: SD_OK when there is no error, else the first error's kind. */
SD_API sd_status sd_messages_status(const sd_messages *m);
/* Empties the list. */
SD_API void sd_messages_clear(sd_messages *m);
/* One line each, "error: " or "warning: " before it. */
SD_API void sd_messages_print(const sd_messages *m, FILE *out);

/* Memory. Functions whose arrays have a row per disk, contact, pair or row of output return
 * SD_ERROR_IO, or what their header says, when there is no memory. Small things (texts, structs,
 * lists of messages) do not fail: without memory for `bytes` of them the handler is called, once,
 * from the thread that lacks them. It must not return; it may write a line and leave by _exit,
 * but not allocate. NULL, the default: a line on the standard error output, and abort(). */
typedef void sd_memory_handler(size_t bytes);
SD_API void sd_on_no_memory(sd_memory_handler *handler);

/* Frees memory that a function of this library has returned, where its header says so. */
SD_API void sd_free(void *memory);
/* Version of the library that runs, "0.4.0"; SD_VERSION is that of the headers. */
SD_API const char *sd_version(void);

#ifdef __cplusplus
}
#endif

#endif
