/* file.c: writes files and folders under temporary names (drafts), which are renamed when they are
 * complete, and reads files; see file.h. */
#include "io/store/file.h"

#include <assert.h>
#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#include "base/memory.h"
#include "base/team.h"
#include "base/text.h"

sd_status file_fail(sd_messages *messages, const char *what, const char *path) {
  return sd_fail(messages, SD_ERROR_IO, "cannot %s %s: %s", what, path, strerror(errno));
}

/* --- System calls that a signal may interrupt ------------------------------------------------- */

static int open_again(int folder, const char *name, int flags, mode_t mode) {
  int fd;
  do fd = openat(folder, name, flags | O_CLOEXEC, mode);
  while (fd < 0 && errno == EINTR);
  return fd;
}

int file_open_at(int folder, const char *name, int flags) {
  return open_again(folder, name, flags, 0666);
}

static bool sync_again(int fd) {
  int result;
  do result = fsync(fd);
  while (result != 0 && errno == EINTR);
  return result == 0;
}

static bool truncate_again(int fd, off_t size) {
  int result;
  do result = ftruncate(fd, size);
  while (result != 0 && errno == EINTR);
  return result == 0;
}

/* Closes a descriptor; returns false, with errno set, if that fails. EINTR is no error, since Linux
 * has closed the descriptor then, too. */
static bool close_told(int fd) { return close(fd) == 0 || errno == EINTR; }

bool file_write_all(int fd, const void *bytes, size_t size) {
  /* one call of write gets at most 1 GiB, since the kernel cuts longer ones short anyway */
  const size_t most = (size_t)1 << 30;
  for (const unsigned char *at = bytes; size > 0;) {
    ssize_t n = write(fd, at, size < most ? size : most);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return false;
    if (n == 0) {
      errno = ENOSPC;
      return false;
    }
    at += n;
    size -= (size_t)n;
  }
  return true;
}

/* --- Names ------------------------------------------------------------------------------------ */

/* Returns the part of a path after its last slash. */
static const char *last_component(const char *path) {
  const char *slash = strrchr(path, '/');
  return slash ? slash + 1 : path;
}

/* Returns the descriptor of the folder relative to which a path is looked up; *name receives the
 * name to look up there. */
static int base_of(int folder, const char *path, const char **name) {
  *name = folder < 0 ? path : last_component(path);
  return folder < 0 ? AT_FDCWD : folder;
}

/* Returns the path of the folder that contains a file; the caller frees it. */
static char *folder_of(const char *path) {
  const char *slash = strrchr(path, '/');
  return !slash          ? format_text(".")
         : slash == path ? format_text("/")
                         : format_text("%.*s", (int)(slash - path), path);
}

bool file_exists(const char *path) {
  struct stat facts;
  return stat(path, &facts) == 0 || (errno != ENOENT && errno != ENOTDIR);
}

bool file_is_folder(const char *path) {
  struct stat facts;
  return stat(path, &facts) == 0 && S_ISDIR(facts.st_mode);
}

char *file_hint(const char *path) {
  char *folder = folder_of(path), *best = NULL;
  const char *slash = strrchr(path, '/'), *name = slash ? slash + 1 : path;
  guess near = guess_start(name);
  DIR *directory = file_exists(path) ? NULL : opendir(folder);
  for (struct dirent *one; directory && (one = readdir(directory));) {
    const char *before = near.best;
    if (one->d_name[0] != '.' && text_printable(one->d_name)) guess_add(&near, one->d_name);
    if (near.best == before) continue;
    free(best);
    near.best = best = memory_text(one->d_name);
  }
  if (directory) closedir(directory);
  char *hint = best ? format_text("; did you mean %.*s%s?", (int)(name - path), path, best)
                    : memory_text("");
  free(best);
  free(folder);
  return hint;
}

bool file_is_link(const char *path) {
  struct stat facts;
  return lstat(path, &facts) == 0 && S_ISLNK(facts.st_mode);
}

static bool is_special(mode_t mode) { return !S_ISREG(mode) && !S_ISLNK(mode) && !S_ISDIR(mode); }

bool file_is_special(const char *path) {
  struct stat facts;
  return lstat(path, &facts) == 0 && is_special(facts.st_mode);
}

uint64_t file_size(const char *path) {
  struct stat facts;
  return stat(path, &facts) == 0 ? (uint64_t)facts.st_size : 0;
}

sd_status file_make_folder(const char *path, sd_messages *messages) {
  if (mkdir(path, 0777) == 0) return file_sync_folder(-1, path, messages);
  if (errno == EEXIST && file_is_folder(path)) return SD_OK;
  int error = errno;
  sd_status status;
  char *above = folder_of(path);
  if (error == ENOENT && !file_exists(above)) {
    status = sd_fail(messages, SD_ERROR_USER,
                     "there is no folder %s: make it, or name another place", above);
  } else {
    errno = error;
    status = file_fail(messages, "make folder", path);
  }
  free(above);
  return status;
}

sd_status file_sync_folder(int folder, const char *path, sd_messages *messages) {
  char *above = folder_of(path);
  int fd = folder < 0 ? file_open_at(AT_FDCWD, above, O_RDONLY | O_DIRECTORY) : folder;
  sd_status status = SD_OK;
  if (fd < 0) status = file_fail(messages, "open folder", above);
  /* EINVAL: the file system cannot synchronise folders; nothing more can be done there */
  else if (!sync_again(fd) && errno != EINVAL && errno != ENOTSUP)
    status = file_fail(messages, "synchronise", above);
  if (folder < 0 && fd >= 0) close(fd);
  free(above);
  return status;
}

void file_remove(int folder, const char *path) {
  const char *name;
  const int base = base_of(folder, path, &name);
  unlinkat(base, name, 0);
}

/* --- Drafts ----------------------------------------------------------------------------------- */

/* Number of hexadecimal digits in the name of a draft (temporary file) */
enum { DRAFT_DIGITS = 16 };
static const char draft_ending[] = ".tmp";

bool file_is_draft(const char *name) { return text_ends(name, draft_ending); }

/* Returns true if a regular file, or a link to one, has this name; *mode then receives its
 * permission bits. A file that replaces it gets these, so that the same users may read it. */
static bool mode_of(int base, const char *name, mode_t *mode) {
  struct stat facts;
  if (fstatat(base, name, &facts, 0) != 0 || !S_ISREG(facts.st_mode)) return false;
  *mode = facts.st_mode & 0777;
  return true;
}

void file_keep_mode(int fd, int folder, const char *path) {
  const char *name;
  struct stat facts;
  mode_t mode;
  const int base = base_of(folder, path, &name);
  if (!mode_of(base, name, &mode) || fstat(fd, &facts) != 0) return;
  /* if the open file is a folder, permission to read it gives permission to enter it */
  if (S_ISDIR(facts.st_mode)) mode |= 0700 | (mode & 0444) >> 2;
  (void)!fchmod(fd, mode); /* errors are ignored, since some file systems have no permission bits */
}

/* Returns a name like "NAME.h5.0123456789abcdef.tmp". Its digits are random, so that no other user
 * can create a file of that name in advance. */
char *file_draft_name(const char *name) {
  uint64_t bits;
  if (getrandom(&bits, sizeof bits, GRND_NONBLOCK) != (ssize_t)sizeof bits) {
    struct timespec t;
    clock_gettime(CLOCK_REALTIME, &t);
    bits = ((uint64_t)t.tv_nsec << 32) ^ (uint64_t)t.tv_sec ^ ((uint64_t)getpid() << 16);
  }
  return format_text("%s.%0*" PRIx64 "%s", name, DRAFT_DIGITS, bits, draft_ending);
}

sd_status file_draft_new(int folder, const char *path, file_draft *out, sd_messages *messages) {
  *out = (file_draft){.folder = -1, .fd = -1};
  char *above = folder_of(path);
  /* a duplicate of the caller's descriptor, so that the draft may outlive that */
  out->folder = folder < 0 ? file_open_at(AT_FDCWD, above, O_RDONLY | O_DIRECTORY)
                           : fcntl(folder, F_DUPFD_CLOEXEC, 0);
  sd_status status = out->folder < 0 ? file_fail(messages, "write to folder", above) : SD_OK;
  const char *last;
  mode_t mode;
  const int base = base_of(folder, path, &last);
  /* a draft that replaces a file must not be readable for other users before it has that file's
   * permission bits */
  const bool replaces = mode_of(base, last, &mode);
  for (int attempt = 0; status == SD_OK && out->fd < 0; attempt++) {
    free(out->name);
    free(out->path);
    out->name = file_draft_name(last_component(path));
    out->path = format_text("%s/%s", above, out->name);
    out->fd = open_again(out->folder, out->name, O_RDWR | O_CREAT | O_EXCL | O_NOFOLLOW,
                         replaces ? 0600 : 0666);
    if (out->fd < 0 && (errno != EEXIST || attempt > 8))
      status = file_fail(messages, "create", out->path);
  }
  if (out->fd >= 0 && replaces) file_keep_mode(out->fd, folder, path);
  free(above);
  return status;
}

/* Closes the descriptors of a draft (temporary file) and frees its name and path. */
static void draft_close(file_draft *draft) {
  if (draft->fd >= 0) close(draft->fd);
  if (draft->folder >= 0) close(draft->folder);
  free(draft->name);
  free(draft->path);
  *draft = (file_draft){.folder = -1, .fd = -1};
}

void file_draft_drop(file_draft *draft) {
  if (draft->fd >= 0) unlinkat(draft->folder, draft->name, 0);
  draft_close(draft);
}

/* Renames a draft to a name that no file may have yet; returns false, with errno set, if that
 * fails. If the file system supports neither RENAME_NOREPLACE nor hard links, the function checks
 * just before it renames that there is no such file. */
static bool rename_new(const file_draft *draft, int base, const char *name) {
  if (renameat2(draft->folder, draft->name, base, name, RENAME_NOREPLACE) == 0) return true;
  if (errno != EINVAL && errno != ENOSYS && errno != ENOTSUP) return false;
  if (linkat(draft->folder, draft->name, base, name, 0) == 0)
    return unlinkat(draft->folder, draft->name, 0) == 0;
  if (errno == EEXIST) return false;
  struct stat facts;
  if (fstatat(base, name, &facts, AT_SYMLINK_NOFOLLOW) == 0) {
    errno = EEXIST;
    return false;
  }
  return errno == ENOENT && renameat(draft->folder, draft->name, base, name) == 0;
}

/* Renames a draft to its final name; returns false, with errno set, if that fails. how: action if a
 * file has this name. */
static bool rename_draft(const file_draft *draft, int base, const char *name, file_replace how) {
  bool good;
  do
    good = how == FILE_KEEP ? rename_new(draft, base, name)
                            : renameat(draft->folder, draft->name, base, name) == 0;
  while (!good && errno == EINTR);
  return good;
}

/* Closes a draft and renames it to its final name. If that fails, removes the draft and returns
 * false, with errno set. */
static bool finish_draft(file_draft *draft, int base, const char *name, file_replace how) {
  int fd = draft->fd;
  draft->fd = -1;
  /* close may be the first call to report a full disk (NFS, quotas) */
  if (close_told(fd) && rename_draft(draft, base, name, how)) return true;
  int error = errno;
  unlinkat(draft->folder, draft->name, 0);
  errno = error;
  return false;
}

sd_status file_draft_publish(file_draft *draft, int folder, const char *path, file_replace how,
                             sd_messages *messages) {
  const char *name;
  assert(draft->fd >= 0 && draft->folder >= 0 && draft->name);
  int base = base_of(folder, path, &name);
  sd_status status = SD_OK;
  struct stat facts;
  if (how == FILE_REPLACE) file_keep_mode(draft->fd, folder, path);
  /* a rename would replace a device or a pipe by a file, and /dev/null is shared by all
   * processes */
  if (fstatat(base, name, &facts, AT_SYMLINK_NOFOLLOW) == 0 && is_special(facts.st_mode))
    status = sd_fail(messages, SD_ERROR_IO, "cannot write %s: it is a device or a pipe", path);
  /* truncating the file to its present size gives back the space that file_reserve took beyond
   * it */
  else if (fstat(draft->fd, &facts) != 0 || !truncate_again(draft->fd, facts.st_size) ||
           !sync_again(draft->fd))
    status = file_fail(messages, "write", path);
  else if (!finish_draft(draft, base, name, how))
    status = how == FILE_KEEP && errno == EEXIST
                 ? sd_fail(messages, SD_ERROR_IO,
                           "%s has appeared meanwhile: it is not overwritten", path)
                 : file_fail(messages, "write", path);
  file_draft_drop(draft);
  return status == SD_OK ? file_sync_folder(folder, path, messages) : status;
}

sd_status file_stream_open(const char *path, file_stream *s, sd_messages *messages) {
  *s = (file_stream){.path = memory_text(path)};
  sd_status status = file_draft_new(-1, path, &s->draft, messages);
  int fd = status == SD_OK ? fcntl(s->draft.fd, F_DUPFD_CLOEXEC, 0) : -1;
  s->out = fd < 0 ? NULL : fdopen(fd, "w");
  if (status == SD_OK && !s->out) status = file_fail(messages, "write", path);
  if (fd >= 0 && !s->out) close(fd);
  if (status != SD_OK) file_draft_drop(&s->draft);
  return status;
}

sd_status file_stream_close(file_stream *s, sd_status status, sd_messages *messages) {
  if (s->out) {
    bool bad = ferror(s->out) != 0;
    bad = fclose(s->out) != 0 || bad;
    if (bad && status == SD_OK) status = file_fail(messages, "write", s->path);
    if (status == SD_OK)
      status = file_draft_publish(&s->draft, -1, s->path, FILE_REPLACE, messages);
    else
      file_draft_drop(&s->draft);
  }
  free(s->path);
  *s = (file_stream){0};
  return status;
}

sd_status file_write_atomic(const char *path, const void *bytes, size_t size,
                            sd_messages *messages) {
  file_stream s;
  const sd_status status = file_stream_open(path, &s, messages);
  if (status == SD_OK) fwrite(bytes, 1, size, s.out);
  return file_stream_close(&s, status, messages);
}

sd_status file_remove_drafts(const char *folder, const char *base, sd_messages *messages) {
  DIR *directory = opendir(folder);
  if (!directory) return file_fail(messages, "read", folder);
  sd_status worst = SD_OK;
  size_t length = strlen(base);
  for (struct dirent *entry; (entry = readdir(directory));) {
    const char *name = entry->d_name;
    if (strncmp(name, base, length) != 0 || name[length] != '.' ||
        strlen(name) != length + 1 + DRAFT_DIGITS + sizeof draft_ending - 1 || !file_is_draft(name))
      continue;
    if (unlinkat(dirfd(directory), name, 0) != 0 && errno != ENOENT)
      worst = file_fail(messages, "remove", name);
  }
  closedir(directory);
  return worst;
}

sd_status file_reserve(int fd, const char *path, uint64_t bytes, sd_messages *messages) {
#ifdef FALLOC_FL_KEEP_SIZE
  int result;
  do result = fallocate(fd, FALLOC_FL_KEEP_SIZE, 0, (off_t)bytes);
  while (result != 0 && errno == EINTR);
  /* if the file system cannot reserve space, later writes report a full disk */
  if (result != 0 && (errno == ENOSPC || errno == EDQUOT || errno == EFBIG))
    return sd_fail(messages, SD_ERROR_IO, "cannot write %s: %.0f MB are needed: %s", path,
                   (double)bytes / 1e6, strerror(errno));
#else
  (void)fd, (void)path, (void)bytes, (void)messages;
#endif
  return SD_OK;
}

/* --- Reading ---------------------------------------------------------------------------------- */

/* Opens a regular file for reading; *size receives its size. Returns -1, with errno set, if that
 * fails. O_NONBLOCK keeps the opening of a pipe from waiting for a writer. */
static int open_regular(int base, const char *name, int flags, uint64_t *size) {
  struct stat facts;
  int fd = file_open_at(base, name, O_RDONLY | O_NONBLOCK | O_NOCTTY | flags);
  if (fd < 0) return -1;
  int error = fstat(fd, &facts) != 0 ? errno : 0;
  if (!error && !S_ISREG(facts.st_mode)) error = S_ISDIR(facts.st_mode) ? EISDIR : ENODEV;
  if (!error) {
    *size = (uint64_t)facts.st_size;
    return fd;
  }
  close(fd);
  errno = error;
  return -1;
}

const char *file_error_text(int error) {
  return error == EISDIR                     ? "it is a folder, not a file"
         : error == ENODEV || error == ENXIO ? "it is a device or a pipe, not a file"
                                             : strerror(error);
}

int file_open_quiet(const char *path, uint64_t *size) {
  return open_regular(AT_FDCWD, path, 0, size);
}

int file_open(int folder, const char *path, sd_messages *messages) {
  const char *name;
  uint64_t size;
  int base = base_of(folder, path, &name),
      fd = open_regular(base, name, folder < 0 ? 0 : O_NOFOLLOW, &size);
  if (fd < 0) sd_fail(messages, SD_ERROR_IO, "cannot open %s: %s", path, file_error_text(errno));
  return fd;
}

/* Recognises a file that is no text by its first n bytes, and returns a description of it with
 * advice, e.g. to unpack it first; NULL: it seems to be a text. */
static const char *kind_of(const char *bytes, size_t n) {
  static const struct {
    const char *head;
    size_t n;
    const char *kind;
  } kinds[] = {{"\x1f\x8b", 2, "it is compressed with gzip; unpack it first (gunzip)"},
               {"\xfd"
                "7zXZ",
                5, "it is compressed with xz; unpack it first (unxz)"},
               {"BZh91AY&SY", 10, "it is compressed with bzip2; unpack it first (bunzip2)"},
               {"\x28\xb5\x2f\xfd", 4, "it is compressed with zstd; unpack it first (unzstd)"},
               {"PK\x03\x04", 4,
                "it is a zip archive or a spreadsheet, not a text; unpack or export it first"},
               {"\xff\xfe", 2, "it is a text in UTF-16; save it as UTF-8"},
               {"\xfe\xff", 2, "it is a text in UTF-16; save it as UTF-8"}};
  for (size_t k = 0; k < sizeof kinds / sizeof *kinds; k++)
    if (n >= kinds[k].n && memcmp(bytes, kinds[k].head, kinds[k].n) == 0) return kinds[k].kind;
  /* HDF5 files may begin with a user block of 512, 1024, ... bytes, as those of MATLAB do */
  for (size_t at = 0; n >= 8 && at <= n - 8; at = at ? 2 * at : 512)
    if (memcmp(bytes + at, "\x89HDF\r\n\x1a\n", 8) == 0) return "it is an HDF5 file, not a text";
  return memchr(bytes, 0, n) ? "not a text file (it holds a zero byte)" : NULL;
}

sd_status file_text(const char *path, uint64_t most, char **text, char trouble[FILE_TROUBLE]) {
  uint64_t size;
  size_t have = 0;
  *text = NULL;
  int fd = file_open_quiet(path, &size);
  if (fd < 0) {
    int error = errno;
    bool mistake =
        error == ENOENT || error == ENOTDIR || error == EISDIR || error == ENODEV || error == ENXIO;
    snprintf(trouble, FILE_TROUBLE, "%s", file_error_text(error));
    return mistake ? SD_ERROR_USER : SD_ERROR_IO;
  }
  sd_status status = SD_ERROR_IO;
  const char *kind;
  char *read = NULL;
  if (size > most) {
    snprintf(trouble, FILE_TROUBLE, "it has %.1f MiB; expected at most %.0f MiB",
             (double)size / 0x1p20, (double)most / 0x1p20);
    status = SD_ERROR_USER;
  } else if (!memory_resize_row(&read, (size_t)size + 1, 1)) {
    snprintf(trouble, FILE_TROUBLE, "no memory");
  } else if (!file_read_at(fd, 0, read, (size_t)size, &have)) {
    snprintf(trouble, FILE_TROUBLE, "%s", strerror(errno));
  } else if ((kind = kind_of(read, have))) {
    snprintf(trouble, FILE_TROUBLE, "%s", kind);
    status = SD_ERROR_USER;
  } else {
    read[have] = 0;
    *text = read;
    status = SD_OK;
  }
  close(fd);
  if (!*text) free(read);
  return status;
}

char *file_reopen_path(int fd, const char *path) {
  char *again = format_text("/proc/self/fd/%d", fd);
  struct stat held, named;
  if (fstat(fd, &held) == 0 && stat(again, &named) == 0 && held.st_ino == named.st_ino &&
      held.st_dev == named.st_dev)
    return again;
  free(again);
  return memory_text(path); /* there is no /proc: use the path */
}

bool file_read_at(int fd, uint64_t at, void *bytes, size_t n, size_t *have) {
  for (*have = 0; *have < n;) {
    ssize_t got = pread(fd, (unsigned char *)bytes + *have, n - *have, (off_t)(at + *have));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return false;
    if (got == 0) break;
    *have += (size_t)got;
  }
  return true;
}

sd_status file_read(const char *path, size_t n, unsigned char **bytes, size_t *size,
                    sd_messages *messages) {
  *bytes = NULL;
  *size = 0;
  int fd = file_open(-1, path, messages);
  if (fd < 0) return SD_ERROR_IO;
  struct stat facts;
  sd_status status = SD_OK;
  if (fstat(fd, &facts) != 0) {
    status = file_fail(messages, "read", path);
  } else {
    size_t want = (size_t)facts.st_size < n ? (size_t)facts.st_size : n, have = 0;
    unsigned char *buffer = NULL;
    if (!memory_resize_row(&buffer, want, 1))
      status = sd_fail(messages, SD_ERROR_IO, "no memory to read %s", path);
    else if (!file_read_at(fd, 0, buffer, want, &have))
      status = file_fail(messages, "read", path);
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

sd_status file_visit(int fd, const char *path, uint64_t from, uint64_t to, file_visitor *take,
                     void *with, sd_messages *messages) {
  enum { PIECE = 1 << 20 }; /* number of bytes read at a time, a multiple of 8 (hash_words) */
  unsigned char *buffer = memory_grow(NULL, 1, PIECE);
  sd_status status = SD_OK;
  for (uint64_t at = from; status == SD_OK && at < to;) {
    size_t want = to - at < PIECE ? (size_t)(to - at) : PIECE, have;
    if (!file_read_at(fd, at, buffer, want, &have))
      status = file_fail(messages, "read", path);
    else if (have < want)
      status = sd_fail(messages, SD_ERROR_IO, "%s has become shorter while it was read", path);
    else if (take)
      take(with, buffer, have);
    at += want;
  }
  free(buffer);
  return status;
}

sd_status file_read_through(const char *path, sd_messages *messages) {
  uint64_t size;
  const int fd = file_open_quiet(path, &size);
  if (fd < 0)
    return sd_fail(messages, SD_ERROR_IO, "cannot read %s: %s", path, file_error_text(errno));
  const sd_status status = file_visit(fd, path, 0, size, NULL, NULL, messages);
  close(fd);
  return status;
}

/* --- Folders that appear complete or not at all ----------------------------------------------- */

sd_status file_folder_open(const char *path, file_folder *f, sd_messages *messages) {
  *f = (file_folder){0};
  size_t length = strlen(path);
  while (length > 1 && path[length - 1] == '/') length--;
  f->path = format_text("%.*s", (int)length, path);
  /* an existing empty folder of this name is replaced by the new one, which gets its permission
   * bits */
  struct stat facts;
  const bool there = stat(f->path, &facts) == 0 && S_ISDIR(facts.st_mode);
  const mode_t mode = there ? facts.st_mode & 0777 : 0777;
  if (file_exists(f->path) && (rmdir(f->path) != 0 || mkdir(f->path, mode) != 0))
    return sd_fail(messages, SD_ERROR_USER, "%s is there already: remove it, or name another",
                   f->path);
  sd_status status = SD_ERROR_IO;
  for (int attempt = 0;; attempt++) {
    f->draft = file_draft_name(f->path);
    if (mkdir(f->draft, mode) == 0) {
      if (there) (void)!chmod(f->draft, mode);
      return SD_OK;
    }
    bool taken = errno == EEXIST && attempt < 8;
    /* this call reports why the folder cannot be made */
    if (!taken) status = file_make_folder(f->draft, messages);
    if (status == SD_OK) return SD_OK;
    free(f->draft);
    f->draft = NULL;
    if (!taken) return status;
  }
}

FILE *file_folder_new(const file_folder *f, const char *name, sd_messages *messages) {
  char *path = format_text("%s/%s", f->draft, name);
  int fd = file_open_at(AT_FDCWD, path, O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW);
  FILE *out = fd < 0 ? NULL : fdopen(fd, "w");
  if (!out) file_fail(messages, "write", path);
  if (fd >= 0 && !out) close(fd);
  free(path);
  return out;
}

sd_status file_folder_end(const file_folder *f, FILE *out, sd_status status,
                          sd_messages *messages) {
  if (!out) return status;
  bool bad = ferror(out) != 0;
  bad = fclose(out) != 0 || bad;
  return bad && status == SD_OK ? file_fail(messages, "write", f->path) : status;
}

/* Writes all files of the file system that holds this folder to disk (syncfs); returns false if
 * that fails. */
static bool sync_all(const char *path) {
  int fd = file_open_at(AT_FDCWD, path, O_RDONLY | O_DIRECTORY);
  bool good = fd >= 0 && syncfs(fd) == 0;
  if (fd >= 0) close(fd);
  return good;
}

/* Removes the temporary folder (draft) of f with the files in it. */
static void remove_draft(const file_folder *f) {
  DIR *directory = opendir(f->draft);
  for (struct dirent *entry; directory && (entry = readdir(directory));)
    if (entry->d_name[0] != '.') unlinkat(dirfd(directory), entry->d_name, 0);
  if (directory) closedir(directory);
  rmdir(f->draft);
}

sd_status file_folder_close(file_folder *f, sd_status status, sd_messages *messages) {
  if (f->draft) {
    if (status == SD_OK && (!sync_all(f->draft) || rename(f->draft, f->path) != 0))
      status = file_fail(messages, "write", f->path);
    if (status == SD_OK)
      status = file_sync_folder(-1, f->path, messages);
    else
      remove_draft(f);
  }
  free(f->path);
  free(f->draft);
  *f = (file_folder){0};
  return status;
}

/* Writing of a file whose contents are in several pieces of memory.
 *
 * Long files bypass the kernel's page cache (O_DIRECT) if the system supports it: copying 1.7 GB
 * into the cache took 3.5 s of processor time, and the disk began to write late. Pieces are
 * gathered in two buffers; while one is being written to disk the other is filled and its checksum
 * computed.
 */

/* BUFFER: bytes of each buffer; PAGE: alignment in bytes that O_DIRECT requires; LONG: size from
 * which on a file is written with O_DIRECT. */
enum { BUFFER = 8 << 20, PAGE = 4096, LONG = 4 * BUFFER };

/* Pieces of memory that are copied into buffers, and the position reached in them. */
typedef struct gathering {
  const file_piece *pieces;
  size_t n, k, at; /* n: number of pieces; k: index of the next piece; at: next byte in it */
} gathering;

/* Fills a buffer from the pieces; returns the number of bytes, less than BUFFER at the end of the
 * last piece. */
static size_t gather(gathering *g, unsigned char *to) {
  size_t have = 0;
  while (g->k < g->n && have < BUFFER) {
    const file_piece *p = &g->pieces[g->k];
    size_t n = p->size - g->at < BUFFER - have ? p->size - g->at : BUFFER - have;
    if (n > 0) memcpy(to + have, (const unsigned char *)p->bytes + g->at, n);
    have += n;
    g->at += n;
    if (g->at < p->size) continue;
    g->k++;
    g->at = 0;
  }
  return have;
}

/* Switches O_DIRECT on or off for an open file; returns false if the system does not support it. */
static bool set_direct(int fd, bool on) {
#ifdef O_DIRECT
  int flags = fcntl(fd, F_GETFL);
  return flags >= 0 && fcntl(fd, F_SETFL, on ? flags | O_DIRECT : flags & ~O_DIRECT) == 0;
#else
  (void)fd;
  return !on;
#endif
}

/* Writes a buffer with O_DIRECT if *direct is true. If that is not possible, switches O_DIRECT off
 * and writes without it, which also gives a meaningful error. Returns 0 or errno. */
static int write_buffer(int fd, const unsigned char *bytes, size_t n, bool *direct) {
  off_t start = lseek(fd, 0, SEEK_CUR);
  if (*direct && n % PAGE == 0 && file_write_all(fd, bytes, n)) return 0;
  if (*direct) {
    *direct = false;
    if (!set_direct(fd, false) || lseek(fd, start, SEEK_SET) != start) return errno;
  }
  return file_write_all(fd, bytes, n) ? 0 : errno;
}

/* Work of two threads in one step of write_long: one buffer is written to disk while the other is
 * filled. */
typedef struct turn {
  int fd, error;
  bool direct;
  gathering *g;
  unsigned char *full, *empty;
  size_t have, next;
  file_digest *digest;
} turn;

/* Task of two threads: the first writes the full buffer to disk, the last fills the empty one and
 * adds its bytes to the checksum. */
static void turn_together(const team *t, void *with) {
  turn *f = with;
  if (t->rank == 0) f->error = write_buffer(f->fd, f->full, f->have, &f->direct);
  if (t->rank != t->size - 1) return;
  f->next = gather(f->g, f->empty);
  file_digest_add(f->digest, f->empty, f->next);
}

/* Writes pieces through two buffers, and adds them to the digest; returns false, with errno set, if
 * that fails. */
static bool write_long(int fd, gathering *g, unsigned char *buffers, file_digest *digest) {
  turn f = {.fd = fd,
            .direct = set_direct(fd, true),
            .g = g,
            .full = buffers,
            .empty = buffers + BUFFER,
            .digest = digest};
  pool *two = pool_new(2);
  f.have = gather(g, f.full);
  file_digest_add(digest, f.full, f.have);
  while (f.have > 0 && f.error == 0) {
    pool_run(two, turn_together, &f);
    unsigned char *full = f.empty;
    f.empty = f.full;
    f.full = full;
    f.have = f.next;
  }
  pool_free(two);
  if (f.direct && !set_direct(fd, false) && f.error == 0) f.error = errno;
  errno = f.error;
  return f.error == 0;
}

bool file_write_pieces(int fd, size_t n, const file_piece *pieces, uint64_t *sum) {
  size_t total = 0;
  for (size_t k = 0; k < n; k++) total += pieces[k].size;
  unsigned char *buffers = total >= LONG ? aligned_alloc(PAGE, 2 * (size_t)BUFFER) : NULL;
  bool good = true;
  file_digest *digest = file_digest_new();
  if (buffers) good = write_long(fd, &(gathering){.pieces = pieces, .n = n}, buffers, digest);
  for (size_t k = 0; !buffers && good && k < n; k++) {
    file_digest_add(digest, pieces[k].bytes, pieces[k].size);
    good = file_write_all(fd, pieces[k].bytes, pieces[k].size);
  }
  int error = errno;
  *sum = file_digest_sum(digest);
  file_digest_free(digest);
  free(buffers);
  errno = error;
  return good;
}
