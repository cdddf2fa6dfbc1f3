/* folder.h: the folder NAME.h5.parts that stands beside a result while its run is not finished.
 *
 *   lock                 held with flock by the process that writes here
 *   part-000001.h5 ...   sealed parts: rows of the series, frames, contact tables
 *   part-000001-<rank>.h5 ...    their shares (h5.h), where several ranks have written them
 *   checkpoint-<step>.h5 the last two; each says how many parts belong to it
 *   checkpoint-<step>-<rank>.h5  likewise
 *   emergency-<step>.h5  state at which a numerical error was found
 *   damaged-...          a checkpoint whose checksum did not fit, kept for inspection
 *   *.tmp                a draft: a file whose writing was interrupted, or the result while parts are merged
 *
 * The folder is held by a descriptor. Before anything is written or removed folder_check makes sure that the path
 * still leads to it and that its lock is ours: another run may have taken the name after the folder was removed.
 */
#ifndef SLIPDISK_IO_FOLDER_H
#define SLIPDISK_IO_FOLDER_H

#include <stdbool.h>
#include <stdint.h>

#include "slipdisk/status.h"

typedef struct folder {
  char *path;
  int at;   /* descriptor of the folder; -1: not open */
  int lock; /* descriptor of the lock; -1: not held */
} folder;

/* Makes the folder if need be and locks it. SD_ERROR_USER: another process holds it, or the path is a symbolic link (that
 * of a folder of sweeps may be one). */
sd_status folder_open(const char *path, bool may_be_link, folder *out, sd_messages *messages);
/* SD_ERROR_IO: the folder was removed, moved or replaced. */
sd_status folder_check(const folder *f, sd_messages *messages);
bool folder_is_locked(
    const char *path);        /* some process holds it now; false when there is no such folder */
void folder_close(folder *f); /* gives the lock back; the files stay */
/* Removes all of it and closes; files that slipdisk does not make are left, with a warning. */
sd_status folder_remove(folder *f, sd_messages *messages);

/* Paths, to be freed. */
char *folder_part(const char *path, int64_t number);
char *folder_checkpoint(const char *path, int64_t step);
char *folder_emergency(const char *path, int64_t step);

/* Steps of the checkpoints, newest first, to be freed. Also without the lock. */
sd_status folder_checkpoints(const char *path, int64_t **steps, size_t *n, sd_messages *messages);
/* Removes drafts, parts and their shares with numbers beyond `parts`, and shares of checkpoints newer than all checkpoints. */
sd_status folder_clean(const folder *f, int64_t parts, sd_messages *messages);
/* Removes all checkpoints but the `keep` newest, with their shares. */
sd_status folder_prune(const folder *f, size_t keep, sd_messages *messages);
/* Removes everything but the lock. */
sd_status folder_empty(const folder *f, sd_messages *messages);
/* Puts a damaged checkpoint out of the way. */
void folder_set_aside(const folder *f, int64_t step);

#endif
