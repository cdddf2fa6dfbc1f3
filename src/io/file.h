/* file.h: files that are either there whole or not at all.
 *
 * A file is written under a temporary name (the name + ".tmp") in the same folder, synchronised, renamed, and
 * the folder synchronised: whenever the power goes, the name leads to the old contents or to the new.
 * When a write fails (disk full, no permission) the temporary file is removed and nothing else is touched.
 */
#ifndef SLIPDISK_IO_FILE_H
#define SLIPDISK_IO_FILE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "slipdisk/status.h"

typedef struct file_piece {
  const void *bytes;
  size_t size;
} file_piece;

/* Writes the pieces one after the other. */
sd_status file_write_atomic(const char *path, size_t n_pieces, const file_piece *pieces,
                            sd_messages *messages);
/* Makes a finished temporary file durable and gives it its name. */
sd_status file_commit(const char *temporary, const char *path, sd_messages *messages);
/* Makes renames and removals in the folder of `path` durable. */
sd_status file_sync_folder(const char *path, sd_messages *messages);
/* Reserves room for a file that is being written; SD_ERROR_IO when there is not enough. */
sd_status file_reserve(const char *path, uint64_t bytes, sd_messages *messages);
/* The first n bytes of a file, or all of it when n is SIZE_MAX; to be freed. */
sd_status file_read(const char *path, size_t n, unsigned char **bytes, size_t *size, sd_messages *messages);
/* Sum of all but the last `tail` bytes, which go to `end`; size: of what was summed, 0 when the file is shorter than
 * `tail`. Needs no memory for the file. */
sd_status file_sum_of(const char *path, size_t tail, void *end, uint64_t *size, uint64_t *sum,
                      sd_messages *messages);

bool file_exists(const char *path);
bool file_is_folder(const char *path);
bool file_is_special(const char *path); /* a device, a pipe or a socket: never replaced by a file */
uint64_t file_size(const char *path);   /* 0 when there is none */
sd_status file_make_folder(const char *path, sd_messages *messages); /* one that exists is all right */
/* No message when it is not there. */
sd_status file_remove(const char *path, sd_messages *messages);

/* A path made with printf, to be freed; NULL: no memory. */
char *file_path(const char *format, ...) SD_PRINTF(1, 2);

/* Order-dependent sum of 64-bit words (FNV-1a), to tell damaged files. Start from FILE_SUM. */
#define FILE_SUM UINT64_C(14695981039346656037)
uint64_t file_sum(uint64_t sum, const void *bytes, size_t n);

#endif
