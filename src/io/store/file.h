/* file.h: files that are either there whole or not at all.
 *
 * A file is written as a draft: a new file of an unpredictable name in the same folder, synchronised, renamed, and the
 * folder synchronised. Whenever the power goes, the name leads to the old contents or to the new. When a write fails
 * (disk full, no permission) the draft is removed and nothing else is touched. Drafts never follow symbolic links.
 *
 * `folder` is the descriptor of an open folder, in which the last component of `path` is looked up (the rest of path
 * serves messages); a folder < 0 means that path is looked up as it stands.
 */
#ifndef SLIPDISK_IO_FILE_H
#define SLIPDISK_IO_FILE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include "slipdisk/status.h"

/* "cannot WHAT PATH: " and the reason in errno. */
sd_status file_fail(sd_messages *messages, const char *what, const char *path);

/* --- drafts --------------------------------------------------------------------------------------- */
typedef struct file_draft {
  int folder, fd; /* -1: none */
  char *name;     /* in that folder */
  char *path;     /* for messages */
} file_draft;

typedef enum file_replace {
  FILE_KEEP,   /* a file of that name is an error: nothing is overwritten */
  FILE_REPLACE /* a file or a link of that name goes; a device or a pipe is an error */
} file_replace;

/* A draft beside `path`, open for reading and writing. file_draft_drop also when it fails. */
sd_status file_draft_new(int folder, const char *path, file_draft *out, sd_messages *messages);
/* Makes it durable and gives it the name `path`; the draft is closed. When it fails the draft is removed and `path` is as
 * it was. */
sd_status file_draft_publish(file_draft *draft, int folder, const char *path, file_replace how,
                             sd_messages *messages);
void file_draft_drop(file_draft *draft); /* removes it, if it is still a draft */

/* The name of a draft of it, another one each time; to be freed. */
char *file_draft_name(const char *name);

/* A file that is written with the functions of the C library. */
typedef struct file_stream {
  FILE *out;
  char *path;
  file_draft draft;
} file_stream;
sd_status file_stream_open(const char *path, file_stream *s,
                           sd_messages *messages); /* file_stream_close also when it fails */
/* Publishes what was written (replaces what is there) when `status`, the caller's, is SD_OK, else drops it. Returns the
 * first of what went wrong. */
sd_status file_stream_close(file_stream *s, sd_status status, sd_messages *messages);
/* A file of these bytes; replaces what is there. */
sd_status file_write_atomic(const char *path, const void *bytes, size_t size,
                            sd_messages *messages);
/* A folder that gets its name when all files in it are written. */
typedef struct file_folder {
  char *path, *draft;
} file_folder;
/* SD_ERROR_USER: something of this name, other than an empty folder, is there. file_folder_close also when it fails. */
sd_status file_folder_open(const char *path, file_folder *f, sd_messages *messages);
/* A new file in it, for file_folder_end, which closes it and returns the first of what went wrong; NULL: reported. */
FILE *file_folder_new(const file_folder *f, const char *name, sd_messages *messages);
sd_status file_folder_end(const file_folder *f, FILE *out, sd_status status, sd_messages *messages);
/* Publishes the folder when `status` is SD_OK, else removes what was written. Returns the first of what went wrong. */
sd_status file_folder_close(file_folder *f, sd_status status, sd_messages *messages);
/* openat, closed on exec, again where a signal comes; folder may be AT_FDCWD. */
int file_open_at(int folder, const char *name, int flags);
/* Gives an open file the mode of the one at path, whose place it will take, and a folder one for such files; without one: nothing. */
void file_keep_mode(int fd, int folder, const char *path);
/* All of it, through short writes and signals; false with errno set when it cannot be. */
bool file_write_all(int fd, const void *bytes, size_t size);
typedef struct file_piece {
  const void *bytes;
  size_t size;
} file_piece;
/* All pieces, of which all but the last are whole words; sum: file_sum of them all. False with errno set. */
bool file_write_pieces(int fd, size_t n, const file_piece *pieces, uint64_t *sum);
/* Removes drafts of the file `base` that a kill has left in the folder; for the holder of its lock. */
sd_status file_remove_drafts(const char *folder, const char *base, sd_messages *messages);
bool file_is_draft(const char *name);
/* Reserves room for a file that is being written; SD_ERROR_IO when there is not enough. */
sd_status file_reserve(int fd, const char *path, uint64_t bytes, sd_messages *messages);

/* --- reading -------------------------------------------------------------------------------------- */
/* A regular file, for reading; -1: reported. In a held folder no link is followed. */
int file_open(int folder, const char *path, sd_messages *messages);
/* A path by which a library opens this very file again; to be freed. */
char *file_again(int fd, const char *path);
/* The same without a message: -1 with errno set; its errno in words. */
int file_open_quiet(const char *path, uint64_t *size);
const char *file_trouble(int error);
/* A whole text with a zero behind it, to be freed. Not read: SD_ERROR_USER where the name is a mistake, it is larger
 * than `most` bytes, or no text, else SD_ERROR_IO; why in `trouble`. */
enum { FILE_TROUBLE = 120 };
sd_status file_text(const char *path, uint64_t most, char **text, char trouble[FILE_TROUBLE]);
/* The first n bytes of a file, or all of it when n is SIZE_MAX; to be freed. */
sd_status file_read(const char *path, size_t n, unsigned char **bytes, size_t *size,
                    sd_messages *messages);
/* Up to n bytes from `at` on; *have < n: the file ends there. False with errno set when they cannot be read. */
bool file_read_at(int fd, uint64_t at, void *bytes, size_t n, size_t *have);
/* Sum of the first n bytes, in pieces; SD_ERROR_IO: the file is shorter, or cannot be read. */
sd_status file_sum_of(int fd, const char *path, uint64_t n, uint64_t *sum, sd_messages *messages);

/* --- names ---------------------------------------------------------------------------------------- */
bool file_exists(const char *path); /* only what certainly is not there does not exist */
bool file_is_folder(const char *path);
bool file_is_link(const char *path);    /* a symbolic link */
bool file_is_special(const char *path); /* a device, a pipe or a socket: never replaced by a file */
uint64_t file_size(const char *path);   /* 0 when there is none */
sd_status file_make_folder(const char *path,
                           sd_messages *messages); /* one that exists is all right */
/* Makes renames and removals in the folder of `path` durable. */
sd_status file_sync_folder(int folder, const char *path, sd_messages *messages);
/* A file that is not there, or cannot be removed, is not told of. */
void file_remove(int folder, const char *path);

/* Order-dependent sum of 64-bit words (FNV-1a), to tell damaged files. Start from FILE_SUM. */
#define FILE_SUM UINT64_C(14695981039346656037)
uint64_t file_sum(uint64_t sum, const void *bytes, size_t n);

#endif
