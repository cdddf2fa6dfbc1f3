/* ranks_failure.c: see ranks_failure.h. */
#include "run/ranks_failure.h"

#include <stdlib.h>
#include <string.h>

#include "base/comm.h"
#include "base/comm_data.h"
#include "base/memory.h"

static char *text_of(const sd_messages *m, size_t *length) {
  *length = 0;
  for (size_t k = 0; k < sd_messages_count(m); k++) *length += strlen(sd_messages_text(m, k)) + 1;
  char *text = memory_new(*length, 1), *at = text;
  for (size_t k = 0; k < sd_messages_count(m); k++) {
    const size_t n = strlen(sd_messages_text(m, k)) + 1;
    memcpy(at, sd_messages_text(m, k), n);
    at += n;
  }
  return text;
}

static bool is_told(const sd_messages *m, const char *text) {
  for (size_t k = 0; k < sd_messages_count(m); k++)
    if (strcmp(sd_messages_text(m, k), text) == 0) return true;
  return false;
}

sd_status ranks_tell_failure(sd_status failed, const sd_messages *own, sd_messages *messages) {
  const size_t n = (size_t)comm_size();
  size_t length;
  char *mine = text_of(own, &length);
  int *counts = memory_new(2 * n, sizeof *counts), *all = counts + n;
  comm_gather_counts((int)failed, all);
  comm_gather_counts((int)length, counts);
  sd_status status = SD_OK;
  size_t bytes = 0;
  for (size_t q = 0; q < n; q++) {
    if (status == SD_OK) status = (sd_status)all[q];
    bytes += (size_t)counts[q];
  }
  char *text = memory_new(bytes, 1);
  comm_gather(mine, text, counts, 1);
  for (size_t at = 0; messages && at < bytes; at += strlen(text + at) + 1)
    if (!is_told(messages, text + at)) sd_fail(messages, status, "%s", text + at);
  free(mine);
  free(counts);
  free(text);
  return status;
}
