/* folder.c: see folder.h. */
#ifndef _GNU_SOURCE
#define _GNU_SOURCE /* flock */
#endif
#include "io/folder.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#include "io/file.h"

char *folder_part(const char *path, int64_t number) {
  return file_path("%s/part-%06" PRId64 ".h5", path, number);
}

char *folder_checkpoint(const char *path, int64_t step) {
  return file_path("%s/checkpoint-%" PRId64 ".h5", path, step);
}

char *folder_emergency(const char *path, int64_t step) {
  return file_path("%s/emergency-%" PRId64 ".h5", path, step);
}

/* --- lock ----------------------------------------------------------------------------------------- */

/* The lock file may have been removed, with the folder, between open and flock: then what is held is
 * nothing, and the caller tries again. */
static bool is_still_there(int fd, const char *path) {
  struct stat held, named;
  return fstat(fd, &held) == 0 && stat(path, &named) == 0 && held.st_ino == named.st_ino &&
         held.st_dev == named.st_dev;
}

static sd_status take_lock(folder *f, const char *lock, sd_messages *messages) {
  int busy = 0;
  for (int attempt = 0; attempt < 100; attempt++) {
    sd_status status = file_make_folder(f->path, messages);
    if (status != SD_OK) return status;
    int fd = open(lock, O_RDWR | O_CREAT | O_CLOEXEC, 0666);
    if (fd < 0 && errno == ENOENT) continue;
    if (fd < 0) return sd_fail(messages, SD_ERROR_IO, "cannot create %s: %s", lock, strerror(errno));
    if (flock(fd, LOCK_EX | LOCK_NB) != 0) {
      int error = errno;
      close(fd);
      /* whoever only looks whether it is locked (folder_is_locked) holds it for a moment */
      if (error == EWOULDBLOCK && busy++ < 4) {
        nanosleep(&(struct timespec){.tv_nsec = 2000000}, NULL);
        continue;
      }
      if (error == EWOULDBLOCK)
        return sd_fail(messages, SD_ERROR_USER, "another process is writing this result (%s is locked)",
                       lock);
      return sd_fail(messages, SD_ERROR_IO, "cannot lock %s: %s", lock, strerror(error));
    }
    if (is_still_there(fd, lock)) {
      f->lock = fd;
      return SD_OK;
    }
    close(fd);
  }
  return sd_fail(messages, SD_ERROR_IO, "cannot lock %s: it keeps disappearing", lock);
}

sd_status folder_open(const char *path, folder *out, sd_messages *messages) {
  *out = (folder){.path = file_path("%s", path), .lock = -1};
  char *lock = file_path("%s/lock", path);
  sd_status status = out->path && lock ? take_lock(out, lock, messages)
                                       : sd_fail(messages, SD_ERROR_IO, "no memory to open %s", path);
  free(lock);
  if (status != SD_OK) folder_close(out);
  return status;
}

bool folder_is_locked(const char *path) {
  char *lock = file_path("%s/lock", path);
  int fd = lock ? open(lock, O_RDONLY | O_CLOEXEC) : -1;
  bool locked = fd >= 0 && flock(fd, LOCK_SH | LOCK_NB) != 0 && errno == EWOULDBLOCK;
  if (fd >= 0) close(fd);
  free(lock);
  return locked;
}

void folder_close(folder *f) {
  if (f->lock >= 0) close(f->lock);
  free(f->path);
  *f = (folder){.lock = -1};
}

/* --- contents ------------------------------------------------------------------------------------- */

/* Does the name belong to slipdisk? The number in it, or -1, goes to *number. */
typedef enum kind { FOREIGN, PART, CHECKPOINT, TEMPORARY, OTHER } kind;

static kind kind_of(const char *name, int64_t *number) {
  int end = 0;
  size_t length = strlen(name);
  *number = -1;
  if (length > 4 && strcmp(name + length - 4, ".tmp") == 0) return TEMPORARY;
  if (sscanf(name, "part-%" SCNd64 ".h5%n", number, &end) == 1 && end > 0 && !name[end]) return PART;
  if (sscanf(name, "checkpoint-%" SCNd64 ".h5%n", number, &end) == 1 && end > 0 && !name[end])
    return CHECKPOINT;
  if (strncmp(name, "emergency-", 10) == 0 || strncmp(name, "damaged-", 8) == 0) return OTHER;
  return FOREIGN;
}

static int newest_first(const void *a, const void *b) {
  int64_t x = *(const int64_t *)a, y = *(const int64_t *)b;
  return x < y ? 1 : x > y ? -1 : 0;
}

sd_status folder_checkpoints(const char *path, int64_t **steps, size_t *n, sd_messages *messages) {
  *steps = NULL;
  *n = 0;
  DIR *directory = opendir(path);
  if (!directory) return sd_fail(messages, SD_ERROR_IO, "cannot read %s: %s", path, strerror(errno));
  sd_status status = SD_OK;
  for (struct dirent *entry; (entry = readdir(directory));) {
    int64_t number;
    if (kind_of(entry->d_name, &number) != CHECKPOINT) continue;
    int64_t *longer = realloc(*steps, (*n + 1) * sizeof *longer);
    if (!longer) {
      status = sd_fail(messages, SD_ERROR_IO, "no memory to read %s", path);
      break;
    }
    *steps = longer;
    longer[(*n)++] = number;
  }
  closedir(directory);
  if (*n > 0) qsort(*steps, *n, sizeof **steps, newest_first);
  return status;
}

/* Removes the files for which doomed says so. */
typedef bool chooser(kind what, int64_t number, int64_t limit);

static sd_status remove_some(const folder *f, chooser *doomed, int64_t limit, sd_messages *messages) {
  DIR *directory = opendir(f->path);
  if (!directory) return sd_fail(messages, SD_ERROR_IO, "cannot read %s: %s", f->path, strerror(errno));
  sd_status worst = SD_OK;
  for (struct dirent *entry; (entry = readdir(directory));) {
    int64_t number;
    kind what = kind_of(entry->d_name, &number);
    if (what == FOREIGN || !doomed(what, number, limit)) continue;
    char *path = file_path("%s/%s", f->path, entry->d_name);
    sd_status status = path ? file_remove(path, messages) : SD_ERROR_IO;
    if (status != SD_OK) worst = status;
    free(path);
  }
  closedir(directory);
  return worst;
}

static bool is_stale(kind what, int64_t number, int64_t parts) {
  return what == TEMPORARY || (what == PART && number > parts);
}

static bool is_older(kind what, int64_t number, int64_t oldest) {
  return what == CHECKPOINT && number < oldest;
}

static bool is_ours(kind what, int64_t number, int64_t limit) {
  (void)number, (void)limit;
  return what != FOREIGN;
}

sd_status folder_clean(const folder *f, int64_t parts, sd_messages *messages) {
  return remove_some(f, is_stale, parts, messages);
}

sd_status folder_prune(const folder *f, size_t keep, sd_messages *messages) {
  int64_t *steps;
  size_t n;
  sd_status status = folder_checkpoints(f->path, &steps, &n, messages);
  if (status == SD_OK && n > keep) status = remove_some(f, is_older, steps[keep - 1], messages);
  free(steps);
  return status;
}

sd_status folder_empty(const folder *f, sd_messages *messages) {
  return remove_some(f, is_ours, 0, messages);
}

void folder_set_aside(const folder *f, int64_t step) {
  char *from = folder_checkpoint(f->path, step);
  char *to = file_path("%s/damaged-checkpoint-%" PRId64 ".h5", f->path, step);
  /* best effort: when it cannot be moved it is found damaged again next time */
  if (from && to) (void)!rename(from, to);
  free(from);
  free(to);
}

sd_status folder_remove(folder *f, sd_messages *messages) {
  /* The lock goes last, and is held until its name is gone: whoever waits for it starts over. */
  sd_status status = remove_some(f, is_ours, 0, messages);
  char *lock = file_path("%s/lock", f->path);
  if (status == SD_OK && lock) status = file_remove(lock, messages);
  if (status == SD_OK && rmdir(f->path) != 0)
    sd_warn(messages, "%s is not removed: %s", f->path, strerror(errno));
  free(lock);
  folder_close(f);
  return status;
}
