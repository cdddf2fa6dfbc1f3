/* file.c: see file.h. */
#ifndef _GNU_SOURCE
#define _GNU_SOURCE /* fallocate */
#endif
#include "io/file.h"

#include <errno.h>
#include <fcntl.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

char *file_path(const char *format, ...) {
  va_list args;
  va_start(args, format);
  int n = vsnprintf(NULL, 0, format, args);
  va_end(args);
  char *path = n < 0 ? NULL : malloc((size_t)n + 1);
  if (!path) return NULL;
  va_start(args, format);
  vsnprintf(path, (size_t)n + 1, format, args);
  va_end(args);
  return path;
}

static sd_status fail(sd_messages *messages, const char *what, const char *path) {
  return sd_fail(messages, SD_ERROR_IO, "cannot %s %s: %s", what, path, strerror(errno));
}

/* All of it, through short writes and signals; false with errno set when it cannot be. */
static bool write_all(int fd, const unsigned char *bytes, size_t size) {
  /* One call is kept below 1 GiB: the kernel cuts longer ones anyway. */
  const size_t most = (size_t)1 << 30;
  while (size > 0) {
    ssize_t n = write(fd, bytes, size < most ? size : most);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return false;
    if (n == 0) {
      errno = ENOSPC;
      return false;
    }
    bytes += n;
    size -= (size_t)n;
  }
  return true;
}

bool file_is_special(const char *path) {
  struct stat facts;
  if (lstat(path, &facts) != 0) return false;
  return !S_ISREG(facts.st_mode) && !S_ISLNK(facts.st_mode) && !S_ISDIR(facts.st_mode);
}

/* A rename would put a file in the place of a device or a pipe, and of /dev/null for everybody. */
static sd_status check_replaceable(const char *path, sd_messages *messages) {
  if (!file_is_special(path)) return SD_OK;
  return sd_fail(messages, SD_ERROR_IO, "cannot write %s: it is a device or a pipe", path);
}

sd_status file_write_atomic(const char *path, size_t n_pieces, const file_piece *pieces,
                            sd_messages *messages) {
  if (check_replaceable(path, messages) != SD_OK) return SD_ERROR_IO;
  char *temporary = file_path("%s.tmp", path);
  if (!temporary) return sd_fail(messages, SD_ERROR_IO, "no memory to write %s", path);
  int fd = open(temporary, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (fd < 0) {
    sd_status status = fail(messages, "create", temporary);
    free(temporary);
    return status;
  }
  bool good = true;
  for (size_t k = 0; good && k < n_pieces; k++) good = write_all(fd, pieces[k].bytes, pieces[k].size);
  good = good && fsync(fd) == 0;
  int error = errno;
  /* close can be the first to tell of a full disk (NFS, quotas) */
  if (close(fd) != 0 && good) {
    good = false;
    error = errno;
  }
  if (good && rename(temporary, path) != 0) {
    good = false;
    error = errno;
  }
  if (!good) {
    unlink(temporary);
    errno = error;
  }
  sd_status status = good ? file_sync_folder(path, messages) : fail(messages, "write", path);
  free(temporary);
  return status;
}

sd_status file_sync_folder(const char *path, sd_messages *messages) {
  const char *slash = strrchr(path, '/');
  char *folder = !slash          ? file_path(".")
                 : slash == path ? file_path("/")
                                 : file_path("%.*s", (int)(slash - path), path);
  if (!folder) return sd_fail(messages, SD_ERROR_IO, "no memory to write %s", path);
  int fd = open(folder, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  sd_status status = SD_OK;
  if (fd < 0) {
    status = fail(messages, "open folder", folder);
  } else {
    /* some file systems do not synchronise folders and say EINVAL; there is no more to be done there */
    if (fsync(fd) != 0 && errno != EINVAL && errno != ENOTSUP) status = fail(messages, "synchronise", folder);
    close(fd);
  }
  free(folder);
  return status;
}

sd_status file_commit(const char *temporary, const char *path, sd_messages *messages) {
  if (check_replaceable(path, messages) != SD_OK) return SD_ERROR_IO;
  int fd = open(temporary, O_RDWR | O_CLOEXEC);
  if (fd < 0) return fail(messages, "open", temporary);
  struct stat facts;
  /* to its own size: gives back what file_reserve took and nobody used */
  bool good = fstat(fd, &facts) == 0 && ftruncate(fd, facts.st_size) == 0 && fsync(fd) == 0;
  int error = errno;
  close(fd);
  errno = error;
  if (!good) return fail(messages, "synchronise", temporary);
  if (rename(temporary, path) != 0) return fail(messages, "rename to", path);
  return file_sync_folder(path, messages);
}

sd_status file_reserve(const char *path, uint64_t bytes, sd_messages *messages) {
#ifdef FALLOC_FL_KEEP_SIZE
  int fd = open(path, O_WRONLY | O_CLOEXEC);
  if (fd < 0) return fail(messages, "open", path);
  int result;
  do result = fallocate(fd, FALLOC_FL_KEEP_SIZE, 0, (off_t)bytes);
  while (result != 0 && errno == EINTR);
  int error = errno;
  close(fd);
  errno = error;
  /* a file system that cannot reserve lets the writes find out */
  if (result != 0 && (error == ENOSPC || error == EDQUOT || error == EFBIG))
    return sd_fail(messages, SD_ERROR_IO, "cannot write %s: %.0f MB are needed: %s", path,
                   (double)bytes / 1e6, strerror(error));
#else
  (void)path, (void)bytes, (void)messages;
#endif
  return SD_OK;
}

/* Up to n bytes, fewer at the end of the file only; false with errno set when they cannot be read. */
static bool read_some(int fd, void *bytes, size_t n, size_t *have) {
  for (*have = 0; *have < n;) {
    ssize_t got = read(fd, (unsigned char *)bytes + *have, n - *have);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return false;
    if (got == 0) break;
    *have += (size_t)got;
  }
  return true;
}

sd_status file_read(const char *path, size_t n, unsigned char **bytes, size_t *size, sd_messages *messages) {
  *bytes = NULL;
  *size = 0;
  int fd = open(path, O_RDONLY | O_CLOEXEC);
  if (fd < 0) return fail(messages, "open", path);
  struct stat facts;
  sd_status status = SD_OK;
  if (fstat(fd, &facts) != 0) {
    status = fail(messages, "read", path);
  } else {
    size_t want = (size_t)facts.st_size < n ? (size_t)facts.st_size : n, have = 0;
    unsigned char *buffer = malloc(want ? want : 1);
    if (!buffer)
      status = sd_fail(messages, SD_ERROR_IO, "no memory to read %s", path);
    else if (!read_some(fd, buffer, want, &have))
      status = fail(messages, "read", path);
    if (status == SD_OK) {
      *bytes = buffer;
      *size = have;
    } else {
      free(buffer);
    }
  }
  close(fd);
  return status;
}

sd_status file_sum_of(const char *path, size_t tail, void *end, uint64_t *size, uint64_t *sum,
                      sd_messages *messages) {
  enum { PIECE = 1 << 20 }; /* whole words, so that pieces give the sum of the whole */
  *size = 0;
  *sum = FILE_SUM;
  int fd = open(path, O_RDONLY | O_CLOEXEC);
  if (fd < 0) return fail(messages, "open", path);
  struct stat facts;
  unsigned char *buffer = malloc(PIECE);
  bool good = buffer && fstat(fd, &facts) == 0;
  uint64_t left = good && (uint64_t)facts.st_size >= tail ? (uint64_t)facts.st_size - tail : 0;
  size_t have = 1;
  for (; good && left > 0 && have > 0; left -= have) {
    good = read_some(fd, buffer, left < PIECE ? (size_t)left : PIECE, &have);
    *sum = good ? file_sum(*sum, buffer, have) : 0;
    *size += have;
  }
  if (good && *size > 0) good = read_some(fd, end, tail, &have);
  if (good && have < tail) *size = 0; /* it has become shorter */
  sd_status status = good     ? SD_OK
                     : buffer ? fail(messages, "read", path)
                              : sd_fail(messages, SD_ERROR_IO, "no memory to read %s", path);
  free(buffer);
  close(fd);
  return status;
}

bool file_exists(const char *path) {
  struct stat facts;
  return stat(path, &facts) == 0;
}

bool file_is_folder(const char *path) {
  struct stat facts;
  return stat(path, &facts) == 0 && S_ISDIR(facts.st_mode);
}

uint64_t file_size(const char *path) {
  struct stat facts;
  return stat(path, &facts) == 0 ? (uint64_t)facts.st_size : 0;
}

sd_status file_make_folder(const char *path, sd_messages *messages) {
  if (mkdir(path, 0777) == 0) return file_sync_folder(path, messages);
  if (errno == EEXIST && file_is_folder(path)) return SD_OK;
  int error = errno;
  sd_status status;
  const char *slash = strrchr(path, '/');
  char *above =
      error == ENOENT && slash && slash > path ? file_path("%.*s", (int)(slash - path), path) : NULL;
  if (above && !file_exists(above)) {
    status = sd_fail(messages, SD_ERROR_USER, "there is no folder %s: make it, or name another place", above);
  } else {
    errno = error;
    status = fail(messages, "make folder", path);
  }
  free(above);
  return status;
}

sd_status file_remove(const char *path, sd_messages *messages) {
  if (unlink(path) == 0 || errno == ENOENT) return SD_OK;
  return fail(messages, "remove", path);
}

uint64_t file_sum(uint64_t sum, const void *bytes, size_t n) {
  const unsigned char *b = bytes;
  const uint64_t prime = UINT64_C(1099511628211);
  for (; n >= 8; b += 8, n -= 8) {
    uint64_t word;
    memcpy(&word, b, 8);
    /* the fold brings high bits down: a product alone never lets them reach the low ones */
    sum = (sum ^ word) * prime;
    sum ^= sum >> 32;
  }
  for (; n > 0; b++, n--) sum = (sum ^ *b) * prime;
  return sum;
}
