/* file.h: files and folders that appear complete or not at all, and reading of files.
 *
 * A file is written as a draft: a new file with an unpredictable name in the same folder, which is
 * synchronised and renamed, then the folder is synchronised. If the power fails the name leads to
 * the old contents or to the new ones. If a write fails (disk full, no permission) the draft is
 * removed and nothing else is changed. Drafts never follow symbolic links.
 *
 * `folder` is the descriptor of an open folder, in which the last component of `path` is looked up
 * (the rest of path is for messages). If folder < 0, path is looked up as it stands.
 */
#ifndef SLIPDISK_IO_FILE_H
#define SLIPDISK_IO_FILE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include "slipdisk/status.h"

/* Reports "cannot WHAT PATH: " with the reason in errno; returns SD_ERROR_IO. */
sd_status file_fail(sd_messages *messages, const char *what, const char *path);

/* --- Drafts ----------------------------------------------------------------------------------- */
/* A draft: a new file under a temporary name, which gets its final name when it is complete. */
typedef struct file_draft {
  /* descriptors of the folder that contains the draft, and of the draft; -1: none */
  int folder, fd;
  char *name; /* temporary name of the draft in the folder */
  char *path; /* path of the draft (temporary file), for messages */
} file_draft;

/* Action if a file already has the final name of a draft when it is published (renamed). */
typedef enum file_replace {
  FILE_KEEP,   /* a file of that name is an error: nothing is overwritten */
  FILE_REPLACE /* a file or link of that name is replaced; a device or a pipe is an error */
} file_replace;

/* Creates a draft (temporary file) in the folder of `path`, open for reading and writing.
 * file_draft_drop must be called also if it fails. */
sd_status file_draft_new(int folder, const char *path, file_draft *out, sd_messages *messages);
/* Writes a draft to disk (fsync), renames it to `path` and closes it. If that fails the draft is
 * removed and the file at `path` is as it was. */
sd_status file_draft_publish(file_draft *draft, int folder, const char *path, file_replace how,
                             sd_messages *messages);
/* Removes a draft that was not published, closes its descriptors and frees its names. */
void file_draft_drop(file_draft *draft);

/* Returns a name for a draft (temporary file) of the file `name`, a new one at each call; the
 * caller frees it. */
char *file_draft_name(const char *name);

/* A draft that is written through a stream of the C library. */
typedef struct file_stream {
  FILE *out; /* stream of the draft; NULL: the draft could not be opened */
  char *path;
  file_draft draft;
} file_stream;
/* Creates a draft (temporary file) of the file `path` and opens it as a stream. file_stream_close
 * must be called also if it fails. */
sd_status file_stream_open(const char *path, file_stream *s, sd_messages *messages);
/* Closes the stream. If `status`, the status of the caller so far, is SD_OK the draft gets its
 * final name and replaces a file of this name; else the draft is removed. Returns the first
 * error. */
sd_status file_stream_close(file_stream *s, sd_status status, sd_messages *messages);
/* Writes these bytes to a file so that it appears complete or not at all: through a draft, which
 * replaces a file of this name. */
sd_status file_write_atomic(const char *path, const void *bytes, size_t size,
                            sd_messages *messages);
/* A folder that gets its final name when all files in it are written. */
typedef struct file_folder {
  /* path: final path of the folder; draft: its temporary path, NULL: there is no such folder */
  char *path, *draft;
} file_folder;
/* Creates a temporary folder (draft) for the folder `path`. Returns SD_ERROR_USER if something else
 * than an empty folder has this name. file_folder_close must be called also if it fails. */
sd_status file_folder_open(const char *path, file_folder *f, sd_messages *messages);
/* Creates a new file in the temporary folder, which file_folder_end closes. Returns NULL, with a
 * message, if that fails. */
FILE *file_folder_new(const file_folder *f, const char *name, sd_messages *messages);
/* Closes a file of file_folder_new; NULL is allowed. Returns `status`, the status of the caller so
 * far, or if that is SD_OK the error of writing and closing. */
sd_status file_folder_end(const file_folder *f, FILE *out, sd_status status, sd_messages *messages);
/* Renames the temporary folder to its final name if `status`, the status of the caller so far, is
 * SD_OK; else removes it. Returns the first error. */
sd_status file_folder_close(file_folder *f, sd_status status, sd_messages *messages);
/* Calls openat, again if a signal interrupts it, with O_CLOEXEC; folder may be AT_FDCWD. */
int file_open_at(int folder, const char *name, int flags);
/* Gives an open file the permission bits of the file at path, which it will replace. If the open
 * file is a folder, it also gets the right to enter it. Does nothing if there is no file at
 * path. */
void file_keep_mode(int fd, int folder, const char *path);
/* Writes all bytes, even if calls of write are interrupted by signals or write less than asked;
 * returns false, with errno set, if that fails. */
bool file_write_all(int fd, const void *bytes, size_t size);
/* Piece of memory with a part of a file's contents. */
typedef struct file_piece {
  const void *bytes;
  size_t size;
} file_piece;
/* Writes n pieces one after the other. *sum receives the checksum (file_sum) of all pieces. Returns
 * false, with errno set, if that fails. */
bool file_write_pieces(int fd, size_t n, const file_piece *pieces, uint64_t *sum);
/* Removes drafts (temporary files) of the file `base` that killed processes have left in the
 * folder. The caller must hold the lock of the file. */
sd_status file_remove_drafts(const char *folder, const char *base, sd_messages *messages);
/* Returns true if a file name is that of a draft, i.e. ends in ".tmp". */
bool file_is_draft(const char *name);
/* Reserves space on disk for a file that is being written; SD_ERROR_IO: there is not enough. */
sd_status file_reserve(int fd, const char *path, uint64_t bytes, sd_messages *messages);

/* --- Reading ---------------------------------------------------------------------------------- */
/* Opens a regular file for reading; returns -1, with a message, if that fails. With folder >= 0 a
 * symbolic link is not followed. */
int file_open(int folder, const char *path, sd_messages *messages);
/* Returns a path by which a library can open the file of an open descriptor again, even if its name
 * now belongs to another file; the caller frees it. */
char *file_reopen_path(int fd, const char *path);
/* Opens a regular file for reading without a message; *size receives its size. Returns -1, with
 * errno set, if that fails. */
int file_open_quiet(const char *path, uint64_t *size);
/* Returns a text that explains the errno that file_open_quiet has set. */
const char *file_error_text(int error);
/* Size of the argument `trouble` of file_text, bytes. */
enum { FILE_TROUBLE = 120 };
/* Reads a text file into *text, with a zero byte behind it; the caller frees it. On failure trouble
 * receives the reason; returns SD_ERROR_USER if the name is wrong, or the file has more than `most`
 * bytes or is no text, else SD_ERROR_IO. */
sd_status file_text(const char *path, uint64_t most, char **text, char trouble[FILE_TROUBLE]);
/* Reads the first n bytes of a file, or all of it if n is SIZE_MAX or too large; the caller frees
 * *bytes, and *size receives their number. */
sd_status file_read(const char *path, size_t n, unsigned char **bytes, size_t *size,
                    sd_messages *messages);
/* Reads up to n bytes from offset `at` on; *have receives their number, which is less than n only
 * if the file ends there. Returns false, with errno set, if they cannot be read. */
bool file_read_at(int fd, uint64_t at, void *bytes, size_t n, size_t *have);
/* Takes n bytes of a file, as file_visit has read them. */
typedef void file_visitor(void *with, const void *bytes, size_t n);
/* Reads bytes from ... to - 1 of an open file piece by piece, and calls take, which may be NULL,
 * for each. Returns SD_ERROR_IO if the file is shorter or cannot be read. */
sd_status file_visit(int fd, const char *path, uint64_t from, uint64_t to, file_visitor *take,
                     void *with, sd_messages *messages);
/* Reads all bytes of a regular file. It is called after a file could not be understood: SD_OK says
 * that its content is to blame, SD_ERROR_IO with a message that the disk or a permission is. */
sd_status file_read_through(const char *path, sd_messages *messages);

/* --- Names ------------------------------------------------------------------------------------ */
/* Returns false if there certainly is no file or folder at path; true also if that cannot be found
 * out. */
bool file_exists(const char *path);
/* Returns true if path leads to a folder. */
bool file_is_folder(const char *path);
/* Returns "; did you mean NAME?" with the name in its folder that is most similar to that of a file
 * that does not exist; "" without a similar one. The caller frees it. */
char *file_hint(const char *path);
/* Returns true if path is a symbolic link. */
bool file_is_link(const char *path);
/* Returns true if a file lies in a folder or deeper, all links followed. A file that does not exist
 * lies where the deepest folder on the way to it lies. */
bool file_is_within(const char *path, const char *folder);
/* Returns true if path is a device, a pipe or a socket, which a file never replaces. */
bool file_is_special(const char *path);
/* Returns the size of a file in bytes; 0: there is none. */
uint64_t file_size(const char *path);
/* Makes a folder; one that exists is no error. Returns SD_ERROR_USER if the folder above it does
 * not exist. */
sd_status file_make_folder(const char *path, sd_messages *messages);
/* Writes the folder of `path` to disk (fsync), so that renames and removals in it survive a power
 * failure. */
sd_status file_sync_folder(int folder, const char *path, sd_messages *messages);
/* Removes a file; a failure is not reported. */
void file_remove(int folder, const char *path);

/* --- Checksums (file_sum.c) ------------------------------------------------------------------- */
/* Returns the checksum of these bytes: XXH3, 64 bits, without seed, as `xxhsum -H3` computes it. */
uint64_t file_sum(const void *bytes, size_t n);
/* The same checksum, computed piece by piece. */
typedef struct file_digest file_digest;
file_digest *file_digest_new(void);
void file_digest_add(file_digest *d, const void *bytes, size_t n);
/* Returns the checksum of the pieces added so far; more may follow. */
uint64_t file_digest_sum(const file_digest *d);
void file_digest_free(file_digest *d);

#endif
