/* ranks_failure.c: see ranks_failure.h. */
#include "run/ranks_failure.h"

#include <stdlib.h>
#include <string.h>

#include "base/comm.h"
#include "base/memory.h"

/* The errors, each with its end. */
static char *errors_of(const sd_messages *m, size_t *length) {
  *length = 0;
  for (size_t k = 0; k < sd_messages_count(m); k++) *length += strlen(sd_messages_text(m, k)) + 1;
  char *text = memory_new(*length, 1), *at = text;
  for (size_t k = 0; k < sd_messages_count(m); k++) {
    if (sd_messages_kind(m, k) == SD_OK) continue;
    const size_t n = strlen(sd_messages_text(m, k)) + 1;
    memcpy(at, sd_messages_text(m, k), n);
    at += n;
  }
  *length = (size_t)(at - text);
  return text;
}

static bool is_told(const sd_messages *m, const char *text) {
  for (size_t k = 0; k < sd_messages_count(m); k++)
    if (strcmp(sd_messages_text(m, k), text) == 0) return true;
  return false;
}

static void tell_errors(const comm *c, sd_status status, const sd_messages *own,
                        sd_messages *messages) {
  size_t length, bytes = 0;
  char *mine = errors_of(own, &length);
  int *counts = memory_new((size_t)comm_size(c), sizeof *counts);
  comm_gather_counts(c, (int)length, counts);
  for (int q = 0; q < comm_size(c); q++) bytes += (size_t)counts[q];
  char *text = memory_new(bytes, 1);
  comm_gather(c, mine, text, counts, 1);
  for (size_t at = 0; messages && at < bytes; at += strlen(text + at) + 1)
    if (!is_told(messages, text + at)) sd_fail(messages, status, "%s", text + at);
  free(mine);
  free(counts);
  free(text);
}

sd_status ranks_tell(const comm *c, sd_status status, sd_messages *own, sd_messages *messages) {
  for (size_t k = 0; messages && k < sd_messages_count(own); k++)
    if (sd_messages_kind(own, k) == SD_OK) sd_warn(messages, "%s", sd_messages_text(own, k));
  if (status != SD_OK) tell_errors(c, status, own, messages);
  sd_messages_clear(own);
  return status;
}
