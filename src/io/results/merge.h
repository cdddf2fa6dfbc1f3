/* merge.h: puts the sealed parts of a finished run together into one file.
 *
 * Part after part is read and copied by rows, so that memory stays bounded whatever the length of the run.
 * The file is written as a draft among the parts, read back and compared with what was put into it, sealed, and renamed;
 * the parts are left alone, so an interrupted merge is simply done again.
 */
#ifndef SLIPDISK_IO_MERGE_H
#define SLIPDISK_IO_MERGE_H

#include <signal.h>

#include "io/results/checkpoint.h"
#include "io/store/folder.h"
#include "io/results/record.h"

typedef struct merge_job {
  const char *result; /* path of the file to be made */
  file_replace how;   /* FILE_KEEP: nothing may be there */
  const folder *folder;
  int64_t parts;
  const record *layout; /* which tables there are; its rows are not looked at */
  const sd_model *model;
  const sd_state *state;     /* NULL: */
  const h5_file *checkpoint; /* has the state, which is copied column by column */
  const provenance *origin;
  const summary *found;
  const volatile sig_atomic_t *stop; /* may be NULL; SD_INTERRUPTED soon after it becomes true */
} merge_job;

sd_status merge_parts(const merge_job *job, sd_messages *messages);
/* Are all parts there, whole, of this run, and in their order? last: sum in the seal of the last one. */
sd_status merge_check_parts(const folder *f, const record *layout, const char *run_id,
                            int64_t parts, uint64_t last, sd_messages *messages);

#endif
