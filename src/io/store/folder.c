/* folder.c: locks, lists and cleans up the folder NAME.h5.parts with the files of an unfinished
 * run; see folder.h. */
#include "io/store/folder.h"

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

#include "base/memory.h"
#include "base/text.h"
#include "io/store/file.h"

char *folder_part(const char *path, int64_t number) {
  return format_text("%s/part-%06" PRId64 ".h5", path, number);
}

char *folder_checkpoint(const char *path, int64_t step) {
  return format_text("%s/checkpoint-%" PRId64 ".h5", path, step);
}

char *folder_emergency(const char *path, int64_t step) {
  return format_text("%s/emergency-%" PRId64 ".h5", path, step);
}

/* --- Lock ------------------------------------------------------------------------------------- */

static bool is_same(const struct stat *a, const struct stat *b) {
  return a->st_ino == b->st_ino && a->st_dev == b->st_dev;
}

/* Returns true if f->path still leads to the open folder, and the name "lock" in it to the open
 * file `lock`. If it returns false with errno 0, they lead to another folder or another file. */
static bool is_still_there(const folder *f, int lock) {
  struct stat held, named, file, entry;
  errno = 0;
  return fstat(f->at, &held) == 0 && stat(f->path, &named) == 0 && is_same(&held, &named) &&
         fstat(lock, &file) == 0 && fstatat(f->at, "lock", &entry, AT_SYMLINK_NOFOLLOW) == 0 &&
         is_same(&file, &entry);
}

sd_status folder_check(const folder *f, sd_messages *messages) {
  if (is_still_there(f, f->lock)) return SD_OK;
  if (errno != 0 && errno != ENOENT && errno != ENOTDIR)
    return sd_fail(messages, SD_ERROR_IO, "cannot look at %s: %s", f->path, strerror(errno));
  return sd_fail(
      messages, SD_ERROR_IO,
      "%s was removed or replaced while the run went on: nothing is written into what is there now",
      f->path);
}

static sd_status open_folder(folder *f, bool may_be_link, sd_messages *messages) {
  sd_status status = file_make_folder(f->path, messages);
  if (status != SD_OK) return status;
  f->at = file_open_at(AT_FDCWD, f->path, O_RDONLY | O_DIRECTORY | (may_be_link ? 0 : O_NOFOLLOW));
  if (f->at >= 0) return SD_OK;
  if (!may_be_link && file_is_link(f->path))
    return sd_fail(messages, SD_ERROR_USER,
                   "%s is a symbolic link: it has to be a folder of the run's own; remove the "
                   "link, or give the "
                   "result a name in the folder to which it leads",
                   f->path);
  return sd_fail(messages, SD_ERROR_IO, "cannot open folder %s: %s", f->path, strerror(errno));
}

/* Tries once to lock the folder. If it returns SD_OK and f->lock is still < 0, the caller tries
 * again. busy: number of attempts so far at which another process held the lock. */
static sd_status try_lock(folder *f, int *busy, sd_messages *messages) {
  int fd = file_open_at(f->at, "lock", O_RDWR | O_CREAT | O_NOFOLLOW);
  if (fd < 0 && errno == ENOENT) return SD_OK;
  if (fd < 0)
    return sd_fail(messages, SD_ERROR_IO, "cannot create %s/lock: %s", f->path, strerror(errno));
  if (flock(fd, LOCK_EX | LOCK_NB) != 0) {
    int error = errno;
    close(fd);
    if (error == EINTR) return SD_OK;
    if (error != EWOULDBLOCK)
      return sd_fail(messages, SD_ERROR_IO, "cannot lock %s/lock: %s", f->path, strerror(error));
    /* another process may hold the lock only for a moment, in folder_is_locked: try a few times */
    if ((*busy)++ >= 4)
      return sd_fail(messages, SD_ERROR_USER,
                     "another process is writing this result (%s/lock is locked)", f->path);
    nanosleep(&(struct timespec){.tv_nsec = 2000000}, NULL);
    return SD_OK;
  }
  /* if the lock file was removed, with its folder, between open and flock, the lock has no
   * effect */
  if (is_still_there(f, fd))
    f->lock = fd;
  else
    close(fd);
  return SD_OK;
}

sd_status folder_open(const char *path, bool may_be_link, folder *out, sd_messages *messages) {
  *out = (folder){.path = memory_text(path), .at = -1, .lock = -1};
  sd_status status = SD_OK;
  int busy = 0;
  for (int attempt = 0; status == SD_OK && out->lock < 0; attempt++) {
    if (out->at >= 0) close(out->at);
    out->at = -1;
    status = attempt < 100 ? open_folder(out, may_be_link, messages)
                           : sd_fail(messages, SD_ERROR_IO,
                                     "cannot lock %s/lock: it keeps disappearing", path);
    if (status == SD_OK) status = try_lock(out, &busy, messages);
  }
  if (status != SD_OK) folder_close(out);
  return status;
}

bool folder_is_locked(const char *path) {
  char *lock = format_text("%s/lock", path);
  int fd = file_open_at(AT_FDCWD, lock, O_RDONLY | O_NOFOLLOW | O_NONBLOCK);
  bool locked = fd >= 0 && flock(fd, LOCK_SH | LOCK_NB) != 0 && errno == EWOULDBLOCK;
  if (fd >= 0) close(fd);
  free(lock);
  return locked;
}

void folder_close(folder *f) {
  if (f->lock >= 0) close(f->lock);
  if (f->at >= 0) close(f->at);
  free(f->path);
  *f = (folder){.at = -1, .lock = -1};
}

/* --- Contents --------------------------------------------------------------------------------- */

/* Kinds of files in the folder: parts and checkpoints, their files of single ranks (shares),
 * temporary files, other files of slipdisk; FOREIGN: not made by slipdisk. */
typedef enum kind { FOREIGN, PART, PART_SHARE, CHECKPOINT, SHARE, TEMPORARY, OTHER } kind;

/* Returns the kind of a file by its name. *number receives the number of the part, or the step of
 * the checkpoint, in the name; -1: none. */
static kind kind_of(const char *name, int64_t *number) {
  int end = 0;
  *number = -1;
  if (file_is_draft(name)) return TEMPORARY;
  if (sscanf(name, "part-%" SCNd64 ".h5%n", number, &end) == 1 && end > 0 && !name[end])
    return PART;
  if (sscanf(name, "part-%" SCNd64 "-%*u.h5%n", number, &end) == 1 && end > 0 && !name[end])
    return PART_SHARE;
  if (sscanf(name, "checkpoint-%" SCNd64 ".h5%n", number, &end) == 1 && end > 0 && !name[end])
    return CHECKPOINT;
  if (sscanf(name, "checkpoint-%" SCNd64 "-%*u.h5%n", number, &end) == 1 && end > 0 && !name[end])
    return SHARE;
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
  DIR *directory;
  do directory = opendir(path);
  while (!directory && errno == EINTR);
  if (!directory)
    return sd_fail(messages, SD_ERROR_IO, "cannot read %s: %s", path, strerror(errno));
  sd_status status = SD_OK;
  errno = 0;
  for (struct dirent *entry; (entry = readdir(directory)); errno = 0) {
    int64_t number;
    if (kind_of(entry->d_name, &number) != CHECKPOINT) continue;
    *steps = memory_grow(*steps, *n + 1, sizeof **steps);
    (*steps)[(*n)++] = number;
  }
  if (errno != 0)
    status = sd_fail(messages, SD_ERROR_IO, "cannot read %s: %s", path, strerror(errno));
  closedir(directory);
  if (*n > 0) qsort(*steps, *n, sizeof **steps, newest_first);
  return status;
}

sd_status folder_read_through(const char *path, sd_messages *messages) {
  DIR *directory = opendir(path);
  if (!directory) return file_fail(messages, "read", path);
  sd_status status = SD_OK;
  for (struct dirent *entry; status == SD_OK && (entry = readdir(directory));) {
    int64_t number;
    const kind what = kind_of(entry->d_name, &number);
    if (what == FOREIGN || what == TEMPORARY) continue;
    char *file = format_text("%s/%s", path, entry->d_name);
    status = file_read_through(file, messages);
    free(file);
  }
  closedir(directory);
  return status;
}

/* A function that returns true if a file of this kind, with this number in its name, is to be
 * removed. limit: as given to remove_some. */
typedef bool chooser(kind what, int64_t number, int64_t limit);

/* Removes those files of slipdisk in the folder for which doomed(kind, number in the name, limit)
 * returns true. */
static sd_status remove_some(const folder *f, chooser *doomed, int64_t limit,
                             sd_messages *messages) {
  sd_status worst = folder_check(f, messages);
  if (worst != SD_OK) return worst;
  /* opened through the descriptor f->at, since f->path may lead to another folder by now */
  int fd = file_open_at(f->at, ".", O_RDONLY | O_DIRECTORY);
  DIR *directory = fd < 0 ? NULL : fdopendir(fd);
  if (!directory) {
    worst = sd_fail(messages, SD_ERROR_IO, "cannot read %s: %s", f->path, strerror(errno));
    if (fd >= 0) close(fd);
    return worst;
  }
  errno = 0;
  for (struct dirent *entry; (entry = readdir(directory)); errno = 0) {
    int64_t number;
    kind what = kind_of(entry->d_name, &number);
    if (what == FOREIGN || !doomed(what, number, limit)) continue;
    if (unlinkat(f->at, entry->d_name, 0) != 0 && errno != ENOENT)
      worst = sd_fail(messages, SD_ERROR_IO, "cannot remove %s/%s: %s", f->path, entry->d_name,
                      strerror(errno));
  }
  if (errno != 0)
    worst = sd_fail(messages, SD_ERROR_IO, "cannot read %s: %s", f->path, strerror(errno));
  closedir(directory);
  return worst;
}

static bool is_stale(kind what, int64_t number, int64_t parts) {
  return what == TEMPORARY || ((what == PART || what == PART_SHARE) && number > parts);
}

static bool is_older(kind what, int64_t number, int64_t oldest) {
  return (what == CHECKPOINT || what == SHARE) && number < oldest;
}

/* Returns true for files of single ranks (shares) of a checkpoint that is newer than the newest
 * complete one: it was never finished, or was set aside as damaged. */
static bool is_newer_share(kind what, int64_t number, int64_t newest) {
  return what == SHARE && number > newest;
}

static bool is_ours(kind what, int64_t number, int64_t limit) {
  (void)number, (void)limit;
  return what != FOREIGN;
}

sd_status folder_clean(const folder *f, int64_t parts, sd_messages *messages) {
  int64_t *steps;
  size_t n;
  sd_status status = remove_some(f, is_stale, parts, messages);
  if (status != SD_OK) return status;
  status = folder_checkpoints(f->path, &steps, &n, messages);
  if (status == SD_OK) status = remove_some(f, is_newer_share, n > 0 ? steps[0] : -1, messages);
  free(steps);
  return status;
}

sd_status folder_prune(const folder *f, size_t keep, sd_messages *messages) {
  int64_t *steps;
  size_t n;
  sd_status status = folder_check(f, messages);
  if (status != SD_OK) return status;
  status = folder_checkpoints(f->path, &steps, &n, messages);
  if (status == SD_OK && n > keep) status = remove_some(f, is_older, steps[keep - 1], messages);
  free(steps);
  return status;
}

sd_status folder_empty(const folder *f, sd_messages *messages) {
  return remove_some(f, is_ours, 0, messages);
}

void folder_set_aside(const folder *f, int64_t step) {
  char from[64], to[80];
  snprintf(from, sizeof from, "checkpoint-%" PRId64 ".h5", step);
  snprintf(to, sizeof to, "damaged-%s", from);
  /* if renaming fails, the checkpoint is found damaged again next time */
  if (folder_check(f, NULL) == SD_OK) (void)!renameat(f->at, from, f->at, to);
}

sd_status folder_remove(folder *f, sd_messages *messages) {
  /* The lock file is removed last and stays locked until then, so that a process that waits for it
   * starts over. */
  sd_status status = remove_some(f, is_ours, 0, messages);
  if (status == SD_OK && unlinkat(f->at, "lock", 0) != 0)
    status = sd_fail(messages, SD_ERROR_IO, "cannot remove %s/lock: %s", f->path, strerror(errno));
  if (status == SD_OK && rmdir(f->path) != 0)
    sd_warn(messages, "%s is not removed: %s", f->path, strerror(errno));
  folder_close(f);
  return status;
}
