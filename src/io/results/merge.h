/* merge.h: merges the part files of a finished run into one result file.
 *
 * Parts are read and copied one after the other, a block of rows at a time, so that memory stays
 * bounded for any length of the run. The result is written under a temporary name in the folder of
 * the parts, read back, compared with what was written, closed with a checksum and renamed. Part
 * files are only read, so an interrupted merge can simply be repeated.
 */
#ifndef SLIPDISK_IO_MERGE_H
#define SLIPDISK_IO_MERGE_H

#include <signal.h>

#include "io/results/checkpoint.h"
#include "io/store/folder.h"
#include "io/results/record.h"

/* Inputs of a merge. */
typedef struct merge_job {
  const char *result;   /* path of the result file */
  file_replace how;     /* FILE_KEEP: it is an error if the result file already exists */
  const folder *folder; /* open folder with the part files */
  int64_t parts;        /* number of part files */
  /* tables and columns that the result has; rows in this record are ignored */
  const record *layout;
  const sd_model *model;
  const sd_state *state;     /* final state; NULL: it is copied from `checkpoint` */
  const h5_file *checkpoint; /* source of the final state, column by column, if `state` is NULL */
  const provenance *origin;
  const summary *found; /* summary to be stored as /summary */
  /* merge_parts returns SD_INTERRUPTED soon after this becomes nonzero; may be NULL */
  const volatile sig_atomic_t *stop;
} merge_job;

/* Merges all part files into the result file. */
sd_status merge_parts(const merge_job *job, sd_messages *messages);
/* Checks that part files 1 ... `parts` exist, are intact, belong to this run and follow one
 * another. last: checksum at the end of the last part, as the checkpoint gives it. SD_ERROR_IO: one
 * of the checks fails. */
sd_status merge_check_parts(const folder *f, const record *layout, const char *run_id,
                            int64_t parts, uint64_t last, sd_messages *messages);

#endif
