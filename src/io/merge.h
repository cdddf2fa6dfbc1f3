/* merge.h: puts the sealed parts of a finished run together into one file.
 *
 * Part after part is read and copied by rows, so that memory stays bounded whatever the length of the run.
 * The file is written under a temporary name (the name + ".tmp") and renamed when it is complete; the parts
 * are left alone, so an interrupted merge is simply done again.
 */
#ifndef SLIPDISK_IO_MERGE_H
#define SLIPDISK_IO_MERGE_H

#include <signal.h>

#include "io/checkpoint.h"
#include "io/record.h"

typedef struct merge_job {
  const char *result; /* path of the file to be made */
  const char *folder; /* of the parts */
  int64_t parts;
  record *layout; /* which tables there are; its rows are not looked at */
  const sd_model *model;
  const sd_state *state;
  const provenance *origin;
  const summary *found;
  const volatile sig_atomic_t *stop; /* may be NULL; SD_INTERRUPTED soon after it becomes true */
} merge_job;

sd_status merge_parts(const merge_job *job, sd_messages *messages);

#endif
