/* folder.h: the folder NAME.h5.parts, which is beside a result while its run is not finished. It
 * contains
 *
 *   lock                         locked with flock by the process that writes here
 *   part-000001.h5 ...           parts with a checksum: rows of series, frames, contact tables
 *   part-000001-<rank>.h5 ...    the rows of a part that one rank has written (h5.h)
 *   checkpoint-<step>.h5         the last two; each says how many parts belong to it
 *   checkpoint-<step>-<rank>.h5  the rows of a checkpoint that one rank has written
 *   emergency-<step>.h5          state in which a numerical error was found
 *   damaged-...                  a checkpoint with a wrong checksum, kept for inspection
 *   *.tmp                        a draft: a file whose writing was interrupted, or the result
 *                                while parts are merged
 *
 * The folder is kept open by a descriptor. Before anything is written or removed, folder_check
 * makes sure that the path still leads to this folder and to the lock of this process: another run
 * may have taken the name after the folder was removed.
 */
#ifndef SLIPDISK_IO_FOLDER_H
#define SLIPDISK_IO_FOLDER_H

#include <stdbool.h>
#include <stdint.h>

#include "slipdisk/status.h"

/* An open folder NAME.h5.parts with the files of an unfinished run. */
typedef struct folder {
  char *path; /* path of the folder */
  int at;     /* descriptor of the folder; -1: it is not open */
  int lock;   /* descriptor of the lock file; -1: the lock is not held */
} folder;

/* Makes the folder if it does not exist, opens and locks it. may_be_link: true if the path may be a
 * symbolic link, as for a folder of sweeps. Returns SD_ERROR_USER if another process holds the
 * lock, or if the path is a symbolic link and must not be. */
sd_status folder_open(const char *path, bool may_be_link, folder *out, sd_messages *messages);
/* Returns SD_ERROR_IO if the folder was removed, moved or replaced since it was opened. */
sd_status folder_check(const folder *f, sd_messages *messages);
/* Returns true if a process holds the lock of this folder now; false also if there is no such
 * folder. */
bool folder_is_locked(const char *path);
/* Releases the lock and closes the folder; its files stay. */
void folder_close(folder *f);
/* Removes the folder with all files that slipdisk makes, and closes it. If other files are in it,
 * they and the folder stay, with a warning. */
sd_status folder_remove(folder *f, sd_messages *messages);

/* folder_part returns the path of part `number` in the folder at `path`, folder_checkpoint and
 * folder_emergency those of the checkpoint and the emergency file of a step. The caller frees
 * them. */
char *folder_part(const char *path, int64_t number);
char *folder_checkpoint(const char *path, int64_t step);
char *folder_emergency(const char *path, int64_t step);

/* Lists the steps of the checkpoints in a folder, newest first; *steps is to be freed. It needs no
 * lock. */
sd_status folder_checkpoints(const char *path, int64_t **steps, size_t *n, sd_messages *messages);
/* Reads all bytes of the files of slipdisk in a folder. SD_ERROR_IO: the disk or a permission
 * prevents that (file_read_through). */
sd_status folder_read_through(const char *path, sd_messages *messages);
/* Removes temporary files, parts with numbers above `parts` with their files of single ranks
 * (shares), and such files of checkpoints that are newer than all complete checkpoints. */
sd_status folder_clean(const folder *f, int64_t parts, sd_messages *messages);
/* Removes all checkpoints but the `keep` newest, with their files of single ranks (shares). */
sd_status folder_prune(const folder *f, size_t keep, sd_messages *messages);
/* Removes all files that slipdisk makes in the folder, but not the lock. */
sd_status folder_empty(const folder *f, sd_messages *messages);
/* Renames the checkpoint of this step to damaged-..., so that it is not used again. */
void folder_set_aside(const folder *f, int64_t step);

#endif
